//! What code can be printed for.

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
}

impl Verb {
    /// All verbs.
    pub const ALL: [Verb; 5] = [
        Verb::Encode,
        Verb::Decode,
        Verb::Density,
        Verb::Jacobian,
        Verb::Valid,
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
        }
    }
}
