//! Both paths give the same weights, and every source texel keeps its light.

use super::*;
use crate::geometry::solid_angle::Rect;
use crate::image::raster::Raster;
use crate::image::raster::shape_of_size;
use crate::map::Map;
use crate::projections::REGISTRY;
use crate::projections::projection::{Coverage, Outline};
use glam::DMat3;

fn map(name: &str) -> Map {
    Map::new(name).unwrap()
}

fn turn() -> DMat3 {
    crate::geometry::axes::from_angles(33.0, -20.0, 71.0)
}

fn noise(n: usize) -> Vec<f64> {
    let mut state = 7_u64;
    (0..n)
        .map(|_| {
            state = state
                .wrapping_mul(6364136223846793005)
                .wrapping_add(1442695040888963407);
            (state >> 40) as f64 / (1 << 24) as f64
        })
        .collect()
}

/// The converted image, and how many cells went which way.
fn converted(
    path: Path,
    (source, from): (&Map, &[usize]),
    (target, into): (&Map, &[usize]),
    rotation: Option<DMat3>,
) -> (Vec<f64>, [usize; 3]) {
    let texels = |shape: &[usize]| shape.iter().product::<usize>();
    let image = noise(texels(from));
    let mut out = vec![0.0; texels(into)];
    let tally = Tally::default();
    let source = ImageView::new(source, from, 1, &image).unwrap();
    let window = Window::whole(&Raster::new(target, into).unwrap());
    let request = Request {
        image: &source,
        map: target,
        shape: into,
        rotation,
        fill: &[f64::NAN],
        window: &window,
    };
    let of = Of {
        filter: AreaFilter::Area,
        skipna: false,
        whole: false,
    };
    convert_by(path, &tally, request, of, &mut out).unwrap();
    let counts = [&tally.fast, &tally.followed, &tally.general];
    (
        out,
        counts.map(|count| count.load(std::sync::atomic::Ordering::Relaxed)),
    )
}

#[test]
fn both_paths_agree() {
    for (turns, info) in REGISTRY.iter().enumerate() {
        // Each is converted from and to one of another kind, in turns.
        let partner = ["latlong", "cube", "angular"][turns % 3];
        for (k, (a, b)) in [(info.name, partner), (partner, info.name)]
            .iter()
            .enumerate()
        {
            let rotation = (k == 0).then(turn);
            let (source, target) = (map(a), map(b));
            let (from, into) = (shape_of_size(&source, 24), shape_of_size(&target, 10));
            let both = [Path::Fast, Path::General]
                .map(|path| converted(path, (&source, &from), (&target, &into), rotation));
            let [(fast, counts), (general, _)] = both;
            let raster = Raster::new(&target, &into).unwrap();
            for (k, (p, q)) in fast.iter().zip(&general).enumerate() {
                // What is left of a texel outside the rim may be a matter of rounding.
                let near = (p - q).abs() < 2e-6 || (p.is_nan() && q.is_nan());
                assert!(
                    near || raster.has_rim() || source.coverage() != Coverage::Sphere,
                    "{a} {b} {k}: {p} {q} {counts:?}"
                );
            }
            let all: usize = counts.iter().sum();
            // Sources that are disks take the general path more often.
            if [&source, &target]
                .iter()
                .all(|map| map.outline() == Outline::Square)
                && source.coverage() == Coverage::Sphere
            {
                assert!(2 * (counts[0] + counts[1]) > all, "{a} {b}: {counts:?}");
            }
        }
    }
}

#[test]
fn copies_in_another_size_are_those_of_the_general_path() {
    for info in REGISTRY {
        let p = map(info.name);
        for (n, m) in [(24, 8), (20, 13), (9, 20), (70, 2), (80, 30)] {
            let (from, into) = (shape_of_size(&p, n), shape_of_size(&p, m));
            let [(best, counts), (general, _)] = [Path::Best, Path::General]
                .map(|path| converted(path, (&p, &from), (&p, &into), None));
            assert_eq!(counts, [0; 3], "{}", info.name);
            let raster = Raster::new(&p, &into).unwrap();
            for (k, (a, b)) in best.iter().zip(&general).enumerate() {
                // What is left of a texel outside the rim may be a matter of rounding.
                let near = (a - b).abs() < 2e-6 || (a.is_nan() && b.is_nan());
                assert!(
                    near || raster.has_rim(),
                    "{} {n} {m} {k}: {a} {b}",
                    info.name
                );
            }
        }
    }
}

#[test]
fn copies_in_another_size_share_out_whole_texels() {
    for info in REGISTRY {
        let p = map(info.name);
        // Large enough for densities that are polynomials, and texels that are cut.
        let [from, into] = [90, 37].map(|n| {
            let shape = shape_of_size(&p, n);
            Lattice::new(&p, &shape, None).unwrap().refine(1)
        });
        let alike = Alike::new(&from, &into);
        let mut room = Room::default();
        let mut shares = vec![0.0; from.raster.texels()];
        let mut largest = 0.0_f64;
        for face in 0..p.info().faces {
            let high = [into.columns, into.rows];
            alike.cells(&mut room, face, [0, 0], high, &mut |_, found| {
                largest = largest.max(found.iter().map(|(_, size)| size).sum());
                found.iter().for_each(|(at, size)| shares[*at] += size);
            });
        }
        let mut weights = vec![0.0; from.raster.texels()];
        crate::image::weights(&p, &shape_of_size(&p, 90), &mut weights).unwrap();
        for (k, (shared, whole)) in shares.iter().zip(&weights).enumerate() {
            // As exact as a cell's sum has to be.
            let off = (shared - whole).abs();
            assert!(off <= 1e-8 * largest, "{} {k}: {off:e}", info.name);
        }
    }
}

/// The largest relative change of light that a sun of one texel can suffer, wherever it is, and what went which way.
fn worst_sun(a: &str, n: usize, b: &str, m: usize, rotation: Option<DMat3>) -> (f64, [usize; 3]) {
    let (source, target) = (map(a), map(b));
    let (from_shape, into_shape) = (shape_of_size(&source, n), shape_of_size(&target, m));
    let matrix = frame(&source, &target, rotation);
    let into = Lattice::new(&target, &into_shape, Some(matrix)).unwrap();
    let [from, coarse, followed] =
        [(); 3].map(|()| (Lattice::new(&source, &from_shape, None).unwrap()).counted_once());
    let followed = finer(followed, traced::density::FEWEST);
    let (from, into) = refined(from, into);
    let varies = [Density::varies(&from), Density::varies(&into)];
    let mut sweep = Sweep::new([&from, &followed, &coarse], &into, varies, true);
    let mut kept = vec![0.0; from.raster.texels()];
    let parts = into.refined;
    let solid_angle = |raster: &Raster, map: &Map, i: usize, j: usize| {
        let ((u0, u1), (v0, v1)) = (raster.along_u.cell(i), raster.along_v.cell(j));
        map.solid_angle(Rect { u0, u1, v0, v1 })
    };
    let mut weights = Vec::new();
    for face in 0..target.info().faces {
        for j in 0..into.raster.height {
            for i in 0..into.raster.width {
                weights.clear();
                let (low, high) = ([i * parts, j * parts], [(i + 1) * parts, (j + 1) * parts]);
                let mut add =
                    |_: [usize; 2], more: &[(usize, f64)]| weights.extend_from_slice(more);
                sweep.cells(face, low, high, &|_, _, _| (), &mut add);
                let sum: f64 = weights.iter().map(|(_, weight)| weight).sum();
                let size = solid_angle(&into.raster, &target, i, j);
                for (index, weight) in &weights {
                    kept[*index] += weight * size / sum;
                }
            }
        }
    }
    let mut worst = 0.0_f64;
    for face in 0..source.info().faces {
        for j in 0..from.raster.height {
            for i in 0..from.raster.width {
                if from.raster.has_rim() && !from.raster.holds(i as isize, j as isize) {
                    continue;
                }
                // Texels on a rim have their neighbors' shares as well.
                let size = solid_angle(&from.raster, &source, i, j);
                let near = [-2, 2].iter().all(|d| {
                    from.raster.holds(i as isize + d, j as isize)
                        && from.raster.holds(i as isize, j as isize + d)
                });
                if !from.raster.has_rim() || near {
                    let change = kept[from.raster.view(face).index(i, j)] / size - 1.0;
                    worst = worst.max(change.abs());
                }
            }
        }
    }
    let tally = Tally::default();
    sweep.count(&tally);
    let counts = [&tally.fast, &tally.followed, &tally.general];
    (
        worst,
        counts.map(|count| count.load(std::sync::atomic::Ordering::Relaxed)),
    )
}

#[test]
fn no_sun_loses_light() {
    for (a, n, b, m) in [
        ("latlong", 150, "cube", 60),
        ("cube", 70, "latlong", 90),
        ("latlong", 130, "angular", 100),
        ("octahedral", 140, "cube", 66),
        ("latlong", 64, "octahedral", 200),
        ("latlong", 256, "cube", 4),
    ] {
        for rotation in [None, Some(turn())] {
            let (worst, counts) = worst_sun(a, n, b, m, rotation);
            println!(
                "{a} {n} {b} {m} {} {worst:.1e} {counts:?}",
                rotation.is_some()
            );
            assert!(worst < 1e-6, "{a} {b} {} {worst:e}", rotation.is_some());
            assert!(counts[0] + counts[1] > 8 * counts[2], "{a} {b} {counts:?}");
        }
    }
}

#[test]
fn lenses_that_see_some_of_the_sphere_twice_count_it_once() {
    for (a, n, b, m) in [
        ("dual_fisheye(fov=200)", 90, "latlong", 40),
        ("dual_fisheye(fov=190)", 40, "cube", 70),
        ("latlong", 60, "dual_fisheye(fov=220)", 50),
        ("cube", 30, "dual_fisheye(fov=200)", 9),
        ("dual_fisheye(fov=200)", 70, "dual_fisheye(fov=270)", 50),
    ] {
        for rotation in [None, Some(turn())] {
            let (worst, counts) = worst_sun(a, n, b, m, rotation);
            assert!(worst < 1e-6, "{a} {b} {worst:e} {counts:?}");
        }
    }
}

/// Panoramas and cylinders have rows and columns in common, and the general path says the same.
#[test]
fn meridians_and_parallels_agree_with_the_general_path() {
    use crate::geometry::axes::from_angles;
    let names: Vec<&str> = REGISTRY
        .iter()
        .filter(|info| map(info.name).meridians().is_some())
        .map(|info| info.name)
        .collect();
    assert!(names.len() >= 6);
    let turns = [
        None,
        Some(from_angles(90.0, 0.0, 0.0)),
        Some(from_angles(-37.0, 0.0, 0.0)),
        Some(from_angles(11.0, 180.0, 0.0)),
    ];
    for (k, a) in names.iter().enumerate() {
        for (l, b) in names.iter().enumerate() {
            let (source, target) = (map(a), map(b));
            // Larger, smaller and about as large, by turns.
            let (n, m) = [(9, 14), (14, 5), (11, 11)][(k + l) % 3];
            let (from, into) = (shape_of_size(&source, n), shape_of_size(&target, m));
            let rotation = turns[(k + 2 * l) % 4];
            let [best, general] = [Path::Best, Path::General]
                .map(|path| converted(path, (&source, &from), (&target, &into), rotation).0);
            for (k, (p, q)) in best.iter().zip(&general).enumerate() {
                let same = (p - q).abs() < 1e-6 || (p.is_nan() && q.is_nan());
                assert!(same, "{a} {from:?} {b} {into:?} {rotation:?} {k}: {p} {q}");
            }
        }
    }
}

/// A claim of each map that makes it: longitude grows with u alone, and v tells the height.
#[test]
fn columns_are_meridians_where_they_are_said_to_be() {
    for info in REGISTRY {
        let map = map(info.name);
        let Some(edge) = map.meridians() else {
            continue;
        };
        let lattice = Lattice::new(&map, &shape_of_size(&map, 16), None).unwrap();
        for (i, j) in (0..=20).flat_map(|i| (0..=20).map(move |j| (i, j))) {
            let [u, v] = [i, j].map(|k| f64::from(k) / 20.0);
            let ([x, y, z], [_, height, _]) =
                (lattice.decode(0, [u, v]), lattice.decode(0, [0.5, v]));
            assert!((y - height).abs() < 1e-15, "{} {u} {v}", info.name);
            let flat = x.hypot(z);
            let (sin, cos) = (edge * (2.0 * u - 1.0) * std::f64::consts::PI).sin_cos();
            let off = (x - flat * sin).abs().max((z - flat * cos).abs());
            assert!(off < 1e-15, "{} {u} {v}", info.name);
        }
    }
}
