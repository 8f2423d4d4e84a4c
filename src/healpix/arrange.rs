//! Whole maps from one arrangement into another: ring order, nested order, and the twelve faces as images.
//!
//! On a face, pixels of one x + y lie next to each other on a ring, pixels of one y next to each other in a row of
//! the image, and those of an aligned square of 2ᵏ × 2ᵏ next to each other in nested order. So work goes
//! in squares of [`SIDE`] pixels, which the nearest cache holds whatever the map's size, and what is next to each other is read or
//! written as a piece. Of ring order a task writes some rings, of images some rows of a face, of nested order a square: pieces of
//! the output that follow each other, so that threads share them out.
//!
//! # What did not help
//!
//! Numbers of the source's pixels for the whole map and one gather: eight bytes a pixel more, and a miss for each.

use super::index::{FaceCell, Grid, spread};
use crate::kernel::threads;
use crate::kernel::tile::prefetch_item;
use std::ops::Range;

/// How the values of a whole map lie in memory.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Arrangement {
    /// Along rings from the north.
    Ring,
    /// Face by face along a Z-order curve.
    Nested,
    /// Face by face as images: rows are y, columns x.
    Faces,
}

/// Pixels along the side of a square, a power of two.
const SIDE: usize = 64;

/// What is done with a part of a map: behind a pointer, as it is called once for thousands of pixels.
pub(super) type Then<'t> = &'t (dyn Fn(&mut [u8]) + Sync);

/// How many bytes a pixel has, where the compiler may know.
trait Width: Copy + Send + Sync {
    fn bytes(self) -> usize;
}

#[derive(Clone, Copy)]
struct Fixed<const N: usize>;

impl<const N: usize> Width for Fixed<N> {
    #[inline(always)]
    fn bytes(self) -> usize {
        N
    }
}

#[derive(Clone, Copy)]
struct Any(usize);

impl Width for Any {
    #[inline(always)]
    fn bytes(self) -> usize {
        self.0
    }
}

/// Copies a map of `bytes` bytes a pixel, at least one, into another arrangement; slices hold 12 nside² pixels each. `then`
/// is called with each part of the target while it is in the cache.
pub(super) fn copy(
    grid: Grid,
    bytes: usize,
    source: (Arrangement, &[u8]),
    target: (Arrangement, &mut [u8]),
    then: Then<'_>,
) {
    match bytes {
        1 => Job::new(grid, Fixed::<1>, source).run(target, then),
        2 => Job::new(grid, Fixed::<2>, source).run(target, then),
        4 => Job::new(grid, Fixed::<4>, source).run(target, then),
        8 => Job::new(grid, Fixed::<8>, source).run(target, then),
        12 => Job::new(grid, Fixed::<12>, source).run(target, then),
        16 => Job::new(grid, Fixed::<16>, source).run(target, then),
        _ => Job::new(grid, Any(bytes), source).run(target, then),
    }
}

struct Job<'a, W> {
    grid: Grid,
    side: usize,
    width: W,
    from: Arrangement,
    source: &'a [u8],
    /// The bits of 0 to SIDE - 1, with a zero above each.
    spread: [usize; SIDE],
}

/// Copies `count` pixels that lie next to each other.
#[inline(always)]
fn piece<W: Width>(w: W, source: &[u8], from: usize, target: &mut [u8], to: usize, count: usize) {
    let n = w.bytes();
    target[to * n..][..count * n].copy_from_slice(&source[from * n..][..count * n]);
}

/// Copies `count` pixels that lie next to each other to places of their own.
#[inline(always)]
fn spread_out<W: Width>(
    w: W,
    source: &[u8],
    from: usize,
    count: usize,
    target: &mut [u8],
    to: impl Fn(usize) -> usize,
) {
    let n = w.bytes();
    let pixels = source[from * n..][..count * n].chunks_exact(n);
    for (i, pixel) in pixels.enumerate() {
        target[to(i) * n..][..n].copy_from_slice(pixel);
    }
}

impl<'a, W: Width> Job<'a, W> {
    fn new(grid: Grid, width: W, (from, source): (Arrangement, &'a [u8])) -> Self {
        Job {
            grid,
            side: grid.nside as usize,
            width,
            from,
            source,
            spread: std::array::from_fn(|x| spread(x as i64) as usize),
        }
    }

    fn run(&self, (to, target): (Arrangement, &mut [u8]), then: Then<'_>) {
        let points = 12 * self.side * self.side;
        if self.from == to {
            let chunk = SIDE * SIDE * self.width.bytes();
            return threads::rows(target, chunk, points, |k, out| {
                out.copy_from_slice(&self.source[k * chunk..][..out.len()]);
                then(out);
            });
        }
        match to {
            Arrangement::Faces => self.rows(points, target, then),
            Arrangement::Nested => self.squares(points, target, then),
            Arrangement::Ring => self.rings(points, target, then),
        }
    }

    /// The first pixel of a square in nested order.
    fn nested(&self, face: usize, x: usize, y: usize) -> usize {
        let [face, x, y] = [face, x, y].map(|i| i as i64);
        self.grid.nested(FaceCell { face, x, y }) as usize
    }

    /// Writes images: a task is as many rows of a face as a square has.
    fn rows(&self, points: usize, target: &mut [u8], then: Then<'_>) {
        let (n, w) = (self.side, self.width);
        let faces = target.chunks_mut(n * n * w.bytes()).enumerate();
        let tasks = faces.flat_map(|(face, out)| {
            let rows = out.chunks_mut(SIDE * n * w.bytes()).enumerate();
            rows.map(move |(k, out)| (face, k * SIDE, out))
        });
        // A list, as it tells how many there are.
        let tasks: Vec<_> = tasks.collect();
        threads::each(points, tasks.into_iter(), |(face, y, out)| {
            let rows = y..n.min(y + SIDE);
            if self.from == Arrangement::Nested {
                for x in (0..n).step_by(SIDE) {
                    let side = SIDE.min(n);
                    let first = self.nested(face, x, y) * w.bytes();
                    let source = &self.source[first..][..side * side * w.bytes()];
                    self.unravel(source, side, out, x, n);
                }
            } else {
                let mut scratch = vec![0; SIDE * SIDE * w.bytes()];
                for sum in (y..rows.end - 1 + n).step_by(SIDE) {
                    self.fetch_rings(face, sum + SIDE, &rows);
                    self.slanted(face, sum, rows.clone(), &mut scratch, out);
                }
            }
            then(out);
        });
    }

    /// Writes the cells of some rows in which x + y is from `sum` to `sum` + SIDE - 1: pieces of that length of both rings and rows.
    #[inline(always)]
    fn slanted(
        &self,
        face: usize,
        sum: usize,
        rows: Range<usize>,
        scratch: &mut [u8],
        out: &mut [u8],
    ) {
        let (n, w) = (self.side, self.width);
        for s in sum..(sum + SIDE).min(rows.end - 1 + n) {
            let (low, high) = self.rows_of(s, &rows);
            let to = |k: usize| (high - 1 - k - rows.start) * SIDE + s - sum;
            self.on_ring(
                face,
                s + 1 - high,
                high - 1,
                high - low,
                |from, k, count| {
                    spread_out(w, self.source, from, count, scratch, |i| to(k + i));
                },
            );
        }
        for y in rows.clone() {
            let (low, high) = (sum.max(y), (sum + SIDE).min(y + n));
            if low < high {
                let from = (y - rows.start) * SIDE + low - sum;
                let to = (y - rows.start) * n + low - y;
                piece(w, scratch, from, out, to, high - low);
            }
        }
    }

    /// Asks for what [`Job::slanted`] will read.
    #[inline(always)]
    fn fetch_rings(&self, face: usize, sum: usize, rows: &Range<usize>) {
        for s in sum..(sum + SIDE).min(rows.end - 1 + self.side) {
            let (low, high) = self.rows_of(s, rows);
            self.on_ring(
                face,
                s + 1 - high,
                high - 1,
                high - low,
                |from, _, count| {
                    self.fetch(from, count);
                },
            );
        }
    }

    /// Asks for pixels that lie next to each other.
    #[inline(always)]
    fn fetch(&self, from: usize, count: usize) {
        let bytes = self.width.bytes();
        for place in (from * bytes..(from + count) * bytes).step_by(64) {
            prefetch_item(self.source, place);
        }
        prefetch_item(self.source, (from + count) * bytes - 1);
    }

    /// Those of some rows in which x + y is `sum` at a cell of the face.
    #[inline(always)]
    fn rows_of(&self, sum: usize, rows: &Range<usize>) -> (usize, usize) {
        let low = rows.start.max((sum + 1).saturating_sub(self.side));
        (low, rows.end.min(sum + 1))
    }

    /// Writes a square of nested order into rows that are `stride` pixels apart, from column `x` on.
    #[inline(always)]
    fn unravel(&self, source: &[u8], side: usize, out: &mut [u8], x: usize, stride: usize) {
        let w = self.width;
        for row in 0..side {
            let (from, to) = (2 * self.spread[row], row * stride + x);
            if side == 1 {
                piece(w, source, from, out, to, 1);
            }
            // Two at a time: those of x and x + 1 lie next to each other, x even.
            for k in 0..side / 2 {
                piece(w, source, from | self.spread[2 * k], out, to + 2 * k, 2);
            }
        }
    }

    /// Reads a square from rings into rows that are SIDE pixels apart.
    #[inline(always)]
    fn diagonals(&self, face: usize, x: usize, y: usize, side: usize, out: &mut [u8]) {
        let w = self.width;
        for sum in 0..2 * side - 1 {
            let first = (sum + 1).saturating_sub(side);
            let count = sum + 1 - 2 * first;
            let to = |k: usize| (sum - first - k) * SIDE + first + k;
            self.on_ring(face, x + first, y + sum - first, count, |from, k, count| {
                // Toward larger x and smaller y.
                spread_out(w, self.source, from, count, out, |i| to(k + i));
            });
        }
    }

    /// Asks for what [`Job::diagonals`] will read for the square of a nested pixel.
    #[inline(always)]
    fn fetch_diagonals(&self, pixel: usize, side: usize) {
        if pixel >= 12 * self.side * self.side {
            return;
        }
        let cell = self.grid.cell_of_nested(pixel as i64);
        let [face, x, y] = [cell.face, cell.x, cell.y].map(|i| i as usize);
        for sum in 0..2 * side - 1 {
            let first = (sum + 1).saturating_sub(side);
            let count = sum + 1 - 2 * first;
            self.on_ring(face, x + first, y + sum - first, count, |from, _, count| {
                self.fetch(from, count);
            });
        }
    }

    /// Calls `work(number, k, count)` on the one or two pieces of ring order that make `count` cells of a diagonal, from (x, y)
    /// toward larger x: `count` pixels from `number` on are the cells from the k-th on.
    #[inline(always)]
    fn on_ring(
        &self,
        face: usize,
        x: usize,
        y: usize,
        count: usize,
        mut work: impl FnMut(usize, usize, usize),
    ) {
        let [face, x, y] = [face, x, y].map(|i| i as i64);
        let place = self.grid.ring_of_cell(FaceCell { face, x, y });
        let (first, number) = self.grid.along_ring(place);
        // West of longitude 0 a ring ends.
        let west = (-number).clamp(0, count as i64) as usize;
        if west > 0 {
            work((first + 4 * place.quadrant + number) as usize, 0, west);
        }
        if west < count {
            work((first + number) as usize + west, west, count - west);
        }
    }

    /// Writes nested order: a task is a square.
    fn squares(&self, points: usize, target: &mut [u8], then: Then<'_>) {
        let (n, w) = (self.side, self.width);
        let side = SIDE.min(n);
        let each = side * side;
        threads::rows(target, each * w.bytes(), points, |k, out| {
            let cell = self.grid.cell_of_nested((k * each) as i64);
            let [face, x, y] = [cell.face, cell.x, cell.y].map(|i| i as usize);
            if self.from == Arrangement::Faces {
                self.ravel(self.source, (face * n + y) * n + x, n, side, out);
            } else {
                let mut scratch = vec![0; SIDE * SIDE * w.bytes()];
                self.fetch_diagonals((k + 1) * each, side);
                self.diagonals(face, x, y, side, &mut scratch);
                self.ravel(&scratch, 0, SIDE, side, out);
            }
            then(out);
        });
    }

    /// Writes a square in nested order, from rows that are `stride` pixels apart.
    #[inline(always)]
    fn ravel(&self, source: &[u8], first: usize, stride: usize, side: usize, out: &mut [u8]) {
        let w = self.width;
        for row in 0..side {
            let (from, to) = (first + row * stride, 2 * self.spread[row]);
            if side == 1 {
                piece(w, source, from, out, to, 1);
            }
            for k in 0..side / 2 {
                piece(w, source, from + 2 * k, out, to | self.spread[2 * k], 2);
            }
        }
    }

    /// Writes rings: a task is SIDE of them, all around.
    fn rings(&self, points: usize, target: &mut [u8], then: Then<'_>) {
        let (n, w) = (self.side, self.width);
        let mut rest = target;
        let tasks = (1..4 * n).step_by(SIDE).map(|ring| {
            let end = (ring + SIDE).min(4 * n);
            let pixels: usize = (ring..end).map(|r| 4 * r.min(4 * n - r).min(n)).sum();
            let (out, others) = std::mem::take(&mut rest).split_at_mut(pixels * w.bytes());
            rest = others;
            (ring, end, out)
        });
        threads::each(points, tasks, |(ring, end, out)| {
            let mut scratch = vec![0; SIDE * SIDE * w.bytes()];
            let start = self.grid.first_of_ring(ring as i64) as usize;
            for face in 0..12 {
                self.strip(face, ring, end, start, &mut scratch, out);
            }
            then(out);
        });
    }

    /// Writes what lies on a face of the rings from `ring` to before `end`, of which `start` is the first pixel.
    #[inline(always)]
    fn strip(
        &self,
        face: usize,
        ring: usize,
        end: usize,
        start: usize,
        scratch: &mut [u8],
        out: &mut [u8],
    ) {
        let (n, w) = (self.side, self.width);
        // On ring r of the face x + y is `northern` - r.
        let northern = (face / 4 + 2) * n - 1;
        let Some(most) = northern.checked_sub(ring) else {
            return;
        };
        let sums = (northern + 1).saturating_sub(end)..(most + 1).min(2 * n - 1);
        if sums.is_empty() {
            return;
        }
        for y in (0..n.min(most + 1)).step_by(SIDE) {
            let rows = y..n.min(y + SIDE);
            if self.from == Arrangement::Faces {
                for y in y + SIDE..n.min(y + 2 * SIDE) {
                    let (low, high) = (sums.start.max(y), sums.end.min(y + n));
                    if low < high {
                        self.fetch((face * n + y) * n + low - y, high - low);
                    }
                }
            }
            // By rows into the scratch, a line of it for each ring, ...
            for y in rows.clone() {
                let (low, high) = (sums.start.max(y), sums.end.min(y + n));
                if low < high {
                    let to = |s: usize| (most - s) * SIDE + rows.end - 1 - y;
                    self.row(face, y, low..high, to, scratch);
                }
            }
            // ... and by lines out.
            for s in sums.clone() {
                let (low, high) = self.rows_of(s, &rows);
                if low < high {
                    let line = (most - s) * SIDE + rows.end - high;
                    self.on_ring(
                        face,
                        s + 1 - high,
                        high - 1,
                        high - low,
                        |number, k, count| {
                            piece(w, scratch, line + k, out, number - start, count);
                        },
                    );
                }
            }
        }
    }

    /// Reads the cells of a row in which x + y is some numbers into places of the scratch.
    #[inline(always)]
    fn row(
        &self,
        face: usize,
        y: usize,
        sums: Range<usize>,
        to: impl Fn(usize) -> usize,
        scratch: &mut [u8],
    ) {
        let w = self.width;
        if self.from == Arrangement::Faces {
            let first = (face * self.side + y) * self.side;
            let (from, count) = (first + sums.start - y, sums.len());
            spread_out(w, self.source, from, count, scratch, |i| to(sums.start + i));
            return;
        }
        let mut s = sums.start;
        while s < sums.end {
            // Within an aligned square the number of a pixel is the first's with the bits of x.
            let aligned = (s - y) & !(SIDE - 1);
            let first = self.nested(face, aligned, y);
            let stop = sums.end.min(aligned + SIDE + y);
            for s in s..stop {
                let from = first | self.spread[s - y - aligned];
                piece(w, self.source, from, scratch, to(s), 1);
            }
            s = stop;
        }
    }
}
