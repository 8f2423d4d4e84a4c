//! The octahedral map: the sphere on an octahedron, unfolded to a square.
//!
//! Source: Meyer, Süßmuth, Sußner, Stamminger, Greiner 2010, On Floating-Point Normal Vectors; survey
//! and code in Cigolle et al. 2014. N.xy / |N|₁ is the place in the inner diamond; the lower half is folded
//! outward over its edges.
//!
//! Domain: all directions; no singular point; the density varies 5.196:1. The fold takes sign(±0) = +1: with
//! sign(0) = 0 the direction -z would encode to the center, an error of π. -z encodes to (1, 1).

use crate::geometry::solid_angle;
use crate::geometry::solid_angle::Rect;
use crate::number::real::{Real, min, sign};
use crate::projections::projection::{Coverage, Info, Projection, Seam, Uv};

/// The edges of the octahedron in its square: [`Info::creases`].
pub(super) const EDGES: [[f64; 3]; 6] = [
    [1.0, 0.0, 0.0],
    [0.0, 1.0, 0.0],
    [1.0, 1.0, 1.0],
    [1.0, 1.0, -1.0],
    [1.0, -1.0, 1.0],
    [1.0, -1.0, -1.0],
];

/// The full octahedron.
#[derive(Clone, Copy, Debug)]
pub struct Octahedral;

impl Projection for Octahedral {
    const INFO: Info = Info {
        name: "octahedral",
        title: "Octahedral map",
        known_as: &["octahedron", "oct"],
        source: "Meyer et al. 2010, On Floating-Point Normal Vectors; Cigolle et al. 2014",
        summary: "The sphere on an octahedron, unfolded to a square; normals in two numbers, probes in one image.",
        singular: "None; -z is all four corners and encodes to (1, 1).",
        axes: "+x +y +z",
        creases: &EDGES,
        ..Info::PLAIN
    };
    const MEMORY_BOUND: bool = true;

    fn with_parameters(_: &[f64]) -> Self {
        Octahedral
    }

    fn coverage(self) -> Coverage {
        Coverage::Sphere
    }

    fn density_range(self) -> (f64, f64) {
        (4.0, 4.0 * 27f64.sqrt())
    }

    fn seam(self) -> Seam {
        Seam::Octahedral
    }

    #[inline(always)]
    fn encode<R: Real>(self, [x, y, z]: [R; 3]) -> Uv<R> {
        let one = R::ONE;
        let sum = x.abs() + y.abs() + z.abs();
        let (p, q) = (x / sum, y / sum);
        let below = z.less(R::ZERO);
        let folded_p = (one - q.abs()) * sign(p);
        let folded_q = (one - p.abs()) * sign(q);
        Uv::centered(
            R::select(below, folded_p, p),
            R::select(below, folded_q, q),
            R::ZERO,
        )
    }

    #[inline(always)]
    fn decode<R: Real>(self, uv: Uv<R>) -> [R; 3] {
        let (p, q) = uv.pq();
        let z = R::ONE - p.abs() - q.abs();
        let below = min(z, R::ZERO);
        let x = p + sign(p) * below;
        let y = q + sign(q) * below;
        let inverse = R::ONE / (x * x + y * y + z * z).sqrt();
        [x * inverse, y * inverse, z * inverse]
    }

    fn solid_angle(self, rect: Rect) -> f64 {
        solid_angle::octahedral(rect)
    }
}
