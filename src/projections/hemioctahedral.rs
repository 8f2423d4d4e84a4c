//! The hemi-octahedral map: the upper half of the octahedron, turned by 45° to fill the square.
//!
//! Source: Cigolle et al. 2014, A Survey of Efficient Representations for Independent Unit Vectors,
//! section 3.3: after N /= |N|₁ the coordinates are (x + y, x - y).
//!
//! Domain: z ≥ 0; below it NaN. No singular point; the density varies 5.196:1. The border is the equator.

use crate::geometry::solid_angle;
use crate::geometry::solid_angle::Rect;
use crate::number::real::{Real, max};
use crate::projections::projection::{Coverage, Info, Projection, Seam, Uv};

/// Where a square's diagonals are: [`Info::creases`].
pub(super) const DIAGONALS: [[f64; 3]; 2] = [[1.0, 1.0, 0.0], [1.0, -1.0, 0.0]];

/// Half an octahedron.
#[derive(Clone, Copy, Debug)]
pub struct Hemioctahedral;

impl Projection for Hemioctahedral {
    const INFO: Info = Info {
        name: "hemioctahedral",
        title: "Hemi-octahedral map",
        known_as: &["hemioct"],
        source: "Cigolle et al. 2014, A Survey of Efficient Representations for Independent Unit Vectors",
        summary: "The upper half of the octahedron, turned to fill the square; normals that face the viewer.",
        singular: "None; the border is the equator.",
        axes: "+x +y +z",
        creases: &DIAGONALS,
        ..Info::PLAIN
    };
    const MEMORY_BOUND: bool = true;

    fn with_parameters(_: &[f64]) -> Self {
        Hemioctahedral
    }

    fn coverage(self) -> Coverage {
        Coverage::Hemisphere
    }

    fn density_range(self) -> (f64, f64) {
        (2.0, 2.0 * 27f64.sqrt())
    }

    fn seam(self) -> Seam {
        Seam::Ends
    }

    #[inline(always)]
    fn encode<R: Real>(self, [x, y, z]: [R; 3]) -> Uv<R> {
        let sum = x.abs() + y.abs() + z.abs();
        let above = z.at_least(R::ZERO);
        let sum = R::select(above, sum, R::NAN);
        Uv::centered((x + y) / sum, (x - y) / sum, R::ZERO)
    }

    #[inline(always)]
    fn decode<R: Real>(self, uv: Uv<R>) -> [R; 3] {
        let (p, q) = uv.pq();
        let half = R::HALF;
        let (x, y) = ((p + q) * half, (p - q) * half);
        // |x| + |y| is the larger of |p| and |q|, which costs no rounding on the border.
        let z = R::ONE - max(p.abs(), q.abs());
        let inverse = R::ONE / (x * x + y * y + z * z).sqrt();
        [x * inverse, y * inverse, z * inverse]
    }

    fn solid_angle(self, rect: Rect) -> f64 {
        solid_angle::hemioctahedral(rect)
    }
}
