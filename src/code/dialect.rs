//! What languages differ in. Each is one file in `languages/` and one line of its registry.
//!
//! The defaults are those of C's family. A [`Dialect`] says how numbers, vectors and choices are written; which statements
//! there are, what is named and what stands within another expression is the business of [`crate::code::printer`], once
//! for all.

use crate::code::program::{Gives, Takes};
use crate::number::graph::{Binary, Comparison, Unary};

/// How tightly an expression holds together; what holds less stands in parentheses.
pub mod level {
    /// `c ? a : b`.
    pub const CHOICE: u8 = 0;
    /// `a || b`.
    pub const OR: u8 = 1;
    /// `a && b`.
    pub const AND: u8 = 2;
    /// `a < b`.
    pub const COMPARISON: u8 = 3;
    /// `a + b`.
    pub const SUM: u8 = 4;
    /// `a * b`.
    pub const PRODUCT: u8 = 5;
    /// `-a`.
    pub const SIGN: u8 = 6;
    /// A name, a number, a call.
    pub const ATOM: u8 = 7;
}

/// A piece of text and how tightly it holds together.
#[derive(Clone, Debug)]
pub struct Expression {
    /// The text.
    pub text: String,
    /// One of [`level`].
    pub level: u8,
    /// Whether it is a number that is known.
    pub is_constant: bool,
}

impl Expression {
    /// What needs no parentheses anywhere.
    pub fn atom(text: impl Into<String>) -> Self {
        Expression {
            text: text.into(),
            level: level::ATOM,
            is_constant: false,
        }
    }

    /// A number that is known.
    pub fn constant(text: impl Into<String>) -> Self {
        Expression {
            is_constant: true,
            ..Expression::atom(text)
        }
    }

    /// Text of a level.
    pub fn new(text: impl Into<String>, level: u8) -> Self {
        Expression {
            text: text.into(),
            level,
            is_constant: false,
        }
    }

    /// The text where at least `level` is wanted.
    pub fn within(&self, level: u8) -> String {
        if self.level < level {
            format!("({})", self.text)
        } else {
            self.text.clone()
        }
    }
}

/// What a local name stands for.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Local {
    /// A number.
    Number,
    /// A condition.
    Truth,
    /// Two numbers.
    Pair,
}

/// A function's outside.
#[derive(Clone, Debug)]
pub struct Signature {
    /// Its name.
    pub name: String,
    /// What it takes.
    pub takes: Takes,
    /// What it gives.
    pub gives: Gives,
    /// What it is, in lines.
    pub doc: Vec<String>,
}

/// What the whole text agrees on.
#[derive(Clone, Debug)]
pub struct Text {
    /// What all names begin with.
    pub prefix: String,
    /// Numbers of 64 bits.
    pub double: bool,
    /// What the text is, in lines.
    pub header: Vec<String>,
    /// Whether some number is NaN.
    pub not_a_number: bool,
}

/// A language.
pub trait Dialect: Sync {
    /// The name that it is asked for by.
    fn name(&self) -> &'static str;

    /// Its full name.
    fn title(&self) -> &'static str;

    /// What files of it end in, without the dot.
    fn extension(&self) -> &'static str;

    /// What is promised about bits of `precision="exact"`, in one sentence.
    fn promise(&self) -> &'static str;

    /// What runs the printed text in the tests.
    fn checked(&self) -> &'static str {
        "nothing yet"
    }

    /// Whether it has numbers of 64 bits.
    fn has_double(&self) -> bool {
        false
    }

    /// Whether results are named before they are given: where a qualifier of the name keeps their bits.
    fn names_results(&self) -> bool {
        false
    }

    /// Words that a function cannot be called, beside those that no language takes.
    fn reserved(&self) -> &'static [&'static str] {
        &[]
    }

    /// What a line of a comment begins with.
    fn comment(&self) -> &'static str {
        "// "
    }

    /// The type of a number.
    fn number(&self, text: &Text) -> &'static str {
        if text.double { "double" } else { "float" }
    }

    /// The type of a condition.
    fn truth(&self) -> &'static str {
        "bool"
    }

    /// The type of `n` numbers.
    fn vector(&self, n: usize, text: &Text) -> String;

    /// A vector of these numbers.
    fn joined(&self, values: &[String], text: &Text) -> String {
        format!("{}({})", self.vector(values.len(), text), values.join(", "))
    }

    /// A finite constant.
    fn literal(&self, x: f64, text: &Text) -> String {
        plain(x, text.double)
    }

    /// What is no number.
    fn not_a_number(&self, text: &Text) -> String;

    /// What stands before the functions.
    fn prelude(&self, _text: &Text) -> String {
        String::new()
    }

    /// What begins a function's line of signature.
    fn qualifier(&self, _signature: &Signature) -> &'static str {
        ""
    }

    /// A function's beginning, through its opening brace.
    fn open(&self, signature: &Signature, text: &Text) -> String {
        open(self, signature, text)
    }

    /// The type of two directions.
    fn columns(&self, text: &Text) -> String;

    /// Both directions.
    fn joined_columns(&self, values: &[String], text: &Text) -> String {
        format!("{}({})", self.columns(text), values.join(", "))
    }

    /// A number that a function takes.
    fn argument(&self, signature: &Signature, number: usize) -> String {
        match signature.takes {
            Takes::Direction => format!("d.{}", ["x", "y", "z"][number]),
            Takes::Place(n) => format!("{}.{}", place_name(n), ["x", "y", "z"][number]),
            Takes::Numbers(n) => numbered(n).nth(number).unwrap_or_default().to_owned(),
        }
    }

    /// A name for a value.
    fn local(&self, local: Local, name: &str, value: &str, text: &Text) -> String {
        let kind = match local {
            Local::Number => self.number(text).to_owned(),
            Local::Truth => self.truth().to_owned(),
            Local::Pair => self.vector(2, text),
        };
        format!("{kind} {name} = {value};")
    }

    /// The statement that gives values.
    fn gives(&self, signature: &Signature, values: &[String], text: &Text) -> String {
        let value = match signature.gives {
            Gives::Number | Gives::Truth => values.concat(),
            Gives::Pair | Gives::Vector(_) => self.joined(values, text),
            Gives::Columns => self.joined_columns(values, text),
        };
        format!("return {value};")
    }

    /// A function's end.
    fn close(&self) -> &'static str {
        "}\n"
    }

    /// One of two numbers.
    fn part(&self, pair: &str, number: u8) -> String {
        format!("{pair}.{}", ["x", "y"][usize::from(number)])
    }

    /// The name of a function on one number.
    fn function(&self, operation: Unary, text: &Text) -> String {
        let _ = text;
        match operation {
            Unary::Negate => "-",
            Unary::Absolute => "abs",
            Unary::Root => "sqrt",
            Unary::Floor => "floor",
            Unary::Round => "roundEven",
            Unary::PowerOfTwo => "exp2",
            Unary::Exponent => "exponent",
            Unary::Sine => "sin",
            Unary::Cosine => "cos",
            Unary::Sinh => "sinh",
            Unary::Cosh => "cosh",
        }
        .to_owned()
    }

    /// An operation on one number.
    fn unary(&self, operation: Unary, a: &Expression, text: &Text) -> Expression {
        prefix(self, operation, a, text)
    }

    /// Whether the smaller and the larger of two numbers are chosen by a comparison: the language's own functions may
    /// drop a NaN.
    fn compares(&self, text: &Text) -> bool {
        text.not_a_number
    }

    /// A constant where a function wants what its other arguments are.
    fn typed(&self, x: &str, _text: &Text) -> String {
        x.to_owned()
    }

    /// The names of the smaller number, the larger one and the arctangent of two.
    fn functions_of_two(&self, text: &Text) -> [String; 3] {
        let _ = text;
        ["min", "max", "atan"].map(str::to_owned)
    }

    /// An operation on two numbers.
    fn binary(&self, operation: Binary, a: &Expression, b: &Expression, text: &Text) -> Expression {
        let [minimum, maximum, arctangent] = self.functions_of_two(text);
        let infix = |sign: &str, level: u8| {
            let text = format!("{} {sign} {}", a.within(level), b.within(level + 1));
            Expression::new(text, level)
        };
        let call = |name: &str, a: &Expression, b: &Expression| {
            let [a, b] = [a, b].map(|x| {
                if x.is_constant {
                    self.typed(&x.text, text)
                } else {
                    x.text.clone()
                }
            });
            Expression::atom(format!("{name}({a}, {b})"))
        };
        if matches!(operation, Binary::Minimum | Binary::Maximum) && self.compares(text) {
            let (low, high) = if operation == Binary::Minimum {
                (a, b)
            } else {
                (b, a)
            };
            let condition = self.compare(Comparison::Less, low, high);
            return self.select(&condition, a, b, text);
        }
        match operation {
            Binary::Add => infix("+", level::SUM),
            Binary::Subtract => infix("-", level::SUM),
            Binary::Multiply => infix("*", level::PRODUCT),
            Binary::Divide => infix("/", level::PRODUCT),
            Binary::Minimum => call(&minimum, b, a),
            Binary::Maximum => call(&maximum, b, a),
            Binary::Arctangent => call(&arctangent, a, b),
        }
    }

    /// A comparison.
    fn compare(&self, comparison: Comparison, a: &Expression, b: &Expression) -> Expression {
        let (sign, turned) = match comparison {
            Comparison::Less => ("<", ">"),
            Comparison::AtMost => ("<=", ">="),
            Comparison::Equal => ("==", "=="),
        };
        // A constant stands last.
        let (a, sign, b) = if a.is_constant {
            (b, turned, a)
        } else {
            (a, sign, b)
        };
        let text = format!("{} {sign} {}", a.within(level::SUM), b.within(level::SUM));
        Expression::new(text, level::COMPARISON)
    }

    /// Both conditions.
    fn and(&self, a: &Expression, b: &Expression) -> Expression {
        let text = format!("{} && {}", a.within(level::AND), b.within(level::AND));
        Expression::new(text, level::AND)
    }

    /// One condition or both. What is joined by "and" within gets parentheses, which compilers ask for.
    fn or(&self, a: &Expression, b: &Expression) -> Expression {
        let inside = |x: &Expression| {
            x.within(if x.level == level::AND {
                level::ATOM
            } else {
                level::OR
            })
        };
        Expression::new(format!("{} || {}", inside(a), inside(b)), level::OR)
    }

    /// The opposite condition.
    fn not(&self, a: &Expression) -> Expression {
        Expression::new(format!("!{}", a.within(level::ATOM)), level::SIGN)
    }

    /// One number or another.
    fn select(
        &self,
        condition: &Expression,
        a: &Expression,
        b: &Expression,
        _text: &Text,
    ) -> Expression {
        let condition = condition.within(level::OR);
        let text = format!(
            "{condition} ? {} : {}",
            a.within(level::SUM),
            b.within(level::CHOICE)
        );
        Expression::new(text, level::CHOICE)
    }
}

/// A function's line of signature in C's family.
pub fn open<D: Dialect + ?Sized>(dialect: &D, signature: &Signature, text: &Text) -> String {
    let arguments = match signature.takes {
        Takes::Direction => format!("{} d", dialect.vector(3, text)),
        Takes::Place(n) => format!("{} {}", dialect.vector(n, text), place_name(n)),
        Takes::Numbers(n) => numbered(n)
            .map(|name| format!("{} {name}", dialect.number(text)))
            .collect::<Vec<_>>()
            .join(", "),
    };
    let gives = match signature.gives {
        Gives::Number => dialect.number(text).to_owned(),
        Gives::Truth => dialect.truth().to_owned(),
        Gives::Pair => dialect.vector(2, text),
        Gives::Vector(n) => dialect.vector(n, text),
        Gives::Columns => dialect.columns(text),
    };
    let qualifier = dialect.qualifier(signature);
    format!("{qualifier}{gives} {}({arguments}) {{", signature.name)
}

/// A sign, or a function of one number.
pub fn prefix<D: Dialect + ?Sized>(
    dialect: &D,
    operation: Unary,
    a: &Expression,
    text: &Text,
) -> Expression {
    if operation == Unary::Negate {
        Expression::new(format!("-{}", a.within(level::ATOM)), level::SIGN)
    } else {
        Expression::atom(format!("{}({})", dialect.function(operation, text), a.text))
    }
}

/// The name of image coordinates.
pub fn place_name(numbers: usize) -> &'static str {
    if numbers == 2 { "uv" } else { "uvf" }
}

/// The names of plain numbers.
pub fn numbered(n: usize) -> impl Iterator<Item = &'static str> {
    let names: &[&str] = if n == 2 { &["y", "x"] } else { &["x"] };
    names.iter().copied()
}

/// The shortest decimal that reads as this number.
pub fn plain(x: f64, double: bool) -> String {
    if double {
        format!("{x:?}")
    } else {
        format!("{:?}", x as f32)
    }
}
