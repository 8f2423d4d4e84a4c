//! What a formula is written in: the trait of numbers, the functions they share, dual numbers, and numbers
//! that record.

pub mod angle;
pub mod dual;
pub mod graph;
pub mod math;
pub mod real;
pub mod trace;
