//! HEALPix: twelve faces of equal area, curved squares on the sphere.
//!
//! Source: Górski et al., "HEALPix", Astrophysical Journal 622 (2005). z points to the north pole and x to
//! longitude 0, east is toward y. Faces 0 to 3 touch the north pole, 4 to 7 lie around the equator, 8 to 11 touch the south
//! pole. u runs north-east and v north-west from a face's southern corner, so that texel (i, j) of an
//! n × n face f is the pixel (f, x = i, y = j) of nside n: f n² plus the bits of i and j in turn in nested
//! order. Seen from inside, the picture is turned by 135° and not mirrored.
//!
//! In quarter turns a of longitude, within a quadrant, and with s = √(3 (1 - |z|)) in the caps |z| > ⅔:
//! a cap's corner of the face lies at its pole and the distances from the two sides that meet there are
//! a s and (1 - a) s; in the belt u and v are ½ + a ± ¾ z. The 1 - |z| is (x² + y²)/(L (L + |z|)), which does not cancel.
//!
//! Domain: all directions. At a pole four faces meet: the answer is the one of longitude 0, whatever the signs of
//! zeros. The density is π/3 everywhere. The seams are exact: texels on both sides of an edge are opposite each other,
//! and at eight vertices only three faces meet.

use crate::geometry::solid_angle::Rect;
use crate::number::real::Real;
use crate::projections::faces::{Cells, LayoutSpec};
use crate::projections::projection::{Coverage, Edge, Info, Projection, Seam, Uv};
use std::f64::consts::PI;

/// The twelve faces.
#[derive(Clone, Copy, Debug)]
pub struct Healpix;

/// √(2/3): the sine of the angle from a pole over the distance to it.
const SQRT_2_3: f64 = 0.816_496_580_927_726;

/// Where caps begin: [`Info::creases`]. On the four faces of the belt nothing bends there.
const CAPS: [[f64; 3]; 1] = [[1.0, 1.0, 0.0]];

const LAYOUTS: &[LayoutSpec] = &[
    LayoutSpec {
        name: "faces",
        cells: Cells::Apart,
    },
    LayoutSpec {
        name: "4x3",
        cells: Cells::Block(4, 3),
    },
];

impl Projection for Healpix {
    const INFO: Info = Info {
        name: "healpix",
        title: "HEALPix faces",
        source: "Gorski et al., HEALPix, Astrophysical Journal 622 (2005)",
        summary: "Twelve equal-area faces whose texels are the nested pixels; maps of the whole sky.",
        singular: "The poles, where four faces meet: the face of longitude 0.",
        axes: "+x +y +z",
        faces: 12,
        layouts: LAYOUTS,
        creases: &CAPS,
        equal_area: true,
        ..Info::PLAIN
    };

    const COMMON: bool = false;

    fn with_parameters(_: &[f64]) -> Self {
        Healpix
    }

    fn coverage(self) -> Coverage {
        Coverage::Sphere
    }

    fn density_range(self) -> (f64, f64) {
        (PI / 3.0, PI / 3.0)
    }

    fn seam(self) -> Seam {
        Seam::Faces
    }

    #[inline(always)]
    fn encode<R: Real>(self, [x, y, z]: [R; 3]) -> Uv<R> {
        let (zero, half, one, two) = (R::ZERO, R::HALF, R::ONE, R::TWO);
        let (three, four) = (R::new(3.0), R::new(4.0));
        // The quadrant, and the longitude within it in quarter turns.
        let odd = (x.at_most(zero) & y.more(zero)) | (x.at_least(zero) & y.less(zero));
        let back = y.less(zero) | (y.equals(zero) & x.less(zero));
        let turn = R::choose(odd, one, zero) + R::choose(back, two, zero);
        let (ax, ay) = (x.abs(), y.abs());
        let along = two * R::half_turns(R::choose(odd, ax, ay), R::choose(odd, ay, ax));

        let (xf, yf) = (ax.squarable(), ay.squarable());
        let squared = xf * xf + yf * yf;
        let length = (squared + z * z).sqrt();
        let cap = (three * z.abs()).more(two * length);
        let numerator = R::choose(cap, three * squared, R::new(0.75) * z);
        let denominator = length * R::choose(cap, length + z.abs(), one);
        let quotient = numerator / denominator;
        let radius = quotient.abs().sqrt();

        let (falling, rising) = (along * radius, (one - along) * radius);
        let south = z.less(zero);
        let cap_u = R::choose(south, falling, one - rising);
        let cap_v = R::choose(south, rising, one - falling);
        let cap_face = turn + R::choose(south, R::new(8.0), zero);

        let (falling, rising) = (half + along - quotient, half + along + quotient);
        let (f, r) = (falling.at_least(one), rising.at_least(one));
        let belt_u = rising - R::choose(r, one, zero);
        let belt_v = one - (falling - R::choose(f, one, zero));
        let next = turn + R::choose(f, one, zero);
        let equator = four + R::choose(next.equals(four), zero, next);
        let beside = turn + R::choose(f, R::new(8.0), zero);
        let belt_face = R::choose(!(f ^ r), equator, beside);

        let u = R::choose(cap, cap_u, belt_u);
        let v = R::choose(cap, cap_v, belt_v);
        Uv {
            u: u.clamped(0.0, 1.0),
            v: v.clamped(0.0, 1.0),
            face: R::choose(cap, cap_face, belt_face),
        }
    }

    #[inline(always)]
    fn decode<R: Real>(self, Uv { u, v, face }: Uv<R>) -> [R; 3] {
        let (zero, one, two) = (R::ZERO, R::ONE, R::TWO);
        let north = face.less(R::new(3.5));
        let south = face.more(R::new(7.5));
        let row = R::choose(north, zero, one) + R::choose(south, one, zero);
        let column = face - R::new(4.0) * row;
        // The longitude of a face's center, from -1 to 1 half turns.
        let middle = R::HALF * column + R::choose(north | south, R::new(0.25), zero);
        let middle = middle - R::choose(middle.more(one), two, zero);

        // How far the pole is: 1 where the cap ends.
        let from_pole = R::choose(south, u + v, (one - u) + (one - v));
        let cap = (north | south) & from_pole.less(one);
        let quarter = R::new(0.25) * (u - v);
        let radius = R::choose(from_pole.vanishes(), one, from_pole);
        let longitude = middle + quarter / R::choose(cap, radius, one);
        let (sin, cos) = R::sin_cos_half_turns(longitude);

        let height = from_pole * from_pole * R::new(1.0 / 3.0);
        let cap_z = (one - height).negated_if(south);
        let cap_sine = from_pole * ((two - height) * R::new(1.0 / 3.0)).sqrt();
        let belt_z = (u + v - row) * R::new(2.0 / 3.0);
        let beyond = (one - belt_z) * (one + belt_z);
        let belt_sine = R::choose(cap, one, beyond).sqrt();
        let sine = R::choose(cap, cap_sine, belt_sine);
        // At the poles, where the tips of four faces meet, the derivatives are those along the middle of the face.
        let pole = cap & from_pole.vanishes();
        let slope = R::new(SQRT_2_3);
        let turn = quarter * R::new(PI);
        let x = (sine * cos).with_slope_of(pole, || (from_pole * cos - turn * sin) * slope);
        let y = (sine * sin).with_slope_of(pole, || (from_pole * sin + turn * cos) * slope);
        [x, y, R::choose(cap, cap_z, belt_z)]
    }

    fn beyond(self, uv: Uv<f64>) -> Uv<f64> {
        let Uv { mut u, mut v, face } = uv;
        let mut face = face as usize;
        // Around a vertex of three faces a place crosses up to three edges.
        for _ in 0..4 {
            let (row, column) = (face / 4, face % 4);
            let (east, west) = ((column + 1) % 4, (column + 3) % 4);
            if u > 1.0 {
                (u, v, face) = match row {
                    0 => (v, 2.0 - u, east),
                    1 => (u - 1.0, v, column),
                    _ => (u - 1.0, v, 4 + east),
                };
            } else if u < 0.0 {
                (u, v, face) = match row {
                    0 => (u + 1.0, v, 4 + column),
                    1 => (u + 1.0, v, 8 + west),
                    _ => (v, -u, 8 + west),
                };
            } else if v > 1.0 {
                (u, v, face) = match row {
                    0 => (2.0 - v, u, west),
                    1 => (u, v - 1.0, west),
                    _ => (u, v - 1.0, 4 + column),
                };
            } else if v < 0.0 {
                (u, v, face) = match row {
                    0 => (u, v + 1.0, 4 + east),
                    1 => (u, v + 1.0, 8 + column),
                    _ => (-v, u, 8 + east),
                };
            } else {
                break;
            }
        }
        Uv {
            u: u.clamp(0.0, 1.0),
            v: v.clamp(0.0, 1.0),
            face: face as f64,
        }
    }

    fn beside(self, _: Edge, along: f64, _: f64) -> f64 {
        along
    }

    fn across(self, edge: Edge, along: f64, inset: f64) -> Uv<f64> {
        self.beyond(edge.place(along, -inset))
    }

    fn solid_angle(self, rect: Rect) -> f64 {
        PI / 3.0 * (rect.u1 - rect.u0) * (rect.v1 - rect.v0)
    }

    #[inline(always)]
    fn density<R: Real>(self, _: Uv<R>) -> R {
        R::new(PI / 3.0)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn beyond_an_edge_lies_the_same_direction() {
        for face in 0..12 {
            for k in 0..=10 {
                let along = 2.0 * f64::from(k) / 10.0 - 1.0;
                for (axis, high) in [(0, false), (0, true), (1, false), (1, true)] {
                    let edge = Edge {
                        face: f64::from(face),
                        axis,
                        high,
                    };
                    let here = Healpix.decode(edge.place(along, 0.0));
                    let there = Healpix.decode(Healpix.beyond(edge.place(along, -1e-12)));
                    for c in 0..3 {
                        assert!((here[c] - there[c]).abs() < 1e-11, "{edge:?} {along}");
                    }
                }
            }
        }
    }

    #[test]
    fn texels_are_pixels() {
        use crate::healpix::{Grid, cell_of_direction};
        for nside in [1, 2, 3, 8] {
            let grid = Grid::new(nside);
            for face in 0..12 {
                for (x, y) in (0..nside).flat_map(|y| (0..nside).map(move |x| (x, y))) {
                    let center = |i: i64| (i as f64 + 0.5) / nside as f64;
                    let d = Healpix.decode(Uv {
                        u: center(x),
                        v: center(y),
                        face: face as f64,
                    });
                    let (cell, _) = cell_of_direction(grid, d);
                    assert_eq!((cell.face, cell.x, cell.y), (face, x, y));
                }
            }
        }
    }
}
