//! The verbs as kernels: what is compiled for each projection.
//!
//! A formula is compiled once for each float type and level of instructions, and that is nearly all of the library's
//! code and of the time to build it. So there is one kernel a verb, and it computes as many numbers as the projection's own
//! coordinates have: of (u, v, face) in rows it takes the first two, of interleaved ones what a loop that knows no
//! projection leaves ([`narrow`]), and arrangements of faces are a formula of their own ([`crate::map::layout`]). Projections that
//! are not [`COMMON`](Projection::COMMON) have kernels up to AVX2, and for f32 at most those of encoding and decoding
//! ([`SINGLE`](Projection::SINGLE)); the other verbs compute f32 in f64.
//!
//! Everything here runs on the caller's thread.

use crate::geometry::axes::Rotation;
use crate::kernel;
use crate::kernel::tile::{TILE, Tile, Tuples, TuplesMut, W};
use crate::kernel::{
    Formula, Frame, Instructions, Point, Scalar, Scratch, SignedPermutation, each, vectorize,
};
use crate::number::real::{Normal, Real, max};
use crate::projections::projection::Visitor;
use crate::projections::projection::one;
use crate::projections::projection::{Projection, Uv};

/// The direction with its largest component brought near 1, and whether it is a direction at all:
/// finite and not zero.
#[inline(always)]
pub(super) fn prepared<R: Real>([x, y, z]: [R; 3]) -> ([R; 3], R::Mask) {
    let scale = max(x.abs(), max(y.abs(), z.abs())).binade_scale();
    let d = [x * scale, y * scale, z * scale];
    let sum = d[0].abs() + d[1].abs() + d[2].abs();
    let ok = sum.more(R::ZERO) & sum.less(R::new(f64::INFINITY));
    (d, ok)
}

#[inline(always)]
pub(super) fn only_if<R: Real, const N: usize>(ok: R::Mask, x: [R; N]) -> [R; N] {
    x.map(|x| R::choose(ok, x, R::NAN))
}

#[inline(always)]
fn uv<R: Real, const I: usize>(x: [R; I]) -> Uv<R> {
    Uv {
        u: x[0],
        v: x[1],
        face: if I > 2 { x[2] } else { R::ZERO },
    }
}

/// Whether a place lies in the valid image: 0, or NaN. For the baseline only: few are asked.
struct Contains<P>(P);

impl<P: Projection, R: Scalar, const I: usize> Formula<R, I, 1> for Contains<P> {
    #[inline(never)]
    fn fill_rows(&mut self, _: Instructions, chunk: &mut Scratch<R, I, 1>) {
        let p = self.0;
        if const { P::SINGLE } {
            each(
                chunk,
                #[inline(always)]
                |x| only_if(p.contains(uv(x)), [R::ZERO]),
            );
        } else {
            contains_one_by_one(p, chunk);
        }
    }
}

/// Where a lens is inverted for it. A function of its own: in kernels a test looks for calls.
#[inline(never)]
fn contains_one_by_one<P: Projection, R: Scalar, const I: usize>(
    p: P,
    chunk: &mut Scratch<R, I, 1>,
) {
    each(
        chunk,
        #[inline(always)]
        |x| [R::select(one::contains(p, uv(x)), R::ZERO, R::NAN)],
    );
}

/// What f64 finds at those places of a chunk that lie in the image for numbers of this type, if only for these.
fn within<R: Scalar, const I: usize, const O: usize>(
    contains: &mut dyn Formula<R, I, 1>,
    at: Instructions,
    chunk: &mut Scratch<R, I, O>,
    formula: &dyn Fn(Uv<f64>) -> [f64; O],
) {
    let mut lies = Scratch::new();
    lies.input = chunk.input;
    contains.fill_rows(at, &mut lies);
    for (k, lies) in lies.output.0[0].iter().enumerate() {
        let mut found = [R::NAN; O];
        if !lies.is_nan() {
            let place: [f64; I] = std::array::from_fn(|row| chunk.input.0[row][k].to_f64());
            found = formula(uv(place)).map(R::new);
        }
        for (row, found) in chunk.output.0.iter_mut().zip(found) {
            row[k] = found;
        }
    }
}

#[derive(Clone, Copy)]
struct Encode<P>(P);

impl<P: Projection> Encode<P> {
    /// The coordinates of a direction of any length, NaN where it has none.
    #[inline(always)]
    fn whole<R: Real, const O: usize>(self, d: [R; 3]) -> [R; O] {
        let (d, ok) = prepared(d);
        let uv = self.0.encode(d);
        // A face number is never NaN by itself: outside the coverage u is.
        let ok = ok & !uv.u.is_nan();
        let all = only_if(ok, [uv.u, uv.v, uv.face]);
        std::array::from_fn(|k| all[k])
    }
}

impl<P: Projection, R: Scalar, const O: usize> Point<R, 3, O> for Encode<P> {
    const HAS_NORMAL_FORM: bool = true;
    const EVERY_LEVEL: bool = P::COMMON;
    const SINGLE: bool = P::SINGLE;
    const STREAMS: bool = P::MEMORY_BOUND;

    #[inline(always)]
    fn apply(self, d: [R; 3]) -> [R; O] {
        self.whole(d)
    }

    #[inline(always)]
    fn apply_normal(self, d: [R; 3]) -> [R; O] {
        let uv = self.0.encode(d.map(Normal));
        let (Normal(u), Normal(v), Normal(face)) = (uv.u, uv.v, uv.face);
        let face = if O > 2 {
            only_if(!u.is_nan(), [face])[0]
        } else {
            face
        };
        let all = [u, v, face];
        std::array::from_fn(|k| all[k])
    }
}

#[derive(Clone, Copy)]
struct Decode<P>(P);

impl<P: Projection> Decode<P> {
    /// The direction of coordinates, NaN where the image holds nothing.
    #[inline(always)]
    fn whole<R: Real, const I: usize>(self, x: [R; I]) -> [R; 3] {
        only_if(self.0.contains(uv(x)), self.0.decode(uv(x)))
    }
}

impl<P: Projection, R: Scalar, const I: usize> Point<R, I, 3> for Decode<P> {
    const EVERY_LEVEL: bool = P::COMMON;
    const SINGLE: bool = P::SINGLE;
    const STREAMS: bool = P::MEMORY_BOUND;

    #[inline(always)]
    fn apply(self, x: [R; I]) -> [R; 3] {
        self.whole(x)
    }

    fn alone(self, at: Instructions, chunk: &mut Scratch<R, I, 3>) {
        let Decode(p) = self;
        within(&mut Contains(p), at, chunk, &|uv| one::decode(p, uv));
    }
}

#[derive(Clone, Copy)]
struct Jacobian<P>(P);

impl<P: Projection, R: Scalar, const I: usize> Point<R, I, 6> for Jacobian<P> {
    const EVERY_LEVEL: bool = P::COMMON;
    const SINGLE: bool = P::COMMON;

    #[inline(always)]
    fn apply(self, x: [R; I]) -> [R; 6] {
        let [a, b] = self.0.jacobian(uv(x));
        only_if(self.0.contains(uv(x)), [a[0], b[0], a[1], b[1], a[2], b[2]])
    }

    fn alone(self, at: Instructions, chunk: &mut Scratch<R, I, 6>) {
        let Jacobian(p) = self;
        within(&mut Contains(p), at, chunk, &|uv| {
            let [a, b] = one::jacobian(p, uv);
            [a[0], b[0], a[1], b[1], a[2], b[2]]
        });
    }
}

#[derive(Clone, Copy)]
struct Density<P>(P);

impl<P: Projection, R: Scalar, const I: usize> Point<R, I, 1> for Density<P> {
    const EVERY_LEVEL: bool = P::COMMON;
    const SINGLE: bool = P::COMMON;

    #[inline(always)]
    fn apply(self, x: [R; I]) -> [R; 1] {
        only_if(self.0.contains(uv(x)), [self.0.density(uv(x))])
    }

    fn alone(self, at: Instructions, chunk: &mut Scratch<R, I, 1>) {
        let Density(p) = self;
        within(&mut Contains(p), at, chunk, &|uv| [one::density(p, uv)]);
    }
}

/// Puts what a formula gives outside the valid image where a kernel gave NaN, among the first n of a tile.
///
/// Few places are there. Kernels of their own, without the NaN, were a twentieth of the library.
fn beyond<const N: usize>(found: &mut Tile<f64, N>, n: usize, formula: impl Fn(usize) -> [f64; N]) {
    for first in (0..n).step_by(W) {
        let last = n.min(first + W);
        // All of them are looked at, which makes lanes: most have none.
        let any = |any, x: &f64| any | x.is_nan();
        if found.0[0][first..last].iter().fold(false, any) {
            for k in first..last {
                if found.0[0][k].is_nan() {
                    found.set(k, formula(k));
                }
            }
        }
    }
}

/// World directions into the view frame, on the way in.
pub(super) fn frame_in<const O: usize>(turn: Rotation) -> Frame<f64, 3, O> {
    let mut frame = Frame::plain();
    match turn {
        Rotation::Axes(axes) => {
            frame.input = SignedPermutation {
                order: axes.world.map(usize::from),
                negative: axes.negative,
            };
        }
        Rotation::Matrix(m) => frame.rotate_input = Some(m),
    }
    frame
}

/// View directions, or their derivatives by `columns` variables, into the world on the way out.
pub(super) fn frame_out<const I: usize, const O: usize>(turn: Rotation) -> Frame<f64, I, O> {
    let columns = O / 3;
    let mut frame = Frame::plain();
    match turn {
        Rotation::Axes(axes) => {
            let source = |k: usize| axes.world[k / columns] as usize * columns + k % columns;
            frame.output.order = std::array::from_fn(source);
            frame.output.negative = std::array::from_fn(|k| axes.negative[k / columns]);
        }
        Rotation::Matrix(m) => frame.rotate_output = Some(m),
    }
    frame
}

/// Runs a verb of a projection: in kernels for its arrays' type, or in those for f64.
pub(super) fn run<R: Scalar, F, const I: usize, const O: usize>(
    point: F,
    frame: &Frame<f64, I, O>,
    input: Tuples<'_, R, I>,
    output: TuplesMut<'_, R, O>,
) where
    F: Point<f64, I, O> + Point<R, I, O>,
{
    if const { <F as Point<R, I, O>>::SINGLE || size_of::<R>() == size_of::<f64>() } {
        kernel::run(point, &frame.cast::<R>(), input, output);
    } else {
        kernel::double::run_in_double(point, frame, input, output);
    }
}

/// Leaves the face out of (u, v, face).
fn narrow<R: Scalar>(canonical: &[R], flat: &mut [R]) {
    let (canonical, flat) = (canonical.as_chunks::<3>().0, flat.as_chunks_mut::<2>().0);
    vectorize(
        #[inline(always)]
        || {
            for (flat, &[u, v, _]) in flat.iter_mut().zip(canonical) {
                *flat = [u, v];
            }
        },
    );
}

/// Calls `work(uv, out)` with blocks of (u, v) of canonical (u, v, face) and of O numbers each.
fn narrowed<R: Scalar, const O: usize>(
    canonical: &[R],
    out: &mut [R],
    work: impl Fn(&[R], &mut [R]),
) {
    let mut flat = [R::default(); 2 * TILE];
    for (canonical, out) in canonical.chunks(3 * TILE).zip(out.chunks_mut(O * TILE)) {
        let flat = &mut flat[..canonical.len() / 3 * 2];
        narrow(canonical, flat);
        work(flat, out);
    }
}

/// A verb on the projection's own coordinates: (u, v), or (u, v, face) where it has several faces.
macro_rules! own_verb {
    ($(#[$doc:meta])* $verb:ident: $point:expr, $frame:ident, $flat:literal => $out:literal, $wide:literal => $wide_out:literal) => {
        $(#[$doc])*
        pub struct $verb<'a, R> {
            /// World to view for directions that come in, view to world for those that go out.
            pub turn: Rotation,
            /// What goes in.
            pub input: &'a [R],
            /// What comes out.
            pub output: &'a mut [R],
            /// Whether that goes past the caches, if the verb is one that is held up by memory.
            pub past_caches: bool,
        }

        impl<R: Scalar> Visitor for $verb<'_, R> {
            type Output = ();
            fn visit<P: Projection>(self, p: P) {
                let (point, turn) = (($point)(p), self.turn);
                if const { P::INFO.faces == 1 } {
                    let output = TuplesMut::past_caches(self.output, self.past_caches);
                    run::<R, _, $flat, $out>(point, &$frame(turn), Tuples::of(self.input), output);
                } else {
                    let output = TuplesMut::past_caches(self.output, self.past_caches);
                    run::<R, _, $wide, $wide_out>(point, &$frame(turn), Tuples::of(self.input), output);
                }
            }
        }
    };
}

own_verb! {
    /// World directions to the projection's own coordinates.
    EncodeOwn: Encode, frame_in, 3 => 2, 3 => 3
}
own_verb! {
    /// The projection's own coordinates to world directions.
    DecodeOwn: Decode, frame_out, 2 => 3, 3 => 3
}
own_verb! {
    /// ∂d/∂(u, v) in the world at the projection's own coordinates, six numbers each.
    JacobianOwn: Jacobian, frame_out, 2 => 6, 3 => 6
}

/// dω/(du dv) at the projection's own coordinates; NaN outside the valid image.
pub struct DensityOwn<'a, R> {
    /// Coordinates.
    pub input: &'a [R],
    /// Densities.
    pub output: &'a mut [R],
}

impl<R: Scalar> Visitor for DensityOwn<'_, R> {
    type Output = ();
    fn visit<P: Projection>(self, p: P) {
        let point = Density(p);
        let (input, output) = (self.input, TuplesMut::of(self.output));
        if const { P::INFO.faces == 1 } {
            run::<R, _, 2, 1>(point, &Frame::plain(), Tuples::of(input), output);
        } else {
            run::<R, _, 3, 1>(point, &Frame::plain(), Tuples::of(input), output);
        }
    }
}

/// Whether canonical (u, v, face) lie in the valid image.
pub struct ValidCanonical<'a, R> {
    /// Coordinates.
    pub input: &'a [R],
    /// Whether they do.
    pub output: &'a mut [bool],
}

impl<R: Scalar> Visitor for ValidCanonical<'_, R> {
    type Output = ();
    fn visit<P: Projection>(self, p: P) {
        for (uv, valid) in self.input.as_chunks::<3>().0.iter().zip(self.output) {
            let [u, v, face] = uv.map(Scalar::to_f64);
            // As `decode`: where it computes in f64, what lies in the image there does, and what numbers of this type cannot tell.
            *valid = !P::SINGLE && one::contains(p, Uv { u, v, face }) || {
                let [u, v, face] = *uv;
                one::contains(p, Uv { u, v, face })
            };
        }
    }
}

/// Canonical (u, v, face), also beyond a face's edges, to the directions that the image shows there.
pub struct Beyond<'a, R> {
    /// View to world.
    pub turn: Rotation,
    /// Coordinates.
    pub input: &'a [R],
    /// Directions.
    pub output: &'a mut [R],
}

impl<R: Scalar> Visitor for Beyond<'_, R> {
    type Output = ();
    fn visit<P: Projection>(self, p: P) {
        let output = self.output.as_chunks_mut::<3>().0;
        for (uv, d) in self.input.as_chunks::<3>().0.iter().zip(output) {
            let [u, v, face] = uv.map(Scalar::to_f64);
            let there = one::decode(p, p.beyond(Uv { u, v, face }));
            *d = self.turn.apply(there).map(R::new);
        }
    }
}

/// The directions that each face's formula gives at canonical (u, v, face), also beyond the face's edges, in the view
/// frame.
pub struct ContinuedCanonical<'a> {
    /// Coordinates.
    pub input: &'a [f64],
    /// Directions.
    pub output: &'a mut [f64],
}

impl Visitor for ContinuedCanonical<'_> {
    type Output = ();
    fn visit<P: Projection>(self, p: P) {
        let point = Decode(p);
        if const { P::INFO.faces > 1 } {
            let output = TuplesMut::of(&mut *self.output);
            run::<f64, _, 3, 3>(point, &Frame::plain(), Tuples::of(self.input), output);
        } else {
            narrowed::<f64, 3>(self.input, self.output, |input, output| {
                let (input, output) = (Tuples::of(input), TuplesMut::of(output));
                run::<f64, _, 2, 3>(point, &Frame::plain(), input, output);
            });
        }
        let places = self.input.as_chunks::<3>().0.iter();
        for (d, &[u, v, face]) in self.output.as_chunks_mut::<3>().0.iter_mut().zip(places) {
            if d[0].is_nan() {
                *d = one::decode(p, Uv { u, v, face });
            }
        }
    }
}

/// Directions to canonical (u, v, face), in rows.
pub struct EncodeTile<'a, R> {
    /// World to view.
    pub turn: Rotation,
    /// At most [`TILE`] directions.
    pub input: Tuples<'a, R, 3>,
    /// Their coordinates. Where u is NaN the face means nothing.
    pub output: &'a mut Tile<R, 3>,
}

impl<R: Scalar> Visitor for EncodeTile<'_, R> {
    type Output = ();
    fn visit<P: Projection>(self, p: P) {
        let (point, turn, n) = (Encode(p), self.turn, self.input.len());
        if const { P::INFO.faces > 1 } {
            let output = self.output.first_mut(n);
            run::<R, _, 3, 3>(point, &frame_in(turn), self.input, output);
        } else {
            let output = self.output.first_pairs_mut(n);
            run::<R, _, 3, 2>(point, &frame_in(turn), self.input, output);
            self.output.0[2][..n].fill(R::default());
        }
    }
}

/// Canonical (u, v, face), in rows, to directions.
pub struct DecodeTile<'a, R> {
    /// View to world.
    pub turn: Rotation,
    /// Coordinates.
    pub input: &'a Tile<R, 3>,
    /// Room for at most [`TILE`] directions.
    pub output: TuplesMut<'a, R, 3>,
}

fn decode_tile<P: Projection, R: Scalar>(
    point: Decode<P>,
    turn: Rotation,
    input: &Tile<R, 3>,
    output: TuplesMut<'_, R, 3>,
) {
    let n = output.len();
    if const { P::INFO.faces > 1 } {
        run::<R, _, 3, 3>(point, &frame_out(turn), input.first(n), output);
    } else {
        run::<R, _, 2, 3>(point, &frame_out(turn), input.first_pairs(n), output);
    }
}

impl<R: Scalar> Visitor for DecodeTile<'_, R> {
    type Output = ();
    fn visit<P: Projection>(self, p: P) {
        decode_tile(Decode(p), self.turn, self.input, self.output);
    }
}

/// Derivatives of world directions at canonical (u, v, face), in rows: ∂x/∂u, ∂x/∂v, ∂y/∂u and so on. NaN outside
/// the valid image.
pub struct JacobianTile<'a> {
    /// View to world.
    pub turn: Rotation,
    /// Coordinates.
    pub input: &'a Tile<f64, 3>,
    /// How many, at most [`TILE`].
    pub count: usize,
    /// Derivatives.
    pub output: &'a mut Tile<f64, 6>,
}

impl Visitor for JacobianTile<'_> {
    type Output = ();
    fn visit<P: Projection>(self, p: P) {
        let (point, turn, n) = (Jacobian(p), self.turn, self.count);
        let output = self.output.first_mut(n);
        if const { P::INFO.faces > 1 } {
            let input = self.input.first(n);
            run::<f64, _, 3, 6>(point, &frame_out(turn), input, output);
        } else {
            let input = self.input.first_pairs(n);
            run::<f64, _, 2, 6>(point, &frame_out(turn), input, output);
        }
    }
}

/// dω/(du dv) at canonical (u, v, face); NaN outside the valid image.
pub struct DensityCanonical<'a, R> {
    /// Coordinates.
    pub input: &'a [R],
    /// Densities.
    pub output: &'a mut [R],
}

impl<R: Scalar> Visitor for DensityCanonical<'_, R> {
    type Output = ();
    fn visit<P: Projection>(self, p: P) {
        let own = |input: &[R], output: &mut [R]| DensityOwn { input, output }.visit(p);
        if const { P::INFO.faces > 1 } {
            own(self.input, self.output);
        } else {
            narrowed::<R, 1>(self.input, self.output, own);
        }
    }
}

/// One direction of the view frame to canonical (u, v, face), NaN where it has none.
pub struct EncodeOne<R>(pub [R; 3]);

impl<R: Real> Visitor for EncodeOne<R> {
    type Output = [R; 3];
    fn visit<P: Projection>(self, p: P) -> [R; 3] {
        Encode(p).whole(self.0)
    }
}

/// One canonical (u, v, face) to a direction of the view frame, NaN outside the valid image.
pub struct DecodeOne<R>(pub [R; 3]);

impl<R: Real> Visitor for DecodeOne<R> {
    type Output = [R; 3];
    fn visit<P: Projection>(self, p: P) -> [R; 3] {
        Decode(p).whole(self.0)
    }
}

/// World directions spread evenly, by solid angle, over small rectangles of faces: (u0, u1, v0, v1, face)
/// and two numbers in [0, 1], in rows. The density is taken to be linear in each.
pub struct DrawTile<'a> {
    /// View to world.
    pub turn: Rotation,
    /// Rectangles, faces and numbers.
    pub input: &'a Tile<f64, 7>,
    /// How many, at most [`TILE`].
    pub count: usize,
    /// Directions.
    pub output: &'a mut Tile<f64, 3>,
}

/// A number of each point of a tile.
type Row = [f64; TILE];

/// Where the shares `x` of the mass lie on [0, 1] when densities run straight from a to b.
fn shares_of_lines([Tile([a]), Tile([b])]: &[Tile<f64, 1>; 2], x: &mut Row) {
    vectorize(
        #[inline(always)]
        || {
            for ((x, a), b) in x.iter_mut().zip(a).zip(b) {
                let t = (a + b) * *x / (a + (a * a + *x * (b * b - a * a)).sqrt());
                // Both ends zero or one of them infinite: no line, and no place for NaN.
                *x = f64::select(t.at_least(0.0) & t.at_most(1.0), t, *x);
            }
        },
    );
}

/// The numbers that lie so far from a to b.
fn between(a: &Row, b: &Row, share: &Row, into: &mut Row) {
    vectorize(
        #[inline(always)]
        || {
            for (((into, a), b), share) in into.iter_mut().zip(a).zip(b).zip(share) {
                *into = a + share * (b - a);
            }
        },
    );
}

impl Visitor for DrawTile<'_> {
    type Output = ();

    /// By the kernels of density and decoding, step by step. One of its own for each projection, which finds up to four densities, was
    /// two megabytes, and no faster.
    fn visit<P: Projection>(self, p: P) {
        let Tile([left, right, top, bottom, face, across, down]) = self.input;
        let mut at = Tile([*left, *top, *face]);
        let mut densities = [Tile::new(), Tile::new()];
        let find = |at: &Tile<f64, 3>, densities: &mut Tile<f64, 1>| {
            let (point, n) = (Density(p), self.count);
            let output = densities.first_mut(n);
            if const { P::INFO.faces > 1 } {
                run::<f64, _, 3, 1>(point, &Frame::plain(), at.first(n), output);
            } else {
                run::<f64, _, 2, 1>(point, &Frame::plain(), at.first_pairs(n), output);
            }
            beyond(densities, n, |k| [one::density(p, uv(at.at(k)))]);
        };
        let mut share = *down;
        if !P::INFO.equal_area {
            for (middle, (left, right)) in at.0[0].iter_mut().zip(left.iter().zip(right)) {
                *middle = 0.5 * (left + right);
            }
            for (end, densities) in [top, bottom].into_iter().zip(&mut densities) {
                at.0[1] = *end;
                find(&at, densities);
            }
            shares_of_lines(&densities, &mut share);
        }
        between(top, bottom, &share, &mut at.0[1]);
        share = *across;
        if !P::EVEN_ROWS {
            for (end, densities) in [left, right].into_iter().zip(&mut densities) {
                at.0[0] = *end;
                find(&at, densities);
            }
            shares_of_lines(&densities, &mut share);
        }
        between(left, right, &share, &mut at.0[0]);
        let output = self.output.first_mut(self.count);
        decode_tile(Decode(p), self.turn, &at, output);
        beyond(self.output, self.count, |k| {
            self.turn.apply(one::decode(p, uv(at.at(k))))
        });
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::map::Map;
    use crate::projections::REGISTRY;

    #[test]
    fn rows_are_as_even_as_they_are_said_to_be() {
        struct EvenRows;
        impl Visitor for EvenRows {
            type Output = (bool, bool);
            fn visit<P: Projection>(self, p: P) -> (bool, bool) {
                let us = [0.31, 0.37, 0.41, 0.57, 0.63];
                let even = [0.23, 0.42, 0.71].into_iter().all(|v| {
                    let of = us.map(|u| p.density(Uv::flat(u, v)));
                    of.iter()
                        .all(|x| (x / of[0] - 1.0).abs() <= 4.0 * f64::EPSILON)
                });
                (P::EVEN_ROWS, even)
            }
        }
        for info in REGISTRY {
            let map = Map::new(info.name).unwrap();
            let (claimed, found) = map.visit_canonical(EvenRows);
            assert_eq!(claimed, found, "{}", info.name);
        }
    }
}
