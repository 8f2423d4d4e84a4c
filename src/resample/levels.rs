//! What a place shows in a mip chain: in a level of it and the next one.
//!
//! `trilinear` goes by the footprint's longer side and looks levels up bilinearly: it never aliases, and blurs where a footprint
//! is long. `ewa` goes by the shorter axis of the ellipse that the footprint stands for, and averages over it
//! (`sample::ellipse`); the longer axis is at most [`LONGEST`] times the shorter one.

use crate::resample::filters::MipmappedFilter;
use crate::resample::footprint::Footprint;
use crate::resample::lod::Between;
use crate::resample::sample::{ByPlace, Level};

/// The most that an ellipse is longer than wide; longer ones are made wider.
const LONGEST: f64 = 16.0;

/// How many texels of the image lookups lie apart whose memory is nearly the same.
const NEAR: f64 = 4.0;

/// An image and its smaller versions, to be looked up.
pub(crate) struct Levels<'a, L: ?Sized> {
    /// For each how many of its texels, along u and v, a texel of the image is.
    levels: Vec<(&'a L, [f64; 2])>,
    /// The longer side of the image, in texels.
    most: f64,
}

impl<'a, L: Level + ?Sized> Levels<'a, L> {
    /// Of an image as large as this, each level half as wide and high as the one before.
    pub(crate) fn halved(
        [width, height]: [usize; 2],
        levels: impl IntoIterator<Item = &'a L>,
    ) -> Self {
        let scale = |k: usize| [0.5_f64.powi(k as i32); 2];
        let levels = levels.into_iter().enumerate();
        Levels {
            levels: levels.map(|(k, level)| (level, scale(k))).collect(),
            most: width.max(height) as f64,
        }
    }

    /// Of an image as large as the first of these, each with its size.
    pub(crate) fn sized(levels: Vec<(&'a L, [usize; 2])>) -> Self {
        let [width, height] = levels.first().map_or([1, 1], |(_, size)| *size);
        let scale = |[w, h]: [usize; 2]| [w as f64 / width as f64, h as f64 / height as f64];
        let levels = levels.into_iter();
        Levels {
            levels: levels.map(|(level, size)| (level, scale(size))).collect(),
            most: width.max(height) as f64,
        }
    }

    /// One of them.
    pub(crate) fn level(&self, number: usize) -> &'a L {
        self.levels[number].0
    }

    /// How many there are.
    pub(crate) fn count(&self) -> usize {
        self.levels.len()
    }

    /// Where a footprint is looked up. `rule` says which levels a length lies between.
    pub(crate) fn aim(
        &self,
        filter: MipmappedFilter,
        footprint: &Footprint,
        rule: impl Fn(f64, usize) -> Between,
    ) -> Aim {
        let (length, sides) = match filter {
            MipmappedFilter::Trilinear => {
                let [right, down] = footprint.lengths();
                (right.max(down), None)
            }
            MipmappedFilter::Ewa => {
                let sides = rounded(footprint, self.most);
                (axes(sides).1, Some(sides))
            }
        };
        Aim {
            sides,
            ..Aim::at(footprint.source, rule(length, self.count()))
        }
    }

    /// Whether two lookups read nearly the same memory.
    pub(crate) fn near(&self, one: &Aim, other: &Aim) -> bool {
        let ([u, v, face], [x, y, other]) = (one.place, other.place);
        face == other && ((u - x).abs() + (v - y).abs()) * self.most < NEAR
    }

    /// Asks for the memory of what a lookup will read.
    pub(crate) fn ask(&self, aim: &Aim) {
        let [u, v, face] = aim.place;
        for (level, [_, along]) in self.pair(aim.between) {
            let rows = aim
                .sides
                .map_or(0.0, |[a, b]| along * a[1].abs().max(b[1].abs()));
            level.ask(face as usize, [u, v], rows);
        }
    }

    /// Writes the average over a footprint's ellipse into the first half of `values`.
    #[inline(always)]
    pub(crate) fn average(&self, aim: &Aim, values: &mut [f64]) {
        let [u, v, face] = aim.place;
        self.mix(aim.between, values, |level, [across, along], out| {
            let sides = aim.sides.unwrap_or_default();
            let sides = sides.map(|[x, y]| [x * across, y * along]);
            level.ellipse(face as usize, [u, v], sides, out);
        });
    }

    /// Writes a mix of what `look` writes of two levels into the first half of `values`.
    #[inline(always)]
    fn mix(&self, between: Between, values: &mut [f64], look: impl Fn(&L, [f64; 2], &mut [f64])) {
        let (near, far) = values.split_at_mut(values.len() / 2);
        if let [(level, scale), others @ ..] = self.pair(between) {
            look(level, *scale, near);
            if let [(level, scale)] = others {
                look(level, *scale, far);
                for (near, far) in near.iter_mut().zip(far) {
                    *near += between.share * (*far - *near);
                }
            }
        }
    }

    /// The levels between which a lookup lies: two, or one where there is nothing to mix.
    fn pair(&self, Between { level, share }: Between) -> &[(&'a L, [f64; 2])] {
        let count = if share > 0.0 { 2 } else { 1 };
        &self.levels[level..self.count().min(level + count)]
    }
}

impl<L: ByPlace + ?Sized> Levels<'_, L> {
    /// Writes what a lookup shows into the first half of `values`.
    #[inline(always)]
    pub(crate) fn look(&self, aim: &Aim, values: &mut [f64]) {
        let [u, v, face] = aim.place;
        if aim.sides.is_some() {
            return self.average(aim, values);
        }
        self.mix(aim.between, values, |level, _, out| {
            level.bilinear(face as usize, [u, v], out);
        });
    }
}

/// Where a lookup goes.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Aim {
    /// u, v and face.
    place: [f64; 3],
    between: Between,
    /// The sides of the footprint, in texels of the image, where it is averaged over.
    sides: Option<[[f64; 2]; 2]>,
}

impl Aim {
    /// Its place, and between which levels it lies.
    pub(crate) fn ends(&self) -> ([f64; 3], Between) {
        (self.place, self.between)
    }

    /// A bilinear one between two levels.
    pub(crate) fn at(place: [f64; 3], between: Between) -> Aim {
        Aim {
            place,
            between,
            sides: None,
        }
    }
}

/// The longer and the shorter radius of the ellipse with these conjugate radii.
fn axes([[ax, ay], [bx, by]]: [[f64; 2]; 2]) -> (f64, f64) {
    let (xx, yy, xy) = (ax * ax + bx * bx, ay * ay + by * by, ax * ay + bx * by);
    let (middle, half) = (0.5 * (xx + yy), 0.5 * (xx - yy));
    let root = (half * half + xy * xy).sqrt();
    let longer = middle + root;
    let area = ax * by - ay * bx;
    // The product of both is the area: no difference of nearly equal numbers.
    (
        longer.sqrt(),
        if longer > 0.0 {
            area.abs() / longer.sqrt()
        } else {
            0.0
        },
    )
}

/// The footprint's sides, none longer than the source, made wide enough that the ellipse is not too long.
fn rounded(footprint: &Footprint, most: f64) -> [[f64; 2]; 2] {
    // At a singular place they are infinite or no numbers.
    let finite = |x: f64| if x.abs() <= 1e9 { x } else { 1e9 };
    let mut sides = footprint.sides.map(|side| side.map(finite));
    let (longer, shorter) = axes(sides);
    if longer > most {
        sides = sides.map(|side| side.map(|x| x * (most / longer)));
    }
    let (longer, shorter) = (longer.min(most), shorter * (most / longer).min(1.0));
    let wanted = longer / LONGEST;
    if shorter >= wanted || longer <= 1.0 {
        return sides;
    }
    // The ellipse's own axes, the shorter one stretched.
    let [[ax, ay], [bx, by]] = sides;
    let (xx, yy, xy) = (ax * ax + bx * bx, ay * ay + by * by, ax * ay + bx * by);
    let (x, y) = if xx >= yy {
        (longer * longer - yy, xy)
    } else {
        (xy, longer * longer - xx)
    };
    let norm = (x * x + y * y).sqrt();
    let (x, y) = if norm > 0.0 {
        (x / norm, y / norm)
    } else {
        (1.0, 0.0)
    };
    [[longer * x, longer * y], [-wanted * y, wanted * x]]
}
