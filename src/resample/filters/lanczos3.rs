//! The sinc function in Lanczos' window of three lobes: sinc(x) sinc(x/3), divided by the sum of its six
//! weights, which alone differs from 1 by up to 1 %.

use super::claims::{Claims, FilterInfo, Kernel, Lookup, Method, Visitor};
use crate::number::real::Real;

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
