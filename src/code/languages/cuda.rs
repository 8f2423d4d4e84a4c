//! CUDA C++.

use super::c::math;
use crate::code::dialect::{Dialect, Expression, Names, Signature, Text, by_exponent, filled_by};
use crate::code::interface::Gives;
use crate::number::graph::Unary;

/// CUDA.
pub struct Cuda;

impl Dialect for Cuda {
    fn name(&self) -> &'static str {
        "cuda"
    }

    fn title(&self) -> &'static str {
        "CUDA C++"
    }

    fn extension(&self) -> &'static str {
        "cuh"
    }

    fn promise(&self) -> &'static str {
        "The bits are those of the library with `-fmad=false` and without `--use_fast_math`."
    }

    fn has_double(&self) -> bool {
        true
    }

    fn reserved(&self) -> &'static [&'static str] {
        &[
            "main", "register", "auto", "union", "sizeof", "inline", "class", "template",
            "operator", "this", "new", "delete",
        ]
    }

    fn qualifier(&self, _signature: &Signature) -> &'static str {
        "__host__ __device__ inline "
    }

    fn vector(&self, n: usize, text: &Text) -> String {
        format!("{}{n}", self.number(text))
    }

    fn joined(&self, values: &[String], text: &Text) -> String {
        format!(
            "make_{}({})",
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
        Some(if bits <= 32 {
            "unsigned int"
        } else {
            "unsigned long long"
        })
    }

    fn cast(&self, kind: &str, value: &str) -> String {
        format!("({kind})({value})")
    }

    fn suffix(&self, text: &Text) -> &'static str {
        if text.double { "" } else { "f" }
    }

    fn not_a_number(&self, text: &Text) -> String {
        if text.double {
            "nan(\"\")"
        } else {
            "nanf(\"\")"
        }
        .to_owned()
    }

    // Its own functions drop a NaN, and may give the other one of two zeros.
    fn compares(&self, _text: &Text) -> bool {
        true
    }

    fn names(&self) -> Names {
        Names::C
    }

    fn called(&self, name: &str, text: &Text) -> String {
        math(name, text)
    }

    fn unary(&self, operation: Unary, a: &Expression, text: &Text) -> Expression {
        by_exponent(self, operation, a, text)
    }
}
