//! The elliptical weighted average of film renderers, in the two levels of a mip chain that the footprint's shorter axis lies
//! between. `resample::levels` does it.

use super::claims::{Claims, FilterInfo, Method};

/// The elliptical weighted average in two levels of a mip chain, by the footprint's shorter axis.
#[derive(Clone, Copy)]
pub struct Ewa;

impl Claims for Ewa {
    const INFO: FilterInfo = FilterInfo {
        name: "ewa",
        also: &[],
        title: "Elliptical weighted average",
        source: "Heckbert, Fundamentals of Texture Mapping and Image Warping, 1989",
        takes: "an ellipse in two levels of a mip chain, by the footprint's shorter axis",
        summary: "the look of a film renderer",
        method: Method::Mipmapped,
        support: None,
        interpolates: false,
        ringing: false,
        takes_labels: false,
        antialiased: false,
    };
}
