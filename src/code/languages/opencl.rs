//! OpenCL C.

use crate::code::dialect::{Dialect, Expression, Names, Signature, Text, by_exponent, filled_by};
use crate::code::interface::Gives;
use crate::number::graph::Unary;

/// OpenCL C.
pub struct OpenCl;

impl Dialect for OpenCl {
    fn name(&self) -> &'static str {
        "opencl"
    }

    fn title(&self) -> &'static str {
        "OpenCL C"
    }

    fn extension(&self) -> &'static str {
        "cl"
    }

    fn promise(&self) -> &'static str {
        "The bits are those of the library where division and square root are rounded correctly (`-cl-fp32-correctly-rounded-divide-sqrt`)."
    }

    fn has_double(&self) -> bool {
        true
    }

    fn reserved(&self) -> &'static [&'static str] {
        &[
            "kernel", "global", "local", "constant", "private", "half", "main", "register", "auto",
            "union",
        ]
    }

    fn prelude(&self, text: &Text) -> String {
        let wide = if text.double {
            "#pragma OPENCL EXTENSION cl_khr_fp64 : enable\n"
        } else {
            ""
        };
        format!("{wide}#pragma OPENCL FP_CONTRACT OFF\n\n")
    }

    fn qualifier(&self, _signature: &Signature) -> &'static str {
        "static inline "
    }

    fn vector(&self, n: usize, text: &Text) -> String {
        format!("{}{n}", self.number(text))
    }

    fn joined(&self, values: &[String], text: &Text) -> String {
        format!(
            "({})({})",
            self.vector(values.len(), text),
            values.join(", ")
        )
    }

    fn filled(&self, gives: Gives, text: &Text) -> Vec<(&'static str, String)> {
        filled_by(self, gives, text, ["", "*"])
    }

    fn fill(&self, name: &str, values: &[String], text: &Text) -> String {
        format!("*{name} = {};", self.joined(values, text))
    }

    fn word(&self, bits: u32) -> Option<&'static str> {
        Some(if bits <= 32 { "uint" } else { "ulong" })
    }

    fn cast(&self, kind: &str, value: &str) -> String {
        format!("({kind})({value})")
    }

    fn suffix(&self, text: &Text) -> &'static str {
        if text.double { "" } else { "f" }
    }

    fn not_a_number(&self, text: &Text) -> String {
        if text.double { "nan(0ul)" } else { "nan(0u)" }.to_owned()
    }

    // Its own functions drop a NaN, and may give the other one of two zeros.
    fn compares(&self, _text: &Text) -> bool {
        true
    }

    fn names(&self) -> Names {
        Names::C
    }

    fn unary(&self, operation: Unary, a: &Expression, text: &Text) -> Expression {
        by_exponent(self, operation, a, text)
    }
}
