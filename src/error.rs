//! One error type. Each message says what was expected and what came.

use std::borrow::Cow;

/// Everything that can be wrong with a call.
#[derive(Debug, thiserror::Error, Clone, PartialEq)]
#[non_exhaustive]
pub enum Error {
    /// A name that nothing has.
    #[error("unknown {what} '{name}'{hint}")]
    Unknown {
        /// The kind of thing that was asked for.
        what: Cow<'static, str>,
        /// What was asked for.
        name: String,
        /// The nearest name, or the names there are.
        hint: String,
    },
    /// A parameter out of its range.
    #[error("`{name}` must be in ({above}, {maximum}], got {value}.")]
    Parameter {
        /// The parameter.
        name: &'static str,
        /// Its lower, excluded bound.
        above: f64,
        /// Its upper, included bound.
        maximum: f64,
        /// What came.
        value: f64,
    },
    /// Parameters that do not go together, each within its range.
    #[error("projection '{projection}': {why}")]
    Together {
        /// The projection.
        projection: &'static str,
        /// What was expected and what came.
        why: String,
    },
    /// Axes that are no signed permutation.
    #[error("`axes` '{text}' name no frame: {why}")]
    Axes {
        /// What came.
        text: String,
        /// What is wrong with it.
        why: String,
    },
    /// The same of a world.
    #[error("`world` '{text}' names no frame: {why}")]
    World {
        /// What came.
        text: String,
        /// What is wrong with it.
        why: String,
    },
    /// A matrix that is no rotation.
    #[error("`rotation` is no rotation: {0}")]
    Rotation(String),
    /// A shape that does not fit.
    #[error("{0}")]
    Shape(String),
    /// A slice of another length than what belongs with it.
    #[error("Expected `{name}` to hold {expected} numbers, got {got}.")]
    Length {
        /// The slice.
        name: &'static str,
        /// How many numbers it should hold.
        expected: usize,
        /// How many it holds.
        got: usize,
    },
    /// A slice of numbers that ends within a point.
    #[error("Expected `{name}` to hold a multiple of {of} numbers, got {got}.")]
    Multiple {
        /// The slice.
        name: &'static str,
        /// How many numbers a point has.
        of: usize,
        /// How many numbers came.
        got: usize,
    },
    /// A slice whose points have more or fewer numbers than they should.
    #[error("Expected the points of `{name}` to have {expected} numbers each, got {got}.")]
    Width {
        /// The slice.
        name: &'static str,
        /// How many numbers a point should have.
        expected: usize,
        /// How many it has.
        got: usize,
    },
    /// Options that contradict each other.
    #[error("{0}")]
    Contradiction(String),
    /// Code that cannot be written.
    #[error("{0}")]
    Code(String),
    /// Whoever runs a call stopped it.
    #[error("The call was stopped.")]
    Stopped,
    /// What a call needs beside its inputs and outputs does not fit.
    #[error(
        "There is no room for {bytes} bytes of memory that this takes beside its inputs and outputs."
    )]
    Memory {
        /// How much it was.
        bytes: usize,
    },
}

impl Error {
    /// An unknown name, with the nearest of `names` or all of them.
    pub(crate) fn unknown(what: impl Into<Cow<'static, str>>, name: &str, names: &[&str]) -> Error {
        let nearest = names
            .iter()
            .map(|candidate| (distance(name, candidate), *candidate))
            .min()
            .filter(|(distance, candidate)| *distance <= (candidate.len() / 3).max(2));
        let hint = match nearest {
            Some((_, candidate)) => format!("; did you mean '{candidate}'?"),
            None if names.is_empty() => String::new(),
            None => format!("; there are {}", names.join(", ")),
        };
        Error::Unknown {
            what: what.into(),
            name: name.to_owned(),
            hint,
        }
    }

    /// A name that others use for what is here under `names`.
    pub(crate) fn known_here_as(what: &'static str, name: &str, names: &[&str]) -> Error {
        Error::Unknown {
            what: what.into(),
            name: name.to_owned(),
            hint: format!("; here it is '{}'", names.join("' or '")),
        }
    }

    /// An unknown name among those that `owner` has: all of `names`, the nearest first.
    pub(crate) fn unknown_of(what: &'static str, name: &str, owner: &str, names: &[&str]) -> Error {
        // Names that start the same are near, however much one of them goes on.
        let shared = |candidate: &str| {
            let pairs = name.chars().zip(candidate.chars());
            pairs.take_while(|(a, b)| a == b).count()
        };
        let mut sorted = names.to_vec();
        sorted.sort_by_key(|candidate| {
            let far = 2 * distance(name, candidate) as isize - 3 * shared(candidate) as isize;
            (far, *candidate)
        });
        let nearest = match sorted.first() {
            Some(first) if distance(name, first) <= (first.len() / 3).max(2) => {
                format!("did you mean '{first}'? ")
            }
            _ => String::new(),
        };
        Error::Unknown {
            what: what.into(),
            name: name.to_owned(),
            hint: format!("; {nearest}'{owner}' has {}", sorted.join(", ")),
        }
    }
}

/// An error if a slice does not hold so many numbers.
pub(crate) fn expect_length(name: &'static str, got: usize, expected: usize) -> Result<(), Error> {
    if got == expected {
        return Ok(());
    }
    Err(Error::Length {
        name,
        expected,
        got,
    })
}

/// An error if a slice does not hold a multiple of so many numbers.
pub(crate) fn expect_multiple(name: &'static str, got: usize, of: usize) -> Result<(), Error> {
    if got.is_multiple_of(of) {
        return Ok(());
    }
    Err(Error::Multiple { name, of, got })
}

/// Levenshtein's distance.
fn distance(a: &str, b: &str) -> usize {
    let b: Vec<char> = b.chars().collect();
    let mut row: Vec<usize> = (0..=b.len()).collect();
    for (i, ca) in a.chars().enumerate() {
        let mut diagonal = row[0];
        row[0] = i + 1;
        for (j, cb) in b.iter().enumerate() {
            let replaced = diagonal + usize::from(ca != *cb);
            diagonal = row[j + 1];
            row[j + 1] = replaced.min(row[j] + 1).min(diagonal + 1);
        }
    }
    row[b.len()]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn unknown_names_suggest_the_nearest() {
        let names = ["octahedral", "latlong", "cube"];
        let text = Error::unknown("projection", "octahedrel", &names).to_string();
        assert_eq!(
            text,
            "unknown projection 'octahedrel'; did you mean 'octahedral'?"
        );
        let text = Error::unknown("projection", "mercury", &names).to_string();
        assert_eq!(
            text,
            "unknown projection 'mercury'; there are octahedral, latlong, cube"
        );
    }
}
