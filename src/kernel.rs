//! Slices in, slices out: the only file that knows about instruction sets.
//!
//! A [`Point`] is a formula from I numbers to O numbers. [`run`] takes it over arrays of such tuples:
//! chunks of 64 points are de-interleaved into an aligned structure-of-arrays buffer, the formula runs
//! over the buffer as a plain loop that the compiler vectorises, and the results are interleaved again.
//! The loop is compiled for the baseline, for AVX2 and for AVX-512 (on x86-64) and chosen at run time.
//! No lane types, no intrinsics but the prefetch: every level runs the same operations in the same order,
//! without fused multiply-add, and so gives the same bits.
//!
//! What decided the shape, measured: 64 points a chunk (16 or 32 were 1.2 to 2 times slower, 256 slower
//! again); a buffer that the caller of the dispatched function owns (made inside, it lost its alignment,
//! 1.4×); software prefetch of source and target (0.80 → 1.20 of a copy); `#[inline(always)]` on
//! everything below `run` (one missing made a kernel five times slower). Streaming stores did not help:
//! below the cache's size they cost more than half.

use crate::real::Real;
use fearless_simd::{Level, Simd};
use std::sync::atomic::{AtomicU8, Ordering};

/// Points a chunk.
const W: usize = 64;

/// How far ahead the source and the target are fetched, in bytes.
const SOURCE_AHEAD: usize = 3072;
const TARGET_AHEAD: usize = 2048;

/// A float type that arrays hold.
pub trait Scalar: Real + Default + Send + Sync {}
impl Scalar for f32 {}
impl Scalar for f64 {}

/// A formula from I numbers to O numbers.
pub trait Point<R, const I: usize, const O: usize>: Copy + Send + Sync {
    /// One point.
    fn apply(self, x: [R; I]) -> [R; O];
}

/// Which component goes where, with its sign: the exact part of a change of frame.
#[derive(Clone, Copy, Debug)]
pub struct Lanes<R, const N: usize> {
    /// Component k is taken from here.
    pub order: [usize; N],
    /// And multiplied by ±1.
    pub signs: [R; N],
}

impl<R: Real, const N: usize> Lanes<R, N> {
    /// Every component stays.
    pub fn identity() -> Self {
        Lanes {
            order: std::array::from_fn(|k| k),
            signs: [R::new(1.0); N],
        }
    }
}

/// What happens to the three rows of a direction besides the formula.
#[derive(Clone, Copy, Debug)]
pub struct Frame<R, const I: usize, const O: usize> {
    /// Components on the way in.
    pub input: Lanes<R, I>,
    /// Components on the way out.
    pub output: Lanes<R, O>,
    /// A rotation of the input's three components, before `input`.
    pub rotate_input: Option<[[R; 3]; 3]>,
    /// A rotation of the output's three components (each of O/3 columns), before `output`.
    pub rotate_output: Option<[[R; 3]; 3]>,
}

impl<R: Real, const I: usize, const O: usize> Frame<R, I, O> {
    /// Everything stays where it is.
    pub fn plain() -> Self {
        Frame {
            input: Lanes::identity(),
            output: Lanes::identity(),
            rotate_input: None,
            rotate_output: None,
        }
    }
}

#[repr(C, align(64))]
#[derive(Clone, Copy)]
struct Rows<R, const N: usize>([[R; W]; N]);

struct Scratch<R, const I: usize, const O: usize> {
    input: Rows<R, I>,
    view: Rows<R, I>,
    result: Rows<R, O>,
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
pub fn levels() -> &'static [&'static str] {
    &LEVELS[..available()]
}

/// The level that kernels run at.
pub fn level() -> &'static str {
    match FORCED.load(Ordering::Relaxed) {
        0 => LEVELS[available() - 1],
        forced => LEVELS[forced as usize - 1],
    }
}

/// Makes kernels run at this level, or at the best one again. False if this CPU does not have it.
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

/// Takes `point` over `input`, I numbers a point, into `output`, O numbers a point.
pub fn run<R: Scalar, F: Point<R, I, O>, const I: usize, const O: usize>(
    point: F,
    frame: &Frame<R, I, O>,
    input: &[R],
    output: &mut [R],
) {
    let zero = R::default();
    let (rows_in, rows_out) = (Rows([[zero; W]; I]), Rows([[zero; W]; O]));
    let mut scratch = Scratch {
        input: rows_in,
        view: rows_in,
        result: rows_out,
        output: rows_out,
    };
    dispatch(
        point,
        frame,
        input.as_chunks().0,
        output.as_chunks_mut().0,
        &mut scratch,
    );
}

#[inline(never)]
fn dispatch<R: Scalar, F: Point<R, I, O>, const I: usize, const O: usize>(
    point: F,
    frame: &Frame<R, I, O>,
    input: &[[R; I]],
    output: &mut [[R; O]],
    scratch: &mut Scratch<R, I, O>,
) {
    #[cfg(target_arch = "x86_64")]
    {
        let forced = FORCED.load(Ordering::Relaxed);
        let best = Level::new();
        if (forced == 0 || forced > 2)
            && let Some(token) = best.as_avx512()
        {
            return token.vectorize(
                #[inline(always)]
                || all(point, frame, input, output, scratch),
            );
        }
        if forced != 1
            && let Some(token) = best.as_avx2()
        {
            return token.vectorize(
                #[inline(always)]
                || all(point, frame, input, output, scratch),
            );
        }
    }
    all(point, frame, input, output, scratch);
}

#[inline(always)]
fn all<R: Scalar, F: Point<R, I, O>, const I: usize, const O: usize>(
    point: F,
    frame: &Frame<R, I, O>,
    input: &[[R; I]],
    output: &mut [[R; O]],
    scratch: &mut Scratch<R, I, O>,
) {
    let (inputs, input_rest) = input.as_chunks::<W>();
    let (outputs, output_rest) = output.as_chunks_mut::<W>();
    for (source, target) in inputs.iter().zip(outputs) {
        prefetch(source, SOURCE_AHEAD);
        prefetch(target, TARGET_AHEAD);
        chunk(point, frame, source, target, scratch);
    }
    let rest = input_rest.len();
    if rest > 0 {
        let mut source = [[R::default(); I]; W];
        let mut target = [[R::default(); O]; W];
        source[..rest].copy_from_slice(input_rest);
        chunk(point, frame, &source, &mut target, scratch);
        output_rest.copy_from_slice(&target[..rest]);
    }
}

#[inline(always)]
fn chunk<R: Scalar, F: Point<R, I, O>, const I: usize, const O: usize>(
    point: F,
    frame: &Frame<R, I, O>,
    source: &[[R; I]; W],
    target: &mut [[R; O]; W],
    scratch: &mut Scratch<R, I, O>,
) {
    let Scratch {
        input: Rows(input),
        view: Rows(view),
        result: Rows(result),
        output: Rows(output),
    } = scratch;
    for i in 0..W {
        for k in 0..I {
            input[k][i] = source[i][k];
        }
    }
    if let Some(matrix) = &frame.rotate_input {
        rotate::<R, I, 1>(matrix, input, 0);
    }
    // Whole rows change places, so that every loop over points has fixed addresses: with rows chosen
    // inside the loop the compiler kept a scalar copy of the formula, for rows that might overlap.
    for k in 0..I {
        view[k] = input[frame.input.order[k] % I];
    }
    // Copies: behind a reference they might change with each result that is stored.
    let (signs_in, signs_out) = (frame.input.signs, frame.output.signs);
    for i in 0..W {
        let point = point.apply(std::array::from_fn(|k| signs_in[k] * view[k][i]));
        for k in 0..O {
            result[k][i] = point[k];
        }
    }
    if let Some(matrix) = &frame.rotate_output {
        if O == 6 {
            rotate::<R, O, 2>(matrix, result, 0);
            rotate::<R, O, 2>(matrix, result, 1);
        } else {
            rotate::<R, O, 1>(matrix, result, 0);
        }
    }
    for k in 0..O {
        output[k] = result[frame.output.order[k] % O];
    }
    for i in 0..W {
        for k in 0..O {
            target[i][k] = signs_out[k] * output[k][i];
        }
    }
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

/// Asks for the memory `ahead` bytes after each cache line of a chunk.
#[inline(always)]
fn prefetch<T>(chunk: &T, ahead: usize) {
    #[cfg(target_arch = "x86_64")]
    {
        use std::arch::x86_64::{_MM_HINT_T0, _mm_prefetch};
        let start = std::ptr::from_ref(chunk).cast::<i8>();
        let mut offset = 0;
        while offset < size_of::<T>() {
            // SAFETY: a prefetch is a hint and never faults, whatever the address; `wrapping_add` makes
            // no claim that it lies in the slice.
            unsafe { _mm_prefetch::<_MM_HINT_T0>(start.wrapping_add(ahead + offset)) };
            offset += 64;
        }
    }
    #[cfg(not(target_arch = "x86_64"))]
    let _ = (chunk, ahead);
}
