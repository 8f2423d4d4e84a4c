//! The worlds of programs: what is up, what lies ahead, and which hand x, y, z are.
//!
//! A row says where its program's directions lie in an image; what the program means by them is its world, and the same for all its
//! rows. Ahead is what a camera of the program looks along that nobody has turned. A program without cameras has ahead what the
//! middle column of its panoramas shows. One that only turns pictures into pictures has the hand in which its own pictures are not
//! mirrored, whatever its manual calls it.

use super::{Convention, ROW};
use crate::geometry::world::World;

const fn program(world: World, ahead: &'static str) -> Convention {
    Convention {
        world,
        ahead,
        ..ROW
    }
}

pub(super) const OPENGL: Convention = program(World::OURS, "its eye looks along -z");
pub(super) const GLTF: Convention = program(World::OURS, "a camera node looks along -z");
pub(super) const VULKAN: Convention = program(
    World::OURS,
    "no world of its own; as OpenGL's programs have it",
);
pub(super) const THREEJS: Convention = program(World::OURS, "a camera looks along -z");
pub(super) const PLAYCANVAS: Convention = program(World::OURS, "a camera looks along -z");
pub(super) const GODOT: Convention = program(World::OURS, "a Camera3D looks along -z");
pub(super) const BEVY: Convention =
    program(World::OURS, "Transform::forward, what a camera looks along");
pub(super) const USD: Convention = program(World::OURS, "a UsdGeomCamera looks along -z");
pub(super) const DIRECTXTK: Convention = program(World::OURS, "SimpleMath's Vector3::Forward");
pub(super) const NVIDIA: Convention = program(World::OURS, "OpenGL's eye, along -z");
pub(super) const PROBES: Convention = program(World::OURS, "the middle of its images");
pub(super) const SKYLIBS: Convention = program(World::OURS, "the middle of its panoramas");
pub(super) const VECTORS: Convention = program(
    World::OURS,
    "no world of its own; that of names without a program",
);

/// libs/ibl works in a mirror image of Filament's world, which cmgen turns over in x when it writes.
pub(super) const FILAMENT: Convention =
    program(World::new("+y", "-z", true), "a camera looks along -z");
/// cmft and bimg are of bgfx, whose cameras are left-handed unless they are asked.
pub(super) const BGFX: Convention = program(
    World::new("+y", "+z", true),
    "the middle of its panoramas, and what bgfx's cameras look along",
);
pub(super) const DIRECT3D: Convention =
    program(World::new("+y", "+z", true), "its eye looks along +z");
pub(super) const BABYLONJS: Convention = program(
    World::new("+y", "+z", true),
    "Vector3.Forward, what a camera looks along",
);
/// A format of files has no eye; its text says what lies forward, with +x to the right of it.
pub(super) const KTX: Convention = program(
    World::new("+y", "+z", true),
    "what its specification calls forward",
);
pub(super) const UNITY: Convention = program(
    World::new("+y", "+z", true),
    "Vector3.forward, what a camera looks along",
);
pub(super) const UNREAL: Convention = program(
    World::new("+z", "+x", true),
    "FVector::ForwardVector, what a camera looks along",
);
pub(super) const PBRT: Convention = program(
    World::new("+z", "-x", true),
    "the middle of its panorama; its camera looks along +z, which is up here",
);
pub(super) const MITSUBA: Convention =
    program(World::new("+y", "+z", false), "a sensor looks along +z");
pub(super) const OPENEXR: Convention =
    program(World::new("+y", "+z", false), "the middle of its panoramas");
pub(super) const OPENIMAGEIO: Convention = OPENEXR;
pub(super) const OPENIMAGEIO_Z_UP: Convention =
    program(World::new("+z", "+x", false), "the middle of its panoramas");
pub(super) const BLENDER: Convention = program(
    World::new("+z", "+y", false),
    "the front view looks along +y",
);
pub(super) const HEALPY: Convention = program(
    World::new("+z", "+x", false),
    "the middle of its maps: longitude 0 on the equator",
);
/// A camera that nobody has turned looks straight down there; ahead is what lies ahead on a stage with +y up, turned as its dome is.
pub(super) const USD_Z_UP: Convention = program(
    World::new("+z", "+y", false),
    "-z of a stage with +y up, turned as the dome is",
);
pub(super) const S2: Convention = program(World::new("+z", "+x", false), "latitude 0, longitude 0");
pub(super) const FFMPEG: Convention = program(
    World::new("-y", "+z", false),
    "a flat view that is not turned looks along +z",
);
pub(super) const HUGIN: Convention =
    program(World::new("-y", "+z", false), "the middle of its panoramas");
pub(super) const COLMAP: Convention = program(
    World::new("-y", "+z", false),
    "a camera looks along +z, with +x to the right and +y down",
);
pub(super) const PY360CONVERT: Convention = program(
    World::new("+y", "+z", true),
    "a view that is not turned looks along +z, with +x to the right",
);
pub(super) const EQUILIB: Convention = program(
    World::new("+z", "+x", true),
    "the face F, with +y to the right",
);
