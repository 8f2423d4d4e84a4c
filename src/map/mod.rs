//! A projection with everything that a program decides about it: axes, grid, face order, layout.
//!
//! [`Map`] is the run-time value behind every call. Its verbs find the compiled formula through the
//! registry, put the frame around it and spread the work over threads.

pub mod compare;
pub mod conventions;
mod drawing;
pub(crate) mod element;
mod explain;
pub(crate) mod grid;
pub(crate) mod layout;
pub(crate) mod lonlat;
mod name;
mod options;
mod parallels;
mod pullback;
pub(crate) mod row_of_cells;
mod slices;
mod typed;
pub(crate) mod verbs;
mod world;

pub use element::Element;
pub use grid::Grid;
pub use options::MapOptions;

use crate::error::Error;
use crate::geometry::axes::{self, Axes, Rotation};
use crate::geometry::solid_angle::Rect;
use crate::geometry::world::World;
use crate::kernel::Scalar;
use crate::kernel::stream::{self, Room};
use crate::kernel::threads;
use crate::kernel::tile::{TILE, Tile, Tuples};
use crate::map::conventions::Convention;
use crate::map::verbs::{
    Beyond, DecodeOwn, DensityOwn, EncodeOwn, EncodeTile, JacobianOwn, ValidCanonical,
};
use crate::projections::faces::{Cells, FaceLayout, FaceTable};
use crate::projections::projection::Visitor;
use crate::projections::projection::one;
use crate::projections::projection::{Coverage, Info, Outline, Projection, Seam, Uv};
use crate::projections::{Kind, REGISTRY};
use glam::DMat3;

/// A projection with its axes, grid, faces and parameters.
#[derive(Clone, Debug)]
pub struct Map {
    kind: Kind,
    info: &'static Info,
    convention: Option<&'static str>,
    axes: Axes,
    grid: Grid,
    layout: Option<&'static str>,
    face_layout: FaceLayout,
    parameters: Vec<f64>,
    /// How its world is turned in the world of the caller: the pose of a camera.
    pose: Option<DMat3>,
    /// The world of its directions.
    world: World,
}

impl Eq for Map {}

impl std::hash::Hash for Map {
    fn hash<H: std::hash::Hasher>(&self, state: &mut H) {
        self.info.name.hash(state);
        self.convention.hash(state);
        self.axes.hash(state);
        self.world.hash(state);
        self.grid.hash(state);
        self.layout.hash(state);
        self.parameters.iter().for_each(|x| x.to_bits().hash(state));
        if let Some(pose) = self.pose {
            pose.to_cols_array().map(f64::to_bits).hash(state);
        }
    }
}

impl PartialEq for Map {
    fn eq(&self, other: &Self) -> bool {
        self.info.name == other.info.name
            && self.convention == other.convention
            && self.axes == other.axes
            && self.grid == other.grid
            && self.layout == other.layout
            && self.face_layout == other.face_layout
            && self.parameters == other.parameters
            && self.pose == other.pose
            && self.world == other.world
    }
}

impl Map {
    /// The map of this name, which may have parameters, as "perspective(fov=60)", and be qualified by a convention, as
    /// "latlong:mitsuba" or "angular(fov=180):openimageio".
    ///
    /// # Errors
    /// No projection has this name, or it has no such convention or parameter.
    ///
    /// ```
    /// use spheremap::{Map, MapOptions};
    /// let map = Map::new("latlong:mitsuba")?;
    /// assert_eq!(map.axes().to_string(), "-x -y +z");
    /// assert_eq!("latlong:mitsuba".parse::<Map>()?, map);
    /// assert_eq!(Map::new("perspective(fov=60)")?.parameters()[0], 60.0);
    /// let error = Map::new("octahedrel").unwrap_err();
    /// assert_eq!(error.to_string(), "unknown projection 'octahedrel'; did you mean 'octahedral'?");
    /// # Ok::<(), spheremap::Error>(())
    /// ```
    pub fn new(name: &str) -> Result<Map, Error> {
        Map::with(name, MapOptions::default())
    }

    /// The map of this name with these options.
    ///
    /// # Errors
    /// A name that nothing has; a parameter out of its range, or parameters that do not go together; options that
    /// contradict each other.
    ///
    /// ```
    /// use spheremap::{Map, MapOptions};
    /// let map = Map::with("cube:opengl", MapOptions::new().layout("cross"))?;
    /// assert_eq!(map.layout(), Some("cross"));
    /// assert!(Map::with("latlong", MapOptions::new().layout("cross")).is_err()); // it has one face
    /// # Ok::<(), spheremap::Error>(())
    /// ```
    pub fn with(name: &str, options: MapOptions<'_>) -> Result<Map, Error> {
        let written = name::parse(name)?;
        let (name, qualifier) = (written.kind, written.convention);
        let names: Vec<&str> = REGISTRY.iter().map(|info| info.name).collect();
        let info = REGISTRY
            .iter()
            .find(|info| info.name == name)
            .ok_or_else(|| unknown_projection(name, &names))?;
        let convention = match (qualifier, options.convention) {
            (Some(a), Some(b)) if a != b => {
                return Err(Error::Contradiction(format!(
                    "two conventions for '{name}': '{a}' in its name and `convention` '{b}'"
                )));
            }
            (a, b) => a
                .or(b)
                .map(|name| conventions::find(info.name, name))
                .transpose()?,
        };
        let axes = options
            .axes
            .or(convention.map(|c| c.axes))
            .unwrap_or(info.axes)
            .parse()?;
        let grid = match options.grid {
            Some(name) => find_grid(name)?,
            None => convention.map_or(Grid::Centers, |c| c.grid),
        };
        let given = [&written.parameters, options.parameters].concat();
        let parameters = parameters(info, convention, &given)?;
        Kind::check(info.name, &parameters).map_err(|why| Error::Together {
            projection: info.name,
            why,
        })?;
        let kind = Kind::new(info.name, &parameters)
            .ok_or_else(|| Error::unknown("projection", name, &names))?;
        let table = convention
            .and_then(|c| c.faces)
            .unwrap_or(FaceTable::CANONICAL);
        let wanted = options.layout.or(convention.and_then(|c| c.layout));
        let (layout, face_layout) = face_layout(info, table, wanted)?;
        let world = convention.map_or(World::OURS, |c| c.world);
        let convention = convention.map(|c| c.name);
        Ok(Map {
            kind,
            info,
            convention,
            axes,
            grid,
            layout,
            face_layout,
            parameters,
            pose: None,
            world,
        })
    }

    /// The same map with its faces laid out otherwise.
    ///
    /// # Errors
    /// It has no such layout.
    ///
    /// ```
    /// let cross = spheremap::Map::new("cube")?.with_layout("cross")?;
    /// assert_eq!(cross.uv_width(), 2);
    /// # Ok::<(), spheremap::Error>(())
    /// ```
    pub fn with_layout(&self, layout: &str) -> Result<Map, Error> {
        let parameters = self.info.parameters.iter().zip(&self.parameters);
        let parameters: Vec<(&str, f64)> = parameters
            .map(|(parameter, value)| (parameter.name, *value))
            .collect();
        let map = Map::with(
            self.info.name,
            MapOptions {
                convention: self.convention,
                axes: Some(&self.axes.to_string()),
                grid: Some(self.grid.name()),
                layout: Some(layout),
                parameters: &parameters,
            },
        )?;
        Ok(Map {
            pose: self.pose,
            world: self.world,
            ..map
        })
    }

    /// The claims of the projection.
    ///
    /// ```
    /// let info = spheremap::Map::new("healpix")?.info();
    /// assert!(info.equal_area && !info.conformal);
    /// # Ok::<(), spheremap::Error>(())
    /// ```
    pub fn info(&self) -> &'static Info {
        self.info
    }

    /// The name of the convention that the map was made with.
    ///
    /// ```
    /// use spheremap::Map;
    /// assert_eq!(Map::new("latlong:mitsuba")?.convention(), Some("mitsuba"));
    /// assert_eq!(Map::new("latlong")?.convention(), None);
    /// # Ok::<(), spheremap::Error>(())
    /// ```
    pub fn convention(&self) -> Option<&'static str> {
        self.convention
    }

    /// The world axes that point right, down and forward.
    ///
    /// ```
    /// assert_eq!(spheremap::Map::new("latlong")?.axes().to_string(), "+x -y -z");
    /// # Ok::<(), spheremap::Error>(())
    /// ```
    pub fn axes(&self) -> Axes {
        self.axes
    }

    /// The grid: where texel centers lie.
    ///
    /// ```
    /// use spheremap::{Grid, Map};
    /// assert_eq!(Map::new("latlong:mitsuba")?.grid(), Grid::CornersV);
    /// # Ok::<(), spheremap::Error>(())
    /// ```
    pub fn grid(&self) -> Grid {
        self.grid
    }

    /// The name of the layout; none for a projection of one face.
    ///
    /// ```
    /// use spheremap::Map;
    /// assert_eq!(Map::new("cube")?.layout(), Some("faces"));
    /// assert_eq!(Map::new("latlong")?.layout(), None);
    /// # Ok::<(), spheremap::Error>(())
    /// ```
    pub fn layout(&self) -> Option<&'static str> {
        self.layout
    }

    /// The place of each face in the stored image.
    ///
    /// ```
    /// let strip = spheremap::MapOptions::new().layout("strip");
    /// let map = spheremap::Map::with("cube", strip)?;
    /// assert_eq!((map.face_layout().columns, map.face_layout().rows), (6, 1));
    /// # Ok::<(), spheremap::Error>(())
    /// ```
    pub fn face_layout(&self) -> &FaceLayout {
        &self.face_layout
    }

    /// The parameters, in the order of the claims' list.
    ///
    /// ```
    /// assert_eq!(spheremap::Map::new("equisolid")?.parameters(), [180.0]);
    /// # Ok::<(), spheremap::Error>(())
    /// ```
    pub fn parameters(&self) -> &[f64] {
        &self.parameters
    }

    /// The count of numbers that an image coordinate has: 3 where faces are apart, else 2.
    ///
    /// ```
    /// use spheremap::{Map, MapOptions};
    /// assert_eq!(Map::new("latlong")?.uv_width(), 2);
    /// assert_eq!(Map::new("cube")?.uv_width(), 3);
    /// assert_eq!(Map::with("cube", MapOptions::new().layout("cross"))?.uv_width(), 2);
    /// # Ok::<(), spheremap::Error>(())
    /// ```
    pub fn uv_width(&self) -> usize {
        if self.face_layout.is_atlas { 2 } else { 3 }
    }

    /// The count of faces that the image coordinates tell apart.
    ///
    /// ```
    /// assert_eq!(spheremap::Map::new("cube")?.faces(), 6);
    /// # Ok::<(), spheremap::Error>(())
    /// ```
    pub fn faces(&self) -> usize {
        if self.face_layout.is_atlas {
            1
        } else {
            self.face_layout.faces
        }
    }

    /// The part of the sphere that the map holds.
    ///
    /// ```
    /// use spheremap::projections::Coverage;
    /// assert_eq!(spheremap::Map::new("hemioctahedral")?.coverage(), Coverage::Hemisphere);
    /// # Ok::<(), spheremap::Error>(())
    /// ```
    pub fn coverage(&self) -> Coverage {
        struct Get;
        impl Visitor for Get {
            type Output = Coverage;
            fn visit<P: Projection>(self, p: P) -> Coverage {
                p.coverage()
            }
        }
        self.kind.visit(Get)
    }

    /// The rule for what lies beyond the edges of the map.
    ///
    /// ```
    /// use spheremap::projections::Seam;
    /// assert_eq!(spheremap::Map::new("latlong")?.seam(), Seam::Latlong);
    /// # Ok::<(), spheremap::Error>(())
    /// ```
    pub fn seam(&self) -> Seam {
        struct Get;
        impl Visitor for Get {
            type Output = Seam;
            fn visit<P: Projection>(self, p: P) -> Seam {
                p.seam()
            }
        }
        self.kind.visit(Get)
    }

    /// The part of an image that holds sphere, in closed form: 1, π/4 for a disk, 1/2 for a cross.
    ///
    /// ```
    /// use spheremap::{Map, MapOptions};
    ///
    /// let cross = MapOptions::new().layout("cross");
    /// assert_eq!(Map::with("cube", cross)?.used_part(), 0.5);
    /// # Ok::<(), spheremap::Error>(())
    /// ```
    pub fn used_part(&self) -> f64 {
        struct Get;
        impl Visitor for Get {
            type Output = f64;
            fn visit<P: Projection>(self, p: P) -> f64 {
                p.used_part()
            }
        }
        let layout = &self.face_layout;
        let cells = if layout.is_atlas {
            layout.rows * layout.columns
        } else {
            layout.faces
        };
        self.kind.visit(Get) * layout.faces as f64 / cells as f64
    }

    /// Width and height of a face of size `n`.
    ///
    /// ```
    /// assert_eq!(spheremap::Map::new("latlong")?.face_size(64), (128, 64));
    /// # Ok::<(), spheremap::Error>(())
    /// ```
    pub fn face_size(&self, n: usize) -> (usize, usize) {
        struct Get(usize);
        impl Visitor for Get {
            type Output = (usize, usize);
            fn visit<P: Projection>(self, p: P) -> (usize, usize) {
                p.size(self.0)
            }
        }
        self.kind.visit(Get(n))
    }

    /// The exact solid angle that a rectangle of a canonical face sees, rims included; NaN of one with a side that is no
    /// finite number. Sides are those of a texel or the like: 0 ≤ u0 ≤ u1 ≤ 1, and the same in v.
    ///
    /// ```
    /// use spheremap::geometry::Rect;
    /// let map = spheremap::Map::new("latlong")?;
    /// assert!((map.solid_angle(Rect::WHOLE) - 4.0 * std::f64::consts::PI).abs() < 1e-14);
    /// # Ok::<(), spheremap::Error>(())
    /// ```
    pub fn solid_angle(&self, rect: Rect) -> f64 {
        struct Get(Rect);
        impl Visitor for Get {
            type Output = f64;
            fn visit<P: Projection>(self, p: P) -> f64 {
                p.solid_angle(self.0)
            }
        }
        if ![rect.u0, rect.u1, rect.v0, rect.v1]
            .iter()
            .all(|x| x.is_finite())
        {
            return f64::NAN;
        }
        self.visit_canonical(Get(rect))
    }

    /// Whether rectangles of the same rows and width see the same solid angle.
    pub(crate) fn has_even_rows(&self) -> bool {
        struct Get;
        impl Visitor for Get {
            type Output = bool;
            fn visit<P: Projection>(self, p: P) -> bool {
                P::EVEN_ROWS && matches!(p.outline(), Outline::Square)
            }
        }
        self.visit_canonical(Get)
    }

    /// The radius about the middle of a face within which what it shows is its own: less than ½ where faces show some of the sphere twice.
    pub(crate) fn own_radius(&self) -> f64 {
        struct Get;
        impl Visitor for Get {
            type Output = f64;
            fn visit<P: Projection>(self, p: P) -> f64 {
                p.own_radius()
            }
        }
        self.visit_canonical(Get)
    }

    /// Whether faces show some of the sphere twice.
    pub(crate) fn overlaps(&self) -> bool {
        self.own_radius() < 0.5
    }

    /// The smallest and largest dω/(du dv) over the valid image.
    ///
    /// ```
    /// let (low, high) = spheremap::Map::new("healpix")?.density_range();
    /// assert_eq!(low, high); // equal-area
    /// # Ok::<(), spheremap::Error>(())
    /// ```
    pub fn density_range(&self) -> (f64, f64) {
        struct Get;
        impl Visitor for Get {
            type Output = (f64, f64);
            fn visit<P: Projection>(self, p: P) -> (f64, f64) {
                p.density_range()
            }
        }
        let (low, high) = self.visit_canonical(Get);
        (low * self.cells(), high * self.cells())
    }

    /// Whether the picture of each canonical face is mirrored as seen from inside a right-handed
    /// world. Not all formulas keep the view frame's sense, and faces may differ.
    ///
    /// ```
    /// use spheremap::Map;
    /// assert_eq!(Map::new("latlong")?.mirrored(), [false]);
    /// assert_eq!(Map::new("cube:opengl")?.mirrored(), [true; 6]);
    /// # Ok::<(), spheremap::Error>(())
    /// ```
    pub fn mirrored(&self) -> Vec<bool> {
        struct Sense;
        impl Visitor for Sense {
            type Output = Vec<bool>;
            fn visit<P: Projection>(self, p: P) -> Vec<bool> {
                (0..P::INFO.faces)
                    .map(|face| is_reversed(p, face))
                    .collect()
            }
        }
        // By calls: of a lens, whose formula does not look at the face, LLVM 22 takes it for what every lane has alike, and its loop
        // vectorizer asks the operands of that in a time that doubles with each step of Newton's method.
        fn is_reversed<P: Projection>(p: P, face: usize) -> bool {
            let uv = Uv {
                u: 0.45,
                v: 0.4,
                face: face as f64,
            };
            let [a, b] = one::jacobian(p, uv).map(glam::DVec3::from);
            a.cross(b).dot(glam::DVec3::from(one::decode(p, uv))) < 0.0
        }
        let turned = |(face, reversed): (usize, bool)| {
            let o = self.face_layout.places[face].orientation;
            reversed ^ o.swap ^ o.flip_u ^ o.flip_v ^ self.axes.mirrored()
        };
        self.visit_canonical(Sense)
            .into_iter()
            .enumerate()
            .map(turned)
            .collect()
    }

    /// Whether both give each canonical coordinate the same direction: they may differ in size, grid and
    /// layout of their images.
    pub(crate) fn same_formula(&self, other: &Map) -> bool {
        self.info.name == other.info.name
            && self.axes == other.axes
            && self.parameters == other.parameters
            && self.pose == other.pose
    }

    /// This map with its world turned: what it showed at d it shows at `pose`·d. Of a camera, `pose` takes its own frame to
    /// the world.
    ///
    /// # Errors
    /// `pose` is no rotation.
    ///
    /// ```
    /// use spheremap::Map;
    /// use spheremap::geometry::from_angles;
    /// use spheremap::glam::{DMat3, DVec3};
    /// let camera = Map::new("perspective")?;
    /// let pose = from_angles(90.0, 0.0, 0.0); // a quarter turn to the left
    /// let (_, before) = camera.encode_one(DVec3::NEG_Z).unwrap();
    /// let (_, after) = camera.turned(pose)?.encode_one(pose * DVec3::NEG_Z).unwrap();
    /// assert!(before.distance(after) < 1e-15);
    /// assert!(camera.turned(2.0 * DMat3::IDENTITY).is_err());
    /// # Ok::<(), spheremap::Error>(())
    /// ```
    pub fn turned(&self, pose: DMat3) -> Result<Map, Error> {
        let pose = axes::rotation(axes::rows(pose))?;
        let pose = self.pose.map_or(pose, |before| pose * before);
        // Zeros of one sign, so that what is equal has one hash.
        let pose = DMat3::from_cols_array(&pose.to_cols_array().map(|x| x + 0.0));
        Ok(Map {
            pose: (pose != DMat3::IDENTITY).then_some(pose),
            ..self.clone()
        })
    }

    /// The map before it was turned.
    pub(crate) fn unturned(&self) -> Map {
        Map {
            pose: None,
            ..self.clone()
        }
    }

    /// The rotation by which the world of the map is turned.
    ///
    /// ```
    /// use spheremap::Map;
    /// use spheremap::geometry::from_angles;
    /// let pose = from_angles(90.0, 0.0, 0.0);
    /// assert_eq!(Map::new("latlong")?.turned(pose)?.pose(), Some(pose));
    /// assert_eq!(Map::new("latlong")?.pose(), None);
    /// # Ok::<(), spheremap::Error>(())
    /// ```
    pub fn pose(&self) -> Option<DMat3> {
        self.pose
    }

    /// World to view, for the map turned by `rotation`.
    pub(crate) fn view_rotation(&self, rotation: Option<DMat3>) -> Rotation {
        let turned = match (rotation, self.pose) {
            (Some(rotation), Some(pose)) => Some(rotation * pose),
            (rotation, pose) => rotation.or(pose),
        };
        Rotation::new(self.axes, turned)
    }

    /// The projection with its parameters.
    pub(crate) fn kind(&self) -> Kind {
        self.kind
    }

    /// What part of a face holds sphere, with the map's parameters.
    pub(crate) fn outline(&self) -> Outline {
        struct Get;
        impl Visitor for Get {
            type Output = Outline;
            fn visit<P: Projection>(self, p: P) -> Outline {
                p.outline()
            }
        }
        self.kind.visit(Get)
    }

    /// The middle and the half axes, in p and q, of an ellipse of places that every face holds.
    pub(crate) fn held_ellipse(&self) -> Option<[[f64; 2]; 2]> {
        struct Get;
        impl Visitor for Get {
            type Output = Option<[[f64; 2]; 2]>;
            fn visit<P: Projection>(self, p: P) -> Option<[[f64; 2]; 2]> {
                p.held_ellipse()
            }
        }
        self.kind.visit(Get)
    }

    /// Calls the visitor with the projection in its own order of faces, three numbers a coordinate.
    pub(crate) fn visit_canonical<V: Visitor>(&self, visitor: V) -> V::Output {
        self.kind.visit(visitor)
    }

    /// Calls `work` with the canonical (u, v, face) of blocks of places, and O items of output for each.
    fn located<R: Scalar, T, const O: usize>(
        &self,
        uv: &[R],
        output: &mut [T],
        work: impl Fn(&[R], &mut [T]),
    ) {
        layout::locate(&self.face_layout, uv, &mut |first, canonical| {
            let end = first + canonical.len() / 3;
            work(canonical, &mut output[O * first..O * end]);
        });
    }

    /// Directions, three numbers each, to image coordinates.
    pub(crate) fn encode_numbers<R: Scalar>(
        &self,
        rotation: Option<DMat3>,
        directions: &[R],
        uv: &mut [R],
    ) {
        self.encode_to(rotation, directions, uv, Room::Used);
    }

    /// The same, to memory that may be fresh.
    pub(crate) fn encode_to<R: Scalar>(
        &self,
        rotation: Option<DMat3>,
        directions: &[R],
        uv: &mut [R],
        room: Room,
    ) {
        let turn = self.view_rotation(rotation);
        let width = self.uv_width();
        let past = room == Room::Used && stream::pays(directions, uv);
        let own = |input: &[R], output: &mut [R], past_caches: bool| {
            self.visit_canonical(EncodeOwn {
                turn,
                input,
                output,
                past_caches,
            });
        };
        threads::blocks(directions, 3, uv, width, |directions, uv| {
            if self.face_layout.is_canonical() {
                return own(directions, uv, past);
            }
            layout::store(&self.face_layout, directions, uv, &|d, uv| {
                own(d, uv, false)
            });
        });
    }

    /// Image coordinates to unit directions, three numbers each.
    pub(crate) fn decode_numbers<R: Scalar>(
        &self,
        rotation: Option<DMat3>,
        uv: &[R],
        directions: &mut [R],
    ) {
        self.decode_to(rotation, uv, directions, Room::Used);
    }

    /// The same, to memory that may be fresh.
    pub(crate) fn decode_to<R: Scalar>(
        &self,
        rotation: Option<DMat3>,
        uv: &[R],
        directions: &mut [R],
        room: Room,
    ) {
        let turn = self.view_rotation(rotation).inverse();
        let past = room == Room::Used && stream::pays(uv, directions);
        let own = |input: &[R], output: &mut [R], past_caches: bool| {
            self.visit_canonical(DecodeOwn {
                turn,
                input,
                output,
                past_caches,
            });
        };
        threads::blocks(uv, self.uv_width(), directions, 3, |uv, directions| {
            if self.face_layout.is_canonical() {
                return own(uv, directions, past);
            }
            self.located::<R, R, 3>(uv, directions, |uv, d| own(uv, d, false));
        });
    }

    /// The directions that the image shows at canonical (u, v, face), also beyond a face's edges.
    pub(crate) fn beyond<R: Scalar>(&self, canonical: &[R], directions: &mut [R]) {
        let turn = self.view_rotation(None).inverse();
        threads::blocks(canonical, 3, directions, 3, |input, output| {
            self.visit_canonical(Beyond {
                turn,
                input,
                output,
            });
        });
    }

    /// ∂d/∂(u, v) at image coordinates, six numbers each.
    pub(crate) fn jacobian_numbers<R: Scalar>(
        &self,
        rotation: Option<DMat3>,
        uv: &[R],
        jacobians: &mut [R],
    ) {
        let turn = self.view_rotation(rotation).inverse();
        let own = |input: &[R], output: &mut [R]| {
            self.visit_canonical(JacobianOwn {
                turn,
                input,
                output,
                past_caches: false,
            });
        };
        threads::blocks(uv, self.uv_width(), jacobians, 6, |uv, jacobians| {
            if self.face_layout.is_canonical() {
                return own(uv, jacobians);
            }
            self.located::<R, R, 6>(uv, jacobians, own);
            layout::scale_derivatives(&self.face_layout, uv, jacobians);
        });
    }

    /// dω/(du dv) at image coordinates.
    pub(crate) fn density_numbers<R: Scalar>(&self, uv: &[R], density: &mut [R]) {
        let own = |input: &[R], output: &mut [R]| {
            self.visit_canonical(DensityOwn { input, output });
        };
        let cells = R::new(self.cells());
        threads::blocks(uv, self.uv_width(), density, 1, |uv, density| {
            if self.face_layout.is_canonical() {
                return own(uv, density);
            }
            self.located::<R, R, 1>(uv, density, |canonical, out| {
                own(canonical, out);
                out.iter_mut().for_each(|x| *x = *x * cells);
            });
        });
    }

    /// How many cells of the size of a face the image has.
    pub(crate) fn cells(&self) -> f64 {
        if self.face_layout.is_atlas {
            (self.face_layout.columns * self.face_layout.rows) as f64
        } else {
            1.0
        }
    }

    /// Whether image coordinates lie in the valid image.
    pub(crate) fn valid_numbers<R: Scalar>(&self, uv: &[R], valid: &mut [bool]) {
        threads::blocks(uv, self.uv_width(), valid, 1, |uv, valid| {
            self.located::<R, bool, 1>(uv, valid, |input, output| {
                self.visit_canonical(ValidCanonical { input, output });
            });
        });
    }

    /// Whether directions lie in the coverage.
    pub(crate) fn covers_numbers<R: Scalar>(
        &self,
        rotation: Option<DMat3>,
        directions: &[R],
        covered: &mut [bool],
    ) {
        let turn = self.view_rotation(rotation);
        threads::blocks(directions, 3, covered, 1, |directions, covered| {
            let mut uv = Tile::new();
            for (input, covered) in directions.chunks(3 * TILE).zip(covered.chunks_mut(TILE)) {
                self.visit_canonical(EncodeTile {
                    turn,
                    input: Tuples::of(input),
                    output: &mut uv,
                });
                for (u, covered) in uv.0[0].iter().zip(covered) {
                    *covered = !u.is_nan();
                }
            }
        });
    }
}

fn find_grid(name: &str) -> Result<Grid, Error> {
    let names = Grid::ALL.map(Grid::name);
    let found = Grid::ALL.into_iter().find(|grid| grid.name() == name);
    found.ok_or_else(|| Error::unknown("grid", name, &names))
}

/// The error for a name that no projection has: others may use it for one, it may be a layout's or a program's.
fn unknown_projection(name: &str, names: &[&str]) -> Error {
    // "Light Probe", "light-probe" and "lightprobe" are one word.
    let plain = |text: &str| text.to_lowercase().replace(['_', '-', ' '], "");
    let called = |words: &[&str]| words.iter().any(|word| plain(word) == plain(name));
    let named = |found: &dyn Fn(&Info) -> bool| {
        let fits = REGISTRY.iter().filter(|info| found(info));
        fits.map(|info| info.name).collect::<Vec<_>>()
    };
    let here = named(&|info| called(info.known_as));
    if !here.is_empty() {
        return Error::known_here_as("projection", name, &here);
    }
    let hinted = |hint: String| Error::Unknown {
        what: "projection".into(),
        name: name.to_owned(),
        hint,
    };
    let of_layout = named(&|info| info.layouts.iter().any(|layout| called(&[layout.name])));
    if let Some(first) = of_layout.first() {
        return hinted(format!(
            "; it is a layout, as of '{first}': `layout` '{name}'"
        ));
    }
    let rows: Vec<String> = conventions::of_program(name)
        .map(|row| format!("{}:{}", row.kind, row.name))
        .collect();
    if !rows.is_empty() {
        return hinted(format!("; it is a program, with {}", rows.join(", ")));
    }
    Error::unknown("projection", name, names)
}

fn parameters(
    info: &'static Info,
    convention: Option<&Convention>,
    given: &[(&str, f64)],
) -> Result<Vec<f64>, Error> {
    let names: Vec<&str> = info.parameters.iter().map(|p| p.name).collect();
    if let Some((name, _)) = given.iter().find(|(name, _)| !names.contains(name)) {
        if names.is_empty() {
            return Err(Error::Contradiction(format!(
                "projection '{}' takes no parameters, got `{name}`",
                info.name
            )));
        }
        return Err(Error::unknown_of("parameter", name, info.name, &names));
    }
    for (k, (name, value)) in given.iter().enumerate() {
        if let Some((_, other)) = given[..k].iter().find(|(before, _)| before == name) {
            return Err(Error::Contradiction(format!(
                "`{name}` is given twice, {other} and {value}"
            )));
        }
    }
    let value = |parameter: &crate::projections::Parameter| {
        let by_caller = given
            .iter()
            .find(|(name, _)| *name == parameter.name)
            .map(|(_, x)| *x);
        let by_convention = convention
            .and_then(|c| {
                c.parameters
                    .iter()
                    .find(|(name, _)| *name == parameter.name)
            })
            .map(|(_, x)| *x);
        let value = by_caller.or(by_convention).unwrap_or(parameter.default);
        if value > parameter.above && value <= parameter.maximum {
            // No -0, so that what is equal has one hash.
            Ok(value + 0.0)
        } else {
            Err(Error::Parameter {
                name: parameter.name,
                above: parameter.above,
                maximum: parameter.maximum,
                value,
            })
        }
    };
    info.parameters.iter().map(value).collect()
}

fn face_layout(
    info: &'static Info,
    table: FaceTable,
    wanted: Option<&str>,
) -> Result<(Option<&'static str>, FaceLayout), Error> {
    if info.layouts.is_empty() {
        return match wanted {
            None => Ok((None, FaceLayout::single())),
            Some(layout) => Err(Error::Contradiction(format!(
                "projection '{}' has one face and no layouts, got layout '{layout}'",
                info.name
            ))),
        };
    }
    let names: Vec<&str> = info.layouts.iter().map(|layout| layout.name).collect();
    let name = wanted.unwrap_or(names[0]);
    let layout = info.layouts.iter().find(|layout| layout.name == name);
    let layout = layout.ok_or_else(|| Error::unknown("layout", name, &names))?;
    debug_assert!(!matches!(layout.cells, Cells::Grid(_, _, cells) if cells.len() != info.faces));
    Ok((
        Some(layout.name),
        FaceLayout::new(info.faces, table, layout.cells),
    ))
}
