//! The smaller versions of a picture that maps no sphere: each texel the mean of those that it covers.
//!
//! A side of n texels has n/2 in the next level, rounded down, and at least one: the sizes of a complete chain in graphics
//! APIs, which leave open how its texels are made. Where n is odd, texels at the borders of two are divided.

use crate::error::Error;
use crate::image::texel::Texel;
use crate::kernel::Scalar;
use crate::kernel::memory::expect_room;
use crate::kernel::threads;
use crate::number::real::Real;

/// A level: how wide and high it is, and its texels.
pub(crate) type Level<F> = ([usize; 2], Vec<F>);

/// All levels but the first, down to one texel.
pub(crate) fn chain<T: Texel>(
    size: [usize; 2],
    channels: usize,
    texels: &[T],
) -> Result<Vec<Level<T::Float>>, Error> {
    let mut levels: Vec<Level<T::Float>> = Vec::new();
    loop {
        let next = match levels.last() {
            None => half(size, channels, texels)?,
            Some((size, texels)) => half(*size, channels, texels)?,
        };
        match next {
            Some(next) => levels.push(next),
            None => return Ok(levels),
        }
    }
}

fn half<T: Texel>(
    [width, height]: [usize; 2],
    channels: usize,
    texels: &[T],
) -> Result<Option<Level<T::Float>>, Error> {
    if width.max(height) < 2 {
        return Ok(None);
    }
    let size = [(width / 2).max(1), (height / 2).max(1)];
    let count = size[0] * size[1] * channels;
    expect_room::<T::Float>(count)?;
    let (across, down) = (shares(width, size[0]), shares(height, size[1]));
    let mut out = vec![T::Float::default(); count];
    threads::rows(&mut out, size[0] * channels, width * height, |j, row| {
        for (i, out) in row.chunks_exact_mut(channels).enumerate() {
            for (c, out) in out.iter_mut().enumerate() {
                let value =
                    |x: usize, y: usize| texels[(y * width + x) * channels + c].load().to_f64();
                // Differences from one of them: a constant stays constant to the bit.
                let base = value(across[i][0].0, down[j][0].0);
                let mut sum = 0.0;
                for &(y, part_v) in &down[j] {
                    for &(x, part_u) in &across[i] {
                        sum += part_u * part_v * (value(x, y) - base);
                    }
                }
                *out = T::Float::new(base + sum);
            }
        }
    });
    Ok(Some((size, out)))
}

/// For each of `wanted` texels along a side those of `count` that it covers, and what part of it each is.
fn shares(count: usize, wanted: usize) -> Vec<Vec<(usize, f64)>> {
    // In units of 1 / (count · wanted): whole numbers.
    let covered = |i: usize| {
        let (low, high) = (i * count, (i + 1) * count);
        (low / wanted..high.div_ceil(wanted)).map(move |k| {
            let part = high.min((k + 1) * wanted) - low.max(k * wanted);
            (k, part as f64 / count as f64)
        })
    };
    (0..wanted).map(|i| covered(i).collect()).collect()
}

#[cfg(test)]
mod tests {
    use super::{chain, shares};

    #[test]
    fn shares_are_those_of_the_covered_parts() {
        assert_eq!(shares(4, 2), [[(0, 0.5), (1, 0.5)], [(2, 0.5), (3, 0.5)]]);
        let fifth = |k: usize, fifths: f64| (k, fifths / 5.0);
        assert_eq!(
            shares(5, 2),
            [
                [fifth(0, 2.0), fifth(1, 2.0), fifth(2, 1.0)],
                [fifth(2, 1.0), fifth(3, 2.0), fifth(4, 2.0)]
            ]
        );
        assert_eq!(shares(1, 1), [[(0, 1.0)]]);
    }

    #[test]
    fn a_chain_ends_with_the_mean() {
        let texels: Vec<f64> = (0..5 * 12 * 2).map(f64::from).collect();
        let levels = chain([12, 5], 2, &texels).unwrap();
        let sizes: Vec<_> = levels.iter().map(|(size, _)| *size).collect();
        assert_eq!(sizes, [[6, 2], [3, 1], [1, 1]]);
        // The means of 0, 2, .. 118 and of 1, 3, .. 119; three levels round.
        for (got, want) in levels[2].1.iter().zip([59.0, 60.0]) {
            assert!((got - want).abs() < 1e-13, "{got}");
        }
    }
}
