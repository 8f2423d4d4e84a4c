//! The Kannala–Brandt fisheye with the K matrix of a calibration, as OpenCV's `cv2.fisheye.calibrate` gives it.
//!
//! Source: Kannala & Brandt 2006, A Generic Camera Model and Calibration Method, equation 6, in OpenCV's normalization: the
//! radius is θ (1 + k1 θ² + k2 θ⁴ + k3 θ⁶ + k4 θ⁸), θ in radians from the axis; see `kannala_brandt`. COLMAP's SIMPLE_RADIAL_FISHEYE,
//! RADIAL_FISHEYE and OPENCV_FISHEYE, Kalibr's pinhole-equi, ROS's equidistant.
//!
//! Domain: directions that the rectangle shows, up to where the polynomial turns back or to the one opposite the axis; else NaN.
//!
//! The inverse is Newton's method for w = θ² in w P(w)² = s, five steps from a polynomial. Where coefficients that no lens has make
//! the radius nearly stand still on its way, the method leaps: the map ends before. Lenses as they are made need two steps, and most one; where those
//! find all that was tried, there are no more.

use crate::number::real::{Real, scaled};
use crate::projections::common::camera::{
    ASPECT, CAMERA, CX, CY, Camera, FX, FY, Guess, LET_OUT, Lens, RADII, coefficient, grows_up_to,
    last, last_of, reaches,
};
use crate::projections::projection::{Info, Visitor};
use std::f64::consts::PI;

/// Steps of Newton's method.
const STEPS: usize = 5;
/// As many as lenses need.
const FEW: usize = 2;
/// How near they are before the last step, which squares that.
const NEAR: f64 = 1e-10;
/// As many as lenses need whose polynomial is near from the start.
const ONE: usize = 1;
/// How far, of it, from a point's radius its inverse's may be.
const RESIDUE: f64 = 1e-12;

/// A lens with a polynomial.
#[derive(Clone, Copy, Debug)]
pub struct FisheyePolynomial<const STEPS_TAKEN: usize = STEPS> {
    k: [f64; 4],
    /// The largest angle from the axis, in half turns.
    end: f64,
    /// The square of the image radius there.
    limit: f64,
    /// The angle over the radius.
    guess: Guess,
    /// Whether few steps find all.
    has_few: bool,
    /// Whether one does.
    has_one: bool,
}

/// A fisheye camera with a K matrix.
pub type CameraKannalaBrandt = Camera<FisheyePolynomial>;

/// Of a power of the angle.
const RANGE: [f64; 3] = [-100.0, 0.0, 100.0];

impl<const STEPS_TAKEN: usize> FisheyePolynomial<STEPS_TAKEN> {
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

    /// A step of Newton's method toward w P(w)² = s.
    #[inline(always)]
    fn newton<R: Real>(self, w: R, s: R) -> R {
        let p = self.stretch(w);
        w - (w * p * p - s) / (p * (p + self.bend(w)))
    }

    /// The square of the angle whose radius has the square `s`.
    #[inline(always)]
    fn square_of_angle<R: Real>(self, s: R) -> R {
        let known = s.value();
        // The last step's derivative is that of the solution.
        self.newton(R::constant(self.near(known)), s)
    }

    /// It, but for the last step.
    #[inline(always)]
    fn near<R: Real>(self, s: R) -> R {
        let ratio = self.guess.at(s);
        let mut w = s * ratio * ratio;
        for _ in 1..STEPS_TAKEN {
            w = self.newton(w, s);
        }
        w
    }

    /// The same lens with another count of steps.
    fn by<const OTHER: usize>(self) -> FisheyePolynomial<OTHER> {
        FisheyePolynomial {
            k: self.k,
            end: self.end,
            limit: self.limit,
            guess: self.guess,
            has_few: self.has_few,
            has_one: self.has_one,
        }
    }

    /// Whether so many steps come near the angles of all radii that are tried.
    fn is_found_by<const OTHER: usize>(self) -> bool {
        let other = self.by::<OTHER>();
        (1..=RADII).all(|k| {
            let angle = PI * self.end * k as f64 / RADII as f64;
            let (w, r) = (angle * angle, angle * self.stretch(angle * angle));
            (other.near(r * r) - w).abs() <= NEAR * w
        })
    }
}

impl<const STEPS_TAKEN: usize> Lens for FisheyePolynomial<STEPS_TAKEN> {
    const NAMES: Info = Info {
        name: "camera_kannala_brandt",
        title: "Calibrated camera: Kannala-Brandt fisheye (OpenCV)",
        source: "Kannala, Brandt 2006, A Generic Camera Model, eq. 6; OpenCV fisheye camera model",
        summary: "A fisheye by K and D of OpenCV's cv2.fisheye; sm.camera makes it from pixels.",
        parameters: &[
            FX,
            FY,
            CX,
            CY,
            ASPECT,
            coefficient(
                "k1",
                RANGE,
                "the coefficient of the angle's cube, in radians",
            ),
            coefficient("k2", RANGE, "the coefficient of its fifth power"),
            coefficient("k3", RANGE, "the coefficient of its seventh power"),
            coefficient("k4", RANGE, "the coefficient of its ninth power"),
        ],
        ..CAMERA
    };

    fn new(coefficients: &[f64], reach: f64) -> Self {
        let mut lens = FisheyePolynomial {
            k: std::array::from_fn(|n| coefficients[n]),
            end: 1.0,
            limit: 0.0,
            guess: Guess::new(1.0, 4.0, |_| 1.0),
            has_few: false,
            has_one: false,
        };
        let polynomial = lens;
        let at = |angle: f64| {
            let w = angle * angle;
            let (stretch, bend) = (polynomial.stretch(w), polynomial.bend(w));
            [angle * stretch, stretch + bend]
        };
        let radius = |angle: f64| at(angle)[0];
        // No farther than the image.
        let grown = grows_up_to(PI, at);
        let end = last(grown, |angle| radius(angle) < reach * 1.001);
        lens.end = end / PI;
        lens.limit = radius(end).powi(2);
        if lens.k != [0.0; 4] {
            // Beyond π there is no direction, but the polynomial goes on.
            let fold = last(2.0 * PI, |angle| at(angle)[1] > 0.0);
            let turn = if fold < 2.0 * PI {
                radius(fold).powi(2)
            } else {
                f64::INFINITY
            };
            lens.guess = Guess::new(lens.limit, turn, |s| {
                let r = s.sqrt();
                reaches(r, fold, radius) / r
            });
            let found = last_of(RADII, radius(end), |r| lens.holds([r, 0.0]));
            if found < radius(end) {
                lens.end = reaches(found, end, radius) / PI;
                lens.limit = found * found;
            }
        }
        lens.has_few = lens.is_found_by::<FEW>();
        lens.has_one = lens.is_found_by::<ONE>();
        lens
    }

    fn accept<V: Visitor>(camera: Camera<Self>, visitor: V) -> V::Output {
        let lens = camera.lens();
        if lens.has_one {
            return visitor.visit(camera.with_lens(lens.by::<ONE>()));
        }
        if lens.has_few {
            return visitor.visit(camera.with_lens(lens.by::<FEW>()));
        }
        visitor.visit(camera)
    }

    #[inline(always)]
    fn project<R: Real>(self, [x, y, z]: [R; 3]) -> ([R; 2], R::Mask) {
        let (xs, ys, unscale) = scaled(x, y);
        let hs = (xs * xs + ys * ys).sqrt();
        // On the axis the azimuth is that of (1, 0).
        let on_axis = R::select(hs.vanishes(), R::ONE, R::ZERO);
        let t = R::half_turns(hs * unscale, z);
        let seen = t.at_most(R::new(self.end * (1.0 + 2.0 * f64::EPSILON)));
        let angle = t * R::new(PI);
        let factor = angle * self.stretch(angle * angle) / (hs + on_axis);
        ([(xs + on_axis) * factor, ys * factor], seen)
    }

    #[inline(always)]
    fn unproject<R: Real>(self, [a, b]: [R; 2]) -> [R; 3] {
        let s = (a * a + b * b).clamped(0.0, self.limit);
        let w = self.square_of_angle(s).clamped(0.0, PI * PI);
        let half_turns = w * R::new(1.0 / (PI * PI));
        let t = half_turns.sqrt();
        let factor = R::sinc_half_turns(half_turns, t) * R::new(1.0 / PI) / self.stretch(w);
        [a * factor, b * factor, R::cos_half_turns(half_turns, t)]
    }

    /// sin θ dθ dφ over r dr dφ.
    #[inline(always)]
    fn density<R: Real>(self, [a, b]: [R; 2]) -> Option<R> {
        let s = (a * a + b * b).clamped(0.0, self.limit);
        let w = self.square_of_angle(s).clamped(0.0, PI * PI);
        let half_turns = w * R::new(1.0 / (PI * PI));
        let sinc = R::sinc_half_turns(half_turns, half_turns.sqrt()) * R::new(1.0 / PI);
        let stretch = self.stretch(w);
        Some(sinc / (stretch * (stretch + self.bend(w))))
    }

    #[inline(always)]
    fn holds<R: Real>(self, [a, b]: [R; 2]) -> R::Mask {
        let s = a * a + b * b;
        let w = self.square_of_angle(s.clamped(0.0, self.limit));
        let stretch = self.stretch(w);
        let near = R::new(4.0 * RESIDUE) * s + R::new(RESIDUE * RESIDUE);
        s.at_most(R::new(self.limit * (1.0 + LET_OUT)))
            & (w * stretch * stretch - s).abs().at_most(near)
    }

    fn rim(self) -> f64 {
        PI * self.end
    }

    fn held_radius(self) -> f64 {
        self.limit.sqrt()
    }
}
