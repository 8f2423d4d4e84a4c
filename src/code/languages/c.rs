//! C, and C++ that reads it.

use crate::code::dialect::{Dialect, Expression, Names, Signature, Text, by_exponent, several};
use crate::code::interface::{Argument, Gives, Kind};
use crate::number::graph::Unary;

/// C99.
pub struct C;

/// The name of a function of `math.h` in the width of a text.
pub fn math(name: &str, text: &Text) -> String {
    format!("{name}{}", if text.double { "" } else { "f" })
}

impl Dialect for C {
    fn name(&self) -> &'static str {
        "c"
    }

    fn title(&self) -> &'static str {
        "C99"
    }

    fn extension(&self) -> &'static str {
        "h"
    }

    fn promise(&self) -> &'static str {
        "The bits are those of the library with `-ffp-contract=off` and without `-ffast-math`."
    }

    fn has_double(&self) -> bool {
        true
    }

    fn reserved(&self) -> &'static [&'static str] {
        &[
            "main", "register", "auto", "union", "sizeof", "inline", "restrict",
        ]
    }

    fn prelude(&self, text: &Text) -> String {
        let number = self.number(text);
        let words = if text.words {
            "#include <stdint.h>\n"
        } else {
            ""
        };
        format!(
            "#include <math.h>\n#include <stdbool.h>\n{words}\ntypedef struct {{ {number} x, y; }} {}_pair;\n\n",
            text.prefix
        )
    }

    fn qualifier(&self, _signature: &Signature) -> &'static str {
        "static inline "
    }

    fn vector(&self, _n: usize, text: &Text) -> String {
        format!("{}_pair", text.prefix)
    }

    fn joined(&self, values: &[String], text: &Text) -> String {
        format!("({}){{{}}}", self.vector(2, text), values.join(", "))
    }

    fn word(&self, bits: u32) -> Option<&'static str> {
        Some(if bits <= 32 { "uint32_t" } else { "uint64_t" })
    }

    fn cast(&self, kind: &str, value: &str) -> String {
        format!("({kind})({value})")
    }

    fn suffix(&self, text: &Text) -> &'static str {
        if text.double { "" } else { "f" }
    }

    fn not_a_number(&self, text: &Text) -> String {
        if text.double { "(double)NAN" } else { "NAN" }.to_owned()
    }

    fn parameter(&self, argument: &Argument, text: &Text) -> String {
        let (number, name) = (self.number(text), argument.name);
        match argument.kind {
            Kind::Number => format!("{number} {name}"),
            Kind::Vector(n) => format!("const {number} {name}[{n}]"),
            Kind::Word(_) => format!("{} {name}", self.kind(argument.kind, text)),
        }
    }

    fn filled(&self, gives: Gives, text: &Text) -> Vec<(&'static str, String)> {
        let array = |name, n| (name, format!("{} {name}[{n}]", self.number(text)));
        match gives {
            Gives::Vector(n, name) => vec![array(name, n)],
            Gives::Columns | Gives::Taps { .. } => {
                let (names, width) = several(gives);
                names.iter().map(|&name| array(name, width)).collect()
            }
            Gives::Number | Gives::Truth | Gives::Pair | Gives::Word(_) => Vec::new(),
        }
    }

    fn fill(&self, name: &str, values: &[String], _text: &Text) -> String {
        let store = |(k, value): (usize, &String)| format!("{name}[{k}] = {value};");
        let stores: Vec<_> = values.iter().enumerate().map(store).collect();
        stores.join("\n")
    }

    fn component(&self, vector: &str, number: usize) -> String {
        format!("{vector}[{number}]")
    }

    fn part(&self, pair: &str, number: usize) -> String {
        format!("{pair}.{}", ["x", "y"][number])
    }

    // Results are computed before the first is stored, which may be where an argument is.
    fn names_results(&self) -> bool {
        true
    }

    // Its own functions drop a NaN, and are calls.
    fn compares(&self, _text: &Text) -> bool {
        true
    }

    fn names(&self) -> Names {
        Names::C
    }

    fn called(&self, name: &str, text: &Text) -> String {
        math(name, text)
    }

    fn unary(&self, operation: Unary, a: &Expression, text: &Text) -> Expression {
        by_exponent(self, operation, a, text)
    }
}
