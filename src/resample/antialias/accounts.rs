//! Which texels single lookups are of whose means are put together of them, and the sums for these.

use crate::kernel::Scalar;
use crate::kernel::tile::{TILE, Tile};
use crate::resample::coordinate_map::CoordinateMap;
use std::ops::Range;

/// Which texels the samples of a tile belong to, and how much they count: those of one follow each other.
#[derive(Clone, Copy)]
pub(super) struct Owners {
    /// One more than samples: those of the last may not fit any more.
    pub(super) list: [Owner; TILE + 1],
    pub(super) length: usize,
    /// How many samples there are.
    pub(super) count: usize,
    /// Whether the source holds anything there.
    pub(super) seen: [bool; TILE],
    /// How much each counts of what those of its owner do.
    pub(super) shares: [f64; TILE],
}

#[derive(Clone, Copy)]
pub(super) struct Owner {
    pub(super) texel: u16,
    /// The first sample; the last is the one before the next owner's.
    pub(super) first: u16,
    /// Of each sample.
    pub(super) weight: f64,
    /// Whether shares are densities.
    pub(super) uneven: bool,
}

impl Owners {
    pub(super) const NONE: Owners = Owners {
        list: [Owner {
            texel: 0,
            first: 0,
            weight: 0.0,
            uneven: false,
        }; TILE + 1],
        length: 0,
        count: 0,
        seen: [false; TILE],
        shares: [1.0; TILE],
    };

    /// What comes next belongs to this texel, and each counts so much, times the density of its place if that is uneven.
    pub(super) fn begin(&mut self, texel: u16, (weight, uneven): (f64, bool)) {
        self.list[self.length] = Owner {
            texel,
            first: self.count as u16,
            weight,
            uneven,
        };
        self.length += 1;
    }

    /// The samples of an owner, by its number.
    #[inline(always)]
    pub(super) fn samples(&self, number: usize) -> Range<usize> {
        let list = &self.list[..self.length];
        let end = list
            .get(number + 1)
            .map_or(self.count, |next| usize::from(next.first));
        usize::from(list[number].first)..end
    }

    /// Weighs samples of uneven owners by the density at their places.
    #[inline(never)]
    pub(super) fn share<R: Scalar>(
        &mut self,
        coordinate_map: &CoordinateMap<'_>,
        places: &Tile<R, 3>,
    ) {
        self.shares = [1.0; TILE];
        if !self.list[..self.length].iter().any(|owner| owner.uneven) {
            return;
        }
        let mut densities = [0.0; TILE];
        coordinate_map.densities(places, self.count, &mut densities);
        for number in (0..self.length).filter(|&number| self.list[number].uneven) {
            let own = self.samples(number);
            self.shares[own.clone()].copy_from_slice(&densities[own]);
        }
    }
}

/// Sums for the texels of a block. Differences from a texel's first value are added, so that a constant stays
/// constant to the bit.
pub(super) struct Sums {
    pub(super) weights: [f64; TILE],
    pub(super) first: Vec<f64>,
    pub(super) sums: Vec<f64>,
}

impl Sums {
    /// Adds the samples of an owner that were seen. CHANNELS is 0 where their number is known at run time only.
    #[inline(always)]
    pub(super) fn add<F: Scalar, const CHANNELS: usize>(
        &mut self,
        owner: Owner,
        channels: usize,
        values: &[F],
        (seen, shares): (&[bool], &[f64]),
    ) {
        let texel = usize::from(owner.texel);
        let own = texel * channels..(texel + 1) * channels;
        let (first, sums) = (&mut self.first[own.clone()], &mut self.sums[own]);
        let samples = values.chunks_exact(channels).zip(seen).zip(shares);
        let samples = samples.filter(|((_, seen), _)| **seen);
        let mut samples = samples
            .map(|((values, _), share)| (values, share))
            .peekable();
        if self.weights[texel] == 0.0
            && let Some((values, _)) = samples.peek()
        {
            for (first, value) in first.iter_mut().zip(*values) {
                *first = value.to_f64();
            }
            sums.fill(0.0);
        }
        if CHANNELS > 0 {
            let (mut sum, mut base, mut count) = ([0.0; CHANNELS], [0.0; CHANNELS], 0.0);
            base.copy_from_slice(first);
            for (values, share) in samples {
                for k in 0..CHANNELS {
                    sum[k] += share * (values[k].to_f64() - base[k]);
                }
                count += share;
            }
            for (total, sum) in sums.iter_mut().zip(sum) {
                *total += owner.weight * sum;
            }
            self.weights[texel] += owner.weight * count;
        } else {
            // As above, number by number: however many channels there are, each has the same bits.
            for (c, (total, first)) in sums.iter_mut().zip(first).enumerate() {
                let differences = samples
                    .clone()
                    .map(|(values, share)| share * (values[c].to_f64() - *first));
                *total += owner.weight * differences.fold(0.0, |sum, x| sum + x);
            }
            let count = samples.fold(0.0, |count, (_, share)| count + share);
            self.weights[texel] += owner.weight * count;
        }
    }
}
