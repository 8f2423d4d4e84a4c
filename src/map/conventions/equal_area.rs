//! Maps of equal or nearly equal areas: pbrt's square, 360-degree video, S2, Lambert's map in PROJ.

use super::{Convention, Known, programs};
use crate::projections::faces::{FaceTable, Orientation};

const fn turned(swap: bool, flip_u: bool, flip_v: bool) -> Orientation {
    Orientation {
        swap,
        flip_u,
        flip_v,
    }
}

/// Left, front, right over down, back, up; those of the lower row lie on their sides.
const VIDEO: FaceTable = {
    let mut table = FaceTable::ordered(&[2, 0, 5, 3, 1, 4]);
    table.orientation[2] = turned(true, false, true);
    table.orientation[3] = turned(true, false, true);
    table.orientation[5] = turned(true, true, false);
    table
};

/// S2 numbers +x +y +z -x -y -z; s and t of each face in its own right-handed frame.
const S2: FaceTable = {
    let mut table = FaceTable::ordered(&[0, 3, 4, 1, 2, 5]);
    table.orientation[0] = turned(true, false, true);
    table.orientation[1] = Orientation::TURNED;
    table.orientation[2] = turned(true, true, false);
    table.orientation[3] = Orientation::TURNED;
    table.orientation[4] = Orientation::TURNED;
    table.orientation[5] = turned(true, false, true);
    table
};

const S2_CELLS: Convention = Convention {
    kind: "cube_quadratic",
    name: "s2",
    axes: "+x +y +z",
    faces: Some(S2),
    note: "u = s, v = t, S2's face numbers; its latitudes and longitudes have z up.",
    source: "S2 geometry library, s2coords.h",
    version: "s2sphere 0.2.5",
    known: Known::Run,
    ..programs::S2
};

/// Rows of `equal_area`, `cube_equiangular`, `cube_quadratic` and `equisolid`.
pub const TABLE: &[Convention] = &[
    Convention {
        kind: "equal_area",
        name: "pbrt",
        axes: "+x +y +z",
        note: "What pbrt-v4 wants of environment lights. Its own encoder's polynomial is off by 6e-6 rad.",
        source: "pbrt-v4, EqualAreaSquareToSphere",
        version: "pbrt-v4",
        ..programs::PBRT
    },
    Convention {
        kind: "cube_equiangular",
        name: "ffmpeg-eac",
        axes: "+x +y +z",
        layout: Some("3x2"),
        faces: Some(VIDEO),
        note: "v360's `eac`, 360-degree video: left, front, right over down, back, up, the lower row on its \
               side. v360 takes 2 texels at the ends of each row for padding, which belong to no map.",
        source: "ffmpeg, vf_v360, eac_to_xyz",
        version: "ffmpeg 9.0.2",
        known: Known::Run,
        ..programs::FFMPEG
    },
    Convention {
        kind: "cube_equiangular",
        name: "s2-tangent",
        note: "S2_TAN_PROJECTION: the tangent warp in S2's face numbers and frames.",
        version: "S2 geometry library, 2024",
        known: Known::Read,
        ..S2_CELLS
    },
    S2_CELLS,
];
