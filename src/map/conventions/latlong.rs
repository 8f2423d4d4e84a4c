//! Panoramas: everyone has the same angles, and nearly everyone other axes.

use super::{Convention, Known, programs};
use crate::map::grid::Grid;

/// Rows of `latlong`.
pub const TABLE: &[Convention] = &[
    Convention {
        kind: "latlong",
        name: "mitsuba",
        axes: "-x -y +z",
        grid: Grid::CornersV,
        note: "Rows lie on the poles: row 0 at theta = 0, the last at theta = pi.",
        source: "mitsuba 3, envmap emitter",
        version: "mitsuba 3.9.1",
        known: Known::Run,
        ..programs::MITSUBA
    },
    Convention {
        kind: "latlong",
        name: "openimageio",
        axes: "-x -y +z",
        note: "y up, files without oiio:sampleborder (.tif, .tx); its lookups clamp at the poles.",
        source: "OpenImageIO, TextureSystem::environment",
        version: "OpenImageIO 3.2.2",
        known: Known::Run,
        ..programs::OPENIMAGEIO
    },
    Convention {
        kind: "latlong",
        name: "openimageio-sampleborder",
        axes: "-x -y +z",
        grid: Grid::Corners,
        note: "y up, files with oiio:sampleborder, as every .exr that maketx writes.",
        source: "OpenImageIO, TextureSystem::environment",
        version: "OpenImageIO 3.2.2",
        known: Known::Run,
        ..programs::OPENIMAGEIO
    },
    Convention {
        kind: "latlong",
        name: "openimageio-z-up",
        axes: "+y -z +x",
        note: "With the attribute latlong_up = \"z\"; mirrored, as its y-up map is not.",
        source: "OpenImageIO, TextureSystem::environment",
        version: "OpenImageIO 3.2.2",
        known: Known::Run,
        ..programs::OPENIMAGEIO_Z_UP
    },
    Convention {
        kind: "latlong",
        name: "openexr",
        axes: "-x -y +z",
        grid: Grid::Corners,
        note: "An .exr with envmap = latlong: the first and last columns show the same meridian.",
        source: "OpenEXR, ImfEnvmap, LatLongMap",
        version: "OpenEXR 3.1.5",
        known: Known::Run,
        ..programs::OPENEXR
    },
    Convention {
        kind: "latlong",
        name: "pbrt",
        axes: "-y -z -x",
        note: "u = 0 is +x. Read from the math; pbrt-v4 itself wants its environment lights equal-area.",
        source: "pbrt-v4, SphericalTheta and SphericalPhi, imgtool makeequiarea",
        version: "pbrt-v4",
        ..programs::PBRT
    },
    Convention {
        kind: "latlong",
        name: "blender",
        axes: "-y -z +x",
        note: "Center +x, -y to the right.",
        source: "Blender, Cycles equirectangular mapping",
        version: "Blender 5.0.1",
        known: Known::Run,
        ..programs::BLENDER
    },
    Convention {
        kind: "latlong",
        name: "threejs",
        axes: "+z -y +x",
        note: "Center +x, +z to the right. Textures are flipped on upload, so row 0 is the top.",
        source: "three.js, equirectUv",
        version: "three.js r150 and later",
        ..programs::THREEJS
    },
    Convention {
        kind: "latlong",
        name: "gltf",
        axes: "+z -y +x",
        note: "The guideline for panoramas of glTF viewers: the same as three.js.",
        source: "Khronos glTF sample viewer, panorama_to_cubemap",
        version: "glTF 2.0",
        ..programs::GLTF
    },
    Convention {
        kind: "latlong",
        name: "nvdiffrec",
        axes: "+x -y -z",
        note: "Center -z, +x to the right.",
        source: "nvdiffrec, render/util.py, latlong_to_cubemap",
        version: "nvdiffrec, 2022",
        ..programs::NVIDIA
    },
    Convention {
        kind: "latlong",
        name: "ict",
        axes: "+x -y -z",
        note: "The high-resolution probes of USC-ICT.",
        source: "USC-ICT, High-Resolution Light Probe Image Gallery",
        version: "the gallery",
        ..programs::PROBES
    },
    Convention {
        kind: "latlong",
        name: "skylibs",
        axes: "+x -y -z",
        note: "Center -z, unmirrored; its lookups clamp at the seam.",
        source: "skylibs, envmap.projections",
        version: "skylibs 0.7.7",
        known: Known::Run,
        ..programs::SKYLIBS
    },
    Convention {
        kind: "latlong",
        name: "filament",
        axes: "+x -y +z",
        grid: Grid::Corners,
        note: "As libs/ibl reads it, in a left-handed world; cmgen then mirrors x, unless told --no-mirror.",
        source: "Filament, libs/ibl, CubemapUtils::equirectangularToCubemap",
        version: "Filament 1",
        ..programs::FILAMENT
    },
    Convention {
        kind: "latlong",
        name: "cmft",
        axes: "+x -y +z",
        note: "The same angles as Filament's.",
        source: "cmft, latLongFromVec",
        version: "cmft 1",
        ..programs::BGFX
    },
    Convention {
        kind: "latlong",
        name: "bimg",
        axes: "+x -y +z",
        grid: Grid::Corners,
        note: "cmft's angles on texel corners.",
        source: "bimg, imageCubemapFromLatLongRgba32F",
        version: "bimg, 2023",
        ..programs::BGFX
    },
    Convention {
        kind: "latlong",
        name: "py360convert",
        axes: "+x -y +z",
        note: "Its panorama has texel centers, its faces and views have corners.",
        source: "py360convert, utils.xyz2uv and uv2coor",
        version: "py360convert 1.0.4",
        known: Known::Run,
        ..programs::PY360CONVERT
    },
    Convention {
        kind: "latlong",
        name: "equilib",
        axes: "+y -z +x",
        note: "As equi2cube reads it; equi2equi at no rotation shifts the picture by half a texel each way. \
               Its manual says right-handed; its pictures have +y to the right of +x.",
        source: "pyequilib, equi2cube.numpy.convert_grid",
        version: "pyequilib 0.6.0",
        ..programs::EQUILIB
    },
    Convention {
        kind: "latlong",
        name: "ffmpeg",
        axes: "+x +y +z",
        grid: Grid::Corners,
        note: "v360's `e` as it reads it. It writes texel centers, so `e` to `e` is not the identity.",
        source: "ffmpeg, vf_v360",
        version: "ffmpeg 9.0.2",
        known: Known::Run,
        ..programs::FFMPEG
    },
    Convention {
        kind: "latlong",
        name: "ffmpeg-output",
        axes: "+x +y +z",
        note: "v360's `e` as it writes it: on texel centers.",
        source: "ffmpeg, vf_v360",
        version: "ffmpeg 9.0.2",
        known: Known::Run,
        ..programs::FFMPEG
    },
    Convention {
        kind: "latlong",
        name: "unity",
        axes: "-z -y +x",
        note: "Center +x, -z to the right, which is not mirrored in Unity's left-handed world.",
        source: "Unity built-in shader Skybox/Panoramic, ToRadialCoords",
        version: "Unity 2017 and later",
        ..programs::UNITY
    },
    Convention {
        kind: "latlong",
        name: "unreal",
        axes: "+x -z -y",
        note: "Center -y, +x to the right. Its importer reads texel i at u = i/W, half a texel off this grid.",
        source: "Unreal Engine, TextureCompressorModule, LookupLongLatDouble",
        version: "Unreal Engine 5",
        ..programs::UNREAL
    },
    Convention {
        kind: "latlong",
        name: "usd",
        axes: "-x -y +z",
        note: "A DomeLight, on a stage with either axis up. Its text quotes OpenEXR's, texels on corners; Storm has centers.",
        source: "OpenUSD, usdLux schema, DomeLight; Storm, surfaceHelpers.glslfx, ProjectToLatLong",
        version: "OpenUSD 26.11",
        ..programs::USD
    },
    Convention {
        kind: "latlong",
        name: "usd-z-up",
        axes: "-x -z -y",
        note: "A DomeLight_1 on a stage with +z up, or with poleAxis Z: center -y.",
        source: "OpenUSD, usdLux schema, DomeLight_1",
        version: "OpenUSD 26.11",
        ..programs::USD_Z_UP
    },
    Convention {
        kind: "latlong",
        name: "godot",
        axes: "-x -y +z",
        note: "PanoramaSkyMaterial, and SKY_COORDS: center +z, behind. Its shader approximates the angles to 0.52°.",
        source: "Godot, sky.glsl, panorama_coords",
        version: "Godot 4, 0095d7d",
        ..programs::GODOT
    },
    Convention {
        kind: "latlong",
        name: "babylonjs",
        axes: "+x -y +z",
        note: "HDRCubeTexture, EquiRectangularCubeTexture; they read texel i at u = i/W, half a texel off this grid.",
        source: "Babylon.js, PanoramaToCubeMapTools",
        version: "Babylon.js 9.34.0",
        ..programs::BABYLONJS
    },
    Convention {
        kind: "latlong",
        name: "playcanvas",
        axes: "-x -y +z",
        note: "Looked up with x negated, as its cubes: center +z, unmirrored.",
        source: "PlayCanvas, shader chunks skybox, spherical and reproject",
        version: "PlayCanvas 2.23.3",
        ..programs::PLAYCANVAS
    },
    Convention {
        kind: "latlong",
        name: "hugin",
        axes: "+x +y +z",
        note: "Yaw to the right, pitch up; Panorama Tools has y down, as images have.",
        source: "Hugin, PanoToolsTransformGPU.cpp, erect_sphere_tp; libpano13, math.c",
        version: "Hugin, b345d9d",
        ..programs::HUGIN
    },
    Convention {
        kind: "latlong",
        name: "colmap",
        axes: "+x +y +z",
        note: "The camera model EQUIRECTANGULAR; pixels count from the corner of the first, and a pose takes the world to it.",
        source: "COLMAP, sensor/models.h, EquirectangularCameraModel",
        version: "pycolmap 4.2.1",
        known: Known::Run,
        ..programs::COLMAP
    },
];
