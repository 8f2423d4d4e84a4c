//! PyTorch: the same on tensors, of any device.

use super::numpy::Arrays;
use crate::code::dialect::Text;

/// PyTorch.
pub struct Torch;

impl Arrays for Torch {
    const NAME: &'static str = "torch";
    const TITLE: &'static str = "PyTorch";
    const MODULE: &'static str = "torch";
    const WIDTHS: [&'static str; 2] = ["torch.float32", "torch.float64"];
    // `asarray` may detach, and warns where it does not.
    const TAKE: &'static str = "as_tensor";
    const CAST: &'static str = "to";
    const IMPORT: &'static str = "import torch";
    const PROMISE: &'static str = "Within a few units in the last place: its square root, and what is divided into a constant, are not rounded correctly.";
    const AXIS: &'static str = "dim";
    const ARCTANGENT: &'static str = "atan2";
    const NARROWS: bool = true;

    // Its unsigned numbers have no shifts.
    fn word(bits: u32) -> Option<&'static str> {
        (bits < 64).then_some("torch.int64")
    }

    fn power_of_two(a: &str) -> String {
        format!("torch.ldexp(torch.ones_like({a}), {a})")
    }

    fn exponent(a: &str) -> String {
        format!("(torch.frexp({a})[1] - 1).to(({a}).dtype)")
    }

    fn constant(x: &str, text: &Text) -> String {
        let width = if text.double { "float64" } else { "float32" };
        format!("torch.tensor({x}, dtype=torch.{width})")
    }
}
