//! A smooth piece of a border in the source's plane, and what it does to the cells that it passes.
//!
//! Coordinates count source cells. An [`Arc`] is a cubic, which is split at the lines between cells into [`Piece`]s.
//! By Green's theorem the area of a region is the sum over its border of ∫ x dy: in its own cell a piece adds what lies
//! between it and the cell's right side, and to each cell further right in the row the whole width (as renderers of
//! fonts do it, cell by cell, for pixels). Besides the area these sums are taken for the moments up to second
//! order, so that what a cell weighs follows from any density that is quadratic there.

/// A point of the plane, in cells.
pub(in crate::resample::area) type PlanePoint = [f64; 2];

/// p(t) = from + t·(along + (1 - t)·(bend + (1 - 2t)·twist)) for t from 0 to 1.
#[derive(Clone, Copy, Debug)]
pub(in crate::resample::area) struct Arc {
    from: PlanePoint,
    along: PlanePoint,
    bend: PlanePoint,
    twist: PlanePoint,
}

/// What the part of an arc inside one cell adds.
#[derive(Clone, Copy, Debug)]
pub(in crate::resample::area) struct Piece {
    /// The cell.
    pub at: [u32; 2],
    /// ∫ of 1, X, Y, X², XY, Y² between it and the cell's right side; X and Y from the cell's center.
    pub own: [f64; 6],
    /// ∫ of 1, Y, Y² across each cell further right, a width of 1.
    pub right: [f64; 3],
}

impl Arc {
    pub fn line(from: PlanePoint, to: PlanePoint) -> Arc {
        Arc {
            from,
            along: minus(to, from),
            bend: [0.0; 2],
            twist: [0.0; 2],
        }
    }

    /// The cubic through three places, half a step apart each, with this third difference in the middle.
    #[inline(always)]
    pub fn through([a, b, c]: [PlanePoint; 3], third: PlanePoint) -> Arc {
        let along = minus(c, a);
        Arc {
            from: a,
            along,
            bend: [0, 1].map(|k| 4.0 * (b[k] - 0.5 * (a[k] + c[k]))),
            twist: [0, 1].map(|k| third[k] * (2.0 / 3.0)),
        }
    }

    /// Its numbers: from, along, bend and twist.
    #[cfg(test)]
    pub fn numbers(&self) -> [f64; 8] {
        let mut numbers = [0.0; 8];
        let all = [self.from, self.along, self.bend, self.twist];
        numbers.copy_from_slice(all.as_flattened());
        numbers
    }

    #[inline(always)]
    fn at(&self, axis: usize, t: f64) -> f64 {
        let s = 1.0 - t;
        let bent = self.bend[axis] + (s - t) * self.twist[axis];
        self.from[axis] + t * (self.along[axis] + s * bent)
    }

    #[inline(always)]
    fn slope(&self, axis: usize, t: f64) -> f64 {
        self.along[axis]
            + (1.0 - 2.0 * t) * self.bend[axis]
            + (1.0 - 6.0 * t + 6.0 * t * t) * self.twist[axis]
    }

    /// Where a coordinate turns back, if on the way.
    #[inline(always)]
    fn turn(&self, axis: usize) -> f64 {
        let (a, b, c) = (self.along[axis], self.bend[axis], self.twist[axis]);
        if b.abs() <= a.abs() {
            return 1.0;
        }
        let mut turn = 0.5 + 0.5 * a / b;
        // For the twist.
        for _ in 0..2 {
            let step = self.slope(axis, turn) / (12.0 * c * turn - 6.0 * c - 2.0 * b);
            if step.abs() < 0.1 {
                turn -= step;
            }
        }
        turn.clamp(0.0, 1.0)
    }

    /// Where a coordinate that grows (`up`) or falls meets a line.
    #[inline(always)]
    fn meets(&self, axis: usize, line: f64, up: bool) -> f64 {
        let sign = if up { 1.0 } else { -1.0 };
        // Where a + b t + c t² passes zero on its way up; NaN becomes 0.
        let passes = |a: f64, b: f64, c: f64| {
            let root = (b * b - 4.0 * a * c).max(0.0).sqrt();
            let t = if b >= 0.0 {
                -2.0 * a / (b + root)
            } else {
                (root - b) / (2.0 * c)
            };
            if t.is_nan() { 0.0 } else { t }
        };
        let (bend, twist) = (self.bend[axis], self.twist[axis]);
        let from = sign * (self.from[axis] - line);
        let mut t = passes(from, sign * (self.along[axis] + bend), -sign * bend);
        if twist != 0.0 {
            // Parabolas that touch it: beside a turning point a step along the tangent goes astray, and one through the ends
            // with the bend that the twist leaves there comes closer by a factor of five only.
            for _ in 0..2 {
                t = t.clamp(0.0, 1.0);
                let half_curve = (6.0 * t - 3.0) * twist - bend;
                t += passes(
                    sign * (self.at(axis, t) - line),
                    sign * self.slope(axis, t),
                    sign * half_curve,
                );
            }
        }
        t
    }

    /// Appends its pieces in a plane of `columns` × `rows` cells.
    #[inline(always)]
    pub fn pieces(&self, limits: [usize; 2], pieces: &mut Vec<Piece>) {
        let (x, y) = (self.turn(0), self.turn(1));
        let cuts = [0.0, x.min(y), x.max(y), 1.0];
        for k in 0..3 {
            self.monotone(cuts[k], cuts[k + 1], limits, pieces);
        }
    }

    /// The same for a part on which no coordinate turns back.
    #[inline(always)]
    fn monotone(&self, start: f64, end: f64, limits: [usize; 2], pieces: &mut Vec<Piece>) {
        if start >= end {
            return;
        }
        let mut at = [0; 2];
        let mut up = [true; 2];
        let mut left = [0_u32; 2];
        let mut line = [0.0; 2];
        for axis in [0, 1] {
            let (a, b) = (self.at(axis, start), self.at(axis, end));
            up[axis] = b >= a;
            let last = limits[axis] as i32 - 1;
            let (p, q) = (cell(up[axis], a, last), cell(!up[axis], b, last));
            at[axis] = p as u32;
            left[axis] = if up[axis] == (q >= p) {
                p.abs_diff(q)
            } else {
                0
            };
            line[axis] = f64::from(p + i32::from(up[axis]));
        }
        let next = |axis: usize, left: [u32; 2], line: [f64; 2]| {
            if left[axis] == 0 {
                end
            } else {
                // NaN becomes `start`.
                self.meets(axis, line[axis], up[axis]).max(start).min(end)
            }
        };
        let mut t = start;
        let mut meet = [next(0, left, line), next(1, left, line)];
        while left[0] + left[1] > 0 {
            let axis = if left[0] == 0 {
                1
            } else if left[1] == 0 {
                0
            } else {
                usize::from(meet[1] < meet[0])
            };
            let stop = meet[axis].max(t);
            pieces.push(self.piece(at, t, stop));
            t = stop;
            left[axis] -= 1;
            if up[axis] {
                at[axis] += 1;
                line[axis] += 1.0;
            } else {
                at[axis] -= 1;
                line[axis] -= 1.0;
            }
            meet[axis] = next(axis, left, line);
        }
        pieces.push(self.piece(at, t, end));
    }

    /// By two places of Gauss, which is exact for the area of a parabola.
    #[inline(always)]
    fn piece(&self, at: [u32; 2], start: f64, end: f64) -> Piece {
        const OFF: f64 = 0.288_675_134_594_812_9;
        let (middle, length) = (0.5 * (start + end), end - start);
        let center = at.map(|k| f64::from(k) + 0.5);
        let mut piece = Piece {
            at,
            own: [0.0; 6],
            right: [0.0; 3],
        };
        for t in [middle - OFF * length, middle + OFF * length] {
            let (x, y) = (self.at(0, t) - center[0], self.at(1, t) - center[1]);
            let w = 0.5 * length * self.slope(1, t);
            let (a, b) = (w * (x - 0.5), w * 0.5 * (x * x - 0.25));
            piece.own[0] += a;
            piece.own[1] += b;
            piece.own[2] += a * y;
            piece.own[3] += w * (1.0 / 3.0) * (x * x * x - 0.125);
            piece.own[4] += b * y;
            piece.own[5] += a * y * y;
            piece.right[0] -= w;
            piece.right[1] -= w * y;
            piece.right[2] -= w * y * y;
        }
        piece
    }
}

/// The cell of a coordinate; of one on a line, the further one if it starts there (`low`), else the nearer.
#[inline(always)]
fn cell(low: bool, x: f64, last: i32) -> i32 {
    // Coordinates are hardly ever negative: this is `floor` and `ceil` without a call.
    let whole = x as i32;
    let nearer = i32::from(!low && f64::from(whole) >= x);
    (whole - nearer).clamp(0, last)
}

#[inline(always)]
pub(in crate::resample::area) fn minus(a: PlanePoint, b: PlanePoint) -> PlanePoint {
    [a[0] - b[0], a[1] - b[1]]
}

/// The third difference in the middle and the fourth, of five places with equal steps between them.
#[inline(always)]
pub(in crate::resample::area) fn differences(q: [PlanePoint; 5]) -> (PlanePoint, f64) {
    let third = [0, 1].map(|k| 0.5 * (q[4][k] - q[0][k]) - (q[3][k] - q[1][k]));
    let fourth = [0, 1].map(|k| q[4][k] - 4.0 * q[3][k] + 6.0 * q[2][k] - 4.0 * q[1][k] + q[0][k]);
    (third, fourth[0].abs() + fourth[1].abs())
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The moments of each cell of a plane.
    fn cells(arcs: &[Arc], [columns, rows]: [usize; 2]) -> Vec<[f64; 6]> {
        let mut pieces = Vec::new();
        arcs.iter()
            .for_each(|arc| arc.pieces([columns, rows], &mut pieces));
        let mut cells = vec![[0.0; 6]; columns * rows];
        for piece in pieces {
            let [x, y] = piece.at.map(|k| k as usize);
            for (sum, own) in cells[y * columns + x].iter_mut().zip(piece.own) {
                *sum += own;
            }
            let [a, b, c] = piece.right;
            for cell in &mut cells[y * columns..][x + 1..columns] {
                for (sum, more) in cell.iter_mut().zip([a, 0.0, b, a / 12.0, 0.0, c]) {
                    *sum += more;
                }
            }
        }
        cells
    }

    #[test]
    fn a_rectangle_and_its_moments() {
        let corners = [[0.25, 0.5], [2.5, 0.5], [2.5, 1.75], [0.25, 1.75]];
        let arcs = [0, 1, 2, 3].map(|k| Arc::line(corners[k], corners[(k + 1) % 4]));
        let got = cells(&arcs, [3, 2]);
        let part = |k: usize, low: f64, high: f64| {
            let center = k as f64 + 0.5;
            let (a, b) = (
                low.max(center - 0.5) - center,
                high.min(center + 0.5) - center,
            );
            [b - a, (b * b - a * a) / 2.0, (b * b * b - a * a * a) / 3.0]
        };
        for y in 0..2 {
            for x in 0..3 {
                let (p, q) = (part(x, 0.25, 2.5), part(y, 0.5, 1.75));
                let want = [
                    p[0] * q[0],
                    p[1] * q[0],
                    p[0] * q[1],
                    p[2] * q[0],
                    p[1] * q[1],
                    p[0] * q[2],
                ];
                for (got, want) in got[y * 3 + x].iter().zip(want) {
                    assert!((got - want).abs() < 1e-14, "{x} {y} {got} {want}");
                }
            }
        }
    }

    #[test]
    fn a_disk() {
        // Sixty-four arcs: each errs by the fifth power of its length.
        let circle = |k: f64| {
            let a = k * std::f64::consts::PI / 32.0;
            [2.6 + 2.1 * a.cos(), 2.4 + 2.1 * a.sin()]
        };
        let arcs: Vec<Arc> = (0..64)
            .map(|k| {
                let q = [-0.5, 0.0, 0.5, 1.0, 1.5].map(|s| circle(f64::from(k) + s));
                Arc::through([q[1], q[2], q[3]], differences(q).0)
            })
            .collect();
        let got = cells(&arcs, [5, 5]);
        let area: f64 = got.iter().map(|cell| cell[0]).sum();
        assert!(
            (area / (std::f64::consts::PI * 2.1 * 2.1) - 1.0).abs() < 1e-7,
            "{area}"
        );
        assert!((got[12][0] - 1.0).abs() < 1e-7 && got.iter().all(|cell| cell[0] > -1e-7));
    }
}
