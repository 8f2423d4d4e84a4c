//! Open Shading Language, of Blender's Cycles, Arnold and others. It has no NaN that a shader may write, so that what lies
//! outside the coverage is (-1, -1); and no way to the bits of a float.

use crate::code::dialect::{
    Dialect, Expression, Local, Signature, Text, numbered, place_name, prefix,
};
use crate::code::program::{Gives, Takes};
use crate::number::graph::Unary;

/// OSL.
pub struct Osl;

impl Dialect for Osl {
    fn name(&self) -> &'static str {
        "osl"
    }

    fn title(&self) -> &'static str {
        "Open Shading Language"
    }

    fn extension(&self) -> &'static str {
        "osl"
    }

    fn promise(&self) -> &'static str {
        "Within a few units in the last place. Outside the coverage coordinates are -1: the language has no NaN to write."
    }

    fn reserved(&self) -> &'static [&'static str] {
        &[
            "shader",
            "surface",
            "displacement",
            "volume",
            "color",
            "normal",
            "point",
            "vector",
            "closure",
            "output",
            "P",
            "N",
            "I",
        ]
    }

    fn truth(&self) -> &'static str {
        "int"
    }

    fn vector(&self, _n: usize, _text: &Text) -> String {
        "vector".to_owned()
    }

    fn joined(&self, values: &[String], _text: &Text) -> String {
        let third = if values.len() > 2 {
            values[2].as_str()
        } else {
            "0.0"
        };
        format!("vector({}, {}, {third})", values[0], values[1])
    }

    fn columns(&self, _text: &Text) -> String {
        "void".to_owned()
    }

    fn open(&self, signature: &Signature, _text: &Text) -> String {
        let mut arguments = match signature.takes {
            Takes::Direction => "vector d".to_owned(),
            Takes::Place(n) => format!("vector {}", place_name(n)),
            Takes::Numbers(n) => numbered(n)
                .map(|name| format!("float {name}"))
                .collect::<Vec<_>>()
                .join(", "),
        };
        let gives = match signature.gives {
            Gives::Number => "float",
            Gives::Truth => "int",
            Gives::Pair | Gives::Vector(_) => "vector",
            Gives::Columns => {
                arguments.push_str(", output vector du, output vector dv");
                "void"
            }
        };
        format!("{gives} {}({arguments}) {{", signature.name)
    }

    fn gives(&self, signature: &Signature, values: &[String], text: &Text) -> String {
        match signature.gives {
            Gives::Number | Gives::Truth => format!("return {};", values.concat()),
            Gives::Pair | Gives::Vector(_) => format!("return {};", self.joined(values, text)),
            Gives::Columns => {
                let [a, b] = [0, 3].map(|k| self.joined(&values[k..k + 3], text));
                format!("du = {a};\ndv = {b};")
            }
        }
    }

    fn argument(&self, signature: &Signature, number: usize) -> String {
        match signature.takes {
            Takes::Direction => format!("d[{number}]"),
            Takes::Place(n) => format!("{}[{number}]", place_name(n)),
            Takes::Numbers(n) => numbered(n).nth(number).unwrap_or_default().to_owned(),
        }
    }

    fn part(&self, pair: &str, number: u8) -> String {
        format!("{pair}[{number}]")
    }

    fn local(&self, local: Local, name: &str, value: &str, _text: &Text) -> String {
        let kind = match local {
            Local::Number => "float",
            Local::Truth => "int",
            Local::Pair => "vector",
        };
        format!("{kind} {name} = {value};")
    }

    fn not_a_number(&self, _text: &Text) -> String {
        "-1.0".to_owned()
    }

    fn unary(&self, operation: Unary, a: &Expression, text: &Text) -> Expression {
        match operation {
            // Its own function rounds halves away from zero; quarter turns at a half may be taken either way.
            Unary::Round => Expression::atom(format!("round({})", a.text)),
            Unary::Exponent => Expression::atom(format!("floor(log2({}))", a.text)),
            _ => prefix(self, operation, a, text),
        }
    }

    fn functions_of_two(&self, _text: &Text) -> [String; 3] {
        ["min", "max", "atan2"].map(str::to_owned)
    }
}
