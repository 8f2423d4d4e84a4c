//! Formulas for languages that have no NaN to write: what takes its place is chosen at the end, where no operation can make
//! a number of it.

use crate::code::interface::{Gives, Program};
use crate::code::printer;
use crate::number::graph::{Binary, Comparison, Graph, Id, Logic, Node, Style};

/// The same program, whose outputs are chosen between a number and NaN last.
pub fn chosen_last(program: Program, style: Style) -> Program {
    if matches!(program.gives, Gives::Truth | Gives::Word(_)) || !printer::has_nan(&program) {
        return program;
    }
    let mut graph = Graph::new(style);
    let never = graph.node(Node::Truth(false));
    // For each node: its number, whatever it is where it would be NaN, and where that is.
    let mut made: Vec<(Id, Id)> = Vec::with_capacity(program.nodes.len());
    for &node in &program.nodes {
        let of = |id: Id| made[id as usize];
        let either = |graph: &mut Graph, a: Id, b: Id| graph.logic(Logic::Or, of(a).1, of(b).1);
        let pair = match node {
            Node::Constant(bits) if f64::from_bits(bits).is_nan() => {
                (graph.node(node), graph.node(Node::Truth(true)))
            }
            Node::Input(_) | Node::Constant(_) | Node::Truth(_) => (graph.node(node), never),
            Node::Unary(operation, a) => (graph.unary(operation, of(a).0), of(a).1),
            Node::Part(a, number) => (graph.node(Node::Part(of(a).0, number)), of(a).1),
            Node::Call(helper, a, b) => {
                let absent = either(&mut graph, a, b);
                (graph.node(Node::Call(helper, of(a).0, of(b).0)), absent)
            }
            // Comparisons with NaN do not hold: the second number is taken.
            Node::Binary(operation @ (Binary::Minimum | Binary::Maximum), a, b) => {
                let number = graph.binary(operation, of(a).0, of(b).0);
                (graph.select(of(a).1, of(b).0, number), of(b).1)
            }
            // Such a language has no infinity either, and what is divided by zero may be anything.
            Node::Binary(Binary::Divide, a, b) => {
                let absent = either(&mut graph, a, b);
                let zero = graph.constant(0.0);
                let vanishes = graph.compare(Comparison::Equal, of(b).0, zero);
                let absent = graph.logic(Logic::Or, absent, vanishes);
                (graph.binary(Binary::Divide, of(a).0, of(b).0), absent)
            }
            Node::Binary(operation, a, b) => {
                let absent = either(&mut graph, a, b);
                (graph.binary(operation, of(a).0, of(b).0), absent)
            }
            Node::Compare(comparison, a, b) => {
                let absent = either(&mut graph, a, b);
                let (holds, present) = (
                    graph.compare(comparison, of(a).0, of(b).0),
                    graph.not(absent),
                );
                (graph.logic(Logic::And, holds, present), never)
            }
            Node::Logic(logic, a, b) => (graph.logic(logic, of(a).0, of(b).0), never),
            Node::Not(a) => (graph.not(of(a).0), never),
            Node::Select(condition, a, b) => {
                let (condition, (a, no_a), (b, no_b)) = (of(condition).0, of(a), of(b));
                let absent = graph.choose_truth(condition, no_a, no_b);
                let number = if graph.is_nan(b) {
                    a
                } else if graph.is_nan(a) {
                    b
                } else {
                    graph.select(condition, a, b)
                };
                (number, absent)
            }
        };
        made.push(pair);
    }
    let nan = graph.constant(f64::NAN);
    let outputs = program.outputs.iter().map(|&id| {
        let (number, absent) = made[id as usize];
        graph.select(absent, nan, number)
    });
    Program {
        outputs: outputs.collect(),
        nodes: graph.into_nodes(),
        ..program
    }
}
