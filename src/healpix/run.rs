//! One step from I numbers to O others over arrays of them, vectorized and in threads.

use crate::kernel;
use crate::kernel::Job;
use crate::kernel::threads;
use crate::kernel::tile::{SOURCE_AHEAD, TARGET_AHEAD, W, in_chunks, prefetch};

/// What arrays hold, as steps compute with it.
pub trait Wide: Copy + Default + Sync {
    /// Of eight bytes, like every result: where loads and stores of a loop differ in size, the compiler keeps a scalar loop
    /// in case they overlap.
    type Number: Copy + Default;

    /// The same number.
    fn wide(self) -> Self::Number;
}

macro_rules! wide {
    ($from:ty, $to:ty) => {
        impl Wide for $from {
            type Number = $to;

            #[inline(always)]
            fn wide(self) -> $to {
                self.into()
            }
        }
    };
}
wide!(f32, f64);
wide!(f64, f64);
wide!(i64, i64);

/// What happens to one point; `#[inline(always)]`.
pub(super) trait Step<A, B, const I: usize, const O: usize>: Copy + Send + Sync {
    fn apply(self, x: [A; I]) -> [B; O];
}

#[repr(C, align(64))]
struct Scratch<A, B, const I: usize, const O: usize> {
    input: [[A; W]; I],
    output: [[B; W]; O],
}

struct Loop<'a, S, A: Wide, B, const I: usize, const O: usize> {
    step: S,
    input: &'a [[[A; I]; W]],
    output: &'a mut [[[B; O]; W]],
    scratch: &'a mut Scratch<A::Number, B, I, O>,
}

impl<S, A, B, const I: usize, const O: usize> Job for Loop<'_, S, A, B, I, O>
where
    S: Step<A::Number, B, I, O>,
    A: Wide,
    B: Copy + Default,
{
    type Output = ();

    #[inline(always)]
    fn work(self) {
        // A copy: behind a reference it might change with each number that is stored, and the compiler keeps a scalar
        // loop for that.
        let step = self.step;
        for (source, target) in self.input.iter().zip(self.output) {
            prefetch(source, SOURCE_AHEAD);
            prefetch(target, TARGET_AHEAD);
            chunk(step, source, target, self.scratch);
        }
    }
}

#[inline(always)]
fn chunk<S, A, B, const I: usize, const O: usize>(
    step: S,
    source: &[[A; I]; W],
    target: &mut [[B; O]; W],
    scratch: &mut Scratch<A::Number, B, I, O>,
) where
    S: Step<A::Number, B, I, O>,
    A: Wide,
    B: Copy,
{
    let Scratch { input, output } = scratch;
    for i in 0..W {
        for k in 0..I {
            input[k][i] = source[i][k].wide();
        }
    }
    for i in 0..W {
        let result = step.apply(std::array::from_fn(|k| input[k][i]));
        for k in 0..O {
            output[k][i] = result[k];
        }
    }
    for i in 0..W {
        for k in 0..O {
            target[i][k] = output[k][i];
        }
    }
}

/// Takes a step over arrays of points, I numbers a point in and O out.
pub(super) fn run<S, A, B, const I: usize, const O: usize>(step: S, input: &[A], output: &mut [B])
where
    S: Step<A::Number, B, I, O>,
    A: Wide,
    B: Copy + Default + Send,
{
    threads::blocks(input, I, output, O, |input, output| {
        let mut scratch = Scratch {
            input: [[A::Number::default(); W]; I],
            output: [[B::default(); W]; O],
        };
        let (points, results) = (input.as_chunks().0, output.as_chunks_mut().0);
        let others = ([A::default(); I], [B::default(); O]);
        in_chunks(points, results, others, |input, output| {
            kernel::dispatch(Loop {
                step,
                input,
                output,
                scratch: &mut scratch,
            });
        });
    });
}

/// Takes a step whose arms differ too much to be vectorized over arrays of points, I numbers a point in and O out.
pub(super) fn run_one_by_one<S, A, B, const I: usize, const O: usize>(
    step: S,
    input: &[A],
    output: &mut [B],
) where
    S: Step<A::Number, B, I, O>,
    A: Wide,
    B: Copy + Default + Send,
{
    threads::blocks(input, I, output, O, |input, output| {
        let points = input.as_chunks::<I>().0;
        for (x, result) in points.iter().zip(output.as_chunks_mut::<O>().0) {
            *result = step.apply(x.map(Wide::wide));
        }
    });
}
