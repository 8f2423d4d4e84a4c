//! A Gaussian of σ = ½ texel, cut at two texels: e^(-2x²), as RenderMan has it by default. Soft, and without ringing.
//!
//! A texel at the distance d weighs e^(-2d²) divided by the sum over the four of its row, so that what is cut, 6·10⁻⁵ of the
//! whole beyond two texels, is shared among them. With y = 2t - 1, which runs from -1 to 1 between the middle two,
//! the four are as e⁻⁴ e^(-3y), e^(-y), e^y and e⁻⁴ e^(3y): one exponential, made of sinh and cosh
//! ([`Real::sinh_cosh`], 4 units in the last place), and no call into the platform's library. Both halves are mirror
//! images to the bit.

use super::claims::{Claims, FilterInfo, Kernel, Lookup, Method, Visitor};
use crate::number::real::Real;

/// A Gaussian of σ = ½ texel over 4 × 4 texels.
#[derive(Clone, Copy)]
pub struct Gaussian;

impl Claims for Gaussian {
    const INFO: FilterInfo = FilterInfo {
        name: "gaussian",
        also: &[],
        title: "Gaussian, σ = ½ texel",
        source: "RiGaussianFilter, The RenderMan Interface 3.2, 2000",
        takes: "4×4 texels, softest",
        summary: "no ringing at all; blurs",
        method: Method::Lookup,
        support: Some(2.0),
        interpolates: false,
        ringing: false,
        takes_labels: false,
        antialiased: true,
    };
}

impl Lookup for Gaussian {
    fn visit<V: Visitor>(visitor: V) -> V::Output {
        visitor.separable::<Self, 4>()
    }
}

impl Kernel<4> for Gaussian {
    #[inline(always)]
    fn weights<R: Real>(t: R) -> [R; 4] {
        // e⁻⁴
        let far = R::new(0.018_315_638_888_734_18);
        let (sinh, cosh) = (R::TWO * t - R::ONE).sinh_cosh();
        // e^(-y) and e^y: |y| ≤ 1, so that the difference loses three bits at most.
        let (left, right) = (cosh - sinh, cosh + sinh);
        let outer = [far * (left * left * left), far * (right * right * right)];
        let scale = R::ONE / ((left + right) + (outer[0] + outer[1]));
        [outer[0], left, right, outer[1]].map(|w| w * scale)
    }
}

#[cfg(test)]
mod tests {
    use super::Gaussian;
    use crate::resample::filters::claims::Kernel;
    use crate::resample::filters::tests::check_weights;

    #[test]
    fn weights_are_those_of_the_bell() {
        check_weights::<4, Gaussian>(|x| (-2.0 * x * x).exp(), true);
    }

    #[test]
    fn halves_are_mirror_images_to_the_bit() {
        for k in 0..=64 {
            let t = f64::from(k) / 64.0;
            let (mut weights, mirrored) = (Gaussian::weights(t), Gaussian::weights(1.0 - t));
            weights.reverse();
            assert_eq!(weights, mirrored);
        }
    }
}
