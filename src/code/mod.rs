//! Maps as source text of other languages.
//!
//! Each formula is written once, generic over its number type ([`Real`](crate::number::real::Real)). Run on a number that
//! records ([`Trace`](crate::number::trace::Trace)) it gives a graph, with the map's axes, rotation, layout and parameters
//! folded in; [`printer`] makes statements of the graph, and a [`dialect`] says how a language writes them. So what is
//! printed is what the library computes, operation by operation, and a new projection prints in every language.
//!
//! What the library's kernels do beside the formula is left out, as shaders hold unit vectors: scaling of directions of odd
//! lengths, and NaN for places outside the valid image, which [`Verb::Valid`] answers for.

mod absent;
mod bilinear;
mod cube_taps;
mod dialect;
mod header;
mod interface;
mod languages;
mod options;
mod printer;
mod program;
mod source;
mod taps;
mod verb;

pub use crate::code::options::CodeOptions;
pub use crate::code::verb::Verb;

pub(crate) use crate::code::header::wrapped;
pub(crate) use crate::code::interface::{Argument, Gives, Program, Words};
pub(crate) use crate::code::source::{Function, Order};

use crate::code::program::program;
use crate::error::Error;
use crate::map::Map;

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
    let prefix = options.name.unwrap_or(map.info().name);
    let order = Order::new(language, prefix, options.native, options.double)?;
    if options.verbs.is_empty() {
        return Err(Error::Code("at least one verb is wanted".to_owned()));
    }
    if options.verbs.contains(&Verb::Taps) {
        taps::rule(map)?;
    }
    let function = |&verb: &Verb| Function {
        name: verb.name(),
        doc: vec![verb.says(map)],
        program: program(map, verb, order.style),
    };
    let functions: Vec<Function> = once(options.verbs).map(function).collect();
    order.text(header::lines(map, options), &functions)
}

/// Each of some verbs, once.
pub(crate) fn once<V: PartialEq>(verbs: &[V]) -> impl Iterator<Item = &V> {
    let first = |(k, verb): &(usize, &V)| !verbs[..*k].contains(verb);
    let each = verbs.iter().enumerate().filter(first);
    each.map(|(_, verb)| verb)
}

#[cfg(test)]
pub(crate) mod run;
#[cfg(test)]
mod tests;
