//! OpenCL C.

use crate::code::dialect::{Dialect, Expression, Signature, Text, plain, prefix};
use crate::code::program::Gives;
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

    fn checked(&self) -> &'static str {
        "OpenCL (pocl), by `make test-languages`"
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

    fn columns(&self, _text: &Text) -> String {
        "void".to_owned()
    }

    fn open(&self, signature: &Signature, text: &Text) -> String {
        let line = crate::code::dialect::open(self, signature, text);
        if signature.gives == Gives::Columns {
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
        if text.double { "nan(0ul)" } else { "nan(0u)" }.to_owned()
    }

    fn function(&self, operation: Unary, _text: &Text) -> String {
        match operation {
            Unary::Absolute => "fabs",
            Unary::Floor => "floor",
            Unary::Round => "rint",
            Unary::Sine => "sin",
            Unary::Cosine => "cos",
            Unary::Sinh => "sinh",
            Unary::Cosh => "cosh",
            _ => "sqrt",
        }
        .to_owned()
    }

    fn unary(&self, operation: Unary, a: &Expression, text: &Text) -> Expression {
        let number = self.number(text);
        match operation {
            Unary::PowerOfTwo => {
                let one = self.literal(1.0, text);
                Expression::atom(format!("ldexp({one}, (int)({}))", a.text))
            }
            Unary::Exponent => Expression::atom(format!("({number})ilogb({})", a.text)),
            _ => prefix(self, operation, a, text),
        }
    }

    fn functions_of_two(&self, _text: &Text) -> [String; 3] {
        ["fmin", "fmax", "atan2"].map(str::to_owned)
    }
}
