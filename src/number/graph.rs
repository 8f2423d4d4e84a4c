//! A formula as a graph: what the recording number of [`crate::number::trace`] writes and printers of languages read.
//!
//! Nodes are made once: the same operation on the same operands is the same node, so common subexpressions cost nothing to
//! find. Operations are simplified as they are made, and only where that keeps every bit of the result for every number
//! but the payload of a NaN: constants are computed in the type that is recorded, signs move outward, choices between
//! equals and by known conditions disappear. `x + 0` stays, because -0 + 0 is 0; `x · 0` stays, because of infinity.
//!
//! A smaller and a larger number of two have nodes of their own: every language has them in one instruction.

use std::collections::HashMap;

/// A node's number.
pub type Id = u32;

/// An operation on one number.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Unary {
    /// -x.
    Negate,
    /// |x|.
    Absolute,
    /// √x.
    Root,
    /// The largest whole number not above x.
    Floor,
    /// The nearest whole number, the even one of two.
    Round,
    /// 2ˣ of a whole number.
    PowerOfTwo,
    /// The exponent of the power of two not above a positive normal number.
    Exponent,
    /// The language's own sine.
    Sine,
    /// The language's own cosine.
    Cosine,
    /// The language's own hyperbolic sine.
    Sinh,
    /// The language's own hyperbolic cosine.
    Cosh,
}

/// An operation on two numbers.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Binary {
    /// a + b.
    Add,
    /// a - b.
    Subtract,
    /// a · b.
    Multiply,
    /// a / b.
    Divide,
    /// a if a < b, else b.
    Minimum,
    /// a if a > b, else b.
    Maximum,
    /// The language's own atan2(a, b).
    Arctangent,
}

/// A function that the formulas share: printed once, and called.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub enum Helper {
    /// atan2(a, b)/π for a ≥ 0.
    HalfTurns,
    /// (sin πa, cos πa).
    SinCosPi,
    /// (sinh a, cosh a).
    SinhCosh,
    /// asinh a.
    Asinh,
    /// The cube root of a > 0.
    CubeRoot,
}

impl Helper {
    /// All of them.
    pub const ALL: [Helper; 5] = [
        Helper::HalfTurns,
        Helper::SinCosPi,
        Helper::SinhCosh,
        Helper::Asinh,
        Helper::CubeRoot,
    ];

    /// How many numbers it takes.
    pub fn arguments(self) -> usize {
        if self == Helper::HalfTurns { 2 } else { 1 }
    }

    /// How many numbers it gives.
    pub fn results(self) -> usize {
        match self {
            Helper::SinCosPi | Helper::SinhCosh => 2,
            Helper::HalfTurns | Helper::Asinh | Helper::CubeRoot => 1,
        }
    }
}

/// A comparison of two numbers.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Comparison {
    /// a < b.
    Less,
    /// a ≤ b.
    AtMost,
    /// a = b.
    Equal,
}

/// What joins two conditions.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Logic {
    /// Both.
    And,
    /// One or both.
    Or,
}

/// A node: an operation on nodes that were made before it.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Node {
    /// An argument of the function.
    Input(u8),
    /// A number, as the bits of the double that it is.
    Constant(u64),
    /// An operation on one number.
    Unary(Unary, Id),
    /// An operation on two numbers.
    Binary(Binary, Id, Id),
    /// The first number where the condition holds, else the second.
    Select(Id, Id, Id),
    /// A shared function of one or two numbers; of one, both operands are it.
    Call(Helper, Id, Id),
    /// The first or second number of a call that gives two.
    Part(Id, u8),
    /// A condition known beforehand.
    Truth(bool),
    /// A condition on two numbers.
    Compare(Comparison, Id, Id),
    /// Two conditions joined.
    Logic(Logic, Id, Id),
    /// The opposite condition.
    Not(Id),
}

impl Node {
    /// Whether it is a condition and no number.
    pub fn is_condition(self) -> bool {
        matches!(
            self,
            Node::Truth(_) | Node::Compare(..) | Node::Logic(..) | Node::Not(_)
        )
    }

    /// Whether it is two numbers.
    pub fn is_pair(self) -> bool {
        matches!(self, Node::Call(helper, ..) if helper.results() == 2)
    }

    /// The nodes that it is made of.
    pub fn operands(self) -> impl Iterator<Item = Id> {
        let [a, b, c] = match self {
            Node::Input(_) | Node::Constant(_) | Node::Truth(_) => [None; 3],
            Node::Unary(_, a) | Node::Not(a) | Node::Part(a, _) => [Some(a), None, None],
            Node::Call(helper, a, _) if helper.arguments() == 1 => [Some(a), None, None],
            Node::Call(_, a, b)
            | Node::Binary(_, a, b)
            | Node::Compare(_, a, b)
            | Node::Logic(_, a, b) => [Some(a), Some(b), None],
            Node::Select(a, b, c) => [Some(a), Some(b), Some(c)],
        };
        [a, b, c].into_iter().flatten()
    }
}

/// How wide the numbers of a graph are, and whose functions it uses.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Style {
    /// f64 rather than f32.
    pub double: bool,
    /// The language's own sine, arctangent and so on, rather than the library's polynomials.
    pub native: bool,
    /// Shared functions are written out rather than called: in their own bodies.
    pub inside: bool,
}

/// A graph while it grows.
#[derive(Debug)]
pub struct Graph {
    style: Style,
    nodes: Vec<Node>,
    known: HashMap<Node, Id>,
}

impl Graph {
    /// One without nodes.
    pub fn new(style: Style) -> Self {
        Graph {
            style,
            nodes: Vec::new(),
            known: HashMap::new(),
        }
    }

    /// How wide its numbers are, and whose functions it uses.
    pub fn style(&self) -> Style {
        self.style
    }

    /// The nodes, each behind those that it is made of.
    pub fn into_nodes(self) -> Vec<Node> {
        self.nodes
    }

    /// The node of an operation as it is.
    pub fn node(&mut self, node: Node) -> Id {
        if let Some(&id) = self.known.get(&node) {
            return id;
        }
        let id = self.nodes.len() as Id;
        self.nodes.push(node);
        self.known.insert(node, id);
        id
    }

    /// A constant, rounded to the width of the graph.
    pub fn constant(&mut self, x: f64) -> Id {
        let x = self.rounded(x);
        // Every NaN is one node.
        let x = if x.is_nan() { f64::NAN } else { x };
        self.node(Node::Constant(x.to_bits()))
    }

    fn rounded(&self, x: f64) -> f64 {
        if self.style.double {
            x
        } else {
            f64::from(x as f32)
        }
    }

    fn at(&self, id: Id) -> Node {
        self.nodes[id as usize]
    }

    fn known_number(&self, id: Id) -> Option<f64> {
        match self.at(id) {
            Node::Constant(bits) => Some(f64::from_bits(bits)),
            _ => None,
        }
    }

    /// Whether it is known to be no number.
    pub fn is_nan(&self, id: Id) -> bool {
        self.known_number(id).is_some_and(f64::is_nan)
    }

    fn known_truth(&self, id: Id) -> Option<bool> {
        match self.at(id) {
            Node::Truth(value) => Some(value),
            _ => None,
        }
    }

    fn negated(&self, id: Id) -> Option<Id> {
        match self.at(id) {
            Node::Unary(Unary::Negate, a) => Some(a),
            _ => None,
        }
    }

    /// Whether two numbers compare as each other's opposite.
    fn opposite(&self, a: Id, b: Id) -> bool {
        match (self.known_number(a), self.known_number(b)) {
            (Some(x), Some(y)) => x == -y,
            _ => self.negated(a) == Some(b) || self.negated(b) == Some(a),
        }
    }

    /// Of a choice between -1 and 1: the condition on which it is -1.
    fn sign(&self, id: Id) -> Option<Id> {
        let Node::Select(condition, a, b) = self.at(id) else {
            return None;
        };
        (self.known_number(a) == Some(-1.0) && self.known_number(b) == Some(1.0))
            .then_some(condition)
    }

    /// An operation on one number.
    pub fn unary(&mut self, operation: Unary, a: Id) -> Id {
        if let Some(x) = self.known_number(a)
            && let Some(x) = computed(operation, x, self.style.double)
        {
            return self.constant(x);
        }
        match (operation, self.at(a)) {
            (Unary::Negate, Node::Unary(Unary::Negate, x)) => x,
            (Unary::Absolute, Node::Unary(Unary::Negate, x)) => self.unary(Unary::Absolute, x),
            (Unary::Absolute, Node::Unary(Unary::Absolute, _)) => a,
            // A number or its opposite has one size.
            (Unary::Absolute, Node::Select(_, x, y))
                if self.negated(x) == Some(y) || self.negated(y) == Some(x) =>
            {
                let x = self.negated(x).unwrap_or(x);
                self.unary(Unary::Absolute, x)
            }
            _ => self.node(Node::Unary(operation, a)),
        }
    }

    /// An operation on two numbers.
    pub fn binary(&mut self, operation: Binary, a: Id, b: Id) -> Id {
        let (x, y) = (self.known_number(a), self.known_number(b));
        if let (Some(x), Some(y)) = (x, y)
            && let Some(result) = folded(operation, x, y, self.style.double)
        {
            return self.constant(result);
        }
        match operation {
            Binary::Add => {
                if let Some(b) = self.negated(b) {
                    return self.binary(Binary::Subtract, a, b);
                }
                if let Some(a) = self.negated(a) {
                    return self.binary(Binary::Subtract, b, a);
                }
                for (known, other) in [(x, b), (y, a)] {
                    if let Some(known) = known.filter(|known| *known < 0.0) {
                        let opposite = self.constant(-known);
                        return self.binary(Binary::Subtract, other, opposite);
                    }
                }
            }
            Binary::Subtract => {
                if y.is_some_and(|y| y == 0.0 && y.is_sign_positive()) {
                    return a;
                }
                if let Some(b) = self.negated(b) {
                    return self.binary(Binary::Add, a, b);
                }
                if let Some(y) = y.filter(|y| *y < 0.0) {
                    let opposite = self.constant(-y);
                    return self.binary(Binary::Add, a, opposite);
                }
            }
            Binary::Multiply => {
                for (known, other) in [(x, b), (y, a)] {
                    if known == Some(1.0) {
                        return other;
                    }
                    if known == Some(-1.0) {
                        return self.unary(Unary::Negate, other);
                    }
                }
                // A factor of ±1 is a choice of sign.
                for (factor, other) in [(a, b), (b, a)] {
                    if let Some(condition) = self.sign(factor) {
                        let opposite = self.unary(Unary::Negate, other);
                        return self.select(condition, opposite, other);
                    }
                }
                if let Some(product) = self.signs_outside(operation, a, b) {
                    return product;
                }
            }
            Binary::Divide => {
                if y == Some(1.0) {
                    return a;
                }
                if let Some(quotient) = self.signs_outside(operation, a, b) {
                    return quotient;
                }
            }
            Binary::Minimum | Binary::Maximum | Binary::Arctangent => {}
        }
        let (a, b) = if matches!(operation, Binary::Add | Binary::Multiply) && self.later(a, b) {
            (b, a)
        } else {
            (a, b)
        };
        self.node(Node::Binary(operation, a, b))
    }

    /// Whether two operands whose order does not matter should change places: constants stand last in a sum and first in a
    /// product alike, so that what is the same is one node.
    fn later(&self, a: Id, b: Id) -> bool {
        let constant = |id| self.known_number(id).is_some();
        (constant(a), a) > (constant(b), b)
    }

    /// A product or quotient with the signs of its operands outside: rounding is the same for both signs.
    fn signs_outside(&mut self, operation: Binary, a: Id, b: Id) -> Option<Id> {
        let (p, q) = (self.negated(a), self.negated(b));
        if p.is_none() && q.is_none() {
            return None;
        }
        let result = self.binary(operation, p.unwrap_or(a), q.unwrap_or(b));
        if p.is_some() && q.is_some() {
            Some(result)
        } else {
            Some(self.unary(Unary::Negate, result))
        }
    }

    /// A comparison.
    pub fn compare(&mut self, comparison: Comparison, a: Id, b: Id) -> Id {
        if let (Some(x), Some(y)) = (self.known_number(a), self.known_number(b)) {
            let holds = match comparison {
                Comparison::Less => x < y,
                Comparison::AtMost => x <= y,
                Comparison::Equal => x == y,
            };
            return self.node(Node::Truth(holds));
        }
        // A sign moves to the constant: -a < c is -c < a.
        for (number, other, flipped) in [(a, b, false), (b, a, true)] {
            if let (Some(number), Some(constant)) = (self.negated(number), self.known_number(other))
            {
                // Zeros of both signs compare alike.
                let constant = self.constant(0.0 - constant);
                return if flipped {
                    self.compare(comparison, number, constant)
                } else {
                    self.compare(comparison, constant, number)
                };
            }
        }
        // A choice among constants, such as a face's number, is taken apart into its conditions.
        for (choice, other, flipped) in [(a, b, false), (b, a, true)] {
            if let Node::Select(condition, x, y) = self.at(choice)
                && self.known_number(other).is_some()
                && self.chooses_constants(choice)
            {
                let [on, off] = [x, y].map(|arm| {
                    if flipped {
                        self.compare(comparison, other, arm)
                    } else {
                        self.compare(comparison, arm, other)
                    }
                });
                return self.choose_truth(condition, on, off);
            }
        }
        self.node(Node::Compare(comparison, a, b))
    }

    fn chooses_constants(&self, id: Id) -> bool {
        match self.at(id) {
            Node::Constant(_) => true,
            Node::Select(_, a, b) => self.chooses_constants(a) && self.chooses_constants(b),
            _ => false,
        }
    }

    /// One condition or another.
    pub fn choose_truth(&mut self, condition: Id, on: Id, off: Id) -> Id {
        if on == off {
            return on;
        }
        let both = self.logic(Logic::And, condition, on);
        let opposite = self.not(condition);
        let neither = self.logic(Logic::And, opposite, off);
        match (self.known_truth(on), self.known_truth(off)) {
            (Some(true), _) => self.logic(Logic::Or, condition, off),
            (_, Some(true)) => self.logic(Logic::Or, opposite, on),
            _ => self.logic(Logic::Or, both, neither),
        }
    }

    /// Two conditions joined.
    pub fn logic(&mut self, logic: Logic, a: Id, b: Id) -> Id {
        // What decides the whole, whatever the other is.
        let decisive = logic == Logic::Or;
        for (known, other) in [(a, b), (b, a)] {
            if let Some(value) = self.known_truth(known) {
                return if value == decisive { known } else { other };
            }
        }
        if a == b {
            return a;
        }
        let (a, b) = if a > b { (b, a) } else { (a, b) };
        self.node(Node::Logic(logic, a, b))
    }

    /// The opposite condition.
    pub fn not(&mut self, a: Id) -> Id {
        match self.at(a) {
            Node::Truth(value) => self.node(Node::Truth(!value)),
            Node::Not(a) => a,
            _ => self.node(Node::Not(a)),
        }
    }

    /// One number or another.
    pub fn select(&mut self, condition: Id, a: Id, b: Id) -> Id {
        if let Some(value) = self.known_truth(condition) {
            return if value { a } else { b };
        }
        if a == b {
            return a;
        }
        match self.at(condition) {
            Node::Not(condition) => return self.select(condition, b, a),
            Node::Compare(Comparison::Less, x, y) if (x, y) == (a, b) => {
                return self.binary(Binary::Minimum, a, b);
            }
            Node::Compare(Comparison::Less, y, x) if (x, y) == (a, b) => {
                return self.binary(Binary::Maximum, a, b);
            }
            // x < y is -y < -x, whichever way the comparison is written.
            Node::Compare(Comparison::Less, x, y) if self.opposite(x, a) && self.opposite(y, b) => {
                return self.binary(Binary::Maximum, a, b);
            }
            Node::Compare(Comparison::Less, x, y) if self.opposite(y, a) && self.opposite(x, b) => {
                return self.binary(Binary::Minimum, a, b);
            }
            _ => {}
        }
        // The same condition was asked before.
        if let Node::Select(before, a, _) = self.at(a)
            && before == condition
        {
            return self.select(condition, a, b);
        }
        if let Node::Select(before, _, b) = self.at(b)
            && before == condition
        {
            return self.select(condition, a, b);
        }
        self.node(Node::Select(condition, a, b))
    }
}

/// f(x) in f64 or f32, for what every language computes alike.
fn computed(operation: Unary, x: f64, double: bool) -> Option<f64> {
    let root = |x: f64| {
        if double {
            x.sqrt()
        } else {
            f64::from((x as f32).sqrt())
        }
    };
    match operation {
        Unary::Negate => Some(-x),
        Unary::Absolute => Some(x.abs()),
        Unary::Root => Some(root(x)),
        Unary::Floor => Some(x.floor()),
        Unary::Round => Some(x.round_ties_even()),
        Unary::PowerOfTwo => Some(x.exp2()),
        Unary::Exponent | Unary::Sine | Unary::Cosine | Unary::Sinh | Unary::Cosh => None,
    }
}

/// a ∘ b in f64 or f32, for what every language computes alike.
fn folded(operation: Binary, a: f64, b: f64, double: bool) -> Option<f64> {
    let (p, q) = (a as f32, b as f32);
    let of = |wide: f64, narrow: f32| Some(if double { wide } else { f64::from(narrow) });
    match operation {
        Binary::Add => of(a + b, p + q),
        Binary::Subtract => of(a - b, p - q),
        Binary::Multiply => of(a * b, p * q),
        Binary::Divide => of(a / b, p / q),
        Binary::Minimum => Some(if a < b { a } else { b }),
        Binary::Maximum => Some(if a > b { a } else { b }),
        Binary::Arctangent => None,
    }
}
