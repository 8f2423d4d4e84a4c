//! Calls that can be stopped, and tell how far they are.
//!
//! Whoever runs a call may give it a question that is asked on the caller's thread, between pieces of work and no oftener than
//! [`EVERY`]: is it to stop? Then no further piece is begun, here or on other threads, nothing else that the call does is begun, and its
//! result is thrown away. Python asks whether somebody pressed Ctrl-C.
//!
//! The question is told how much of the call is done, where that is known: pieces are counted within a [`part`] of the call, and nowhere
//! else. What prepares the work, and takes little of the time, is in none.
//!
//! Results that outlive a call must not be kept of a call that was stopped: [`check`] says so.

use crate::error::Error;
use std::cell::Cell;
use std::time::{Duration, Instant};

/// How long work goes on before the question is asked again.
const EVERY: Duration = Duration::from_millis(50);

/// Asked with how much of a call is done, from 0 to 1, or none where that is not known: is it to stop?
pub type Question = fn(Option<f64>) -> bool;

thread_local! {
    /// The question of the call that runs on this thread.
    static QUESTION: Cell<Option<Question>> = const { Cell::new(None) };
    /// Whether the call that runs on this thread is to stop.
    static STOPPED: Cell<bool> = const { Cell::new(false) };
    /// Which part of its call is being done on this thread, where pieces are counted.
    static PART: Cell<Option<[f64; 2]>> = const { Cell::new(None) };
}

/// Runs a call that stops once `question` says so. It is told how much of the call is done, where that is known.
///
/// # Errors
/// It was stopped.
///
/// ```
/// use spheremap::{Error, interrupt, Map};
/// let map = Map::new("octahedral")?;
/// let mut uv = vec![0.0; 2 * 1000];
/// // Done before the question is first asked.
/// interrupt::stoppable(|_| true, || map.encode(&vec![0.5; 3 * 1000], &mut uv))??;
/// # Ok::<(), Error>(())
/// ```
pub fn stoppable<T>(question: Question, call: impl FnOnce() -> T) -> Result<T, Error> {
    /// Leaves things as they were, also where the call panics.
    struct Before(Option<Question>, Option<[f64; 2]>);
    impl Drop for Before {
        fn drop(&mut self) {
            QUESTION.set(self.0);
            PART.set(self.1);
            STOPPED.set(false);
        }
    }
    let before = Before(QUESTION.replace(Some(question)), PART.take());
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

/// Does a part of the call that runs on this thread, or of the part that it is in, and counts its pieces: from `first` to `last`, where the
/// whole is from 0 to 1.
pub(crate) fn part<T>(first: f64, last: f64, work: impl FnOnce() -> T) -> T {
    let whole = PART.get();
    let [start, end] = whole.unwrap_or([0.0, 1.0]);
    PART.set(Some([first, last].map(|x| start + (end - start) * x)));
    let result = work();
    PART.set(whole);
    result
}

/// Asks the question of a call now and then.
pub(crate) struct Watch {
    question: Option<Question>,
    part: Option<[f64; 2]>,
    asked: Instant,
}

impl Watch {
    /// That of the call that runs on this thread.
    pub fn new() -> Watch {
        Watch {
            question: QUESTION.get(),
            part: PART.get(),
            asked: Instant::now(),
        }
    }

    /// Whether the call is to stop; `done` says how many of all pieces of this work are done, from 0 to 1.
    pub fn stops(&mut self, done: &dyn Fn() -> f64) -> bool {
        let Some(question) = self.question else {
            return false;
        };
        if !STOPPED.get() && self.asked.elapsed() >= EVERY {
            let part = self.part;
            STOPPED.set(question(
                part.map(|[start, end]| start + (end - start) * done()),
            ));
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
        assert_eq!(stoppable(|_| true, call), Err(Error::Stopped));
        assert!((1..100).contains(&done.load(Ordering::Relaxed)));
        assert_eq!(check(), Ok(()));
        let mut out = [0_u8; 10];
        assert_eq!(
            stoppable(|_| true, || threads::rows(&mut out, 1, 10, |_, x| x[0] = 1)),
            Ok(())
        );
        assert_eq!(out, [1; 10]);
    }

    #[test]
    fn a_call_tells_how_far_it_is_where_pieces_are_counted() {
        thread_local! {
            static TOLD: Cell<Vec<Option<f64>>> = const { Cell::new(Vec::new()) };
        }
        fn remember(done: Option<f64>) -> bool {
            let mut told = TOLD.take();
            told.push(done);
            TOLD.set(told);
            false
        }
        // On this thread alone, and on several.
        for points in [1, threads::PARALLEL_FROM] {
            let pieces = || {
                let mut out = [0_u8; 30];
                threads::rows(&mut out, 1, points, |_, _| {
                    std::thread::sleep(Duration::from_millis(20));
                });
            };
            let call = || {
                pieces();
                let uncounted = TOLD.take();
                part(0.5, 1.0, || {
                    part(0.0, 0.5, pieces);
                    part(0.5, 1.0, pieces);
                });
                uncounted
            };
            let uncounted = stoppable(remember, call).unwrap();
            assert!(!uncounted.is_empty() && uncounted.iter().all(Option::is_none));
            let told: Option<Vec<f64>> = TOLD.take().into_iter().collect();
            let told = told.unwrap();
            // The whole, where the last piece was in hand when it was asked.
            assert!(told.is_sorted() && told[0] >= 0.5 && *told.last().unwrap() <= 1.0);
            assert!(told.iter().any(|x| *x < 0.75) && told.iter().any(|x| *x > 0.75));
        }
    }
}
