//! What becomes of the values that a texel covers, added cell by cell.

use crate::image::texel::Texel;
use crate::image::view::ImageView;
use crate::kernel::Scalar;
use crate::number::real::Real;
use crate::resample::filters::AreaFilter;

/// A weighted mean on its way.
#[derive(Clone, Copy)]
pub(super) struct Sum {
    sum: f64,
    weight: f64,
    least: f64,
    most: f64,
}

impl Sum {
    pub const NONE: Sum = Sum {
        sum: 0.0,
        weight: 0.0,
        least: f64::INFINITY,
        most: f64::NEG_INFINITY,
    };

    #[inline(always)]
    pub fn add(&mut self, value: f64, weight: f64) {
        self.sum += weight * value;
        self.weight += weight;
        self.least = self.least.min(value);
        self.most = self.most.max(value);
    }

    /// Adds what is in another one.
    #[inline(always)]
    pub fn merge(&mut self, other: &Sum, weight: f64) {
        self.sum += weight * other.sum;
        self.weight += weight * other.weight;
        self.least = self.least.min(other.least);
        self.most = self.most.max(other.most);
    }

    /// The mean, within the values; NaN of none.
    pub fn mean(&self) -> f64 {
        let mean = self.sum / self.weight;
        if mean < self.least {
            self.least
        } else if mean > self.most {
            self.most
        } else {
            mean
        }
    }
}

/// Whether a sum of what is weighed, over that of the weights, is the mean. Rounding takes means of equal numbers beyond them
/// by parts in 1e16, which only f64 has.
pub(super) fn is_plain<T: Texel>(skipna: bool) -> bool {
    !skipna && size_of::<T>() < 8
}

/// What is made of what a texel covers.
#[derive(Clone, Copy)]
pub(super) struct Of {
    pub filter: AreaFilter,
    /// Whether what is not finite has no weight.
    pub skipna: bool,
    /// Whether a mean is over the whole texel, black where it covers nothing.
    pub whole: bool,
}

/// A texel that is covered but for so much of it is covered: 5e-7 of it may be missing.
const ALL: f64 = 1.0 - 1e-6;

/// The texels of a block of the target.
pub(super) struct Tallies<'a, T> {
    image: &'a ImageView<'a, T>,
    of: Of,
    channels: usize,
    /// Whether a texel covers anything.
    covers: Vec<bool>,
    /// For means: each texel's channels.
    sums: Vec<Sum>,
    /// For plain means, instead of them: the source's numbers, Σ w·L of each texel's channels, and Σ w.
    numbers: Option<&'a [T]>,
    plain: Vec<f64>,
    weights: Vec<f64>,
    /// For modes: each texel's source texels and how much of each.
    lists: Vec<Vec<(usize, f64)>>,
    values: Vec<(f64, f64)>,
}

impl<'a, T: Texel> Tallies<'a, T> {
    pub fn new(image: &'a ImageView<'a, T>, of: Of, texels: usize) -> Self {
        let Of { filter, skipna, .. } = of;
        let channels = image.channels();
        let plain = filter == AreaFilter::Area && is_plain::<T>(skipna);
        let numbers = plain.then(|| image.texels());
        let (plain, sums, lists) = match filter {
            AreaFilter::Area if numbers.is_some() => (texels, 0, 0),
            AreaFilter::Area => (0, texels * channels, 0),
            AreaFilter::Mode => (0, 0, texels),
        };
        Tallies {
            image,
            of,
            channels,
            covers: vec![false; texels],
            sums: vec![Sum::NONE; sums],
            numbers,
            plain: vec![0.0; plain * channels],
            weights: vec![0.0; plain],
            lists: vec![Vec::new(); lists],
            values: Vec::new(),
        }
    }

    pub fn clear(&mut self) {
        self.covers.fill(false);
        self.sums.fill(Sum::NONE);
        self.plain.fill(0.0);
        self.weights.fill(0.0);
        self.lists.iter_mut().for_each(Vec::clear);
    }

    /// Adds source texels to what texel `number` covers.
    #[inline(always)]
    pub fn add(&mut self, number: usize, weights: &[(usize, f64)]) {
        self.covers[number] |= !weights.is_empty();
        if self.of.filter == AreaFilter::Mode {
            return self.lists[number].extend_from_slice(weights);
        }
        if let Some(texels) = self.numbers {
            self.weights[number] += weights.iter().map(|(_, weight)| weight).sum::<f64>();
            let sums = &mut self.plain[number * self.channels..][..self.channels];
            return match self.channels {
                1 => add_plain::<T, 1>(texels, weights, sums),
                3 => add_plain::<T, 3>(texels, weights, sums),
                4 => add_plain::<T, 4>(texels, weights, sums),
                n => weights.iter().for_each(|&(index, weight)| {
                    let texel = &texels[index * n..][..n];
                    for (sum, value) in sums.iter_mut().zip(texel) {
                        *sum += weight * value.load().to_f64();
                    }
                }),
            };
        }
        let sums = &mut self.sums[number * self.channels..][..self.channels];
        let skipna = self.of.skipna;
        for &(index, weight) in weights {
            let texel = self.image.texel(index);
            for (sum, texel) in sums.iter_mut().zip(texel) {
                let value = texel.load().to_f64();
                if !skipna || value.is_finite() {
                    sum.add(value, weight);
                }
            }
        }
    }

    /// Writes texel `number`; a mean is over at least so much.
    pub fn store(&mut self, number: usize, least: f64, fill: &[T], out: &mut [T]) {
        if !self.covers[number] {
            return out.copy_from_slice(fill);
        }
        for (channel, out) in out.iter_mut().enumerate() {
            let place = number * self.channels + channel;
            let weight = match &self.numbers {
                Some(_) => self.weights[number],
                None => self.sums.get(place).map_or(f64::INFINITY, |sum| sum.weight),
            };
            let part = weight / least;
            let part = if part < ALL { part } else { 1.0 };
            let value = match self.of.filter {
                AreaFilter::Area if self.numbers.is_some() => part * self.plain[place] / weight,
                AreaFilter::Area => part * self.sums[place].mean(),
                AreaFilter::Mode => {
                    self.values.clear();
                    for &(index, weight) in &self.lists[number] {
                        let value = self.image.texel(index)[channel].load().to_f64();
                        if !self.of.skipna || value.is_finite() {
                            self.values.push((value, weight));
                        }
                    }
                    mode(&mut self.values)
                }
            };
            *out = T::store(<T::Float as Real>::new(value));
        }
    }
}

/// Adds texels of N channels.
#[inline(always)]
fn add_plain<T: Texel, const N: usize>(texels: &[T], weights: &[(usize, f64)], sums: &mut [f64]) {
    let (texels, _) = texels.as_chunks::<N>();
    let mut sum = [0.0; N];
    for &(index, weight) in weights {
        let texel = &texels[index];
        for (sum, value) in sum.iter_mut().zip(texel) {
            *sum += weight * value.load().to_f64();
        }
    }
    for (to, sum) in sums.iter_mut().zip(sum) {
        *to += sum;
    }
}

/// The value of the largest weight; NaN of none.
fn mode(values: &mut [(f64, f64)]) -> f64 {
    values.sort_by(|a, b| a.0.total_cmp(&b.0));
    let (mut best, mut current) = ((f64::NAN, 0.0), (f64::NAN, 0.0));
    for &(value, weight) in values.iter() {
        if value.to_bits() == current.0.to_bits() {
            current.1 += weight;
        } else {
            current = (value, weight);
        }
        // Shares that differ by rounding are equal, and the smaller value stays.
        if current.1 > best.1 * (1.0 + 1e-9) || current.0.to_bits() == best.0.to_bits() {
            best = current;
        }
    }
    best.0
}
