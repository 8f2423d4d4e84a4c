//! Where a tile of lookups is put.

/// The rectangle of a band of stored texels that a tile of lookups fills, row by row.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Rectangle {
    /// Its first texel.
    pub(crate) start: usize,
    /// Texels in a row; at least one.
    pub(crate) columns: usize,
    /// Texels from one row to the next.
    pub(crate) stride: usize,
}

/// Calls `work` with each row of an area, and the number of its first texel.
#[inline(always)]
pub(super) fn each_row<O>(
    band: &mut [O],
    area: Rectangle,
    length: usize,
    mut work: impl FnMut(usize, &mut [O]),
) {
    for top in (0..length).step_by(area.columns) {
        let columns = area.columns.min(length - top);
        let start = area.start + top / area.columns * area.stride;
        work(top, &mut band[start..][..columns]);
    }
}
