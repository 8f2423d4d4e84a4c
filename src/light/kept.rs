//! What was found last of images of a map and a shape, kept for the next call that asks for the same.
//!
//! Lights are asked of one environment again and again: what does not depend on its texels is found once. Each list keeps what
//! fits a number of items, the latest of them, and is not locked while something is found: two threads that ask at once both find it.
//! What a call found that was stopped is not whole, and is not kept.

use crate::kernel::interrupt;
use crate::map::Map;
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};

/// The last of some kind, up to so many items in all.
pub struct Kept<V> {
    most: usize,
    found: Mutex<Vec<Found<V>>>,
}

struct Found<V> {
    map: Map,
    shape: Vec<usize>,
    items: usize,
    what: Arc<V>,
}

impl<V> Found<V> {
    fn is_of(&self, map: &Map, shape: &[usize]) -> bool {
        self.map == *map && self.shape == shape
    }
}

impl<V> Kept<V> {
    /// Nothing yet.
    pub const fn new(most: usize) -> Kept<V> {
        Kept {
            most,
            found: Mutex::new(Vec::new()),
        }
    }

    /// That of a map and a shape, which `find` finds where it is not there. It has so many `items`.
    pub fn of<E>(
        &self,
        map: &Map,
        shape: &[usize],
        items: impl FnOnce(&V) -> usize,
        find: impl FnOnce() -> Result<V, E>,
    ) -> Result<Arc<V>, E> {
        if let Some(what) = self.again(map, shape) {
            return Ok(what);
        }
        let what = Arc::new(find()?);
        let items = items(&what);
        if items <= self.most && interrupt::check().is_ok() {
            let mut found = self.lock();
            found.retain(|one| !one.is_of(map, shape));
            found.push(Found {
                map: map.clone(),
                shape: shape.to_vec(),
                items,
                what: Arc::clone(&what),
            });
            while found.iter().map(|one| one.items).sum::<usize>() > self.most {
                found.remove(0);
            }
        }
        Ok(what)
    }

    fn again(&self, map: &Map, shape: &[usize]) -> Option<Arc<V>> {
        let mut found = self.lock();
        let place = found.iter().position(|one| one.is_of(map, shape))?;
        let one = found.remove(place);
        let what = Arc::clone(&one.what);
        found.push(one);
        Some(what)
    }

    fn lock(&self) -> MutexGuard<'_, Vec<Found<V>>> {
        self.found.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::error::Error;
    use crate::kernel::threads;
    use std::convert::Infallible;
    use std::time::Duration;

    #[test]
    fn the_latest_are_there_and_what_is_too_large_is_not() {
        let kept = Kept::new(5);
        let maps = ["latlong", "cube"].map(|name| Map::new(name).unwrap());
        let count = std::cell::Cell::new(0);
        let ask = |map: usize, side: usize, items: usize| {
            let find = || {
                count.set(count.get() + 1);
                Ok::<_, Infallible>(count.get())
            };
            let Ok(found) = kept.of(&maps[map], &[side], |_| items, find);
            *found
        };
        assert_eq!([ask(0, 1, 2), ask(1, 1, 2), ask(0, 1, 2)], [1, 2, 1]);
        // No room for all three: the one that was asked for longest ago goes.
        assert_eq!([ask(0, 2, 3), ask(0, 1, 2), ask(1, 1, 2)], [3, 1, 4]);
        // Larger than all that is kept: found each time.
        assert_eq!([ask(0, 9, 6), ask(0, 9, 6), ask(1, 1, 2)], [5, 6, 4]);
    }

    #[test]
    fn what_a_stopped_call_found_is_not_there() {
        let (kept, map) = (Kept::new(5), Map::new("latlong").unwrap());
        let slowly = || {
            let mut rows = vec![0; 200];
            threads::rows(&mut rows, 1, 200, |_, row| {
                std::thread::sleep(Duration::from_millis(5));
                row[0] = 1;
            });
            Ok::<_, Infallible>(rows)
        };
        let ask = || kept.of(&map, &[1], |_| 1, slowly);
        assert_eq!(
            interrupt::stoppable(|_| true, ask).err(),
            Some(Error::Stopped)
        );
        let whole = || Ok::<_, Infallible>(vec![1; 2]);
        let Ok(found) = kept.of(&map, &[1], Vec::len, whole);
        assert_eq!(*found, [1, 1]);
    }
}
