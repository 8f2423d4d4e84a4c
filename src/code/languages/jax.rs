//! JAX: the same under `jit`, `grad` and `vmap`.

use super::numpy::Arrays;
use crate::code::dialect::Text;

/// JAX.
pub struct Jax;

impl Arrays for Jax {
    const NAME: &'static str = "jax";
    const TITLE: &'static str = "JAX";
    const MODULE: &'static str = "jnp";
    const WIDTHS: [&'static str; 2] = ["jnp.float32", "jnp.float64"];
    const IMPORT: &'static str = "import jax.numpy as jnp";
    const PROMISE: &'static str = "Within a few units in the last place: the compiler contracts. Doubles want `jax_enable_x64`.";
    const AXIS: &'static str = "axis";

    fn word(bits: u32) -> Option<&'static str> {
        Some(if bits <= 32 {
            "jnp.uint32"
        } else {
            "jnp.uint64"
        })
    }

    fn typed(x: &str, text: &Text) -> String {
        format!(
            "jnp.asarray({x}, {})",
            Self::WIDTHS[usize::from(text.double)]
        )
    }

    fn power_of_two(a: &str) -> String {
        format!("jnp.ldexp(jnp.ones_like({a}), ({a}).astype(int))")
    }

    fn exponent(a: &str) -> String {
        format!("(jnp.frexp({a})[1] - 1).astype(({a}).dtype)")
    }
}
