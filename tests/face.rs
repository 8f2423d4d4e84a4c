//! What a Rust program is promised: slices of any kind give the same numbers, one point gives those of a slice, types are
//! names, and a wrong length is an error.

use proptest::prelude::*;
use proptest::test_runner::{RngSeed, TestRunner};
use spheremap::geometry::from_angles;
use spheremap::glam::{DVec2, DVec3, Vec2, Vec3};
use spheremap::projections::REGISTRY;
use spheremap::{Error, Map, MapOptions};

/// Every projection in every layout, and once turned.
fn maps() -> Vec<Map> {
    let mut maps = Vec::new();
    for info in REGISTRY {
        for layout in info.layouts {
            let options = MapOptions::new().layout(layout.name);
            maps.push(Map::with(info.name, options).unwrap());
        }
        let plain = Map::new(info.name).unwrap();
        maps.push(plain.turned(from_angles(20.0, -30.0, 40.0)).unwrap());
        maps.push(plain);
    }
    maps.push(Map::new("cube:ffmpeg-c3x2").unwrap());
    maps
}

/// Takes a test over values that are the same in every run.
fn check<S: Strategy>(values: S, test: impl Fn(S::Value) -> Result<(), TestCaseError>) {
    let config = ProptestConfig {
        cases: 300,
        failure_persistence: None,
        rng_seed: RngSeed::Fixed(20261),
        ..ProptestConfig::default()
    };
    if let Err(error) = TestRunner::new(config).run(&values, test) {
        panic!("{error}");
    }
}

/// Components of a direction: of any size, now and then none.
fn component() -> impl Strategy<Value = f64> {
    prop_oneof![
        8 => -1.0..=1.0,
        1 => Just(0.0),
        1 => (-300.0..300.0).prop_map(|e| 10_f64.powf(e)),
        1 => Just(f64::NAN),
        1 => Just(f64::INFINITY),
    ]
}

/// The face and the bits of a place.
fn bits(face: usize, numbers: [f64; 2]) -> (usize, [u64; 2]) {
    (face, numbers.map(f64::to_bits))
}

#[test]
fn one_point_has_the_numbers_of_a_slice() {
    let maps = maps();
    check(prop::array::uniform3(component()), |d| {
        for map in &maps {
            let mut uv = vec![0.0_f64; map.uv_width()];
            map.encode(&d, &mut uv).unwrap();
            let face = if uv.len() > 2 { uv[2] as usize } else { 0 };
            let expected = (!uv[0].is_nan()).then(|| bits(face, [uv[0], uv[1]]));
            let got = map.encode_one(DVec3::from(d));
            let got = got.map(|(face, uv)| bits(face, uv.to_array()));
            prop_assert_eq!(got, expected, "{} {:?}", map.info().name, map.layout());
        }
        Ok(())
    });
    // Places beyond the image and on edges among them.
    let coordinate = || prop_oneof![-0.25..1.25, Just(0.0), Just(1.0), Just(f64::NAN)];
    check((coordinate(), coordinate(), 0_usize..13), |(u, v, face)| {
        for map in &maps {
            let mut d = [[0.0_f64; 3]];
            let place = [u, v, face as f64];
            map.decode(&place[..map.uv_width()], &mut d).unwrap();
            let there = !d[0][0].is_nan() && (face == 0 || map.uv_width() > 2);
            let expected = there.then_some(d[0].map(f64::to_bits));
            let got = map.decode_one(face, DVec2::new(u, v));
            let got = got.map(|d| d.to_array().map(f64::to_bits));
            prop_assert_eq!(got, expected, "{} {:?}", map.info().name, map.layout());
        }
        Ok(())
    });
}

#[test]
fn every_element_gives_the_same_numbers() {
    // More than a tile of them, and not a multiple of one.
    let arrays: Vec<[f32; 3]> = (0..777)
        .map(|k| {
            [
                (k % 7) as f32 - 3.0,
                (k % 11) as f32 - 5.0,
                (k % 13) as f32 - 6.0,
            ]
        })
        .collect();
    let vectors: Vec<Vec3> = arrays.iter().copied().map(Vec3::from).collect();
    for map in [
        Map::new("octahedral").unwrap(),
        Map::new("mollweide").unwrap(),
    ] {
        let mut numbers = vec![0.0_f32; 2 * arrays.len()];
        map.encode(arrays.as_flattened(), &mut numbers).unwrap();
        let mut pairs = vec![[0.0_f32; 2]; arrays.len()];
        map.encode(&vectors, &mut pairs).unwrap();
        let same = |a: &[f32]| {
            a.iter()
                .map(|x| x.to_bits())
                .eq(numbers.iter().map(|x| x.to_bits()))
        };
        assert!(same(pairs.as_flattened()));
        let mut glam = vec![Vec2::ZERO; arrays.len()];
        map.encode(&arrays, &mut glam).unwrap();
        assert!(same(
            &glam.iter().flat_map(|uv| uv.to_array()).collect::<Vec<_>>()
        ));

        let mut back = vec![[0.0_f32; 3]; arrays.len()];
        map.decode(&numbers, &mut back).unwrap();
        let mut vectors = vec![Vec3::ZERO; arrays.len()];
        map.decode(&glam, &mut vectors).unwrap();
        let bits = |d: [f32; 3]| d.map(f32::to_bits);
        assert!(
            vectors
                .iter()
                .map(|d| bits(d.to_array()))
                .eq(back.iter().copied().map(bits))
        );

        let (mut density, mut of_glam) = (vec![0.0; arrays.len()], vec![0.0; arrays.len()]);
        map.density(&pairs, &mut density).unwrap();
        map.density(&glam, &mut of_glam).unwrap();
        assert!(
            density
                .iter()
                .map(|x| x.to_bits())
                .eq(of_glam.iter().map(|x| x.to_bits()))
        );
    }
}

#[test]
fn a_type_is_a_name() {
    fn same<P: Projection>(of_type: Map) {
        assert_eq!(of_type, Map::new(P::INFO.name).unwrap());
    }
    use spheremap::projections::*;
    macro_rules! all {
        ($($name:ident),+) => {$(same::<$name>(Map::from($name));)+};
    }
    all!(
        Sphere,
        Matcap,
        DualParaboloid,
        Cube,
        Octahedral,
        Hemioctahedral,
        Latlong,
        EqualArea,
        Concentric,
        LambertCylindrical,
        CubeEqualArea,
        Healpix,
        Miller,
        HemiLatlong,
        Mollweide,
        Hammer,
        Sinusoidal,
        Tetrahedral,
        Icosahedral
    );
    same::<CubeEquiangular>(Map::from(CubeEquiangular::default()));
    same::<CubeQuadratic>(Map::from(CubeQuadratic::default()));
    same::<Perspective>(Map::of::<Perspective>(MapOptions::new()).unwrap());
    for info in REGISTRY {
        let options = MapOptions::new();
        assert_eq!(Map::with(info.name, options), info.name.parse());
    }
}

#[test]
fn wrong_lengths_are_errors() {
    let cube = Map::new("cube").unwrap();
    let directions = [[0.0_f64, 0.0, 1.0]; 4];
    let length = |expected, got| move |error: &Error| matches!(*error, Error::Length { expected: e, got: g, .. } if (e, g) == (expected, got));
    let fails = |result: Result<(), Error>, is: &dyn Fn(&Error) -> bool| {
        let error = result.unwrap_err();
        assert!(is(&error), "{error}");
    };
    let (mut one, mut two, mut three, mut six) =
        ([0.0; 1], [[0.0; 2]; 4], [[0.0; 3]; 5], [[0.0; 6]; 3]);

    // Two numbers for a cube's three wrote nothing once.
    fails(cube.encode(&directions[..1], &mut two[..1]), &|e| {
        matches!(
            e,
            Error::Width {
                expected: 3,
                got: 2,
                ..
            }
        )
    });
    fails(cube.encode(&directions, &mut three), &length(12, 15));
    fails(cube.encode(&[0.0, 1.0], &mut three), &|e| {
        matches!(e, Error::Multiple { of: 3, got: 2, .. })
    });
    fails(cube.encode(&[[0.0, 1.0]; 3], &mut three[..2]), &|e| {
        matches!(
            e,
            Error::Width {
                expected: 3,
                got: 2,
                ..
            }
        )
    });
    fails(cube.decode(&directions, &mut three), &length(12, 15));
    fails(cube.decode(&two, &mut three[..4]), &|e| {
        matches!(
            e,
            Error::Width {
                expected: 3,
                got: 2,
                ..
            }
        )
    });
    fails(cube.jacobian(&directions, &mut six), &length(24, 18));
    fails(cube.jacobian(&directions, &mut three[..4]), &|e| {
        matches!(
            e,
            Error::Width {
                expected: 6,
                got: 3,
                ..
            }
        )
    });
    fails(cube.density(&directions, &mut one), &length(4, 1));
    fails(cube.valid(&directions, &mut [false; 5]), &length(4, 5));
    fails(cube.covers(&directions, &mut [false; 3]), &length(4, 3));
    // Nothing in, nothing out.
    assert_eq!(cube.encode::<f32, f32>(&[], &mut []), Ok(()));
}
