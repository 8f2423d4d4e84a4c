//! A picture, as lookups need it.

use super::address::Address;
use crate::image::texel::Texel;
use crate::kernel::Scalar;
use crate::resample::filters::LookupFilter;
use crate::resample::filters::claims::{Kernel, Visitor};
use crate::resample::sample::{ByPlace, Level, ellipse};

/// A picture that can be looked up: it knows what lies beyond its edges.
#[derive(Clone, Copy)]
pub(crate) struct Picture<'a, T> {
    pub(crate) size: [usize; 2],
    pub(crate) channels: usize,
    pub(crate) texels: &'a [T],
    pub(crate) address: [Address; 2],
    /// The color of the border.
    pub(crate) border: &'a [f64],
}

/// A texel by its index, or the border.
type Tap = Option<usize>;

impl<T: Texel> Picture<'_, T> {
    /// The texel at an index along each side that may lie beyond an edge.
    fn tap(&self, i: isize, j: isize) -> Tap {
        let [width, height] = self.size;
        let i = self.address[0].texel(i, width)?;
        let j = self.address[1].texel(j, height)?;
        Some(j * width + i)
    }

    fn value(&self, tap: Tap, c: usize) -> f64 {
        match tap {
            Some(index) => self.texels[index * self.channels + c].load().to_f64(),
            None => self.border[c],
        }
    }

    /// A place in texels: 0 at the first center. Where numbers have no fractions any more, places mean nothing.
    fn place(&self, [u, v]: [f64; 2]) -> [f64; 2] {
        let [width, height] = self.size;
        let most = 1e15;
        [u * width as f64 - 0.5, v * height as f64 - 0.5].map(|x| x.clamp(-most, most))
    }

    /// Writes what a filter shows at a place.
    pub(crate) fn look(&self, filter: LookupFilter, uv: [f64; 2], out: &mut [f64]) {
        filter.visit(Look(self, uv, out));
    }
}

/// The mean of texels that are added, each with a weight.
struct Mean<'p, 'a, 'o, T> {
    picture: &'p Picture<'a, T>,
    /// What the others differ from, so that a constant stays constant to the bit.
    base: Option<Tap>,
    weights: f64,
    sums: &'o mut [f64],
}

impl<'p, 'a, 'o, T: Texel> Mean<'p, 'a, 'o, T> {
    fn new(picture: &'p Picture<'a, T>, sums: &'o mut [f64]) -> Self {
        sums.fill(0.0);
        Mean {
            picture,
            base: None,
            weights: 0.0,
            sums,
        }
    }

    fn add(&mut self, i: isize, j: isize, weight: f64) {
        // What has no weight need not be finite.
        if weight == 0.0 {
            return;
        }
        let tap = self.picture.tap(i, j);
        let base = *self.base.get_or_insert(tap);
        self.weights += weight;
        if tap == base {
            return;
        }
        for (c, sum) in self.sums.iter_mut().enumerate() {
            *sum += weight * (self.picture.value(tap, c) - self.picture.value(base, c));
        }
    }

    /// Adds TAPS × TAPS texels around a place, by their weights along each side.
    fn window<const TAPS: usize>(&mut self, uv: [f64; 2], weights: impl Fn(f64) -> [f64; TAPS]) {
        let [x, y] = self.picture.place(uv);
        let (left, top) = (x.floor(), y.floor());
        let (across, down) = (weights(x - left), weights(y - top));
        let before = TAPS as isize / 2 - 1;
        for (r, down) in (0..).zip(down) {
            for (t, across) in (0..).zip(across) {
                let (i, j) = (left as isize + t - before, top as isize + r - before);
                self.add(i, j, across * down);
            }
        }
    }

    fn finish(self) {
        let base = self.base.unwrap_or(None);
        for (c, sum) in self.sums.iter_mut().enumerate() {
            *sum = self.picture.value(base, c) + *sum / self.weights;
        }
    }
}

impl<T: Texel> ByPlace for Picture<'_, T> {
    fn bilinear(&self, _: usize, uv: [f64; 2], out: &mut [f64]) {
        let mut mean = Mean::new(self, out);
        mean.window(uv, |t| [1.0 - t, t]);
        mean.finish();
    }
}

impl<T: Texel> Level for Picture<'_, T> {
    fn ellipse(&self, _: usize, uv: [f64; 2], sides: [[f64; 2]; 2], out: &mut [f64]) {
        let mut mean = Mean::new(self, out);
        ellipse::each(self.place(uv), sides, |i, j, weight| mean.add(i, j, weight));
        mean.finish();
    }
}

/// Looks a place up.
struct Look<'p, 'a, 'o, T>(&'p Picture<'a, T>, [f64; 2], &'o mut [f64]);

impl<T: Texel> Visitor for Look<'_, '_, '_, T> {
    type Output = ();
    fn nearest(self) {
        let [x, y] = self.0.place(self.1);
        let mut mean = Mean::new(self.0, self.2);
        mean.add((x + 0.5).floor() as isize, (y + 0.5).floor() as isize, 1.0);
        mean.finish();
    }
    fn bilinear(self) {
        ByPlace::bilinear(self.0, 0, self.1, self.2);
    }
    fn separable<K: Kernel<TAPS>, const TAPS: usize>(self) {
        let mut mean = Mean::new(self.0, self.2);
        mean.window(self.1, K::weights);
        mean.finish();
    }
}
