//! Pixels as integers: nested numbers, ring numbers, cells of faces and places on rings. All exact.

// An `if` may become a branch, which keeps the loop from being vectorized.
use std::hint::select_unpredictable as choose;

/// A pixel by its face and its place there: x north-east, y north-west, from the southern corner.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct FaceCell {
    /// 0 to 11.
    pub face: i64,
    /// 0 to nside - 1.
    pub x: i64,
    /// 0 to nside - 1.
    pub y: i64,
}

/// A pixel by its ring.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct OnRing {
    /// From the north, 1 to 4 nside - 1.
    pub ring: i64,
    /// Pixels in a quadrant of it.
    pub quadrant: i64,
    /// Longitude of the center in half pixels, of which the ring has 8 `quadrant`; negative west of 0 or
    /// counted around it.
    pub halves: i64,
}

/// A division of the sphere.
#[derive(Clone, Copy, Debug)]
pub struct Grid {
    /// Pixels along a side of a face.
    pub nside: i64,
    order: u32,
    /// Pixels in rings shorter than those at the equator, on one side.
    cap: i64,
    pixels: i64,
    per_equatorial: f64,
}

/// a·b for numbers of 32 bits: one instruction where a product of 64 takes many. What is computed of other numbers, for a
/// choice that is not made, may wrap.
#[inline(always)]
fn product(a: i64, b: i64) -> i64 {
    const LOW: i64 = 0xffff_ffff;
    (a & LOW).wrapping_mul(b & LOW)
}

/// How often n goes into a number below 5 n.
#[inline(always)]
fn few_times(a: i64, n: i64) -> i64 {
    i64::from(a >= n) + i64::from(a >= 2 * n) + i64::from(a >= 3 * n) + i64::from(a >= 4 * n)
}

/// 1.5·2⁵²: a whole number of less than 51 bits, added to it, is its lowest bits.
const MAGIC: f64 = 1.5 / f64::EPSILON;

/// A whole number of less than 51 bits as a double, without the conversion that old levels lack.
#[inline(always)]
pub fn double(x: i64) -> f64 {
    f64::from_bits(MAGIC.to_bits().wrapping_add(x as u64)) - MAGIC
}

/// The largest whole number not above a double of less than 51 bits.
#[inline(always)]
pub fn floor(x: f64) -> i64 {
    let nearest = x + MAGIC;
    let above = nearest - MAGIC > x;
    nearest.to_bits().wrapping_sub(MAGIC.to_bits()) as i64 - i64::from(above)
}

/// The double next to a number of up to 63 bits that is not negative, within 2 units in the last place.
#[inline(always)]
fn long_double(x: i64) -> f64 {
    double((x as u64 >> 32) as i64) * 4_294_967_296.0 + double(x & 0xffff_ffff)
}

/// The bits of a 32-bit number, with a zero above each.
#[inline(always)]
pub fn spread(x: i64) -> i64 {
    let x = (x | (x << 16)) & 0x0000_ffff_0000_ffff;
    let x = (x | (x << 8)) & 0x00ff_00ff_00ff_00ff;
    let x = (x | (x << 4)) & 0x0f0f_0f0f_0f0f_0f0f;
    let x = (x | (x << 2)) & 0x3333_3333_3333_3333;
    (x | (x << 1)) & 0x5555_5555_5555_5555
}

/// The even bits of a number, moved together.
#[inline(always)]
fn gathered(x: i64) -> i64 {
    let x = x & 0x5555_5555_5555_5555;
    let x = (x | (x >> 1)) & 0x3333_3333_3333_3333;
    let x = (x | (x >> 2)) & 0x0f0f_0f0f_0f0f_0f0f;
    let x = (x | (x >> 4)) & 0x00ff_00ff_00ff_00ff;
    let x = (x | (x >> 8)) & 0x0000_ffff_0000_ffff;
    (x | (x >> 16)) & 0x0000_0000_ffff_ffff
}

impl Grid {
    /// nside from 1 to 2²⁹.
    pub fn new(nside: i64) -> Grid {
        Grid {
            nside,
            order: nside.ilog2(),
            cap: 2 * nside * (nside - 1),
            pixels: 12 * nside * nside,
            per_equatorial: 0.25 / nside as f64,
        }
    }

    /// The pixel and true, or one that exists and false.
    #[inline(always)]
    pub fn checked(self, pixel: i64) -> (i64, bool) {
        let is_pixel = (pixel >= 0) & (pixel < self.pixels);
        (choose(is_pixel, pixel, 0), is_pixel)
    }

    /// The nested number of a cell; nside is a power of two.
    #[inline(always)]
    pub fn nested(self, cell: FaceCell) -> i64 {
        (cell.face << (2 * self.order)) | spread(cell.x) | (spread(cell.y) << 1)
    }

    /// The cell of a nested number.
    #[inline(always)]
    pub fn cell_of_nested(self, pixel: i64) -> FaceCell {
        let face = pixel >> (2 * self.order);
        let within = pixel - (face << (2 * self.order));
        FaceCell {
            face,
            x: gathered(within),
            y: gathered(within >> 1),
        }
    }

    /// Where a cell's center lies on its ring.
    #[inline(always)]
    pub fn ring_of_cell(self, FaceCell { face, x, y }: FaceCell) -> OnRing {
        let n = self.nside;
        let row = face >> 2;
        let ring = product(row + 2, n) - x - y - 1;
        let quadrant = self.quadrant(ring);
        // Eighths of a turn: equatorial faces are centered on longitude 0, the others half a face east.
        let eighths = 2 * (face & 3) + i64::from(row != 1);
        OnRing {
            ring,
            quadrant,
            halves: product(eighths, quadrant) + x - y,
        }
    }

    /// Pixels in a quadrant of a ring.
    #[inline(always)]
    pub fn quadrant(self, ring: i64) -> i64 {
        let n = self.nside;
        let south = 4 * n - ring;
        let shorter = choose(ring < south, ring, south);
        choose(shorter < n, shorter, n)
    }

    /// The ring number of a place.
    #[inline(always)]
    pub fn ring(self, place: OnRing) -> i64 {
        let (first, number) = self.along_ring(place);
        first + number + choose(number < 0, 4 * place.quadrant, 0)
    }

    /// The first ring number of a place's ring, and how many pixels east of that it is: negative from the other end.
    #[inline(always)]
    pub fn along_ring(self, place: OnRing) -> (i64, i64) {
        // A ring's first center is half a pixel east of longitude 0, or on it: then `halves` is even.
        (self.first(place.ring, place.quadrant), place.halves >> 1)
    }

    /// The first number of a ring.
    pub fn first_of_ring(self, ring: i64) -> i64 {
        self.first(ring, self.quadrant(ring))
    }

    #[inline(always)]
    fn first(self, ring: i64, quadrant: i64) -> i64 {
        let n = self.nside;
        let northern = product(quadrant, quadrant - 1).wrapping_mul(2);
        let southern = product(quadrant, quadrant + 1).wrapping_mul(-2);
        let southern = self.pixels.wrapping_add(southern);
        let between = product(ring - n, n).wrapping_mul(4).wrapping_add(self.cap);
        let first = choose(ring < n, northern, between);
        choose(ring > 3 * n, southern, first)
    }

    /// The place of a ring number.
    #[inline(always)]
    pub fn on_ring(self, pixel: i64) -> OnRing {
        let n = self.nside;
        let mirrored = self.pixels - 1 - pixel;
        let nearer = choose(pixel < mirrored, pixel, mirrored);
        let south = pixel > mirrored;
        // Caps: the quadrant q for which 2 q (q - 1) pixels come before it.
        let q = floor(0.5 + (0.25 + 0.5 * long_double(nearer)).sqrt());
        let q = q - i64::from(2 * product(q, q - 1) > nearer);
        let q = q + i64::from(2 * product(q, q + 1) <= nearer);
        let along = nearer - 2 * product(q, q - 1);
        let along = choose(south, 4 * q - 1 - along, along);
        // Between them: rings of 4 nside.
        let from_cap = pixel - self.cap;
        let rows = floor(long_double(from_cap) * self.per_equatorial);
        let rest = from_cap.wrapping_sub(product(rows, n).wrapping_mul(4));
        let before = i64::from(rest < 0);
        let beyond = i64::from(rest >= 4 * n);
        let rows = rows - before + beyond;
        let rest = rest.wrapping_add(4 * n * (before - beyond));
        let in_cap = nearer < self.cap;
        OnRing {
            ring: choose(in_cap, choose(south, 4 * n - q, q), n + rows),
            quadrant: choose(in_cap, q, n),
            halves: choose(in_cap, 2 * along + 1, (rest << 1) + 1 - (rows & 1)),
        }
    }

    /// The cell of a place that [`Grid::on_ring`] found.
    #[inline(always)]
    pub fn cell(self, place: OnRing) -> FaceCell {
        let OnRing {
            ring,
            quadrant,
            halves,
        } = place;
        let n = self.nside;
        // Along the two diagonals; a center is half a pixel off both.
        let falling = (halves + ring - n) >> 1;
        let rising = (halves + 3 * n - ring) >> 1;
        let equatorial = self.between(falling, rising);
        let along = halves >> 1;
        let turn = few_times(along, quadrant);
        let polar = self.in_cap(
            turn,
            ring > 2 * n,
            along - product(turn, quadrant),
            quadrant - 1,
        );
        let in_cap = (ring < n) | (ring > 3 * n);
        FaceCell {
            face: choose(in_cap, polar.face, equatorial.face),
            x: choose(in_cap, polar.x, equatorial.x),
            y: choose(in_cap, polar.y, equatorial.y),
        }
    }

    /// A cell of the belt between the caps by its numbers along the diagonals, each below 5 nside.
    #[inline(always)]
    pub fn between(self, falling: i64, rising: i64) -> FaceCell {
        let n = self.nside;
        self.belt(falling, rising, few_times(falling, n), few_times(rising, n))
    }

    /// The same for those in which nside goes f and r times.
    #[inline(always)]
    pub fn belt(self, falling: i64, rising: i64, f: i64, r: i64) -> FaceCell {
        let n = self.nside;
        let face = choose(f == r, (f & 3) + 4, r + 8);
        let face = choose(f < r, f, face);
        FaceCell {
            face,
            x: rising - product(r, n),
            y: n - 1 - (falling - product(f, n)),
        }
    }

    /// A cell of a cap: its quadrant of a turn, its number along the ring in there and the largest one.
    #[inline(always)]
    pub fn in_cap(self, turn: i64, south: bool, along: i64, most: i64) -> FaceCell {
        let n = self.nside;
        let back = most - along;
        FaceCell {
            face: turn + choose(south, 8, 0),
            x: choose(south, along, n - 1 - back),
            y: choose(south, back, n - 1 - along),
        }
    }

    /// The eight cells around one: south-west, west, north-west and so on clockwise to south; none where
    /// only three faces meet.
    pub fn around(self, cell: FaceCell) -> [Option<FaceCell>; 8] {
        const STEPS: [(i64, i64); 8] = [
            (-1, 0),
            (-1, 1),
            (0, 1),
            (1, 1),
            (1, 0),
            (1, -1),
            (0, -1),
            (-1, -1),
        ];
        STEPS.map(|(dx, dy)| self.beside(cell.face, cell.x + dx, cell.y + dy))
    }

    /// Whether all around a cell lie on its face.
    #[inline(always)]
    pub fn is_inside(self, FaceCell { x, y, .. }: FaceCell) -> bool {
        let last = self.nside - 1;
        (x > 0) & (x < last) & (y > 0) & (y < last)
    }

    /// The nested numbers around a cell [inside](Self::is_inside) its face, in the order of [`around`](Self::around).
    #[inline(always)]
    pub fn nested_around(self, FaceCell { face, x, y }: FaceCell) -> [i64; 8] {
        let face = face << (2 * self.order);
        let [a, b, c] = [spread(x - 1), spread(x), spread(x + 1)];
        let [d, e, f] = [spread(y - 1) << 1, spread(y) << 1, spread(y + 1) << 1];
        [a | e, a | f, b | f, c | f, c | e, c | d, b | d, a | d].map(|within| face | within)
    }

    /// The ring numbers: on five rings, whose first pixels all eight have in common.
    #[inline(always)]
    pub fn ring_around(self, cell: FaceCell) -> [i64; 8] {
        let OnRing { ring, .. } = self.ring_of_cell(cell);
        let eighths = 2 * (cell.face & 3) + i64::from(cell.face >> 2 != 1);
        let across = cell.x - cell.y;
        let on = |ring: i64, steps: [i64; 2]| -> [i64; 2] {
            let quadrant = self.quadrant(ring);
            let first = self.first(ring, quadrant);
            let middle = product(eighths, quadrant) + across;
            let number = |step: i64| {
                let number = (middle + step) >> 1;
                first + number + choose(number < 0, 4 * quadrant, 0)
            };
            [number(steps[0]), number(steps[1])]
        };
        let [north, _] = on(ring - 2, [0, 0]);
        let [north_west, north_east] = on(ring - 1, [-1, 1]);
        let [west, east] = on(ring, [-2, 2]);
        let [south_west, south_east] = on(ring + 1, [-1, 1]);
        let [south, _] = on(ring + 2, [0, 0]);
        [
            south_west, west, north_west, north, north_east, east, south_east, south,
        ]
    }

    /// The cell at x and y of a face, from -1 to nside.
    fn beside(self, face: i64, x: i64, y: i64) -> Option<FaceCell> {
        let n = self.nside;
        let (row, column) = (face >> 2, face & 3);
        let [east, opposite, west] = [1, 2, 3].map(|turn| (column + turn) & 3);
        let side = |t: i64| i64::from(t >= n) - i64::from(t < 0);
        // North-east is +x, north-west +y.
        let (face, x, y) = match (side(x), side(y), row) {
            (0, 0, _) => (face, x, y),
            (1, 0, 0) => (east, y, n - 1),
            (1, 0, 1) => (column, 0, y),
            (1, 0, _) => (4 + east, 0, y),
            (-1, 0, 0) => (4 + column, n - 1, y),
            (-1, 0, 1) => (8 + west, n - 1, y),
            (-1, 0, _) => (8 + west, y, 0),
            (0, 1, 0) => (west, n - 1, x),
            (0, 1, 1) => (west, x, 0),
            (0, 1, _) => (4 + column, x, 0),
            (0, -1, 0) => (4 + east, x, n - 1),
            (0, -1, 1) => (8 + column, x, n - 1),
            (0, -1, _) => (8 + east, 0, x),
            // Across a pole, and over the vertices of four faces on the equator.
            (1, 1, 0) => (opposite, n - 1, n - 1),
            (1, 1, 2) => (column, 0, 0),
            (-1, -1, 0) => (8 + column, n - 1, n - 1),
            (-1, -1, 2) => (8 + opposite, 0, 0),
            (1, -1, 1) => (4 + east, 0, n - 1),
            (-1, 1, 1) => (4 + west, n - 1, 0),
            _ => return None,
        };
        Some(FaceCell { face, x, y })
    }
}
