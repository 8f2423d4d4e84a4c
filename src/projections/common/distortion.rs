//! The distortion of Brown and Conrady on the plane of a camera, with a thin prism, as OpenCV writes it.
//!
//! Source: Brown 1966, Decentering Distortion of Lenses; Conrady 1919; Weng, Cohen & Herniou 1992, Camera Calibration with Distortion Models;
//! in OpenCV's letters and with its denominator, with r² = x² + y² and q = (1 + k1 r² + k2 r⁴ + k3 r⁶)/(1 + k4 r² + k5 r⁴ + k6 r⁶):
//! a = q x + 2 p1 x y + p2 (r² + 2x²) + s1 r² + s2 r⁴, b = q y + p1 (r² + 2y²) + 2 p2 x y + s3 r² + s4 r⁴.
//! The numerator may have more powers; lenses without a prism do not pay for it.
//!
//! Domain: the largest disk r ≤ R in which the map is one to one: it turns nowhere inside out (the Jacobian's determinant
//! is more than a hundredth of (ρ/r)²), and circles stay star-shaped, so that none crosses itself or another.
//!
//! The inverse has no closed form. Newton's method in two dimensions starts from a polynomial that inverts q alone and takes
//! nine steps, none out of the disk; a point that it does not bring back to 1e-12 counts as one that no direction has. Where the
//! map turns back, Newton's method converges from inside and leaps from outside: with terms that are not radial, for which the
//! polynomial is off there, the start is kept a little inside. Where coefficients that no lens has make the radius nearly stand still on its
//! way, the method leaps: the disk ends before.
//!
//! A lens as photographers have it needs four of the nine steps, and none comes near the end of its disk: where that is so
//! wherever it was tried, [`Distortion::short`] takes no more and does not look. That is a fourth of the time. With a radial
//! polynomial alone, far from where it turns back, and with tangential terms as small as calibrations have them, two steps do from a polynomial of
//! r² that is taken twice more without what these terms add: [`Distortion::plain`], a third of that.

use crate::number::angle;
use crate::number::real::{Real, max};
use crate::projections::common::camera::{
    Guess, LET_OUT, PlainGuess, RADII, last, last_of, reaches,
};
use crate::projections::common::lens::LEAST_SLOPE;

/// How far from a point its inverse may lead: 1e-9 pixels at a focal length of a thousand.
const RESIDUE: f64 = 1e-12;
/// The largest radius that is looked at: 89.99 degrees.
const FARTHEST: f64 = 5000.0;
/// Directions in which circles are looked at.
const AZIMUTHS: usize = 48;
/// In how many of them the inverse is tried.
const TRIED: usize = 8;
/// How near a short way is before its last step, which squares that.
const NEAR: f64 = 1e-11;
/// How near the plain way is before its last step.
const PLAINLY_NEAR: f64 = 3e-8;

/// The way back: with all steps, each kept in the disk.
pub const LONG: u8 = 9;
/// With as many as most lenses need.
pub const SHORT: u8 = 4;
/// With those that a polynomial alone needs.
pub const PLAIN: u8 = 2;

/// The coefficients.
#[derive(Clone, Copy, Debug)]
pub struct Terms<const N: usize> {
    /// k1, k2, k3: of the numerator's powers of r².
    pub over: [f64; N],
    /// k4, k5, k6: of the denominator's.
    pub under: [f64; 3],
    /// p1, p2.
    pub tangential: [f64; 2],
    /// s1, s2; s3, s4.
    pub prism: [[f64; 2]; 2],
}

impl<const N: usize> Terms<N> {
    /// None at all.
    pub const NONE: Self = Terms {
        over: [0.0; N],
        under: [0.0; 3],
        tangential: [0.0; 2],
        prism: [[0.0; 2]; 2],
    };

    fn has_prism(self) -> bool {
        self.prism != [[0.0; 2]; 2]
    }

    /// Whether circles stay circles around the axis.
    fn is_round(self) -> bool {
        self.tangential == [0.0; 2] && !self.has_prism()
    }

    fn has_radial(self) -> bool {
        self.over != [0.0; N] || self.under != [0.0; 3]
    }
}

/// The coefficients, and where they hold. Without `PRISM`, that one is none; a [`PLAIN`] way has no denominator.
#[derive(Clone, Copy, Debug)]
pub struct Distortion<const N: usize = 3, const PRISM: bool = true, const WAY: u8 = LONG> {
    terms: Terms<N>,
    /// The square of the largest radius that is mapped.
    limit: f64,
    /// The square of the largest radius that Newton's method starts from.
    start: f64,
    /// r over the image's radius, of the radial part.
    guess: Guess,
    /// The same for the plain way.
    plain_guess: PlainGuess,
    /// Whether the short way finds all.
    has_short: bool,
    /// Whether the plain way does.
    has_plain: bool,
}

/// A point and the derivatives there: ∂a/∂x, ∂a/∂y; ∂b/∂x, ∂b/∂y.
struct Mapped<R> {
    point: [R; 2],
    slope: [[R; 2]; 2],
}

/// Over which area a point's surroundings are spread.
#[inline(always)]
fn determinant<R: Real>([[xx, xy], [yx, yy]]: [[R; 2]; 2]) -> R {
    xx * yy - xy * yx
}

/// 1 + k1 s + k2 s² ..., and its derivative by s.
#[inline(always)]
fn polynomial<R: Real, const N: usize>(k: [f64; N], s: R) -> [R; 2] {
    let mut value = R::new(k[N - 1]);
    let mut slope = R::new(N as f64 * k[N - 1]);
    for n in (0..N - 1).rev() {
        value = R::new(k[n]) + s * value;
        slope = R::new((n + 1) as f64 * k[n]) + s * slope;
    }
    [R::ONE + s * value, slope]
}

impl<const N: usize, const PRISM: bool, const WAY: u8> Distortion<N, PRISM, WAY> {
    /// With these coefficients, in an image that reaches as far as `reach`, on a plane that ends at the radius `end`.
    pub fn new(terms: Terms<N>, reach: f64, end: f64) -> Self {
        let mut new = Distortion {
            terms,
            limit: 0.0,
            start: 0.0,
            guess: Guess::new(1.0, 4.0, |_| 1.0),
            plain_guess: PlainGuess::new(1.0, |_| 1.0),
            has_short: false,
            has_plain: false,
        };
        // The last radius of the plane up to which something holds, by angles.
        let last_radius = |end: f64, holds: &dyn Fn(f64) -> bool| {
            angle::tan(last(angle::atan(end), |angle| holds(angle::tan(angle))))
        };
        let end = last_radius(end.min(FARTHEST), &|r| new.one_to_one(r));
        // No farther than the image.
        let enough = last_radius(end, &|r| new.nearest(r) < reach * 1.001);
        new.limit = enough * enough;
        new.start = new.limit * if terms.is_round() { 1.0 } else { 0.92 };
        if !terms.has_radial() {
            return new.with_ways();
        }
        let distorted = new;
        let radius = |r: f64| r * distorted.radial(r * r)[0];
        // The radial part alone may turn back a little before the circle does.
        let fold = last_radius(FARTHEST, &|r| {
            let [q, slope] = new.radial(r * r);
            q > 0.0 && q + 2.0 * r * r * slope > 0.0
        });
        let range = enough.min(fold);
        let turn = if fold < 0.999 * FARTHEST {
            radius(fold).powi(2)
        } else {
            f64::INFINITY
        };
        let ratio = |s: f64| {
            let rho = s.sqrt();
            reaches(rho, fold, radius) / rho
        };
        new.guess = Guess::new(radius(range).powi(2), turn, ratio);
        new.plain_guess = PlainGuess::new(radius(range).powi(2), ratio);
        let found = last_of(RADII, angle::atan(enough), |angle| {
            new.found(angle::tan(angle))
        });
        if found < angle::atan(enough) {
            let shrink = (angle::tan(found) / enough).powi(2);
            new.limit *= shrink;
            new.start *= shrink;
        }
        new.with_ways()
    }

    /// The same, which knows the ways that find all.
    fn with_ways(mut self) -> Self {
        self.has_short = self.is_found_by::<PRISM, SHORT>(NEAR);
        self.has_plain = !self.terms.has_prism()
            && self.terms.under == [0.0; 3]
            && self.is_found_by::<false, PLAIN>(PLAINLY_NEAR);
        self
    }

    /// The same with a shorter inverse, where that finds all; one without a prism only where there is none.
    pub fn short<const WITH: bool>(self) -> Option<Distortion<N, WITH, SHORT>> {
        let holds = WITH || !self.terms.has_prism();
        (self.has_short && holds).then(|| self.by())
    }

    /// The same with the shortest inverse, where that finds all.
    pub fn plain(self) -> Option<Distortion<N, false, PLAIN>> {
        self.has_plain.then(|| self.by())
    }

    /// The same by another way.
    fn by<const WITH: bool, const OTHER: u8>(self) -> Distortion<N, WITH, OTHER> {
        Distortion {
            terms: self.terms,
            limit: self.limit,
            start: self.start,
            guess: self.guess,
            plain_guess: self.plain_guess,
            has_short: self.has_short,
            has_plain: self.has_plain,
        }
    }

    /// Whether the inverse of a way is so near the places it comes from, before its last step, wherever it is tried.
    fn is_found_by<const WITH: bool, const OTHER: u8>(self, near: f64) -> bool {
        let (other, end) = (self.by::<WITH, OTHER>(), angle::atan(self.end()));
        (1..=RADII).all(|k| {
            let r = angle::tan(end * k as f64 / RADII as f64);
            self.tried(r).all(|([x, y], there)| {
                let [a, b] = other.inverse(there.point);
                angle::length(a - x, b - y) <= near * (1.0 + r)
            })
        })
    }

    /// Whether what is mapped of a circle is brought back.
    fn found(self, r: f64) -> bool {
        self.tried(r).all(|(_, there)| self.holds(there.point))
    }

    /// What is mapped of a circle, at the places where the inverse is tried.
    fn tried(self, r: f64) -> impl Iterator<Item = ([f64; 2], Mapped<f64>)> {
        self.circle(r).step_by(AZIMUTHS / TRIED)
    }

    /// q and dq/dr², from r².
    #[inline(always)]
    fn radial<R: Real>(self, s: R) -> [R; 2] {
        let over = polynomial(self.terms.over, s);
        if WAY == PLAIN {
            return over;
        }
        let under = polynomial(self.terms.under, s);
        let inverse = R::ONE / under[0];
        let q = over[0] * inverse;
        [q, (over[1] - q * under[1]) * inverse]
    }

    /// What the tangential terms add.
    #[inline(always)]
    fn decentered<R: Real>(self, [x, y]: [R; 2]) -> [R; 2] {
        let [p1, p2] = self.terms.tangential.map(R::new);
        let (xx, xy, yy) = (x * x, R::TWO * (x * y), y * y);
        let s = xx + yy;
        [
            p1 * xy + p2 * (s + R::TWO * xx),
            p1 * (s + R::TWO * yy) + p2 * xy,
        ]
    }

    #[inline(always)]
    fn mapped<R: Real>(self, [x, y]: [R; 2]) -> Mapped<R> {
        let [p1, p2] = self.terms.tangential.map(R::new);
        let (two, six) = (R::TWO, R::new(6.0));
        let (xx, xy, yy) = (x * x, x * y, y * y);
        let s = xx + yy;
        let [q, bend] = self.radial(s);
        let bend = two * bend;
        let across = bend * xy + two * p1 * x + two * p2 * y;
        let mut mapped = Mapped {
            point: [
                q * x + two * p1 * xy + p2 * (s + two * xx),
                q * y + p1 * (s + two * yy) + two * p2 * xy,
            ],
            slope: [
                [q + bend * xx + two * p1 * y + six * p2 * x, across],
                [across, q + bend * yy + six * p1 * y + two * p2 * x],
            ],
        };
        if PRISM {
            for (k, terms) in self.terms.prism.into_iter().enumerate() {
                let [first, second] = terms.map(R::new);
                mapped.point[k] = mapped.point[k] + s * (first + s * second);
                let bend = two * (first + s * (two * second));
                mapped.slope[k] = [mapped.slope[k][0] + bend * x, mapped.slope[k][1] + bend * y];
            }
        }
        mapped
    }

    /// The largest radius that is mapped.
    pub fn end(self) -> f64 {
        self.limit.sqrt()
    }

    /// The radius of the largest disk, about the axis, of points that are [held](Distortion::holds).
    pub fn held_radius(self) -> f64 {
        self.nearest(self.end())
    }

    /// What is mapped of a circle, at some places of it; where it stays one, one place stands for all.
    fn circle(self, r: f64) -> impl Iterator<Item = ([f64; 2], Mapped<f64>)> {
        let places = if self.terms.is_round() { 1 } else { AZIMUTHS };
        (0..places).map(move |k| {
            let (sin, cos) = f64::sin_cos_half_turns(k as f64 / (AZIMUTHS / 2) as f64 - 1.0);
            let at = [-r * cos, -r * sin];
            (at, self.mapped(at))
        })
    }

    /// Whether a circle stays around its center and is not turned inside out.
    fn one_to_one(self, r: f64) -> bool {
        let turns = self.radial(r * r)[0] <= 0.0 || polynomial(self.terms.under, r * r)[0] <= 0.0;
        !turns
            && self.circle(r).all(|([x, y], there)| {
                let ([a, b], [[xx, xy], [yx, yy]]) = (there.point, there.slope);
                let chord = (a * a + b * b) / (r * r);
                // The image of the circle's tangent (-y, x).
                let (da, db) = (x * xy - y * xx, x * yy - y * yx);
                determinant(there.slope) > LEAST_SLOPE * chord
                    && a * db - b * da > LEAST_SLOPE * chord * r * r
            })
    }

    /// How near to the axis a circle comes.
    pub fn nearest(self, r: f64) -> f64 {
        self.circle(r)
            .map(|(_, there)| angle::length(there.point[0], there.point[1]))
            .fold(f64::INFINITY, f64::min)
    }

    /// Where a point of the plane goes, and whether it lies in the disk.
    #[inline(always)]
    pub fn distort<R: Real>(self, [x, y]: [R; 2]) -> ([R; 2], R::Mask) {
        let inside = (x * x + y * y).at_most(R::new(self.limit * (1.0 + 4.0 * f64::EPSILON)));
        (self.mapped([x, y]).point, inside)
    }

    /// A step of Newton's method toward the point.
    #[inline(always)]
    fn newton<R: Real>(self, [x, y]: [R; 2], [a, b]: [R; 2]) -> [R; 2] {
        let Mapped { point, slope } = self.mapped([x, y]);
        let (da, db) = (a - point[0], b - point[1]);
        let inverse = R::ONE / determinant(slope);
        let [[xx, xy], [yx, yy]] = slope;
        [
            x + (yy * da - xy * db) * inverse,
            y + (xx * db - yx * da) * inverse,
        ]
    }

    /// A step that stays in the disk.
    #[inline(always)]
    fn nearer<R: Real>(self, at: [R; 2], known: [R; 2]) -> [R; 2] {
        within(self.newton(at, known), self.limit)
    }

    #[inline(always)]
    fn inverse<R: Real>(self, known: [R; 2]) -> [R; 2] {
        let [a, b] = known;
        if WAY == PLAIN {
            let guess = |[a, b]: [R; 2]| {
                let ratio = self.plain_guess.at(a * a + b * b);
                [a * ratio, b * ratio]
            };
            let without = |[da, db]: [R; 2]| guess([a - da, b - db]);
            let at = without(self.decentered(guess(known)));
            return self.newton(without(self.decentered(at)), known);
        }
        let ratio = self.guess.at(a * a + b * b);
        if WAY == SHORT {
            let step = |at| {
                R::part(
                    #[inline(always)]
                    || self.newton(at, known),
                )
            };
            return step(step(step([a * ratio, b * ratio])));
        }
        let at = within([a * ratio, b * ratio], self.start);
        let step = |at| {
            R::part(
                #[inline(always)]
                || self.nearer(at, known),
            )
        };
        // No loop: it is too long for the compiler to unroll, and stands in the way of lanes.
        let at = step(step(step(step(at))));
        step(step(step(step(at))))
    }

    /// What comes to a point that is [held](Distortion::holds).
    #[inline(always)]
    pub fn undistort<R: Real>(self, point: [R; 2]) -> [R; 2] {
        let known = point.map(R::value);
        let at = R::part(
            #[inline(always)]
            || self.inverse::<R::Value>(known),
        );
        // The last step's derivative is that of the solution.
        self.newton(at.map(R::constant), point)
    }

    /// The area around what comes to a point that is [held](Distortion::holds) over that around the point, and where it is.
    #[inline(always)]
    pub fn shrinks<R: Real>(self, point: [R; 2]) -> (R, [R; 2]) {
        let at = self.undistort(point);
        (R::ONE / determinant(self.mapped(at).slope), at)
    }

    /// Whether a point is that of one in the disk.
    #[inline(always)]
    pub fn holds<R: Real>(self, [a, b]: [R; 2]) -> R::Mask {
        let [x, y] = self.undistort([a, b]);
        let there = self.mapped([x, y]).point;
        let (da, db) = (there[0] - a, there[1] - b);
        let near = R::new(RESIDUE * RESIDUE) * (R::ONE + a * a + b * b);
        (x * x + y * y).at_most(R::new(self.limit * (1.0 + LET_OUT)))
            & (da * da + db * db).at_most(near)
    }
}

/// The point, or where it lies outside of a disk of this squared radius, the one on its rim.
#[inline(always)]
fn within<R: Real>([x, y]: [R; 2], limit: f64) -> [R; 2] {
    let s = max(x * x + y * y, R::new(limit));
    let shrink = (R::new(limit) / s).sqrt();
    [x * shrink, y * shrink]
}
