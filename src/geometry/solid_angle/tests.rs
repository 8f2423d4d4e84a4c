//! Totals, subdivision, symmetry and brute force, for every map alike.

use super::gnomonic::gnomonic_polygon;
use super::*;
use std::f64::consts::PI;

/// Name, function, solid angle of the whole image.
type Map = (&'static str, fn(Rect) -> f64, f64);

const MAPS: [Map; 10] = [
    ("latlong", latlong, 4.0 * PI),
    ("sphere", |r| 16.0 * disk_area(r), 4.0 * PI),
    ("matcap", matcap, 2.0 * PI),
    ("angular", |r| angular(r, PI), 4.0 * PI),
    ("angular 180", |r| angular(r, PI / 2.0), 2.0 * PI),
    ("paraboloid", paraboloid, 2.0 * PI),
    ("equal area", |r| azimuthal(r, |_| 16.0, |_| 2.0), 4.0 * PI),
    ("cube", cube, 2.0 * PI / 3.0),
    ("octahedral", octahedral, 4.0 * PI),
    ("hemioctahedral", hemioctahedral, 2.0 * PI),
];

fn s(u: f64, v: f64) -> f64 {
    let (p, q) = (2.0 * u - 1.0, 2.0 * v - 1.0);
    p * p + q * q
}

/// θ = m r.
fn angular(r: Rect, m: f64) -> f64 {
    let sinc = |x: f64| if x < 1e-9 { 1.0 } else { x.sin() / x };
    let density = |s: f64| 4.0 * m * m * sinc(m * s.sqrt());
    azimuthal(r, density, |s| {
        0.5 * m * m * sinc(0.5 * m * s.sqrt()).powi(2)
    })
}

fn paraboloid(r: Rect) -> f64 {
    azimuthal(r, |s| 16.0 / ((1.0 + s) * (1.0 + s)), |s| 2.0 / (1.0 + s))
}

fn rect(u0: f64, u1: f64, v0: f64, v1: f64) -> Rect {
    Rect { u0, u1, v0, v1 }
}

fn texel(n: usize, i: usize, j: usize) -> Rect {
    let at = |i: usize| i as f64 / n as f64;
    rect(at(i), at(i + 1), at(j), at(j + 1))
}

/// Uniform in [0, 1), from a linear congruence.
struct Random(u64);

impl Random {
    fn next(&mut self) -> f64 {
        self.0 = self
            .0
            .wrapping_mul(6364136223846793005)
            .wrapping_add(1442695040888963407);
        (self.0 >> 11) as f64 / (1u64 << 53) as f64
    }

    /// A texel of an n × n grid, half of the time one at the rim of the disk.
    fn texel(&mut self, n: usize) -> Rect {
        let (mut u, mut v) = (self.next(), self.next());
        if self.next() < 0.5 {
            let (sin, cos) = (2.0 * PI * u).sin_cos();
            let radius = 0.5 + (v - 0.5) * 6.0 / n as f64;
            (u, v) = (0.5 + radius.min(0.5) * cos, 0.5 + radius.min(0.5) * sin);
        }
        let at = |x: f64| ((x * n as f64) as usize).min(n - 1);
        texel(n, at(u), at(v))
    }
}

fn close(a: f64, b: f64, tolerance: f64) -> bool {
    (a - b).abs() <= tolerance
}

/// The densities, for brute force. NaN outside of the disk.
fn density(name: &str, u: f64, v: f64) -> f64 {
    let (p, q) = ((2.0 * u - 1.0).abs(), (2.0 * v - 1.0).abs());
    let s = p * p + q * q;
    let norm = |x: f64, y: f64, z: f64| (x * x + y * y + z * z).sqrt();
    let disk = |value: f64| if s <= 1.0 { value } else { f64::NAN };
    match name {
        "latlong" => 2.0 * PI * PI * (PI * v).sin(),
        "sphere" | "equal area" => disk(16.0),
        "matcap" => disk(4.0 / (1.0 - s).sqrt()),
        "angular" => disk(4.0 * PI * (PI * s.sqrt()).sin() / s.sqrt()),
        "angular 180" => disk(2.0 * PI * (0.5 * PI * s.sqrt()).sin() / s.sqrt()),
        "paraboloid" => disk(16.0 / ((1.0 + s) * (1.0 + s))),
        "cube" => 4.0 / norm(p, q, 1.0).powi(3),
        "octahedral" if p + q > 1.0 => 4.0 / norm(1.0 - p, 1.0 - q, 1.0 - p - q).powi(3),
        "octahedral" => 4.0 / norm(p, q, 1.0 - p - q).powi(3),
        _ => 2.0 / norm(0.5 * (p + q), 0.5 * (p - q), 1.0 - p.max(q)).powi(3),
    }
}

#[test]
fn totals() {
    for (name, f, total) in MAPS {
        for n in [1, 2, 3, 4, 5, 7, 8, 16, 33, 64, 127, 256] {
            let row = |j| (0..n).map(|i| f(texel(n, i, j))).sum::<f64>();
            let sum = (0..n).map(row).sum::<f64>();
            assert!(
                close(sum / total, 1.0, 4e-15),
                "{name} {n}: {:e}",
                sum / total - 1.0
            );
        }
    }
}

#[test]
fn whole_disk_to_rounding() {
    let all = rect(0.0, 1.0, 0.0, 1.0);
    assert_eq!(azimuthal(all, |_| f64::NAN, |_| 1.7), 2.0 * PI * 1.7);
    assert_eq!(matcap(all), 2.0 * PI);
    assert_eq!(latlong(all), 4.0 * PI);
    assert_eq!(octahedral(all), 4.0 * PI);
}

/// A shift of the rim by a rounding error matters where the rim cuts the texel, most for MatCap.
#[test]
fn a_texel_is_the_sum_of_its_quarters() {
    let mut random = Random(1);
    for n in [2, 7, 33, 256, 1000, 8191, 8192] {
        for _ in 0..2000 {
            let r = random.texel(n);
            for (name, f, _) in MAPS {
                let (whole, parts) = (f(r), r.quarters().map(f).iter().sum::<f64>());
                let tolerance = 1e-12 * whole + 1e-11 * r.du() * r.dv();
                assert!(
                    whole >= 0.0 && close(whole, parts, tolerance),
                    "{name} {r:?}"
                );
            }
        }
    }
}

#[test]
fn any_rectangle_is_the_sum_of_its_quarters() {
    let mut random = Random(2);
    for _ in 0..20000 {
        // Sides over six decades, of any aspect ratio.
        let mut side = || {
            let (x, length) = (random.next(), 10f64.powf(-6.0 * random.next()));
            (x * (1.0 - length), x * (1.0 - length) + length)
        };
        let ((u0, u1), (v0, v1)) = (side(), side());
        let r = rect(u0, u1.min(1.0), v0, v1.min(1.0));
        for (name, f, _) in MAPS {
            let (whole, parts) = (f(r), r.quarters().map(f).iter().sum::<f64>());
            let tolerance = 1e-12 * whole + 1e-15 * r.du().min(r.dv());
            assert!(
                whole >= 0.0 && close(whole, parts, tolerance),
                "{name} {r:?} {whole} {parts}"
            );
        }
    }
}

#[test]
fn symmetry() {
    let mut random = Random(3);
    for n in [5, 64, 8192] {
        for _ in 0..1000 {
            let r = random.texel(n);
            let mirrored = Rect {
                u0: 1.0 - r.u1,
                u1: 1.0 - r.u0,
                ..r
            };
            let upside_down = Rect {
                v0: 1.0 - r.v1,
                v1: 1.0 - r.v0,
                ..r
            };
            let transposed = Rect {
                u0: r.v0,
                u1: r.v1,
                v0: r.u0,
                v1: r.u1,
            };
            for (name, f, _) in MAPS {
                let value = f(r);
                let same = |other| close(f(other), value, 1e-11 * (value + r.du() * r.dv()));
                assert!(same(mirrored) && same(upside_down), "{name} {r:?}");
                assert!(name == "latlong" || same(transposed), "{name} {r:?}");
            }
        }
    }
}

#[test]
fn brute_force() {
    let mut random = Random(4);
    for n in [4, 9, 30, 300, 8192] {
        for _ in 0..100 {
            let r = random.texel(n);
            for (name, f, _) in MAPS {
                let density = |u, v| density(name, u, v);
                let (value, brute) = (f(r), quadrature(r, &density));
                let corners = [(r.u0, r.v0), (r.u1, r.v0), (r.u1, r.v1), (r.u0, r.v1)];
                let cut = corners.iter().any(|&(u, v)| !density(u, v).is_finite());
                // Creases and, at the rim, jumps; for MatCap, a pole.
                let rim = if name == "matcap" { 0.15 } else { 0.01 };
                let tolerance = if cut {
                    rim * value.max(r.du() * r.dv())
                } else {
                    1e-5 * value
                };
                assert!(
                    close(value, brute, tolerance),
                    "{name} {r:?} {value} {brute}"
                );
            }
        }
    }
}

#[test]
fn integrals_of_every_length() {
    // Singular a tenth of the unit interval beside the middle of each part.
    for length in [1.0 / 1600.0, 1.0 / 256.0, 1.0 / 64.0, 0.05, 0.3, 1.0] {
        let (from, to) = (-0.5 * length, 0.5 * length);
        let value = integral(from, to, |x| 1.0 / (x * x + 0.01));
        let want = 20.0 * f64::atan(10.0 * to);
        assert!(close(value, want, 1e-13 * want), "{length}");
    }
}

#[test]
fn integrals_that_are_halved_where_they_are_steep() {
    for steep in [1.0_f64, 0.1, 0.03, 0.01] {
        let value = halved(-0.4, 0.6, &|x| 1.0 / (x * x + steep * steep));
        let want = ((0.4 / steep).atan() + (0.6 / steep).atan()) / steep;
        assert!(close(value, want, 1e-13 * want), "{steep} {value} {want}");
        let value = halved(0.0, 1.0, &|x| (x + 0.1 * steep).sqrt());
        let want = 2.0 / 3.0 * ((1.0 + 0.1 * steep).powf(1.5) - (0.1 * steep).powf(1.5));
        // The last root lies a 15th of the shortest part away: 16 points leave 3e-13.
        assert!(close(value, want, 1e-12 * want), "{steep} {value} {want}");
    }
    // Nothing is left: rounding is not halved, which would have taken a thousand places.
    let places = std::cell::Cell::new(0);
    let value = halved(0.0, 1.0, &|x| {
        places.set(places.get() + 1);
        (std::f64::consts::TAU * x).sin()
    });
    assert!(value.abs() < 1e-15 && places.get() < 100);
}

#[test]
fn smooth_quadrature() {
    let mut random = Random(5);
    for n in [1, 2, 3, 5, 8, 64, 1000, 8192] {
        for _ in 0..100 {
            let r = random.texel(n);
            let value = quadrature(r, &|u, v| density("cube", u, v));
            assert!(
                close(value, cube(r), 1e-10 * value),
                "{r:?} {:e}",
                value / cube(r) - 1.0
            );
        }
    }
    assert_eq!(quadrature(rect(0.2, 0.6, 0.1, 0.9), &|_, _| f64::NAN), 0.0);
    assert_eq!(quadrature(rect(0.2, 0.2, 0.1, 0.9), &|_, _| 1.0), 0.0);
}

#[test]
fn quadrature_of_a_disk() {
    let disk = |u, v| density("sphere", u, v);
    for n in [1, 2, 5, 16] {
        for i in 0..n * n {
            let r = texel(n, i / n, i % n);
            assert!(
                close(
                    quadrature(r, &disk),
                    16.0 * disk_area(r),
                    16e-3 * r.du() * r.dv()
                ),
                "{r:?}"
            );
        }
    }
}

#[test]
fn disk_interior_is_exact() {
    let mut random = Random(6);
    for _ in 0..1000 {
        let r = random.texel(8191);
        let (u, v) = (r.u0.min(1.0 - r.u1), r.v0.min(1.0 - r.v1));
        if s(u, v) < 1.0 {
            assert_eq!(disk_area(r), (r.u1 - r.u0) * (r.v1 - r.v0));
        }
    }
    assert_eq!(disk_area(rect(0.0, 0.1, 0.0, 0.1)), 0.0);
}

#[test]
fn polygons() {
    let octant = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];
    assert!(close(gnomonic_polygon(&octant), 0.5 * PI, 1e-15));
    let mut random = Random(7);
    for _ in 0..1000 {
        let r = random.texel(1 << 10);
        let at = |u: f64, v: f64| [2.0 * u - 1.0, 2.0 * v - 1.0, 1.0];
        let mut face = [
            at(r.u0, r.v0),
            at(r.u1, r.v0),
            at(r.u1, r.v1),
            at(r.u0, r.v1),
        ];
        let value = gnomonic_polygon(&face);
        assert!(close(value, cube(r), 1e-14 * value));
        face.reverse();
        assert!(close(value, gnomonic_polygon(&face), 1e-14 * value));
    }
    assert_eq!(gnomonic_polygon(&octant[..2]), 0.0);
}

#[test]
fn slivers_end() {
    for width in [5e-324, 1e-200, 1e-32, 1e-16, 1e-9] {
        for (name, f, _) in MAPS {
            let total = f(rect(0.0, width, 0.0, 1.0)) + f(rect(0.0, 1.0, 0.0, width));
            assert!(
                (0.0..=100.0 * width).contains(&total),
                "{name} {width} {total}"
            );
        }
    }
}

#[test]
fn empty_rectangles() {
    for (name, f, _) in MAPS {
        for x in [0.0, 0.25, 0.5, 0.8, 1.0] {
            assert_eq!(f(rect(x, x, 0.1, 0.9)), 0.0, "{name}");
            assert_eq!(f(rect(0.3, 0.9, x, x)), 0.0, "{name}");
        }
    }
}

/// Rectangles that the edge of a shape crosses, against closed forms: a disk, and the sinusoidal map's sine.
#[test]
fn outlined_shapes() {
    let disk = |u: f64, v: f64| {
        let (p, q) = (2.0 * u - 1.0, 2.0 * v - 1.0);
        if p * p + q * q <= 1.0 { 1.0 } else { f64::NAN }
    };
    let sine = |u: f64, v: f64| {
        let (p, q) = (2.0 * u - 1.0, 2.0 * v - 1.0);
        if p.abs() <= (0.5 * PI * q).cos() {
            1.0
        } else {
            f64::NAN
        }
    };
    for n in [4, 8, 32] {
        let at = |k: usize| k as f64 / n as f64;
        let (mut round, mut wave) = (0.0, 0.0);
        for j in 0..n {
            for i in 0..n {
                let r = Rect {
                    u0: at(i),
                    u1: at(i + 1),
                    v0: at(j),
                    v1: at(j + 1),
                };
                let (got, want) = (outlined(r, &disk), disk_area(r));
                // The rim turns back inside the texels at its four ends.
                assert!((got - want).abs() < 2e-4 * r.area(), "{r:?}: {got} {want}");
                round += got;
                wave += outlined(r, &sine);
            }
        }
        assert!(
            (round - 0.25 * PI).abs() < 1e-4 / (n * n) as f64,
            "{n}: {round}"
        );
        assert!(
            (wave - 2.0 / PI).abs() < 1e-4 / (n * n) as f64,
            "{n}: {wave}"
        );
    }
}
