//! What calibrated cameras share: a lens that puts directions on a plane, and a sensor that cuts a rectangle out of it.
//!
//! Source: the camera matrix K of computer vision (Hartley and Zisserman 2004, section 6.1): a point (a, b) of the plane
//! lies at (fx a + cx, fy b + cy) in pixels. Here lengths are in image widths and heights, measured from the image's middle, so
//! that they hold at every size: with K for W × H pixels whose centers have whole numbers, as OpenCV counts them,
//! u = (x + ½)/W, hence fx/W, fy/H, (cx + ½)/W - ½ and (cy + ½)/H - ½.
//!
//! Domain: the part of the plane in which the lens has an inverse. A polynomial of a calibration turns back somewhere, often just
//! outside of the picture and sometimes inside; from there on both formulas give NaN. The lens is taken to end a little
//! before, where its slope has fallen to [`LEAST_SLOPE`] of its chord: beyond, directions are lost to rounding. The cut is some ten
//! thousandths of the image's radius wide.

use crate::geometry::solid_angle;
use crate::geometry::solid_angle::Rect;
use crate::number::angle;
use crate::number::real::{Real, max};
use crate::projections::common::lens::{self, LEAST_SLOPE};
use crate::projections::projection;
use crate::projections::projection::one;
use crate::projections::projection::{
    Coverage, Info, Outline, Parameter, Projection, Seam, Uv, Visitor, size_of_aspect,
};
use std::f64::consts::PI;
use std::fmt::Debug;

/// How far beyond an edge or a rim a place counts as on it: what the inverse of a polynomial rounds.
pub const LET_OUT: f64 = 256.0 * f64::EPSILON;

/// The part of the radius that a lens holds of which nobody need ask: near its end the inverse of a polynomial is steep.
const WITHIN: f64 = 1.0 - 1.0 / 256.0;

/// The solid angle of a rectangle of an image with these halves and this principal point.
pub type ClosedForm = fn(Rect, [f64; 2], [f64; 2]) -> f64;

/// A lens: directions to points of the plane at distance 1 and back, in the view frame.
pub trait Lens: Copy + Debug + Send + Sync + 'static {
    /// Claims that are its own: names, texts, parameters, outline.
    const NAMES: Info;

    /// The solid angle of a rectangle, if it has a closed form.
    const CLOSED_FORM: Option<ClosedForm> = None;

    /// With these coefficients, the parameters after [`ASPECT`], for an image whose farthest corner lies at `reach` from the axis.
    fn new(coefficients: &[f64], reach: f64) -> Self;

    /// Calls the visitor with a camera that has this lens, or one with shorter formulas where its coefficients allow them.
    fn accept<V: Visitor>(camera: Camera<Self>, visitor: V) -> V::Output {
        visitor.visit(camera)
    }

    /// The point of a direction, and whether the lens sees it.
    fn project<R: Real>(self, d: [R; 3]) -> ([R; 2], R::Mask);

    /// The unit direction of a point that it [`holds`](Lens::holds).
    fn unproject<R: Real>(self, point: [R; 2]) -> [R; 3];

    /// The solid angle over the area of the plane at a point that it [`holds`](Lens::holds), where it has a closed form.
    fn density<R: Real>(self, _point: [R; 2]) -> Option<R> {
        None
    }

    /// Whether a point is that of a direction.
    fn holds<R: Real>(self, point: [R; 2]) -> R::Mask;

    /// The angle from the axis at which it ends.
    fn rim(self) -> f64;

    /// The radius of a disk of the plane all of which it [`holds`](Lens::holds); the largest that is known.
    fn held_radius(self) -> f64;
}

/// What cameras claim alike; names are a lens's own.
pub const CAMERA: Info = Info {
    singular: "None in the image.",
    axes: "+x -y -z",
    outline: Outline::Shape,
    smooth: true,
    // An edge is let out by 256 ε, half of it in u, and u may be worth 2π.
    round_trip: (9.5e-7, 3e-13),
    ..Info::PLAIN
};

const fn parameter(name: &'static str, range: [f64; 3], unit: &'static str) -> Parameter {
    Parameter {
        name,
        default: range[1],
        above: range[0],
        maximum: range[2],
        unit,
        doc: "",
    }
}

/// The focal length across.
pub const FX: Parameter = Parameter {
    doc: "the focal length of pixels across: that of K over the image's width",
    ..parameter("fx", [0.0, 0.5, 20.0], "image widths")
};
/// The focal length down.
pub const FY: Parameter = Parameter {
    doc: "the focal length of pixels down: that of K over the image's height",
    ..parameter("fy", [0.0, 0.5, 20.0], "image heights")
};
/// The principal point across.
pub const CX: Parameter = Parameter {
    doc: "how far right of the middle the axis is",
    ..parameter("cx", [-2.0, 0.0, 2.0], "image widths")
};
/// The principal point down.
pub const CY: Parameter = Parameter {
    doc: "how far below the middle the axis is",
    ..parameter("cy", [-2.0, 0.0, 2.0], "image heights")
};
/// The image's shape.
pub const ASPECT: Parameter = Parameter {
    doc: "the image's width over its height",
    ..parameter("aspect", [0.0, 1.0, 20.0], "width/height")
};
/// How many parameters are no lens's.
const SENSOR: usize = 5;

/// A coefficient of a lens.
pub const fn coefficient(name: &'static str, range: [f64; 3], doc: &'static str) -> Parameter {
    Parameter {
        doc,
        ..parameter(name, range, "")
    }
}

/// A lens and a sensor.
#[derive(Clone, Copy, Debug)]
pub struct Camera<L> {
    lens: L,
    /// The size of one unit of the plane, in p and q.
    focal: [f64; 2],
    /// Where the axis is, in p and q.
    principal: [f64; 2],
    /// Width over height.
    aspect: f64,
    /// Whether the whole rectangle holds sphere.
    whole: bool,
    /// The radius of a disk of the plane about the axis that has all that the lens holds, and may be larger.
    held_within: f64,
}

impl<L: Lens> Camera<L> {
    /// The lens.
    pub fn lens(self) -> L {
        self.lens
    }

    /// The same camera with the same lens in other formulas.
    pub fn with_lens<M>(self, lens: M) -> Camera<M> {
        Camera {
            lens,
            focal: self.focal,
            principal: self.principal,
            aspect: self.aspect,
            whole: self.whole,
            held_within: self.held_within,
        }
    }

    /// The point of the plane at p and q.
    #[inline(always)]
    fn point<R: Real>(self, uv: Uv<R>) -> [R; 2] {
        let (p, q) = uv.pq();
        [
            (p - R::new(self.principal[0])) * R::new(1.0 / self.focal[0]),
            (q - R::new(self.principal[1])) * R::new(1.0 / self.focal[1]),
        ]
    }

    /// Whether the lens holds all, and whether it holds any, of many places of the image, most of them along its border: of a camera
    /// that is not known to be whole.
    fn held(self) -> (bool, bool) {
        const INSIDE: usize = 24;
        const ALONG: usize = 128;
        let at = |k: usize, n: usize| k as f64 / n as f64;
        let held = |u: f64, v: f64| one::contains(self, Uv::flat(u, v));
        let inside = (0..(INSIDE + 1) * (INSIDE + 1)).map(|k| {
            let (i, j) = (k % (INSIDE + 1), k / (INSIDE + 1));
            held(at(i, INSIDE), at(j, INSIDE))
        });
        let border = (0..=ALONG).flat_map(|k| {
            let t = at(k, ALONG);
            [held(t, 0.0), held(t, 1.0), held(0.0, t), held(1.0, t)]
        });
        let (mut all, mut any) = (true, false);
        for held in inside.chain(border) {
            (all, any) = (all & held, any | held);
        }
        (all, any)
    }

    /// How far from the axis what the lens holds reaches: the farthest of some points of its rim, and more.
    fn farthest_held(self) -> f64 {
        const AZIMUTHS: usize = 64;
        // Between two of 64 places a radius r(φ) grows by 0.0012 r'' at most.
        const SLACK: f64 = 1.0 / 64.0;
        let (sin, cos) = angle::sin_cos(self.lens.rim() * (1.0 - 1e-12));
        let far = (0..AZIMUTHS).map(|k| {
            let (y, x) = f64::sin_cos_half_turns(2.0 * k as f64 / AZIMUTHS as f64);
            let ([a, b], seen) = self.lens.project([sin * x, sin * y, cos]);
            let far = angle::length(a, b);
            if seen && far < f64::INFINITY {
                far
            } else {
                f64::INFINITY
            }
        });
        far.fold(0.0, f64::max) * (1.0 + SLACK)
    }

    /// Whether a rectangle lies beyond all that the lens holds.
    fn is_beyond(self, r: Rect) -> bool {
        let [near_u, near_v] = [0, 1].map(|k| {
            let axis = 0.5 + 0.5 * self.principal[k];
            let [from, to] = [[r.u0, r.u1], [r.v0, r.v1]][k];
            2.0 * (axis - axis.clamp(from, to)) / self.focal[k]
        });
        near_u * near_u + near_v * near_v > self.held_within * self.held_within
    }

    /// ∫ (1 - cos θ) dφ along an edge of a rectangle, from one place of it to another. Where the lens ends with no slope the
    /// integrand has a root, which the square of a sine at both ends takes away.
    fn along(self, at: &dyn Fn(f64) -> [f64; 2], axis: usize, from: f64, to: f64) -> f64 {
        let share = |s: f64| {
            let (sin, cos) = f64::sin_cos_half_turns(0.5 * s);
            let [u, v] = at(from + (to - from) * sin * sin);
            let uv = Uv::flat(u, v);
            let ([x, y, z], slope) = (one::decode(self, uv), one::jacobian(self, uv)[axis]);
            let turn = x * slope[1] - y * slope[0];
            // sin²θ is (1 - z)(1 + z): what does not cancel.
            let share = if z > 0.0 {
                turn / (1.0 + z)
            } else {
                turn * (1.0 - z) / (x * x + y * y)
            };
            share * PI * sin * cos * (to - from)
        };
        // Behind a pointer: the rules of integration are the same for all lenses.
        let share: &dyn Fn(f64) -> f64 = &share;
        solid_angle::halved(0.0, 1.0, share)
    }

    /// The solid angle of what a rectangle holds, ∮ (1 - cos θ) dφ around it, by Stokes: along its edges, and along the circle at
    /// which the lens ends from where an edge leaves it to where one comes back.
    fn around(self, r: Rect) -> f64 {
        // Fine enough for what a corner of the rectangle just cuts off, and what an edge of the image does.
        let steps = if (r.u1 - r.u0).max(r.v1 - r.v0) > 0.125 {
            256
        } else {
            32
        };
        let held = |[u, v]: [f64; 2]| one::contains(self, Uv::flat(u, v));
        let cap = 2.0 * angle::sin(0.5 * self.lens.rim()).powi(2);
        // A lens that sees the direction behind it has that all along its rim; it is a round one, which keeps azimuths.
        let behind = self.lens.rim() > PI - 1e-6;
        let azimuth = |[u, v]: [f64; 2]| {
            let uv = Uv::flat(u, v);
            let ([a, b], [x, y, _]) = (self.point(uv), one::decode(self, uv));
            if behind {
                angle::atan2(b, a)
            } else {
                angle::atan2(y, x)
            }
        };
        let (mut sum, mut pieces) = (0.0, 0);
        // The azimuth at which the rectangle's border left the lens, and that at which it first came in.
        let (mut left, mut entered): (Option<f64>, Option<f64>) = (None, None);
        for edge in 0..4 {
            let at = move |t: f64| match edge {
                0 => [r.u0 + (r.u1 - r.u0) * t, r.v0],
                1 => [r.u1, r.v0 + (r.v1 - r.v0) * t],
                2 => [r.u1 - (r.u1 - r.u0) * t, r.v1],
                _ => [r.u0, r.v1 - (r.v1 - r.v0) * t],
            };
            let long = [r.u1 - r.u0, r.v1 - r.v0, r.u0 - r.u1, r.v0 - r.v1][edge];
            let mut after = held(at(0.0));
            let mut start = after.then_some(0.0);
            for k in 0..steps {
                let (a, b) = (k as f64 / steps as f64, (k + 1) as f64 / steps as f64);
                let inside = after;
                after = held(at(b));
                if inside == after {
                    continue;
                }
                let (mut same, mut other) = (a, b);
                for _ in 0..50 {
                    let middle = 0.5 * (same + other);
                    if held(at(middle)) == inside {
                        same = middle;
                    } else {
                        other = middle;
                    }
                }
                if inside {
                    sum += long * self.along(&at, edge % 2, start.unwrap_or(a), same);
                    pieces += 1;
                    (left, start) = (Some(azimuth(at(same))), None);
                } else {
                    let here = azimuth(at(other));
                    match left.take() {
                        Some(from) => sum += sum_of_arc(cap, from, here),
                        None => entered = Some(here),
                    }
                    start = Some(other);
                }
            }
            if let Some(start) = start {
                sum += long * self.along(&at, edge % 2, start, 1.0);
                pieces += 1;
            }
        }
        if let (Some(from), Some(to)) = (left, entered) {
            sum += sum_of_arc(cap, from, to);
        }
        let axis = [0, 1].map(|k| 0.5 + 0.5 * self.principal[k]);
        let around_axis = r.u0 < axis[0] && axis[0] < r.u1 && r.v0 < axis[1] && axis[1] < r.v1;
        if pieces == 0 && around_axis {
            // The circle lies inside.
            return 2.0 * PI * cap;
        }
        sum
    }

    /// ∫∫ f du dv over the part of the image that holds sphere.
    fn over_the_held(self, f: impl Fn(Uv<f64>) -> f64) -> f64 {
        const PARTS: usize = 4;
        let at = |k: usize| k as f64 / PARTS as f64;
        let value = |u: f64, v: f64| {
            let uv = Uv::flat(u, v);
            if one::contains(self, uv) {
                f(uv)
            } else {
                f64::NAN
            }
        };
        let part = |k: usize| {
            let (i, j) = (k % PARTS, k / PARTS);
            let rect = Rect {
                u0: at(i),
                u1: at(i + 1),
                v0: at(j),
                v1: at(j + 1),
            };
            solid_angle::outlined(rect, &value)
        };
        (0..PARTS * PARTS).map(part).sum()
    }

    /// The largest of sign · density: the best of a lattice, then uphill in steps that get shorter.
    fn extreme(self, sign: f64) -> f64 {
        const LATTICE: usize = 48;
        let value = |at: [f64; 2]| {
            let uv = Uv::flat(at[0], at[1]);
            if one::contains(self, uv) {
                sign * one::density(self, uv)
            } else {
                f64::NEG_INFINITY
            }
        };
        let lattice = (0..(LATTICE + 1) * (LATTICE + 1))
            .map(|k| [k % (LATTICE + 1), k / (LATTICE + 1)].map(|i| i as f64 / LATTICE as f64));
        let mut best =
            lattice
                .map(|at| (value(at), at))
                .fold(
                    (f64::NEG_INFINITY, [0.5; 2]),
                    |a, b| if b.0 > a.0 { b } else { a },
                );
        let mut step = 1.0 / LATTICE as f64;
        while step > 1e-10 {
            let around = [[step, 0.0], [-step, 0.0], [0.0, step], [0.0, -step]];
            let places = around.map(|d| [0, 1].map(|k| (best.1[k] + d[k]).clamp(0.0, 1.0)));
            let found = places
                .map(|at| (value(at), at))
                .into_iter()
                .fold(best, |a, b| if b.0 > a.0 { b } else { a });
            if found.0 > best.0 {
                best = found;
            } else {
                step *= 0.5;
            }
        }
        sign * best.0
    }
}

impl<L: Lens> Projection for Camera<L> {
    const INFO: Info = L::NAMES;

    const COMMON: bool = false;
    const SINGLE: bool = false;

    fn check(parameters: &[f64]) -> Result<(), String> {
        let camera = Self::with_parameters(parameters);
        if camera.whole || camera.held().1 {
            return Ok(());
        }
        Err(
            "Expected a camera whose lens has an inverse somewhere in the image, got one that has none."
                .into(),
        )
    }

    fn with_parameters(parameters: &[f64]) -> Self {
        let [fx, fy, cx, cy, aspect] = [0, 1, 2, 3, 4].map(|k| parameters[k]);
        let (focal, principal) = ([2.0 * fx, 2.0 * fy], [2.0 * cx, 2.0 * cy]);
        let corner = [0, 1].map(|k| (1.0 + f64::abs(principal[k])) / focal[k]);
        let camera = Camera {
            lens: L::new(&parameters[SENSOR..], angle::length(corner[0], corner[1])),
            focal,
            principal,
            aspect,
            whole: false,
            held_within: f64::INFINITY,
        };
        let whole = camera.held().0;
        Camera {
            whole,
            held_within: if whole {
                f64::INFINITY
            } else {
                camera.farthest_held()
            },
            ..camera
        }
    }

    fn accept<V: Visitor>(self, visitor: V) -> V::Output {
        L::accept(self, visitor)
    }

    fn size(self, n: usize) -> (usize, usize) {
        size_of_aspect(self.aspect, n)
    }

    fn coverage(self) -> Coverage {
        Coverage::Part(match L::CLOSED_FORM {
            Some(exact) => exact(Rect::WHOLE, self.half(), self.principal),
            None => self.around(Rect::WHOLE),
        })
    }

    fn used_part(self) -> f64 {
        if self.whole {
            1.0
        } else {
            self.over_the_held(|_| 1.0)
        }
    }

    fn density_range(self) -> (f64, f64) {
        let (low, high) = (self.extreme(-1.0), self.extreme(1.0));
        if self.whole {
            return (low, high);
        }
        // Along the circle at which the lens ends, where that lies in the image.
        let (sin, cos) = angle::sin_cos(self.lens.rim() * (1.0 - 1e-12));
        let rim = lens::extremes(2.0 * PI, &|azimuth| {
            let (y, x) = angle::sin_cos(azimuth);
            let uv = one::encode(self, [sin * x, sin * y, cos]);
            if one::contains(self, uv) {
                one::density(self, uv)
            } else {
                high
            }
        });
        (low.min(rim.0), high.max(rim.1))
    }

    fn seam(self) -> Seam {
        Seam::Ends
    }

    fn outline(self) -> Outline {
        if self.whole {
            Outline::Square
        } else {
            Self::INFO.outline
        }
    }

    fn held_ellipse(self) -> Option<[[f64; 2]; 2]> {
        let radius = self.lens.held_radius() * WITHIN;
        Some([self.principal, self.focal.map(|focal| focal * radius)])
    }

    #[inline(always)]
    fn encode<R: Real>(self, d: [R; 3]) -> Uv<R> {
        let ([a, b], seen) = self.lens.project(d);
        let p = a * R::new(self.focal[0]) + R::new(self.principal[0]);
        let q = b * R::new(self.focal[1]) + R::new(self.principal[1]);
        let edge = R::new(1.0 + LET_OUT);
        let inside = seen & p.abs().at_most(edge) & q.abs().at_most(edge);
        Uv::held(p, q, inside)
    }

    #[inline(always)]
    fn decode<R: Real>(self, uv: Uv<R>) -> [R; 3] {
        self.lens.unproject(self.point(uv))
    }

    #[inline(always)]
    fn density<R: Real>(self, uv: Uv<R>) -> R {
        match self.lens.density(self.point(uv)) {
            Some(density) => density * R::new(4.0 / (self.focal[0] * self.focal[1])),
            None => projection::density(self, uv),
        }
    }

    #[inline(always)]
    fn contains<R: Real>(self, uv: Uv<R>) -> R::Mask {
        if self.whole {
            return uv.in_bounds(1);
        }
        uv.in_bounds(1) & self.lens.holds(self.point(uv))
    }

    fn is_smooth(self, rect: Rect, corners: impl Fn() -> [f64; 4]) -> bool {
        L::CLOSED_FORM.is_none()
            && solid_angle::is_small(rect)
            && (self.whole || is_level(corners()))
    }

    fn solid_angle(self, rect: Rect) -> f64 {
        let density = |u: f64, v: f64| one::held_density(self, Uv::flat(u, v));
        if !self.whole {
            if self.is_beyond(rect) {
                return 0.0;
            }
            // Beside the rim the density has a root: where it varies much, and where the rim is.
            let corners = [(0, 0), (0, 1), (1, 0), (1, 1)]
                .map(|(i, j)| density([rect.u0, rect.u1][i], [rect.v0, rect.v1][j]));
            if !is_level(corners) {
                return self.around(rect);
            }
        }
        match L::CLOSED_FORM {
            Some(exact) => exact(rect, self.half(), self.principal),
            None if solid_angle::is_small(rect) => {
                solid_angle::smooth(rect, |u, v| one::density(self, Uv::flat(u, v)))
            }
            None => solid_angle::quadrature(rect, &density),
        }
    }
}

/// Whether the least of four densities is nearly the most.
fn is_level(corners: [f64; 4]) -> bool {
    let most = corners.into_iter().fold(0.0, f64::max);
    // What is not a number is no corner.
    corners.iter().all(|&x| x > 0.8 * most)
}

/// ∫ (1 - cos θ) dφ along the circle at which a lens ends, counterclockwise from one azimuth to another.
fn sum_of_arc(cap: f64, from: f64, to: f64) -> f64 {
    let turn = (to - from).rem_euclid(2.0 * PI);
    // An edge that only touches the circle leaves it where it comes back, to rounding.
    if turn > 2.0 * PI - 1e-9 {
        0.0
    } else {
        cap * turn
    }
}

impl<L> Camera<L> {
    /// Half the image's width and height, on the plane.
    fn half(&self) -> [f64; 2] {
        self.focal.map(|focal| 1.0 / focal)
    }
}

/// The angle from the axis up to which the image radius of a lens grows, and no farther than `end`: it grows while its slope
/// is more than [`LEAST_SLOPE`] of the slope of its chord. `at` gives radius and slope, no numbers beyond the lens's domain.
pub fn grows_up_to(end: f64, at: impl Fn(f64) -> [f64; 2]) -> f64 {
    last(end, |angle| {
        let [radius, slope] = at(angle);
        radius > 0.0 && slope * angle > LEAST_SLOPE * radius
    })
}

/// The last place on [0, end] up to which something holds, which it does at the start.
pub fn last(end: f64, holds: impl Fn(f64) -> bool) -> f64 {
    last_of(2048, end, holds)
}

/// At how many radii inverses are tried. Where the image radius nearly stands still on its way, Newton's method may leap in a ring as
/// narrow as a 250th of the whole.
pub const RADII: usize = 1024;

/// [`last`], by so many places that are tried first.
pub fn last_of(tried: usize, end: f64, holds: impl Fn(f64) -> bool) -> f64 {
    let at = |k: usize| end * k as f64 / tried as f64;
    let Some(first) = (1..=tried).find(|&k| !holds(at(k))) else {
        return end;
    };
    let (mut low, mut high) = (at(first - 1), at(first));
    for _ in 0..60 {
        let middle = 0.5 * (low + high);
        if holds(middle) {
            low = middle;
        } else {
            high = middle;
        }
    }
    low
}

/// How many places a first guess goes through: fours of them.
const NODES: usize = 12;

/// A polynomial that stands for the inverse of a growing function to some digits, from which Newton's method starts.
///
/// What is guessed is a ratio of the two radii as a function of the square s of the image's. Where the function turns back, at s = fold, its
/// inverse has a root; so the polynomial is one of √(1 - s/fold).
#[derive(Clone, Copy, Debug)]
pub struct Guess {
    /// 1/fold.
    fold: f64,
    /// Brings 1 - √(1 - s/fold) to [0, 1].
    scale: f64,
    /// The coefficients of its powers.
    coefficients: [f64; NODES],
}

impl Guess {
    /// For s up to `end`, of a function that turns back at `fold`, which may be infinite.
    pub fn new(end: f64, fold: f64, ratio: impl Fn(f64) -> f64) -> Self {
        // A fold far off is none.
        let fold = fold.clamp(end, 4.0 * end);
        let span = 1.0 - (1.0 - end / fold).max(0.0).sqrt();
        let coefficients = through(1.0, |x| {
            let root = 1.0 - span * x;
            ratio(fold * (1.0 - root) * (1.0 + root))
        });
        Guess {
            fold: 1.0 / fold,
            scale: 1.0 / span,
            coefficients,
        }
    }

    /// The ratio at s.
    #[inline(always)]
    pub fn at<R: Real>(self, s: R) -> R {
        let root = max(R::ONE - s * R::new(self.fold), R::ZERO).sqrt();
        let x = (R::ONE - root) * R::new(self.scale);
        polynomial(&self.coefficients, x)
    }
}

/// The coefficients of the polynomial through a function's values at Chebyshev's places of [0, end], by Newton's divided differences.
fn through<const N: usize>(end: f64, f: impl Fn(f64) -> f64) -> [f64; N] {
    let x: [f64; N] =
        std::array::from_fn(|k| 0.5 + 0.5 * angle::cos((k as f64 + 0.5) / N as f64 * PI));
    let mut difference = x.map(|x| f(end * x));
    for order in 1..N {
        for k in (order..N).rev() {
            difference[k] = (difference[k] - difference[k - 1]) / (x[k] - x[k - order]);
        }
    }
    let mut coefficients = [0.0; N];
    for k in (0..N).rev() {
        // polynomial = polynomial · (X - x[k]) + difference[k].
        for power in (1..N).rev() {
            coefficients[power] = coefficients[power - 1] - x[k] * coefficients[power];
        }
        coefficients[0] = difference[k] - x[k] * coefficients[0];
    }
    let mut scale = 1.0;
    for coefficient in &mut coefficients {
        *coefficient *= scale;
        scale /= end;
    }
    coefficients
}

/// The sum of coefficients, four and more, times powers of x. By halves, as Estrin has it: one power after the other makes the
/// processor wait.
#[inline(always)]
fn polynomial<R: Real, const N: usize>(coefficients: &[f64; N], x: R) -> R {
    let pair = |k: usize| R::new(coefficients[k]) + x * R::new(coefficients[k + 1]);
    let square = x * x;
    let four = |k: usize| pair(k) + square * pair(k + 2);
    let fourth = square * square;
    let mut sum = four(N - 4);
    for k in (0..N / 4 - 1).rev() {
        sum = four(4 * k) + fourth * sum;
    }
    sum
}

/// How many places a plain guess goes through: fours, too.
const FEW_NODES: usize = 8;

/// The same as [`Guess`], far from where the function turns back: a polynomial of s alone.
#[derive(Clone, Copy, Debug)]
pub struct PlainGuess {
    coefficients: [f64; FEW_NODES],
}

impl PlainGuess {
    /// For s up to `end`.
    pub fn new(end: f64, ratio: impl Fn(f64) -> f64) -> Self {
        PlainGuess {
            coefficients: through(end, ratio),
        }
    }

    /// The ratio at s.
    #[inline(always)]
    pub fn at<R: Real>(self, s: R) -> R {
        polynomial(&self.coefficients, s)
    }
}

/// The place on [0, end] where a growing function reaches a value, by bisection.
pub fn reaches(value: f64, end: f64, f: impl Fn(f64) -> f64) -> f64 {
    let (mut low, mut high) = (0.0, end);
    for _ in 0..100 {
        let middle = 0.5 * (low + high);
        if f(middle) < value {
            low = middle;
        } else {
            high = middle;
        }
    }
    0.5 * (low + high)
}
