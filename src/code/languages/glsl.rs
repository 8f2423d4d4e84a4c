//! GLSL 4.3: the shading language of OpenGL and, through SPIR-V, of Vulkan. `precise` keeps compilers from contracting
//! and reordering.

use super::bits;
use crate::code::dialect::{Dialect, Expression, Local, Names, Text};
use crate::number::graph::Unary;

/// GLSL.
pub struct Glsl;

impl Dialect for Glsl {
    fn name(&self) -> &'static str {
        "glsl"
    }

    fn title(&self) -> &'static str {
        "GLSL 4.30"
    }

    fn extension(&self) -> &'static str {
        "glsl"
    }

    fn promise(&self) -> &'static str {
        "The bits are those of the library where division and square root are rounded correctly; `precise` forbids the rest."
    }

    fn has_double(&self) -> bool {
        true
    }

    fn names_results(&self) -> bool {
        true
    }

    fn reserved(&self) -> &'static [&'static str] {
        &[
            "input", "output", "sample", "filter", "common", "active", "half", "fixed", "main",
        ]
    }

    fn vector(&self, n: usize, text: &Text) -> String {
        format!("{}vec{n}", if text.double { "d" } else { "" })
    }

    fn columns(&self, text: &Text) -> String {
        format!("{}mat2x3", if text.double { "d" } else { "" })
    }

    fn suffix(&self, text: &Text) -> &'static str {
        if text.double { "lf" } else { "" }
    }

    fn not_a_number(&self, text: &Text) -> String {
        if text.double {
            "packDouble2x32(uvec2(0u, 0x7ff80000u))".to_owned()
        } else {
            "uintBitsToFloat(0x7fc00000u)".to_owned()
        }
    }

    fn local(&self, local: Local, name: &str, value: &str, text: &Text) -> String {
        match local {
            Local::Number => format!("precise {} {name} = {value};", self.number(text)),
            Local::Pair => format!("precise {} {name} = {value};", self.vector(2, text)),
            Local::Truth => format!("bool {name} = {value};"),
        }
    }

    fn unary(&self, operation: Unary, a: &Expression, text: &Text) -> Expression {
        if text.double {
            let a = &a.text;
            match operation {
                Unary::PowerOfTwo => return Expression::atom(format!("ldexp(1.0lf, int({a}))")),
                Unary::Exponent => {
                    let high = format!("unpackDouble2x32({a}).y");
                    return Expression::atom(format!("double(int({high} >> 20) - 1023)"));
                }
                // The language has these for floats only.
                Unary::Sine | Unary::Cosine | Unary::Sinh | Unary::Cosh => {
                    let name = self.function(operation, text);
                    return Expression::atom(format!("double({name}(float({a})))"));
                }
                _ => {}
            }
        } else if let Some(made) = bits::single(
            operation,
            a,
            ["int", "intBitsToFloat", "floatBitsToInt", "float"],
        ) {
            return made;
        }
        crate::code::dialect::prefix(self, operation, a, text)
    }

    fn names(&self) -> Names {
        super::glsl_es::NAMES
    }
}
