//! What a formula is written in: the trait of numbers, the functions they share, dual numbers.

pub mod dual;
pub mod math;
pub mod real;
