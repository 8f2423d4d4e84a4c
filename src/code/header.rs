//! What the text says about itself: source, frame, ranges, singular points, bounds.

use crate::code::dialect::Dialect;
use crate::code::options::CodeOptions;
use crate::map::Map;
use crate::number::graph::Helper;

/// Words in lines of at most so many characters, the later ones indented.
pub(crate) fn wrapped(label: &str, words: &str) -> Vec<String> {
    const WIDTH: usize = 96;
    let mut lines = vec![label.to_owned()];
    for word in words.split_whitespace() {
        let line = lines.last().map(String::len).unwrap_or_default();
        match lines.last_mut() {
            Some(last) if line + 1 + word.len() <= WIDTH => {
                if !last.ends_with(' ') {
                    last.push(' ');
                }
                last.push_str(word);
            }
            _ => lines.push(format!("  {word}")),
        }
    }
    lines
}

/// The lines at the top of a text.
pub fn lines(map: &Map, options: &CodeOptions<'_>) -> Vec<String> {
    let info = map.info();
    let mut name = info.name.to_owned();
    let parameters: Vec<String> = info
        .parameters
        .iter()
        .zip(map.parameters())
        .map(|(parameter, value)| format!("{}={value}", parameter.name))
        .collect();
    if !parameters.is_empty() {
        name = format!("{name}({})", parameters.join(", "));
    }
    if let Some(convention) = map.convention() {
        name = format!("{name}:{convention}");
    }
    let mut lines = vec![format!("{}: {name}", info.title)];
    let mut say = |label: &str, words: &str| lines.extend(wrapped(label, words));
    say("Source:", info.source);
    say(
        "Directions:",
        &format!(
            "axes \"{}\", the world axes that point right, down and forward in the image; unit length, or near it.",
            map.axes()
        ),
    );
    if map.pose().is_some() {
        say("Turned:", "the map's rotation is folded in.");
    }
    if map.uv_width() > 2 {
        say(
            "Image:",
            &format!(
                "u right, v down, each in [0, 1] on its face; {} faces, numbered from 0.",
                map.faces()
            ),
        );
    } else if let Some(layout) = map.layout() {
        say(
            "Image:",
            &format!("u right, v down, each in [0, 1] on the image of layout \"{layout}\"."),
        );
    } else {
        say("Image:", "u right, v down, each in [0, 1].");
    }
    say("Singular:", info.singular);
    let (single, double) = info.round_trip;
    let bound = if options.double { double } else { single };
    // A language's own functions may be looser than what the claim was measured with.
    let by = if options.native {
        ", by the functions of precision \"exact\""
    } else {
        ""
    };
    say(
        "Bound:",
        &format!(
            "a direction and what comes back of it through the image are within {bound:e} radians, at default parameters{by}."
        ),
    );
    lines
}

/// The last lines at the top of every text: whose functions, and who wrote it.
pub fn colophon(dialect: &dyn Dialect, native: bool) -> Vec<String> {
    let functions = if native {
        format!("those of {}, with its own bounds.", dialect.title())
    } else {
        format!("polynomials with stated bounds. {}", dialect.promise())
    };
    let mut lines = wrapped("Functions:", &functions);
    lines.push(format!(
        "Written by spheremap {} for {}.",
        env!("CARGO_PKG_VERSION"),
        dialect.title()
    ));
    lines
}

/// What a shared function is.
pub fn of_helper(helper: Helper) -> &'static str {
    match helper {
        Helper::HalfTurns => "atan2(y, x) / pi for y >= 0: 0 to 1.",
        Helper::SinCosPi => "(sin(pi x), cos(pi x)).",
        Helper::SinhCosh => "(sinh(x), cosh(x)).",
        Helper::Asinh => "asinh(x).",
        Helper::CubeRoot => "The cube root of x > 0.",
    }
}
