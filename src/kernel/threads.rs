//! Threads: one pool, safe across `fork`, and only where they pay.
//!
//! Waking the pool costs 15 to 60 µs, so small calls stay on the caller's thread. The pool belongs to the
//! process that made it: a forked child has none of its parent's threads, and rayon's global pool would
//! wait for them for ever. So the pool is ours, kept with the id of its process, and a child makes
//! its own at its first large call.
//!
//! The caller's thread takes its share of the work. While it only waited, both threads of a pool of two, after a pause, woke on one
//! core as often as not, and a call of 11 ms took 16.
//!
//! Work is split into blocks whose borders depend on nothing but the size of the work, and no block's result
//! depends on another's, so the number of threads never shows in a result.
//!
//! Without the feature `rayon` there is no pool, and all work is done on the caller's thread.

use crate::kernel::interrupt::Watch;
#[cfg(feature = "rayon")]
use rayon::ThreadPool;
#[cfg(feature = "rayon")]
use std::sync::Arc;
#[cfg(feature = "rayon")]
use std::sync::atomic::AtomicBool;
use std::sync::atomic::{AtomicUsize, Ordering};
use std::sync::{Mutex, PoisonError};

/// Points from which a call is spread over threads.
pub const PARALLEL_FROM: usize = 1 << 17;

/// Points a block.
const BLOCK: usize = 1 << 13;

/// 0 until somebody asks or sets.
static THREADS: AtomicUsize = AtomicUsize::new(0);

#[cfg(feature = "rayon")]
struct Pool {
    process: u32,
    threads: usize,
    pool: Arc<ThreadPool>,
}

#[cfg(feature = "rayon")]
static POOL: Mutex<Option<Pool>> = Mutex::new(None);

/// How many threads large calls use: what was set, else `SPHEREMAP_NUM_THREADS`, else one a core; at most four a core.
///
/// ```
/// assert!(spheremap::threads::count() >= 1);
/// ```
pub fn count() -> usize {
    match THREADS.load(Ordering::Relaxed) {
        0 => {
            let threads = std::env::var("SPHEREMAP_NUM_THREADS")
                .ok()
                .and_then(|text| text.trim().parse().ok())
                .filter(|threads| *threads > 0)
                .unwrap_or_else(cores)
                .min(most());
            THREADS.store(threads, Ordering::Relaxed);
            threads
        }
        threads => threads,
    }
}

fn cores() -> usize {
    std::thread::available_parallelism().map_or(1, usize::from)
}

/// Four a core: more wait for each other, and thousands take minutes to start.
fn most() -> usize {
    4 * cores()
}

/// Sets how many threads large calls use; at least one, and at most four a core.
///
/// ```
/// use spheremap::threads;
/// threads::set_count(2);
/// assert_eq!(threads::count(), 2);
/// ```
pub fn set_count(threads: usize) {
    THREADS.store(threads.clamp(1, most()), Ordering::Relaxed);
}

/// The pool of this process, one thread short of what is asked for, or none where that is one or threads cannot be had.
#[cfg(feature = "rayon")]
fn pool() -> Option<Arc<ThreadPool>> {
    let threads = count();
    if threads < 2 {
        return None;
    }
    let process = std::process::id();
    let mut slot = POOL.lock().unwrap_or_else(PoisonError::into_inner);
    if let Some(pool) = slot.as_ref()
        && pool.process == process
        && pool.threads == threads
    {
        return Some(Arc::clone(&pool.pool));
    }
    if let Some(old) = slot.take()
        && old.process != process
    {
        // Its threads live in the parent: waiting for them would never end.
        std::mem::forget(old);
    }
    let builder = rayon::ThreadPoolBuilder::new().num_threads(threads - 1);
    let pool = Arc::new(
        builder
            .thread_name(|i| format!("spheremap-{i}"))
            .build()
            .ok()?,
    );
    *slot = Some(Pool {
        process,
        threads,
        pool: Arc::clone(&pool),
    });
    Some(pool)
}

/// Calls `work` on matching blocks of `input` (I numbers a point) and `output` (O items a point).
pub fn blocks<A: Sync, B: Send>(
    input: &[A],
    per_input: usize,
    output: &mut [B],
    per_output: usize,
    work: impl Fn(&[A], &mut [B]) + Sync,
) {
    let points = output.len() / per_output;
    if points < PARALLEL_FROM {
        return work(input, output);
    }
    let blocks = input
        .chunks(BLOCK * per_input)
        .zip(output.chunks_mut(BLOCK * per_output));
    each(points, blocks, |(input, output)| work(input, output));
}

/// Calls `work` on each item, on the caller's thread and, where there are enough points, on those of the pool.
pub fn each<I: ExactSizeIterator<Item: Send> + Send>(
    points: usize,
    items: I,
    work: impl Fn(I::Item) + Sync,
) {
    let count = items.len().max(1) as f64;
    let items = Mutex::new(items);
    let rest = || items.lock().unwrap_or_else(PoisonError::into_inner);
    let next = || rest().next();
    let step = || next().map(&work).is_some();
    repeat(points, &step, &|| 1.0 - rest().len() as f64 / count);
}

/// Does steps of work until there are no more, or the call is to stop; `done` says how much is done, from 0 to 1.
///
/// Behind pointers: threads, and what is done on each of them, were a megabyte as a function for each work.
fn repeat(points: usize, step: &(dyn Fn() -> bool + Sync), done: &dyn Fn() -> f64) {
    let mut watch = Watch::new();
    #[cfg(feature = "rayon")]
    if points >= PARALLEL_FROM
        && let Some(pool) = pool()
    {
        let stop = AtomicBool::new(false);
        pool.in_place_scope(|scope| {
            for _ in 0..pool.current_num_threads() {
                scope.spawn(|_| {
                    while !stop.load(Ordering::Relaxed) {
                        if !step() {
                            break;
                        }
                    }
                });
            }
            while !watch.stops(done) && step() {}
            stop.store(watch.stops(done), Ordering::Relaxed);
        });
        return;
    }
    #[cfg(not(feature = "rayon"))]
    let _ = points;
    while !watch.stops(done) && step() {}
}

/// Calls `work(number, row)` on each row of `width` items, spread over threads where there are
/// enough points in all.
pub fn rows<T: Send>(
    output: &mut [T],
    width: usize,
    points: usize,
    work: impl Fn(usize, &mut [T]) + Sync,
) {
    if width == 0 {
        return;
    }
    let rows = output.chunks_mut(width).enumerate();
    each(points, rows, |(row, out)| work(row, out));
}

/// How many rows [`bands`] of so many in all have, of `points` points in all.
pub fn band_rows(height: usize, points: usize, step: usize) -> usize {
    (BLOCK * height / points.max(1))
        .max(1)
        .next_multiple_of(step)
}

/// Calls `work(first, band)` on bands of rows of `width` items, spread over threads where there are enough
/// points in all. A band has about [`BLOCK`] points, in a multiple of `step` rows.
pub fn bands<T: Send>(
    output: &mut [T],
    width: usize,
    points: usize,
    step: usize,
    work: impl Fn(usize, &mut [T]) + Sync,
) {
    if width == 0 {
        return;
    }
    let height = output.len() / width;
    let band = band_rows(height, points, step);
    rows(output, band * width, points, |k, out| work(k * band, out));
}
