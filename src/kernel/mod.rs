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
//! everything below `run` (one missing made a kernel five times slower). Large results go past the caches
//! ([`stream`]).

pub mod interrupt;
pub mod memory;
pub mod pages;
pub mod stream;
pub mod threads;
pub mod tile;

use crate::kernel::tile::{Parcel, Rows, W};
use crate::kernel::tile::{TILE, Tile, Tuples, TuplesMut};
use crate::number::math::Polynomials;
use crate::number::real::Real;
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
pub trait Point<R, const I: usize, const O: usize>: Copy + Send + Sync {
    /// Whether `Frame::input` applies to what comes in.
    const DIRECTION_IN: bool = false;
    /// Whether `Frame::output` applies to what goes out.
    const DIRECTION_OUT: bool = false;
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

struct Scratch<R, const I: usize, const O: usize> {
    input: Rows<R, I>,
    output: Rows<R, O>,
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

/// Runs `work`, which must be `#[inline(always)]` down to its loops, compiled for the level in force.
#[inline(always)]
pub fn vectorize<O>(work: impl FnOnce() -> O) -> O {
    #[cfg(target_arch = "x86_64")]
    {
        let forced = FORCED.load(Ordering::Relaxed);
        let best = Level::new();
        if (forced == 0 || forced > 2)
            && let Some(token) = best.as_avx512()
        {
            return token.vectorize(work);
        }
        if forced != 1
            && let Some(token) = best.as_avx2()
        {
            return token.vectorize(work);
        }
    }
    work()
}

/// Work written in lanes of `fearless_simd`, for sums over many points: there the compiler may not
/// change the order of a loop's additions, so lanes that are added last are part of the formula. The
/// number of lanes is the same at every level, and so are the bits.
pub trait SimdWork {
    /// Does the work; to be `#[inline(always)]`.
    fn run<S: Simd>(self, simd: S);
}

/// Runs SIMD work at the level in force.
#[inline(never)]
pub fn run_simd<P: SimdWork>(work: P) {
    #[cfg(target_arch = "x86_64")]
    {
        let forced = FORCED.load(Ordering::Relaxed);
        let best = Level::new();
        if (forced == 0 || forced > 2)
            && let Some(token) = best.as_avx512()
        {
            return token.vectorize(
                #[inline(always)]
                || work.run(token),
            );
        }
        if forced != 1
            && let Some(token) = best.as_avx2()
        {
            return token.vectorize(
                #[inline(always)]
                || work.run(token),
            );
        }
    }
    run_baseline(work);
}

/// Runs SIMD work for the baseline only: what is seldom done is not worth its code three times.
pub fn run_baseline<P: SimdWork>(work: P) {
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

/// Runs a job at the level in force, but not above AVX2.
#[inline(never)]
fn dispatch_narrow<J: Job>(job: J) -> J::Output {
    #[cfg(target_arch = "x86_64")]
    if FORCED.load(Ordering::Relaxed) != 1
        && let Some(token) = Level::new().as_avx2()
    {
        return token.vectorize(
            #[inline(always)]
            || job.work(),
        );
    }
    job.work()
}

struct Run<'a, R, F, const I: usize, const O: usize> {
    point: F,
    frame: &'a Frame<R, I, O>,
    input: Tuples<'a, R, I>,
    output: TuplesMut<'a, R, O>,
    scratch: &'a mut Scratch<R, I, O>,
    /// Where chunks are put together that go past the caches.
    parcel: Option<&'a mut Parcel<R, O>>,
}

impl<R: Scalar, F: Point<R, I, O>, const I: usize, const O: usize> Job for Run<'_, R, F, I, O> {
    type Output = ();

    #[inline(always)]
    fn work(self) {
        all(
            self.point,
            self.frame,
            self.input,
            self.output,
            self.scratch,
            self.parcel,
        );
    }
}

/// Takes `point` over `input`, I numbers a point, into `output`, O numbers for each of as many points.
pub fn run<R: Scalar, F: Point<R, I, O>, const I: usize, const O: usize>(
    point: F,
    frame: &Frame<R, I, O>,
    input: Tuples<'_, R, I>,
    mut output: TuplesMut<'_, R, O>,
) {
    let zero = R::default();
    let mut scratch = Scratch {
        input: Rows([[zero; W]; I]),
        output: Rows([[zero; W]; O]),
    };
    // Of two that are in rows, whose ends mean nothing, or of one, the other tells how many there are.
    let count = input.len().min(output.len());
    let whole = count / W * W;
    if whole > 0 {
        chunks(point, frame, input, output.again(), &mut scratch);
    }
    if whole < count {
        let mut padded = [[zero; I]; W];
        let input = input.rest(whole, &mut padded);
        output.rest(whole, |output| {
            chunks(point, frame, input, output, &mut scratch);
        });
    }
}

/// The whole chunks among them.
fn chunks<R: Scalar, F: Point<R, I, O>, const I: usize, const O: usize>(
    point: F,
    frame: &Frame<R, I, O>,
    input: Tuples<'_, R, I>,
    output: TuplesMut<'_, R, O>,
    scratch: &mut Scratch<R, I, O>,
) {
    // Not made where it is not wanted: small calls would clear as much again.
    let mut parcel = None;
    if F::STREAMS && output.is_streamed() {
        parcel = Some(Parcel([[R::default(); O]; W]));
    }
    let job = Run {
        point,
        frame,
        input,
        output,
        scratch,
        parcel: parcel.as_mut(),
    };
    if const { F::EVERY_LEVEL } {
        dispatch(job);
    } else {
        dispatch_narrow(job);
    }
}

/// Takes `point` over numbers of another type in f64, tile by tile. Where f64 says that there is no result, the formula in
/// the numbers' own type decides: a coordinate that was rounded to f32 may lie beyond a rim by more than f64 lets out.
pub fn run_in_double<R: Scalar, F, const I: usize, const O: usize>(
    point: F,
    frame: &Frame<f64, I, O>,
    input: Tuples<'_, R, I>,
    mut output: TuplesMut<'_, R, O>,
) where
    F: Point<f64, I, O> + Point<R, I, O>,
{
    let own = frame.cast::<R>();
    let (mut from, mut into) = (Tile::<f64, I>::new(), Tile::<f64, O>::new());
    let (mut before, mut after) = (Tile::<R, I>::new(), Tile::<R, O>::new());
    let count = input.len().min(output.len());
    for first in (0..count).step_by(TILE) {
        let n = TILE.min(count - first);
        // Behind the last point stay numbers of the tile before, which nobody asks for.
        input.read(first, n, &mut before);
        dispatch(Converted(&before, &mut from, n));
        run(point, frame, from.first(n), into.first_mut(n));
        dispatch(Converted(&into, &mut after, n));
        if into.0[0][..n].iter().any(|x| x.is_nan()) {
            for k in 0..n {
                if into.0[0][k].is_nan() {
                    after.set(k, one(point, &own, before.at(k)));
                }
            }
        }
        output.write(first, n, &after);
    }
}

/// The chunks of so many points of a tile, in another float type.
struct Converted<'a, A, B, const N: usize>(&'a Tile<A, N>, &'a mut Tile<B, N>, usize);

impl<A: Scalar, B: Scalar, const N: usize> Job for Converted<'_, A, B, N> {
    type Output = ();

    #[inline(always)]
    fn work(self) {
        let Converted(from, into, n) = self;
        for (from, into) in from.0.iter().zip(&mut into.0) {
            let chunks = from.as_chunks::<W>().0.iter();
            for (from, into) in chunks.zip(into.as_chunks_mut::<W>().0).take(n.div_ceil(W)) {
                for i in 0..W {
                    into[i] = B::new(from[i].to_f64());
                }
            }
        }
    }
}

/// One point, by itself.
fn one<R: Scalar, F: Point<R, I, O>, const I: usize, const O: usize>(
    point: F,
    frame: &Frame<R, I, O>,
    x: [R; I],
) -> [R; O] {
    let x = if F::DIRECTION_IN {
        let x = turned::<R, I, 1>(frame.rotate_input.as_ref(), x, 0);
        std::array::from_fn(|k| x[frame.input.order[k] % I].negated_if(frame.input.negative[k]))
    } else {
        x
    };
    let result = point.apply(x);
    if F::DIRECTION_OUT {
        let rotation = frame.rotate_output.as_ref();
        let result = if O == 6 {
            let result = turned::<R, O, 2>(rotation, result, 0);
            turned::<R, O, 2>(rotation, result, 1)
        } else {
            turned::<R, O, 1>(rotation, result, 0)
        };
        let SignedPermutation { order, negative } = &frame.output;
        std::array::from_fn(|k| result[order[k] % O].negated_if(negative[k]))
    } else {
        result
    }
}

/// The components `first`, `first + STEP`, `first + 2 STEP` multiplied by a matrix.
fn turned<R: Real, const N: usize, const STEP: usize>(
    matrix: Option<&[[R; 3]; 3]>,
    mut x: [R; N],
    first: usize,
) -> [R; N] {
    if let Some(m) = matrix
        && first + 2 * STEP < N
    {
        let d = [0, 1, 2].map(|k| x[first + k * STEP]);
        for (k, row) in m.iter().enumerate() {
            x[first + k * STEP] = row[0] * d[0] + row[1] * d[1] + row[2] * d[2];
        }
    }
    x
}

#[inline(always)]
fn all<R: Scalar, F: Point<R, I, O>, const I: usize, const O: usize>(
    point: F,
    frame: &Frame<R, I, O>,
    input: Tuples<'_, R, I>,
    mut output: TuplesMut<'_, R, O>,
    scratch: &mut Scratch<R, I, O>,
    parcel: Option<&mut Parcel<R, O>>,
) {
    let mut slot: [usize; I] = std::array::from_fn(|k| k);
    if F::DIRECTION_IN {
        for (k, &source) in frame.input.order.iter().enumerate() {
            slot[source % I] = k;
        }
    }
    let mut order: [usize; O] = std::array::from_fn(|k| k);
    if F::DIRECTION_OUT {
        order = frame.output.order;
    }
    // Copies: behind a reference they might change with each number that is stored.
    let (flip_in, flip_out) = (frame.input.negative, frame.output.negative);
    // Without this there are stores past the caches in every kernel.
    let mut parcel = parcel.filter(|_| F::STREAMS);
    for number in 0..input.len().min(output.len()) / W {
        input.load(number, slot, flip_in, &mut scratch.input.0);
        chunk(point, frame, scratch);
        let parcel = parcel.as_deref_mut();
        output.store(number, order, flip_out, &scratch.output.0, parcel);
    }
    if parcel.is_some() {
        stream::finish();
    }
}

#[inline(always)]
fn chunk<R: Scalar, F: Point<R, I, O>, const I: usize, const O: usize>(
    point: F,
    frame: &Frame<R, I, O>,
    scratch: &mut Scratch<R, I, O>,
) {
    let Scratch {
        input: Rows(input),
        output: Rows(output),
    } = scratch;
    if F::DIRECTION_IN
        && let Some(matrix) = &frame.rotate_input
    {
        rotate::<R, I, 1>(matrix, input, 0);
    }
    if F::HAS_NORMAL_FORM && all_normal(input) {
        for i in 0..W {
            let result = point.apply_normal(std::array::from_fn(|k| input[k][i]));
            for k in 0..O {
                output[k][i] = result[k];
            }
        }
    } else {
        for i in 0..W {
            let result = point.apply(std::array::from_fn(|k| input[k][i]));
            for k in 0..O {
                output[k][i] = result[k];
            }
        }
    }
    if F::DIRECTION_OUT
        && let Some(matrix) = &frame.rotate_output
    {
        if O == 6 {
            rotate::<R, O, 2>(matrix, output, 0);
            rotate::<R, O, 2>(matrix, output, 1);
        } else {
            rotate::<R, O, 1>(matrix, output, 0);
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
fn rotate<R: Scalar, const N: usize, const STEP: usize>(
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
