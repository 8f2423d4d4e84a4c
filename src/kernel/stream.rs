//! Results that are larger than caches go past them.
//!
//! A store to memory that no cache holds first reads what is about to be overwritten: three bytes move where two are asked
//! for, and a mapping that ran as fast as memory lets it took 1.4 times as long as it has to. Streaming stores leave
//! the read out. They also leave nothing in the caches, so that they pay only where inputs and outputs together would not
//! have stayed there. Measured on a CPU with 32 MB of cache, by two threads, ten million directions of f32 to pairs: 5.7 ms
//! and 4.5 ms streamed, where `memcpy` of the same bytes takes 5.9; three million 1.44 and 1.17; two million 0.77 and
//! 0.73; one million 0.31 and 0.37.
//!
//! Memory that the system gives at the first touch is in the cache by then, from being cleared: there a twentieth is lost, so
//! that a call has to say what it writes to ([`Room`]).
//!
//! What did not help: whole blocks, written to a buffer and streamed from there, are as slow as plain stores, since then no read
//! happens beside the writes. So each chunk of 64 points is streamed by itself.

/// Bytes of a call, in and out, from which its results go past the caches.
const FROM: usize = 48 << 20;

/// What streaming stores are aligned to.
#[cfg(target_arch = "x86_64")]
const ALIGNMENT: usize = 16;

/// What memory a call writes to.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Room {
    /// Nobody wrote to it before.
    Fresh,
    /// It has been written to, or may have been.
    Used,
}

/// Whether what a call writes is better not kept in caches.
pub fn pays<A, B>(input: &[A], output: &[B]) -> bool {
    size_of_val(input).saturating_add(size_of_val(output)) >= FROM
}

/// Whether streaming stores can write to this place.
pub(crate) fn fits<T>(place: &[T]) -> bool {
    #[cfg(target_arch = "x86_64")]
    {
        place.as_ptr().cast::<u8>().align_offset(ALIGNMENT) == 0
    }
    #[cfg(not(target_arch = "x86_64"))]
    {
        let _ = place;
        false
    }
}

/// Copies a chunk past the caches. Before anybody reads it, this thread has to [`finish`].
///
/// # Safety
/// The place [`fits`].
#[inline(always)]
pub(crate) unsafe fn copy<T: Copy, const COUNT: usize>(from: &[T; COUNT], to: &mut [T; COUNT]) {
    #[cfg(target_arch = "x86_64")]
    {
        use std::arch::x86_64::{__m128i, _mm_loadu_si128, _mm_stream_si128};
        const { assert!(size_of::<[T; COUNT]>().is_multiple_of(ALIGNMENT)) };
        let (from, to) = (
            from.as_ptr().cast::<__m128i>(),
            to.as_mut_ptr().cast::<__m128i>(),
        );
        for k in 0..size_of::<[T; COUNT]>() / ALIGNMENT {
            // SAFETY: both places are as large as all of these words together, `to` is aligned, which the caller promises, and every
            // x86-64 CPU has these two instructions.
            unsafe { _mm_stream_si128(to.add(k), _mm_loadu_si128(from.add(k))) };
        }
    }
    #[cfg(not(target_arch = "x86_64"))]
    to.copy_from_slice(from);
}

/// Streamed results come before everything that this thread writes from now on.
#[inline(always)]
pub(crate) fn finish() {
    #[cfg(target_arch = "x86_64")]
    {
        // SAFETY: a fence has no operands, and every x86-64 CPU has it.
        unsafe { std::arch::x86_64::_mm_sfence() };
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::kernel::tile::{Tuples, TuplesMut};
    use crate::kernel::{Frame, Point, run};

    #[derive(Clone, Copy)]
    struct Sums;

    impl Point<f32, 3, 2> for Sums {
        const STREAMS: bool = true;

        fn apply(self, [x, y, z]: [f32; 3]) -> [f32; 2] {
            [x + z, y + z]
        }
    }

    #[test]
    fn streamed_results_are_those_that_are_not() {
        for count in [0, 1, 63, 64, 65, 1000] {
            let input: Vec<f32> = (0..3 * count).map(|k| k as f32).collect();
            let results = |first: usize, past: bool| {
                // Some of these places are aligned, others not.
                let mut room = vec![0.0; 2 * count + 5];
                let output = TuplesMut::past_caches(&mut room[first..first + 2 * count], past);
                run(Sums, &Frame::plain(), Tuples::of(&input), output);
                assert!(room[first + 2 * count..].iter().all(|x| *x == 0.0));
                room[first..first + 2 * count].to_vec()
            };
            let expected: Vec<f32> = input
                .chunks(3)
                .flat_map(|d| [d[0] + d[2], d[1] + d[2]])
                .collect();
            for first in 0..5 {
                assert_eq!(results(first, true), expected, "{count} from {first}");
                assert_eq!(results(first, false), expected, "{count} from {first}");
            }
        }
    }

    #[test]
    fn only_large_calls_pay() {
        let [small, large] = [FROM / 16, FROM / 4].map(|count| vec![0.0_f32; count]);
        assert!(!pays(&small, &small));
        assert!(pays(&small, &large));
    }
}
