//! What languages differ in. Each is one file in `languages/` and one line of its registry.
//!
//! The defaults are those of C's family. A [`Dialect`] says how numbers, vectors and choices are written; which statements
//! there are, what is named and what stands within another expression is the business of [`crate::code::printer`], once
//! for all.

use crate::code::interface::{Argument, Gives, Kind, Words};
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
    pub takes: Vec<Argument>,
    /// What it gives.
    pub gives: Gives,
    /// What it is, in lines.
    pub doc: Vec<String>,
}

/// What a language calls the functions that languages call by different names.
#[derive(Clone, Copy, Debug)]
pub struct Names {
    /// |x|.
    pub absolute: &'static str,
    /// The nearest whole number, the even one of two.
    pub round: &'static str,
    /// The smaller of two numbers.
    pub minimum: &'static str,
    /// The larger of two numbers.
    pub maximum: &'static str,
    /// The angle of a point (x, y), of y and x.
    pub arctangent: &'static str,
}

impl Names {
    /// Of most shading languages.
    pub const SHADERS: Names = Names {
        absolute: "abs",
        round: "round",
        minimum: "min",
        maximum: "max",
        arctangent: "atan2",
    };

    /// Of `math.h`.
    pub const C: Names = Names {
        absolute: "fabs",
        round: "rint",
        minimum: "fmin",
        maximum: "fmax",
        arctangent: "atan2",
    };
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
    /// Whether some number is rounded to a whole one.
    pub rounds: bool,
    /// Whether some function takes or gives a word.
    pub words: bool,
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

    /// Whether it has numbers of 64 bits.
    fn has_double(&self) -> bool {
        false
    }

    /// Whether a vector is an axis of an array, of any length.
    fn has_arrays(&self) -> bool {
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

    /// What a constant ends in.
    fn suffix(&self, _text: &Text) -> &'static str {
        ""
    }

    /// A finite constant.
    fn literal(&self, x: f64, text: &Text) -> String {
        // The shortest decimal that reads as this number.
        let plain = if text.double {
            format!("{x:?}")
        } else {
            format!("{:?}", x as f32)
        };
        format!("{plain}{}", self.suffix(text))
    }

    /// Whether NaN can be written, so that operations on it give it again.
    fn has_nan(&self) -> bool {
        true
    }

    /// What is no number, or stands in its place.
    fn not_a_number(&self, text: &Text) -> String;

    /// What stands before the functions.
    fn prelude(&self, _text: &Text) -> String {
        String::new()
    }

    /// What begins a function's line of signature.
    fn qualifier(&self, _signature: &Signature) -> &'static str {
        ""
    }

    /// The type of an unsigned word of so many bits; nothing where there is none.
    fn word(&self, bits: u32) -> Option<&'static str> {
        (bits <= 32).then_some("uint")
    }

    /// A value as one of another type.
    fn cast(&self, kind: &str, value: &str) -> String {
        format!("{kind}({value})")
    }

    /// A whole number beside a word.
    fn whole(&self, n: u64) -> String {
        format!("{n}u")
    }

    /// One of the numbers in a word.
    fn field(&self, word: &str, words: Words, field: usize, text: &Text) -> String {
        if words.fields == 1 {
            return self.cast(self.number(text), word);
        }
        let mask = self.whole((1 << words.bits) - 1);
        let bits = match words.shift(field) {
            0 => format!("{word} & {mask}"),
            shift => format!("({word} >> {}) & {mask}", self.whole(u64::from(shift))),
        };
        self.cast(self.number(text), &bits)
    }

    /// Numbers as the word that they are in.
    fn word_of(&self, values: &[String], words: Words) -> String {
        let kind = self.word(words.all()).unwrap_or_default();
        let part = |(field, value): (usize, &String)| match words.shift(field) {
            0 => self.cast(kind, value),
            shift => format!(
                "({} << {})",
                self.cast(kind, value),
                self.whole(u64::from(shift))
            ),
        };
        let parts: Vec<_> = values.iter().enumerate().map(part).collect();
        parts.join(" | ")
    }

    /// The type of an argument.
    fn kind(&self, kind: Kind, text: &Text) -> String {
        match kind {
            Kind::Number => self.number(text).to_owned(),
            Kind::Vector(n) => self.vector(n, text),
            Kind::Word(words) => self.word(words.all()).unwrap_or_default().to_owned(),
        }
    }

    /// What a function takes, as its signature says it.
    fn parameter(&self, argument: &Argument, text: &Text) -> String {
        format!("{} {}", self.kind(argument.kind, text), argument.name)
    }

    /// What a function fills instead of returning it: the name and the parameter of each.
    fn filled(&self, gives: Gives, text: &Text) -> Vec<(&'static str, String)> {
        match gives {
            Gives::Taps { .. } => filled_by(self, gives, text, ["out ", ""]),
            _ => Vec::new(),
        }
    }

    /// The statements that fill it.
    fn fill(&self, name: &str, values: &[String], text: &Text) -> String {
        format!("{name} = {};", self.joined(values, text))
    }

    /// A function's beginning, through its opening brace.
    fn open(&self, signature: &Signature, text: &Text) -> String {
        let (arguments, gives) = outside(self, signature, text);
        let qualifier = self.qualifier(signature);
        format!("{qualifier}{gives} {}({arguments}) {{", signature.name)
    }

    /// The type of two directions; nothing where they are filled.
    fn columns(&self, _text: &Text) -> String {
        String::new()
    }

    /// Both directions.
    fn joined_columns(&self, values: &[String], text: &Text) -> String {
        format!("{}({})", self.columns(text), values.join(", "))
    }

    /// A number of a vector.
    fn component(&self, vector: &str, number: usize) -> String {
        format!("{vector}.{}", ["x", "y", "z", "w"][number])
    }

    /// A number that a function takes.
    fn argument(&self, argument: &Argument, number: usize) -> String {
        match argument.kind {
            Kind::Number => argument.name.to_owned(),
            Kind::Vector(_) => self.component(argument.name, number),
            Kind::Word(_) => argument.parts[number].to_owned(),
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

    /// The statements that give values.
    fn gives(&self, signature: &Signature, values: &[String], text: &Text) -> String {
        let filled = self.filled(signature.gives, text);
        if !filled.is_empty() {
            let parts = values.chunks(values.len() / filled.len());
            let fills = filled.iter().zip(parts);
            let fills: Vec<_> = fills
                .map(|((name, _), values)| self.fill(name, values, text))
                .collect();
            return fills.join("\n");
        }
        let value = match signature.gives {
            Gives::Number | Gives::Truth => values.concat(),
            Gives::Pair | Gives::Vector(..) => self.joined(values, text),
            Gives::Columns => self.joined_columns(values, text),
            Gives::Word(words) => self.word_of(values, words),
            Gives::Taps { .. } => String::new(),
        };
        format!("return {value};")
    }

    /// A function's end.
    fn close(&self) -> &'static str {
        "}\n"
    }

    /// One of the two numbers that a shared function gives.
    fn part(&self, pair: &str, number: usize) -> String {
        self.component(pair, number)
    }

    /// What its functions are called.
    fn names(&self) -> Names {
        Names::SHADERS
    }

    /// The name of a function as it is called in the width of a text.
    fn called(&self, name: &str, _text: &Text) -> String {
        name.to_owned()
    }

    /// The name of a function on one number.
    fn function(&self, operation: Unary, text: &Text) -> String {
        let name = match operation {
            Unary::Negate => "-",
            Unary::Absolute => self.names().absolute,
            Unary::Root => "sqrt",
            Unary::Floor => "floor",
            Unary::Round => self.names().round,
            Unary::PowerOfTwo => "exp2",
            Unary::Exponent => "exponent",
            Unary::Sine => "sin",
            Unary::Cosine => "cos",
            Unary::Sinh => "sinh",
            Unary::Cosh => "cosh",
        };
        self.called(name, text)
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

    /// An operation on two numbers.
    fn binary(&self, operation: Binary, a: &Expression, b: &Expression, text: &Text) -> Expression {
        let names = self.names();
        let infix = |sign: &str, level: u8| {
            let text = format!("{} {sign} {}", a.within(level), b.within(level + 1));
            Expression::new(text, level)
        };
        let call = |name: &str, a: &Expression, b: &Expression| {
            let name = self.called(name, text);
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
            Binary::Minimum => call(names.minimum, b, a),
            Binary::Maximum => call(names.maximum, b, a),
            Binary::Arctangent => call(names.arctangent, a, b),
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

/// What stands between the parentheses of a function, and the type before its name.
pub fn outside<D: Dialect + ?Sized>(
    dialect: &D,
    signature: &Signature,
    text: &Text,
) -> (String, String) {
    let filled = dialect.filled(signature.gives, text);
    let gives = match signature.gives {
        _ if !filled.is_empty() => "void".to_owned(),
        Gives::Number => dialect.number(text).to_owned(),
        Gives::Truth => dialect.truth().to_owned(),
        Gives::Pair => dialect.vector(2, text),
        Gives::Vector(n, _) => dialect.vector(n, text),
        Gives::Columns => dialect.columns(text),
        Gives::Word(words) => dialect.kind(Kind::Word(words), text),
        Gives::Taps { .. } => "void".to_owned(),
    };
    let takes = signature.takes.iter();
    let arguments: Vec<_> = takes
        .map(|argument| dialect.parameter(argument, text))
        .chain(filled.into_iter().map(|(_, parameter)| parameter))
        .collect();
    (arguments.join(", "), gives)
}

/// The names of several vectors that a function gives, and how many numbers each has.
pub fn several(gives: Gives) -> (&'static [&'static str], usize) {
    match gives {
        Gives::Columns => (&["du", "dv"], 3),
        Gives::Taps { apart: false } => (&["columns", "rows", "weights"], 4),
        Gives::Taps { apart: true } => (&["columns", "rows", "faces", "weights"], 4),
        _ => (&[], 0),
    }
}

/// Several vectors, each by a parameter whose type stands between these.
pub fn filled_by<D: Dialect + ?Sized>(
    dialect: &D,
    gives: Gives,
    text: &Text,
    [before, after]: [&str; 2],
) -> Vec<(&'static str, String)> {
    let (names, width) = several(gives);
    let of = dialect.vector(width, text);
    let parameter = |&name: &&'static str| (name, format!("{before}{of}{after} {name}"));
    names.iter().map(parameter).collect()
}

/// Powers of two and exponents by `ldexp` and `ilogb`, in languages that convert as C does.
pub fn by_exponent<D: Dialect + ?Sized>(
    dialect: &D,
    operation: Unary,
    a: &Expression,
    text: &Text,
) -> Expression {
    let called = |name| dialect.called(name, text);
    match operation {
        Unary::PowerOfTwo => {
            let (name, one) = (called("ldexp"), dialect.literal(1.0, text));
            Expression::atom(format!("{name}({one}, (int)({}))", a.text))
        }
        Unary::Exponent => {
            let (number, name) = (dialect.number(text), called("ilogb"));
            Expression::atom(format!("({number}){name}({})", a.text))
        }
        _ => prefix(dialect, operation, a, text),
    }
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
