//! Whether all numbers of an image are finite: asked before sums, of which one number that is not would leave nothing.

use crate::image::texel::Texel;
use crate::kernel::{threads, vectorize};
use crate::number::real::Real;
use std::sync::atomic::{AtomicBool, Ordering};

/// Numbers that are looked at together.
const TOGETHER: usize = 1 << 15;

/// Whether they are.
pub(crate) fn all_finite<T: Texel>(numbers: &[T]) -> bool {
    let finite = AtomicBool::new(true);
    threads::each(numbers.len(), numbers.chunks(TOGETHER), |numbers| {
        let infinity = <T::Float as Real>::new(f64::INFINITY);
        let all = vectorize(
            #[inline(always)]
            || {
                let each = numbers.iter().map(|x| x.load().abs().less(infinity));
                each.fold(true, |all, finite| all & finite)
            },
        );
        if !all {
            finite.store(false, Ordering::Relaxed);
        }
    });
    finite.into_inner()
}

#[cfg(test)]
mod tests {
    use super::{TOGETHER, all_finite};

    #[test]
    fn one_number_is_enough_wherever_it_is() {
        let mut numbers = vec![f32::MAX; 3 * TOGETHER + 5];
        assert!(all_finite(&numbers));
        assert!(all_finite::<f32>(&[]));
        for at in [0, TOGETHER - 1, TOGETHER, 3 * TOGETHER + 4] {
            for bad in [f32::NAN, -f32::NAN, f32::INFINITY, f32::NEG_INFINITY] {
                numbers[at] = bad;
                assert!(!all_finite(&numbers), "{at} {bad}");
                assert!(!all_finite(&[half::f16::from_f32(bad)]));
                assert!(!all_finite(&[f64::from(bad)]));
            }
            numbers[at] = -f32::MIN_POSITIVE / 4.0;
        }
        assert!(all_finite(&[
            half::f16::MAX,
            half::f16::MIN,
            half::f16::ZERO
        ]));
    }
}
