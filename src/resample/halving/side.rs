//! Along one side of a face: which texels of a level those of the next one cover, and the parts that these are cut into.
//!
//! Where a side is odd, texels of the next level end within those of this one. A part has a solid angle of its own: by its share of the side alone
//! coarse texels near a pole or a rim would have up to a sixth more light than they cover, or less.

use crate::map::grid::GridAxis;

/// What of a texel's side is less than this is rounding.
const NOTHING: f64 = 1e-9;

/// A texel that is covered, and the number of the part of it.
#[derive(Clone, Copy)]
pub(super) struct Covers {
    pub(super) texel: usize,
    pub(super) part: usize,
}

pub(super) struct Side {
    /// For each texel of the next level what it covers, in order.
    pub(super) across: Vec<Vec<Covers>>,
    /// The texel that each part is of.
    pub(super) texels: Vec<usize>,
    /// Where parts begin and, last, where they end.
    pub(super) edges: Vec<f64>,
    /// Whether parts are the texels themselves.
    pub(super) whole: bool,
}

impl Side {
    /// Of so many texels, and as many as are wanted of the next level.
    pub(super) fn new(fine: GridAxis, count: usize, coarse: GridAxis, wanted: usize) -> Side {
        let mut side = Side {
            across: Vec::with_capacity(wanted),
            texels: Vec::new(),
            edges: Vec::new(),
            whole: true,
        };
        let (mut first, mut end) = (0, 0.0);
        for i in 0..wanted {
            let (low, high) = coarse.cell(i);
            while first + 1 < count && fine.cell(first).1 <= low {
                first += 1;
            }
            let mut covered = Vec::new();
            for texel in first..count {
                let (from, to) = fine.cell(texel);
                if from >= high {
                    break;
                }
                let (mut begins, mut ends) = (low.max(from), high.min(to));
                let share = (ends - begins) / (to - from);
                if share <= NOTHING {
                    continue;
                }
                if share >= 1.0 - NOTHING {
                    (begins, ends) = (from, to);
                } else {
                    side.whole = false;
                }
                let part = side.texels.len();
                covered.push(Covers { texel, part });
                side.texels.push(texel);
                side.edges.push(begins);
                end = ends;
            }
            side.across.push(covered);
        }
        side.edges.push(end);
        side.whole &= side.texels.iter().copied().eq(0..count);
        side
    }
}
