//! Numbers of another type, computed in f64.
//!
//! Formulas for which f32 is not worth a kernel of its own, or is not enough, run in f64 over tuples of f32. To what walks over these they are a
//! formula in f32, which widens the rows of a chunk before and rounds them behind, in lanes.
//!
//! Where f64 says that there is no result, the formula in the numbers' own type decides ([`Point::alone`]): a coordinate that was rounded to f32
//! may lie beyond a rim by more than f64 lets out. The points of a tile for which that is asked go together.
//!
//! What did not help: a tile that was read, widened, given to [`run`](super::run), rounded and written, each by a pass of its
//! own, cost 3 to 5 ns a point more than the formula, which may take 2. A walk of its own, a tile at a time: as fast, and 150 kB.

use crate::kernel::tile::{Rows, TILE, Tile, Tuples, TuplesMut, W};
use crate::kernel::{Formula, Frame, Instructions, Point, Scalar, Scratch, run_formula};

/// Takes `point` over numbers of another type in f64.
pub fn run_in_double<R: Scalar, F, const I: usize, const O: usize>(
    mut point: F,
    frame: &Frame<f64, I, O>,
    input: Tuples<'_, R, I>,
    output: TuplesMut<'_, R, O>,
) where
    F: Point<f64, I, O> + Point<R, I, O>,
{
    let mut alone = Alone(point);
    run_formula_in_double(&mut point, &mut alone, frame, input, output);
}

/// A formula as what f64 has no result for asks it.
struct Alone<F>(F);

impl<R: Scalar, F: Point<R, I, O>, const I: usize, const O: usize> Formula<R, I, O> for Alone<F> {
    fn fill_rows(&mut self, at: Instructions, chunk: &mut Scratch<R, I, O>) {
        self.0.alone(at, chunk);
    }
}

fn run_formula_in_double<R: Scalar, const I: usize, const O: usize>(
    formula: &mut dyn Formula<f64, I, O>,
    alone: &mut dyn Formula<R, I, O>,
    frame: &Frame<f64, I, O>,
    input: Tuples<'_, R, I>,
    mut output: TuplesMut<'_, R, O>,
) {
    let own = frame.cast();
    let in_place = Frame {
        rotate_input: None,
        rotate_output: None,
        ..own
    };
    let mut doubled = Doubled {
        formula,
        frame,
        wide: Scratch::new(),
        count: 0,
        done: 0,
        missing: 0,
        places: [0; TILE],
        asked: Tile::new(),
    };
    let mut chunk = Scratch::new();
    let count = input.len().min(output.len());
    for first in (0..count).step_by(TILE) {
        doubled.count = TILE.min(count - first);
        doubled.done = 0;
        doubled.missing = 0;
        let mut output = output.part(first);
        run_formula(
            &mut doubled,
            false,
            &in_place,
            input.part(first),
            output.again(),
        );
        for first in (0..doubled.missing).step_by(W) {
            let places = &doubled.places[first..doubled.missing.min(first + W)];
            for (row, asked) in chunk.input.0.iter_mut().zip(&doubled.asked.0) {
                row.copy_from_slice(&asked[first..first + W]);
                // What nobody asks for is nowhere, which is told soonest.
                row[places.len()..].fill(R::NAN);
            }
            own.rotate_in(&mut chunk.input);
            alone.fill_rows(Instructions::in_force(), &mut chunk);
            own.rotate_out(&mut chunk.output);
            for (k, &place) in places.iter().enumerate() {
                let found = std::array::from_fn(|row| chunk.output.0[row][k]);
                output.set(place, own.output.order, own.output.negative, found);
            }
        }
    }
}

/// A formula in f64 as one in R, for the chunks of a tile one after the other.
struct Doubled<'a, R, const I: usize, const O: usize> {
    formula: &'a mut dyn Formula<f64, I, O>,
    /// Of which rotations are done here, in f64.
    frame: &'a Frame<f64, I, O>,
    wide: Scratch<f64, I, O>,
    /// Points of the tile, and those before this chunk.
    count: usize,
    done: usize,
    /// Points for which there was no result, where in the tile they are, and what they are.
    missing: usize,
    places: [usize; TILE],
    asked: Tile<R, I>,
}

impl<R: Scalar, const I: usize, const O: usize> Formula<R, I, O> for Doubled<'_, R, I, O> {
    fn fill_rows(&mut self, at: Instructions, chunk: &mut Scratch<R, I, O>) {
        at.vectorize_narrow(
            #[inline(always)]
            || {
                convert(&chunk.input, &mut self.wide.input);
                self.frame.rotate_in(&mut self.wide.input);
            },
        );
        self.formula.fill_rows(at, &mut self.wide);
        let missing = at.vectorize_narrow(
            #[inline(always)]
            || {
                self.frame.rotate_out(&mut self.wide.output);
                convert(&self.wide.output, &mut chunk.output);
                let any = |any, x: &R| any | x.is_nan();
                chunk.output.0[0].iter().fold(false, any)
            },
        );
        if missing {
            self.note_missing(chunk);
        }
        self.done += W;
    }
}

impl<R: Scalar, const I: usize, const O: usize> Doubled<'_, R, I, O> {
    #[inline(never)]
    fn note_missing(&mut self, chunk: &Scratch<R, I, O>) {
        let before = self.missing;
        let count = W.min(self.count - self.done);
        for (k, x) in chunk.output.0[0][..count].iter().enumerate() {
            self.places[self.missing % TILE] = self.done + k;
            self.missing += usize::from(x.is_nan());
        }
        for k in before..self.missing {
            let place = self.places[k] % W;
            self.asked
                .set(k, std::array::from_fn(|row| chunk.input.0[row][place]));
        }
    }
}

/// The rows of a chunk, in another float type.
#[inline(always)]
fn convert<A: Scalar, B: Scalar, const N: usize>(
    Rows(from): &Rows<A, N>,
    Rows(into): &mut Rows<B, N>,
) {
    for (from, into) in from.iter().zip(into) {
        for i in 0..W {
            into[i] = B::new(from[i].to_f64());
        }
    }
}
