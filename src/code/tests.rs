//! What is recorded is what the kernels compute: the graph is run here, number by number.

use super::*;
use crate::map::MapOptions;
use crate::number::graph::{Binary, Comparison, Logic, Node, Unary};
use crate::projections::REGISTRY;
use crate::projections::projection::{Projection, Visitor};

/// The values of a program's outputs; conditions are 0 and 1.
fn values<T: Width>(program: &Program, style: Style, inputs: &[f64]) -> Vec<f64> {
    let rounded = |x: f64| if style.double { x } else { f64::from(x as f32) };
    let mut numbers: Vec<Vec<f64>> = Vec::with_capacity(program.nodes.len());
    for &node in &program.nodes {
        let of = |id: u32| numbers[id as usize][0];
        let truth = |holds: bool| vec![f64::from(u8::from(holds))];
        let made = match node {
            Node::Input(number) => vec![inputs[usize::from(number)]],
            Node::Constant(bits) => vec![f64::from_bits(bits)],
            Node::Unary(operation, a) => {
                let a = of(a);
                // A root in f64 rounds to that in f32, as do sums, products and quotients.
                vec![rounded(match operation {
                    Unary::Negate => -a,
                    Unary::Absolute => a.abs(),
                    Unary::Root => a.sqrt(),
                    Unary::Floor => a.floor(),
                    Unary::Round => a.round_ties_even(),
                    Unary::PowerOfTwo => a.exp2(),
                    Unary::Exponent => f64::from(((a.to_bits() >> 52) & 0x7ff) as i32 - 1023),
                    Unary::Sine => a.sin(),
                    Unary::Cosine => a.cos(),
                    Unary::Sinh => a.sinh(),
                    Unary::Cosh => a.cosh(),
                })]
            }
            Node::Binary(operation, a, b) => {
                let (a, b) = (of(a), of(b));
                vec![rounded(match operation {
                    Binary::Add => a + b,
                    Binary::Subtract => a - b,
                    Binary::Multiply => a * b,
                    Binary::Divide => a / b,
                    Binary::Minimum => {
                        if a < b {
                            a
                        } else {
                            b
                        }
                    }
                    Binary::Maximum => {
                        if a > b {
                            a
                        } else {
                            b
                        }
                    }
                    Binary::Arctangent => a.atan2(b),
                })]
            }
            Node::Select(condition, a, b) => vec![if of(condition) > 0.0 { of(a) } else { of(b) }],
            Node::Call(helper, a, b) => {
                let (graph, outputs) = trace::body::<T>(helper, style);
                let body = Program {
                    takes: helper_arguments(helper),
                    gives: Gives::Pair,
                    nodes: graph.into_nodes(),
                    outputs,
                };
                values::<T>(&body, style, &[of(a), of(b)])
            }
            Node::Part(pair, number) => vec![numbers[pair as usize][usize::from(number)]],
            Node::Truth(value) => truth(value),
            Node::Compare(comparison, a, b) => {
                let (a, b) = (of(a), of(b));
                truth(match comparison {
                    Comparison::Less => a < b,
                    Comparison::AtMost => a <= b,
                    Comparison::Equal => a == b,
                })
            }
            Node::Logic(Logic::And, a, b) => truth(of(a) > 0.0 && of(b) > 0.0),
            Node::Logic(Logic::Or, a, b) => truth(of(a) > 0.0 || of(b) > 0.0),
            Node::Not(a) => truth(of(a) == 0.0),
        };
        numbers.push(made);
    }
    program
        .outputs
        .iter()
        .map(|&id| numbers[id as usize][0])
        .collect()
}

/// Unit vectors: axes, diagonals, near both, and all over.
fn directions() -> Vec<[f64; 3]> {
    let steps = [-1.0, -1e-6, 0.0, 1e-6, 0.5, 1.0];
    let mut all = Vec::new();
    for x in steps {
        for y in steps {
            all.extend(steps.map(|z| [x, y, z]));
        }
    }
    let mut state = 1_u64;
    let mut random = || {
        state = state
            .wrapping_mul(6_364_136_223_846_793_005)
            .wrapping_add(1_442_695_040_888_963_407);
        (state >> 11) as f64 / (1_u64 << 52) as f64 - 1.0
    };
    all.extend((0..300).map(|_| [random(), random(), random()]));
    all.retain(|d| d.iter().any(|&x| x != 0.0));
    all.into_iter()
        .map(|d| {
            let length = d.iter().map(|x| x * x).sum::<f64>().sqrt();
            d.map(|x| x / length)
        })
        .collect()
}

fn maps() -> Vec<Map> {
    let mut maps: Vec<Map> = REGISTRY
        .iter()
        .map(|info| Map::new(info.name).unwrap())
        .collect();
    for name in [
        "cube:unreal",
        "latlong:mitsuba",
        "octahedral:unreal",
        "angular:openimageio",
    ] {
        maps.push(Map::new(name).unwrap());
    }
    for layout in ["cross", "strip", "3x2"] {
        maps.push(Map::with("cube", MapOptions::new().layout(layout)).unwrap());
    }
    maps.push(Map::with("angular", MapOptions::new().parameters(&[("fov", 180.0)])).unwrap());
    let pose = crate::geometry::from_angles(30.0, 20.0, 10.0);
    maps.push(Map::new("latlong").unwrap().turned(pose).unwrap());
    maps
}

fn is_common(map: &Map) -> bool {
    struct Common;
    impl Visitor for Common {
        type Output = bool;
        fn visit<P: Projection>(self, _: P) -> bool {
            P::COMMON
        }
    }
    map.visit_canonical(Common)
}

fn same(a: f64, b: f64) -> bool {
    a == b || a.is_nan() && b.is_nan()
}

/// What a map computes at places, by its kernels, beside what its recorded verb does.
fn check<T: Width, R: crate::kernel::Scalar>(map: &Map, style: Style) {
    let name = format!(
        "{} {:?} {:?} double {}",
        map.info().name,
        map.convention(),
        map.layout(),
        style.double
    );
    let width = map.uv_width();
    let ds: Vec<[f64; 3]> = directions()
        .into_iter()
        .map(|d| d.map(|x| R::new(x).to_f64()))
        .collect();
    let flat: Vec<R> = ds.as_flattened().iter().map(|&x| R::new(x)).collect();
    let mut uv = vec![R::ZERO; width * ds.len()];
    map.encode_numbers(None, &flat, &mut uv);
    let encode = program::<T>(map, Verb::Encode, style);
    for (d, wanted) in ds.iter().zip(uv.chunks(width)) {
        let wanted: Vec<f64> = wanted.iter().map(|x| x.to_f64()).collect();
        let got = values::<T>(&encode, style, d);
        let alike = got.iter().zip(&wanted).all(|(a, b)| same(*a, *b))
            || wanted[0].is_nan() && got[0].is_nan();
        assert!(alike, "{name} encode {d:?}: {got:?} instead of {wanted:?}");
    }
    let places: Vec<R> = uv
        .chunks(width)
        .filter(|uv| !uv[0].to_f64().is_nan())
        .flatten()
        .copied()
        .collect();
    let count = places.len() / width;
    let mut back = vec![R::ZERO; 3 * count];
    map.decode_numbers(None, &places, &mut back);
    let mut densities = vec![R::ZERO; count];
    map.density_numbers(&places, &mut densities);
    let mut jacobians = vec![R::ZERO; 6 * count];
    map.jacobian_numbers(None, &places, &mut jacobians);
    let mut valid = vec![false; count];
    map.valid_numbers(&places, &mut valid);
    let [decode, density, jacobian, validity] =
        [Verb::Decode, Verb::Density, Verb::Jacobian, Verb::Valid]
            .map(|verb| program::<T>(map, verb, style));
    for k in 0..count {
        let uv: Vec<f64> = places[width * k..][..width]
            .iter()
            .map(|x| x.to_f64())
            .collect();
        let holds = |verb: &str, program: &Program, wanted: Vec<f64>| {
            let got = values::<T>(program, style, &uv);
            let alike = got.iter().zip(&wanted).all(|(a, b)| same(*a, *b));
            assert!(alike, "{name} {verb} {uv:?}: {got:?} instead of {wanted:?}");
        };
        let of = |numbers: &[R]| numbers.iter().map(|x| x.to_f64()).collect::<Vec<_>>();
        holds("valid", &validity, vec![f64::from(u8::from(valid[k]))]);
        if !valid[k] {
            continue;
        }
        holds("decode", &decode, of(&back[3 * k..][..3]));
        holds("density", &density, of(&densities[k..][..1]));
        let j = of(&jacobians[6 * k..][..6]);
        holds(
            "jacobian",
            &jacobian,
            vec![j[0], j[2], j[4], j[1], j[3], j[5]],
        );
    }
}

#[test]
fn what_is_recorded_has_the_bits_of_the_kernels() {
    for map in maps() {
        let style = |double| Style {
            double,
            native: false,
            inside: false,
        };
        check::<f64, f64>(&map, style(true));
        // The others compute f32 in f64.
        if is_common(&map) {
            check::<f32, f32>(&map, style(false));
        }
    }
}

#[test]
fn every_map_prints_in_every_language() {
    for map in maps() {
        for language in languages() {
            let options = CodeOptions::new().verbs(&Verb::ALL);
            let text = code(&map, language.name, &options).unwrap();
            for verb in Verb::ALL {
                let name = format!("{}_{}(", map.info().name, verb.name());
                assert!(text.contains(&name), "{} {name}", language.name);
            }
        }
    }
}

#[test]
fn what_cannot_be_written_says_why() {
    let map = Map::new("latlong").unwrap();
    let says = |language: &str, options: CodeOptions<'_>| {
        code(&map, language, &options).unwrap_err().to_string()
    };
    assert!(says("glls", CodeOptions::new()).contains("'glsl'"));
    assert!(says("wgsl", CodeOptions::new().double(true)).contains("64 bits"));
    assert!(says("c", CodeOptions::new().name("1st")).contains("a letter"));
    assert!(says("c", CodeOptions::new().name("union")).contains("word"));
    assert!(says("c", CodeOptions::new().verbs(&[])).contains("verb"));
}
