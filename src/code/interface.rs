//! Functions as what they take, what they give, and the graph between.

use crate::number::graph::{Id, Node};

/// How a word is made of numbers that are not below zero: side by side, the first in the lowest bits.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Words {
    /// How many numbers.
    pub fields: usize,
    /// Bits of each.
    pub bits: u32,
}

impl Words {
    /// The bits of a word.
    pub fn all(self) -> u32 {
        self.fields as u32 * self.bits
    }

    /// Where a field begins.
    pub fn shift(self, field: usize) -> u32 {
        field as u32 * self.bits
    }
}

/// What an argument of a function is.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Kind {
    /// A number.
    Number,
    /// So many numbers.
    Vector(usize),
    /// Numbers in the bits of a word.
    Word(Words),
}

/// An argument of a function.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Argument {
    /// Its name.
    pub name: &'static str,
    /// What it is.
    pub kind: Kind,
    /// The names of its numbers, where they are taken apart.
    pub parts: &'static [&'static str],
}

impl Argument {
    /// A direction.
    pub const DIRECTION: Argument = Argument {
        name: "d",
        kind: Kind::Vector(3),
        parts: &["x", "y", "z"],
    };

    /// A vector whose numbers have these names.
    pub fn vector(name: &'static str, parts: &'static [&'static str]) -> Argument {
        Argument {
            name,
            kind: Kind::Vector(parts.len()),
            parts,
        }
    }

    /// Image coordinates, two or three.
    pub fn place(numbers: usize) -> Argument {
        Argument {
            name: place_name(numbers),
            kind: Kind::Vector(numbers),
            parts: &["u", "v", "face"],
        }
    }

    /// A number.
    pub fn number(name: &'static str) -> Argument {
        Argument {
            name,
            kind: Kind::Number,
            parts: &[],
        }
    }

    /// Numbers in the bits of a word.
    pub fn word(words: Words) -> Argument {
        Argument {
            name: "code",
            kind: Kind::Word(words),
            parts: &["k0", "k1", "k2"],
        }
    }

    /// How its word is made of numbers, if it is one.
    pub fn words(&self) -> Option<Words> {
        match self.kind {
            Kind::Word(words) => Some(words),
            Kind::Number | Kind::Vector(_) => None,
        }
    }

    /// How many numbers it is.
    pub fn width(&self) -> usize {
        match self.kind {
            Kind::Number => 1,
            Kind::Vector(n) => n,
            Kind::Word(words) => words.fields,
        }
    }
}

/// The name of image coordinates.
pub fn place_name(numbers: usize) -> &'static str {
    if numbers == 2 { "uv" } else { "uvf" }
}

/// What a function gives.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Gives {
    /// One number.
    Number,
    /// Two numbers of a shared function.
    Pair,
    /// Whether it is so.
    Truth,
    /// A vector of so many numbers, of this name where it has one: a direction, or image coordinates.
    Vector(usize, &'static str),
    /// Two directions.
    Columns,
    /// Numbers in the bits of a word.
    Word(Words),
    /// Columns, rows and weights of four texels, and their faces where these are apart.
    Taps {
        /// Whether they are.
        apart: bool,
    },
}

/// A function as a graph.
#[derive(Clone, Debug)]
pub struct Program {
    /// What it takes.
    pub takes: Vec<Argument>,
    /// What it gives.
    pub gives: Gives,
    /// Nodes, each behind those that it is made of.
    pub nodes: Vec<Node>,
    /// The numbers, or the condition, that it gives.
    pub outputs: Vec<Id>,
}
