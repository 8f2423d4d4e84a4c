//! Catmull and Rom's cubic: of the family of Mitchell and Netravali the one with (B, C) = (0, ½), which interpolates
//! and reproduces parabolas.

use super::claims::{Claims, FilterInfo, Kernel, Lookup, Method, Visitor};
use crate::number::real::Real;

/// Catmull and Rom's cubic.
#[derive(Clone, Copy)]
pub struct CatmullRom;

impl Claims for CatmullRom {
    const INFO: FilterInfo = FilterInfo {
        name: "catmull-rom",
        // What most programs call it.
        also: &["bicubic"],
        title: "Catmull and Rom's cubic",
        source: "Catmull and Rom, A Class of Local Interpolating Splines, 1974",
        takes: "4×4 texels, interpolating",
        summary: "sharp enlargements",
        method: Method::Lookup,
        support: Some(2.0),
        interpolates: true,
        ringing: true,
        takes_labels: false,
        antialiased: true,
    };
}

impl Lookup for CatmullRom {
    fn visit<V: Visitor>(visitor: V) -> V::Output {
        visitor.separable::<Self, 4>()
    }
}

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

#[cfg(test)]
mod tests {
    use super::CatmullRom;
    use crate::resample::filters::tests::{check_weights, cubic};

    #[test]
    fn weights_are_those_of_the_paper() {
        check_weights::<4, CatmullRom>(cubic(0.0, 0.5), false);
    }
}
