//! What ffmpeg's v360 writes beside panoramas, cubes and balls: views, lenses, world maps and solids.

use super::{Convention, Known, programs};

/// What v360 writes under one of its names, with texels on centers; x right, y down, z forward.
const fn v360(kind: &'static str, note: &'static str) -> Convention {
    Convention {
        kind,
        name: "ffmpeg",
        axes: "+x +y +z",
        note,
        source: "ffmpeg, vf_v360",
        version: "ffmpeg 9.0.2",
        known: Known::Run,
        ..programs::FFMPEG
    }
}

/// One row for each map that v360 has, too.
pub const TABLE: &[Convention] = &[
    Convention {
        parameters: &[("fov", 180.0)],
        ..v360(
            "angular",
            "v360's `fisheye`, with its h_fov and v_fov at 180; other angles are `fov=`.",
        )
    },
    v360(
        "equisolid",
        "v360's `equisolid`, with its h_fov and v_fov at 180; other angles are `fov=`.",
    ),
    v360(
        "stereographic",
        "v360's `sg`, with its h_fov and v_fov at 180; other angles are `fov=`.",
    ),
    v360(
        "orthographic",
        "v360's `og`, with its h_fov and v_fov at 180.",
    ),
    v360(
        "perspective",
        "v360's `flat`, with its h_fov and v_fov at 90; other angles are `fov=`.",
    ),
    v360("octahedral", "v360's `octahedron`."),
    v360("lambert_cylindrical", "v360's `cylindricalea`."),
    Convention {
        axes: "-x +y -z",
        layout: Some("strip"),
        ..v360(
            "dual_fisheye",
            "v360's `dfisheye`: the left picture looks backward. Its h_fov and v_fov are `fov`.",
        )
    },
    v360("mercator", "v360's `mercator`."),
    v360("hammer", "v360's `hammer`."),
    v360("sinusoidal", "v360's `sinusoidal`."),
    Convention {
        axes: "+x -y -z",
        ..v360(
            "tetrahedral",
            "v360's `tetrahedron`: it looks backward, with up and down exchanged.",
        )
    },
];
