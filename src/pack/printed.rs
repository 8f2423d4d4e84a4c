//! Formulas of schemes as graphs, which [`super::source`] prints.
//!
//! A scheme that is a formula is written once, over a number that may record ([`Lattice`]): what is printed is what the
//! kernels compute. Codes are words; their fields come and go as numbers that are not below zero, so that a
//! language needs shifts and masks and no signed integers.

use super::kernel::Lattice;
use super::rounding::Rounding;
use crate::code::{Argument, Gives, Program, Words};
use crate::number::graph::Style;
use crate::number::trace::{Trace, record};

/// A scheme that is a formula.
pub trait Formula: Copy {
    /// How a code is made of numbers.
    fn words(self) -> Words;

    /// The numbers of a unit vector's code.
    fn pack<R: Lattice>(self, rounding: Rounding, d: [R; 3]) -> Vec<R>;

    /// The unit vector of such numbers.
    fn unpack<R: Lattice>(self, numbers: &[R]) -> [R; 3];
}

/// What a scheme can be printed for.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum Verb {
    /// A direction to its code.
    Pack,
    /// A code to its direction.
    Unpack,
}

impl Verb {
    /// Both.
    pub const ALL: [Verb; 2] = [Verb::Pack, Verb::Unpack];

    /// The name of the verb.
    ///
    /// ```
    /// assert_eq!(spheremap::pack::Verb::Pack.name(), "pack");
    /// ```
    pub fn name(self) -> &'static str {
        match self {
            Verb::Pack => "pack",
            Verb::Unpack => "unpack",
        }
    }
}

/// One function of a scheme.
#[derive(Clone, Copy, Debug)]
pub struct Asked {
    /// Which.
    pub verb: Verb,
    /// How `pack` rounds.
    pub rounding: Rounding,
    /// What it is recorded in.
    pub style: Style,
}

impl Asked {
    /// The function of a formula.
    pub fn program<F: Formula>(self, formula: F) -> Program {
        let words = formula.words();
        let input = |number: usize| Trace::input(number as u8);
        let (graph, outputs) = record(self.style, || {
            let numbers = match self.verb {
                Verb::Pack => formula.pack(self.rounding, [0, 1, 2].map(input)),
                Verb::Unpack => {
                    let fields: Vec<_> = (0..words.fields).map(input).collect();
                    formula.unpack(&fields).to_vec()
                }
            };
            numbers.into_iter().map(Trace::id).collect()
        });
        let (takes, gives) = match self.verb {
            Verb::Pack => (Argument::DIRECTION, Gives::Word(words)),
            Verb::Unpack => (Argument::word(words), Gives::Vector(3, "d")),
        };
        Program {
            takes: vec![takes],
            gives,
            nodes: graph.into_nodes(),
            outputs,
        }
    }
}
