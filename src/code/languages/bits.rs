//! Powers of two and exponents from the bits of an f32, in languages that show them.

use crate::code::dialect::Expression;
use crate::number::graph::Unary;

/// 2ˣ and exponents from the bits of an f32, by these names of casts.
pub fn single(
    operation: Unary,
    a: &Expression,
    [integer, of_bits, to_bits, float]: [&str; 4],
) -> Option<Expression> {
    let a = &a.text;
    match operation {
        Unary::PowerOfTwo => Some(Expression::atom(format!(
            "{of_bits}(({integer}({a}) + 127) << 23)"
        ))),
        Unary::Exponent => Some(Expression::atom(format!(
            "{float}(({to_bits}({a}) >> 23) - 127)"
        ))),
        _ => None,
    }
}
