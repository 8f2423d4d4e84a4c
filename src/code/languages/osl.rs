//! Open Shading Language, of Blender's Cycles, Arnold and others. It has no NaN that a shader may write, so that what lies
//! outside the coverage is (-1, -1); and no way to the bits of a float.

use crate::code::dialect::{Dialect, Expression, Local, Text, filled_by, prefix, several};
use crate::code::interface::Gives;
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

    fn filled(&self, gives: Gives, text: &Text) -> Vec<(&'static str, String)> {
        // A vector has three numbers; four are an array.
        match gives {
            Gives::Taps { .. } => several(gives)
                .0
                .iter()
                .map(|&name| (name, format!("output float {name}[4]")))
                .collect(),
            _ => filled_by(self, gives, text, ["output ", ""]),
        }
    }

    fn fill(&self, name: &str, values: &[String], text: &Text) -> String {
        if values.len() < 4 {
            return format!("{name} = {};", self.joined(values, text));
        }
        let store = |(k, value): (usize, &String)| format!("{name}[{k}] = {value};");
        let stores: Vec<_> = values.iter().enumerate().map(store).collect();
        stores.join("\n")
    }

    fn component(&self, vector: &str, number: usize) -> String {
        format!("{vector}[{number}]")
    }

    fn local(&self, local: Local, name: &str, value: &str, _text: &Text) -> String {
        let kind = match local {
            Local::Number => "float",
            Local::Truth => "int",
            Local::Pair => "vector",
        };
        format!("{kind} {name} = {value};")
    }

    // It has no unsigned numbers; the bits are the same.
    fn word(&self, bits: u32) -> Option<&'static str> {
        (bits <= 32).then_some("int")
    }

    fn whole(&self, n: u64) -> String {
        n.to_string()
    }

    fn has_nan(&self) -> bool {
        false
    }

    fn not_a_number(&self, _text: &Text) -> String {
        "-1.0".to_owned()
    }

    fn unary(&self, operation: Unary, a: &Expression, text: &Text) -> Expression {
        // `round` rounds halves away from zero; quarter turns at a half may be taken either way.
        match operation {
            Unary::Exponent => Expression::atom(format!("floor(log2({}))", a.text)),
            _ => prefix(self, operation, a, text),
        }
    }
}
