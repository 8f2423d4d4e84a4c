//! Maps as source text of other languages.
//!
//! Each formula is written once, generic over its number type ([`Real`](crate::number::real::Real)). Run on a number that
//! records ([`Trace`](crate::number::trace::Trace)) it gives a graph, with the map's axes, rotation, layout and parameters
//! folded in; [`printer`] makes statements of the graph, and a [`dialect`] says how a language writes them. So what is
//! printed is what the library computes, operation by operation, and a new projection prints in every language.
//!
//! What the library's kernels do beside the formula is left out, as shaders hold unit vectors: scaling of directions of odd
//! lengths, and NaN for places outside the valid image, which [`Verb::Valid`] answers for.

mod dialect;
mod header;
mod languages;
mod options;
mod printer;
mod program;
mod verb;

pub use crate::code::options::CodeOptions;
pub use crate::code::verb::Verb;

use crate::code::dialect::{Dialect, Signature, Text};
use crate::code::program::{Argument, Gives, Program, program};
use crate::error::Error;
use crate::map::Map;
use crate::number::graph::{Helper, Style};
use crate::number::trace::{self, Width};

/// What a language is called, and what it can do.
#[derive(Clone, Copy, Debug)]
#[non_exhaustive]
pub struct Language {
    /// The name that it is asked for by.
    pub name: &'static str,
    /// Its full name.
    pub title: &'static str,
    /// What files of it end in, without the dot.
    pub extension: &'static str,
    /// Whether it has numbers of 64 bits.
    pub double: bool,
    /// What is promised about bits.
    pub promise: &'static str,
    /// What runs the printed text in the tests.
    pub checked: &'static str,
}

/// Every language, in the order of the registry.
///
/// ```
/// let names: Vec<_> = spheremap::code::languages().map(|language| language.name).collect();
/// assert!(names.contains(&"wgsl"));
/// ```
pub fn languages() -> impl Iterator<Item = Language> {
    languages::ALL.iter().map(|dialect| Language {
        name: dialect.name(),
        title: dialect.title(),
        extension: dialect.extension(),
        double: dialect.has_double(),
        promise: dialect.promise(),
        checked: dialect.checked(),
    })
}

/// Verbs of a map as source text of a language, complete in itself.
///
/// # Errors
/// The language, or its numbers of 64 bits, do not exist; a name that the language does not take; no verb.
///
/// ```
/// use spheremap::Map;
/// use spheremap::code::{CodeOptions, code};
/// let text = code(&Map::new("octahedral")?, "glsl", &CodeOptions::new())?;
/// assert!(text.contains("vec2 octahedral_encode(vec3 d) {"));
/// # Ok::<(), spheremap::Error>(())
/// ```
pub fn code(map: &Map, language: &str, options: &CodeOptions<'_>) -> Result<String, Error> {
    let dialect = dialect_of(language)?;
    if options.double && !dialect.has_double() {
        return Err(Error::Code(format!(
            "{} has no numbers of 64 bits; leave out dtype=\"float64\"",
            dialect.title()
        )));
    }
    if options.verbs.is_empty() {
        return Err(Error::Code("at least one verb is wanted".to_owned()));
    }
    let prefix = options.name.unwrap_or(map.info().name);
    check_name(dialect, prefix)?;
    Ok(if options.double {
        written::<f64>(map, dialect, prefix, options)
    } else {
        written::<f32>(map, dialect, prefix, options)
    })
}

fn dialect_of(language: &str) -> Result<&'static dyn Dialect, Error> {
    let known = || languages::ALL.iter();
    match known().find(|dialect| dialect.name() == language) {
        Some(dialect) => Ok(*dialect),
        None => {
            let names: Vec<_> = known().map(|dialect| dialect.name()).collect();
            Err(Error::unknown("language", language, &names))
        }
    }
}

/// Whether names may begin so: a letter, then letters, digits and single underscores, and no word of the language.
fn check_name(dialect: &dyn Dialect, name: &str) -> Result<(), Error> {
    let letters = name.chars().all(|c| c.is_ascii_alphanumeric() || c == '_');
    let begins = name.starts_with(|c: char| c.is_ascii_alphabetic());
    if !letters || !begins || name.contains("__") || name.ends_with('_') || name.len() > 64 {
        return Err(Error::Code(format!(
            "{name:?} is no name that every language takes: a letter, then letters, digits and single underscores, \
             at most 64"
        )));
    }
    // GLSL keeps names that begin so for itself.
    if name.starts_with("gl_") || dialect.reserved().contains(&name) {
        return Err(Error::Code(format!(
            "{name:?} is a word of {}; choose another name",
            dialect.title()
        )));
    }
    Ok(())
}

/// What a shared function takes.
fn helper_arguments(helper: Helper) -> Vec<Argument> {
    let names: &[_] = if helper.arguments() == 2 {
        &["y", "x"]
    } else {
        &["x"]
    };
    names.iter().map(|name| Argument::number(name)).collect()
}

fn written<T: Width>(
    map: &Map,
    dialect: &dyn Dialect,
    prefix: &str,
    options: &CodeOptions<'_>,
) -> String {
    let style = Style {
        double: options.double,
        native: options.native,
        inside: false,
    };
    let programs: Vec<(Verb, Program)> = options
        .verbs
        .iter()
        .map(|&verb| (verb, program::<T>(map, verb, style)))
        .collect();
    let helpers: Vec<Helper> = Helper::ALL
        .into_iter()
        .filter(|helper| {
            programs
                .iter()
                .any(|(_, program)| printer::helpers(program).any(|h| h == *helper))
        })
        .collect();
    let text = Text {
        prefix: prefix.to_owned(),
        double: options.double,
        header: header::lines(map, dialect, options),
        not_a_number: programs
            .iter()
            .any(|(_, program)| printer::has_nan(program)),
    };
    let mut parts: Vec<String> = Vec::new();
    for helper in helpers {
        let (graph, outputs) = trace::body::<T>(helper, style);
        let program = Program {
            takes: helper_arguments(helper),
            gives: if helper.results() == 2 {
                Gives::Pair
            } else {
                Gives::Number
            },
            nodes: graph.into_nodes(),
            outputs,
        };
        let signature = Signature {
            name: printer::helper_name(prefix, helper),
            takes: program.takes.clone(),
            gives: program.gives,
            doc: vec![header::of_helper(helper).to_owned()],
        };
        parts.push(printer::function(dialect, &text, &signature, &program));
    }
    for (verb, program) in &programs {
        let signature = Signature {
            name: format!("{prefix}_{}", verb.name()),
            takes: program.takes.clone(),
            gives: program.gives,
            doc: header::of_verb(map, *verb),
        };
        parts.push(printer::function(dialect, &text, &signature, program));
    }
    let comment = dialect.comment();
    let mut whole: String = text
        .header
        .iter()
        .map(|line| format!("{}\n", format!("{comment}{line}").trim_end()))
        .collect();
    whole.push('\n');
    whole.push_str(&dialect.prelude(&text));
    let between = if dialect.close().is_empty() {
        "\n\n"
    } else {
        "\n"
    };
    whole.push_str(&parts.join(between));
    whole
}

#[cfg(test)]
mod tests;
