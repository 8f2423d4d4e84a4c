//! NumPy: arrays of directions (…, 3) and of image coordinates (…, 2) or (…, 3).

use crate::code::dialect::{Dialect, Expression, Local, Names, Signature, Text, level, prefix};
use crate::code::interface::{Argument, Gives, Kind};
use crate::number::graph::Unary;

/// NumPy.
pub struct NumPy;

/// What the array languages of Python differ in.
pub trait Arrays: Sync {
    /// The name it is asked for by.
    const NAME: &'static str;
    /// Its full name.
    const TITLE: &'static str;
    /// What its functions begin with.
    const MODULE: &'static str;
    /// Its numbers of 32 and of 64 bits.
    const WIDTHS: [&'static str; 2];
    /// The line that brings it in.
    const IMPORT: &'static str;
    /// What is promised about bits.
    const PROMISE: &'static str;
    /// The function that takes what an argument is as an array.
    const TAKE: &'static str = "asarray";
    /// The method that makes an array of another type.
    const CAST: &'static str = "astype";
    /// The name of the axis that arrays are stacked along.
    const AXIS: &'static str;
    /// The name of the arctangent of two numbers.
    const ARCTANGENT: &'static str = "arctan2";

    /// Whether a plain number of a choice is rounded to 32 bits, whatever the other is.
    const NARROWS: bool = false;

    /// A first line that finds the functions, where they are not imported, from the first argument.
    fn namespace(_first: &str) -> Option<String> {
        None
    }

    /// An argument as an array of a type.
    fn take(name: &str, kind: &str) -> String {
        format!("{}.{}({name}, dtype={kind})", Self::MODULE, Self::TAKE)
    }

    /// A word that is given as an array of a type of words.
    fn take_word(name: &str, kind: &str) -> String {
        Self::cast(kind, &format!("{}.{}({name})", Self::MODULE, Self::TAKE))
    }

    /// An array as one of another type.
    fn cast(kind: &str, value: &str) -> String {
        // A call or a name takes the method as it is.
        let atom = value
            .chars()
            .all(|c| c.is_ascii_alphanumeric() || "._".contains(c))
            || value == format!("{}.{}(code)", Self::MODULE, Self::TAKE);
        let value = if atom {
            value.to_owned()
        } else {
            format!("({value})")
        };
        format!("{value}.{}({kind})", Self::CAST)
    }

    /// 2ˣ of a whole number.
    fn power_of_two(a: &str) -> String;

    /// The exponent of a number.
    fn exponent(a: &str) -> String;

    /// The type that holds words of so many bits.
    fn word(bits: u32) -> Option<&'static str>;

    /// A choice.
    fn choice(condition: &str, a: &str, b: &str, text: &Text) -> String {
        let module = Self::MODULE;
        // A choice between plain numbers has no width of its own.
        let known = |x: &str| x.parse::<f64>().is_ok() || x == format!("{module}.nan");
        let both = known(a) && known(b);
        let [a, b] = [a, b].map(|x| {
            if both || Self::NARROWS && known(x) {
                Self::constant(x, text)
            } else {
                x.to_owned()
            }
        });
        format!("{module}.where({condition}, {a}, {b})")
    }

    /// A number that a shared function compares: of a plain one Python makes a truth of its own, which `~` does not negate.
    fn typed(x: &str, text: &Text) -> String {
        Self::constant(x, text)
    }

    /// A number where a choice or a smaller or larger number wants an array.
    fn constant(x: &str, _text: &Text) -> String {
        x.to_owned()
    }
}

impl Arrays for NumPy {
    const NAME: &'static str = "numpy";
    const TITLE: &'static str = "NumPy";
    const MODULE: &'static str = "np";
    const WIDTHS: [&'static str; 2] = ["np.float32", "np.float64"];
    const IMPORT: &'static str = "import numpy as np";
    const PROMISE: &'static str = "The bits are those of the library.";
    const AXIS: &'static str = "axis";

    fn power_of_two(a: &str) -> String {
        format!("np.ldexp(np.ones_like({a}), ({a}).astype(np.int32))")
    }

    fn exponent(a: &str) -> String {
        format!("(np.frexp({a})[1] - 1).astype(({a}).dtype)")
    }

    fn word(bits: u32) -> Option<&'static str> {
        Some(match bits {
            0..=8 => "np.uint8",
            9..=16 => "np.uint16",
            17..=32 => "np.uint32",
            _ => "np.uint64",
        })
    }

    fn constant(x: &str, text: &Text) -> String {
        format!(
            "np.{}({x})",
            if text.double { "float64" } else { "float32" }
        )
    }
}

impl<A: Arrays> Dialect for A {
    fn name(&self) -> &'static str {
        A::NAME
    }

    fn title(&self) -> &'static str {
        A::TITLE
    }

    fn extension(&self) -> &'static str {
        "py"
    }

    fn promise(&self) -> &'static str {
        A::PROMISE
    }

    fn has_arrays(&self) -> bool {
        true
    }

    fn has_double(&self) -> bool {
        true
    }

    fn reserved(&self) -> &'static [&'static str] {
        &[
            "def", "lambda", "from", "import", "pass", "class", "is", "in", "np", "torch", "jnp",
            "None", "yield", "xp",
        ]
    }

    fn comment(&self) -> &'static str {
        "# "
    }

    fn prelude(&self, _text: &Text) -> String {
        if A::IMPORT.is_empty() {
            return String::new();
        }
        format!("{}\n\n\n", A::IMPORT)
    }

    fn vector(&self, _n: usize, _text: &Text) -> String {
        String::new()
    }

    fn number(&self, text: &Text) -> &'static str {
        if text.double {
            A::WIDTHS[1]
        } else {
            A::WIDTHS[0]
        }
    }

    fn word(&self, bits: u32) -> Option<&'static str> {
        A::word(bits)
    }

    fn cast(&self, kind: &str, value: &str) -> String {
        A::cast(kind, value)
    }

    fn whole(&self, n: u64) -> String {
        n.to_string()
    }

    fn not_a_number(&self, _text: &Text) -> String {
        format!("{}.nan", A::MODULE)
    }

    fn open(&self, signature: &Signature, text: &Text) -> String {
        let width = self.number(text);
        let names: Vec<_> = signature.takes.iter().map(|a| a.name).collect();
        let mut lines = vec![format!("def {}({}):", signature.name, names.join(", "))];
        if let Some(line) = A::namespace(names[0]) {
            lines.push(format!("    {line}"));
        }
        for argument in &signature.takes {
            let name = argument.name;
            if let Kind::Word(words) = argument.kind {
                let word = A::word(words.all()).unwrap_or_default();
                lines.push(format!("    {name} = {}", A::take_word(name, word)));
            }
            let Kind::Vector(n) = argument.kind else {
                continue;
            };
            let places: Vec<_> = (0..n).map(|k| format!("{name}[..., {k}]")).collect();
            lines.push(format!("    {name} = {}", A::take(name, width)));
            let parts = argument.parts[..n].join(", ");
            lines.push(format!("    {parts} = {}", places.join(", ")));
        }
        lines.join("\n")
    }

    fn argument(&self, argument: &Argument, number: usize) -> String {
        match argument.kind {
            Kind::Number => argument.name.to_owned(),
            Kind::Vector(_) | Kind::Word(_) => argument.parts[number].to_owned(),
        }
    }

    fn local(&self, _local: Local, name: &str, value: &str, text: &Text) -> String {
        // A choice between two of these has to know its width.
        if value.parse::<f64>().is_ok() {
            return format!("{name} = {}", A::constant(value, text));
        }
        format!("{name} = {value}")
    }

    fn gives(&self, signature: &Signature, values: &[String], text: &Text) -> String {
        let module = A::MODULE;
        // A constant, such as the face of a map of one, has the shape of what came in.
        let like = match signature.takes.first() {
            Some(argument) => self.argument(argument, 0),
            None => String::new(),
        };
        let shaped = |value: &String| {
            if value.parse::<f64>().is_ok() || value == &self.not_a_number(text) {
                format!("{module}.full_like({like}, {value})")
            } else {
                value.clone()
            }
        };
        let values: Vec<_> = values.iter().map(shaped).collect();
        let axis = A::AXIS;
        let stack =
            |values: &[String]| format!("{module}.stack([{}], {axis}=-1)", values.join(", "));
        match signature.gives {
            Gives::Number => format!("return {}", values.concat()),
            // A condition on constants is no array yet.
            Gives::Truth => format!("return ({}) & ({like} == {like})", values.concat()),
            Gives::Pair => format!("return {}", values.join(", ")),
            Gives::Word(words) => format!("return {}", self.word_of(&values, words)),
            Gives::Vector(..) => format!("return {}", stack(&values)),
            Gives::Taps { .. } => {
                let vectors: Vec<_> = values.chunks(4).map(stack).collect();
                format!("return {}", vectors.join(", "))
            }
            Gives::Columns => {
                format!(
                    "du = {}\ndv = {}\nreturn {module}.stack([du, dv], {axis}=-1)",
                    stack(&values[..3]),
                    stack(&values[3..])
                )
            }
        }
    }

    fn close(&self) -> &'static str {
        ""
    }

    fn component(&self, vector: &str, number: usize) -> String {
        format!("{vector}[{number}]")
    }

    fn names(&self) -> Names {
        Names {
            minimum: "minimum",
            maximum: "maximum",
            arctangent: A::ARCTANGENT,
            ..Names::SHADERS
        }
    }

    fn called(&self, name: &str, _text: &Text) -> String {
        format!("{}.{name}", A::MODULE)
    }

    fn unary(&self, operation: Unary, a: &Expression, text: &Text) -> Expression {
        match operation {
            Unary::PowerOfTwo => Expression::atom(A::power_of_two(&a.text)),
            Unary::Exponent => Expression::atom(A::exponent(&a.text)),
            _ => prefix(self, operation, a, text),
        }
    }

    // They keep a NaN of either operand.
    fn compares(&self, _text: &Text) -> bool {
        false
    }

    fn typed(&self, x: &str, text: &Text) -> String {
        A::typed(x, text)
    }

    fn and(&self, a: &Expression, b: &Expression) -> Expression {
        let text = format!("{} & {}", a.within(level::ATOM), b.within(level::ATOM));
        Expression::new(text, level::CHOICE)
    }

    fn or(&self, a: &Expression, b: &Expression) -> Expression {
        let text = format!("{} | {}", a.within(level::ATOM), b.within(level::ATOM));
        Expression::new(text, level::CHOICE)
    }

    fn not(&self, a: &Expression) -> Expression {
        Expression::new(format!("~{}", a.within(level::ATOM)), level::SIGN)
    }

    fn select(
        &self,
        condition: &Expression,
        a: &Expression,
        b: &Expression,
        text: &Text,
    ) -> Expression {
        Expression::atom(A::choice(&condition.text, &a.text, &b.text, text))
    }
}
