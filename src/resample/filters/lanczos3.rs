//! The sinc function in Lanczos' window of three lobes: sinc(x) sinc(x/3), divided by the sum of its six
//! weights, which alone differs from 1 by up to 1 %.

use super::claims::{Claims, FilterInfo, Kernel, Lookup, Method, Visitor};
use crate::number::math::{horner, polynomial};
use crate::number::real::{Real, SINGLE};

/// The sinc function in Lanczos' window of three lobes.
#[derive(Clone, Copy)]
pub struct Lanczos3;

impl Claims for Lanczos3 {
    const INFO: FilterInfo = FilterInfo {
        name: "lanczos3",
        also: &[],
        title: "Lanczos' windowed sinc, three lobes",
        source: "Duchon, Lanczos Filtering in One and Two Dimensions, 1979; Turkowski, Graphics Gems, 1990",
        takes: "6×6 texels, interpolating",
        summary: "the sharpest; rings at a sun",
        method: Method::Lookup,
        support: Some(3.0),
        interpolates: true,
        ringing: true,
        takes_labels: false,
        antialiased: true,
    };
}

impl Lookup for Lanczos3 {
    fn visit<V: Visitor>(visitor: V) -> V::Output {
        visitor.separable::<Self, 6>()
    }
}

/// Those of sin(πx/3)/(πx/3) by x²: its series, whose first term that is left out is 2e-17 for x up to 1.
const SINC: [f64; 10] = [
    1.0,
    -0.182_770_451_872_025_15,
    0.010_021_511_423_251_28,
    -0.000_261_662_310_181_185_5,
    3.985_344_889_141_107e-6,
    -3.973_108_834_113_742e-8,
    2.792_949_603_645_014e-10,
    -1.458_481_888_897_122_3e-12,
    5.880_163_100_313_791e-15,
    -1.885_473_801_623_789_3e-17,
];

/// sin(πx/3)/(πx/3) for x from 0 to 1.
#[inline(always)]
fn sinc_of_third<R: Real>(x: R) -> R {
    let s = x * x;
    let [a0, a1, a2, a3, a4, a5, a6, a7, a8, a9] = SINC.map(R::new);
    if R::epsilon() < SINGLE {
        polynomial!(s; a0, a1, a2, a3, a4, a5, a6, a7, a8, a9)
    } else {
        horner!(s; a0, a1, a2, a3, a4, a5)
    }
}

impl Kernel<6> for Lanczos3 {
    /// At distances x = t + k all weights have |sin(πx)| in common, and their sum divides it out. What is left, sin(πx/3)/x² with signs
    /// that alternate, is taken times t (1 - t) and the squares of the outer four distances, so that nothing is divided but by the sum. The
    /// sines are those of t and of 1 - t, and their sum: sin(π(t + 1)/3).
    #[inline(always)]
    fn weights<R: Real>(t: R) -> [R; 6] {
        let (one, two, three) = (R::ONE, R::TWO, R::new(3.0));
        let rest = one - t;
        let (near, far) = (sinc_of_third(t), sinc_of_third(rest));
        let (a, b) = (t * near, rest * far);
        let q = t * rest;
        // (1 + t)(2 - t) and (2 + t)(3 - t).
        let (inner, outer) = (q + two, q + R::new(6.0));
        let (inner, outer) = (inner * inner, outer * outer);
        let (left, right) = (one + t, two - t);
        let (beyond_left, beyond_right) = (two + t, three - t);
        let (both, middle) = (q * inner, inner * outer);
        let under = (R::ZERO - (a + b)) * (q * outer);
        let raw = [
            b * both * (beyond_right * beyond_right),
            under * (right * right),
            near * rest * middle,
            far * t * middle,
            under * (left * left),
            a * both * (beyond_left * beyond_left),
        ];
        let sum = ((raw[0] + raw[1]) + (raw[2] + raw[3])) + (raw[4] + raw[5]);
        let scale = one / sum;
        raw.map(|w| w * scale)
    }
}

#[cfg(test)]
mod tests {
    use super::Lanczos3;
    use crate::resample::filters::tests::check_weights;
    use std::f64::consts::PI;

    #[test]
    fn weights_are_those_of_the_windowed_sinc() {
        let sinc = |x: f64| {
            if x == 0.0 {
                1.0
            } else {
                (PI * x).sin() / (PI * x)
            }
        };
        let windowed = |x: f64| {
            if x.abs() < 3.0 {
                sinc(x) * sinc(x / 3.0)
            } else {
                0.0
            }
        };
        check_weights::<6, Lanczos3>(windowed, true);
    }
}
