//! The texel that holds the place: the only lookup whose results are values of the image.

use super::claims::{Claims, FilterInfo, Lookup, Method, Visitor};

/// The texel that holds the place.
#[derive(Clone, Copy)]
pub struct Nearest;

impl Claims for Nearest {
    const INFO: FilterInfo = FilterInfo {
        name: "nearest",
        also: &[],
        title: "Nearest neighbor",
        source: "B-spline of order 0",
        takes: "the texel that holds the place",
        summary: "labels, exact values",
        method: Method::Lookup,
        support: Some(0.5),
        interpolates: true,
        ringing: false,
        takes_labels: true,
        // A mean of labels is no label.
        antialiased: false,
    };
}

impl Lookup for Nearest {
    fn visit<V: Visitor>(visitor: V) -> V::Output {
        visitor.nearest()
    }
}
