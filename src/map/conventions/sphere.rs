//! Mirror balls and paraboloids.

use super::{Convention, Known, programs};

/// Rows of `sphere` and `dual_paraboloid`.
pub const TABLE: &[Convention] = &[
    Convention {
        kind: "sphere",
        name: "opengl",
        axes: "+x -y +z",
        note: "As displayed: t counts up from the last row, so t = 1 - v.",
        source: "OpenGL specification, GL_SPHERE_MAP texture coordinate generation",
        version: "OpenGL 4.6 compatibility profile",
        ..programs::OPENGL
    },
    Convention {
        kind: "sphere",
        name: "d3d",
        axes: "+x -y -z",
        note: "Direct3D's effect: n = normalize(r + (0, 0, -1)), u = nx/2 + 1/2, v = -ny/2 + 1/2.",
        source: "Direct3D sphere-map effect",
        version: "Direct3D 9",
        ..programs::DIRECT3D
    },
    Convention {
        kind: "sphere",
        name: "directxtk",
        axes: "+x +y +z",
        note: "OpenGL's formula with v from the first row and not turned over: +y is down in the image.",
        source: "DirectXTK, EnvironmentMapEffect, sphere mapping",
        version: "DirectXTK, 2023",
        ..programs::DIRECTXTK
    },
    Convention {
        kind: "sphere",
        name: "blender",
        axes: "+x -z -y",
        note: "A photo of a ball that is looked at along +y: the world is mirrored in it, as in any mirror.",
        source: "Blender, Cycles mirror-ball mapping",
        version: "Blender 5.0.1",
        known: Known::Run,
        ..programs::BLENDER
    },
    Convention {
        kind: "sphere",
        name: "skylibs",
        axes: "+x -y -z",
        note: "The view from inside. Its own solid angles of this map sum to 1.77 times 4 pi.",
        source: "skylibs, envmap.projections",
        version: "skylibs 0.7.7",
        known: Known::Run,
        ..programs::SKYLIBS
    },
    Convention {
        kind: "sphere",
        name: "ffmpeg",
        axes: "+x +y +z",
        note: "v360's `ball` as it writes it; it reads texel corners. Its world has y down.",
        source: "ffmpeg, vf_v360",
        version: "ffmpeg 9.0.2",
        known: Known::Run,
        ..programs::FFMPEG
    },
    Convention {
        kind: "dual_paraboloid",
        name: "directxtk",
        axes: "+x +y +z",
        note: "Face 0 holds z > 0; face 1 is not flipped.",
        source: "DirectXTK, EnvironmentMapEffect, dual-parabola mapping",
        version: "DirectXTK, 2023",
        ..programs::DIRECTXTK
    },
];
