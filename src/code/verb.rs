//! What code can be printed for, and what its functions take and give. What they do is recorded in
//! [`crate::code::program`].

use crate::code::interface::{Argument, Gives, place_name};
use crate::map::Map;
use crate::projections::projection::Seam;

/// A verb that has code.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum Verb {
    /// A direction to image coordinates.
    Encode,
    /// Image coordinates to a direction.
    Decode,
    /// Steradians per unit of the image.
    Density,
    /// The derivatives of the direction by u and v.
    Jacobian,
    /// Whether a place lies in the valid image.
    Valid,
    /// What a view vector sees in a mirror: the direction to look up.
    Reflect,
    /// The texels of a bilinear lookup in a direction, and their weights, across seams.
    Taps,
}

impl Verb {
    /// All verbs.
    pub const ALL: [Verb; 7] = [
        Verb::Encode,
        Verb::Decode,
        Verb::Density,
        Verb::Jacobian,
        Verb::Valid,
        Verb::Reflect,
        Verb::Taps,
    ];

    /// The name of the verb.
    ///
    /// ```
    /// assert_eq!(spheremap::code::Verb::Encode.name(), "encode");
    /// ```
    pub fn name(self) -> &'static str {
        match self {
            Verb::Encode => "encode",
            Verb::Decode => "decode",
            Verb::Density => "density",
            Verb::Jacobian => "jacobian",
            Verb::Valid => "valid",
            Verb::Reflect => "reflect",
            Verb::Taps => "taps",
        }
    }

    /// What its function takes and gives, on a map with so many image coordinates.
    pub(super) fn signature(self, width: usize) -> (Vec<Argument>, Gives) {
        let place = vec![Argument::place(width)];
        match self {
            Verb::Encode => {
                let uv = Gives::Vector(width, place_name(width));
                (vec![Argument::DIRECTION], uv)
            }
            Verb::Decode => (place, Gives::Vector(3, "d")),
            Verb::Density => (place, Gives::Number),
            Verb::Jacobian => (place, Gives::Columns),
            Verb::Valid => (place, Gives::Truth),
            Verb::Reflect => (
                vec![
                    Argument::vector("view", &["x", "y", "z"]),
                    Argument::vector("normal", &["a", "b", "c"]),
                ],
                Gives::Vector(3, "d"),
            ),
            Verb::Taps => (
                vec![
                    Argument::DIRECTION,
                    Argument::vector("size", &["width", "height"]),
                ],
                Gives::Taps { apart: width > 2 },
            ),
        }
    }

    /// What its function is.
    pub(super) fn says(self, map: &Map) -> String {
        let apart = map.uv_width() > 2;
        let place = if apart { "(u, v, face)" } else { "(u, v)" };
        match self {
            Verb::Encode => format!("Direction to {place}."),
            Verb::Decode => format!("{place} of the valid image to a unit direction."),
            Verb::Density => format!("Steradians per unit of du dv at {place}."),
            Verb::Jacobian => {
                format!("The derivatives of the direction by u and by v at {place}.")
            }
            Verb::Valid => format!("Whether {place} lies in the valid image."),
            Verb::Reflect => "The direction that a mirror shows: of a view from the surface to the eye, and a normal that is not zero."
                .to_owned(),
            Verb::Taps => {
                let faces = if apart { "columns, rows and faces" } else { "columns and rows" };
                let size = match map.seam() {
                    _ if apart => "a face of that size",
                    Seam::Latlong => "an image of that size, with an even number of columns",
                    _ => "an image of that size",
                };
                format!("Texels of a bilinear lookup, across seams: {faces}, from 0, and weights; of {size}.")
            }
        }
    }
}
