//! Schemes as source text of other languages: [`Packing::code`].
//!
//! Point sets, which search, and formulas of other programs are not printed.

use super::Packing;
use super::printed::{Asked, Verb};
use super::rounding::Rounding;
use crate::code::{Argument, Function, Gives, Order, Program, Words, once, wrapped};
use crate::error::Error;
use crate::number::graph::Style;

/// What is asked for beside the scheme and the language.
#[derive(Clone, Copy, Debug)]
pub struct CodeOptions<'a> {
    /// The functions, in this order.
    pub verbs: &'a [Verb],
    /// How `pack` rounds.
    pub rounding: Rounding,
    /// What names begin with; the scheme's name where nothing is said.
    pub name: Option<&'a str>,
    /// The language's own sine, arctangent and so on, rather than the library's polynomials.
    pub native: bool,
    /// Numbers of 64 bits.
    pub double: bool,
}

impl Default for CodeOptions<'_> {
    fn default() -> Self {
        CodeOptions {
            verbs: &Verb::ALL,
            rounding: Rounding::Precise,
            name: None,
            native: false,
            double: false,
        }
    }
}

/// The bits of a field, or of a code that is one number, that numbers of 32 bits hold with a half to spare.
fn fits_single(words: Words) -> bool {
    words.bits <= if words.fields == 1 { 22 } else { 16 }
}

impl Packing {
    /// A function of this scheme, where it is a formula.
    fn program(&self, verb: Verb, rounding: Rounding, style: Style) -> Option<Program> {
        self.scheme.program(Asked {
            verb,
            rounding,
            style,
        })
    }

    /// `pack` and `unpack` as source text of a language of [`crate::code`], complete in itself: from a unit vector to a word
    /// and back. Of a scheme whose codes are arrays of fields, the word has the first in its lowest bits.
    ///
    /// # Errors
    /// The scheme is no formula, or rounds otherwise; it needs numbers or words that the language or 32 bits do not
    /// have; the language does not exist, or does not take the name; no verb.
    ///
    /// ```
    /// use spheremap::pack::{CodeOptions, Packing, Verb};
    /// let oct = Packing::new("oct16")?;
    /// let text = oct.code("glsl", &CodeOptions::default())?;
    /// assert!(text.contains("uint oct16_pack(vec3 d) {"));
    /// let decoder = CodeOptions { verbs: &[Verb::Unpack], ..CodeOptions::default() };
    /// assert!(!oct.code("hlsl", &decoder)?.contains("_pack"));
    /// # Ok::<(), spheremap::Error>(())
    /// ```
    pub fn code(&self, language: &str, options: &CodeOptions<'_>) -> Result<String, Error> {
        let own = self.name.replace('-', "_");
        let prefix = options.name.unwrap_or(&own);
        let order = Order::new(language, prefix, options.native, options.double)?;
        if options.verbs.is_empty() {
            return Err(Error::Code("at least one verb is wanted".to_owned()));
        }
        if !self.family.roundings.contains(&options.rounding) {
            return Err(Error::Code(format!("'{}' does not round so", self.name)));
        }
        let function = |&verb: &Verb| {
            let program = self.program(verb, options.rounding, order.style);
            program.map(|program| Function {
                name: verb.name(),
                doc: self.says(verb),
                program,
            })
        };
        let functions: Option<Vec<Function>> = once(options.verbs).map(function).collect();
        let Some(functions) = functions else {
            return Err(Error::Code(format!(
                "'{}' is no formula that can be printed: it searches a point set, or repeats the integers of \
                 another program; 'oct', 'woct' and others have one",
                self.name
            )));
        };
        let words = words(&functions[0].program);
        if !options.double && !fits_single(words) {
            return Err(Error::Code(format!(
                "'{}' has fields of {} bits, which numbers of 32 bits do not hold; ask for dtype=\"float64\"",
                self.name, words.bits
            )));
        }
        order.text(self.about(words, options), &functions)
    }

    fn says(&self, verb: Verb) -> Vec<String> {
        let line = match (verb, self.family.hemisphere) {
            (Verb::Pack, false) => "A unit direction to its code.",
            (Verb::Pack, true) => "A unit direction with z >= 0 to its code.",
            (Verb::Unpack, _) => "A code to its unit direction.",
        };
        vec![line.to_owned()]
    }

    /// The lines at the top.
    fn about(&self, words: Words, options: &CodeOptions<'_>) -> Vec<String> {
        let mut lines = vec![format!("{}: {}", self.family.title, self.name)];
        let mut say = |label: &str, words: &str| lines.extend(wrapped(label, words));
        say("Source:", self.family.source);
        let fields = if words.fields == 1 {
            format!("one number below {}", self.codes())
        } else {
            let grid = match self.variant {
                "" => String::new(),
                variant => format!(", {variant}"),
            };
            format!(
                "{} fields of {} bits{grid}, the first in the lowest bits",
                words.fields, words.bits
            )
        };
        say("Codes:", &format!("{} bits, {fields}.", self.bits));
        let half = if self.family.hemisphere {
            " with z >= 0"
        } else {
            ""
        };
        say(
            "Directions:",
            &format!("unit length, or near it{half}; the pole is +z."),
        );
        let rounding = match options.rounding {
            Rounding::Nearest => "each coordinate by itself.",
            Rounding::Precise => "to the best of the grid points around.",
            Rounding::Hex => "in the plane of the octahedron's face.",
        };
        say("Rounding:", rounding);
        match self.bound(options.rounding) {
            Some(bound) if bound.is_finite() => say(
                "Bound:",
                &format!(
                    "a direction and that of its code are within {bound:.3e} radians, but for rounding."
                ),
            ),
            _ => say("Bound:", "none, in steps of the grid."),
        }
        if !options.double && !self.scheme.single() {
            say(
                "Ties:",
                "the library computes this scheme in f64; what lies between two codes may get the other one.",
            );
        }
        lines
    }
}

/// The words that a function takes or gives.
fn words(program: &Program) -> Words {
    let taken = program.takes.iter().find_map(Argument::words);
    match (program.gives, taken) {
        (Gives::Word(words), _) | (_, Some(words)) => words,
        _ => unreachable!("pack gives a word, and unpack takes one"),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::code::run::{directions, values};
    use crate::pack::{Invalid, Real, names};

    fn word(fields: &[f64], words: Words) -> u64 {
        let shifted = |(k, field): (usize, &f64)| (*field as u64) << words.shift(k);
        fields.iter().enumerate().map(shifted).sum()
    }

    fn fields(word: u64, words: Words) -> Vec<f64> {
        let mask = (1_u64 << words.bits) - 1;
        let field = |k| ((word >> words.shift(k)) & mask) as f64;
        (0..words.fields).map(field).collect()
    }

    /// What a scheme computes beside what its recorded functions do.
    fn check<R: Real>(packing: &Packing, rounding: Rounding, double: bool) {
        let style = Style {
            double,
            native: false,
            inside: false,
        };
        let of = |verb| packing.program(verb, rounding, style).unwrap();
        let (pack, unpack) = (of(Verb::Pack), of(Verb::Unpack));
        let words = words(&pack);
        let name = &packing.name;
        let mut codes = Vec::new();
        for d in directions() {
            let z = if packing.family.hemisphere {
                d[2].abs()
            } else {
                d[2]
            };
            let d = [d[0], d[1], z].map(R::new);
            let mut code = [0_u64];
            packing
                .pack(rounding, Invalid::Raise, &d, &mut code)
                .unwrap();
            let got = word(&values(&pack, style, &d.map(|x| x.to_f64())), words);
            assert_eq!(
                got,
                code[0],
                "{name} {rounding:?} {:?}",
                d.map(|x| x.to_f64())
            );
            codes.extend(code);
        }
        if packing.bits <= 16 && rounding == Rounding::Nearest {
            codes = (0..packing.codes()).collect();
        }
        let mut all = vec![R::ZERO; 3 * codes.len()];
        packing.unpack(&codes, &mut all).unwrap();
        for (code, d) in codes.into_iter().zip(all.as_chunks::<3>().0) {
            let got = values(&unpack, style, &fields(code, words));
            for (got, wanted) in got.iter().zip(d.map(|x| x.to_f64())) {
                let alike = *got == wanted || got.is_nan() && wanted.is_nan();
                assert!(alike, "{name} {code}: {got} instead of {wanted}");
            }
        }
    }

    #[test]
    fn what_is_recorded_has_the_bits_of_the_kernels() {
        let style = Style {
            double: true,
            native: false,
            inside: false,
        };
        for (name, family, bits, ..) in names() {
            let packing = Packing::new(&name).unwrap();
            let known = [16, 24, 30, 32, 48, 64].contains(&bits);
            if !known
                || packing
                    .program(Verb::Pack, Rounding::Nearest, style)
                    .is_none()
            {
                continue;
            }
            for &rounding in family.roundings {
                check::<f64>(&packing, rounding, true);
                if packing.scheme.single() {
                    check::<f32>(&packing, rounding, false);
                }
            }
        }
    }
}
