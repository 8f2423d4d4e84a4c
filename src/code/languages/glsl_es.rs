//! GLSL ES 3.00: what WebGL 2 takes.

use super::bits;
use crate::code::dialect::{Dialect, Expression, Names, Text, prefix};
use crate::number::graph::Unary;

/// What the functions of both are called.
pub const NAMES: Names = Names {
    round: "roundEven",
    arctangent: "atan",
    ..Names::SHADERS
};

/// GLSL of WebGL 2.
pub struct GlslEs;

impl Dialect for GlslEs {
    fn name(&self) -> &'static str {
        "glsl_es"
    }

    fn title(&self) -> &'static str {
        "GLSL ES 3.00 (WebGL 2)"
    }

    fn extension(&self) -> &'static str {
        "glsl"
    }

    fn promise(&self) -> &'static str {
        "Within a few units in the last place: the language lets compilers contract and reorder. It wants `precision highp float`."
    }

    fn reserved(&self) -> &'static [&'static str] {
        &[
            "input", "output", "sample", "filter", "common", "active", "half", "fixed", "main",
        ]
    }

    fn prelude(&self, _text: &Text) -> String {
        "precision highp float;\nprecision highp int;\n\n".to_owned()
    }

    fn vector(&self, n: usize, _text: &Text) -> String {
        format!("vec{n}")
    }

    fn columns(&self, _text: &Text) -> String {
        "mat2x3".to_owned()
    }

    fn not_a_number(&self, _text: &Text) -> String {
        "uintBitsToFloat(0x7fc00000u)".to_owned()
    }

    fn names(&self) -> Names {
        NAMES
    }

    fn unary(&self, operation: Unary, a: &Expression, text: &Text) -> Expression {
        bits::single(
            operation,
            a,
            ["int", "intBitsToFloat", "floatBitsToInt", "float"],
        )
        .unwrap_or_else(|| prefix(self, operation, a, text))
    }
}
