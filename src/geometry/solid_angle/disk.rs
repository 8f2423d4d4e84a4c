//! Azimuthal maps: the valid image is the disk p² + q² <= 1.
//!
//! All work is done in the first quadrant of (p, q), where the rim is one falling arc. A rectangle
//! p0..p1 × q0..q1 that it crosses is two strips: the *full* one, left, whose top edge is inside, and
//! the *cut* one below the arc.

use super::gauss::{G2, G3, G4, G6, G16, Rule, line, tensor};
use super::{Quarter, Rect};
use crate::number::angle;
use crate::number::real::Real;
use std::f64::consts::PI;

/// From this area on (in p, q) the absolute error of a closed form, 1e-16 or so, is small enough.
const BIG_AREA: f64 = 0.01;

/// The same for the shorter side and Green's theorem, whose edges cancel more in a thin rectangle.
const BIG_SIDE: f64 = 0.25;

/// 1 - p² - q² at the image point (a, b): the larger coordinate is close to the rim, so take its
/// square from the exact 1 - p² = 4a(1 - a).
fn depth(a: f64, b: f64) -> f64 {
    let (rim, other) = if a < b {
        (a, 1.0 - 2.0 * b)
    } else {
        (b, 1.0 - 2.0 * a)
    };
    4.0 * rim * (1.0 - rim) - other * other
}

/// √(1 - p²): where the rim crosses the line of constant a.
fn chord(a: f64) -> f64 {
    2.0 * (a * (1.0 - a)).sqrt()
}

/// x - y from x² - y² and x + y; 0 if x < y.
fn gap(squares: f64, sum: f64) -> f64 {
    if squares > 0.0 { squares / sum } else { 0.0 }
}

impl Quarter {
    fn p0(self) -> f64 {
        1.0 - 2.0 * self.a1
    }

    fn p1(self) -> f64 {
        1.0 - 2.0 * self.a0
    }

    fn q0(self) -> f64 {
        1.0 - 2.0 * self.b1
    }

    fn q1(self) -> f64 {
        1.0 - 2.0 * self.b0
    }

    fn dp(self) -> f64 {
        2.0 * (self.a1 - self.a0)
    }

    fn dq(self) -> f64 {
        2.0 * (self.b1 - self.b0)
    }

    /// Mirrored, if need be, so that q0 >= p0: then the arc is never steep in a small rectangle.
    fn ordered(self) -> Self {
        if self.b1 > self.a1 { self.swap() } else { self }
    }

    fn outside(self) -> bool {
        depth(self.a1, self.b1) <= 0.0
    }

    fn inside(self) -> bool {
        depth(self.a0, self.b0) >= 0.0
    }
}

/// The part of a rectangle inside the disk.
struct Strips {
    /// Width of the full strip.
    full: f64,
    /// Width of the strip below the arc.
    cut: f64,
    /// Height of the region at p0, which is also that of the cut strip at its left end.
    left: f64,
    /// Height at p1.
    right: f64,
}

impl Strips {
    /// Every length is a quotient of [`depth`]s and so has the error of the circle and no more.
    fn new(c: Quarter) -> Self {
        let (dp, dq, p0, q0) = (c.dp(), c.dq(), c.p0(), c.q0());
        if c.inside() {
            return Self {
                full: dp,
                cut: 0.0,
                left: dq,
                right: dq,
            };
        }
        let near = depth(c.a1, c.b1);
        let full = gap(depth(c.a1, c.b0), chord(c.b0) + p0).min(dp);
        let corner = depth(c.a0, c.b1);
        let reach = if corner >= 0.0 {
            dp
        } else {
            gap(near, chord(c.b1) + p0).min(dp)
        };
        Self {
            full,
            cut: (reach - full).max(0.0),
            left: if full > 0.0 {
                dq
            } else {
                gap(near, chord(c.a1) + q0).min(dq)
            },
            right: gap(corner, chord(c.a0) + q0).min(dq),
        }
    }
}

/// Area in (u, v) of the part of `r` inside the disk of center (½, ½) and radius ½.
pub fn disk_area(r: Rect) -> f64 {
    if interior(r) {
        return r.du() * r.dv();
    }
    0.25 * Quarter::sum(r, |c| {
        if c.outside() {
            return 0.0;
        }
        let s = Strips::new(c);
        let trapezoid = 0.5 * s.cut * (s.left + s.right);
        s.full * c.dq() + trapezoid + segment(angle::length(s.cut, s.left - s.right))
    })
}

/// Whether all of `r` is inside the disk.
fn interior(r: Rect) -> bool {
    let p = (2.0 * r.u0 - 1.0).abs().max((2.0 * r.u1 - 1.0).abs());
    let q = (2.0 * r.v0 - 1.0).abs().max((2.0 * r.v1 - 1.0).abs());
    p * p + q * q <= 1.0
}

/// Area between a chord of the unit circle and its arc: asin x - x√(1-x²) at x = chord/2.
fn segment(chord: f64) -> f64 {
    let x = 0.5 * chord;
    if x > 0.1 {
        return angle::asin(x) - x * (1.0 - x * x).sqrt();
    }
    // The series of its derivative 2x²/√(1-x²), since the difference cancels to x³.
    let s = x * x;
    let tail = 5.0 / 72.0 + s * (35.0 / 704.0 + s * (63.0 / 1664.0 + s * (77.0 / 2560.0)));
    s * x * (2.0 / 3.0 + s * (1.0 / 5.0 + s * (3.0 / 28.0 + s * tail)))
}

/// Solid angle of a rectangle of the MatCap, the orthographic image of a hemisphere.
pub fn matcap(r: Rect) -> f64 {
    Quarter::sum(r, matcap_quarter)
}

fn matcap_quarter(c: Quarter) -> f64 {
    let near = depth(c.a1, c.b1);
    if near <= 0.0 {
        return 0.0;
    }
    if let Some(rule) = matcap_rule(depth(c.a0, c.b0), 0.5 * c.dp().max(c.dq())) {
        return tensor(rule, [c.p0(), c.q0()], [c.dp(), c.dq()], |p, q| {
            1.0 / (1.0 - p * p - q * q).sqrt()
        });
    }
    // Along p, the integrand has further singularities where the rim meets q0 and at p = 1. The two
    // tests keep both as far away from a strip as it is wide.
    let c = c.ordered();
    let local = c.q0() * c.q0() >= near;
    let steep = (c.p0() + c.p1()) * c.dp() > 2.0 * (c.q0() + c.q1()) * c.dq();
    // Halving ends at the spacing of floats.
    let steep = steep && c.dp() > 1e-12;
    if local && !steep {
        matcap_strips(c)
    } else if c.dp() * c.dq() >= BIG_AREA {
        matcap_closed(c)
    } else {
        c.halves().map(matcap_quarter).iter().sum()
    }
}

/// The rule for a rectangle of half width `half` whose far corner has the given depth.
///
/// 1/√(1-p²-q²) is analytic up to the rim, at least depth/2 away, so that ρ > depth/half: these
/// bounds make ρ^-2k less than 1e-14. No rule is left for texels at the rim.
fn matcap_rule(depth: f64, half: f64) -> Option<&'static Rule> {
    match depth / half {
        x if x >= 3200.0 => Some(&G2),
        x if x >= 220.0 => Some(&G3),
        x if x >= 60.0 => Some(&G4),
        x if x >= 15.0 => Some(&G6),
        _ => None,
    }
}

/// Exact across, in q, and Gauss–Legendre along p in t = √(p_rim - p), which makes it smooth.
fn matcap_strips(c: Quarter) -> f64 {
    let s = Strips::new(c);
    let (p1, q0, q1) = (c.p1(), c.q0(), c.q1());
    let mut sum = 0.0;
    if s.full > 0.0 {
        let rim = chord(c.b0);
        let squares = c.dq() * (q0 + q1);
        sum += along(gap(depth(c.a0, c.b0), rim + p1), s.full, |t| {
            // asin(q1/√w) - asin(q0/√w) with w = 1 - p², as the angle between two vectors.
            let z1 = t * (2.0 * rim - t * t).max(0.0).sqrt();
            let z0 = (z1 * z1 + squares).sqrt();
            let w = z1 * z1 + q1 * q1;
            angle::atan2(w * squares / (q1 * z0 + q0 * z1), z0 * z1 + q0 * q1)
        });
    }
    if s.cut > 0.0 {
        let rim = chord(c.b1);
        sum += along(gap(depth(c.a0, c.b1), rim + p1), s.cut, |t| {
            angle::atan2(t * (2.0 * rim - t * t).max(0.0).sqrt(), q0)
        });
    }
    sum
}

/// ∫ f dp over p_rim - p from `near` to `near + width`, f a function of its root t.
fn along(near: f64, width: f64, f: impl Fn(f64) -> f64) -> f64 {
    let t0 = near.sqrt();
    let t1 = (near + width).sqrt();
    line(&G16, t0, width / (t0 + t1), |t| 2.0 * t * f(t))
}

/// Inclusion–exclusion: the solid angle over 0..p × 0..q is p asin(q/√(1-p²)) + q asin(p/√(1-q²)) -
/// atan(pq/z). With z = 0 outside of the disk it holds there, too.
fn matcap_closed(c: Quarter) -> f64 {
    let corner = |a: f64, b: f64| {
        let (p, q, z) = (1.0 - 2.0 * a, 1.0 - 2.0 * b, depth(a, b).max(0.0).sqrt());
        p * angle::atan2(q, z) + q * angle::atan2(p, z) - angle::atan2(p * q, z)
    };
    let far = corner(c.a0, c.b0) + corner(c.a1, c.b1);
    (far - corner(c.a0, c.b1) - corner(c.a1, c.b0)).max(0.0)
}

/// Solid angle of a rectangle of any azimuthal map that fills the unit disk of (p, q).
///
/// `density(s)` is dω/(du dv) and `h(s)` is (1 - cos θ)/s, both as functions of s = p² + q² and both
/// smooth, with no singularity nearer than about 1 to the disk.
pub fn azimuthal(r: Rect, density: impl Fn(f64) -> f64, h: impl Fn(f64) -> f64) -> f64 {
    let half = r.du().max(r.dv());
    if half <= SMALL && interior(r) {
        return tensor(
            azimuthal_rule(half),
            [r.u0, r.v0],
            [r.du(), r.dv()],
            |u, v| {
                let (p, q) = (2.0 * u - 1.0, 2.0 * v - 1.0);
                density(p * p + q * q)
            },
        );
    }
    Quarter::sum(r, |c| azimuthal_quarter(c, &density, &h))
}

/// Half widths, in p, up to which a rule of six points does.
const SMALL: f64 = 1.0 / 16.0;

/// ρ is 2/half or more. The bounds leave room for densities that go to zero at the rim.
fn azimuthal_rule(half: f64) -> &'static Rule {
    match half {
        x if x <= 1.0 / 8000.0 => &G2,
        x if x <= 1.0 / 500.0 => &G3,
        x if x <= 1.0 / 64.0 => &G4,
        _ => &G6,
    }
}

fn azimuthal_quarter(c: Quarter, density: &impl Fn(f64) -> f64, h: &impl Fn(f64) -> f64) -> f64 {
    if c.outside() {
        return 0.0;
    }
    if c.dp().min(c.dq()) >= BIG_SIDE {
        return green(c, h);
    }
    let half = 0.5 * c.dp().max(c.dq());
    if half > SMALL {
        return c
            .halves()
            .map(|c| azimuthal_quarter(c, density, h))
            .iter()
            .sum();
    }
    let c = c.ordered();
    let s = Strips::new(c);
    let (p0, q0) = (c.p0(), c.q0());
    let value = |p: f64, q: f64| density(p * p + q * q);
    let full = tensor(azimuthal_rule(half), [p0, q0], [s.full, c.dq()], value);
    let edge = p0 + s.full;
    let cut = line(&G16, 0.0, s.cut, |x| {
        // The arc's height over q0 from that at the left end, to lose no digits in a small texel.
        let p = edge + x;
        let drop = x * (p + edge) / ((1.0 - p * p).sqrt() + (1.0 - edge * edge).sqrt());
        line(&G6, q0, (s.left - drop).max(0.0), |q| value(p, q))
    });
    0.25 * (full + cut)
}

/// ω = ∮ (1 - cos θ) dφ = ∮ h(s) (p dq - q dp) counter-clockwise; on the arc that is h(1) Δφ.
fn green(c: Quarter, h: &impl Fn(f64) -> f64) -> f64 {
    let s = Strips::new(c);
    let (p0, q0) = (c.p0(), c.q0());
    let edge = |fixed: f64, from: f64, length: f64| {
        let weight = |x: f64| h(x * x + fixed * fixed);
        fixed * line(&G16, from, length, weight)
    };
    let reach = s.full + s.cut;
    let edges = edge(c.p1(), q0, s.right) - edge(q0, p0, reach) + edge(c.q1(), p0, s.full)
        - edge(p0, q0, s.left);
    let arc = if s.cut > 0.0 {
        let ([p, q], [x, y]) = ([p0 + reach, q0 + s.right], [p0 + s.full, q0 + s.left]);
        angle::atan2(p * y - q * x, p * x + q * y)
    } else {
        0.0
    };
    (h(1.0) * arc + edges).max(0.0)
}

/// Solid angle of a rectangle of an azimuthal map that fills the unit disk, along the azimuth: `band(inner, outer)`
/// is cos θ(inner) - cos θ(outer), written without that difference.
///
/// It needs no smooth density, only bands of closed form, and errs by the rounding of azimuths: 1e-16 over the
/// angle that a texel takes.
pub fn bands(r: Rect, band: impl Fn(f64, f64) -> f64) -> f64 {
    Quarter::sum(r, |c| bands_quarter(c, &band))
}

fn bands_quarter(c: Quarter, band: &impl Fn(f64, f64) -> f64) -> f64 {
    if c.outside() {
        return 0.0;
    }
    let (p0, p1, q0, q1) = (c.p0(), c.p1(), c.q0(), c.q1());
    let (low, high) = (angle::atan2(q0, p1), angle::atan2(q1, p0));
    // Where the sides that bound a ray change: at corners, and where the rim crosses a side.
    let mut cuts = [
        low,
        angle::atan2(q0, p0),
        angle::atan2(q1, p1),
        angle::atan2(chord(c.a1), p0),
        angle::atan2(chord(c.a0), p1),
        angle::atan2(q0, chord(c.b1)),
        angle::atan2(q1, chord(c.b0)),
        high,
    ];
    cuts = cuts.map(|cut| cut.clamp(low, high));
    cuts.sort_by(f64::total_cmp);
    let panel = |from: f64, to: f64| {
        // A root at either end of a panel, where the rim meets a side, is smooth in ψ: φ runs as sin²(πψ/2).
        line(&G16, 0.0, 1.0, |psi| {
            let (along, across) = f64::sin_cos_half_turns(0.5 * psi);
            let (sin, cos) = angle::sin_cos(from + (to - from) * along * along);
            let inner = (p0 / cos).max(q0 / sin).min(1.0);
            let outer = (p1 / cos).min(q1 / sin).clamp(inner, 1.0);
            band(inner, outer) * PI * along * across
        }) * (to - from)
    };
    cuts.windows(2)
        .filter(|ends| ends[1] > ends[0])
        .map(|ends| {
            // Sixteen nodes are for a fifth of a radian; only texels beside the center, or long ones, take more.
            let parts = ((ends[1] - ends[0]) / 0.2).ceil().max(1.0);
            let at = |k: f64| ends[0] + (ends[1] - ends[0]) * (k / parts);
            (0..parts as usize)
                .map(|k| panel(at(k as f64), at(k as f64 + 1.0)))
                .sum::<f64>()
        })
        .sum()
}
