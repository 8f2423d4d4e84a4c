//! Tuples of numbers in memory: interleaved, as callers keep them, or a row for each component.
//!
//! Formulas run over rows. What is only handed from one formula to the next stays in rows, a tile at a time:
//! interleaving and separating again took a quarter of the time of a conversion by nearest texels.
//!
//! Nothing here panics or calls within a kernel's loop, which a test of the machine code would mistake for a formula that was
//! not inlined: what does not fill a chunk is padded outside of the loop, and a plain copy of a row would be a call.

use crate::kernel::stream;
use crate::number::real::Real;

/// Points a chunk.
pub(crate) const W: usize = 64;

/// How far ahead the source and the target are fetched, in bytes.
pub(crate) const SOURCE_AHEAD: usize = 3072;
pub(crate) const TARGET_AHEAD: usize = 2048;

/// Points that go from step to step together: small enough for the first-level cache.
pub const TILE: usize = 256;
const _: () = assert!(TILE.is_multiple_of(W));

/// Calls `work` with the whole chunks of as many items, and once more with those that are left among others: in a loop of their own
/// they would want a second copy of the formula.
pub(crate) fn in_chunks<A: Copy, B: Copy>(
    input: &[A],
    output: &mut [B],
    others: (A, B),
    mut work: impl FnMut(&[[A; W]], &mut [[B; W]]),
) {
    let (chunks, input) = input.as_chunks();
    let (results, output) = output.as_chunks_mut();
    work(chunks, results);
    if !input.is_empty() {
        let (mut chunk, mut result) = ([others.0; W], [others.1; W]);
        chunk[..input.len()].copy_from_slice(input);
        work(&[chunk], std::slice::from_mut(&mut result));
        output.copy_from_slice(&result[..output.len()]);
    }
}

/// The rows of a chunk.
#[repr(C, align(64))]
#[derive(Clone, Copy)]
pub(crate) struct Rows<R, const N: usize>(pub [[R; W]; N]);

/// A chunk of tuples one after the other, on its way past the caches.
#[repr(C, align(64))]
#[derive(Clone, Copy)]
pub(crate) struct Parcel<R, const N: usize>(pub [[R; N]; W]);

/// N numbers each of up to [`TILE`] points, a row for each number.
#[derive(Clone, Copy, Debug)]
#[repr(C, align(64))]
pub struct Tile<R, const N: usize>(pub [[R; TILE]; N]);

impl<R: Real, const N: usize> Tile<R, N> {
    /// Zeros.
    pub fn new() -> Self {
        Tile([[R::ZERO; TILE]; N])
    }

    /// The numbers of point k.
    #[inline(always)]
    pub fn at(&self, k: usize) -> [R; N] {
        std::array::from_fn(|row| self.0[row][k])
    }

    /// Sets the numbers of point k.
    #[inline(always)]
    pub fn set(&mut self, k: usize, point: [R; N]) {
        for (row, x) in self.0.iter_mut().zip(point) {
            row[k] = x;
        }
    }

    /// The first n points, to read.
    pub fn first(&self, n: usize) -> Tuples<'_, R, N> {
        let n = n.next_multiple_of(W);
        Tuples::Rows(self.0.each_ref().map(|row| &row[..n]))
    }

    /// The first n points, to write.
    pub fn first_mut(&mut self, n: usize) -> TuplesMut<'_, R, N> {
        let n = n.next_multiple_of(W);
        TuplesMut::Rows(self.0.each_mut().map(|row| &mut row[..n]))
    }
}

impl<R: Real> Tile<R, 3> {
    /// Of the first n points the first two numbers, to read.
    pub fn first_pairs(&self, n: usize) -> Tuples<'_, R, 2> {
        let (n, [u, v, _]) = (n.next_multiple_of(W), &self.0);
        Tuples::Rows([&u[..n], &v[..n]])
    }

    /// The same to write.
    pub fn first_pairs_mut(&mut self, n: usize) -> TuplesMut<'_, R, 2> {
        let (n, [u, v, _]) = (n.next_multiple_of(W), &mut self.0);
        TuplesMut::Rows([&mut u[..n], &mut v[..n]])
    }
}

impl<R: Real, const N: usize> Default for Tile<R, N> {
    fn default() -> Self {
        Tile::new()
    }
}

/// Tuples to read.
#[derive(Clone, Copy, Debug)]
pub enum Tuples<'a, R, const N: usize> {
    /// One after the other.
    Interleaved(&'a [[R; N]]),
    /// A row for each component, of whole chunks: the last ones may mean nothing.
    Rows([&'a [R]; N]),
}

/// Tuples to write.
#[derive(Debug)]
pub enum TuplesMut<'a, R, const N: usize> {
    /// One after the other.
    Interleaved(&'a mut [[R; N]]),
    /// One after the other, past the caches where the place allows it.
    Streamed(&'a mut [[R; N]]),
    /// A row for each component, of whole chunks: nobody asks what is written last.
    Rows([&'a mut [R]; N]),
}

impl<'a, R, const N: usize> Tuples<'a, R, N> {
    /// Numbers that are N a tuple.
    pub fn of(numbers: &'a [R]) -> Self {
        Tuples::Interleaved(numbers.as_chunks().0)
    }
}

impl<'a, R, const N: usize> TuplesMut<'a, R, N> {
    /// Room for numbers, N a tuple.
    pub fn of(numbers: &'a mut [R]) -> Self {
        TuplesMut::Interleaved(numbers.as_chunks_mut().0)
    }

    /// The same, past the caches if that is asked for.
    pub fn past_caches(numbers: &'a mut [R], past: bool) -> Self {
        let tuples = numbers.as_chunks_mut().0;
        if past {
            TuplesMut::Streamed(tuples)
        } else {
            TuplesMut::Interleaved(tuples)
        }
    }
}

impl<'a, R: Real<Mask = bool>, const N: usize> Tuples<'a, R, N> {
    /// How many there are.
    #[inline(always)]
    pub(crate) fn len(&self) -> usize {
        match self {
            Tuples::Interleaved(tuples) => tuples.len(),
            Tuples::Rows(rows) => rows[0].len(),
        }
    }

    /// Those from `first` on, at most [`TILE`].
    pub(crate) fn part(&self, first: usize) -> Self {
        let last = self.len().min(first + TILE);
        match self {
            Tuples::Interleaved(tuples) => Tuples::Interleaved(&tuples[first..last]),
            Tuples::Rows(rows) => Tuples::Rows(rows.map(|row| &row[first..last])),
        }
    }

    /// Those behind the first `first`, fewer than a chunk of them if they are interleaved: as one whole chunk.
    pub(crate) fn rest<'b>(&self, first: usize, padded: &'b mut [[R; N]; W]) -> Tuples<'b, R, N>
    where
        'a: 'b,
    {
        match self {
            Tuples::Interleaved(tuples) => {
                let rest = &tuples[first..];
                padded[..rest.len()].copy_from_slice(rest);
                Tuples::Interleaved(padded)
            }
            Tuples::Rows(rows) => Tuples::Rows(rows.map(|row| &row[first..])),
        }
    }

    /// Brings a chunk into rows: component k into row `slot[k]`, negated where that is asked for of the row.
    #[inline(always)]
    pub(crate) fn load(
        &self,
        number: usize,
        slot: [usize; N],
        negative: [bool; N],
        chunk: &mut [[R; W]; N],
    ) {
        match self {
            Tuples::Interleaved(tuples) => {
                if let Some(tuples) = tuples.as_chunks::<W>().0.get(number) {
                    prefetch(tuples, SOURCE_AHEAD);
                    // Known to be in range, where the compiler sees it.
                    let slot: [usize; N] = std::array::from_fn(|k| slot[k] % N);
                    let negative: [bool; N] = std::array::from_fn(|k| negative[slot[k]]);
                    for i in 0..W {
                        for k in 0..N {
                            chunk[slot[k]][i] = tuples[i][k].negated_if(negative[k]);
                        }
                    }
                }
            }
            Tuples::Rows(rows) => {
                for (k, row) in rows.iter().enumerate() {
                    let slot = slot[k] % N;
                    if let Some(row) = row.as_chunks::<W>().0.get(number) {
                        for i in 0..W {
                            chunk[slot][i] = row[i].negated_if(negative[slot]);
                        }
                    }
                }
            }
        }
    }
}

impl<R: Real<Mask = bool>, const N: usize> TuplesMut<'_, R, N> {
    /// How many there are.
    #[inline(always)]
    pub(crate) fn len(&self) -> usize {
        match self {
            TuplesMut::Interleaved(tuples) | TuplesMut::Streamed(tuples) => tuples.len(),
            TuplesMut::Rows(rows) => rows[0].len(),
        }
    }

    /// Whether whole chunks are to be written past the caches, and can be.
    pub(crate) fn is_streamed(&self) -> bool {
        matches!(self, TuplesMut::Streamed(tuples) if stream::fits(tuples))
    }

    /// The same, for as long as this borrow lasts.
    pub(crate) fn again(&mut self) -> TuplesMut<'_, R, N> {
        match self {
            TuplesMut::Interleaved(tuples) => TuplesMut::Interleaved(tuples),
            TuplesMut::Streamed(tuples) => TuplesMut::Streamed(tuples),
            TuplesMut::Rows(rows) => TuplesMut::Rows(rows.each_mut().map(|row| &mut **row)),
        }
    }

    /// Those from `first` on, at most [`TILE`].
    pub(crate) fn part(&mut self, first: usize) -> TuplesMut<'_, R, N> {
        let last = self.len().min(first + TILE);
        match self {
            TuplesMut::Interleaved(tuples) | TuplesMut::Streamed(tuples) => {
                TuplesMut::Interleaved(&mut tuples[first..last])
            }
            TuplesMut::Rows(rows) => {
                TuplesMut::Rows(rows.each_mut().map(|row| &mut row[first..last]))
            }
        }
    }

    /// Writes one tuple, as [`store`](Self::store) does.
    pub(crate) fn set(
        &mut self,
        place: usize,
        order: [usize; N],
        negative: [bool; N],
        point: [R; N],
    ) {
        for (k, number) in order.map(|k| point[k]).into_iter().enumerate() {
            let number = number.negated_if(negative[k]);
            match self {
                TuplesMut::Interleaved(tuples) | TuplesMut::Streamed(tuples) => {
                    tuples[place][k] = number;
                }
                TuplesMut::Rows(rows) => rows[k][place] = number,
            }
        }
    }

    /// Calls `work` with room for a whole chunk, and takes over what belongs behind the first `first`.
    pub(crate) fn rest(&mut self, first: usize, work: impl FnOnce(TuplesMut<'_, R, N>)) {
        match self {
            TuplesMut::Interleaved(tuples) | TuplesMut::Streamed(tuples) => {
                let mut padded = [[R::ZERO; N]; W];
                work(TuplesMut::Interleaved(&mut padded));
                let rest = &mut tuples[first..];
                rest.copy_from_slice(&padded[..rest.len()]);
            }
            TuplesMut::Rows(rows) => {
                work(TuplesMut::Rows(
                    rows.each_mut().map(|row| &mut row[first..]),
                ));
            }
        }
    }

    /// Writes a chunk: component k from row `order[k]`, negated where that is asked for. By way of a parcel, past the caches:
    /// one is for tuples that are [streamed](Self::is_streamed).
    #[inline(always)]
    pub(crate) fn store(
        &mut self,
        number: usize,
        order: [usize; N],
        negative: [bool; N],
        chunk: &[[R; W]; N],
        past: Option<&mut Parcel<R, N>>,
    ) {
        let chunk: [&[R; W]; N] = std::array::from_fn(|k| &chunk[order[k] % N]);
        match self {
            TuplesMut::Interleaved(tuples) | TuplesMut::Streamed(tuples) => {
                if let Some(tuples) = tuples.as_chunks_mut::<W>().0.get_mut(number) {
                    // A loop for each: where the compiler does not see which of them is written to, it takes number by number.
                    if let Some(Parcel(parcel)) = past {
                        interleave(chunk, negative, parcel);
                        // SAFETY: `fits` was asked of all tuples, by `is_streamed`, and a chunk begins at a multiple of its size.
                        unsafe { stream::copy(parcel, tuples) };
                    } else {
                        prefetch(tuples, TARGET_AHEAD);
                        interleave(chunk, negative, tuples);
                    }
                }
            }
            TuplesMut::Rows(rows) => {
                for (k, row) in rows.iter_mut().enumerate() {
                    if let Some(row) = row.as_chunks_mut::<W>().0.get_mut(number) {
                        for i in 0..W {
                            row[i] = chunk[k][i].negated_if(negative[k]);
                        }
                    }
                }
            }
        }
    }
}

/// Rows, negated where that is asked for, to tuples.
#[inline(always)]
fn interleave<R: Real<Mask = bool>, const N: usize>(
    rows: [&[R; W]; N],
    negative: [bool; N],
    tuples: &mut [[R; N]; W],
) {
    for i in 0..W {
        for k in 0..N {
            tuples[i][k] = rows[k][i].negated_if(negative[k]);
        }
    }
}

/// Asks for the memory `ahead` bytes after each cache line of a chunk.
#[inline(always)]
pub(crate) fn prefetch<T>(chunk: &T, ahead: usize) {
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

/// Asks for the memory of an item that will be read soon, at no cost if it never is.
#[inline(always)]
pub fn prefetch_item<T>(items: &[T], index: usize) {
    #[cfg(target_arch = "x86_64")]
    {
        use std::arch::x86_64::{_MM_HINT_T0, _mm_prefetch};
        let item = items.as_ptr().wrapping_add(index).cast::<i8>();
        // SAFETY: a prefetch is a hint and never faults, whatever the address; `wrapping_add` makes
        // no claim that it lies in the slice.
        unsafe { _mm_prefetch::<_MM_HINT_T0>(item) };
    }
    #[cfg(not(target_arch = "x86_64"))]
    let _ = (items, index);
}
