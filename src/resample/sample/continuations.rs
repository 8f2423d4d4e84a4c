//! What stands for texels beyond mirrored rims and cuts, for as long as an image is looked up.
//!
//! Which stored texels one comes to, and with which weights, is found through both formulas of a projection, again and again where it lies
//! beyond a rim once more: microseconds. Lookups beside a rim come to the same few. So those that were found last are kept, each in the one
//! slot that its place has: in a table that grew, a large image would have megabytes.

use std::array::from_fn;
use std::sync::{Mutex, OnceLock, PoisonError};

/// How many are kept: a block of the target comes to fewer.
const SLOTS: usize = 1 << 10;

/// A texel: its face, and its column and row, which may be beyond those of the image.
pub(super) type Place = (usize, isize, isize);

/// The one of so many slots that a place has: neighbors have others.
pub(super) fn slot_of((face, i, j): Place, slots: usize) -> usize {
    let number = 67 * face as isize + i + 37 * j;
    number.rem_euclid(slots as isize) as usize
}

/// A place, and the stored texels with weights that it came to.
type Slot = Option<(Place, Box<[(usize, f64)]>)>;

/// Those that were found last.
#[derive(Default)]
pub(crate) struct Continuations(OnceLock<Box<[Mutex<Slot>; SLOTS]>>);

impl Continuations {
    /// Calls `each` with the texels and weights of a place: those that `find` finds, now or before.
    pub(super) fn of(
        &self,
        place: Place,
        find: impl FnOnce() -> Vec<(usize, f64)>,
        mut each: impl FnMut(usize, f64),
    ) {
        let slots = (self.0).get_or_init(|| Box::new(from_fn(|_| Mutex::new(None))));
        let slot = &slots[slot_of(place, SLOTS)];
        let mut slot = slot.lock().unwrap_or_else(PoisonError::into_inner);
        if !matches!(&*slot, Some((own, _)) if *own == place) {
            *slot = Some((place, find().into()));
        }
        if let Some((_, texels)) = &*slot {
            texels
                .iter()
                .for_each(|&(texel, weight)| each(texel, weight));
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_place_is_found_again_only_where_another_took_its_slot() {
        let known = Continuations::default();
        let mut found = 0;
        let mut ask = |place: Place| {
            let mut texels = Vec::new();
            let find = || {
                found += 1;
                vec![(place.0, 0.25), (7, place.1 as f64)]
            };
            known.of(place, find, |texel, weight| texels.push((texel, weight)));
            assert_eq!(texels, [(place.0, 0.25), (7, place.1 as f64)]);
            found
        };
        let far = SLOTS as isize;
        assert_eq!(
            [ask((1, -2, 5)), ask((1, -2, 5)), ask((0, -2, 5))],
            [1, 1, 2]
        );
        // In the same slot.
        assert_eq!(
            [ask((1, far - 2, 5)), ask((1, far - 2, 5)), ask((1, -2, 5))],
            [3, 3, 4]
        );
    }
}
