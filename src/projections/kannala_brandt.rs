//! The Kannala–Brandt lens: a fisheye's radius as an odd polynomial of the angle, as OpenCV's `cv2.fisheye` has it.
//!
//! Source: Kannala & Brandt 2006, A Generic Camera Model and Calibration Method for Conventional, Wide-Angle, and
//! Fish-Eye Lenses, equation 6, in OpenCV's normalization: θd = θ (1 + k1 θ² + k2 θ⁴ + k3 θ⁶ + k4 θ⁸), θ in
//! radians from the axis, and the radius θd/θd(fov/2). With all k = 0 it is the equidistant fisheye. A picture that
//! is not a whole image circle with the axis in the middle is a crop of this map: OpenCV's focal length f is
//! half the circle's diameter in pixels over θd(fov/2).
//!
//! Domain: directions within fov/2 of the axis, else NaN; the polynomial must grow up to there. Singular: none in the
//! image, but at 360° the direction opposite the axis, which fills the rim.
//!
//! The inverse has no closed form. θ² is a smooth function of θd² (which θ of θd is not in two dimensions, at the
//! axis), so Newton's method solves w P(w)² = θd² for w = θ². It starts from a polynomial through eight places,
//! found when the map is made, and takes two steps (one in f32) where that reaches rounding everywhere, as for
//! usual lenses, or else three more; the map is refused if those do not, as for coefficients that no lens has.

use crate::geometry::solid_angle::Rect;
use crate::number::angle;
use crate::number::real::{Real, SINGLE, min, scaled};
use crate::projections::common::lens;
use crate::projections::projection::one;
use crate::projections::projection::{Coverage, Info, Outline, Parameter, Projection, Seam, Uv};
use std::f64::consts::PI;

/// How many places the first guess goes through.
const NODES: usize = 8;
/// Further steps of Newton's method where the guess is poor.
const MORE: usize = 3;

/// A lens with a polynomial.
#[derive(Clone, Copy, Debug)]
pub struct KannalaBrandt {
    /// The angle of the rim from the axis, in half turns.
    rim: f64,
    /// The polynomial there.
    radius: f64,
    /// Its coefficients for angles in half turns.
    k: [f64; 4],
    /// Coefficients of w/S by S/radius², the first guess.
    guess: [f64; NODES],
    /// Whether it is so good that two steps from it do.
    close: bool,
}

const fn coefficient(name: &'static str, doc: &'static str) -> Parameter {
    Parameter {
        name,
        default: 0.0,
        above: -2.0,
        maximum: 2.0,
        unit: "",
        doc,
    }
}

impl KannalaBrandt {
    /// P(w): the radius over the angle.
    #[inline(always)]
    fn stretch<R: Real>(self, w: R) -> R {
        let [a, b, c, d] = self.k.map(R::new);
        R::ONE + w * (a + w * (b + w * (c + w * d)))
    }

    /// 2w P'(w).
    #[inline(always)]
    fn bend<R: Real>(self, w: R) -> R {
        let [a, b, c, d] = self.k;
        let [a, b, c, d] = [2.0 * a, 4.0 * b, 6.0 * c, 8.0 * d].map(R::new);
        w * (a + w * (b + w * (c + w * d)))
    }

    /// About the square of the angle, in half turns, whose radius has the square `s`.
    #[inline(always)]
    fn first<R: Real>(self, s: R) -> R {
        let x = s * R::new(1.0 / (self.radius * self.radius));
        let [a, b, c, d, e, f, g, h] = self.guess.map(R::new);
        s * (a + x * (b + x * (c + x * (d + x * (e + x * (f + x * (g + x * h)))))))
    }

    /// The square of the angle, in half turns, whose radius has the square `s`.
    #[inline(always)]
    fn square_of_angle<R: Real>(self, s: R) -> R {
        let known = s.value();
        let mut w = self.first(known);
        if !self.close {
            for _ in 0..MORE {
                w = self.newton(w, known);
            }
        }
        if R::epsilon() < SINGLE {
            w = self.newton(w, known);
        }
        // The last step's derivative is that of the solution.
        self.newton(R::constant(w), s)
    }

    /// A step of Newton's method toward w P(w)² = s.
    #[inline(always)]
    fn newton<R: Real>(self, w: R, s: R) -> R {
        let p = self.stretch(w);
        w - (w * p * p - s) / (p * (p + self.bend(w)))
    }

    /// The same by bisection.
    fn square_of_angle_slowly(self, s: f64) -> f64 {
        let (mut low, mut high) = (0.0, self.rim * self.rim);
        for _ in 0..200 {
            let middle = 0.5 * (low + high);
            let p = self.stretch(middle);
            if middle * p * p < s {
                low = middle
            } else {
                high = middle
            }
        }
        0.5 * (low + high)
    }

    fn new(parameters: &[f64]) -> Self {
        let rim = parameters[0] / 360.0;
        let square = PI * PI;
        let powers = [square, square * square, square.powi(3), square.powi(4)];
        let mut lens = KannalaBrandt {
            rim,
            radius: 0.0,
            k: std::array::from_fn(|n| parameters[n + 1] * powers[n]),
            guess: [0.0; NODES],
            close: true,
        };
        lens.radius = rim * lens.stretch(rim * rim);
        lens.guess = lens.first_guess();
        lens.close = lens.missed().is_none();
        lens
    }

    /// An angle, in half turns, that is not found of its radius.
    fn missed(self) -> Option<f64> {
        (1..=256)
            .map(|k| self.rim * f64::from(k) / 256.0)
            .find(|&t| {
                let w = t * t;
                let s = w * self.stretch(w) * self.stretch(w);
                // A slope far below the chord's makes rounding worse than it would be.
                let worse = 1.0 + self.stretch(w) / (self.stretch(w) + self.bend(w));
                let off = |found: f64| (found / w - 1.0).abs() / worse;
                let enough = off(self.square_of_angle(s)) <= 64.0 * f64::EPSILON;
                let once = off(self.newton(self.first(s), s)) <= 0.25 * SINGLE;
                !(enough && (once || !self.close))
            })
    }

    /// Newton's divided differences through Chebyshev's places, as coefficients of powers.
    fn first_guess(self) -> [f64; NODES] {
        if self.k == [0.0; 4] {
            let mut one = [0.0; NODES];
            one[0] = 1.0;
            return one;
        }
        let x: [f64; NODES] =
            std::array::from_fn(|k| 0.5 + 0.5 * angle::cos((k as f64 + 0.5) / NODES as f64 * PI));
        let mut difference = x.map(|x| {
            let s = x * self.radius * self.radius;
            self.square_of_angle_slowly(s) / s
        });
        for order in 1..NODES {
            for k in (order..NODES).rev() {
                difference[k] = (difference[k] - difference[k - 1]) / (x[k] - x[k - order]);
            }
        }
        let mut guess = [0.0; NODES];
        for k in (0..NODES).rev() {
            // guess = guess · (X - x[k]) + difference[k].
            for power in (1..NODES).rev() {
                guess[power] = guess[power - 1] - x[k] * guess[power];
            }
            guess[0] = difference[k] - x[k] * guess[0];
        }
        guess
    }
}

impl Projection for KannalaBrandt {
    const INFO: Info = Info {
        name: "kannala_brandt",
        title: "Kannala-Brandt fisheye (OpenCV)",
        known_as: &["fisheye", "opencv_fisheye"],
        source: "Kannala, Brandt 2006, A Generic Camera Model, eq. 6; OpenCV fisheye camera model",
        summary: "Fisheye with the distortion polynomial of a calibration, as OpenCV's cv2.fisheye has it.",
        singular: "None in the image; at fov = 360 the direction opposite the axis fills the whole rim.",
        axes: "+x -y -z",
        outline: Outline::Disk,
        parameters: &[
            lens::fov(180.0, 360.0),
            coefficient("k1", "the coefficient of the angle's cube, in radians"),
            coefficient("k2", "the coefficient of its fifth power"),
            coefficient("k3", "the coefficient of its seventh power"),
            coefficient("k4", "the coefficient of its ninth power"),
        ],
        smooth: true,
        ..Info::PLAIN
    };

    const COMMON: bool = false;

    fn check(parameters: &[f64]) -> Result<(), String> {
        let lens = KannalaBrandt::new(parameters);
        let slope = |angle: f64| {
            let w = (angle / PI) * (angle / PI);
            lens.stretch(w) + lens.bend(w)
        };
        lens::grows(
            lens.rim * PI,
            &slope,
            lens.radius * PI,
            "`k1`, `k2`, `k3`, `k4`",
        )?;
        if let Some(t) = lens.missed() {
            return Err(format!(
                "Expected `k1`, `k2`, `k3`, `k4` of a lens, got a polynomial so steep that its inverse is not found \
                 {:.4} degrees from the axis.",
                t * 180.0
            ));
        }
        Ok(())
    }

    fn with_parameters(parameters: &[f64]) -> Self {
        KannalaBrandt::new(parameters)
    }

    fn coverage(self) -> Coverage {
        if self.rim == 1.0 {
            Coverage::Sphere
        } else {
            Coverage::Cap(PI * self.rim)
        }
    }

    fn density_range(self) -> (f64, f64) {
        let (low, high) = lens::extremes(1.0, &|r| one::density(self, Uv::centered(r, 0.0, 0.0)));
        // sin π is 0 and not what a rounded π gives.
        (if self.rim == 1.0 { 0.0 } else { low }, high)
    }

    fn seam(self) -> Seam {
        if self.rim == 1.0 {
            Seam::RimOpposite
        } else {
            Seam::Ends
        }
    }

    #[inline(always)]
    fn encode<R: Real>(self, [x, y, z]: [R; 3]) -> Uv<R> {
        let (zero, one) = (R::ZERO, R::ONE);
        let (xs, ys, unscale) = scaled(x, y);
        let hs = (xs * xs + ys * ys).sqrt();
        // On the axis the azimuth is that of (1, 0).
        let on_axis = R::select(hs.vanishes(), one, zero);
        let t = R::half_turns(hs * unscale, z);
        let inside = (t * R::new(1.0 / self.rim)).at_most(R::new(1.0 + 2.0 * R::epsilon()));
        // Not beyond the rim: a polynomial rounds by more than is let out there.
        let radius = min(t * self.stretch(t * t) * R::new(1.0 / self.radius), one);
        let factor = radius / (hs + on_axis);
        Uv::held((xs + on_axis) * factor, ys * factor, inside)
    }

    #[inline(always)]
    fn decode<R: Real>(self, uv: Uv<R>) -> [R; 3] {
        let (p, q) = uv.pq();
        let (a, b) = (p * R::new(self.radius), q * R::new(self.radius));
        let s = a * a + b * b;
        // Clamped, and not chosen: on the rim the derivative is that from inside.
        let s = s.clamped(0.0, self.radius * self.radius);
        let w = self.square_of_angle(s).clamped(0.0, 1.0);
        let t = w.sqrt();
        let factor = R::sinc_half_turns(w, t) / self.stretch(w);
        [a * factor, b * factor, R::cos_half_turns(w, t)]
    }

    fn is_smooth(self, rect: Rect, _corners: impl Fn() -> [f64; 4]) -> bool {
        lens::is_smooth(rect)
    }

    fn solid_angle(self, rect: Rect) -> f64 {
        let theta = |r: f64| {
            PI * self
                .square_of_angle((r * self.radius).powi(2))
                .max(0.0)
                .sqrt()
        };
        lens::solid_angle(rect, |u, v| one::density(self, Uv::flat(u, v)), theta)
    }

    #[inline(always)]
    fn density<R: Real>(self, uv: Uv<R>) -> R {
        let (p, q) = uv.pq();
        let (a, b) = (p * R::new(self.radius), q * R::new(self.radius));
        let s = a * a + b * b;
        let s = s.clamped(0.0, self.radius * self.radius);
        let w = self.square_of_angle(s).clamped(0.0, 1.0);
        let stretch = self.stretch(w);
        let slope = stretch + self.bend(w);
        R::new(4.0 * PI * self.radius * self.radius) * R::sinc_half_turns(w, w.sqrt())
            / (stretch * slope)
    }
}
