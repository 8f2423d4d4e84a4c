//! Lookups that are bilinear in two levels of a mip chain, a tile at a time.
//!
//! Each level has those lookups of a tile that go there (`sample::in_level`), and the further of two is mixed into what the nearer
//! one showed: in the float that filters compute in, as lookups in an image without levels do.

use crate::kernel::Scalar;
use crate::resample::levels::{Aim, Levels};
use crate::resample::sample::{ByTile, Held, InLevel};

/// Lookups of one thread.
pub(crate) struct Trilinear<'l, F> {
    levels: &'l Levels<'l, dyn ByTile<F> + 'l>,
    /// Of each level that was ever looked up.
    own: Vec<Option<Own<'l, F>>>,
    channels: usize,
    values: Vec<F>,
    nowhere: Vec<usize>,
}

struct Own<'l, F> {
    held: Held<F>,
    lookups: Box<dyn InLevel<F> + 'l>,
}

impl<'l, F: Scalar> Trilinear<'l, F> {
    /// In texels of so many numbers.
    pub(crate) fn new(levels: &'l Levels<'l, dyn ByTile<F> + 'l>, channels: usize) -> Self {
        Trilinear {
            levels,
            own: (0..levels.count()).map(|_| None).collect(),
            channels,
            values: Vec::new(),
            nowhere: Vec::new(),
        }
    }

    /// Writes what lookups show that aim there, one tile at most. Returns which aim nowhere: of these nothing is written.
    #[inline(always)]
    pub(crate) fn look(
        &mut self,
        aims: impl Iterator<Item = Option<Aim>>,
        out: &mut [F],
    ) -> &[usize] {
        self.nowhere.clear();
        (self.own.iter_mut().flatten()).for_each(|own| own.held.clear());
        for (k, aim) in aims.enumerate() {
            let Some(aim) = aim else {
                self.nowhere.push(k);
                continue;
            };
            let (place, between) = aim.ends();
            self.own(between.level).push(k, place, F::ONE);
            if between.share > 0.0 && between.level + 1 < self.own.len() {
                let share = F::new(between.share);
                self.own(between.level + 1).push(k, place, share);
            }
        }
        self.show(out);
        &self.nowhere
    }

    fn show(&mut self, out: &mut [F]) {
        let used = |own: &&mut Own<'l, F>| own.held.count() > 0;
        for own in self.own.iter_mut().flatten().filter(used) {
            own.lookups.place(&mut own.held);
        }
        // A lookup comes to the nearer of its levels first.
        for Own { held, lookups } in self.own.iter_mut().flatten().filter(used) {
            if held.is_all(out.len() / self.channels) {
                lookups.look(held, out);
                continue;
            }
            let count = held.count() * self.channels;
            self.values.resize(count.max(self.values.len()), F::ZERO);
            let values = &mut self.values[..count];
            lookups.look(held, values);
            match self.channels {
                1 => mix::<F, 1>(held, values, out),
                3 => mix::<F, 3>(held, values, out),
                4 => mix::<F, 4>(held, values, out),
                n => {
                    for ((k, share), texel) in held.members().zip(values.chunks_exact(n)) {
                        mix_texel(share, texel, &mut out[k * n..][..n]);
                    }
                }
            }
        }
    }

    #[inline(always)]
    fn own(&mut self, level: usize) -> &mut Held<F> {
        let levels = self.levels;
        let own = self.own[level].get_or_insert_with(|| Own {
            held: Held::new(),
            lookups: levels.level(level).lookups(),
        });
        &mut own.held
    }
}

/// Mixes texels of C numbers into those of their own numbers.
#[inline(always)]
fn mix<F: Scalar, const C: usize>(held: &Held<F>, values: &[F], out: &mut [F]) {
    let out = out.as_chunks_mut::<C>().0;
    for ((k, share), texel) in held.members().zip(values.as_chunks::<C>().0) {
        mix_texel(share, texel, &mut out[k]);
    }
}

/// What counts for all is taken as it is.
#[inline(always)]
fn mix_texel<F: Scalar>(share: F, texel: &[F], out: &mut [F]) {
    if share == F::ONE {
        out.copy_from_slice(texel);
        return;
    }
    for (out, &value) in out.iter_mut().zip(texel) {
        *out = *out + share * (value - *out);
    }
}
