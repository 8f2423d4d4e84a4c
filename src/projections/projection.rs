//! What a projection is, and what it claims about itself.
//!
//! A projection is a pair of formulas in the view frame (x = image right, y = image down, z = toward
//! the image center) between a direction and image coordinates (u right, v down, both in [0, 1]).
//! Axes, rotations, face layouts, grids, validity of the input and NaN are the business of the code
//! around it: `encode` is given three finite numbers whose largest is near 1, and `decode` a point
//! of the valid image.
//!
//! [`Info`] is a list of claims. Each is a test that runs over the whole registry.

use crate::geometry::solid_angle;
use crate::geometry::solid_angle::Rect;
use crate::geometry::vector::dot;
use crate::number::angle;
use crate::number::dual::Dual;
use crate::number::real::{Real, max, min};
use crate::projections::faces::LayoutSpec;

/// Image coordinates; `face` is 0 on a map of one face.
#[derive(Clone, Copy, Debug)]
pub struct Uv<R> {
    /// Along a row, 0 at the left edge and 1 at the right one.
    pub u: R,
    /// Down the rows, 0 at the top edge and 1 at the bottom one.
    pub v: R,
    /// The face's number.
    pub face: R,
}

impl<R: Real> Uv<R> {
    /// A point of a map of one face.
    ///
    /// ```
    /// use spheremap::projections::{Latlong, Projection, Uv};
    /// assert_eq!(Latlong.decode(Uv::flat(0.5, 0.5)), [0.0, 0.0, 1.0]);
    /// ```
    #[inline(always)]
    pub fn flat(u: R, v: R) -> Self {
        Self {
            u,
            v,
            face: R::ZERO,
        }
    }

    /// A point from p = 2u - 1 and q = 2v - 1.
    #[inline(always)]
    pub(crate) fn centered(p: R, q: R, face: R) -> Self {
        let half = R::HALF;
        Self {
            u: p * half + half,
            v: q * half + half,
            face,
        }
    }

    /// A point from p and q of a map of one face whose coverage ends at the edges of the square: NaN beyond
    /// them, by more than rounding, and where it is not `seen`.
    #[inline(always)]
    pub(crate) fn in_square(p: R, q: R, seen: R::Mask) -> Self {
        let edge = R::new(1.0 + 8.0 * R::epsilon());
        Self::held(p, q, seen & p.abs().at_most(edge) & q.abs().at_most(edge))
    }

    /// A point from p and q of a map of one face whose coverage ends at the rim of the disk: NaN beyond it, by
    /// more than rounding, and where it is not `seen`.
    #[inline(always)]
    pub(crate) fn in_disk(p: R, q: R, seen: R::Mask) -> Self {
        let within = (p * p + q * q).at_most(R::new(1.0 + 4.0 * R::epsilon()));
        Self::held(p, q, seen & within)
    }

    /// A point from p and q of a map of one face, held to the square that rounding may leave: NaN where it is not
    /// `inside`.
    ///
    /// NaN is chosen behind the clamps, and the condition is made of numbers: a compiler for graphics cards may make a
    /// minimum of a clamp, which drops NaN.
    #[inline(always)]
    pub(crate) fn held(p: R, q: R, inside: R::Mask) -> Self {
        let nan = R::NAN;
        Self::centered(
            R::choose(inside, p.clamped(-1.0, 1.0), nan),
            R::choose(inside, q.clamped(-1.0, 1.0), nan),
            R::ZERO,
        )
    }

    /// Whether it lies in the unit square of one of so many faces.
    #[inline(always)]
    pub(crate) fn in_bounds(self, faces: usize) -> R::Mask {
        let within = |x: R| x.at_least(R::ZERO) & x.at_most(R::ONE);
        let in_square = within(self.u) & within(self.v);
        let in_faces = if faces > 1 {
            let last = R::new((faces - 1) as f64);
            let bounded = max(R::ZERO, min(self.face, last));
            bounded.floor().equals(self.face) & bounded.equals(self.face)
        } else {
            R::truth(true)
        };
        in_square & in_faces
    }

    /// (p, q) = (2u - 1, 2v - 1): zero at the image center.
    #[inline(always)]
    pub(crate) fn pq(self) -> (R, R) {
        let (two, one) = (R::TWO, R::ONE);
        (self.u * two - one, self.v * two - one)
    }
}

/// The part of the sphere that an image holds.
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub enum Coverage {
    /// Every direction.
    Sphere,
    /// Directions within 90° of the pole.
    Hemisphere,
    /// Directions within this many radians of the image center.
    Cap(f64),
    /// Any other part, of this many steradians: `covers` tells which.
    Part(f64),
}

impl Seam {
    /// The word for a seam.
    ///
    /// ```
    /// assert_eq!(spheremap::projections::Seam::RimOpposite.name(), "rim-opposite");
    /// ```
    pub fn name(self) -> &'static str {
        match self {
            Seam::Ends => "ends",
            Seam::Latlong => "latlong",
            Seam::Periodic => "periodic",
            Seam::Octahedral => "octahedral",
            Seam::Faces => "faces",
            Seam::RimOpposite => "rim-opposite",
            Seam::RimOtherFace => "rim-other-face",
            Seam::RimOtherFaceFlipped => "rim-other-face-flipped",
            Seam::RimMirrored => "rim-mirrored",
            Seam::Cuts => "cuts",
        }
    }
}

impl Coverage {
    /// The word for a coverage.
    ///
    /// ```
    /// assert_eq!(spheremap::projections::Coverage::Cap(1.0).name(), "cap");
    /// ```
    pub fn name(self) -> &'static str {
        match self {
            Coverage::Sphere => "sphere",
            Coverage::Hemisphere => "hemisphere",
            Coverage::Cap(_) => "cap",
            Coverage::Part(_) => "part",
        }
    }

    /// The solid angle of a coverage in steradians.
    ///
    /// ```
    /// use spheremap::projections::Coverage;
    /// assert_eq!(Coverage::Hemisphere.solid_angle(), 2.0 * std::f64::consts::PI);
    /// ```
    pub fn solid_angle(self) -> f64 {
        use std::f64::consts::PI;
        match self {
            Coverage::Sphere => 4.0 * PI,
            Coverage::Hemisphere => 2.0 * PI,
            // 1 - cos θ without its cancellation.
            Coverage::Cap(half_angle) => 4.0 * PI * angle::sin(0.5 * half_angle).powi(2),
            Coverage::Part(solid_angle) => solid_angle,
        }
    }
}

/// The part of a face's unit square that holds sphere.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum Outline {
    /// All of it.
    Square,
    /// The disk of radius ½ about (½, ½).
    Disk,
    /// What [`Projection::contains`] says.
    Shape,
}

/// What lies beyond the edge of the valid image.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum Seam {
    /// Nothing: the coverage ends there.
    Ends,
    /// u is periodic; beyond the first and last row lies the same row, half a turn around.
    Latlong,
    /// u is periodic; the coverage ends at the first and last row.
    Periodic,
    /// Beyond each edge lies the same edge, mirrored about its middle.
    Octahedral,
    /// Other faces: [`Projection::beyond`] tells which, and where.
    Faces,
    /// Across the rim of the disk lies the point opposite.
    RimOpposite,
    /// Across the rim of the disk lies the same azimuth of the other face.
    RimOtherFace,
    /// Across the rim of the disk lies the other face, with left and right exchanged.
    RimOtherFaceFlipped,
    /// Beyond the rim at (p, q) lies what the rim at (-p, q) shows: [`Projection::beyond`] tells where.
    RimMirrored,
    /// Across the edge of a net lies the edge that it was cut from: [`Projection::beyond`] tells where.
    Cuts,
}

/// An edge of a face.
#[derive(Clone, Copy, Debug)]
pub struct Edge {
    /// The face.
    pub face: f64,
    /// The coordinate that is constant on it: 0 for u, 1 for v.
    pub axis: usize,
    /// Whether that coordinate is 1 on it, else 0.
    pub high: bool,
}

impl Edge {
    /// The place at `along` and at `inset` from the edge, both in p and q, from -1 to 1 on the face.
    pub(crate) fn place(self, along: f64, inset: f64) -> Uv<f64> {
        let mut at = [along; 2];
        at[self.axis] = if self.high { 1.0 - inset } else { inset - 1.0 };
        Uv::centered(at[0], at[1], self.face)
    }
}

/// A number that a projection takes, such as a field of view.
#[derive(Clone, Copy, Debug)]
#[non_exhaustive]
pub struct Parameter {
    /// Its keyword.
    pub name: &'static str,
    /// What it is where nothing is said.
    pub default: f64,
    /// Values must be larger than this.
    pub above: f64,
    /// Values must not be larger than this.
    pub maximum: f64,
    /// Its unit.
    pub unit: &'static str,
    /// What it does, in one line.
    pub doc: &'static str,
}

/// What a projection claims about itself, apart from its parameters.
#[derive(Clone, Copy, Debug)]
#[non_exhaustive]
pub struct Info {
    /// The name it is asked for by.
    pub name: &'static str,
    /// Its full name.
    pub title: &'static str,
    /// What others call it: names that an error translates, and that are none here.
    pub known_as: &'static [&'static str],
    /// Where the formula comes from.
    pub source: &'static str,
    /// What it is and who uses it, in one line.
    pub summary: &'static str,
    /// Its singular points and what it answers there.
    pub singular: &'static str,
    /// The default axes: which world axes point right, down and forward.
    pub axes: &'static str,
    /// How many faces it has.
    pub faces: usize,
    /// The ways to lay several faces out; empty for a map of one face.
    pub layouts: &'static [LayoutSpec],
    /// The default shape of a face of size n is (n · aspect.1, n · aspect.0) rows and columns, at the
    /// default parameters: see [`Projection::size`].
    pub aspect: (usize, usize),
    /// What part of a face holds sphere.
    pub outline: Outline,
    /// Every texel sees the same solid angle.
    pub equal_area: bool,
    /// Small circles stay circles.
    pub conformal: bool,
    /// Both formulas of a face are analytic inside it, but at singular points, and its encoding, continued across its
    /// border, leaves the square or the disk: so a polynomial may stand for them.
    pub smooth: bool,
    /// Straight lines of a face, a, b and c of a p + b q = c, at which both formulas bend; on either side of each they are analytic,
    /// but at singular points. None where that is not known, or where [`Info::smooth`] says all.
    pub creases: &'static [[f64; 3]],
    /// The radians that a direction and what comes back of it through the image may be apart, in f32 and in f64, at the
    /// default parameters.
    pub round_trip: (f64, f64),
    /// The numbers it takes.
    pub parameters: &'static [Parameter],
}

impl Info {
    /// One square face without parameters that is neither equal-area nor conformal: what a projection does not say of itself.
    pub const PLAIN: Info = Info {
        name: "",
        title: "",
        known_as: &[],
        source: "",
        summary: "",
        singular: "",
        axes: "",
        faces: 1,
        layouts: &[],
        aspect: (1, 1),
        outline: Outline::Square,
        equal_area: false,
        conformal: false,
        smooth: false,
        creases: &[],
        round_trip: (9.5e-7, 2e-15),
        parameters: &[],
    };
}

/// A kind of map between the sphere and an image.
pub trait Projection: Copy + Send + Sync + 'static {
    /// Its claims.
    const INFO: Info;

    /// Whether it is asked for often enough to have kernels of its own for every verb, float type and instruction set. A
    /// rare one has half of the code: AVX-512 runs what AVX2 does, and f32 densities and derivatives are computed in f64
    /// and rounded once.
    const COMMON: bool = true;

    /// Whether encoding and decoding f32 is computed in f32, which is twice as fast. Else they as well are computed in f64.
    const SINGLE: bool = true;

    /// Whether memory, and not its formulas, decides how long large arrays take where lanes are widest: what does not fit into
    /// caches is then written past them, in 0.6 to 0.9 of the time. A twentieth is lost where that is not so, as with angles.
    const MEMORY_BOUND: bool = false;

    /// Whether dω/(du dv) is the same all along a row, as where rows are parallels.
    const EVEN_ROWS: bool = Self::INFO.equal_area;

    /// Where columns are meridians and rows parallels about the view frame's y axis: the longitude of the right edge in half
    /// turns, that of the middle being 0.
    fn graticule(self) -> Option<f64> {
        None
    }

    /// Whether these parameters, each within its range, go together; if not, what was expected and what came.
    fn check(_parameters: &[f64]) -> Result<(), String> {
        Ok(())
    }

    /// One with these parameters, in the order of [`Info::parameters`], that passed [`Projection::check`].
    fn with_parameters(parameters: &[f64]) -> Self;

    /// Calls the visitor with what computes this map: another type where these parameters allow shorter formulas.
    fn accept<V: Visitor>(self, visitor: V) -> V::Output {
        visitor.visit(self)
    }

    /// Width and height of a face of size `n`: n is its height where it is wider than high.
    fn size(self, n: usize) -> (usize, usize) {
        (
            n.saturating_mul(Self::INFO.aspect.0),
            n.saturating_mul(Self::INFO.aspect.1),
        )
    }

    /// The part of the sphere it holds.
    fn coverage(self) -> Coverage;

    /// What part of a face holds sphere with these parameters: all of it where those of a [`Outline::Shape`] cut nothing off.
    fn outline(self) -> Outline {
        Self::INFO.outline
    }

    /// The middle and the half axes, in p and q, of an ellipse all of whose places in the square are valid, where one is known. That of
    /// a [`Outline::Shape`] spares asking [`Projection::contains`] of each texel.
    fn held_ellipse(self) -> Option<[[f64; 2]; 2]> {
        (Self::INFO.outline == Outline::Disk).then_some([[0.0; 2], [1.0; 2]])
    }

    /// The area of the valid image of a face, over that of its square. An outline that is a [`Outline::Shape`] has to say.
    fn used_part(self) -> f64 {
        match Self::INFO.outline {
            Outline::Square => 1.0,
            Outline::Disk => std::f64::consts::FRAC_PI_4,
            Outline::Shape => f64::NAN,
        }
    }

    /// Smallest and largest dω/(du dv) over the valid image.
    fn density_range(self) -> (f64, f64);

    /// What lies beyond its edges.
    fn seam(self) -> Seam;

    /// The image of a direction of any length near 1. NaN outside the coverage, chosen behind every clamp.
    fn encode<R: Real>(self, d: [R; 3]) -> Uv<R>;

    /// The unit direction at a point of the valid image.
    fn decode<R: Real>(self, uv: Uv<R>) -> [R; 3];

    /// Whether `uv` lies in the valid image. Rims are let out by 8 ε, the most that encoding rounds. An outline that is a
    /// [`Outline::Shape`] is this method's own, and starts with [`Uv::in_bounds`].
    #[inline(always)]
    fn contains<R: Real>(self, uv: Uv<R>) -> R::Mask {
        let in_outline = match Self::INFO.outline {
            Outline::Square | Outline::Shape => R::truth(true),
            Outline::Disk => {
                let (p, q) = uv.pq();
                (p * p + q * q).at_most(R::new(1.0 + 8.0 * R::epsilon()))
            }
        };
        in_outline & uv.in_bounds(Self::INFO.faces)
    }

    /// The place that the image continues with beyond the edge of a face, wherever it lies: for filters that reach
    /// over edges, by up to two texels. The default is what the face's formula, continued, meets.
    fn beyond(self, uv: Uv<f64>) -> Uv<f64> {
        one::encode(self, one::decode(self, uv))
    }

    /// Where, at `inset` from an edge, the place is whose middle with its mirror image in the edge is at `along` on
    /// it; both in p and q. The default finds the foot of the perpendicular.
    fn beside(self, edge: Edge, along: f64, inset: f64) -> f64 {
        foot_of_perpendicular(self, edge, along, inset)
    }

    /// The mirror image, in an edge, of the place at `along` and `inset` from it, on the face that lies there.
    fn across(self, edge: Edge, along: f64, inset: f64) -> Uv<f64> {
        mirrored_across(self, edge, along, inset)
    }

    /// The exact solid angle that a rectangle of a face sees, rims included. The default integrates
    /// the density.
    fn solid_angle(self, rect: Rect) -> f64 {
        let quadrature = match Self::INFO.outline {
            Outline::Square => solid_angle::quadrature,
            Outline::Disk | Outline::Shape => solid_angle::outlined,
        };
        quadrature(rect, &|u, v| one::held_density(self, Uv::flat(u, v)))
    }

    /// The radius about the middle of a face within which what it shows is its own. What lies beyond counts on another face, and a solid
    /// angle is no integral of the density. ½: no face shows anything of another's.
    fn own_radius(self) -> f64 {
        0.5
    }

    /// Whether the solid angle of a rectangle is the density's by [`solid_angle::smooth`]: those of many are then found at once.
    /// The densities at its corners, no numbers beyond the image, are at hand if it asks for them.
    fn is_smooth(self, _rect: Rect, _corners: impl Fn() -> [f64; 4]) -> bool {
        false
    }

    /// The columns ∂d/∂u and ∂d/∂v, by running `decode` on dual numbers.
    #[inline(always)]
    fn jacobian<R: Real>(self, uv: Uv<R>) -> [[R; 3]; 2] {
        let [x, y, z] = self.decode(Uv {
            u: Dual::u(uv.u),
            v: Dual::v(uv.v),
            face: Dual::constant(uv.face),
        });
        [[x.du, y.du, z.du], [x.dv, y.dv, z.dv]]
    }

    /// dω/(du dv) where a closed form is known; the default takes it from the Jacobian.
    #[inline(always)]
    fn density<R: Real>(self, uv: Uv<R>) -> R {
        density(self, uv)
    }
}

pub(crate) mod one {
    //! The formulas of one place.
    //!
    //! Formulas are inlined where loops turn them into lanes. What runs place by place, as bisections, quadratures and borders do, gains
    //! nothing by a long one inlined, and has many callers: with a copy of the formula in each, cameras alone were a quarter of the library.
    //! So here those of projections that are not [`COMMON`](Projection::COMMON) are calls.

    use super::{Projection, Uv};
    use crate::kernel::Scalar;

    /// Runs a formula of a projection, the rare one's as a call.
    #[inline(always)]
    fn run<P: Projection, O>(formula: impl FnOnce() -> O) -> O {
        if const { P::COMMON } {
            formula()
        } else {
            called(formula)
        }
    }

    #[inline(never)]
    fn called<O>(formula: impl FnOnce() -> O) -> O {
        formula()
    }

    /// [`Projection::encode`].
    #[inline(always)]
    pub(crate) fn encode<P: Projection>(p: P, d: [f64; 3]) -> Uv<f64> {
        run::<P, _>(
            #[inline(always)]
            || p.encode(d),
        )
    }

    /// [`Projection::decode`].
    #[inline(always)]
    pub(crate) fn decode<P: Projection>(p: P, uv: Uv<f64>) -> [f64; 3] {
        run::<P, _>(
            #[inline(always)]
            || p.decode(uv),
        )
    }

    /// [`Projection::jacobian`].
    #[inline(always)]
    pub(crate) fn jacobian<P: Projection>(p: P, uv: Uv<f64>) -> [[f64; 3]; 2] {
        run::<P, _>(
            #[inline(always)]
            || p.jacobian(uv),
        )
    }

    /// [`Projection::density`].
    #[inline(always)]
    pub(crate) fn density<P: Projection>(p: P, uv: Uv<f64>) -> f64 {
        run::<P, _>(
            #[inline(always)]
            || p.density(uv),
        )
    }

    /// [`Projection::contains`].
    #[inline(always)]
    pub(crate) fn contains<P: Projection, R: Scalar>(p: P, uv: Uv<R>) -> bool {
        run::<P, _>(
            #[inline(always)]
            || p.contains(uv),
        )
    }

    /// [`Projection::density`] where the image holds something, and NaN elsewhere.
    #[inline(always)]
    pub(crate) fn held_density<P: Projection>(p: P, uv: Uv<f64>) -> f64 {
        if contains(p, uv) {
            density(p, uv)
        } else {
            f64::NAN
        }
    }
}

/// Something to be done with a projection whose type is known at compile time.
pub trait Visitor {
    /// What comes out of it.
    type Output;
    /// Do it.
    fn visit<P: Projection>(self, projection: P) -> Self::Output;
}

/// Width and height of an image of height `n` and this aspect, for [`Projection::size`].
pub fn size_of_aspect(aspect: f64, n: usize) -> (usize, usize) {
    (((n as f64 * aspect).round() as usize).max(1), n)
}

/// dω/(du dv) = |∂d/∂u × ∂d/∂v|.
#[inline(always)]
pub fn density<P: Projection, R: Real>(projection: P, uv: Uv<R>) -> R {
    let [a, b] = projection.jacobian(uv);
    let x = a[1] * b[2] - a[2] * b[1];
    let y = a[2] * b[0] - a[0] * b[2];
    let z = a[0] * b[1] - a[1] * b[0];
    (x * x + y * y + z * z).sqrt()
}

/// A point of an edge and the unit vector along it.
fn on_edge<P: Projection>(projection: P, edge: Edge, along: f64) -> ([f64; 3], [f64; 3]) {
    const STEP: f64 = 1e-4;
    let at = |along: f64| one::decode(projection, edge.place(along.clamp(-1.0, 1.0), 0.0));
    let (before, after) = (at(along - STEP), at(along + STEP));
    let tangent = [0, 1, 2].map(|k| after[k] - before[k]);
    let length = dot(tangent, tangent).sqrt();
    (at(along), tangent.map(|x| x / length))
}

/// [`Projection::beside`] of any formula: where the row at `inset` meets the plane across the edge.
fn foot_of_perpendicular<P: Projection>(projection: P, edge: Edge, along: f64, inset: f64) -> f64 {
    let (point, tangent) = on_edge(projection, edge, along);
    let ahead = |x: f64| {
        let d = one::decode(projection, edge.place(x, inset));
        [0, 1, 2]
            .iter()
            .map(|&k| (d[k] - point[k]) * tangent[k])
            .sum::<f64>()
    };
    // A secant: rows are as good as straight over half a texel.
    let (mut x0, mut x1) = (along, (along + 0.5 * inset).min(along * (1.0 - inset)));
    let (mut y0, mut y1) = (ahead(x0), ahead(x1));
    for _ in 0..8 {
        if y1 == y0 {
            break;
        }
        let x = (x1 - y1 * (x1 - x0) / (y1 - y0)).clamp(-1.0, 1.0);
        (x0, y0) = (x1, y1);
        (x1, y1) = (x, ahead(x));
    }
    x1
}

/// [`Projection::across`] of any formula: the mirror image in the plane of the edge's great circle.
fn mirrored_across<P: Projection>(projection: P, edge: Edge, along: f64, inset: f64) -> Uv<f64> {
    let (point, tangent) = on_edge(projection, edge, along);
    let normal = [
        point[1] * tangent[2] - point[2] * tangent[1],
        point[2] * tangent[0] - point[0] * tangent[2],
        point[0] * tangent[1] - point[1] * tangent[0],
    ];
    let d = one::decode(projection, edge.place(along, inset));
    let depth = 2.0 * dot(d, normal);
    one::encode(projection, [0, 1, 2].map(|k| d[k] - depth * normal[k]))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::projections::{Cube, CubeEqualArea, CubeEquiangular, CubeQuadratic};

    fn edges() -> impl Iterator<Item = Edge> {
        (0..24).map(|k| Edge {
            face: f64::from(k / 4),
            axis: k as usize % 2,
            high: k % 4 > 1,
        })
    }

    /// What any formula finds is what the cube's closed forms say.
    fn check<P: Projection>(p: P) {
        for edge in edges() {
            for k in -9..=9 {
                let (along, inset) = (0.1 * f64::from(k), 0.02);
                let found = foot_of_perpendicular(p, edge, along, inset);
                assert!((found - p.beside(edge, along, inset)).abs() < 1e-7);
                let (a, b) = (
                    p.decode(mirrored_across(p, edge, along, inset)),
                    p.decode(p.across(edge, along, inset)),
                );
                assert!(
                    (0..3).all(|k| (a[k] - b[k]).abs() < 1e-7),
                    "{edge:?} {along}"
                );
            }
        }
    }

    #[test]
    fn mirror_images_of_cubes_are_those_of_any_formula() {
        check(Cube);
        check(CubeEquiangular::with_parameters(&[]));
        check(CubeQuadratic::with_parameters(&[]));
    }

    /// Faces of one cube are mirror images: the place at `inset` comes to the place at `inset`.
    #[test]
    fn texels_along_an_edge_are_opposite_each_other() {
        for edge in edges() {
            for k in -9..=9 {
                let (along, inset) = (0.1 * f64::from(k), 0.02);
                let p = CubeEqualArea;
                let there = p.across(edge, along, inset);
                assert!(there.face != edge.face);
                let (u, v) = there.pq();
                let depth = (1.0 - u.abs()).min(1.0 - v.abs());
                assert!((depth - inset).abs() < 1e-7, "{edge:?} {along}: {depth}");
            }
        }
    }
}
