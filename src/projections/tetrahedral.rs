//! Tetrahedral: the sphere on a tetrahedron, unrolled into one rectangle without a gap.
//!
//! Source: ffmpeg's `tetrahedron` of v360, upright: the surface max(x - y + z, -x + y + z, x + y - z, -x - y - z) = 1, a
//! tetrahedron in the cube of ±1. Cut open along two opposite edges and one between, it is a band: y runs down it,
//! x to and fro along it. Every face is a gnomonic picture.
//!
//! Domain: all directions. u is periodic; the top and the bottom edge are each folded on themselves, u to 1 - u. Singular:
//! none, but the four vertices see texels 27 times smaller than the middles of the faces do.

use crate::geometry::solid_angle;
use crate::geometry::solid_angle::Rect;
use crate::number::real::{Real, max};
use crate::projections::projection;
use crate::projections::projection::{Coverage, Info, Projection, Seam, Uv};

/// An unrolled tetrahedron.
#[derive(Clone, Copy, Debug)]
pub struct Tetrahedral;

/// Width over height of the unrolled band: two edges over the height of a face.
const ASPECT: f64 = 2.309_401_076_758_503;

/// Where the band is folded, u = ½, u = v/2 and u = (1 + v)/2: [`Info::creases`].
const FOLDS: [[f64; 3]; 3] = [[1.0, 0.0, 0.0], [2.0, -1.0, -1.0], [2.0, -1.0, 1.0]];

/// The point of the tetrahedron at (u, v).
#[inline(always)]
fn surface<R: Real>(u: R, v: R) -> [R; 3] {
    let (one, two, three, four) = (R::ONE, R::TWO, R::new(3.0), R::new(4.0));
    let left = u.less(R::HALF);
    let x = R::either(left, || four * u - one, || three - four * u);
    let lean = (one - (one - two * u + v).abs()).abs();
    [x, two * v - one, one - two * lean]
}

impl Projection for Tetrahedral {
    const INFO: Info = Info {
        name: "tetrahedral",
        title: "Tetrahedral",
        known_as: &["tetrahedron"],
        source: "Unrolled tetrahedron; ffmpeg v360 tetrahedron",
        summary: "Four gnomonic triangles unrolled into one rectangle without a gap; ffmpeg's tetrahedron.",
        singular: "None; the density falls to 1/27 at the four vertices.",
        axes: "+x -y -z",
        aspect: (7, 3),
        creases: &FOLDS,
        ..Info::PLAIN
    };

    const COMMON: bool = false;

    fn with_parameters(_: &[f64]) -> Self {
        Tetrahedral
    }

    fn size(self, n: usize) -> (usize, usize) {
        projection::size_of_aspect(ASPECT, n)
    }

    fn coverage(self) -> Coverage {
        Coverage::Sphere
    }

    fn density_range(self) -> (f64, f64) {
        (8.0 / 27_f64.sqrt(), 8.0 * 27_f64.sqrt())
    }

    fn seam(self) -> Seam {
        Seam::Cuts
    }

    #[inline(always)]
    fn encode<R: Real>(self, [x, y, z]: [R; 3]) -> Uv<R> {
        let (quarter, half) = (R::new(0.25), R::HALF);
        // The larger of two faces each.
        let (left, right) = (z + (x - y).abs(), (x + y).abs() - z);
        let n = R::ONE / max(left, right);
        let along = (x * n).clamped(-1.0, 1.0) * quarter;
        let on_left = left.at_least(right);
        Uv::flat(
            R::either(on_left, || quarter + along, || R::new(0.75) - along),
            (y * n).clamped(-1.0, 1.0) * half + half,
        )
    }

    #[inline(always)]
    fn decode<R: Real>(self, uv: Uv<R>) -> [R; 3] {
        let [x, y, z] = surface(uv.u, uv.v);
        let n = R::ONE / (x * x + y * y + z * z).sqrt();
        [x * n, y * n, z * n]
    }

    fn beyond(self, uv: Uv<f64>) -> Uv<f64> {
        let (u, v) = if uv.v < 0.0 {
            (1.0 - uv.u, -uv.v)
        } else if uv.v > 1.0 {
            (1.0 - uv.u, 2.0 - uv.v)
        } else {
            (uv.u, uv.v)
        };
        Uv::flat(u.rem_euclid(1.0), v)
    }

    /// A rectangle is cut where the band is folded: at u = ½, u = v/2 and u = (1 + v)/2.
    fn solid_angle(self, rect: Rect) -> f64 {
        let corners = [
            [rect.u0, rect.v0],
            [rect.u1, rect.v0],
            [rect.u1, rect.v1],
            [rect.u0, rect.v1],
        ];
        let mut sum = 0.0;
        for right in [false, true] {
            for steep in [false, true] {
                // What lies on one side of u = ½ and on one side of that half's fold.
                let start = if right { 0.5 } else { 0.0 };
                let half = solid_angle::clip(&corners, |[u, _]| {
                    (u - 0.5) * if right { 1.0 } else { -1.0 }
                });
                let part = solid_angle::clip(half.corners(), |[u, v]| {
                    ((u - start) - 0.5 * v) * if steep { 1.0 } else { -1.0 }
                });
                // From inside, so that a point on a fold counts with this face.
                let lift = |[u, v]: [f64; 2]| {
                    let x = if right { 3.0 - 4.0 * u } else { 4.0 * u - 1.0 };
                    let y = 2.0 * v - 1.0;
                    let z = match (right, steep) {
                        (false, true) => 1.0 - x + y,
                        (false, false) => 1.0 + x - y,
                        (true, true) => -1.0 - x - y,
                        (true, false) => x + y - 1.0,
                    };
                    [x, y, z]
                };
                sum += part.solid_angle(lift);
            }
        }
        sum
    }

    #[inline(always)]
    fn density<R: Real>(self, uv: Uv<R>) -> R {
        let [x, y, z] = surface(uv.u, uv.v);
        let s = x * x + y * y + z * z;
        R::new(8.0) / (s * s.sqrt())
    }
}
