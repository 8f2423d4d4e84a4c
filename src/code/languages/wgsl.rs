//! WGSL: the shading language of WebGPU.

use super::bits;
use crate::code::dialect::{
    Dialect, Expression, Local, Signature, Text, level, outside, prefix, several,
};
use crate::code::interface::{Argument, Gives};
use crate::number::graph::Unary;

/// WGSL.
pub struct Wgsl;

impl Dialect for Wgsl {
    fn name(&self) -> &'static str {
        "wgsl"
    }

    fn title(&self) -> &'static str {
        "WGSL (WebGPU)"
    }

    fn extension(&self) -> &'static str {
        "wgsl"
    }

    fn promise(&self) -> &'static str {
        "Within a few units in the last place: the language lets compilers contract and divide less exactly."
    }

    fn reserved(&self) -> &'static [&'static str] {
        &[
            "fn",
            "let",
            "var",
            "loop",
            "target",
            "enable",
            "diagnostic",
            "override",
            "alias",
            "of",
            "from",
            "self",
        ]
    }

    fn number(&self, _text: &Text) -> &'static str {
        "f32"
    }

    fn vector(&self, n: usize, _text: &Text) -> String {
        format!("vec{n}<f32>")
    }

    fn columns(&self, _text: &Text) -> String {
        "mat2x3<f32>".to_owned()
    }

    fn prelude(&self, text: &Text) -> String {
        if text.not_a_number {
            // A constant expression must not be NaN.
            format!(
                "var<private> {}_nan_bits: u32 = 0x7fc00000u;\n\n",
                text.prefix
            )
        } else {
            String::new()
        }
    }

    fn not_a_number(&self, text: &Text) -> String {
        format!("bitcast<f32>({}_nan_bits)", text.prefix)
    }

    fn word(&self, bits: u32) -> Option<&'static str> {
        (bits <= 32).then_some("u32")
    }

    fn parameter(&self, argument: &Argument, text: &Text) -> String {
        let kind = self.kind(argument.kind, text);
        format!("{}: {kind}", argument.name)
    }

    fn open(&self, signature: &Signature, text: &Text) -> String {
        let (arguments, gives) = outside(self, signature, text);
        if gives == "void" {
            return format!("fn {}({arguments}) {{", signature.name);
        }
        format!("fn {}({arguments}) -> {gives} {{", signature.name)
    }

    fn filled(&self, gives: Gives, text: &Text) -> Vec<(&'static str, String)> {
        let (names, width) = match gives {
            Gives::Taps { .. } => several(gives),
            _ => return Vec::new(),
        };
        let of = self.vector(width, text);
        let parameter = |&name: &&'static str| (name, format!("{name}: ptr<function, {of}>"));
        names.iter().map(parameter).collect()
    }

    fn fill(&self, name: &str, values: &[String], text: &Text) -> String {
        format!("*{name} = {};", self.joined(values, text))
    }

    fn local(&self, _local: Local, name: &str, value: &str, _text: &Text) -> String {
        format!("let {name} = {value};")
    }

    fn unary(&self, operation: Unary, a: &Expression, text: &Text) -> Expression {
        let casts = ["i32", "bitcast<f32>", "bitcast<i32>", "f32"];
        bits::single(operation, a, casts)
            .map(|made| {
                Expression::atom(
                    made.text
                        .replace("<< 23)", "<< 23u)")
                        .replace(">> 23)", ">> 23u)"),
                )
            })
            .unwrap_or_else(|| prefix(self, operation, a, text))
    }

    fn select(
        &self,
        condition: &Expression,
        a: &Expression,
        b: &Expression,
        _text: &Text,
    ) -> Expression {
        Expression::atom(format!(
            "select({}, {}, {})",
            b.text, a.text, condition.text
        ))
    }

    // The language wants these parentheses.
    fn and(&self, a: &Expression, b: &Expression) -> Expression {
        let text = format!(
            "{} && {}",
            a.within(level::COMPARISON),
            b.within(level::COMPARISON)
        );
        Expression::new(text, level::AND)
    }
}
