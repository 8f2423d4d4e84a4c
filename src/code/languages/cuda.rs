//! CUDA C++.

use super::c::{function, math};
use crate::code::dialect::{Dialect, Expression, Signature, Text, plain, prefix};
use crate::code::program::{Gives, Takes};
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

    fn checked(&self) -> &'static str {
        "a C++ compiler, as C++"
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

    fn columns(&self, _text: &Text) -> String {
        "void".to_owned()
    }

    fn open(&self, signature: &Signature, text: &Text) -> String {
        let line = crate::code::dialect::open(self, signature, text);
        if signature.gives == Gives::Columns && !matches!(signature.takes, Takes::Numbers(_)) {
            let of = self.vector(3, text);
            line.replacen(") {", &format!(", {of}* du, {of}* dv) {{"), 1)
        } else {
            line
        }
    }

    fn gives(&self, signature: &Signature, values: &[String], text: &Text) -> String {
        match signature.gives {
            Gives::Number | Gives::Truth => format!("return {};", values.concat()),
            Gives::Pair | Gives::Vector(_) => format!("return {};", self.joined(values, text)),
            Gives::Columns => {
                let [a, b] = [0, 3].map(|k| self.joined(&values[k..k + 3], text));
                format!("*du = {a};\n*dv = {b};")
            }
        }
    }

    fn literal(&self, x: f64, text: &Text) -> String {
        format!(
            "{}{}",
            plain(x, text.double),
            if text.double { "" } else { "f" }
        )
    }

    fn not_a_number(&self, text: &Text) -> String {
        if text.double {
            "nan(\"\")"
        } else {
            "nanf(\"\")"
        }
        .to_owned()
    }

    fn function(&self, operation: Unary, text: &Text) -> String {
        function(operation, text)
    }

    fn unary(&self, operation: Unary, a: &Expression, text: &Text) -> Expression {
        let number = self.number(text);
        match operation {
            Unary::PowerOfTwo => {
                let one = self.literal(1.0, text);
                Expression::atom(format!("{}({one}, (int)({}))", math("ldexp", text), a.text))
            }
            Unary::Exponent => {
                Expression::atom(format!("({number}){}({})", math("ilogb", text), a.text))
            }
            _ => prefix(self, operation, a, text),
        }
    }

    fn functions_of_two(&self, text: &Text) -> [String; 3] {
        ["fmin", "fmax", "atan2"].map(|name| math(name, text))
    }
}
