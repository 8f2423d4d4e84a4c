//! MatCap: the unit normal itself, seen from the front.
//!
//! Source: the lit-sphere shading of Sloan et al. 2001, as modelling programs use it: a material is
//! a picture of a ball, looked up by the normal in view space, u = nx/2 + ½, v = ny/2 + ½. The same map
//! is the orthographic view of a hemisphere.
//!
//! Toward the rim an error δ of a coordinate turns the direction by √(2δ). Encoding therefore
//! normalises twice: the second time by the remainder 1 - |n|², computed without rounding from the first
//! result. It costs as much as the division that it makes unnecessary.
//!
//! Domain: z ≥ 0; behind it NaN. Singular: the rim, where the density 4/√(1-p²-q²) grows without bound
//! and a coordinate rounded by ε moves the direction by √ε.

use crate::light::solid_angle::{self, Rect};
use crate::projection::{Coverage, Info, Outline, Projection, Seam, Uv};
use crate::real::{Real, max};

/// x² as a part that is exact on the grid's square and the small rest, (rest, exact part).
#[inline(always)]
fn square<R: Real>(x: R, grid: R) -> (R, R) {
    let head = (x + grid) - grid;
    let tail = x - head;
    (tail * (x + head), head * head)
}

/// The lit sphere.
#[derive(Clone, Copy, Debug)]
pub struct Matcap;

impl Projection for Matcap {
    const INFO: Info = Info {
        name: "matcap",
        title: "MatCap (lit sphere)",
        source: "Sloan, Martin, Gooch, Gooch 2001, The Lit Sphere, section 3",
        summary: "The view-space normal as a place on the picture of a ball.",
        singular: "The density grows without bound toward the rim.",
        axes: "+x -y +z",
        faces: 1,
        layouts: &[],
        aspect: (1, 1),
        outline: Outline::Disk,
        equal_area: false,
        conformal: false,
        parameters: &[],
    };

    fn with_parameters(_: &[f64]) -> Self {
        Matcap
    }

    fn coverage(self) -> Coverage {
        Coverage::Hemisphere
    }

    fn density_range(self) -> (f64, f64) {
        (4.0, f64::INFINITY)
    }

    fn seam(self) -> Seam {
        Seam::Ends
    }

    #[inline(always)]
    fn encode<R: Real>(self, [x, y, z]: [R; 3]) -> Uv<R> {
        let inverse = R::new(1.0) / (x * x + y * y + z * z).sqrt();
        let (p, q, r) = (x * inverse, y * inverse, z * inverse);
        // 1 - |n|², exactly: heads on a grid so coarse that their squares and sums round nothing.
        let grid = R::new(if R::EPSILON > 1e-10 { 1.5 * 2048.0 } else { 1.5 * 67_108_864.0 });
        let (pe, p_square) = square(p, grid);
        let (qe, q_square) = square(q, grid);
        let (re, r_square) = square(r, grid);
        let excess = ((R::new(1.0) - p_square) - q_square) - r_square;
        let half = (excess - (pe + qe + re)) * R::new(0.5);
        let uv = Uv::centred(
            (p + p * half).clamped(-1.0, 1.0),
            (q + q * half).clamped(-1.0, 1.0),
            R::new(0.0),
        );
        let nan = R::new(f64::NAN);
        let front = z >= R::new(0.0);
        Uv {
            u: if front { uv.u } else { nan },
            v: if front { uv.v } else { nan },
            face: uv.face,
        }
    }

    #[inline(always)]
    fn decode<R: Real>(self, uv: Uv<R>) -> [R; 3] {
        let (p, q) = uv.pq();
        [p, q, max(R::new(1.0) - (p * p + q * q), R::new(0.0)).sqrt()]
    }

    fn solid_angle(self, rect: Rect) -> f64 {
        solid_angle::matcap(rect)
    }

    #[inline(always)]
    fn density<R: Real>(self, uv: Uv<R>) -> R {
        let (p, q) = uv.pq();
        R::new(4.0) / max(R::new(1.0) - (p * p + q * q), R::new(0.0)).sqrt()
    }
}
