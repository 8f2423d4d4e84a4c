//! What graphics hardware does: bilinear lookups in the two levels of a mip chain that the longer side of the footprint lies
//! between. `resample::levels` does it.

use super::claims::{Claims, FilterInfo, Method};

/// Bilinear in two levels of a mip chain, by the footprint's longer side.
#[derive(Clone, Copy)]
pub struct Trilinear;

impl Claims for Trilinear {
    const INFO: FilterInfo = FilterInfo {
        name: "trilinear",
        also: &[],
        title: "Trilinear in a mip chain",
        source: "Williams, Pyramidal Parametrics, SIGGRAPH 1983",
        takes: "two levels of a mip chain, by the footprint's longer side",
        summary: "the look of a game engine; never aliases",
        method: Method::Mipmapped,
        support: None,
        interpolates: false,
        ringing: false,
        takes_labels: false,
        antialiased: false,
    };
}
