//! Metal's shading language.

use crate::code::dialect::{Dialect, Expression, Names, Signature, Text, filled_by, prefix};
use crate::code::interface::Gives;
use crate::number::graph::Unary;

/// MSL.
pub struct Msl;

impl Dialect for Msl {
    fn name(&self) -> &'static str {
        "msl"
    }

    fn title(&self) -> &'static str {
        "Metal Shading Language"
    }

    fn extension(&self) -> &'static str {
        "metal"
    }

    fn promise(&self) -> &'static str {
        "The bits are those of the library with `-fno-fast-math -ffp-contract=off`."
    }

    fn reserved(&self) -> &'static [&'static str] {
        &[
            "half", "kernel", "vertex", "fragment", "device", "constant", "thread", "main",
        ]
    }

    fn prelude(&self, _text: &Text) -> String {
        "#include <metal_stdlib>\nusing namespace metal;\n\n".to_owned()
    }

    fn qualifier(&self, _signature: &Signature) -> &'static str {
        "static inline "
    }

    fn vector(&self, n: usize, _text: &Text) -> String {
        format!("float{n}")
    }

    fn columns(&self, _text: &Text) -> String {
        "float2x3".to_owned()
    }

    fn filled(&self, gives: Gives, text: &Text) -> Vec<(&'static str, String)> {
        match gives {
            Gives::Taps { .. } => filled_by(self, gives, text, ["thread ", "&"]),
            _ => Vec::new(),
        }
    }

    fn joined_columns(&self, values: &[String], text: &Text) -> String {
        let [a, b] = [0, 3].map(|k| self.joined(&values[k..k + 3], text));
        format!("float2x3({a}, {b})")
    }

    fn word(&self, bits: u32) -> Option<&'static str> {
        Some(if bits <= 32 { "uint" } else { "ulong" })
    }

    fn suffix(&self, _text: &Text) -> &'static str {
        "f"
    }

    fn not_a_number(&self, _text: &Text) -> String {
        "NAN".to_owned()
    }

    fn names(&self) -> Names {
        Names {
            absolute: "fabs",
            round: "rint",
            ..Names::SHADERS
        }
    }

    fn unary(&self, operation: Unary, a: &Expression, text: &Text) -> Expression {
        match operation {
            Unary::PowerOfTwo => Expression::atom(format!("ldexp(1.0f, int({}))", a.text)),
            Unary::Exponent => Expression::atom(format!("float(ilogb({}))", a.text)),
            _ => prefix(self, operation, a, text),
        }
    }
}
