//! Which texels single lookups are of whose means are put together of them, and the sums for these.

use crate::kernel::Scalar;
use crate::kernel::tile::TILE;

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
}

#[derive(Clone, Copy)]
pub(super) struct Owner {
    pub(super) texel: u16,
    /// The first sample; the last is the one before the next owner's.
    pub(super) first: u16,
    /// Of each sample.
    pub(super) weight: f64,
}

impl Owners {
    pub(super) const NONE: Owners = Owners {
        list: [Owner {
            texel: 0,
            first: 0,
            weight: 0.0,
        }; TILE + 1],
        length: 0,
        count: 0,
        seen: [false; TILE],
    };

    /// What comes next belongs to this texel.
    pub(super) fn begin(&mut self, texel: u16, weight: f64) {
        self.list[self.length] = Owner {
            texel,
            first: self.count as u16,
            weight,
        };
        self.length += 1;
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
        seen: &[bool],
    ) {
        let texel = usize::from(owner.texel);
        let own = texel * channels..(texel + 1) * channels;
        let (first, sums) = (&mut self.first[own.clone()], &mut self.sums[own]);
        let samples = values.chunks_exact(channels).zip(seen);
        let mut samples = samples.filter(|(_, seen)| **seen).peekable();
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
            for (values, _) in samples {
                for k in 0..CHANNELS {
                    sum[k] += values[k].to_f64() - base[k];
                }
                count += 1.0;
            }
            for (total, sum) in sums.iter_mut().zip(sum) {
                *total += owner.weight * sum;
            }
            self.weights[texel] += owner.weight * count;
        } else {
            for (values, _) in samples {
                for ((sum, first), value) in sums.iter_mut().zip(&*first).zip(values) {
                    *sum += owner.weight * (value.to_f64() - *first);
                }
                self.weights[texel] += owner.weight;
            }
        }
    }
}
