//! The table of conventions: one row per program and projection.
//!
//! A row says how a named program lays out a kind of map: axes, grid, layout, face order and
//! parameters, with the source of the fact and the version it was seen in. A row is `verified` where a test
//! runs the program or, for a published specification, its formula; other rows are read from source and
//! held to that formula.

use crate::error::Error;
use crate::faces::FaceTable;
use crate::map::Grid;

/// How a program lays out a kind of map.
#[derive(Clone, Copy, Debug)]
pub struct Convention {
    /// The projection's name.
    pub kind: &'static str,
    /// The program's name.
    pub name: &'static str,
    /// Which world axes point right, down and forward.
    pub axes: &'static str,
    /// Where texel centres lie.
    pub grid: Grid,
    /// How faces are laid out, where the program has one way.
    pub layout: Option<&'static str>,
    /// Face order and orientation, where they are not the projection's own.
    pub faces: Option<FaceTable>,
    /// Parameters that differ from the default.
    pub parameters: &'static [(&'static str, f64)],
    /// What a user should know.
    pub note: &'static str,
    /// Where the fact comes from.
    pub source: &'static str,
    /// The version of the program that it was read or seen in.
    pub version: &'static str,
    /// Whether a test holds it against the program or its specification.
    pub verified: bool,
}

const ROW: Convention = Convention {
    kind: "",
    name: "",
    axes: "",
    grid: Grid::Centers,
    layout: None,
    faces: None,
    parameters: &[],
    note: "",
    source: "",
    version: "",
    verified: true,
};

/// Every row.
pub const TABLE: &[Convention] = &[
    Convention {
        kind: "sphere",
        name: "opengl",
        axes: "+x -y +z",
        note: "As displayed: t counts up from the last row, so t = 1 - v.",
        source: "OpenGL specification, GL_SPHERE_MAP texture coordinate generation",
        version: "OpenGL 4.6 compatibility profile",
        ..ROW
    },
    Convention {
        kind: "sphere",
        name: "d3d",
        axes: "+x -y -z",
        note: "Direct3D's effect: n = normalize(r + (0, 0, -1)), u = nx/2 + 1/2, v = -ny/2 + 1/2.",
        source: "Direct3D sphere-map effect",
        version: "Direct3D 9",
        ..ROW
    },
    Convention {
        kind: "cube",
        name: "opengl",
        axes: "+x -y +z",
        note: "Faces +x -x +y -y +z -z, t down in memory; the picture of each face is mirrored from inside.",
        source: "OpenGL specification, table 8.19",
        version: "OpenGL 4.6",
        ..ROW
    },
    Convention {
        kind: "cube",
        name: "d3d",
        axes: "+x -y +z",
        note: "The same table as OpenGL's; Direct3D's left-handed world sees it unmirrored.",
        source: "Direct3D 11 functional specification, cube-map face selection",
        version: "Direct3D 11.3",
        ..ROW
    },
    Convention {
        kind: "cube",
        name: "vulkan",
        axes: "+x -y +z",
        note: "The same table as OpenGL's.",
        source: "Vulkan specification, cube map face selection",
        version: "Vulkan 1.3",
        ..ROW
    },
    Convention {
        kind: "angular",
        name: "debevec",
        axes: "+x -y -z",
        note: "Centre -z, unmirrored: the reading that real light probes fit.",
        source: "Debevec, Light Probe Image Gallery",
        version: "1998",
        ..ROW
    },
    Convention {
        kind: "angular",
        name: "openimageio",
        axes: "+x -y +z",
        note: "The gallery's second sentence taken literally, centre +z: real probes come out mirrored.",
        source: "OpenImageIO, maketx --lightprobe",
        version: "3.2.2",
        ..ROW
    },
    Convention {
        kind: "latlong",
        name: "mitsuba",
        axes: "-x -y +z",
        grid: Grid::CornersV,
        note: "Rows lie on the poles: row 0 at theta = 0, the last at theta = pi.",
        source: "mitsuba 3, envmap emitter",
        version: "3.9.1",
        ..ROW
    },
    Convention {
        kind: "latlong",
        name: "openimageio",
        axes: "-x -y +z",
        note: "y up, files without oiio:sampleborder (.tif, .tx); its lookups clamp at the poles.",
        source: "OpenImageIO, TextureSystem::environment",
        version: "3.2.2",
        ..ROW
    },
    Convention {
        kind: "latlong",
        name: "openimageio-sampleborder",
        axes: "-x -y +z",
        grid: Grid::Corners,
        note: "y up, files with oiio:sampleborder, as every .exr that maketx writes.",
        source: "OpenImageIO, TextureSystem::environment",
        version: "3.2.2",
        ..ROW
    },
    Convention {
        kind: "sphere",
        name: "skylibs",
        axes: "+x -y -z",
        note: "The view from inside; its own solid angles of this map do not sum to 4 pi.",
        source: "skylibs, envmap.projections",
        version: "0.7.7",
        verified: false,
        ..ROW
    },
    Convention {
        kind: "angular",
        name: "skylibs",
        axes: "+x -y -z",
        note: "The same as Debevec's.",
        source: "skylibs, envmap.projections",
        version: "0.7.7",
        verified: false,
        ..ROW
    },
    Convention {
        kind: "latlong",
        name: "skylibs",
        axes: "+x -y -z",
        note: "Centre -z, unmirrored, as nvdiffrec and the USC-ICT probes.",
        source: "skylibs, envmap.projections",
        version: "0.7.7",
        verified: false,
        ..ROW
    },
    Convention {
        kind: "latlong",
        name: "blender",
        axes: "-y -z +x",
        note: "World z up; centre +x, -y to the right.",
        source: "Blender, Cycles equirectangular mapping",
        version: "4",
        verified: false,
        ..ROW
    },
];

/// The rows of a kind.
pub fn of(kind: &str) -> impl Iterator<Item = &'static Convention> {
    TABLE.iter().filter(move |row| row.kind == kind)
}

/// The row of a kind and program.
pub fn find(kind: &str, name: &str) -> Result<&'static Convention, Error> {
    let names: Vec<&str> = of(kind).map(|row| row.name).collect();
    if names.is_empty() {
        return Err(Error::Contradiction(format!(
            "projection '{kind}' has no conventions, got '{name}'"
        )));
    }
    let found = of(kind).find(|row| row.name == name);
    found.ok_or_else(|| Error::unknown("convention", name, &names))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::map::{Map, Options};

    #[test]
    fn every_row_makes_a_map() {
        for row in TABLE {
            let options = Options {
                convention: Some(row.name),
                ..Options::default()
            };
            let map = Map::new(row.kind, options).unwrap();
            assert_eq!(map.axes().to_string(), row.axes);
            assert_eq!(
                TABLE
                    .iter()
                    .filter(|r| (r.kind, r.name) == (row.kind, row.name))
                    .count(),
                1
            );
        }
    }
}
