//! The value that covers most of the texel's solid angle: labels stay labels. `resample::area` does it.

use super::claims::{Claims, FilterInfo, Method};

/// The value that covers most of a texel; of equals, the smallest.
#[derive(Clone, Copy)]
pub struct Mode;

impl Claims for Mode {
    const INFO: FilterInfo = FilterInfo {
        name: "mode",
        also: &[],
        title: "Mode by solid angle",
        source: "majority resampling of label maps, as in GDAL's `mode`",
        takes: "what covers most of a texel; of equals, the smallest",
        summary: "labels, made smaller",
        method: Method::Area,
        support: None,
        interpolates: false,
        ringing: false,
        takes_labels: true,
        antialiased: false,
    };
}
