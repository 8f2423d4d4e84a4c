//! Slang: the shading language of Khronos, which becomes SPIR-V, HLSL, Metal, CUDA and C++. It reads most of HLSL, and has
//! words of 64 bits. Its doubles are left out: in C++ it writes their constants with digits missing. What is `precise` is
//! so in SPIR-V only where a compiler is told `-fp-mode precise`.

use super::hlsl::Hlsl;
use crate::code::dialect::{Dialect, Expression, Local, Text};
use crate::number::graph::Unary;

/// Slang.
pub struct Slang;

impl Dialect for Slang {
    fn name(&self) -> &'static str {
        "slang"
    }

    fn title(&self) -> &'static str {
        "Slang"
    }

    fn extension(&self) -> &'static str {
        "slang"
    }

    fn promise(&self) -> &'static str {
        "The bits are those of the library where division and square root are rounded correctly; SPIR-V wants `-fp-mode precise`."
    }

    fn names_results(&self) -> bool {
        true
    }

    fn reserved(&self) -> &'static [&'static str] {
        &[
            "interface",
            "extension",
            "module",
            "import",
            "property",
            "func",
            "let",
            "var",
            "this",
            "vector",
            "matrix",
            "half",
            "main",
        ]
    }

    // Its C++ takes the number away from zero of two, also by the name of `rint`.
    fn prelude(&self, text: &Text) -> String {
        if !text.rounds {
            return String::new();
        }
        format!(
            "// The nearest whole number, the even one of two.\n\
             float {}_rint(float x) {{\n    \
             return x - floor(x) == 0.5f ? 2.0f * round(0.5f * x) : round(x);\n}}\n\n",
            text.prefix
        )
    }

    fn vector(&self, n: usize, text: &Text) -> String {
        Hlsl.vector(n, text)
    }

    fn columns(&self, text: &Text) -> String {
        Hlsl.columns(text)
    }

    fn suffix(&self, text: &Text) -> &'static str {
        Hlsl.suffix(text)
    }

    fn not_a_number(&self, text: &Text) -> String {
        Hlsl.not_a_number(text)
    }

    fn word(&self, bits: u32) -> Option<&'static str> {
        Some(if bits <= 32 { "uint" } else { "uint64_t" })
    }

    fn local(&self, local: Local, name: &str, value: &str, text: &Text) -> String {
        Hlsl.local(local, name, value, text)
    }

    fn unary(&self, operation: Unary, a: &Expression, text: &Text) -> Expression {
        match operation {
            Unary::Round => Expression::atom(format!("{}_rint({})", text.prefix, a.text)),
            _ => Hlsl.unary(operation, a, text),
        }
    }
}
