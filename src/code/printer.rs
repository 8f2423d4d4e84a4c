//! Graphs as statements: the same for every language.
//!
//! A value that is used once stands where it is used; one that is used again, or would make a line too long, gets a name.

use crate::code::dialect::{Dialect, Expression, Local, Signature, Text};
use crate::code::interface::{Gives, Kind, Program};
use crate::number::graph::{Binary, Comparison, Helper, Id, Logic, Node, Unary};

/// The most characters that an expression may have and still stand within another.
const LONG: usize = 72;

/// The most characters that a statement's expression has, where its parts can have names.
const LINE: usize = 84;

/// What is no longer than this gets no name for the sake of a line.
const SHORT: usize = 16;

/// The name of a shared function.
pub fn helper_name(prefix: &str, helper: Helper) -> String {
    let name = match helper {
        Helper::HalfTurns => "atan2_pi",
        Helper::SinCosPi => "sin_cos_pi",
        Helper::SinhCosh => "sinh_cosh",
        Helper::Asinh => "asinh",
        Helper::CubeRoot => "cbrt",
    };
    format!("{prefix}_{name}")
}

/// How often each node is written, 0 for those that no output is made of. What is compared and then chosen is written twice.
pub fn uses(program: &Program, compares: bool) -> Vec<u32> {
    let mut uses = vec![0_u32; program.nodes.len()];
    for &output in &program.outputs {
        uses[output as usize] += 1;
    }
    for (id, node) in program.nodes.iter().enumerate().rev() {
        if uses[id] > 0 {
            let twice = matches!(node, Node::Binary(Binary::Minimum | Binary::Maximum, ..));
            for operand in node.operands() {
                uses[operand as usize] += 1 + u32::from(twice && compares);
            }
        }
    }
    uses
}

/// The shared functions that a program calls.
pub fn helpers(program: &Program) -> impl Iterator<Item = Helper> {
    Helper::ALL.into_iter().filter(move |&helper| {
        has(
            program,
            |node| matches!(node, Node::Call(h, ..) if *h == helper),
        )
    })
}

/// Whether a program has a NaN.
pub fn has_nan(program: &Program) -> bool {
    has(
        program,
        |node| matches!(node, Node::Constant(bits) if f64::from_bits(*bits).is_nan()),
    )
}

/// Whether a program rounds a number to a whole one.
pub fn rounds(program: &Program) -> bool {
    has(program, |node| matches!(node, Node::Unary(Unary::Round, _)))
}

/// Whether some output is made of such a node.
fn has(program: &Program, such: impl Fn(&Node) -> bool) -> bool {
    let uses = uses(program, false);
    let mut nodes = program.nodes.iter().zip(uses);
    nodes.any(|(node, uses)| uses > 0 && such(node))
}

struct Printer<'a> {
    program: &'a Program,
    dialect: &'a dyn Dialect,
    text: &'a Text,
    signature: &'a Signature,
    made: Vec<Option<Expression>>,
    statements: Vec<String>,
    names: usize,
}

impl Printer<'_> {
    fn of(&self, id: Id) -> Expression {
        match &self.made[id as usize] {
            Some(expression) => expression.clone(),
            None => unreachable!("a node stands behind those that it is made of"),
        }
    }

    /// A number of all that the function takes.
    fn input(&self, mut number: usize) -> String {
        for argument in &self.signature.takes {
            if number < argument.width() {
                return self.dialect.argument(argument, number);
            }
            number -= argument.width();
        }
        unreachable!("a formula has the inputs that its signature says")
    }

    fn expression(&self, node: Node) -> Expression {
        let (dialect, text) = (self.dialect, self.text);
        match node {
            Node::Input(number) => Expression::atom(self.input(usize::from(number))),
            Node::Constant(bits) => {
                let x = f64::from_bits(bits);
                if x.is_nan() {
                    return Expression::atom(dialect.not_a_number(text));
                }
                let literal = Expression::constant(dialect.literal(x.abs(), text));
                if x.is_sign_negative() {
                    Expression {
                        is_constant: true,
                        ..dialect.unary(Unary::Negate, &literal, text)
                    }
                } else {
                    literal
                }
            }
            Node::Unary(operation, a) => dialect.unary(operation, &self.of(a), text),
            Node::Binary(operation, a, b) => {
                dialect.binary(operation, &self.of(a), &self.of(b), text)
            }
            Node::Select(condition, a, b) => {
                dialect.select(&self.of(condition), &self.of(a), &self.of(b), text)
            }
            Node::Truth(value) => {
                // A comparison that every language has, in place of its word for it.
                let [zero, one] = [0.0, 1.0].map(|x| Expression::atom(dialect.literal(x, text)));
                let comparison = Comparison::Less;
                if value {
                    dialect.compare(comparison, &zero, &one)
                } else {
                    dialect.compare(comparison, &one, &zero)
                }
            }
            Node::Compare(comparison, a, b) => {
                dialect.compare(comparison, &self.of(a), &self.of(b))
            }
            Node::Logic(Logic::And, a, b) => dialect.and(&self.of(a), &self.of(b)),
            Node::Logic(Logic::Or, a, b) => dialect.or(&self.of(a), &self.of(b)),
            Node::Not(a) => dialect.not(&self.of(a)),
            Node::Call(helper, ..) => {
                let argument = |id: Id| {
                    let argument = self.of(id);
                    if argument.is_constant {
                        dialect.typed(&argument.text, text)
                    } else {
                        argument.text
                    }
                };
                let arguments: Vec<_> = node.operands().map(argument).collect();
                let name = helper_name(&text.prefix, helper);
                Expression::atom(format!("{name}({})", arguments.join(", ")))
            }
            Node::Part(pair, number) => {
                Expression::atom(dialect.part(&self.of(pair).text, usize::from(number)))
            }
        }
    }

    /// The expression of a node, whose longest parts get names until it fits a line.
    fn short(&mut self, node: Node) -> Expression {
        loop {
            let expression = self.expression(node);
            if expression.text.len() <= LINE {
                return expression;
            }
            let size = |id: Id| self.of(id).text.len();
            let longest = node
                .operands()
                .max_by_key(|&id| size(id))
                .filter(|&id| size(id) > SHORT);
            let Some(longest) = longest else {
                return expression;
            };
            let value = self.of(longest).text;
            let part = self.program.nodes[longest as usize];
            self.made[longest as usize] = Some(self.named(part, &value));
        }
    }

    fn named(&mut self, node: Node, value: &str) -> Expression {
        let name = format!("t{}", self.names);
        self.names += 1;
        let local = if node.is_condition() {
            Local::Truth
        } else if node.is_pair() {
            Local::Pair
        } else {
            Local::Number
        };
        let statement = self.dialect.local(local, &name, value, self.text);
        self.statements.push(statement);
        Expression::atom(name)
    }
}

/// A function's text.
pub fn function(
    dialect: &dyn Dialect,
    text: &Text,
    signature: &Signature,
    program: &Program,
) -> String {
    let uses = uses(program, dialect.compares(text));
    let mut printer = Printer {
        program,
        dialect,
        text,
        signature,
        made: vec![None; program.nodes.len()],
        statements: Vec::new(),
        names: 0,
    };
    // What lies in the bits of a word is taken out first.
    for argument in &signature.takes {
        if let Kind::Word(words) = argument.kind {
            for (field, name) in argument.parts.iter().enumerate().take(words.fields) {
                let value = dialect.field(argument.name, words, field, text);
                let statement = dialect.local(Local::Number, name, &value, text);
                printer.statements.push(statement);
            }
        }
    }
    for (id, &node) in program.nodes.iter().enumerate() {
        if uses[id] == 0 {
            continue;
        }
        let expression = printer.short(node);
        // A sign before a name costs nothing to repeat.
        let plain = matches!(node, Node::Input(_) | Node::Constant(_) | Node::Part(..))
            || matches!(node, Node::Unary(Unary::Negate, _)) && expression.text.len() < 8;
        let result = dialect.names_results()
            && program.outputs.contains(&(id as Id))
            && !matches!(signature.gives, Gives::Truth);
        let apart = uses[id] > 1 || expression.text.len() > LONG || result;
        printer.made[id] = Some(if node.is_pair() || apart && !plain {
            printer.named(node, &expression.text)
        } else {
            expression
        });
    }
    let values: Vec<String> = program
        .outputs
        .iter()
        .map(|&id| printer.of(id).text)
        .collect();
    let mut lines: Vec<String> = signature
        .doc
        .iter()
        .map(|line| format!("{}{line}", dialect.comment()).trim_end().to_owned())
        .collect();
    lines.push(dialect.open(signature, text));
    lines.extend(printer.statements.iter().map(|line| format!("    {line}")));
    let gives = dialect.gives(signature, &values, text);
    lines.extend(gives.lines().map(|line| format!("    {line}")));
    let mut function = lines.join("\n");
    function.push('\n');
    function.push_str(dialect.close());
    function
}
