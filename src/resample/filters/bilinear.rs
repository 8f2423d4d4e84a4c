//! Linear along u and along v, between the four texels around the place.

use super::claims::{Claims, FilterInfo, Lookup, Method, Visitor};

/// The four texels around the place.
#[derive(Clone, Copy)]
pub struct Bilinear;

impl Claims for Bilinear {
    const INFO: FilterInfo = FilterInfo {
        name: "bilinear",
        also: &[],
        title: "Bilinear",
        source: "B-spline of order 1",
        takes: "2×2 texels",
        summary: "nearly everything",
        method: Method::Lookup,
        support: Some(1.0),
        interpolates: true,
        ringing: false,
        takes_labels: false,
        antialiased: true,
    };
}

impl Lookup for Bilinear {
    fn visit<V: Visitor>(visitor: V) -> V::Output {
        visitor.bilinear()
    }
}
