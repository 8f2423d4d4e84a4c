//! Graphs run number by number, for tests: what is recorded is what the kernels compute.

use crate::code::interface::{Gives, Program};
use crate::code::source::helper_arguments;
use crate::number::graph::{Binary, Comparison, Helper, Logic, Node, Style, Unary};
use crate::number::trace;
use std::cell::RefCell;
use std::rc::Rc;

thread_local! {
    /// Bodies of helpers that were called: to trace one takes longer than to run it.
    static BODIES: RefCell<Vec<(Helper, Style, Rc<Program>)>> = const { RefCell::new(Vec::new()) };
}

fn body(helper: Helper, style: Style) -> Rc<Program> {
    BODIES.with_borrow_mut(|bodies| {
        let known = bodies
            .iter()
            .find(|body| (body.0, body.1) == (helper, style));
        if let Some((.., known)) = known {
            return known.clone();
        }
        let (graph, outputs) = trace::body(helper, style);
        let made = Rc::new(Program {
            takes: helper_arguments(helper),
            gives: Gives::Pair,
            nodes: graph.into_nodes(),
            outputs,
        });
        bodies.push((helper, style, made.clone()));
        made
    })
}

/// The values of a program's outputs; conditions are 0 and 1.
pub(crate) fn values(program: &Program, style: Style, inputs: &[f64]) -> Vec<f64> {
    let rounded = |x: f64| if style.double { x } else { f64::from(x as f32) };
    // Of a helper's two outputs both, else one.
    let mut numbers: Vec<[f64; 2]> = Vec::with_capacity(program.nodes.len());
    for &node in &program.nodes {
        let of = |id: u32| numbers[id as usize][0];
        let truth = |holds: bool| [f64::from(u8::from(holds)); 2];
        let made = match node {
            Node::Input(number) => [inputs[usize::from(number)]; 2],
            Node::Constant(bits) => [f64::from_bits(bits); 2],
            Node::Unary(operation, a) => {
                let a = of(a);
                // A root in f64 rounds to that in f32, as do sums, products and quotients.
                [rounded(match operation {
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
                }); 2]
            }
            Node::Binary(operation, a, b) => {
                let (a, b) = (of(a), of(b));
                [rounded(match operation {
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
                }); 2]
            }
            Node::Select(condition, a, b) => [if of(condition) > 0.0 { of(a) } else { of(b) }; 2],
            Node::Call(helper, a, b) => {
                let found = values(&body(helper, style), style, &[of(a), of(b)]);
                [found[0], found[found.len() - 1]]
            }
            Node::Part(pair, number) => [numbers[pair as usize][usize::from(number)]; 2],
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
pub(crate) fn directions() -> Vec<[f64; 3]> {
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
