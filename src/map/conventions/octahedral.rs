//! Unit vectors on an octahedron. Here a row is about axes alone: the number of bits and how they round
//! belong to the packed formats.

use super::{Convention, Known, programs};

/// Rows of `octahedral` and `hemioctahedral`.
pub const TABLE: &[Convention] = &[
    Convention {
        kind: "octahedral",
        name: "unreal",
        axes: "+x +y +z",
        note: "Folds at z <= 0 where others fold at z < 0: on the fold both are the same point.",
        source: "Unreal Engine shaders, UnitVectorToOctahedron",
        version: "Unreal Engine 5",
        ..programs::UNREAL
    },
    Convention {
        kind: "octahedral",
        name: "meshoptimizer",
        axes: "+x +y +z",
        note: "The filter stores p = 2u - 1 and q = 2v - 1 as signed integers, round(p (2^(bits-1) - 1)).",
        source: "meshoptimizer, decodeFilterOct",
        version: "meshoptimizer 0.2.30a0",
        known: Known::Run,
        ..programs::VECTORS
    },
    Convention {
        kind: "octahedral",
        name: "draco",
        axes: "+y +z +x",
        note: "x is the pole. Quantized on an odd grid of 2^bits - 1 points, whose middle is +x; \
               only this grid is run, the pole does not show in what comes out.",
        source: "Draco, OctahedronToolBox",
        version: "Draco 1.5, DracoPy 2.2.0",
        ..programs::VECTORS
    },
    Convention {
        kind: "hemioctahedral",
        name: "unreal",
        axes: "+x +y +z",
        note: "(x + y, x - y) after the projection.",
        source: "Unreal Engine shaders, UnitVectorToHemiOctahedron",
        version: "Unreal Engine 5",
        ..programs::UNREAL
    },
];
