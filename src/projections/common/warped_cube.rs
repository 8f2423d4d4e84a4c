//! Cube maps whose faces are stretched along each axis, so that texels see more nearly the same solid angle.
//!
//! A warp is an odd function w of one face coordinate in [-1, 1] to the gnomonic one, p → tan of an angle, with w(1) = 1.
//! Faces, their order and their layouts are those of `cube`. Because all faces have the same warp, two that meet are
//! mirror images of each other in the plane of their edge, and texels along it are opposite each other.
//!
//! A warp divides as late as it can: it is given a component and the largest one, not their quotient.

use crate::geometry::solid_angle;
use crate::geometry::solid_angle::Rect;
use crate::number::real::Real;
use crate::projections::cube::{from_face, to_face};
use crate::projections::faces::CUBE_LAYOUTS;
use crate::projections::projection::one;
use crate::projections::projection::{Coverage, Edge, Info, Projection, Seam, Uv};
use std::fmt::Debug;

/// A function of one face coordinate to the gnomonic one.
pub trait Warp: Copy + Debug + Send + Sync + 'static {
    /// Claims that are its own.
    const NAMES: Names;

    /// As for a projection.
    const MEMORY_BOUND: bool = false;

    /// Smallest and largest dω/(du dv).
    fn density_range() -> (f64, f64);

    /// w(p).
    fn to_plane<R: Real>(p: R) -> R;

    /// The p with w(p) = component/major, major > 0.
    fn from_plane<R: Real>(component: R, major: R) -> R;

    /// dw/dp, given p and w(p).
    fn slope<R: Real>(p: R, plane: R) -> R;

    /// w(p1) - w(p0), given p1 - p0 > 0: without losing the digits of a narrow texel.
    fn width(p0: f64, p1: f64, difference: f64) -> f64;
}

/// The words of a warp.
pub struct Names {
    /// [`Info::name`].
    pub name: &'static str,
    /// [`Info::title`].
    pub title: &'static str,
    /// [`Info::known_as`].
    pub known_as: &'static [&'static str],
    /// [`Info::source`].
    pub source: &'static str,
    /// [`Info::summary`].
    pub summary: &'static str,
    /// [`Info::smooth`].
    pub smooth: bool,
    /// [`Info::creases`].
    pub creases: &'static [[f64; 3]],
}

/// A cube map with a warp.
#[derive(Clone, Copy, Debug)]
pub struct Warped<W>(std::marker::PhantomData<W>);

// Derived, it would ask for one of the warp.
impl<W> Default for Warped<W> {
    fn default() -> Self {
        Warped(std::marker::PhantomData)
    }
}

/// The farthest that warps are continued, in p: there is no direction beyond twice a face.
const FARTHEST: f64 = 1.75;

impl<W: Warp> Projection for Warped<W> {
    const INFO: Info = Info {
        name: W::NAMES.name,
        title: W::NAMES.title,
        known_as: W::NAMES.known_as,
        source: W::NAMES.source,
        summary: W::NAMES.summary,
        singular: "None; on ties x wins over y wins over z.",
        axes: "+x -y +z",
        faces: 6,
        layouts: CUBE_LAYOUTS,
        smooth: W::NAMES.smooth,
        creases: W::NAMES.creases,
        ..Info::PLAIN
    };
    const MEMORY_BOUND: bool = W::MEMORY_BOUND;

    fn with_parameters(_: &[f64]) -> Self {
        Warped(std::marker::PhantomData)
    }

    fn coverage(self) -> Coverage {
        Coverage::Sphere
    }

    fn density_range(self) -> (f64, f64) {
        W::density_range()
    }

    fn seam(self) -> Seam {
        Seam::Faces
    }

    #[inline(always)]
    fn encode<R: Real>(self, d: [R; 3]) -> Uv<R> {
        let ([p, q], major, face) = to_face(d);
        Uv::centered(W::from_plane(p, major), W::from_plane(q, major), face)
    }

    #[inline(always)]
    fn decode<R: Real>(self, uv: Uv<R>) -> [R; 3] {
        let (p, q) = uv.pq();
        from_face([W::to_plane(p), W::to_plane(q)], uv.face)
    }

    fn beyond(self, uv: Uv<f64>) -> Uv<f64> {
        let (p, q) = uv.pq();
        let [p, q] = [p, q].map(|x| x.clamped(-FARTHEST, FARTHEST));
        one::encode(self, one::decode(self, Uv::centered(p, q, uv.face)))
    }

    fn beside(self, _: Edge, along: f64, inset: f64) -> f64 {
        // In the plane (row, y) and (1, y/row) are mirror images: their middle is at 2y/(1 + row).
        let row = W::to_plane(1.0 - inset);
        W::from_plane(W::to_plane(along) * (1.0 + row), 2.0)
    }

    fn across(self, edge: Edge, along: f64, inset: f64) -> Uv<f64> {
        let row = W::to_plane(1.0 - inset).max(1e-6);
        let mut at = [W::to_plane(along) / row; 2];
        at[edge.axis] = if edge.high { 1.0 / row } else { -1.0 / row };
        one::encode(self, from_face(at, edge.face))
    }

    fn solid_angle(self, rect: Rect) -> f64 {
        let axis = |x0: f64, x1: f64| {
            let (p0, p1) = (2.0 * x0 - 1.0, 2.0 * x1 - 1.0);
            (
                [W::to_plane(p0), W::to_plane(p1)],
                W::width(p0, p1, 2.0 * (x1 - x0)),
            )
        };
        let ((p, dp), (q, dq)) = (axis(rect.u0, rect.u1), axis(rect.v0, rect.v1));
        solid_angle::plane_rectangle(p, q, dp * dq)
    }

    #[inline(always)]
    fn density<R: Real>(self, uv: Uv<R>) -> R {
        let (p, q) = uv.pq();
        let (a, b) = (W::to_plane(p), W::to_plane(q));
        let w = R::ONE + a * a + b * b;
        R::new(4.0) * W::slope(p, a) * W::slope(q, b) / (w * w.sqrt())
    }
}
