//! The double-sphere camera: two unit spheres ξ apart, then a pinhole between the second's center and its pole.
//!
//! Source: Usenko, Demmel & Cremers 2018, The Double Sphere Camera Model, equations 40 to 52: with d1 = |d|
//! and d2 = √(x² + y² + (ξ d1 + z)²) the image is (x, y)/(α d2 + (1 - α)(ξ d1 + z)), here over its radius at
//! fov/2. It fits fisheyes as well as a polynomial of four terms, and has a closed inverse. α = 0 is the
//! unified camera.
//!
//! Domain: directions within fov/2 of the axis, else NaN; fov/2 must stay below the angle at which the image ends or
//! turns back. There z + ξ d1 = -w1 d2, with the paper's w1: solved for z, the cosine is -ξ(1 - w1²) - w1√(1 - ξ²(1 - w1²)).
//! The -w2 of equation 43 is another number, as it takes d2 for 1: of ξ = -0.2 and α = 0.6 it says 122.1° where the image ends
//! at 123.2°, and of ξ = α = 1, which is the equisolid lens r = sin(θ/2), 135° where it ends at 180°. Singular: none in the image.

use crate::geometry::solid_angle::Rect;
use crate::number::angle;
use crate::number::real::{Real, max};
use crate::projections::common::lens;
use crate::projections::projection::one;
use crate::projections::projection::{Coverage, Info, Outline, Parameter, Projection, Seam, Uv};

/// Two spheres.
#[derive(Clone, Copy, Debug)]
pub struct DoubleSphere {
    xi: f64,
    alpha: f64,
    /// The angle of the rim from the axis, in radians.
    angle: f64,
    /// The image radius there.
    radius: f64,
    /// Directions of a smaller cosine are not seen.
    least_cosine: f64,
}

impl DoubleSphere {
    fn new(parameters: &[f64]) -> Self {
        let (xi, alpha) = (parameters[1], parameters[2]);
        let (sin, cos) = f64::sin_cos_half_turns(parameters[0] / 360.0);
        let w1 = if alpha <= 0.5 {
            alpha / (1.0 - alpha)
        } else {
            (1.0 - alpha) / alpha
        };
        let k = (1.0 - w1) * (1.0 + w1);
        let mut lens = DoubleSphere {
            xi,
            alpha,
            angle: lens::rim(parameters[0]),
            radius: 1.0,
            least_cosine: -xi * k - w1 * (1.0 - xi * xi * k).sqrt(),
        };
        lens.radius = sin / lens.depth(1.0, cos, sin * sin).0;
        lens
    }

    /// The divisor of the image coordinates and d2, from |d|, z and x² + y².
    #[inline(always)]
    fn depth<R: Real>(self, length: R, z: R, s: R) -> (R, R) {
        let ahead = R::new(self.xi) * length + z;
        let far = (s + ahead * ahead).sqrt();
        (
            R::new(self.alpha) * far + R::new(1.0 - self.alpha) * ahead,
            far,
        )
    }

    /// (factor, z) of the direction (factor a, factor b, z) at (a, b) on the image plane, from s = a² + b².
    #[inline(always)]
    fn unproject<R: Real>(self, s: R) -> (R, R) {
        let (one, xi) = (R::ONE, R::new(self.xi));
        let inner = max(one - R::new(2.0 * self.alpha - 1.0) * s, R::ZERO);
        let mz = (one - R::new(self.alpha * self.alpha) * s)
            / (R::new(self.alpha) * inner.sqrt() + R::new(1.0 - self.alpha));
        let square = mz * mz;
        let root = (square + R::new((1.0 - self.xi) * (1.0 + self.xi)) * s).sqrt();
        let factor = (mz * xi + root) / (square + s);
        (factor, factor * mz - xi)
    }

    /// dθ/d(image radius) times sin θ over that radius.
    #[inline(always)]
    fn density_at<R: Real>(self, cosine: R, sine_square: R) -> R {
        let (one, xi) = (R::ONE, R::new(self.xi));
        let (depth, far) = self.depth(one, cosine, sine_square);
        let slope = (one + xi * cosine)
            * (R::new(1.0 - self.alpha) + R::new(self.alpha) * (cosine + xi) / far);
        depth * depth * depth / slope
    }
}

impl Projection for DoubleSphere {
    const INFO: Info = Info {
        name: "double_sphere",
        title: "Double-sphere camera",
        source: "Usenko, Demmel, Cremers 2018, The Double Sphere Camera Model, eq. 40-52",
        summary: "Two spheres and a pinhole: calibrated fisheyes of robots and 360 rigs, with a closed inverse.",
        singular: "None in the image.",
        axes: "+x -y -z",
        outline: Outline::Disk,
        parameters: &[
            lens::fov(180.0, 359.0),
            Parameter {
                name: "xi",
                default: -0.2,
                above: -1.0,
                maximum: 1.0,
                unit: "radii",
                doc: "how far the second sphere's center lies before the first's",
            },
            Parameter {
                name: "alpha",
                default: 0.6,
                above: 0.0,
                maximum: 1.0,
                unit: "",
                doc: "where the pinhole lies, as alpha/(1 - alpha) behind the second sphere's center",
            },
        ],
        smooth: true,
        ..Info::PLAIN
    };

    const COMMON: bool = false;

    fn check(parameters: &[f64]) -> Result<(), String> {
        let lens = DoubleSphere::new(parameters);
        let slope = |angle: f64| {
            let (sin, cos) = angle::sin_cos(angle);
            let (depth, far) = lens.depth(1.0, cos, sin * sin);
            if cos > lens.least_cosine && depth > 0.0 {
                (1.0 + lens.xi * cos) * (1.0 - lens.alpha + lens.alpha * (cos + lens.xi) / far)
                    / (depth * depth)
            } else {
                0.0
            }
        };
        lens::grows(lens.angle, &slope, lens.radius, "`xi` and `alpha`")
    }

    fn with_parameters(parameters: &[f64]) -> Self {
        DoubleSphere::new(parameters)
    }

    fn coverage(self) -> Coverage {
        Coverage::Cap(self.angle)
    }

    fn density_range(self) -> (f64, f64) {
        lens::extremes(1.0, &|r| one::density(self, Uv::centered(r, 0.0, 0.0)))
    }

    fn seam(self) -> Seam {
        Seam::Ends
    }

    #[inline(always)]
    fn encode<R: Real>(self, [x, y, z]: [R; 3]) -> Uv<R> {
        let s = x * x + y * y;
        let length = (s + z * z).sqrt();
        let (depth, _) = self.depth(length, z, s);
        let ahead = z.more(R::new(self.least_cosine) * length);
        let factor = R::new(1.0 / self.radius) / depth;
        Uv::in_disk(x * factor, y * factor, ahead)
    }

    #[inline(always)]
    fn decode<R: Real>(self, uv: Uv<R>) -> [R; 3] {
        let (p, q) = uv.pq();
        let (a, b) = (p * R::new(self.radius), q * R::new(self.radius));
        let (factor, z) = self.unproject(a * a + b * b);
        [factor * a, factor * b, z]
    }

    fn is_smooth(self, rect: Rect, _corners: impl Fn() -> [f64; 4]) -> bool {
        lens::is_smooth(rect)
    }

    fn solid_angle(self, rect: Rect) -> f64 {
        let theta = |r: f64| {
            let r = r * self.radius;
            let (factor, z) = self.unproject(r * r);
            angle::atan2(factor * r, z)
        };
        lens::solid_angle(rect, |u, v| one::density(self, Uv::flat(u, v)), theta)
    }

    #[inline(always)]
    fn density<R: Real>(self, uv: Uv<R>) -> R {
        let (p, q) = uv.pq();
        let (a, b) = (p * R::new(self.radius), q * R::new(self.radius));
        let s = a * a + b * b;
        let (factor, z) = self.unproject(s);
        R::new(4.0 * self.radius * self.radius) * self.density_at(z, factor * factor * s)
    }
}
