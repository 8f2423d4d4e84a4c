//! The table of conventions: one row per program and projection, a file for each kind of map.
//!
//! A row says how a named program lays out a kind of map: axes, grid, layout, face order and
//! parameters, with the source of the fact and the version it was seen in. Where a program lays one kind
//! out in several ways, each has a row, named after the program and the way (`ffmpeg-c3x2`).
//!
//! What is up and ahead in a program, and whether its world is left-handed, is said once for all its rows (`programs`).
//!
//! A fact is [`Known::Run`] where a test runs the program and compares, and [`Known::Read`] where it
//! was taken from a specification or from source; those rows are held to the formula that was read, written
//! down a second time in the tests. Where a program and its manual disagree, the row does what the
//! program does, and its note says so.

mod angular;
mod cube;
mod equal_area;
mod latlong;
mod octahedral;
mod programs;
mod sky;
mod sphere;
mod views;

use crate::error::Error;
use crate::geometry::world::World;
use crate::map::grid::Grid;
use crate::projections::REGISTRY;
use crate::projections::faces::FaceTable;

/// How a fact is known.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Known {
    /// A test runs the program and compares.
    Run,
    /// From a specification, or from the program's source.
    Read,
}

/// How a program lays out a kind of map.
#[derive(Clone, Copy, Debug)]
pub struct Convention {
    /// The projection's name.
    pub kind: &'static str,
    /// The program's name, with the way that it lays the map out where it has several.
    pub name: &'static str,
    /// Which world axes point right, down and forward.
    pub axes: &'static str,
    /// Where texel centers lie.
    pub grid: Grid,
    /// How faces are laid out, where the program has one way.
    pub layout: Option<&'static str>,
    /// Face order and orientation, where they are not the projection's own.
    pub faces: Option<FaceTable>,
    /// Parameters that differ from the default.
    pub parameters: &'static [(&'static str, f64)],
    /// The program's world: what is up, what lies ahead, and which hand x, y, z are.
    pub world: World,
    /// Why that is ahead.
    pub ahead: &'static str,
    /// What a user should know.
    pub note: &'static str,
    /// Where the fact comes from.
    pub source: &'static str,
    /// The program or specification with the version that it was read or run in.
    pub version: &'static str,
    /// How it is known.
    pub known: Known,
}

impl Convention {
    /// The way that the convention is known, in words.
    ///
    /// ```
    /// let row = spheremap::conventions::find("latlong", "mitsuba")?;
    /// assert!(!row.verified().is_empty());
    /// # Ok::<(), spheremap::Error>(())
    /// ```
    pub fn verified(&self) -> String {
        match self.known {
            Known::Run => format!("run against {}", self.version),
            Known::Read => "read from source".to_owned(),
        }
    }
}

const ROW: Convention = Convention {
    kind: "",
    name: "",
    axes: "",
    grid: Grid::Centers,
    layout: None,
    faces: None,
    parameters: &[],
    world: World::OURS,
    ahead: "",
    note: "",
    source: "",
    version: "",
    known: Known::Read,
};

const TABLES: &[&[Convention]] = &[
    sphere::TABLE,
    cube::TABLE,
    angular::TABLE,
    octahedral::TABLE,
    equal_area::TABLE,
    latlong::TABLE,
    views::TABLE,
    sky::TABLE,
];

/// Every row of the table.
///
/// ```
/// assert!(spheremap::conventions::all().count() > 60);
/// ```
pub fn all() -> impl Iterator<Item = &'static Convention> {
    TABLES.iter().copied().flatten()
}

/// The rows of a kind of map.
///
/// ```
/// let names: Vec<_> = spheremap::conventions::of("latlong").map(|row| row.name).collect();
/// assert!(names.contains(&"blender"));
/// ```
pub fn of(kind: &str) -> impl Iterator<Item = &'static Convention> {
    all().filter(move |row| row.kind == kind)
}

/// The rows of a program, whichever way it lays maps out.
///
/// ```
/// let rows = spheremap::conventions::of_program("ffmpeg");
/// assert!(rows.into_iter().any(|row| row.name == "ffmpeg-c3x2"));
/// ```
pub fn of_program(name: &str) -> impl Iterator<Item = &'static Convention> {
    let name = name.to_lowercase();
    all().filter(move |row| {
        let way = row.name.strip_prefix(name.as_str());
        way.is_some_and(|way| way.is_empty() || way.starts_with('-'))
    })
}

/// The row of a kind of map and a program.
///
/// # Errors
/// The table has none.
///
/// ```
/// let row = spheremap::conventions::find("latlong", "mitsuba")?;
/// assert_eq!(row.axes, "-x -y +z");
/// # Ok::<(), spheremap::Error>(())
/// ```
pub fn find(kind: &str, name: &str) -> Result<&'static Convention, Error> {
    let names: Vec<&str> = of(kind).map(|row| row.name).collect();
    if names.is_empty() {
        return Err(Error::Contradiction(format!(
            "projection '{kind}' has no conventions, got '{name}'"
        )));
    }
    let found = of(kind).find(|row| row.name == name);
    found.ok_or_else(|| {
        let info = REGISTRY.iter().find(|info| info.name == kind);
        let layouts = info.map_or(&[][..], |info| info.layouts);
        if layouts.iter().any(|layout| layout.name == name) {
            return Error::Unknown {
                what: "convention".into(),
                name: name.to_owned(),
                hint: format!("; it is a layout of '{kind}': `layout` '{name}'"),
            };
        }
        Error::unknown_of("convention", name, kind, &names)
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::map::{Map, MapOptions};

    #[test]
    fn every_row_makes_a_map() {
        for row in all() {
            let options = MapOptions {
                convention: Some(row.name),
                ..MapOptions::default()
            };
            let map = Map::with(row.kind, options).unwrap();
            assert_eq!(map.axes().to_string(), row.axes);
            let same = |other: &&Convention| (other.kind, other.name) == (row.kind, row.name);
            assert_eq!(all().filter(same).count(), 1, "{}:{}", row.kind, row.name);
            assert!(!row.source.is_empty() && !row.version.is_empty());
            assert!(map.world() == row.world && !row.ahead.is_empty());
        }
    }

    #[test]
    fn a_face_table_is_a_permutation() {
        for row in all() {
            let Some(table) = row.faces else { continue };
            let options = MapOptions {
                convention: Some(row.name),
                ..MapOptions::default()
            };
            let faces = Map::with(row.kind, options).unwrap().face_layout().faces;
            let mut stored = table.stored[..faces].to_vec();
            stored.sort_unstable();
            assert!(
                stored.iter().copied().eq(0..faces as u8),
                "{}:{}",
                row.kind,
                row.name
            );
        }
    }

    #[test]
    fn words_of_other_things_are_told_from_conventions_and_projections() {
        let said = |name: &str| Map::new(name).unwrap_err().to_string();
        for (name, says) in [
            ("erp", "unknown projection 'erp'; here it is 'latlong'"),
            (
                "Light Probe",
                "unknown projection 'Light Probe'; here it is 'angular'",
            ),
            (
                "lightprobe",
                "unknown projection 'lightprobe'; here it is 'angular'",
            ),
            ("Cube", "unknown projection 'Cube'; did you mean 'cube'?"),
            (
                "dice",
                "unknown projection 'dice'; it is a layout, as of 'cube': `layout` 'dice'",
            ),
            (
                "cube:strip",
                "unknown convention 'strip'; it is a layout of 'cube': `layout` 'strip'",
            ),
            (
                "unity",
                "unknown projection 'unity'; it is a program, with cube:unity, latlong:unity",
            ),
        ] {
            assert_eq!(said(name), says);
        }
    }

    #[test]
    fn unknown_names_list_the_nearest_first() {
        let error = find("cube", "ffmpeg").unwrap_err().to_string();
        let start =
            "unknown convention 'ffmpeg'; 'cube' has ffmpeg-c1x6, ffmpeg-c3x2, ffmpeg-c6x1, ";
        assert!(error.starts_with(start), "{error}");
        let error = find("latlong", "mitsubo").unwrap_err().to_string();
        let start = "unknown convention 'mitsubo'; did you mean 'mitsuba'? 'latlong' has mitsuba, ";
        assert!(error.starts_with(start), "{error}");
    }
}
