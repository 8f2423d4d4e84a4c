//! The cubic that Mitchell and Netravali recommend, (B, C) = (⅓, ⅓) of their family: softer than Catmull and Rom's,
//! hardly any ringing, and no interpolation.

use super::claims::{Claims, FilterInfo, Kernel, Lookup, Method, Visitor};
use crate::number::real::Real;

/// The cubic of Mitchell and Netravali with B = C = ⅓.
#[derive(Clone, Copy)]
pub struct Mitchell;

impl Claims for Mitchell {
    const INFO: FilterInfo = FilterInfo {
        name: "mitchell",
        also: &[],
        title: "Mitchell and Netravali's cubic",
        source: "Mitchell and Netravali, Reconstruction Filters in Computer Graphics, SIGGRAPH 1988",
        takes: "4×4 texels, softer",
        summary: "enlargements with hardly any ringing",
        method: Method::Lookup,
        support: Some(2.0),
        interpolates: false,
        ringing: true,
        takes_labels: false,
        antialiased: true,
    };
}

impl Lookup for Mitchell {
    fn visit<V: Visitor>(visitor: V) -> V::Output {
        visitor.separable::<Self, 4>()
    }
}

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

#[cfg(test)]
mod tests {
    use super::Mitchell;
    use crate::resample::filters::tests::{check_weights, cubic};

    #[test]
    fn weights_are_those_of_the_paper() {
        check_weights::<4, Mitchell>(cubic(1.0 / 3.0, 1.0 / 3.0), false);
    }
}
