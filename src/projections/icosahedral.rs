//! Icosahedral: ten rhombi of two triangles each, gnomonic; the grid of weather and climate models.
//!
//! Source: the icosahedron with vertices at the poles and at latitudes ±atan ½, its twenty triangles joined in pairs
//! (Sadourny, Arakawa & Mintz 1968; the ten diamonds of DWD's GME, Majewski et al. 2002). Face k is the diamond
//! (north pole, two upper vertices, lower vertex) around azimuth 72°k + 36°, face 5 + k its neighbor below to the
//! right, down to the south pole. u runs down to the right, v down to the left. Within a triangle the map is linear in the
//! plane, so that great circles are straight; the density varies by 1.99.
//!
//! Domain: all directions. Singular: none. The diagonal u + v = 1 of each face is an edge of the solid, as its sides are.
//!
//! The sphere is folded: five sectors are turned to one and that one is mirrored, which leaves four triangles to tell
//! apart by three planes, where a search would look at twenty.

use crate::geometry::solid_angle;
use crate::geometry::solid_angle::Rect;
use crate::geometry::vector::cross;
use crate::number::real::Real;
use crate::projections::faces::{Cells, LayoutSpec, STRIP_AND_COLUMN};
use crate::projections::projection::{Coverage, Info, Projection, Seam, Uv};

/// Ten diamonds.
#[derive(Clone, Copy, Debug)]
pub struct Icosahedral;

const LAYOUTS: &[LayoutSpec] = &[
    STRIP_AND_COLUMN[0],
    LayoutSpec {
        name: "5x2",
        cells: Cells::Block(5, 2),
    },
];

/// Sine and cosine of the latitude of the rings of vertices.
const SIN: f64 = 0.447_213_595_499_957_9;
const COS: f64 = 0.894_427_190_999_915_9;
/// Of 36° and 72°.
const SIN_36: f64 = 0.587_785_252_292_473_1;
const COS_36: f64 = 0.809_016_994_374_947_5;
const SIN_72: f64 = 0.951_056_516_295_153_5;
const COS_72: f64 = 0.309_016_994_374_947_45;

/// (sine, cosine) of the azimuth of each sector's middle, 72°k + 36°.
const SECTORS: [[f64; 2]; 5] = [
    [SIN_36, COS_36],
    [SIN_72, -COS_72],
    [0.0, -1.0],
    [-SIN_72, -COS_72],
    [-SIN_36, COS_36],
];

/// Vertices around a sector's middle, as (right, up, ahead).
const NORTH: [f64; 3] = [0.0, 1.0, 0.0];
const SOUTH: [f64; 3] = [0.0, -1.0, 0.0];
const UPPER_RIGHT: [f64; 3] = [COS * SIN_36, SIN, COS * COS_36];
const UPPER_LEFT: [f64; 3] = [-COS * SIN_36, SIN, COS * COS_36];
const LOWER: [f64; 3] = [0.0, -SIN, COS];
const LOWER_RIGHT: [f64; 3] = [COS * SIN_72, -SIN, COS * COS_72];

/// Three vectors whose products with a direction are, but for a common factor, its coordinates by the corners a, b, c,
/// which run counterclockwise as seen from inside.
const fn dual(a: [f64; 3], b: [f64; 3], c: [f64; 3]) -> [[f64; 3]; 3] {
    [cross(c, b), cross(a, c), cross(b, a)]
}

/// The four triangles of a folded sector, each as (tip, right corner, left corner).
const TRIANGLES: [[[f64; 3]; 3]; 4] = [
    dual(NORTH, UPPER_RIGHT, UPPER_LEFT),
    dual(LOWER, UPPER_LEFT, UPPER_RIGHT),
    dual(UPPER_RIGHT, LOWER_RIGHT, LOWER),
    dual(SOUTH, LOWER, LOWER_RIGHT),
];

/// dω/(du dv) times |P|³ of the point P in the plane: twice a triangle's area times its distance.
const SCALE: f64 = 0.760_845_213_036_122_8;

/// The product of a vector that is known with another, without the terms that are zero.
#[inline(always)]
fn product<R: Real>(n: [f64; 3], d: [R; 3]) -> R {
    let term = |k: usize| R::new(n[k]) * d[k];
    if n[1] == 0.0 && n[2] == 0.0 {
        term(0)
    } else if n[0] == 0.0 {
        term(1) + term(2)
    } else if n[1] == 0.0 {
        term(0) + term(2)
    } else {
        term(0) + term(1) + term(2)
    }
}

/// The plane's point at (u, v) of a face, unfolded into its sector, as (right, up, ahead).
#[inline(always)]
fn flat<R: Real>(u: R, v: R, below: R::Mask) -> [R; 3] {
    let one = R::ONE;
    let beyond = (u + v).more(one);
    let tip = R::either(beyond, || u + v - one, || one - u - v);
    let right = R::either(beyond, || one - v, || u);
    let left = R::either(beyond, || one - u, || v);
    std::array::from_fn(|k| {
        let choose = |upper: f64, lower: f64| R::select(below, R::new(lower), R::new(upper));
        let (top, bottom) = (choose(NORTH[k], UPPER_RIGHT[k]), choose(LOWER[k], SOUTH[k]));
        let tip_corner = R::select(beyond, bottom, top);
        tip * tip_corner
            + right * choose(UPPER_RIGHT[k], LOWER_RIGHT[k])
            + left * choose(UPPER_LEFT[k], LOWER[k])
    })
}

/// (sine, cosine) of the middle of sector k.
#[inline(always)]
fn sector<R: Real>(k: R) -> (R, R) {
    let (mut sin, mut cos) = (R::new(SECTORS[0][0]), R::new(SECTORS[0][1]));
    for (n, [s, c]) in SECTORS.into_iter().enumerate().skip(1) {
        let here = k.equals(R::new(n as f64));
        sin = R::select(here, R::new(s), sin);
        cos = R::select(here, R::new(c), cos);
    }
    (sin, cos)
}

impl Projection for Icosahedral {
    const INFO: Info = Info {
        name: "icosahedral",
        title: "Icosahedral (ten diamonds)",
        known_as: &["icosahedron"],
        source: "Sadourny, Arakawa, Mintz 1968; Majewski et al. 2002, the icosahedral-hexagonal GME grid",
        summary: "Twenty gnomonic triangles as ten square faces: the most even gnomonic map; climate grids.",
        singular: "None; five triangles meet at each vertex.",
        axes: "+x -y -z",
        faces: 10,
        layouts: LAYOUTS,
        creases: &[[1.0, 1.0, 0.0]],
        ..Info::PLAIN
    };

    const COMMON: bool = false;

    fn with_parameters(_: &[f64]) -> Self {
        Icosahedral
    }

    fn coverage(self) -> Coverage {
        Coverage::Sphere
    }

    fn density_range(self) -> (f64, f64) {
        let [x, y, z] = flat(1.0 / 3.0, 1.0 / 3.0, false);
        let s: f64 = x * x + y * y + z * z;
        (SCALE, SCALE / (s * s.sqrt()))
    }

    fn seam(self) -> Seam {
        Seam::Faces
    }

    #[inline(always)]
    fn encode<R: Real>(self, [x, y, z]: [R; 3]) -> Uv<R> {
        let (zero, one) = (R::ZERO, R::ONE);
        let mut best = R::new(SECTORS[0][0]) * x + R::new(SECTORS[0][1]) * z;
        let (mut k, mut sin, mut cos) = (zero, R::new(SECTORS[0][0]), R::new(SECTORS[0][1]));
        for (n, [s, c]) in SECTORS.into_iter().enumerate().skip(1) {
            let along = R::new(s) * x + R::new(c) * z;
            let nearer = along.more(best);
            best = R::select(nearer, along, best);
            k = R::select(nearer, R::new(n as f64), k);
            sin = R::select(nearer, R::new(s), sin);
            cos = R::select(nearer, R::new(c), cos);
        }
        let aside = x * cos - z * sin;
        let mirrored = aside.less(zero);
        let d = [aside.abs(), -y, best];
        let (tip_a, right_a, left_a) = (
            product(TRIANGLES[0][0], d),
            product(TRIANGLES[0][1], d),
            product(TRIANGLES[0][2], d),
        );
        let (left_b, right_b) = (product(TRIANGLES[1][1], d), product(TRIANGLES[1][2], d));
        let (tip_c, left_c) = (product(TRIANGLES[2][0], d), product(TRIANGLES[2][2], d));
        let (left_e, right_e) = (product(TRIANGLES[3][1], d), product(TRIANGLES[3][2], d));
        // Below each of three edges: the tip, the sides and the foot of the sector. What lies on the other side of an edge has
        // the same plane, the other way around.
        let (below_cap, beside, foot) = (tip_a.less(zero), left_b.less(zero), tip_c.less(zero));
        let right_c = -left_b;
        let lower = below_cap & beside;
        let of = |a: R, b: R, c: R, e: R| {
            let upper = R::choose(below_cap, b, a);
            R::choose(lower, R::choose(foot, e, c), upper)
        };
        let tip = R::choose(lower, tip_c.abs(), tip_a.abs());
        let right = of(right_a, right_b, right_c, right_e);
        let left = of(left_a, left_b, left_c, left_e);
        let n = one / (tip + right + left);
        let (p, q) = (
            (R::choose(mirrored, left, right) * n).clamped(0.0, 1.0),
            (R::choose(mirrored, right, left) * n).clamped(0.0, 1.0),
        );
        let second = (lower & foot) | (below_cap & !lower);
        let back = lower & mirrored;
        let k = k - R::choose(back, one, zero);
        let k = R::choose(k.less(zero), R::new(4.0), k);
        Uv {
            u: R::choose(second, one - q, p),
            v: R::choose(second, one - p, q),
            face: k + R::choose(lower, R::new(5.0), zero),
        }
    }

    #[inline(always)]
    fn decode<R: Real>(self, uv: Uv<R>) -> [R; 3] {
        let below = uv.face.more(R::new(4.5));
        let k = R::either(below, || uv.face - R::new(5.0), || uv.face);
        let (sin, cos) = sector(k);
        let [x, up, z] = flat(uv.u, uv.v, below);
        let n = R::ONE / (x * x + up * up + z * z).sqrt();
        let (x, z) = (x * n, z * n);
        [x * cos + z * sin, -(up * n), z * cos - x * sin]
    }

    fn solid_angle(self, rect: Rect) -> f64 {
        let corners = [
            [rect.u0, rect.v0],
            [rect.u1, rect.v0],
            [rect.u1, rect.v1],
            [rect.u0, rect.v1],
        ];
        let lift = |[u, v]: [f64; 2]| {
            let at = |k: usize| (1.0 - u - v) * NORTH[k] + u * UPPER_RIGHT[k] + v * UPPER_LEFT[k];
            [at(0), at(1), at(2)]
        };
        let first = solid_angle::clip(&corners, |[u, v]| 1.0 - u - v);
        let second = solid_angle::clip(&corners, |[u, v]| u + v - 1.0);
        // The triangles of a face are mirror images in its diagonal.
        first.solid_angle(lift) + second.solid_angle(|[u, v]| lift([1.0 - v, 1.0 - u]))
    }

    #[inline(always)]
    fn density<R: Real>(self, uv: Uv<R>) -> R {
        let [x, y, z] = flat(uv.u, uv.v, R::truth(false));
        let s = x * x + y * y + z * z;
        R::new(SCALE) / (s * s.sqrt())
    }
}
