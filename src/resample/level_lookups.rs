//! Lookups at levels of a mip chain by either filter, a tile at a time.

use crate::image::texel::Texel;
use crate::number::real::Real;
use crate::resample::filters::MipmappedFilter;
use crate::resample::levels::{Aim, Levels};
use crate::resample::sample::ByTile;
use crate::resample::trilinear::Trilinear;

/// How many lookups on one is whose memory is asked for.
const AHEAD: usize = 8;

/// Lookups of one thread.
pub(crate) struct LevelLookups<'l, T: Texel> {
    levels: &'l Levels<'l, dyn ByTile<T::Float> + 'l>,
    channels: usize,
    fill: &'l [T],
    way: Way<'l, T::Float>,
}

enum Way<'l, F> {
    /// Tile by tile: what a tile shows, and what shows it.
    Trilinear(Trilinear<'l, F>, Vec<F>),
    /// Lookup by lookup: where those of a tile go, and what both levels show of one.
    Ewa(Vec<Option<Aim>>, Vec<f64>),
}

impl<'l, T: Texel> LevelLookups<'l, T> {
    /// In texels of so many numbers. What aims nowhere shows `fill`.
    pub(crate) fn new(
        levels: &'l Levels<'l, dyn ByTile<T::Float> + 'l>,
        filter: MipmappedFilter,
        (channels, fill): (usize, &'l [T]),
    ) -> Self {
        let way = match filter {
            MipmappedFilter::Trilinear => {
                Way::Trilinear(Trilinear::new(levels, channels), Vec::new())
            }
            MipmappedFilter::Ewa => Way::Ewa(Vec::new(), vec![0.0; 2 * channels]),
        };
        LevelLookups {
            levels,
            channels,
            fill,
            way,
        }
    }

    /// Writes what lookups show that aim there, one tile at most.
    #[inline(always)]
    pub(crate) fn look(&mut self, aims: impl Iterator<Item = Option<Aim>>, out: &mut [T]) {
        let (levels, fill, channels) = (self.levels, self.fill, self.channels);
        match &mut self.way {
            Way::Trilinear(trilinear, shown) => {
                shown.resize(out.len(), T::Float::ZERO);
                let nowhere = trilinear.look(aims, shown);
                for (out, shown) in out.iter_mut().zip(&*shown) {
                    *out = T::store(*shown);
                }
                for k in nowhere {
                    out[k * channels..][..channels].copy_from_slice(fill);
                }
            }
            Way::Ewa(all, values) => {
                all.clear();
                all.extend(aims);
                for (k, out) in out.chunks_exact_mut(channels).enumerate() {
                    if let [.., Some(last), Some(next)] = all[..all.len().min(k + AHEAD + 1)]
                        && k + AHEAD < all.len()
                        && !levels.near(&next, &last)
                    {
                        levels.ask(&next);
                    }
                    let Some(aim) = &all[k] else {
                        out.copy_from_slice(fill);
                        continue;
                    };
                    levels.average(aim, values);
                    for (out, value) in out.iter_mut().zip(values.iter()) {
                        *out = T::store(T::Float::new(*value));
                    }
                }
            }
        }
    }
}
