//! Gauss–Legendre rules on [0, 1], and integrals over lines and rectangles.
//!
//! A rule of k points errs by about ρ^-2k times the largest value inside the ellipse in which the
//! integrand is analytic; ρ is the sum of its half axes in half widths of the interval. Callers pick
//! the rule by the distance to the nearest singularity.

use super::Rect;

/// Points and weights on [0, 1]; the weights add up to 1.
pub(super) type Rule = [[f64; 2]];

/// ∫ f(x) dx from `x` to `x + dx`.
pub(super) fn line(rule: &Rule, x: f64, dx: f64, mut f: impl FnMut(f64) -> f64) -> f64 {
    let mut sum = 0.0;
    for &[t, w] in rule {
        sum += w * f(x + dx * t);
    }
    dx * sum
}

/// ∫∫ f(x, y) dx dy over the rectangle from `[x, y]` to `[x + dx, y + dy]`.
pub(super) fn tensor(
    rule: &Rule,
    [x, y]: [f64; 2],
    [dx, dy]: [f64; 2],
    mut f: impl FnMut(f64, f64) -> f64,
) -> f64 {
    line(rule, x, dx, |x| line(rule, y, dy, |y| f(x, y)))
}

/// How often [`halved`] halves, down to a 64th.
const HALVINGS: u32 = 6;
/// Accepted difference of the rule of 16 points from two of six, relative. Where these err by that, the former errs by less than 1e-15.
const SETTLED: f64 = 1e-9;
/// The same, of what cancels and has rounding alone left of numbers of size 1.
const CANCELED: f64 = 1e-12;

/// ∫ f(x) dx of a function that is smooth but for some places, if any, that singularities come near to: halved there.
pub fn halved(from: f64, to: f64, f: &dyn Fn(f64) -> f64) -> f64 {
    part_of_halved(from, to, f, HALVINGS)
}

fn part_of_halved(from: f64, to: f64, f: &dyn Fn(f64) -> f64, left: u32) -> f64 {
    let middle = 0.5 * (from + to);
    let whole = line(&G16, from, to - from, f);
    let halves = line(&G6, from, middle - from, f) + line(&G6, middle, to - middle, f);
    if left == 0 || (whole - halves).abs() <= SETTLED * whole.abs() + CANCELED * (to - from) {
        return whole;
    }
    part_of_halved(from, middle, f, left - 1) + part_of_halved(middle, to, f, left - 1)
}

/// How often [`quadrature`] halves a rectangle: down to 64 cells a side.
const DEPTH: u32 = 6;
/// Accepted difference of the 2- and the 4-point rule. The error of the latter goes as its square.
const AGREEMENT: f64 = 1e-6;
/// Longest side of a cell that may be accepted. Over a longer one two rules may agree by chance.
const SHORT: f64 = 1.0 / 16.0;

/// ∫∫ density du dv for maps without a closed form, relative error 1e-10 where the density is smooth.
///
/// Points where the density is not finite count as 0, and cells with such points are subdivided down
/// to 1/64 of the rectangle: one that the edge of the valid image crosses is good to about 1e-3. A
/// cell counts as valid by its four corners and the 20 points of two rules. A cell of a subdivision
/// with no valid point among these is 0 at once.
pub fn quadrature(r: Rect, density: &dyn Fn(f64, f64) -> f64) -> f64 {
    let whole = probe(&G4, r, density);
    let area = r.du() * r.dv();
    if area > 0.0 {
        cell(r, density, whole, whole.0.abs() / area, DEPTH)
    } else {
        0.0
    }
}

/// Steps along the sides of a rectangle in which [`outlined`] looks for the edge of the valid image.
const STEPS: usize = 8;

/// ∫∫ density du dv over the part of a rectangle where it is finite, the edge of the valid image included: to
/// 1e-9 of the whole rectangle's integral where that edge is smooth, 1e-4 where it turns back inside the
/// rectangle. A corner of the valid image that reaches in between two of 32 places on the border is not seen.
///
/// Lines of constant v are cut where the edge crosses them, found by bisection; and their sum is cut where
/// the edge leaves the rectangle.
pub fn outlined(r: Rect, density: &dyn Fn(f64, f64) -> f64) -> f64 {
    if r.du() <= 0.0 || r.dv() <= 0.0 {
        return 0.0;
    }
    let at = |x: f64, dx: f64, k: usize| x + dx * (k as f64 / STEPS as f64);
    let mut valid = 0;
    for k in 0..STEPS {
        for (i, j) in [(k, 0), (STEPS, k), (STEPS - k, STEPS), (0, STEPS - k)] {
            let value = density(at(r.u0, r.du(), i), at(r.v0, r.dv(), j));
            valid += usize::from(value.is_finite());
        }
    }
    let middle = density(0.5 * (r.u0 + r.u1), 0.5 * (r.v0 + r.v1));
    if valid == 4 * STEPS && middle.is_finite() {
        return quadrature(r, density);
    }
    if valid == 0 && !middle.is_finite() {
        return 0.0;
    }
    let places = [0.0, 0.25, 0.5, 0.75, 1.0].map(|t| r.u0 + r.du() * t);
    let signature = |v: f64| places.map(|u| density(u, v).is_finite());
    let mut sum = 0.0;
    for k in 0..STEPS {
        let (mut from, to) = (at(r.v0, r.dv(), k), at(r.v0, r.dv(), k + 1));
        let (mut before, last) = (signature(from), signature(to));
        // Each place along the line may change once in a step.
        for _ in 0..places.len() {
            if before == last {
                break;
            }
            let (mut low, mut high) = (from, to);
            while high - low > 1e-15 {
                let middle = 0.5 * (low + high);
                if middle <= low || middle >= high {
                    break;
                }
                if signature(middle) == before {
                    low = middle;
                } else {
                    high = middle;
                }
            }
            sum += strip(r, from, low, density);
            (from, before) = (high, signature(high));
        }
        sum += strip(r, from, to, density);
    }
    sum
}

/// The part of [`outlined`] between two values of v.
fn strip(r: Rect, from: f64, to: f64, density: &dyn Fn(f64, f64) -> f64) -> f64 {
    line(&G6, from, to - from, |v| {
        let valid = |u: f64| density(u, v).is_finite();
        // Between two places of which one is valid: the valid side of the edge.
        let edge = |mut inside: f64, mut outside: f64| {
            for _ in 0..48 {
                let middle = 0.5 * (inside + outside);
                if valid(middle) {
                    inside = middle;
                } else {
                    outside = middle;
                }
            }
            inside
        };
        let places = [0.0, 0.25, 0.5, 0.75, 1.0].map(|t| r.u0 + r.du() * t);
        let mut sum = 0.0;
        for pair in places.windows(2) {
            let (a, b) = (pair[0], pair[1]);
            let (from, to) = match (valid(a), valid(b)) {
                (true, true) => (a, b),
                (true, false) => (a, edge(a, b)),
                (false, true) => (edge(b, a), b),
                (false, false) => continue,
            };
            sum += line(&G4, from, to - from, |u| density(u, v));
        }
        sum
    })
}

/// A cell of which the four-point rule is known.
fn cell(
    r: Rect,
    density: &dyn Fn(f64, f64) -> f64,
    (high, high_valid): (f64, usize),
    mean: f64,
    depth: u32,
) -> f64 {
    let (low, low_valid) = probe(&G2, r, density);
    let corners = [(r.u0, r.v0), (r.u1, r.v0), (r.u1, r.v1), (r.u0, r.v1)];
    let corners_valid = corners
        .iter()
        .filter(|&&(u, v)| density(u, v).is_finite())
        .count();
    let valid = corners_valid + low_valid + high_valid;
    let tolerance = AGREEMENT * high.abs().max(mean * r.du() * r.dv());
    let short = r.du().max(r.dv()) <= SHORT;
    let smooth = short && valid == 24 && (high - low).abs() <= tolerance;
    let empty = valid == 0 && depth < DEPTH;
    if smooth || empty || depth == 0 {
        return high;
    }
    r.quarters()
        .map(|r| cell(r, density, probe(&G4, r, density), mean, depth - 1))
        .iter()
        .sum()
}

/// The integral over the points where the density is finite, and their number.
fn probe(rule: &Rule, r: Rect, density: &dyn Fn(f64, f64) -> f64) -> (f64, usize) {
    let (mut sum, mut valid) = (0.0, 0);
    for &[s, ws] in rule {
        for &[t, wt] in rule {
            let value = density(r.u0 + r.du() * s, r.v0 + r.dv() * t);
            if value.is_finite() {
                sum += ws * wt * value;
                valid += 1;
            }
        }
    }
    (sum * r.du() * r.dv(), valid)
}

pub(super) const G2: [[f64; 2]; 2] = [[0.2113248654051871, 0.5], [0.7886751345948129, 0.5]];
pub(super) const G3: [[f64; 2]; 3] = [
    [0.11270166537925831, 0.2777777777777778],
    [0.5, 0.4444444444444444],
    [0.8872983346207417, 0.2777777777777778],
];
pub(super) const G4: [[f64; 2]; 4] = [
    [0.06943184420297371, 0.17392742256872692],
    [0.33000947820757187, 0.32607257743127305],
    [0.6699905217924281, 0.32607257743127305],
    [0.9305681557970263, 0.17392742256872692],
];
pub(super) const G6: [[f64; 2]; 6] = [
    [0.03376524289842399, 0.08566224618958518],
    [0.16939530676686773, 0.1803807865240693],
    [0.38069040695840156, 0.23395696728634552],
    [0.6193095930415985, 0.23395696728634552],
    [0.8306046932331322, 0.1803807865240693],
    [0.966234757101576, 0.08566224618958518],
];
pub(super) const G16: [[f64; 2]; 16] = [
    [0.005299532504175033, 0.013576229705877048],
    [0.02771248846338371, 0.031126761969323947],
    [0.06718439880608412, 0.04757925584124639],
    [0.12229779582249849, 0.06231448562776694],
    [0.19106187779867811, 0.07479799440828837],
    [0.2709916111713863, 0.08457825969750127],
    [0.35919822461037054, 0.09130170752246179],
    [0.4524937450811813, 0.09472530522753425],
    [0.5475062549188188, 0.09472530522753425],
    [0.6408017753896295, 0.09130170752246179],
    [0.7290083888286137, 0.08457825969750127],
    [0.8089381222013219, 0.07479799440828837],
    [0.8777022041775016, 0.06231448562776694],
    [0.9328156011939158, 0.04757925584124639],
    [0.9722875115366163, 0.031126761969323947],
    [0.994700467495825, 0.013576229705877048],
];
