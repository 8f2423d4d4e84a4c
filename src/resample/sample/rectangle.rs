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

/// Texels that are put together at a time.
pub(super) const LENGTH: usize = 64;

/// Calls `work` with each row of an area, at most [`LENGTH`] texels of it at a time, and with the number of their first.
///
/// What it calls is inlined where it says so: otherwise it has the lanes of no level.
#[inline(always)]
pub(super) fn each_part<O>(
    band: &mut [O],
    area: Rectangle,
    length: usize,
    mut work: impl FnMut(usize, &mut [O]),
) {
    for top in (0..length).step_by(area.columns) {
        let columns = area.columns.min(length - top);
        let start = area.start + top / area.columns * area.stride;
        let row = &mut band[start..][..columns];
        for (part, out) in row.chunks_mut(LENGTH).enumerate() {
            work(top + part * LENGTH, out);
        }
    }
}
