//! The frame in which two images are looked at: that of the source.

use crate::map::Map;
use glam::DMat3;

/// The matrix from the target's view frame to the source's.
///
/// The target is turned by a hair about an axis of no symmetry. Edges of the two images that would lie on
/// each other, as those of a latlong and a cube do, then cross instead, and rounding does not decide
/// again and again on which side of a seam a place lies. The turn moves light by 1e-9 of a texel
/// at 4096 columns, and loses none.
pub(super) fn frame(source: &Map, target: &Map, rotation: Option<DMat3>) -> [[f64; 3]; 3] {
    const HAIR: [f64; 3] = [0.61e-11, -0.53e-11, 0.29e-11];
    let [x, y, z] = HAIR;
    turn(
        source,
        target,
        rotation,
        [[1.0, z, -y], [-z, 1.0, x], [y, -x, 1.0]],
    )
}

/// The rows of the matrix from these axes of the target's view frame to the source's.
pub(super) fn turn(
    source: &Map,
    target: &Map,
    rotation: Option<DMat3>,
    axes: [[f64; 3]; 3],
) -> [[f64; 3]; 3] {
    let (into, from) = (
        source.view_rotation(rotation),
        target.view_rotation(None).inverse(),
    );
    let columns = axes.map(|axis| into.apply(from.apply(axis)));
    [0, 1, 2].map(|row| [0, 1, 2].map(|column| columns[column][row]))
}
