//! Beyond the edges of images whose seams join texel to texel.
//!
//! On three kinds of map what lies beyond an edge is exactly a texel of the image, at any distance: latitude and
//! longitude (the other end of the row; beyond a pole the same row, half a turn around), bands that go around (the other
//! end of the row; the first and last row go on), and octahedral squares (each edge continues at itself, mirrored
//! about its middle). Where the coverage ends the texels at the edge go on. This is the one place that says which
//! texel that is: lookups near an edge and borders of whole images both ask here.
//!
//! A side whose outer texels lie on the edges is mirrored at them and does not repeat them; a row of that kind
//! ends with the texel that it began with. Singular: half a turn around from a texel of a row with an odd number lies
//! between two.

use crate::projections::projection::Seam;

/// Texels (i, j) of a face that stand for a place beyond its edges.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Continued {
    /// This one.
    Texel([usize; 2]),
    /// The mean of both.
    Between([[usize; 2]; 2]),
}

/// A side of a face: how many texels, and whether the outer ones lie on the edges.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Side {
    pub(crate) n: usize,
    pub(crate) on_edges: bool,
}

impl Side {
    /// The texel that mirrors at both ends bring number i back to, and whether it took an odd number of them.
    fn mirrored(self, i: isize) -> (usize, bool) {
        let n = self.n as isize;
        let (period, last) = if self.on_edges {
            (2 * (n - 1), 2 * (n - 1))
        } else {
            (2 * n, 2 * n - 1)
        };
        let i = i.rem_euclid(period.max(1));
        if i > n - 1 {
            ((last - i) as usize, true)
        } else {
            (i as usize, false)
        }
    }

    /// How many texels there are in a turn.
    fn turn(self) -> isize {
        self.n as isize - isize::from(self.on_edges && self.n > 1)
    }

    /// Number i around.
    fn wrapped(self, i: isize) -> usize {
        if (0..self.n as isize).contains(&i) {
            return i as usize;
        }
        i.rem_euclid(self.turn()) as usize
    }

    fn clamped(self, i: isize) -> usize {
        i.clamp(0, self.n as isize - 1) as usize
    }
}

/// What texel (i, j), which may lie anywhere, is on a face with these sides along u and v; none where the seam does not
/// join texel to texel.
pub(crate) fn continued(seam: Seam, [u, v]: [Side; 2], [i, j]: [isize; 2]) -> Option<Continued> {
    let texel = match seam {
        Seam::Latlong => {
            let (row, turned) = v.mirrored(j);
            if turned {
                let turn = u.turn();
                let around = (i + turn / 2).rem_euclid(turn) as usize;
                if turn % 2 != 0 {
                    let next = (i + turn / 2 + 1).rem_euclid(turn) as usize;
                    return Some(Continued::Between([[around, row], [next, row]]));
                }
                [around, row]
            } else {
                [u.wrapped(i), row]
            }
        }
        Seam::Periodic => [u.wrapped(i), v.clamped(j)],
        Seam::Octahedral => {
            let ((column, beside), (row, above)) = (u.mirrored(i), v.mirrored(j));
            [
                if above { u.n - 1 - column } else { column },
                if beside { v.n - 1 - row } else { row },
            ]
        }
        Seam::Ends => [u.clamped(i), v.clamped(j)],
        _ => return None,
    };
    Some(Continued::Texel(texel))
}

#[cfg(test)]
mod tests {
    use super::*;

    const CENTERS: fn(usize) -> Side = |n| Side { n, on_edges: false };
    const CORNERS: fn(usize) -> Side = |n| Side { n, on_edges: true };

    fn texel(seam: Seam, sides: [Side; 2], at: [isize; 2]) -> [usize; 2] {
        match continued(seam, sides, at) {
            Some(Continued::Texel(texel)) => texel,
            other => panic!("{other:?}"),
        }
    }

    #[test]
    fn inside_a_texel_is_itself() {
        for seam in [Seam::Latlong, Seam::Periodic, Seam::Octahedral, Seam::Ends] {
            for side in [CENTERS, CORNERS] {
                for (i, j) in [(0, 0), (4, 0), (2, 3), (4, 4)] {
                    let got = texel(seam, [side(5), side(5)], [i, j]);
                    assert_eq!(got, [i as usize, j as usize], "{seam:?}");
                }
            }
        }
    }

    #[test]
    fn over_a_pole_and_around() {
        let sides = [CENTERS(8), CENTERS(4)];
        assert_eq!(texel(Seam::Latlong, sides, [-1, 2]), [7, 2]);
        assert_eq!(texel(Seam::Latlong, sides, [1, -1]), [5, 0]);
        // Twice over a pole: the rows come back.
        assert_eq!(texel(Seam::Latlong, sides, [3, -8]), [3, 0]);
        assert_eq!(texel(Seam::Periodic, sides, [9, -5]), [1, 0]);
        // A row on the pole is not repeated, and the last column is the first again.
        let sides = [CORNERS(9), CORNERS(5)];
        assert_eq!(texel(Seam::Latlong, sides, [9, 2]), [1, 2]);
        assert_eq!(texel(Seam::Latlong, sides, [0, -1]), [4, 1]);
        let odd = continued(Seam::Latlong, [CENTERS(3), CENTERS(1)], [0, -1]);
        assert_eq!(odd, Some(Continued::Between([[1, 0], [2, 0]])));
    }

    #[test]
    fn edges_of_an_octahedron_continue_at_themselves() {
        let sides = [CENTERS(4); 2];
        assert_eq!(texel(Seam::Octahedral, sides, [0, -1]), [3, 0]);
        assert_eq!(texel(Seam::Octahedral, sides, [-1, 1]), [0, 2]);
        // Beyond a corner lies the opposite one: all four are one direction.
        assert_eq!(texel(Seam::Octahedral, sides, [-1, -1]), [3, 3]);
        assert_eq!(continued(Seam::Faces, sides, [-1, 0]), None);
    }
}
