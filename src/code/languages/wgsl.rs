//! WGSL: the shading language of WebGPU.

use super::bits;
use crate::code::dialect::{
    Dialect, Expression, Local, Signature, Text, level, numbered, place_name, plain, prefix,
};
use crate::code::program::{Gives, Takes};
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

    fn checked(&self) -> &'static str {
        "WebGPU (wgpu), by `make test-languages`"
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

    fn literal(&self, x: f64, text: &Text) -> String {
        plain(x, text.double)
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

    fn open(&self, signature: &Signature, text: &Text) -> String {
        let arguments = match signature.takes {
            Takes::Direction => "d: vec3<f32>".to_owned(),
            Takes::Place(n) => format!("{}: {}", place_name(n), self.vector(n, text)),
            Takes::Numbers(n) => numbered(n)
                .map(|name| format!("{name}: f32"))
                .collect::<Vec<_>>()
                .join(", "),
        };
        let gives = match signature.gives {
            Gives::Number => "f32".to_owned(),
            Gives::Truth => "bool".to_owned(),
            Gives::Pair => self.vector(2, text),
            Gives::Vector(n) => self.vector(n, text),
            Gives::Columns => self.columns(text),
        };
        format!("fn {}({arguments}) -> {gives} {{", signature.name)
    }

    fn local(&self, _local: Local, name: &str, value: &str, _text: &Text) -> String {
        format!("let {name} = {value};")
    }

    fn function(&self, operation: Unary, _text: &Text) -> String {
        match operation {
            Unary::Absolute => "abs",
            Unary::Floor => "floor",
            Unary::Round => "round",
            Unary::Sine => "sin",
            Unary::Cosine => "cos",
            Unary::Sinh => "sinh",
            Unary::Cosh => "cosh",
            _ => "sqrt",
        }
        .to_owned()
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

    fn functions_of_two(&self, _text: &Text) -> [String; 3] {
        ["min", "max", "atan2"].map(str::to_owned)
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
