//! Interpolation kernels: how much each texel of a row counts for a place between two of them.
//!
//! `t` in [0, 1) is how far the place lies from the texel on its left to the one on its right. The cubics are
//! the family of Mitchell and Netravali ("Reconstruction Filters in Computer Graphics", SIGGRAPH 1988): (B, C) =
//! (0, ½) is Catmull and Rom's, which interpolates and reproduces parabolas, (⅓, ⅓) the compromise that the
//! paper recommends: softer, hardly any ringing, and no interpolation. Lanczos' window over three lobes is
//! sinc(x) sinc(x/3), here divided by the sum of its six weights, which alone differs from 1 by up to 1 %.
//!
//! Sums of weights are 1 but for rounding. Where that would show, callers add differences from one of
//! the texels, so that a constant stays constant to the bit.

use crate::number::real::Real;

/// A separable kernel over TAPS texels along each side.
pub(crate) trait Kernel<const TAPS: usize>: Copy {
    /// The weights of the texels `1 - TAPS/2 … TAPS/2` from the left one.
    fn weights<R: Real>(t: R) -> [R; TAPS];
}

/// Catmull and Rom's cubic.
#[derive(Clone, Copy)]
pub(crate) struct CatmullRom;

impl Kernel<4> for CatmullRom {
    #[inline(always)]
    fn weights<R: Real>(t: R) -> [R; 4] {
        let (half, one) = (R::HALF, R::ONE);
        let s = one - t;
        let (tts, sst) = (t * t * s, s * s * t);
        let ends = [R::ZERO - half * sst, R::ZERO - half * tts];
        // s + t = 1: the inner two are 1 - t and t with what the outer two took put back.
        [ends[0], s + sst - half * tts, t + tts - half * sst, ends[1]]
    }
}

/// The cubic of Mitchell and Netravali with B = C = ⅓.
#[derive(Clone, Copy)]
pub(crate) struct Mitchell;

impl Kernel<4> for Mitchell {
    #[inline(always)]
    fn weights<R: Real>(t: R) -> [R; 4] {
        let near = |x: R| (R::new(7.0 / 6.0) * x - R::TWO) * x * x + R::new(8.0 / 9.0);
        let far = |x: R| {
            ((R::new(-7.0 / 18.0) * x + R::TWO) * x - R::new(10.0 / 3.0)) * x + R::new(16.0 / 9.0)
        };
        let one = R::ONE;
        [far(one + t), near(t), near(one - t), far(R::TWO - t)]
    }
}

/// The sinc function in Lanczos' window of three lobes.
#[derive(Clone, Copy)]
pub(crate) struct Lanczos3;

impl Kernel<6> for Lanczos3 {
    #[inline(always)]
    fn weights<R: Real>(t: R) -> [R; 6] {
        let (one, third) = (R::ONE, R::new(1.0 / 3.0));
        let (sine, _) = R::sin_cos_half_turns(t);
        let (s, c) = R::sin_cos_half_turns(t * third);
        let (half, root) = (R::HALF, R::new(0.75_f64.sqrt()));
        // sin(π(t + k)/3) for k = 1, 2; sin(π - x) = sin(x) gives those of k - t.
        let (s1, s2) = (s * half + c * root, c * root - s * half);
        let lobe = |x: R, wide: R| sine * wide / (x * x);
        // sin(πx) sin(πx/3)/x² without its 0/0, for x in [0, 1].
        let middle = |x: R| {
            let y = x * third;
            R::sinc_half_turns(x * x, x) * R::sinc_half_turns(y * y, y) * third
        };
        // sin(πx) alternates in sign from texel to texel; x is the distance from the place.
        let raw = [
            lobe(t + R::TWO, s2),
            R::ZERO - lobe(t + one, s1),
            middle(t),
            middle(one - t),
            R::ZERO - lobe(R::TWO - t, s1),
            lobe(R::new(3.0) - t, s),
        ];
        let sum = ((raw[0] + raw[1]) + (raw[2] + raw[3])) + (raw[4] + raw[5]);
        let scale = one / sum;
        raw.map(|w| w * scale)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::f64::consts::PI;

    fn check<const TAPS: usize, K: Kernel<TAPS>>(kernel: impl Fn(f64) -> f64, normal: bool) {
        for k in 0..=1000 {
            let t = f64::from(k) / 1000.0;
            let expected: Vec<f64> = (0..TAPS)
                .map(|i| kernel(i as f64 + 1.0 - (TAPS / 2) as f64 - t))
                .collect();
            let sum: f64 = expected.iter().sum();
            let got = K::weights(t);
            let single = K::weights(t as f32);
            for i in 0..TAPS {
                let expected = if normal {
                    expected[i] / sum
                } else {
                    expected[i]
                };
                // The papers' expanded cubics have terms up to 16, and round by some of their ε.
                assert!(
                    (got[i] - expected).abs() < 1e-14,
                    "{t} {i} {} {expected}",
                    got[i]
                );
                // A sinc near its zero is what is left of numbers near π: some eight ε.
                assert!((f64::from(single[i]) - expected).abs() < 1e-6, "{t} {i}");
            }
        }
    }

    fn cubic(b: f64, c: f64) -> impl Fn(f64) -> f64 {
        move |x: f64| {
            let x = x.abs();
            (if x < 1.0 {
                (12.0 - 9.0 * b - 6.0 * c) * x.powi(3) + (-18.0 + 12.0 * b + 6.0 * c) * x * x + 6.0
                    - 2.0 * b
            } else if x < 2.0 {
                (-b - 6.0 * c) * x.powi(3)
                    + (6.0 * b + 30.0 * c) * x * x
                    + (-12.0 * b - 48.0 * c) * x
                    + 8.0 * b
                    + 24.0 * c
            } else {
                0.0
            }) / 6.0
        }
    }

    #[test]
    fn weights_are_those_of_the_papers() {
        check::<4, CatmullRom>(cubic(0.0, 0.5), false);
        check::<4, Mitchell>(cubic(1.0 / 3.0, 1.0 / 3.0), false);
        let sinc = |x: f64| {
            if x == 0.0 {
                1.0
            } else {
                (PI * x).sin() / (PI * x)
            }
        };
        check::<6, Lanczos3>(
            |x| {
                if x.abs() < 3.0 {
                    sinc(x) * sinc(x / 3.0)
                } else {
                    0.0
                }
            },
            true,
        );
    }
}
