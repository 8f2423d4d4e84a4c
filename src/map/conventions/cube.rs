//! Cube maps: one table of faces in hardware, and every way to put six squares into a picture.

use super::{Convention, Known, programs};
use crate::map::grid::Grid;
use crate::projections::faces::FaceTable;

/// +x -x +y -y +z -z where the world's -z is in front.
const FRONT_IS_MINUS_Z: FaceTable = FaceTable::ordered(&[0, 1, 2, 3, 5, 4]);
/// F R B L U D, as panorama tools store them.
const FRBLUD: FaceTable = FaceTable::ordered(&[1, 3, 4, 5, 0, 2]);

/// The table of graphics hardware in a program's world.
const fn hardware(program: Convention) -> Convention {
    Convention {
        kind: "cube",
        axes: "+x -y +z",
        ..program
    }
}
const DIRECTXTEX: Convention = Convention {
    source: "DirectXTex, texassemble",
    version: "DirectXTex, 2024",
    ..hardware(programs::DIRECT3D)
};
const FFMPEG: Convention = Convention {
    kind: "cube",
    axes: "+x +y +z",
    source: "ffmpeg, vf_v360",
    version: "ffmpeg 9.0.2",
    known: Known::Run,
    ..programs::FFMPEG
};
const PY360CONVERT: Convention = Convention {
    grid: Grid::Corners,
    faces: Some(FRBLUD),
    source: "py360convert, utils.xyzcube",
    version: "py360convert 1.0.4",
    known: Known::Run,
    ..hardware(programs::PY360CONVERT)
};
const EQUILIB: Convention = Convention {
    kind: "cube",
    axes: "+y -z +x",
    faces: Some(FRBLUD),
    source: "pyequilib, numpy_utils.create_xyz_grid",
    version: "pyequilib 0.6.0",
    ..programs::EQUILIB
};

/// Rows of `cube`.
pub const TABLE: &[Convention] = &[
    Convention {
        name: "opengl",
        note: "Faces +x -x +y -y +z -z, t down in memory; the picture of each face is mirrored from inside.",
        source: "OpenGL specification, table 8.19",
        version: "OpenGL 4.6",
        ..hardware(programs::OPENGL)
    },
    Convention {
        name: "d3d",
        note: "The same table as OpenGL's; Direct3D's left-handed world sees it unmirrored.",
        source: "Direct3D 11 functional specification, cube-map face selection",
        version: "Direct3D 11.3",
        ..hardware(programs::DIRECT3D)
    },
    Convention {
        name: "vulkan",
        note: "The same table as OpenGL's.",
        source: "Vulkan specification, cube map face selection",
        version: "Vulkan 1.3",
        ..hardware(programs::VULKAN)
    },
    Convention {
        name: "openexr",
        axes: "+x -y -z",
        grid: Grid::Corners,
        layout: Some("column"),
        faces: Some(FRONT_IS_MINUS_Z),
        note: "OpenGL's table with z negated, so that no face is mirrored; texels lie on the edges.",
        source: "OpenEXR, ImfEnvmap, CubeMap",
        version: "OpenEXR 3.1.5",
        known: Known::Run,
        ..hardware(programs::OPENEXR)
    },
    Convention {
        name: "nvdiffrast",
        note: "OpenGL's table; texel rows as in memory.",
        source: "nvdiffrast, texture.cu, boundary mode cube",
        version: "nvdiffrast 0.3",
        ..hardware(programs::NVIDIA)
    },
    Convention {
        name: "threejs",
        axes: "-x -y +z",
        note: "Six images px nx py ny pz nz, looked up with x negated: px shows what lies toward -x, unmirrored.",
        source: "three.js, flipEnvMap of a CubeTexture",
        version: "three.js r150 and later",
        ..hardware(programs::THREEJS)
    },
    Convention {
        name: "filament",
        layout: Some("cross"),
        note: "The horizontal cross, +z in the middle; mirrored in Filament's world, which cmgen undoes.",
        source: "Filament, libs/ibl, CubemapUtils",
        version: "Filament 1",
        ..hardware(programs::FILAMENT)
    },
    Convention {
        name: "filament-vertical-cross",
        layout: Some("vertical_cross"),
        note: "-z at the bottom, turned by half a turn.",
        source: "Filament, libs/ibl, CubemapUtils",
        version: "Filament 1",
        ..hardware(programs::FILAMENT)
    },
    Convention {
        name: "cmft",
        note: "OpenGL's table.",
        source: "cmft, texelCoordToVec",
        version: "cmft 1",
        ..hardware(programs::BGFX)
    },
    Convention {
        name: "bimg",
        note: "OpenGL's table.",
        source: "bimg, texelUvToDir",
        version: "bimg, 2023",
        ..hardware(programs::BGFX)
    },
    Convention {
        name: "unity",
        note: "Direct3D's table in a left-handed world with y up.",
        source: "Unity manual, cubemaps; its shaders sample with the world's direction",
        version: "Unity 2017 and later",
        ..hardware(programs::UNITY)
    },
    Convention {
        name: "unreal",
        note: "Direct3D's table looked up with the world's direction: face +z is up, +x ahead.",
        source: "Unreal Engine, TextureCompressorModule, TransformSideToWorldSpace",
        version: "Unreal Engine 5",
        ..hardware(programs::UNREAL)
    },
    Convention {
        name: "skylibs",
        axes: "+x -y -z",
        layout: Some("vertical_cross"),
        note: "-z in the middle; back, at the bottom, is turned by half a turn.",
        source: "skylibs, envmap.projections",
        version: "skylibs 0.7.7",
        known: Known::Run,
        ..hardware(programs::SKYLIBS)
    },
    Convention {
        name: "py360convert-horizon",
        layout: Some("strip"),
        note: "F R B L U D in a row, as e2c writes them; c2e reads them up to a texel off.",
        ..PY360CONVERT
    },
    Convention {
        name: "py360convert-dice",
        layout: Some("dice"),
        note: "U and D over and under F in the row L F R B.",
        ..PY360CONVERT
    },
    Convention {
        name: "py360convert-list",
        note: "F R B L U D one after the other; the dict has the same six under these letters.",
        ..PY360CONVERT
    },
    Convention {
        name: "equilib-horizon",
        layout: Some("strip"),
        note: "F R B L U D in a row, F toward +x.",
        ..EQUILIB
    },
    Convention {
        name: "equilib-dice",
        layout: Some("dice"),
        note: "U and D over and under F in the row L F R B.",
        ..EQUILIB
    },
    Convention {
        name: "equilib-list",
        note: "F R B L U D one after the other; the dict has the same six under these letters.",
        ..EQUILIB
    },
    Convention {
        name: "ffmpeg-c3x2",
        layout: Some("3x2"),
        note: "v360's `c3x2`: right, left, up over down, front, back.",
        ..FFMPEG
    },
    Convention {
        name: "ffmpeg-c6x1",
        layout: Some("strip"),
        note: "v360's `c6x1`: right, left, up, down, front, back in a row.",
        ..FFMPEG
    },
    Convention {
        name: "ffmpeg-c1x6",
        layout: Some("column"),
        note: "v360's `c1x6`: the same, one below the other.",
        ..FFMPEG
    },
    Convention {
        name: "directxtex-h-cross",
        layout: Some("cross"),
        note: "+y over +z in the row -x +z +x -z.",
        ..DIRECTXTEX
    },
    Convention {
        name: "directxtex-v-cross",
        layout: Some("vertical_cross_upright"),
        note: "-z at the bottom as it is, not turned.",
        ..DIRECTXTEX
    },
    Convention {
        name: "directxtex-v-cross-fnz",
        layout: Some("vertical_cross"),
        note: "-z at the bottom, turned by half a turn.",
        ..DIRECTXTEX
    },
    Convention {
        name: "directxtex-h-tee",
        layout: Some("tee"),
        note: "+y over +z in the row +z +x -z -x.",
        ..DIRECTXTEX
    },
    Convention {
        name: "directxtex-h-strip",
        layout: Some("strip"),
        note: "+x -x +y -y +z -z in a row.",
        ..DIRECTXTEX
    },
    Convention {
        name: "directxtex-v-strip",
        layout: Some("column"),
        note: "+x -x +y -y +z -z one below the other.",
        ..DIRECTXTEX
    },
    Convention {
        name: "ktx",
        note: "KTX 2: the hardware's table, which its text calls left-handed; every face is `rd`, from the top left.",
        source: "KTX File Format Specification, faceCount and Cubemap Orientation",
        version: "KTX 2.0",
        ..hardware(programs::KTX)
    },
    Convention {
        name: "bevy",
        axes: "+x -y -z",
        note: "Six layers looked up with z negated: layer 4, the hardware's +z, shows what lies toward -z, unmirrored.",
        source: "Bevy, skybox.wesl and environment_map.wesl",
        version: "Bevy, 76ccb61",
        ..hardware(programs::BEVY)
    },
    Convention {
        name: "babylonjs",
        note: "Direct3D's table in a left-handed world. Its six files are px py pz nx ny nz, in another order.",
        source: "Babylon.js, reflectionFunction and engine.cubeTexture",
        version: "Babylon.js 9.34.0",
        ..hardware(programs::BABYLONJS)
    },
    Convention {
        name: "playcanvas",
        axes: "-x -y +z",
        note: "Six images px nx py ny pz nz, looked up with x negated: px shows what lies toward -x, unmirrored.",
        source: "PlayCanvas, shader chunks skybox and reflectionCube",
        version: "PlayCanvas 2.23.3",
        ..hardware(programs::PLAYCANVAS)
    },
];
