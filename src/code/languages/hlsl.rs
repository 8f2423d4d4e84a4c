//! HLSL: the shading language of Direct3D, of Unreal and of Unity. `precise` keeps compilers from contracting and
//! reordering.

use super::bits;
use crate::code::dialect::{Dialect, Expression, Local, Text, prefix};
use crate::number::graph::Unary;

/// HLSL.
pub struct Hlsl;

impl Dialect for Hlsl {
    fn name(&self) -> &'static str {
        "hlsl"
    }

    fn title(&self) -> &'static str {
        "HLSL (shader model 5)"
    }

    fn extension(&self) -> &'static str {
        "hlsl"
    }

    fn promise(&self) -> &'static str {
        "The bits are those of the library where division and square root are rounded correctly; `precise` forbids the rest."
    }

    fn names_results(&self) -> bool {
        true
    }

    fn reserved(&self) -> &'static [&'static str] {
        &[
            "sample",
            "texture",
            "pass",
            "technique",
            "vector",
            "matrix",
            "half",
            "fixed",
            "main",
        ]
    }

    fn vector(&self, n: usize, _text: &Text) -> String {
        format!("float{n}")
    }

    fn columns(&self, _text: &Text) -> String {
        "float2x3".to_owned()
    }

    fn suffix(&self, _text: &Text) -> &'static str {
        "f"
    }

    fn not_a_number(&self, _text: &Text) -> String {
        "asfloat(0x7fc00000u)".to_owned()
    }

    fn local(&self, local: Local, name: &str, value: &str, text: &Text) -> String {
        match local {
            Local::Number => format!("precise float {name} = {value};"),
            Local::Pair => format!("precise {} {name} = {value};", self.vector(2, text)),
            Local::Truth => format!("bool {name} = {value};"),
        }
    }

    fn unary(&self, operation: Unary, a: &Expression, text: &Text) -> Expression {
        bits::single(operation, a, ["int", "asfloat", "asint", "float"])
            .unwrap_or_else(|| prefix(self, operation, a, text))
    }
}
