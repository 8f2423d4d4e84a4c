//! Light probes and equidistant skies.

use super::{Convention, Known, programs};

/// Rows of `angular`.
pub const TABLE: &[Convention] = &[
    Convention {
        kind: "angular",
        name: "debevec",
        axes: "+x -y -z",
        note: "Center -z, unmirrored: the reading of the gallery's two sentences that real light probes fit.",
        source: "Debevec, Light Probe Image Gallery",
        version: "the gallery of 1998",
        ..programs::PROBES
    },
    Convention {
        kind: "angular",
        name: "openimageio",
        axes: "+x -y +z",
        note: "The gallery's second sentence taken literally, center +z: real probes come out mirrored.",
        source: "OpenImageIO, maketx --lightprobe",
        version: "OpenImageIO 3.2.2",
        known: Known::Run,
        ..programs::OPENIMAGEIO
    },
    Convention {
        kind: "angular",
        name: "skylibs",
        axes: "+x -y -z",
        note: "The same as Debevec's.",
        source: "skylibs, envmap.projections",
        version: "skylibs 0.7.7",
        known: Known::Run,
        ..programs::SKYLIBS
    },
    Convention {
        kind: "angular",
        name: "skylibs-skyangular",
        axes: "+x -z +y",
        parameters: &[("fov", 180.0)],
        note: "The upper half of the sky: zenith in the middle, horizon on the rim, +z at the top.",
        source: "skylibs, envmap.projections",
        version: "skylibs 0.7.7",
        known: Known::Run,
        ..programs::SKYLIBS
    },
    Convention {
        kind: "angular",
        name: "hugin",
        axes: "+x +y +z",
        parameters: &[("fov", 180.0)],
        note: "Its fisheye, at a field of view of 180; other angles are `fov=`.",
        source: "Hugin, PanoToolsTransformGPU.cpp, erect_sphere_tp; libpano13, math.c",
        version: "Hugin, b345d9d",
        ..programs::HUGIN
    },
];
