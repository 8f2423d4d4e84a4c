//! Conservative remapping: the mean of the source over the texel's own solid angle. `resample::area` does it.

use super::claims::{Claims, FilterInfo, Method};

/// The mean of what a texel covers, by solid angle.
#[derive(Clone, Copy)]
pub struct Area;

impl Claims for Area {
    const INFO: FilterInfo = FilterInfo {
        name: "area",
        also: &[],
        title: "Mean by solid angle",
        source: "Jones, First- and Second-Order Conservative Remapping Schemes, 1999",
        takes: "all that a texel covers, by solid angle",
        summary: "light: Σ L·dω is kept exactly",
        method: Method::Area,
        support: None,
        interpolates: false,
        ringing: false,
        takes_labels: false,
        antialiased: false,
    };
}
