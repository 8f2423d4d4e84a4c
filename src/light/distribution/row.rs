//! Where a row of the grid lies in the image.

/// A row of cells.
#[derive(Clone, Copy, Debug)]
pub(super) struct Row {
    pub v0: f64,
    pub v1: f64,
    pub face: f64,
    /// Its first texel.
    pub texel: usize,
}
