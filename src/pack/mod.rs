//! Unit vectors in 4 to 64 bits.
//!
//! A [`Family`] is a scheme of all its sizes; [`FAMILIES`] is the registry, one line each. A [`Packing`] is one
//! member, asked for by name: the family, the bits of a code, and the grid where there is a choice, as
//! in `oct16`, `oct16-centers`, `cube24-s2`. A code is one unsigned word, the first coordinate in its lowest
//! bits. `oct16x2` is the same as `oct32` as an array of its two fields; that is a matter of how the words
//! are looked at, and left to the Python layer.
//!
//! Two kinds of scheme: those whose formula the compiler vectorizes ([`kernel`]; in f32 where fields have
//! at most 16 bits and the data are f32, else in f64), and scalar ones (point sets, other programs'
//! formulas). All are pure functions of a direction, so threads and levels never show.
//!
//! Errors are bounded: [`Packing::bound`]. Directions of any length are taken, their length is not kept.

mod chart;
mod components;
mod cube;
mod draco;
mod engines;
mod fibonacci;
mod fold;
pub mod frame;
pub(crate) mod grid;
mod hemioct;
pub(crate) mod kernel;
mod literal;
mod meshoptimizer;
mod oct;
mod printed;
mod ray;
mod rings;
mod rounding;
mod source;
mod spherical;
mod unbounded;
mod unit;

pub use printed::Verb;
pub use rounding::Rounding;
pub use source::CodeOptions;

use crate::code::Program;
use crate::error::{Error, expect_length};
use crate::kernel::threads;
use std::fmt;
use std::sync::Arc;
use std::sync::atomic::{AtomicUsize, Ordering};

/// Every family of schemes.
pub static FAMILIES: &[&Family] = &[
    &oct::OCT,
    &hemioct::HEMIOCT,
    &oct::WOCT,
    &oct::EQUAL_AREA,
    &spherical::SPHERICAL,
    &cube::CUBE,
    &fibonacci::FIBONACCI,
    &rings::RINGS,
    &unbounded::SPHERE,
    &unbounded::MATCAP,
    &unbounded::Z_PHI,
    &components::SNORM,
    &components::RGB,
    &components::RGB10A2,
    &meshoptimizer::MESHOPTIMIZER,
    &draco::DRACO,
    &engines::PBRT,
    &engines::UNREAL,
    &engines::CESIUM,
];

/// How codes may be looked at as arrays of their fields.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Splits {
    /// Not at all.
    Whole,
    /// Not at all, and the name has no number of bits.
    Named,
    /// A word by default (`oct32`); two fields of 8, 16 or 32 bits by name (`oct16x2`).
    Two,
    /// Named by its three fields (`snorm8x3`); these totals are arrays of them.
    Three {
        /// Total bits of those that are arrays.
        components: &'static [u32],
    },
    /// Always an array of fields.
    Fields {
        /// How many.
        count: u32,
        /// Whether they count in two's complement.
        signed: bool,
    },
}

/// What the bounds of a family are multiples of.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Unit {
    /// The step of its grid on [-1, 1].
    Step,
    /// 1/√n for n codes.
    Root,
}

/// What a scheme claims about itself, in all its sizes.
#[derive(Debug)]
pub struct Family {
    /// The first part of its names.
    pub name: &'static str,
    /// Its full name.
    pub title: &'static str,
    /// Where it comes from.
    pub source: &'static str,
    /// What it is good for, in one line.
    pub summary: &'static str,
    /// The total bits it comes in.
    pub bits: &'static [u32],
    /// Grids or spacings, the default first; empty if there is no choice.
    pub variants: &'static [&'static str],
    /// The ways to round it has.
    pub roundings: &'static [Rounding],
    /// How its codes may be looked at.
    pub splits: Splits,
    /// Whether it holds z ≥ 0 only.
    pub hemisphere: bool,
    /// What `bounds` are multiples of.
    pub unit: Unit,
    /// The largest error of each of `roundings`, in radians over the unit, as stated by theory or rounded up
    /// from a search.
    pub bounds: &'static [f64],
    /// What a coarse grid adds to the bounds: so many times the square of the unit.
    pub excess: f64,
    /// The program that it repeats to the bit.
    pub exact: Option<&'static str>,
    /// Whether other programs decode its codes, or could by a formula in print.
    pub standard: bool,
    /// Whether a code costs a search, ten times a formula.
    pub slow: bool,
    /// How many codes there are: those from 0 on below this number.
    pub codes: fn(u32) -> u64,
    /// A member of so many bits, with a variant (or "").
    pub make: fn(u32, &str) -> Arc<dyn Scheme>,
}

impl Family {
    const DEFAULT: Family = Family {
        name: "",
        title: "",
        source: "",
        summary: "",
        bits: &[],
        variants: &[],
        roundings: &[],
        splits: Splits::Whole,
        hemisphere: false,
        unit: Unit::Step,
        bounds: &[],
        excess: 0.0,
        exact: None,
        standard: true,
        slow: false,
        // 0 for every pattern of bits.
        codes: |_| 0,
        make: |_, _| unreachable!("each family has its own"),
    };
}

/// Codes and directions, many at a time. Codes are below the number of codes.
pub trait Scheme: Send + Sync {
    /// Codes of directions. False if one has none.
    fn encode(&self, rounding: Rounding, directions: &[f64], codes: &mut [u64]) -> bool;

    /// Directions of codes.
    fn decode(&self, codes: &[u64], directions: &mut [f64]);

    /// Whether f32 suffices: then the next two may be called.
    fn single(&self) -> bool {
        false
    }

    /// As `encode`.
    fn encode_single(&self, _: Rounding, _: &[f32], _: &mut [u32]) -> bool {
        false
    }

    /// As `decode`.
    fn decode_single(&self, _: &[u32], _: &mut [f32]) {}

    /// A function of it as a graph, where it is a formula.
    fn program(&self, _asked: printed::Asked) -> Option<Program> {
        None
    }

    /// The step of the grid on [-1, 1] (1/√n for point sets), of which bounds are multiples.
    fn step(&self) -> f64;

    /// Replaces codes by the one that stands for all of the same direction. In whole numbers: to decode and encode
    /// again would round.
    fn canonical(&self, codes: &mut [u64]);
}

impl fmt::Debug for Packing {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_tuple("Packing").field(&self.name).finish()
    }
}

/// One scheme.
#[derive(Clone)]
pub struct Packing {
    /// Its name, without what is said by default.
    pub name: String,
    /// What it is a member of.
    pub family: &'static Family,
    /// Bits a code.
    pub bits: u32,
    /// The grid or spacing; "" where there is no choice.
    pub variant: &'static str,
    /// Fields if its codes are arrays of them: how many.
    pub fields: Option<u32>,
    scheme: Arc<dyn Scheme>,
}

/// A float that directions come in.
pub trait Real: kernel::Cell {
    /// Codes of this tile.
    fn encode(scheme: &dyn Scheme, rounding: Rounding, d: &[Self], codes: &mut [u64]) -> bool;
    /// Directions of this tile.
    fn decode(scheme: &dyn Scheme, codes: &[u64], d: &mut [Self]);
    /// Codes in words of 32 bits, where the scheme computes in this type.
    fn encode_words(scheme: &dyn Scheme, rounding: Rounding, d: &[Self], codes: &mut [u32])
    -> bool;
    /// Directions of codes in words of 32 bits, where the scheme computes in this type.
    fn decode_words(scheme: &dyn Scheme, codes: &[u32], d: &mut [Self]);
    /// Whether the last two may be called.
    const WORDS: bool;
}

impl Real for f32 {
    const WORDS: bool = true;

    fn encode(scheme: &dyn Scheme, rounding: Rounding, d: &[f32], codes: &mut [u64]) -> bool {
        let mut wide = [0.0; 3 * TILE];
        let wide = &mut wide[..d.len()];
        for (wide, d) in wide.iter_mut().zip(d) {
            *wide = f64::from(*d);
        }
        scheme.encode(rounding, wide, codes)
    }

    fn decode(scheme: &dyn Scheme, codes: &[u64], d: &mut [f32]) {
        let mut wide = [0.0; 3 * TILE];
        let wide = &mut wide[..d.len()];
        scheme.decode(codes, wide);
        for (wide, d) in wide.iter().zip(d) {
            *d = *wide as f32;
        }
    }

    fn encode_words(scheme: &dyn Scheme, rounding: Rounding, d: &[f32], codes: &mut [u32]) -> bool {
        scheme.encode_single(rounding, d, codes)
    }

    fn decode_words(scheme: &dyn Scheme, codes: &[u32], d: &mut [f32]) {
        scheme.decode_single(codes, d);
    }
}

impl Real for f64 {
    const WORDS: bool = false;

    fn encode(scheme: &dyn Scheme, rounding: Rounding, d: &[f64], codes: &mut [u64]) -> bool {
        scheme.encode(rounding, d, codes)
    }

    fn decode(scheme: &dyn Scheme, codes: &[u64], d: &mut [f64]) {
        scheme.decode(codes, d);
    }

    fn encode_words(_: &dyn Scheme, _: Rounding, _: &[f64], _: &mut [u32]) -> bool {
        false
    }

    fn decode_words(_: &dyn Scheme, _: &[u32], _: &mut [f64]) {}
}

/// An unsigned integer that codes are stored in.
pub trait Store: Copy + Default + Send + Sync + 'static {
    /// Its bits.
    const BITS: u32;
    /// The lowest bits of a word.
    fn from_word(word: u64) -> Self;
    /// As a word.
    fn word(self) -> u64;
    /// The lowest bits of a narrow word.
    fn from_narrow(word: u32) -> Self;
    /// As a narrow word.
    fn narrow(self) -> u32;
    /// The slice itself where it holds narrow words.
    fn as_narrow(_: &[Self]) -> Option<&[u32]> {
        None
    }
    /// The slice itself where it holds narrow words.
    fn as_narrow_mut(_: &mut [Self]) -> Option<&mut [u32]> {
        None
    }
}

macro_rules! store {
    ($t:ty $(, $own:item)*) => {
        impl Store for $t {
            const BITS: u32 = <$t>::BITS;
            #[inline(always)]
            fn from_word(word: u64) -> Self {
                word as $t
            }
            #[inline(always)]
            fn word(self) -> u64 {
                self as u64
            }
            #[inline(always)]
            fn from_narrow(word: u32) -> Self {
                word as $t
            }
            #[inline(always)]
            fn narrow(self) -> u32 {
                self as u32
            }
            $($own)*
        }
    };
}
store!(u8);
store!(u16);
store!(
    u32,
    fn as_narrow(codes: &[u32]) -> Option<&[u32]> {
        Some(codes)
    },
    fn as_narrow_mut(codes: &mut [u32]) -> Option<&mut [u32]> {
        Some(codes)
    }
);
store!(u64);

/// Points a tile, between loops that use different types.
const TILE: usize = 512;

/// What happens to directions that have no code.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Invalid {
    /// The call fails and names the first one.
    Raise,
    /// They become code 0.
    Zero,
    /// They become code 0 too, but a direction below the horizon of a hemisphere becomes the one on it.
    Ignore,
}

/// Whether a vector has a direction: finite and not zero.
fn has_direction(d: [f64; 3]) -> bool {
    d.iter().all(|x| x.is_finite()) && d.iter().any(|x| *x != 0.0)
}

/// Encodes one direction at a time, brought to length 1.
fn each(directions: &[f64], codes: &mut [u64], code: impl Fn([f64; 3]) -> u64) -> bool {
    let mut good = true;
    for (&d, slot) in directions.as_chunks::<3>().0.iter().zip(codes) {
        let (unit, ok) = unit::unit::<f64, false>(d);
        *slot = if ok { code(unit) } else { 0 };
        good &= ok;
    }
    good
}

/// The names that `Packing::new` takes, the most common first.
///
/// ```
/// assert!(spheremap::pack::names().any(|(name, ..)| name == "oct16-centers"));
/// ```
pub fn names() -> impl Iterator<Item = (String, &'static Family, u32, &'static str, Option<u32>)> {
    FAMILIES.iter().flat_map(|family| {
        family.bits.iter().flat_map(move |&bits| {
            let mut all = Vec::new();
            let variants: &[&str] = if family.variants.is_empty() {
                &[""]
            } else {
                family.variants
            };
            for (number, &variant) in variants.iter().enumerate() {
                let name = family.name;
                let tail = if number > 0 {
                    format!("-{variant}")
                } else {
                    String::new()
                };
                let mut add = |stem: String, fields| {
                    all.push((format!("{stem}{tail}"), *family, bits, variant, fields));
                };
                match family.splits {
                    Splits::Whole => add(format!("{name}{bits}"), None),
                    Splits::Named => add(name.to_owned(), None),
                    Splits::Two => {
                        add(format!("{name}{bits}"), None);
                        if [16, 32, 64].contains(&bits) {
                            add(format!("{name}{}x2", bits / 2), Some(2));
                        }
                    }
                    Splits::Three { components } => add(
                        format!("{name}{}x3", bits / 3),
                        components.contains(&bits).then_some(3),
                    ),
                    Splits::Fields { count, .. } => {
                        add(format!("{name}{}x{count}", bits / count), Some(count));
                    }
                }
            }
            all
        })
    })
}

impl Packing {
    /// The scheme of this name.
    ///
    /// # Errors
    /// No scheme has it.
    ///
    /// ```
    /// use spheremap::pack::Packing;
    /// assert_eq!(Packing::new("oct16")?.stored_bits(), 16);
    /// assert!(Packing::new("oct17").is_err());
    /// # Ok::<(), spheremap::Error>(())
    /// ```
    pub fn new(name: &str) -> Result<Packing, Error> {
        // The default variant may be said.
        let plain = name.rsplit_once('-').and_then(|(stem, tail)| {
            let said = |f: &&Family| stem.starts_with(f.name) && f.variants.first() == Some(&tail);
            FAMILIES.iter().copied().any(|f| said(&f)).then_some(stem)
        });
        let wanted = plain.unwrap_or(name);
        match names().find(|candidate| candidate.0 == wanted) {
            Some((name, family, bits, variant, fields)) => Ok(Packing {
                name,
                family,
                bits,
                variant,
                fields,
                scheme: (family.make)(bits, variant),
            }),
            None => {
                let all: Vec<String> = names().map(|candidate| candidate.0).collect();
                let all: Vec<&str> = all.iter().map(String::as_str).collect();
                let near = Error::unknown("packing", name, &all);
                Err(match near {
                    Error::Unknown { what, name, hint } if hint.starts_with("; there") => {
                        let families: Vec<&str> = FAMILIES.iter().map(|f| f.name).collect();
                        let families = families.join(", ");
                        Error::Unknown {
                            what,
                            name,
                            hint: format!(
                                "; the families are {families}, and `packings` lists all"
                            ),
                        }
                    }
                    other => other,
                })
            }
        }
    }

    /// The count of codes; 0 for 2⁶⁴.
    ///
    /// ```
    /// assert_eq!(spheremap::pack::Packing::new("oct16")?.codes(), 1 << 16);
    /// # Ok::<(), spheremap::Error>(())
    /// ```
    pub fn codes(&self) -> u64 {
        match (self.family.codes)(self.bits) {
            0 if self.bits == 64 => 0,
            0 => 1 << self.bits,
            n => n,
        }
    }

    /// The bits of the smallest unsigned integer that holds a code.
    ///
    /// ```
    /// assert_eq!(spheremap::pack::Packing::new("oct24")?.stored_bits(), 32);
    /// # Ok::<(), spheremap::Error>(())
    /// ```
    pub fn stored_bits(&self) -> u32 {
        self.bits.next_power_of_two().max(8)
    }

    /// Whether fields count in two's complement.
    ///
    /// ```
    /// assert!(!spheremap::pack::Packing::new("oct16-centers")?.signed());
    /// # Ok::<(), spheremap::Error>(())
    /// ```
    pub fn signed(&self) -> bool {
        match self.family.splits {
            Splits::Fields { signed, .. } => signed,
            Splits::Three { .. } => self.family.name == "snorm",
            _ => self.variant == "snorm",
        }
    }

    /// The largest angle in radians between a direction and its code's, in exact arithmetic; float32 adds a few
    /// of its rounding units where it is computed in.
    ///
    /// ```
    /// use spheremap::pack::{Packing, Rounding};
    /// let bound = Packing::new("oct32")?.bound(Rounding::Nearest).expect("oct rounds to nearest");
    /// assert!(bound < 1e-4);
    /// # Ok::<(), spheremap::Error>(())
    /// ```
    pub fn bound(&self, rounding: Rounding) -> Option<f64> {
        let index = self.family.roundings.iter().position(|r| *r == rounding)?;
        let unit = match self.family.unit {
            Unit::Step => self.scheme.step(),
            Unit::Root => 1.0 / (self.codes() as f64).sqrt(),
        };
        Some(unit * (self.family.bounds.get(index)? + self.family.excess * unit))
    }

    /// Codes of directions; the index of the first that has none, where that is not to be passed over.
    ///
    /// # Errors
    /// There are not three numbers of directions for each code, or its integers have fewer bits than a code.
    ///
    /// ```
    /// use spheremap::pack::{Invalid, Packing, Rounding};
    /// let oct = Packing::new("oct32")?;
    /// let mut codes = [0_u32; 2];
    /// let directions = [0.0_f32, 0.0, 1.0, 0.6, 0.0, 0.8];
    /// assert_eq!(oct.pack(Rounding::Nearest, Invalid::Raise, &directions, &mut codes)?, None);
    /// let none = [f32::NAN; 6];
    /// assert_eq!(oct.pack(Rounding::Nearest, Invalid::Raise, &none, &mut codes)?, Some(0));
    /// # Ok::<(), spheremap::Error>(())
    /// ```
    pub fn pack<R: Real, S: Store>(
        &self,
        rounding: Rounding,
        invalid: Invalid,
        directions: &[R],
        codes: &mut [S],
    ) -> Result<Option<usize>, Error> {
        expect_length("directions", directions.len(), 3 * codes.len())?;
        self.expect_bits(S::BITS)?;
        let first = AtomicUsize::new(usize::MAX);
        let start = directions.as_ptr() as usize;
        threads::blocks(directions, 3, codes, 1, |d, codes| {
            let mut at = (d.as_ptr() as usize - start) / size_of::<[R; 3]>();
            for (d, codes) in d.chunks(3 * TILE).zip(codes.chunks_mut(TILE)) {
                if !self.pack_tile(rounding, d, codes) {
                    match invalid {
                        Invalid::Raise => {
                            if let Some(k) = self.first_invalid(d) {
                                first.fetch_min(at + k, Ordering::Relaxed);
                            }
                        }
                        Invalid::Zero => {
                            for (d, code) in d.as_chunks::<3>().0.iter().zip(codes) {
                                if self.is_invalid(d) {
                                    *code = S::default();
                                }
                            }
                        }
                        Invalid::Ignore => {}
                    }
                }
                at += TILE;
            }
        });
        let first = first.into_inner();
        Ok((first != usize::MAX).then_some(first))
    }

    fn pack_tile<R: Real, S: Store>(&self, rounding: Rounding, d: &[R], codes: &mut [S]) -> bool {
        let scheme = self.scheme.as_ref();
        let n = codes.len();
        if R::WORDS && scheme.single() {
            if let Some(words) = S::as_narrow_mut(codes) {
                return R::encode_words(scheme, rounding, d, words);
            }
            let mut words = [0_u32; TILE];
            let good = R::encode_words(scheme, rounding, d, &mut words[..n]);
            for (code, word) in codes.iter_mut().zip(&words) {
                *code = S::from_narrow(*word);
            }
            return good;
        }
        let mut words = [0_u64; TILE];
        let good = R::encode(scheme, rounding, d, &mut words[..n]);
        for (code, word) in codes.iter_mut().zip(&words) {
            *code = S::from_word(*word);
        }
        good
    }

    /// An error if an integer of so many bits does not hold a code.
    fn expect_bits(&self, bits: u32) -> Result<(), Error> {
        if bits >= self.bits {
            return Ok(());
        }
        Err(Error::Shape(format!(
            "Expected `codes` of '{}' to be integers of at least {} bits, got {bits}.",
            self.name, self.bits
        )))
    }

    fn is_invalid<R: Real>(&self, d: &[R; 3]) -> bool {
        let d = d.map(|x| x.to_f64());
        !has_direction(d) || (self.family.hemisphere && d[2] < 0.0)
    }

    fn first_invalid<R: Real>(&self, d: &[R]) -> Option<usize> {
        d.as_chunks::<3>().0.iter().position(|d| self.is_invalid(d))
    }

    /// Unit directions of codes. Those that are none ([`Packing::first_out_of_range`]) give one as well, of no meaning: of
    /// `fibonacci` that of the last code.
    ///
    /// # Errors
    /// There is not room for three numbers of directions for each code.
    ///
    /// ```
    /// use spheremap::pack::{Invalid, Packing, Rounding};
    /// let oct = Packing::new("oct32")?;
    /// let (mut codes, mut back) = ([0_u32], [0.0_f32; 3]);
    /// oct.pack(Rounding::Nearest, Invalid::Raise, &[0.6_f32, 0.0, 0.8], &mut codes)?;
    /// oct.unpack(&codes, &mut back)?;
    /// assert!((back[0] - 0.6).abs() < 5e-5);
    /// # Ok::<(), spheremap::Error>(())
    /// ```
    pub fn unpack<R: Real, S: Store>(
        &self,
        codes: &[S],
        directions: &mut [R],
    ) -> Result<(), Error> {
        expect_length("directions", directions.len(), 3 * codes.len())?;
        let scheme = self.scheme.as_ref();
        threads::blocks(codes, 1, directions, 3, |codes, d| {
            for (codes, d) in codes.chunks(TILE).zip(d.chunks_mut(3 * TILE)) {
                if R::WORDS && scheme.single() {
                    if let Some(words) = S::as_narrow(codes) {
                        R::decode_words(scheme, words, d);
                        continue;
                    }
                    let mut words = [0_u32; TILE];
                    for (word, code) in words.iter_mut().zip(codes) {
                        *word = code.narrow();
                    }
                    R::decode_words(scheme, &words[..codes.len()], d);
                } else {
                    let mut words = [0_u64; TILE];
                    for (word, code) in words.iter_mut().zip(codes) {
                        *word = code.word();
                    }
                    R::decode(scheme, &words[..codes.len()], d);
                }
            }
        });
        Ok(())
    }

    /// One code for each direction: codes that are one direction in exact arithmetic become the same of them, which
    /// decodes to it within rounding and is itself left as it is. It is the code that `pack` writes, but in
    /// schemes that write several for one direction: `snorm`, `rgb`, `rgb10a2`, and of those that
    /// repeat other programs all but `draco`.
    ///
    /// # Errors
    /// `out` has another length.
    ///
    /// ```
    /// use spheremap::pack::Packing;
    /// let (oct, mut out) = (Packing::new("oct32")?, [0]);
    /// oct.canonical(&[7_u32], &mut out)?;
    /// # Ok::<(), spheremap::Error>(())
    /// ```
    pub fn canonical<S: Store>(&self, codes: &[S], out: &mut [S]) -> Result<(), Error> {
        expect_length("out", out.len(), codes.len())?;
        threads::blocks(codes, 1, out, 1, |codes, out| {
            let mut words = [0_u64; TILE];
            for (codes, out) in codes.chunks(TILE).zip(out.chunks_mut(TILE)) {
                let words = &mut words[..codes.len()];
                for (word, code) in words.iter_mut().zip(codes) {
                    *word = code.word();
                }
                self.scheme.canonical(words);
                for (out, word) in out.iter_mut().zip(words) {
                    *out = S::from_word(*word);
                }
            }
        });
        Ok(())
    }

    /// The index of the first code that is not below `codes`.
    ///
    /// ```
    /// let packing = spheremap::pack::Packing::new("oct24")?;
    /// assert_eq!(packing.first_out_of_range(&[5_u32, 1 << 24]), Some(1));
    /// # Ok::<(), spheremap::Error>(())
    /// ```
    pub fn first_out_of_range<S: Store>(&self, codes: &[S]) -> Option<usize> {
        let limit = self.codes();
        if limit == 0 || (S::BITS < 64 && limit == 1 << S::BITS) {
            return None;
        }
        codes.iter().position(|code| code.word() >= limit)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn codes_are_not_cut_off() {
        let oct = Packing::new("oct24").unwrap();
        let ahead = [0.0_f64, 0.0, 1.0];
        let error = oct.pack(Rounding::Nearest, Invalid::Raise, &ahead, &mut [0_u16]);
        let text = error.unwrap_err().to_string();
        assert!(
            text.contains("`codes`") && text.contains("24 bits"),
            "{text}"
        );
        let wide = oct.pack(Rounding::Nearest, Invalid::Raise, &ahead, &mut [0_u32]);
        assert_eq!(wide, Ok(None));
        assert_eq!(format!("{oct:?}"), "Packing(\"oct24\")");
    }

    #[test]
    fn codes_beyond_the_last_point_are_the_last() {
        let points = Packing::new("fibonacci8").unwrap();
        let mut all = [0.0_f64; 9];
        let codes = [255_u64, 256, 1 << 63];
        points.unpack(&codes, &mut all).unwrap();
        assert_eq!(all[..3], all[3..6]);
        assert_eq!(all[..3], all[6..]);
        assert_eq!(points.first_out_of_range(&codes), Some(1));
    }
}
