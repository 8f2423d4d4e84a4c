//! Functions as one text, complete in itself: what they share first, then each that was asked for.

use crate::code::dialect::{Dialect, Signature, Text};
use crate::code::interface::{Argument, Gives, Program, Words};
use crate::code::{absent, header, languages, printer};
use crate::error::Error;
use crate::number::graph::{Helper, Style};
use crate::number::trace;

/// A function of a text.
#[derive(Clone, Debug)]
pub(crate) struct Function {
    /// Its name behind that of the text.
    pub name: &'static str,
    /// What it is, in lines.
    pub doc: Vec<String>,
    /// What it does.
    pub program: Program,
}

/// Which language a text is in, what its names begin with, and what its numbers are.
#[derive(Clone, Copy)]
pub(crate) struct Order<'a> {
    dialect: &'static dyn Dialect,
    prefix: &'a str,
    /// What formulas are recorded in.
    pub style: Style,
}

impl<'a> Order<'a> {
    /// A text that can be written.
    ///
    /// # Errors
    /// The language, or its numbers of 64 bits, do not exist; a name that the language does not take.
    pub fn new(
        language: &str,
        prefix: &'a str,
        native: bool,
        double: bool,
    ) -> Result<Order<'a>, Error> {
        let dialect = dialect_of(language)?;
        if double && !dialect.has_double() {
            return Err(Error::Code(format!(
                "{} has no numbers of 64 bits; leave out dtype=\"float64\"",
                dialect.title()
            )));
        }
        check_name(dialect, prefix)?;
        Ok(Order {
            dialect,
            prefix,
            style: Style {
                double,
                native,
                inside: false,
            },
        })
    }

    /// Whether a vector may have any number of channels.
    pub fn has_arrays(&self) -> bool {
        self.dialect.has_arrays()
    }

    /// The text of functions, below what it says about itself.
    ///
    /// # Errors
    /// A function takes or gives words that the language does not have.
    pub fn text(&self, mut about: Vec<String>, functions: &[Function]) -> Result<String, Error> {
        let dialect = self.dialect;
        let own = |function: &Function| Function {
            program: if dialect.has_nan() {
                function.program.clone()
            } else {
                absent::chosen_last(function.program.clone(), self.style)
            },
            ..function.clone()
        };
        let functions: Vec<Function> = functions.iter().map(own).collect();
        about.extend(header::colophon(dialect, self.style.native));
        let programs = || functions.iter().map(|function| &function.program);
        let words: Vec<u32> = programs().filter_map(bits_of_words).collect();
        if let Some(bits) = words.iter().find(|bits| dialect.word(**bits).is_none()) {
            return Err(Error::Code(format!(
                "{} has no unsigned numbers of {bits} bits",
                dialect.title()
            )));
        }
        let calls = |helper: &Helper| programs().any(|p| printer::helpers(p).any(|h| h == *helper));
        let helpers: Vec<(Helper, Program)> = Helper::ALL
            .into_iter()
            .filter(calls)
            .map(|helper| (helper, self.body(helper)))
            .collect();
        let bodies = || helpers.iter().map(|(_, body)| body);
        let text = Text {
            prefix: self.prefix.to_owned(),
            double: self.style.double,
            header: about,
            not_a_number: programs().any(printer::has_nan),
            rounds: programs().chain(bodies()).any(printer::rounds),
            words: !words.is_empty(),
        };
        let shared = helpers.iter().map(|(helper, body)| {
            let name = printer::helper_name(self.prefix, *helper);
            let doc = vec![header::of_helper(*helper).to_owned()];
            self.function(&text, name, doc, body)
        });
        let own = functions.iter().map(|function| {
            let name = format!("{}_{}", self.prefix, function.name);
            self.function(&text, name, function.doc.clone(), &function.program)
        });
        let parts: Vec<String> = shared.chain(own).collect();
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
        Ok(whole)
    }

    fn function(&self, text: &Text, name: String, doc: Vec<String>, program: &Program) -> String {
        let signature = Signature {
            name,
            takes: program.takes.clone(),
            gives: program.gives,
            doc,
        };
        printer::function(self.dialect, text, &signature, program)
    }

    fn body(&self, helper: Helper) -> Program {
        let (graph, outputs) = trace::body(helper, self.style);
        Program {
            takes: helper_arguments(helper),
            gives: if helper.results() == 2 {
                Gives::Pair
            } else {
                Gives::Number
            },
            nodes: graph.into_nodes(),
            outputs,
        }
    }
}

/// What a shared function takes.
pub(super) fn helper_arguments(helper: Helper) -> Vec<Argument> {
    let names: &[_] = if helper.arguments() == 2 {
        &["y", "x"]
    } else {
        &["x"]
    };
    names.iter().map(|name| Argument::number(name)).collect()
}

/// The bits of the words that a function takes or gives.
fn bits_of_words(program: &Program) -> Option<u32> {
    let taken = program.takes.iter().find_map(Argument::words);
    match program.gives {
        Gives::Word(words) => Some(words.all()),
        _ => taken.map(Words::all),
    }
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
            "Expected `name` to be one that every language takes, a letter, then letters, digits and single underscores, \
             at most 64, got {name:?}."
        )));
    }
    if ["gl_", "webgl_"].iter().any(|own| name.starts_with(own)) {
        return Err(Error::Code(format!(
            "Expected `name` to be one that every language takes, got {name:?}, which begins as GLSL's own names do."
        )));
    }
    if dialect.reserved().contains(&name) {
        return Err(Error::Code(format!(
            "Expected `name` to be one that {} takes, got {name:?}, a word of its own.",
            dialect.title()
        )));
    }
    Ok(())
}
