//! Calls that can be stopped.
//!
//! Whoever runs a call may give it a question that is asked on the caller's thread, between pieces of work and no oftener than
//! [`EVERY`]: is it to stop? Then no further piece is begun, here or on other threads, nothing else that the call does is begun, and its
//! result is thrown away. Python asks whether somebody pressed Ctrl-C.
//!
//! Results that outlive a call must not be kept of a call that was stopped: [`check`] says so.

use crate::error::Error;
use std::cell::Cell;
use std::time::{Duration, Instant};

/// How long work goes on before the question is asked again.
const EVERY: Duration = Duration::from_millis(50);

thread_local! {
    /// The question of the call that runs on this thread.
    static QUESTION: Cell<Option<fn() -> bool>> = const { Cell::new(None) };
    /// Whether the call that runs on this thread is to stop.
    static STOPPED: Cell<bool> = const { Cell::new(false) };
}

/// Runs a call that stops once `question` says so.
///
/// # Errors
/// It was stopped.
///
/// ```
/// use spheremap::{Error, interrupt, Map};
/// let map = Map::new("octahedral")?;
/// let mut uv = vec![0.0; 2 * 1000];
/// // Done before the question is first asked.
/// interrupt::stoppable(|| true, || map.encode(&vec![0.5; 3 * 1000], &mut uv))??;
/// # Ok::<(), Error>(())
/// ```
pub fn stoppable<T>(question: fn() -> bool, call: impl FnOnce() -> T) -> Result<T, Error> {
    /// Leaves things as they were, also where the call panics.
    struct Before(Option<fn() -> bool>);
    impl Drop for Before {
        fn drop(&mut self) {
            QUESTION.set(self.0);
            STOPPED.set(false);
        }
    }
    let before = Before(QUESTION.replace(Some(question)));
    let result = call();
    let stopped = check();
    drop(before);
    stopped.map(|()| result)
}

/// # Errors
/// The call that runs on this thread is to stop.
pub(crate) fn check() -> Result<(), Error> {
    if STOPPED.get() {
        Err(Error::Stopped)
    } else {
        Ok(())
    }
}

/// Asks the question of a call now and then.
pub(crate) struct Watch {
    question: Option<fn() -> bool>,
    asked: Instant,
}

impl Watch {
    /// That of the call that runs on this thread.
    pub fn new() -> Watch {
        Watch {
            question: QUESTION.get(),
            asked: Instant::now(),
        }
    }

    /// Whether the call is to stop.
    pub fn stops(&mut self) -> bool {
        let Some(question) = self.question else {
            return false;
        };
        if !STOPPED.get() && self.asked.elapsed() >= EVERY {
            STOPPED.set(question());
            self.asked = Instant::now();
        }
        STOPPED.get()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::kernel::threads;
    use std::sync::atomic::{AtomicUsize, Ordering};

    #[test]
    fn a_call_stops_between_pieces_and_the_next_one_runs() {
        let done = AtomicUsize::new(0);
        let call = || {
            let mut out = vec![0_u8; 1000];
            threads::rows(&mut out, 1, 1000, |_, _| {
                std::thread::sleep(Duration::from_millis(5));
                done.fetch_add(1, Ordering::Relaxed);
            });
            // What comes after it is not begun.
            threads::rows(&mut out, 1, 1000, |_, _| {
                done.fetch_add(1, Ordering::Relaxed);
            });
        };
        assert_eq!(stoppable(|| true, call), Err(Error::Stopped));
        assert!((1..100).contains(&done.load(Ordering::Relaxed)));
        assert_eq!(check(), Ok(()));
        let mut out = [0_u8; 10];
        assert_eq!(
            stoppable(|| true, || threads::rows(&mut out, 1, 10, |_, x| x[0] = 1)),
            Ok(())
        );
        assert_eq!(out, [1; 10]);
    }
}
