//! C, and C++ that reads it.

use crate::code::dialect::{
    Dialect, Expression, Signature, Text, numbered, place_name, plain, prefix,
};
use crate::code::program::{Gives, Takes};
use crate::number::graph::Unary;

/// C99.
pub struct C;

/// The name of a function of `math.h` in the width of a text.
pub fn math(name: &str, text: &Text) -> String {
    format!("{name}{}", if text.double { "" } else { "f" })
}

/// The names of `math.h` for functions on one number.
pub fn function(operation: Unary, text: &Text) -> String {
    let name = match operation {
        Unary::Absolute => "fabs",
        Unary::Floor => "floor",
        Unary::Round => "rint",
        Unary::Sine => "sin",
        Unary::Cosine => "cos",
        Unary::Sinh => "sinh",
        Unary::Cosh => "cosh",
        _ => "sqrt",
    };
    math(name, text)
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

    fn checked(&self) -> &'static str {
        "a C compiler"
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
        format!(
            "#include <math.h>\n#include <stdbool.h>\n\ntypedef struct {{ {number} x, y; }} {}_pair;\n\n",
            text.prefix
        )
    }

    fn qualifier(&self, _signature: &Signature) -> &'static str {
        "static inline "
    }

    fn vector(&self, _n: usize, text: &Text) -> String {
        format!("{}_pair", text.prefix)
    }

    fn columns(&self, _text: &Text) -> String {
        "void".to_owned()
    }

    fn joined(&self, values: &[String], text: &Text) -> String {
        format!("({}){{{}}}", self.vector(2, text), values.join(", "))
    }

    fn literal(&self, x: f64, text: &Text) -> String {
        format!(
            "{}{}",
            plain(x, text.double),
            if text.double { "" } else { "f" }
        )
    }

    fn not_a_number(&self, text: &Text) -> String {
        if text.double { "(double)NAN" } else { "NAN" }.to_owned()
    }

    fn open(&self, signature: &Signature, text: &Text) -> String {
        let number = self.number(text);
        let arguments = match signature.takes {
            Takes::Direction => format!("const {number} d[3]"),
            Takes::Place(n) => format!("const {number} {}[{n}]", place_name(n)),
            Takes::Numbers(n) => numbered(n)
                .map(|name| format!("{number} {name}"))
                .collect::<Vec<_>>()
                .join(", "),
        };
        let (gives, out) = match (signature.gives, signature.takes) {
            (Gives::Number, _) => (number.to_owned(), String::new()),
            (Gives::Truth, _) => ("bool".to_owned(), String::new()),
            (Gives::Pair, _) => (self.vector(2, text), String::new()),
            (Gives::Vector(n), Takes::Direction) => (
                "void".to_owned(),
                format!(", {number} {}[{n}]", place_name(n)),
            ),
            (Gives::Vector(_), _) => ("void".to_owned(), format!(", {number} d[3]")),
            (Gives::Columns, _) => (
                "void".to_owned(),
                format!(", {number} du[3], {number} dv[3]"),
            ),
        };
        let qualifier = self.qualifier(signature);
        format!("{qualifier}{gives} {}({arguments}{out}) {{", signature.name)
    }

    fn argument(&self, signature: &Signature, number: usize) -> String {
        match signature.takes {
            Takes::Direction => format!("d[{number}]"),
            Takes::Place(n) => format!("{}[{number}]", place_name(n)),
            Takes::Numbers(n) => numbered(n).nth(number).unwrap_or_default().to_owned(),
        }
    }

    // Results are computed before the first is stored, which may be where an argument is.
    fn names_results(&self) -> bool {
        true
    }

    fn gives(&self, signature: &Signature, values: &[String], text: &Text) -> String {
        let stores = |name: &str, values: &[String]| {
            let store = |(k, value): (usize, &String)| format!("{name}[{k}] = {value};");
            values
                .iter()
                .enumerate()
                .map(store)
                .collect::<Vec<_>>()
                .join("\n")
        };
        match (signature.gives, signature.takes) {
            (Gives::Number | Gives::Truth, _) => format!("return {};", values.concat()),
            (Gives::Pair, _) => format!("return {};", self.joined(values, text)),
            (Gives::Vector(n), Takes::Direction) => stores(place_name(n), values),
            (Gives::Vector(_), _) => stores("d", values),
            (Gives::Columns, _) => {
                format!(
                    "{}\n{}",
                    stores("du", &values[..3]),
                    stores("dv", &values[3..])
                )
            }
        }
    }

    // Its own functions drop a NaN, and are calls.
    fn compares(&self, _text: &Text) -> bool {
        true
    }

    fn function(&self, operation: Unary, text: &Text) -> String {
        function(operation, text)
    }

    fn unary(&self, operation: Unary, a: &Expression, text: &Text) -> Expression {
        let number = self.number(text);
        match operation {
            Unary::PowerOfTwo => {
                let one = self.literal(1.0, text);
                Expression::atom(format!("{}({one}, (int)({}))", math("ldexp", text), a.text))
            }
            Unary::Exponent => {
                Expression::atom(format!("({number}){}({})", math("ilogb", text), a.text))
            }
            _ => prefix(self, operation, a, text),
        }
    }

    fn functions_of_two(&self, text: &Text) -> [String; 3] {
        ["fmin", "fmax", "atan2"].map(|name| math(name, text))
    }
}
