//! The array API standard: arrays of any library that keeps it, by functions of the arrays' own namespace.
//!
//! Nothing is imported: an array knows where its functions are. What the standard lacks, exponents and powers of two from
//! the bits, is a logarithm and a power here.

use super::numpy::Arrays;
use crate::code::dialect::Text;

/// The array API standard.
pub struct ArrayApi;

impl Arrays for ArrayApi {
    const NAME: &'static str = "array_api";
    const TITLE: &'static str = "Python array API standard";
    const MODULE: &'static str = "xp";
    const WIDTHS: [&'static str; 2] = ["xp.float32", "xp.float64"];
    const IMPORT: &'static str = "";
    const PROMISE: &'static str = "The bits are those of the library where each operation is rounded by itself, and powers of two are exact.";
    const AXIS: &'static str = "axis";
    const ARCTANGENT: &'static str = "atan2";
    // Before 2024 the standard has no choice between an array and a plain number.
    const NARROWS: bool = true;

    fn namespace(first: &str) -> Option<String> {
        Some(format!("xp = {first}.__array_namespace__()"))
    }

    fn take(name: &str, kind: &str) -> String {
        Self::cast(kind, name)
    }

    fn take_word(name: &str, kind: &str) -> String {
        Self::cast(kind, name)
    }

    fn cast(kind: &str, value: &str) -> String {
        format!("xp.astype({value}, {kind})")
    }

    fn word(bits: u32) -> Option<&'static str> {
        Some(match bits {
            0..=8 => "xp.uint8",
            9..=16 => "xp.uint16",
            17..=32 => "xp.uint32",
            _ => "xp.uint64",
        })
    }

    fn power_of_two(a: &str) -> String {
        format!("(2.0 ** ({a}))")
    }

    fn exponent(a: &str) -> String {
        format!("xp.floor(xp.log2({a}))")
    }

    fn constant(x: &str, text: &Text) -> String {
        let width = if text.double { "float64" } else { "float32" };
        format!("xp.asarray({x}, dtype=xp.{width})")
    }
}
