//! What is recorded is what the kernels compute: the graph is run here, number by number.

use super::*;
use crate::code::run::{directions, values};
use crate::map::MapOptions;
use crate::number::graph::{Binary, Node, Style, Unary};
use crate::number::real::Real;
use crate::number::trace::{Trace, record};
use crate::projections::REGISTRY;
use crate::projections::projection::{Info, Projection, Visitor};

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
fn check<R: crate::kernel::Scalar>(map: &Map, style: Style) {
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
    let encode = program(map, Verb::Encode, style);
    for (d, wanted) in ds.iter().zip(uv.chunks(width)) {
        let wanted: Vec<f64> = wanted.iter().map(|x| x.to_f64()).collect();
        let got = values(&encode, style, d);
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
            .map(|verb| program(map, verb, style));
    for k in 0..count {
        let uv: Vec<f64> = places[width * k..][..width]
            .iter()
            .map(|x| x.to_f64())
            .collect();
        let holds = |verb: &str, program: &Program, wanted: Vec<f64>| {
            let got = values(program, style, &uv);
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
        check::<f64>(&map, style(true));
        // The others compute f32 in f64.
        if is_common(&map) {
            check::<f32>(&map, style(false));
        }
    }
}

#[test]
fn what_is_chosen_last_is_the_same() {
    let style = Style {
        double: true,
        native: false,
        inside: false,
    };
    for map in maps() {
        let encode = program(&map, Verb::Encode, style);
        let last = absent::chosen_last(encode.clone(), style);
        for d in directions() {
            let (wanted, got) = (values(&encode, style, &d), values(&last, style, &d));
            let alike = wanted.iter().zip(&got).all(|(a, b)| same(*a, *b));
            assert!(
                alike,
                "{} {d:?}: {got:?} instead of {wanted:?}",
                map.info().name
            );
        }
    }
}

/// Maps of lenses whose coefficients are not zero: their formulas have terms that others lack.
fn distorted() -> Vec<Map> {
    let bent = |info: &&Info| info.parameters.iter().any(|p| p.name == "k1");
    let maps: Vec<Map> = REGISTRY
        .iter()
        .filter(bent)
        .map(|info| {
            let small = info.parameters.iter().filter(|p| p.default == 0.0);
            let some: Vec<(&str, f64)> = small.map(|p| (p.name, 0.01)).collect();
            Map::with(info.name, MapOptions::new().parameters(&some)).unwrap()
        })
        .collect();
    assert!(maps.len() > 3);
    maps
}

/// What a NaN that the formula chose meets on its way out, other than choices and arithmetic, which give it again.
fn met_by_nan(program: &Program) -> Vec<Node> {
    let mut may_be_nan = Vec::with_capacity(program.nodes.len());
    let mut met = Vec::new();
    let used = printer::uses(program, false).into_iter().map(|n| n > 0);
    for (&node, used) in program.nodes.iter().zip(used) {
        let keeps = match node {
            Node::Constant(bits) => f64::from_bits(bits).is_nan(),
            Node::Select(_, a, b) => may_be_nan[a as usize] || may_be_nan[b as usize],
            _ => node.operands().any(|id| may_be_nan[id as usize]),
        };
        let passes = matches!(
            node,
            Node::Constant(_)
                | Node::Select(..)
                | Node::Unary(Unary::Negate, _)
                | Node::Binary(
                    Binary::Add | Binary::Subtract | Binary::Multiply | Binary::Divide,
                    ..
                )
        );
        if used && keeps && !passes {
            met.push(node);
        }
        may_be_nan.push(keeps);
    }
    met
}

// Vulkan lets a card make a minimum of a clamp's comparison, and NVIDIA's does, which gives 1 for NaN.
#[test]
fn no_operation_can_make_a_number_of_the_nan_outside_a_map() {
    for native in [false, true] {
        let style = Style {
            double: false,
            native,
            inside: false,
        };
        for map in maps().into_iter().chain(distorted()) {
            let met = met_by_nan(&program(&map, Verb::Encode, style));
            assert!(met.is_empty(), "{}: {met:?}", map.info().name);
        }
        let (graph, outputs) = record(style, || {
            let x = Trace::input(0);
            let chosen = Trace::select(x.less(Trace::ONE), x, Trace::NAN);
            vec![chosen.clamped(-1.0, 1.0).id()]
        });
        let clamped = Program {
            takes: Vec::new(),
            gives: Gives::Number,
            nodes: graph.into_nodes(),
            outputs,
        };
        assert_eq!(met_by_nan(&clamped).len(), 2);
    }
}

#[test]
fn every_map_prints_in_every_language() {
    for map in maps() {
        for language in languages() {
            let printed = |verb: &Verb| *verb != Verb::Taps || taps::rule(&map).is_ok();
            let verbs: Vec<Verb> = Verb::ALL.into_iter().filter(printed).collect();
            let options = CodeOptions::new().verbs(&verbs);
            let text = code(&map, language.name, &options).unwrap();
            for verb in verbs {
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

#[test]
fn a_verb_asked_for_twice_is_there_once() {
    let map = Map::new("octahedral").unwrap();
    let written = |verbs: &[Verb]| code(&map, "glsl", &CodeOptions::new().verbs(verbs));
    let twice = written(&[Verb::Decode, Verb::Encode, Verb::Decode]);
    assert_eq!(twice, written(&[Verb::Decode, Verb::Encode]));
}
