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
        let (face, i, j) = place;
        let number = 67 * face as isize + i + 37 * j;
        let slot = &slots[number.rem_euclid(SLOTS as isize) as usize];
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
