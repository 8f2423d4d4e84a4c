//! Tuples in, tuples out: the only file that knows about instruction sets.
//!
//! A [`Point`] is a formula from I numbers to O numbers. [`run`] takes it over arrays of such tuples ([`Tuples`]):
//! chunks of 64 points are brought into an aligned structure-of-arrays buffer, the formula runs
//! over the buffer as a plain loop that the compiler vectorizes, and the results are put where they belong.
//! The loop is compiled for the baseline, for AVX2 and for AVX-512 (on x86-64) and chosen at run time.
//! No lane types, no intrinsics but the prefetch: every level runs the same operations in the same order,
//! without fused multiply-add, and so gives the same bits.
//!
//! Formulas that guard against tiny, huge, zero and invalid numbers are compiled a second time without
//! the guards (`apply_normal`), for chunks in which no number needs them; one look at the exponents
//! decides. The bits are the same: what is left out is scaling by powers of two and choices that would not be taken.
//!
//! What decided the shape, measured: 64 points a chunk (16 or 32 were 1.2 to 2 times slower, 256 slower
//! again); a buffer that the caller of the dispatched function owns (made inside, it lost its alignment,
//! 1.4×); software prefetch of source and target (0.80 → 1.20 of a copy); `#[inline(always)]` on
//! everything below a formula (one missing made a kernel five times slower). Large results go past the caches
//! ([`stream`]).
//!
//! A formula is called once a chunk, by a pointer: what brings tuples into rows, turns them and takes them out again is compiled for the
//! numbers of its tuples alone, not for each formula. Of the formulas' kernels it was two thirds. What did not help: four
//! chunks a call, which spared the small formulas nothing and let the prefetches come in bursts (large arrays 1.3 to 1.5×).

pub mod double;
pub mod interrupt;
pub mod memory;
pub mod pages;
pub mod stream;
pub mod threads;
pub mod tile;

use crate::kernel::tile::{Parcel, Rows, Tuples, TuplesMut, W};
use crate::number::math::Polynomials;
use crate::number::real::Real;
#[cfg(target_arch = "x86_64")]
use fearless_simd::{Avx2, Avx512};
use fearless_simd::{Level, Simd, SimdBase, SimdCombine, SimdSplit, f32x4, f32x8, f64x4, f64x8};
use std::ops::BitOr;
use std::sync::atomic::{AtomicU8, Ordering};

/// A float type that arrays hold: `f32` or `f64`.
pub trait Scalar: Real<Mask = bool> + PartialOrd + Polynomials + Default + Send + Sync {
    /// The nearest f64.
    fn to_f64(self) -> f64;

    /// Four of them side by side.
    #[doc(hidden)]
    type Four<S: Simd>: SimdBase<S, Element = Self, Array = [Self; 4]>
        + SimdCombine<S, Combined = Self::Eight<S>>;

    /// Eight of them.
    #[doc(hidden)]
    type Eight<S: Simd>: SimdBase<S, Element = Self, Array = [Self; 8]>
        + SimdSplit<S, Split = Self::Four<S>>;

    /// An unsigned integer of its size.
    #[doc(hidden)]
    type Word: Copy + Default + PartialEq + BitOr<Output = Self::Word>;

    /// A word whose highest bits are clear if and only if the number is normal: within 2⁻¹⁹ to 2¹³ for
    /// f32, 2⁻⁴⁰ to 2²⁴ for f64, of either sign. Words may be joined by OR.
    #[doc(hidden)]
    fn outside_normal_range(self) -> Self::Word;

    /// Whether words joined by OR all came from normal numbers.
    #[doc(hidden)]
    fn all_normal(joined: Self::Word) -> bool;

    /// A whole number within ±2²¹ as an integer: `as` checks its range and never vectorizes.
    #[doc(hidden)]
    fn whole(self) -> i32;
}

macro_rules! scalar {
    ($t:ty, $four:ident, $eight:ident, $word:ty, $first:expr, $outside:expr) => {
        impl Scalar for $t {
            type Four<S: Simd> = $four<S>;
            type Eight<S: Simd> = $eight<S>;
            type Word = $word;

            #[inline(always)]
            fn to_f64(self) -> f64 {
                self as f64
            }

            #[inline(always)]
            fn outside_normal_range(self) -> $word {
                // Without its sign bit the exponent is on top: a window of a power of two exponents
                // from the first one on leaves the highest bits clear.
                (self.to_bits() << 1).wrapping_sub($first)
            }

            #[inline(always)]
            fn all_normal(joined: $word) -> bool {
                joined & $outside == 0
            }

            #[inline(always)]
            fn whole(self) -> i32 {
                // 1.5·2^(digits - 1) leaves the number in the lowest bits.
                const MAGIC: $t = 1.5 / <$t>::EPSILON;
                (self + MAGIC).to_bits().wrapping_sub(MAGIC.to_bits()) as i32
            }
        }
    };
}
scalar!(f32, f32x4, f32x8, u32, 108 << 24, 0xe000_0000);
scalar!(f64, f64x4, f64x8, u64, 983 << 53, 0xf800_0000_0000_0000);

/// A formula from I numbers to O numbers.
pub trait Point<R: Copy, const I: usize, const O: usize>: Copy + Send + Sync {
    /// Whether `apply_normal` is worth a look at each chunk.
    const HAS_NORMAL_FORM: bool = false;
    /// Whether it is compiled for every level. What is not has none for AVX-512, and runs at AVX2 there.
    const EVERY_LEVEL: bool = true;
    /// Whether f32 is computed in f32, and not in f64.
    const SINGLE: bool = true;
    /// Whether it is compiled to write past the caches, too ([`stream`]).
    const STREAMS: bool = false;

    /// One point.
    fn apply(self, x: [R; I]) -> [R; O];

    /// One point of a chunk in which every number is normal: the same bits, with fewer guards.
    #[inline(always)]
    fn apply_normal(self, x: [R; I]) -> [R; O] {
        self.apply(x)
    }

    /// A chunk of points for which f64 has no result, of a formula that is computed in f64 ([`double`]).
    #[inline(never)]
    fn alone(self, at: Instructions, chunk: &mut Scratch<R, I, O>) {
        at.vectorize_narrow(
            #[inline(always)]
            move || {
                each(
                    chunk,
                    #[inline(always)]
                    |x| self.apply(x),
                )
            },
        );
    }
}

/// Which component goes where, with its sign: the exact part of a change of frame.
#[derive(Clone, Copy, Debug)]
pub struct SignedPermutation<const N: usize> {
    /// Component k is taken from here.
    pub order: [usize; N],
    /// Whether component k is negated on its way.
    pub negative: [bool; N],
}

impl<const N: usize> SignedPermutation<N> {
    /// The permutation that leaves every component where it is.
    pub fn identity() -> Self {
        SignedPermutation {
            order: std::array::from_fn(|k| k),
            negative: [false; N],
        }
    }
}

/// What happens to the three rows of a direction besides the formula.
#[derive(Clone, Copy, Debug)]
pub struct Frame<R, const I: usize, const O: usize> {
    /// Components on the way in.
    pub input: SignedPermutation<I>,
    /// Components on the way out.
    pub output: SignedPermutation<O>,
    /// A rotation of the input's three components, before `input`.
    pub rotate_input: Option<[[R; 3]; 3]>,
    /// A rotation of the output's three components (each of O/3 columns), before `output`.
    pub rotate_output: Option<[[R; 3]; 3]>,
}

impl<R: Real, const I: usize, const O: usize> Frame<R, I, O> {
    /// A frame that leaves everything where it is.
    pub fn plain() -> Self {
        Frame {
            input: SignedPermutation::identity(),
            output: SignedPermutation::identity(),
            rotate_input: None,
            rotate_output: None,
        }
    }

    /// Into which row each component goes on the way in.
    #[inline(always)]
    fn slots(&self) -> [usize; I] {
        let mut slot = [0; I];
        for (k, &source) in self.input.order.iter().enumerate() {
            slot[source % I] = k;
        }
        slot
    }

    /// Turns a chunk's points before the formula.
    #[inline(always)]
    fn rotate_in(&self, Rows(rows): &mut Rows<R, I>) {
        if let Some(matrix) = &self.rotate_input {
            rotate::<R, I, 1>(matrix, rows, 0);
        }
    }

    /// Turns what the formula found.
    #[inline(always)]
    fn rotate_out(&self, Rows(rows): &mut Rows<R, O>) {
        if let Some(matrix) = &self.rotate_output {
            if O == 6 {
                rotate::<R, O, 2>(matrix, rows, 0);
                rotate::<R, O, 2>(matrix, rows, 1);
            } else {
                rotate::<R, O, 1>(matrix, rows, 0);
            }
        }
    }
}

impl<const I: usize, const O: usize> Frame<f64, I, O> {
    /// The frame for numbers of another type.
    pub fn cast<R: Real>(&self) -> Frame<R, I, O> {
        let cast = |m: [[f64; 3]; 3]| m.map(|row| row.map(R::new));
        Frame {
            input: self.input,
            output: self.output,
            rotate_input: self.rotate_input.map(cast),
            rotate_output: self.rotate_output.map(cast),
        }
    }
}

/// The rows of a chunk, before and after.
pub struct Scratch<R, const I: usize, const O: usize> {
    pub(crate) input: Rows<R, I>,
    pub(crate) output: Rows<R, O>,
}

impl<R: Real, const I: usize, const O: usize> Scratch<R, I, O> {
    /// Zeros.
    pub(crate) const fn new() -> Self {
        Scratch {
            input: Rows([[R::ZERO; W]; I]),
            output: Rows([[R::ZERO; W]; O]),
        }
    }
}

/// Instruction-set levels, weakest first.
pub const LEVELS: [&str; 3] = ["baseline", "avx2", "avx512"];

/// 0 for the best there is, else 1 + the index in `LEVELS`.
static FORCED: AtomicU8 = AtomicU8::new(0);

/// How many of `LEVELS` this CPU runs.
fn available() -> usize {
    #[cfg(target_arch = "x86_64")]
    {
        let best = Level::new();
        1 + usize::from(best.as_avx2().is_some()) + usize::from(best.as_avx512().is_some())
    }
    #[cfg(not(target_arch = "x86_64"))]
    1
}

/// The levels that this CPU runs, weakest first.
///
/// ```
/// assert_eq!(spheremap::simd::levels()[0], "baseline");
/// ```
pub fn levels() -> &'static [&'static str] {
    &LEVELS[..available()]
}

/// The level that kernels run at: the best one of this CPU, or the one that was forced.
///
/// ```
/// use spheremap::simd;
/// assert_eq!(simd::levels().last(), Some(&simd::level()));
/// ```
pub fn level() -> &'static str {
    match FORCED.load(Ordering::Relaxed) {
        0 => LEVELS[available() - 1],
        forced => LEVELS[forced as usize - 1],
    }
}

/// Makes kernels run at this level, or at the best one again. False if this CPU does not have it.
///
/// ```
/// use spheremap::simd;
/// assert!(simd::force_level(Some("baseline")));
/// assert_eq!(simd::level(), "baseline");
/// assert!(simd::force_level(None));
/// assert!(!simd::force_level(Some("mmx")));
/// ```
pub fn force_level(name: Option<&str>) -> bool {
    let forced = match name {
        None => 0,
        Some(name) => match levels().iter().position(|level| *level == name) {
            Some(index) => index as u8 + 1,
            None => return false,
        },
    };
    FORCED.store(forced, Ordering::Relaxed);
    true
}

/// What kernels are run by: the best level of this CPU, or the one that was forced.
#[derive(Clone, Copy)]
pub enum Instructions {
    Baseline,
    #[cfg(target_arch = "x86_64")]
    Avx2(Avx2),
    #[cfg(target_arch = "x86_64")]
    Avx512(Avx512),
}

impl Instructions {
    #[inline(always)]
    fn in_force() -> Self {
        #[cfg(target_arch = "x86_64")]
        {
            let forced = FORCED.load(Ordering::Relaxed);
            let best = Level::new();
            if (forced == 0 || forced > 2)
                && let Some(token) = best.as_avx512()
            {
                return Instructions::Avx512(token);
            }
            if forced != 1
                && let Some(token) = best.as_avx2()
            {
                return Instructions::Avx2(token);
            }
        }
        Instructions::Baseline
    }

    /// Runs `work`, which must be `#[inline(always)]` down to its loops, compiled for these.
    #[inline(always)]
    fn vectorize<O>(self, work: impl FnOnce() -> O) -> O {
        match self {
            Instructions::Baseline => work(),
            #[cfg(target_arch = "x86_64")]
            Instructions::Avx2(token) => token.vectorize(work),
            #[cfg(target_arch = "x86_64")]
            Instructions::Avx512(token) => token.vectorize(work),
        }
    }

    /// The same, compiled for none above AVX2.
    #[inline(always)]
    fn vectorize_narrow<O>(self, work: impl FnOnce() -> O) -> O {
        #[cfg(target_arch = "x86_64")]
        if let Some(token) = self.avx2() {
            return token.vectorize(work);
        }
        work()
    }

    /// AVX2, where that or more is in force.
    #[cfg(target_arch = "x86_64")]
    #[inline(always)]
    fn avx2(self) -> Option<Avx2> {
        match self {
            Instructions::Baseline => None,
            Instructions::Avx2(token) => Some(token),
            Instructions::Avx512(token) => token.level().as_avx2(),
        }
    }
}

/// Runs `work`, which must be `#[inline(always)]` down to its loops, compiled for the level in force.
#[inline(always)]
pub fn vectorize<O>(work: impl FnOnce() -> O) -> O {
    Instructions::in_force().vectorize(work)
}

/// Work written in lanes of `fearless_simd`, for sums over many points: there the compiler may not
/// change the order of a loop's additions, so lanes that are added last are part of the formula. The
/// number of lanes is the same at every level, and so are the bits.
pub trait SimdWork {
    /// As of a [`Point`].
    const EVERY_LEVEL: bool = true;

    /// Does the work; to be `#[inline(always)]`.
    fn run<S: Simd>(self, simd: S);
}

/// Runs SIMD work at the level in force.
#[inline(never)]
pub fn run_simd<P: SimdWork>(work: P) {
    #[cfg(target_arch = "x86_64")]
    {
        let at = Instructions::in_force();
        if const { P::EVERY_LEVEL }
            && let Instructions::Avx512(token) = at
        {
            return run_by(token, work);
        }
        if let Some(token) = at.avx2() {
            return run_by(token, work);
        }
    }
    run_baseline(work);
}

#[inline(always)]
fn run_by<S: Simd, P: SimdWork>(simd: S, work: P) {
    simd.vectorize(
        #[inline(always)]
        || work.run(simd),
    );
}

/// Runs SIMD work for the baseline only: what is seldom done is not worth its code three times.
pub fn run_baseline<P: SimdWork>(work: P) {
    // Not `dispatch!`, which compiles the work for every level that there is before it finds that it is not run.
    #[cfg(target_arch = "x86_64")]
    run_by(Level::baseline().as_sse2().expect("x86-64 has SSE2"), work);
    #[cfg(not(target_arch = "x86_64"))]
    fearless_simd::dispatch!(Level::baseline(), simd => work.run(simd));
}

/// A loop to be compiled for every level.
pub trait Job {
    /// What comes out of the job.
    type Output;
    /// Does all of the work; `#[inline(always)]`.
    fn work(self) -> Self::Output;
}

/// Runs a job at the level in force. Buffers must belong to the caller: made inside, they lose their
/// alignment.
#[inline(never)]
pub fn dispatch<J: Job>(job: J) -> J::Output {
    vectorize(
        #[inline(always)]
        || job.work(),
    )
}

/// A formula over the rows of a chunk, whichever formula it is: what brings tuples into rows and takes them from there is
/// compiled for all of them together.
pub trait Formula<R, const I: usize, const O: usize> {
    /// Finds the outputs of a chunk.
    fn fill_rows(&mut self, at: Instructions, chunk: &mut Scratch<R, I, O>);
}

impl<R: Scalar, F: Point<R, I, O>, const I: usize, const O: usize> Formula<R, I, O> for F {
    fn fill_rows(&mut self, at: Instructions, chunk: &mut Scratch<R, I, O>) {
        // A copy: behind a reference its parameters might change with each number that is stored.
        let point = *self;
        if const { F::EVERY_LEVEL } {
            at.vectorize(
                #[inline(always)]
                move || fill(point, chunk),
            );
        } else {
            at.vectorize_narrow(
                #[inline(always)]
                move || fill(point, chunk),
            );
        }
    }
}

#[inline(always)]
fn fill<R: Scalar, F: Point<R, I, O>, const I: usize, const O: usize>(
    point: F,
    chunk: &mut Scratch<R, I, O>,
) {
    if F::HAS_NORMAL_FORM && all_normal(&chunk.input.0) {
        each(
            chunk,
            #[inline(always)]
            |x| point.apply_normal(x),
        );
    } else {
        each(
            chunk,
            #[inline(always)]
            |x| point.apply(x),
        );
    }
}

/// Takes a formula over all points of a chunk.
#[inline(always)]
pub(crate) fn each<R: Copy, const I: usize, const O: usize>(
    chunk: &mut Scratch<R, I, O>,
    formula: impl Fn([R; I]) -> [R; O],
) {
    let Scratch {
        input: Rows(input),
        output: Rows(output),
    } = chunk;
    for i in 0..W {
        let result = formula(std::array::from_fn(|k| input[k][i]));
        for k in 0..O {
            output[k][i] = result[k];
        }
    }
}

/// Takes `point` over `input`, I numbers a point, into `output`, O numbers for each of as many points.
pub fn run<R: Scalar, F: Point<R, I, O>, const I: usize, const O: usize>(
    mut point: F,
    frame: &Frame<R, I, O>,
    input: Tuples<'_, R, I>,
    output: TuplesMut<'_, R, O>,
) {
    run_formula(&mut point, F::STREAMS, frame, input, output);
}

fn run_formula<R: Scalar, const I: usize, const O: usize>(
    formula: &mut dyn Formula<R, I, O>,
    streams: bool,
    frame: &Frame<R, I, O>,
    input: Tuples<'_, R, I>,
    mut output: TuplesMut<'_, R, O>,
) {
    let zero = R::default();
    let mut walk = Walk {
        formula,
        frame,
        at: Instructions::in_force(),
        scratch: Scratch::new(),
    };
    // Of two that are in rows, whose ends mean nothing, or of one, the other tells how many there are.
    let count = input.len().min(output.len());
    let whole = count / W * W;
    if whole > 0 {
        // Not made where it is not wanted: small calls would clear as much again.
        let mut parcel = None;
        if streams && output.is_streamed() {
            parcel = Some(Parcel([[zero; O]; W]));
        }
        walk.walk_chunks(input, output.again(), parcel.as_mut());
    }
    if whole < count {
        let mut padded = [[zero; I]; W];
        let input = input.rest(whole, &mut padded);
        output.rest(whole, |output| walk.walk_chunks(input, output, None));
    }
}

/// What a formula's way over tuples needs.
struct Walk<'a, R, const I: usize, const O: usize> {
    formula: &'a mut dyn Formula<R, I, O>,
    frame: &'a Frame<R, I, O>,
    at: Instructions,
    scratch: Scratch<R, I, O>,
}

impl<R: Scalar, const I: usize, const O: usize> Walk<'_, R, I, O> {
    /// The whole chunks among tuples; by way of a parcel, past the caches.
    #[inline(never)]
    fn walk_chunks(
        &mut self,
        input: Tuples<'_, R, I>,
        output: TuplesMut<'_, R, O>,
        parcel: Option<&mut Parcel<R, O>>,
    ) {
        self.at.vectorize(
            #[inline(always)]
            || self.all(input, output, parcel),
        );
    }

    #[inline(always)]
    fn all(
        &mut self,
        input: Tuples<'_, R, I>,
        mut output: TuplesMut<'_, R, O>,
        mut parcel: Option<&mut Parcel<R, O>>,
    ) {
        let Walk {
            formula,
            frame,
            at,
            scratch,
        } = self;
        let slot = frame.slots();
        let order = frame.output.order;
        // Copies: behind a reference they might change with each number that is stored.
        let (flip_in, flip_out) = (frame.input.negative, frame.output.negative);
        for number in 0..input.len().min(output.len()) / W {
            input.load(number, slot, flip_in, &mut scratch.input.0);
            frame.rotate_in(&mut scratch.input);
            formula.fill_rows(*at, scratch);
            frame.rotate_out(&mut scratch.output);
            let Rows(after) = &scratch.output;
            output.store(number, order, flip_out, after, parcel.as_deref_mut());
        }
        if parcel.is_some() {
            stream::finish();
        }
    }
}

/// Whether every number of a chunk is normal.
#[inline(always)]
pub(crate) fn all_normal<R: Scalar, const N: usize>(rows: &[[R; W]; N]) -> bool {
    // Point by point: row by row, the loops were merged into gathers.
    let mut joined = R::Word::default();
    for i in 0..W {
        for row in rows {
            joined = joined | row[i].outside_normal_range();
        }
    }
    R::all_normal(joined)
}

/// Multiplies the rows `first`, `first + STEP`, `first + 2 STEP` by a matrix.
#[inline(always)]
fn rotate<R: Real, const N: usize, const STEP: usize>(
    m: &[[R; 3]; 3],
    rows: &mut [[R; W]; N],
    first: usize,
) {
    if first + 2 * STEP >= N {
        return;
    }
    #[expect(clippy::needless_range_loop, reason = "three rows in step")]
    for i in 0..W {
        let d = [
            rows[first][i],
            rows[first + STEP][i],
            rows[first + 2 * STEP][i],
        ];
        for k in 0..3 {
            rows[first + k * STEP][i] = m[k][0] * d[0] + m[k][1] * d[1] + m[k][2] * d[2];
        }
    }
}
