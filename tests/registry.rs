//! What every projection promises, over the whole registry, its layouts and both float types.

use half::f16;
use proptest::collection::vec;
use proptest::prelude::*;
use proptest::sample::{Index, select};
use proptest::test_runner::{RngSeed, TestRunner};
use spheremap::geometry::{Rect, from_angles};
use spheremap::glam::DVec3;
use spheremap::image::{ImageView, Texel, directions, shape_of_size, solid_angles};
use spheremap::projections::{Coverage, Info, Outline, REGISTRY};
use spheremap::resample::{Filter, Options, convert};
use spheremap::{Element, Error, Grid, Map, MapOptions, Scalar, simd};
use std::fmt::Debug;
use std::hash::{DefaultHasher, Hash, Hasher};

type Outcome = Result<(), TestCaseError>;

/// Takes a test over values that are the same in every run.
fn check<S: Strategy>(cases: u32, values: S, test: impl Fn(S::Value) -> Outcome) {
    let config = ProptestConfig {
        cases,
        failure_persistence: None,
        rng_seed: RngSeed::Fixed(20260),
        max_global_rejects: 100 * cases,
        ..ProptestConfig::default()
    };
    if let Err(error) = TestRunner::new(config).run(&values, test) {
        panic!("{error}");
    }
}

fn describe(map: &Map) -> String {
    let layout = map.layout().unwrap_or("");
    format!("{} {layout} {:?}", map.info().name, map.parameters())
}

/// Every projection in every layout, with its default parameters and with some others.
fn maps() -> Vec<Map> {
    maps_on(Grid::Centers)
}

fn maps_on(grid: Grid) -> Vec<Map> {
    let mut maps = Vec::new();
    // A calibration's numbers are no shares of a range: tests/map/test_cameras.py has lenses as they are.
    let usual = |info: &&Info| !info.name.starts_with("camera_");
    for info in REGISTRY.iter().filter(usual) {
        let mut choices = vec![Vec::new()];
        for parameter in info.parameters {
            for share in [0.125, 0.5, 0.75] {
                let value = parameter.above + (parameter.maximum - parameter.above) * share;
                choices.push(vec![(parameter.name, value)]);
            }
        }
        let layouts: Vec<Option<&str>> = match info.layouts {
            [] => vec![None],
            layouts => layouts.iter().map(|layout| Some(layout.name)).collect(),
        };
        for parameters in &choices {
            for &layout in &layouts {
                let mut options = MapOptions::new().grid(grid.name()).parameters(parameters);
                options.layout = layout;
                match Map::with(info.name, options) {
                    // Not every value goes with the others' defaults.
                    Err(Error::Together { .. }) => {}
                    map => maps.push(map.unwrap()),
                }
            }
        }
    }
    maps
}

/// A float type, seen as bits.
trait Float: Scalar + Element<Number = Self> + Debug {
    /// Bits of the fraction.
    const FRACTION: u32;
    /// The first and last biased exponent of normal numbers.
    const NORMAL: (u64, u64);
    /// A power of two up to which, and down to which, numbers near 1 can be scaled exactly.
    const SCALE: i32;
    fn of(bits: u64) -> Self;
    fn bits(self) -> u64;
    /// The radians that a round trip may cost.
    fn round_trip(info: &Info) -> f64;
}

impl Float for f32 {
    const FRACTION: u32 = 23;
    const NORMAL: (u64, u64) = (108, 139);
    const SCALE: i32 = 100;
    fn of(bits: u64) -> f32 {
        f32::from_bits(bits as u32)
    }
    fn bits(self) -> u64 {
        self.to_bits().into()
    }
    fn round_trip(info: &Info) -> f64 {
        info.round_trip.0
    }
}

impl Float for f64 {
    const FRACTION: u32 = 52;
    const NORMAL: (u64, u64) = (983, 1046);
    const SCALE: i32 = 900;
    fn of(bits: u64) -> f64 {
        f64::from_bits(bits)
    }
    fn bits(self) -> u64 {
        self.to_bits()
    }
    fn round_trip(info: &Info) -> f64 {
        info.round_trip.1
    }
}

/// The same bits; which NaN a NaN is does not count.
fn same<R: Float>(a: R, b: R) -> bool {
    a.bits() == b.bits() || a.is_nan() && b.is_nan()
}

fn first_difference<R: Float>(a: &[R], b: &[R]) -> Option<(usize, R, R)> {
    let mut pairs = a.iter().zip(b).enumerate();
    pairs.find_map(|(i, (&a, &b))| (!same(a, b)).then_some((i, a, b)))
}

/// The map, turned by these angles.
fn turned_by(map: &Map, turned: Option<[f64; 3]>) -> Map {
    match turned {
        Some([yaw, pitch, roll]) => map.turned(from_angles(yaw, pitch, roll)).unwrap(),
        None => map.clone(),
    }
}

/// What the verbs give for these points.
fn encode<R: Float>(map: &Map, turned: Option<[f64; 3]>, d: &[[R; 3]]) -> Vec<R> {
    let mut uv = vec![R::default(); d.len() * map.uv_width()];
    turned_by(map, turned)
        .encode(d.as_flattened(), &mut uv)
        .unwrap();
    uv
}

fn decode<R: Float>(map: &Map, turned: Option<[f64; 3]>, uv: &[R]) -> Vec<[R; 3]> {
    let mut d = vec![[R::default(); 3]; uv.len() / map.uv_width()];
    turned_by(map, turned)
        .decode(uv, d.as_flattened_mut())
        .unwrap();
    d
}

fn jacobian<R: Float>(map: &Map, turned: Option<[f64; 3]>, uv: &[R]) -> Vec<[R; 6]> {
    let mut j = vec![[R::default(); 6]; uv.len() / map.uv_width()];
    turned_by(map, turned)
        .jacobian(uv, j.as_flattened_mut())
        .unwrap();
    j
}

fn density<R: Float>(map: &Map, uv: &[R]) -> Vec<R> {
    let mut density = vec![R::default(); uv.len() / map.uv_width()];
    map.density(uv, &mut density).unwrap();
    density
}

/// The first numbers of each point: two where faces are joined or one, else three.
fn narrowed<R: Float>(map: &Map, uv: &[[R; 3]]) -> Vec<R> {
    let width = map.uv_width();
    uv.iter().flat_map(|uv| uv[..width].to_vec()).collect()
}

/// The direction's unit vector, in f64. No number is too large or too small for it.
fn unit<R: Float>(d: [R; 3]) -> [f64; 3] {
    let d = d.map(R::to_f64);
    let largest = d.iter().fold(0.0_f64, |m, x| m.max(x.abs()));
    let d = d.map(|x| x / largest);
    let length = d.iter().map(|x| x * x).sum::<f64>().sqrt();
    d.map(|x| x / length)
}

fn angle(a: [f64; 3], b: [f64; 3]) -> f64 {
    let cross = [0, 1, 2].map(|k| {
        let (i, j) = ((k + 1) % 3, (k + 2) % 3);
        a[i] * b[j] - a[j] * b[i]
    });
    let dot: f64 = (0..3).map(|k| a[k] * b[k]).sum();
    cross.iter().map(|x| x * x).sum::<f64>().sqrt().atan2(dot)
}

/// Any bit pattern.
fn any_bits<R: Float>() -> impl Strategy<Value = R> {
    any::<u64>().prop_map(R::of)
}

/// A number that no guard is needed for, over the whole range of such.
fn normal<R: Float>() -> impl Strategy<Value = R> {
    let (first, last) = R::NORMAL;
    (any::<u64>(), first..=last).prop_map(|(bits, exponent)| {
        let field = (1 << (u64::from(size_of::<R>() == 8) * 3 + 8)) - 1;
        R::of(bits & !(field << R::FRACTION) | exponent << R::FRACTION)
    })
}

/// A number that formulas might not expect.
fn odd<R: Float>() -> impl Strategy<Value = R> {
    select(vec![
        0.0,
        -0.0,
        1.0,
        -1.0,
        0.5,
        2.0,
        5.0,
        12.0,
        1e-30,
        -1e-44,
        5e-324,
        1e300,
        f64::INFINITY,
        f64::NEG_INFINITY,
        f64::NAN,
    ])
    .prop_map(R::new)
}

/// Anything at all.
fn number<R: Float>() -> impl Strategy<Value = R> {
    prop_oneof![
        any_bits(),
        normal(),
        odd(),
        (0.0..=1.0).prop_map(R::new),
        (0_u8..12).prop_map(|x| R::new(x.into())),
    ]
}

/// A finite direction that is not zero, of any length, with components of any size.
fn direction<R: Float>() -> impl Strategy<Value = [R; 3]> {
    let component = || {
        let size = prop_oneof![
            4 => Just(1.0),
            2 => (-323.0..0.0).prop_map(|e| 10_f64.powf(e)),
            1 => Just(0.0),
        ];
        (-1.0..=1.0, size).prop_map(|(x, size): (f64, f64)| x * size)
    };
    let scaled = (prop::array::uniform3(component()), -30.0..=30.0)
        .prop_map(|(d, e): ([f64; 3], f64)| d.map(|x| R::new(x * 10_f64.powf(e))));
    prop_oneof![3 => scaled, 1 => prop::array::uniform3(any_bits())].prop_filter(
        "a direction",
        |d: &[R; 3]| {
            d.iter().all(|x| x.to_f64().is_finite()) && d.iter().any(|x| x.to_f64() != 0.0)
        },
    )
}

fn turned() -> impl Strategy<Value = Option<[f64; 3]>> {
    prop::option::of(prop::array::uniform3(-180.0..180.0))
}

/// Whether the map holds a direction; none where rounding decides.
fn covers<R: Float>(map: &Map, stretch: f64, d: [R; 3]) -> Option<bool> {
    let view = (map.axes().matrix() * DVec3::from(d.map(R::to_f64))).to_array();
    match map.coverage() {
        Coverage::Sphere => Some(true),
        Coverage::Hemisphere => {
            // Beside a component so much larger, z is zero where that is scaled to 1.
            let largest = view.iter().fold(0.0_f64, |m, x| m.max(x.abs()));
            let kept = R::new(view[2] / largest / 4.0).to_f64() != 0.0;
            (kept || view[2] >= 0.0).then_some(view[2] >= 0.0)
        }
        Coverage::Cap(half) => {
            let beyond = angle(unit(view), [0.0, 0.0, 1.0]) - half;
            let rounding = 8.0 * R::epsilon() * std::f64::consts::PI * stretch;
            (beyond.abs() > rounding.max(1e-6)).then_some(beyond < 0.0)
        }
        // The Python tests have a reference for each.
        Coverage::Part(_) => None,
    }
}

/// How much more than the angular map, 2π a unit of u, a view moves a direction where it moves it most.
fn stretch(map: &Map) -> f64 {
    if map.info().faces > 1 {
        return 1.0;
    }
    let places: Vec<[f64; 3]> = match map.coverage() {
        // Along a radius from the axis; rims where the derivative has no bound have bounds of their own.
        Coverage::Cap(_) => (0..=1000)
            .map(|k| [0.5 + 0.5 * f64::from(k) / 1000.0, 0.5, 0.0])
            .collect(),
        Coverage::Part(_) => (0..41 * 41)
            .map(|k| [f64::from(k / 41) / 40.0, f64::from(k % 41) / 40.0, 0.0])
            .collect(),
        _ => return 1.0,
    };
    let moved = places.into_iter().flat_map(|uv| {
        let j = jacobian(map, None, &narrowed(map, &[uv]))[0];
        let length = |k: usize| (j[k] * j[k] + j[2 + k] * j[2 + k] + j[4 + k] * j[4 + k]).sqrt();
        [length(0), length(1)]
    });
    moved.filter(|x| x.is_finite()).fold(1.0, |most, x| {
        f64::max(most, x / (2.0 * std::f64::consts::PI))
    })
}

fn round_trip<R: Float>() {
    let maps = maps();
    let stretches: Vec<f64> = maps.iter().map(stretch).collect();
    check(3000, vec(direction::<R>(), 1..=130), |ds| {
        for (map, &stretch) in maps.iter().zip(&stretches) {
            let back = decode(map, None, &encode(map, None, &ds));
            // What lies beyond the edge of a view by no more than 8 ε of its half counts as on the edge.
            let let_out = match map.coverage() {
                Coverage::Cap(_) | Coverage::Part(_) => 8.0 * R::epsilon() * std::f64::consts::PI,
                _ => 0.0,
            };
            let limit = (R::round_trip(map.info()) + let_out) * stretch;
            for (&d, &back) in ds.iter().zip(&back) {
                let covered = !back[0].is_nan();
                let expected = covers(map, stretch, d).unwrap_or(covered);
                prop_assert_eq!(covered, expected, "{} {:?}", describe(map), d);
                if covered {
                    let error = angle(unit(d), unit(back));
                    prop_assert!(
                        error <= limit,
                        "{} {d:?} -> {back:?}: {error:e}",
                        describe(map)
                    );
                }
            }
        }
        Ok(())
    });
}

#[test]
fn directions_come_back_f32() {
    round_trip::<f32>();
}

#[test]
fn directions_come_back_f64() {
    round_trip::<f64>();
}

fn length_does_not_matter<R: Float>() {
    let maps = maps();
    let component = || {
        prop_oneof![
            8 => (any::<bool>(), -16.0..0.0)
                .prop_map(|(up, e): (bool, f64)| e.exp2() * if up { 1.0 } else { -1.0 }),
            1 => Just(0.0),
            1 => Just(-0.0),
        ]
        .prop_map(R::new)
    };
    let ds = vec(prop::array::uniform3(component()), 1..=130);
    check(2000, (ds, -R::SCALE..=R::SCALE), |(ds, power)| {
        let scale = R::new(f64::from(power).exp2());
        let scaled: Vec<[R; 3]> = ds.iter().map(|d| d.map(|x| x * scale)).collect();
        for map in &maps {
            let (a, b) = (encode(map, None, &ds), encode(map, None, &scaled));
            if let Some((i, a, b)) = first_difference(&a, &b) {
                let (what, d) = (describe(map), ds[i / map.uv_width()]);
                prop_assert!(false, "{what} {d:?} by 2^{power}: {a:?} {b:?}");
            }
        }
        Ok(())
    });
}

#[test]
fn a_power_of_two_changes_no_bit() {
    length_does_not_matter::<f32>();
    length_does_not_matter::<f64>();
}

fn a_wild_neighbor_does_not_matter<R: Float>() {
    let maps = maps();
    let wild = select(vec![
        [0.0, 0.0, 1.0],
        [1.0, -0.0, 1.0],
        [0.0, 0.0, 0.0],
        [1.0, 1e-30, 1.0],
        [1e30, 1.0, 1.0],
        [f64::NAN, 1.0, 1.0],
        [1.0, 1.0, f64::INFINITY],
    ])
    .prop_map(|d: [f64; 3]| d.map(R::new));
    let ds = vec(prop::array::uniform3(normal::<R>()), 64);
    let values = (ds, wild, any::<Index>(), turned());
    check(3000, values, |(ds, wild, place, turned)| {
        let normal = |d: [R; 3]| d.iter().all(|x| R::all_normal(x.outside_normal_range()));
        prop_assert!(ds.iter().all(|&d| normal(d)) && !normal(wild));
        let place = place.index(ds.len());
        let mut with = ds.clone();
        with[place] = wild;
        for map in &maps {
            let (a, mut b) = (encode(map, turned, &ds), encode(map, turned, &with));
            let width = map.uv_width();
            let own = place * width..(place + 1) * width;
            b[own.clone()].copy_from_slice(&a[own]);
            if let Some((i, a, b)) = first_difference(&a, &b) {
                let (what, d) = (describe(map), ds[i / width]);
                prop_assert!(false, "{what} {d:?} beside {wild:?}: {a:?} {b:?}");
            }
        }
        Ok(())
    });
}

#[test]
fn guards_change_no_bit() {
    a_wild_neighbor_does_not_matter::<f32>();
    a_wild_neighbor_does_not_matter::<f64>();
}

fn levels<R: Float>() {
    let maps = maps();
    let points = prop_oneof![
        vec(prop::array::uniform3(normal::<R>()), 1..=200),
        vec(prop::array::uniform3((0.0..=1.0).prop_map(R::new)), 1..=200),
        vec(prop::array::uniform3(number::<R>()), 1..=200),
    ];
    check(400, (points, turned()), |(points, turned)| {
        let verbs = |map: &Map| {
            let uv = narrowed(map, &points);
            [
                encode(map, turned, &points),
                decode(map, turned, &uv).into_flattened(),
                jacobian(map, turned, &uv).into_flattened(),
                density(map, &uv),
            ]
        };
        assert!(simd::force_level(Some("baseline")));
        let expected: Vec<_> = maps.iter().map(verbs).collect();
        for level in simd::levels() {
            assert!(simd::force_level(Some(level)));
            for (map, expected) in maps.iter().zip(&expected) {
                for (verb, (a, b)) in expected.iter().zip(verbs(map)).enumerate() {
                    let difference = first_difference(a, &b);
                    prop_assert!(
                        difference.is_none(),
                        "{} {level} {verb}: {difference:?}",
                        describe(map)
                    );
                }
            }
        }
        Ok(())
    });
}

// The level is the process's: tests that run at the same time see it change, which by the claim of
// this one makes no difference to them.
#[test]
fn every_level_gives_the_same_bits() {
    levels::<f32>();
    levels::<f64>();
    simd::force_level(None);
}

fn nan_in_nan_out<R: Float>() {
    let maps = maps();
    let points = prop_oneof![
        vec(prop::array::uniform3(number::<R>()), 1..=130),
        vec(prop::array::uniform3(any_bits::<R>()), 1..=130),
    ];
    check(1500, (points, turned()), |(points, turned)| {
        for map in &maps {
            let what = describe(map);
            let width = map.uv_width();
            for (d, uv) in points
                .iter()
                .zip(encode(map, turned, &points).chunks(width))
            {
                let nan = uv[0].is_nan();
                prop_assert!(uv.iter().all(|x| x.is_nan() == nan), "{what} {d:?}: {uv:?}");
                let valid = d.iter().all(|x| x.to_f64().is_finite());
                let valid = valid && d.iter().any(|x| x.to_f64() != 0.0);
                prop_assert!(valid || nan, "{what} {d:?}: {uv:?}");
            }
            let uv = narrowed(map, &points);
            let mut valid = vec![false; points.len()];
            map.valid(&uv, &mut valid).unwrap();
            let (d, j) = (decode(map, turned, &uv), jacobian(map, turned, &uv));
            let density = density(map, &uv);
            for (i, uv) in uv.chunks(width).enumerate() {
                let nan = !valid[i];
                prop_assert!(nan || !uv.iter().any(|x| x.is_nan()), "{what} {uv:?}");
                let all = d[i].iter().all(|x| x.is_nan() == nan);
                prop_assert!(all, "{what} {uv:?}: {:?}", d[i]);
                // Derivatives may be without bound on a rim, but not without a value elsewhere.
                let all = !nan || j[i].iter().all(|x| x.is_nan()) && density[i].is_nan();
                prop_assert!(all, "{what} {uv:?}: {:?} {:?}", j[i], density[i]);
            }
        }
        Ok(())
    });
}

#[test]
fn invalid_numbers_give_nan_in_every_component() {
    nan_in_nan_out::<f32>();
    nan_in_nan_out::<f64>();
}

fn decoded_directions_are_unit<R: Float>() {
    let maps = maps();
    let inside = (0.0..=1.0, 0.0..=1.0);
    let rim = (0.0..=1.0).prop_map(|turns: f64| {
        let (sin, cos) = (2.0 * std::f64::consts::PI * turns).sin_cos();
        (0.5 + 0.5 * cos, 0.5 + 0.5 * sin)
    });
    let edge = select(vec![0.0, 0.25, 1.0 / 3.0, 0.5, 0.75, 1.0]);
    let place =
        prop_oneof![4 => inside, 2 => rim, 1 => (edge.clone(), 0.0..=1.0), 1 => (0.0..=1.0, edge)];
    let points = vec((place, 0_u8..12), 1..=130);
    check(2000, points, |points| {
        let points: Vec<[R; 3]> = points
            .iter()
            .map(|&((u, v), face)| [u, v, face.into()].map(R::new))
            .collect();
        for map in &maps {
            let uv = narrowed(map, &points);
            for (uv, d) in uv.chunks(map.uv_width()).zip(decode(map, None, &uv)) {
                let length = d.iter().map(|x| x.to_f64().powi(2)).sum::<f64>().sqrt();
                let off = (length - 1.0).abs() / R::epsilon();
                // A rim that is let out by 8 eps of the square makes 4 of the length; 1 for rounding.
                prop_assert!(
                    d[0].is_nan() || off <= 5.0,
                    "{} {uv:?}: {off} eps",
                    describe(map)
                );
            }
        }
        Ok(())
    });
}

#[test]
fn decoded_directions_have_length_one() {
    decoded_directions_are_unit::<f32>();
    decoded_directions_are_unit::<f64>();
}

#[test]
fn jacobians_are_central_differences() {
    let maps = maps();
    let value = (0.05..0.95, 0.05..0.95, any::<Index>());
    check(10_000, value, |(a, b, face): (f64, f64, Index)| {
        let (p, q) = (2.0 * a - 1.0, 2.0 * b - 1.0);
        // Faces of an octahedron meet there, in one octahedral map or the other.
        let creases = [p, q, p.abs() - q.abs(), p.abs() + q.abs() - 1.0];
        prop_assume!(creases.iter().all(|x| x.abs() > 1e-4));
        prop_assume!(
            [-1.0, 1.0]
                .iter()
                .all(|side| (2.0 * p - q - side).abs() > 1e-4)
        );
        // The tip of a cone is there in some equal-area maps: derivatives grow toward it.
        prop_assume!(p * p + q * q > 1e-2);
        for map in &maps {
            if map.info().outline == Outline::Disk && p * p + q * q > 0.81 {
                continue;
            }
            let face_layout = map.face_layout();
            let face = face.index(face_layout.faces);
            let place = &face_layout.places[face];
            let (columns, rows) = (face_layout.columns as f64, face_layout.rows as f64);
            let uv = if face_layout.is_atlas {
                let (column, row) = (place.column as f64, place.row as f64);
                [(column + a) / columns, (row + b) / rows, 0.0]
            } else {
                [a, b, face as f64]
            };
            let h = 1e-6;
            let moved = |axis: usize, by: f64| {
                let mut uv = uv;
                uv[axis] += by;
                uv
            };
            let around = [moved(0, -h), moved(0, h), moved(1, -h), moved(1, h)];
            let [west, east, north, south] =
                around.map(|uv| decode(map, None, &narrowed(map, &[uv]))[0]);
            if map.info().outline == Outline::Shape
                && [west, east, north, south].iter().any(|d| d[0].is_nan())
            {
                continue;
            }
            let j = jacobian(map, None, &narrowed(map, &[uv]))[0];
            let scale = j.iter().fold(1.0_f64, |m, x| m.max(x.abs()));
            for k in 0..3 {
                let steps = [around[1][0] - around[0][0], around[3][1] - around[2][1]];
                let expected = [
                    (east[k] - west[k]) / steps[0],
                    (south[k] - north[k]) / steps[1],
                ];
                for axis in 0..2 {
                    let error = (j[2 * k + axis] - expected[axis]).abs() / scale;
                    prop_assert!(
                        error < 2e-8,
                        "{} {uv:?}: {j:?}, {k} {axis} {expected:?} {error:e}",
                        describe(map)
                    );
                }
            }
        }
        Ok(())
    });
}

/// A shape for a map, of sides up to the larger of these.
fn shape(map: &Map, height: usize, width: usize) -> Vec<usize> {
    if map.face_layout().faces == 1 {
        vec![height, width]
    } else {
        shape_of_size(map, height)
    }
}

/// Of a grid of places the part that is valid is what the projection says, to the grid's own error: a cell in
/// each row and column that the rim crosses.
#[test]
fn used_parts_are_the_areas_of_outlines() {
    const N: usize = 256;
    for map in maps() {
        let faces = map.faces();
        let mut uv = Vec::new();
        for k in 0..faces * N * N {
            uv.push(((k % N) as f64 + 0.5) / N as f64);
            uv.push(((k / N % N) as f64 + 0.5) / N as f64);
            if map.uv_width() == 3 {
                uv.push((k / (N * N)) as f64);
            }
        }
        let mut valid = vec![false; faces * N * N];
        map.valid(&uv, &mut valid).unwrap();
        let counted = valid.iter().filter(|valid| **valid).count() as f64 / valid.len() as f64;
        assert!(
            (counted - map.used_part()).abs() < 4.0 / N as f64,
            "{}: {counted} is not {}",
            describe(&map),
            map.used_part()
        );
    }
}

#[test]
fn solid_angles_sum_to_the_coverage() {
    let maps = Grid::ALL.map(maps_on);
    check(40, (1_usize..=40, 1_usize..=40), |(height, width)| {
        for map in maps.iter().flatten() {
            // A grid with texels on the edges needs two of them.
            let least = if map.grid() == Grid::Centers { 1 } else { 2 };
            let shape = shape(map, height.max(least), width.max(least));
            let mut angles = vec![0.0; shape.iter().product()];
            solid_angles(map, &shape, &mut angles).unwrap();
            let whole = map.coverage().solid_angle();
            let off = (angles.iter().sum::<f64>() - whole).abs() / whole;
            // Their densities are integrated numerically: to 1e-10 over square texels, which the Python tests hold,
            // and to 2e-6 over ones of 40:1.
            let bound = match map.info().name {
                "orthographic" | "stereographic" => 2e-6,
                "kannala_brandt" | "unified" | "double_sphere" => 2e-6,
                name if name.starts_with("camera_") => 2e-6,
                _ => 1e-12,
            };
            prop_assert!(
                off < bound,
                "{} {:?} {shape:?}: {off:e}",
                describe(map),
                map.grid()
            );
        }
        Ok(())
    });
}

/// A texel type of which the tests make images.
trait Pixel: Texel + PartialEq + Debug {
    fn of(bits: u64) -> Self;
    fn bits(self) -> u64;
    fn value(self) -> f64;
}

macro_rules! pixel {
    ($t:ty, $bits:ty, $of:expr, $to:expr) => {
        impl Pixel for $t {
            fn of(bits: u64) -> $t {
                $of(bits as $bits)
            }
            fn bits(self) -> u64 {
                let bits: $bits = $to(self);
                bits.into()
            }
            fn value(self) -> f64 {
                self.into()
            }
        }
    };
}
pixel!(u8, u8, |x| x, |x| x);
pixel!(u16, u16, |x| x, |x| x);
pixel!(f16, u16, f16::from_bits, f16::to_bits);
pixel!(f32, u32, f32::from_bits, f32::to_bits);
pixel!(f64, u64, f64::from_bits, f64::to_bits);

fn constant_images<T: Pixel>() {
    let maps = maps();
    let map = || select(maps.clone());
    let side = || 1_usize..=12;
    let sides = (side(), side(), side(), side());
    // Zero is +0: what a filter adds to -0 makes it +0.
    let constant = any::<u64>().prop_map(T::of).prop_filter("finite", |x| {
        let value = x.value();
        value.is_finite() && (value != 0.0 || x.bits() == 0)
    });
    let filter = select(vec![Filter::Nearest, Filter::Bilinear]);
    let values = (
        map(),
        map(),
        sides,
        turned(),
        constant,
        filter,
        any::<bool>(),
    );
    check(
        5000,
        values,
        |(from, to, sides, turned, constant, filter, antialias)| {
            let rotation = turned.map(|[yaw, pitch, roll]| from_angles(yaw, pitch, roll));
            let (source_shape, shape) =
                (shape(&from, sides.0, sides.1), shape(&to, sides.2, sides.3));
            let centers = |map: &Map, shape: &[usize]| {
                let mut d = vec![[0.0_f64; 3]; shape.iter().product()];
                directions(map, shape, None, d.as_flattened_mut()).unwrap();
                d
            };
            // What lies outside of the valid image must not show.
            let garbage = if T::NOTHING.is_nan() {
                T::from_f64(T::NOTHING)
            } else {
                T::of(!constant.bits())
            };
            let fill = T::of(constant.bits() ^ 1);
            let texels: Vec<T> = centers(&from, &source_shape)
                .iter()
                .map(|d| if d[0].is_nan() { garbage } else { constant })
                .collect();
            let image = ImageView::new(&from, &source_shape, 1, &texels).unwrap();
            let options = Options::new()
                .rotation(rotation)
                .filter(filter)
                .antialias(antialias)
                .fill(fill.value());
            let mut out = vec![garbage; shape.iter().product()];
            convert(&image, &to, &shape, &options, &mut out).unwrap();
            for (out, d) in out.iter().zip(centers(&to, &shape)) {
                let what = || {
                    format!(
                        "{} {source_shape:?} -> {} {shape:?}",
                        describe(&from),
                        describe(&to)
                    )
                };
                let seen = !d[0].is_nan();
                let filled =
                    out.bits() == fill.bits() && !(seen && from.coverage() == Coverage::Sphere);
                let kept = out.bits() == constant.bits() && seen;
                prop_assert!(
                    filled || kept,
                    "{}: {constant:?} became {out:?} at {d:?}",
                    what()
                );
            }
            Ok(())
        },
    );
}

#[test]
fn a_constant_image_stays_constant() {
    constant_images::<u8>();
    constant_images::<u16>();
    constant_images::<f16>();
    constant_images::<f32>();
    constant_images::<f64>();
}

#[test]
fn sides_that_are_no_numbers_see_nothing() {
    for map in maps() {
        for wrong in [f64::NAN, f64::INFINITY, f64::NEG_INFINITY] {
            let right = Rect {
                u1: wrong,
                ..Rect::WHOLE
            };
            let upper = Rect {
                v0: wrong,
                ..Rect::WHOLE
            };
            for rect in [right, upper] {
                assert!(map.solid_angle(rect).is_nan(), "{}", describe(&map));
            }
        }
    }
}

#[test]
fn a_zero_of_either_sign_is_one_map() {
    let with = |cx: f64| {
        let given = [("cx", cx)];
        Map::with("perspective", MapOptions::new().parameters(&given)).map(|map| {
            let mut hasher = DefaultHasher::new();
            map.hash(&mut hasher);
            (hasher.finish(), map.parameters().to_vec(), map)
        })
    };
    assert_eq!(with(-0.0), with(0.0));
}
