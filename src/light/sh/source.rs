//! A function on the sphere as source text of other languages, with its coefficients folded in: what a shader does with
//! an irradiance environment (Ramamoorthi and Hanrahan 2001).
//!
//! The sum is that of [`evaluate`](super::evaluate), term by term; the direction is of unit length already.

use super::basis::Basis;
use super::count::count;
use crate::code::{Argument, Function, Gives, Order, Program, wrapped};
use crate::error::{Error, expect_length};
use crate::number::graph::{Id, Style};
use crate::number::trace::{Trace, record};

/// The highest order that is printed: a hundred terms a channel are enough for any shader.
pub const HIGHEST_PRINTED: usize = 8;

/// The function of coefficients, one channel or three, or any number in Python's languages, as source text of a language of
/// [`crate::code`]: from a unit direction to its value. Names begin with `name`, and numbers have 64 bits if `double`.
///
/// # Errors
/// The coefficients are not those of an order up to [`HIGHEST_PRINTED`], or not finite; the language, or its numbers of 64 bits, do not
/// exist; a name that the language does not take.
///
/// ```
/// use spheremap::light::sh;
/// let text = sh::code(&[1.0, 0.0, 0.5, 0.0], 1, "glsl", "sky", false)?;
/// assert!(text.contains("float sky_evaluate(vec3 d) {"));
/// # Ok::<(), spheremap::Error>(())
/// ```
pub fn code(
    coefficients: &[f64],
    channels: usize,
    language: &str,
    name: &str,
    double: bool,
) -> Result<String, Error> {
    let order = Order::new(language, name, false, double)?;
    let highest = (coefficients.len() / channels.max(1)).isqrt().max(1) - 1;
    expect_length(
        "coefficients",
        coefficients.len(),
        count(highest) * channels,
    )?;
    if highest > HIGHEST_PRINTED {
        return Err(Error::Code(format!(
            "Expected `coefficients` up to order {HIGHEST_PRINTED}, got {highest}."
        )));
    }
    let printed = [1, 3].contains(&channels) || (channels > 0 && order.has_arrays());
    if !printed {
        return Err(Error::Code(format!(
            "Expected `coefficients` of one channel or three, in Python's languages of any number, got {channels}."
        )));
    }
    // A number of 32 bits may be too small for what one of 64 holds.
    let held = |c: &f64| c.is_finite() && (double || (*c as f32).is_finite());
    if !coefficients.iter().all(held) {
        return Err(Error::Code(
            "Expected `coefficients` that are finite numbers of the `dtype`.".to_owned(),
        ));
    }
    let program = program(coefficients, channels, highest, order.style);
    let mut about = vec![format!(
        "Spherical harmonics up to order {highest}, with coefficients folded in"
    )];
    about.extend(wrapped(
        "Source:",
        "Ramamoorthi and Hanrahan 2001, An Efficient Representation for Irradiance Environment Maps; the recurrence of \
         Holmes and Featherstone 2002.",
    ));
    about.extend(wrapped(
        "Directions:",
        "world directions of unit length, or near it; z is the polar axis of the basis.",
    ));
    about.extend(wrapped("Singular:", "nowhere: a polynomial of x, y and z."));
    let function = Function {
        name: "evaluate",
        doc: vec!["The value in a unit direction.".to_owned()],
        program,
    };
    order.text(about, &[function])
}

fn program(coefficients: &[f64], channels: usize, order: usize, style: Style) -> Program {
    let basis = Basis::new(order);
    let (graph, outputs) = record(style, || {
        let d = [0, 1, 2].map(Trace::input);
        let value = |channel: usize| {
            let own = coefficients[channel..].iter().step_by(channels);
            let own: Vec<f64> = own.copied().collect();
            basis.at(&own, d).id()
        };
        (0..channels).map(value).collect::<Vec<Id>>()
    });
    Program {
        takes: vec![Argument::DIRECTION],
        gives: if channels == 1 {
            Gives::Number
        } else {
            Gives::Vector(channels, "rgb")
        },
        nodes: graph.into_nodes(),
        outputs,
    }
}
