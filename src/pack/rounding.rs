//! The ways to round.

/// How to choose among the lattice points about a place.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Rounding {
    /// Each coordinate by itself.
    Nearest,
    /// The nearest on the sphere, among the corners of the cell.
    Precise,
    /// The nearest in the plane of the octahedron's face.
    Hex,
}
