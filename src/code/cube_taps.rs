//! The four texels of a bilinear lookup on a cube, across its edges.
//!
//! Beyond an edge lies the texel of the neighbor's first row that has the same number along the edge, and at a corner, where
//! three faces meet, there is no fourth texel: the three share its weight, so that the lookup is continuous and what is
//! constant stays so. That is what graphics hardware does (OpenGL 4.6, section 8.14.3, seamless cube map filtering), here
//! of any layout, order and orientation of faces. `sample` is of second order over an edge, and mixes up to twelve texels
//! there (`resample/sample/edges.rs`); four texels are of first order: along an edge those of two faces are up to half
//! a texel apart.
//!
//! Singular: none. Texels that lie on the edges have nothing beyond them, and no rule for it: faces hold them twice.

use crate::code::bilinear::{Along, on_edges, weights};
use crate::map::Map;
use crate::number::real::Real;
use crate::projections::faces::FaceLayout;
use crate::projections::projection::{Edge, Projection, Visitor};

/// How many faces a cube has.
pub const FACES: usize = 6;

/// A number of a stored texel as a sum: so many times the texels of a side, the last of them, and two other numbers.
type Terms = [f64; 4];

/// A cube's faces as they are stored and joined.
pub struct Cube {
    layout: FaceLayout,
    on_edges: bool,
    /// Of each face, beyond the sides of u and of v, at 0 and at 1.
    neighbors: [[[Neighbor; 2]; 2]; FACES],
}

/// What lies beyond a side of a face.
#[derive(Clone, Copy)]
struct Neighbor {
    face: usize,
    /// Which coordinate is constant on its side, and whether that is the last.
    axis: usize,
    high: bool,
    /// Whether the other runs backward.
    reversed: bool,
}

/// Where texels of faces are stored, chosen by which face, or which side of a face, it is.
struct Choice<M> {
    masks: Vec<M>,
}

impl<M: Copy + std::ops::BitOr<Output = M>> Choice<M> {
    /// The number of the case that it is. Most cases share one, and it is compared with no other.
    fn number<R: Real<Mask = M>>(&self, values: &[f64]) -> R {
        let count = |x: f64| values.iter().filter(|&&y| y == x).count();
        let usual = values.iter().copied().max_by_key(|&x| count(x));
        let usual = usual.unwrap_or_default();
        let mut chosen = R::new(usual);
        let mut others: Vec<f64> = values.iter().copied().filter(|&x| x != usual).collect();
        others.sort_by(f64::total_cmp);
        others.dedup();
        for other in others {
            let cases = self.masks.iter().zip(values).filter(|(_, x)| **x == other);
            if let Some(mask) = cases.map(|(mask, _)| *mask).reduce(|a, b| a | b) {
                chosen = R::select(mask, R::new(other), chosen);
            }
        }
        chosen
    }

    /// The sum of the case that it is.
    fn sum<R: Real<Mask = M>>(&self, cases: &[Terms], numbers: [R; 4]) -> R {
        let mut sum: Option<R> = None;
        for (k, number) in numbers.into_iter().enumerate() {
            let factors: Vec<f64> = cases.iter().map(|terms| terms[k]).collect();
            if factors.iter().all(|&x| x == 0.0) {
                continue;
            }
            let term = if factors.iter().all(|&x| x == 1.0) {
                number
            } else {
                self.number::<R>(&factors) * number
            };
            sum = Some(sum.map_or(term, |sum| sum + term));
        }
        sum.unwrap_or(R::ZERO)
    }
}

struct Joined;

impl Visitor for Joined {
    type Output = [[[Neighbor; 2]; 2]; FACES];
    fn visit<P: Projection>(self, p: P) -> Self::Output {
        if const { P::INFO.faces != FACES } {
            unreachable!("a map of six faces");
        }
        let beyond = |face: usize, axis: usize, high: bool| {
            let edge = Edge {
                face: face as f64,
                axis,
                high,
            };
            // Away from corners, and near the edge, any place tells.
            let there = p.across(edge, 0.5, 1e-3);
            let (a, b) = there.pq();
            let axis = usize::from(b.abs() > a.abs());
            let [constant, along] = if axis == 0 { [a, b] } else { [b, a] };
            Neighbor {
                face: there.face as usize,
                axis,
                high: constant > 0.0,
                reversed: along < 0.0,
            }
        };
        std::array::from_fn(|face| {
            [0, 1].map(|axis| [false, true].map(|high| beyond(face, axis, high)))
        })
    }
}

impl Cube {
    /// Those of a map.
    pub fn of(map: &Map) -> Cube {
        Cube {
            layout: *map.face_layout(),
            on_edges: on_edges(map.grid())[0],
            neighbors: map.visit_canonical(Joined),
        }
    }

    /// Column and row where texel (i, j) of a face is stored: of the texels of a side, the last, i and j.
    fn stored(&self, face: usize) -> [Terms; 2] {
        let place = &self.layout.places[face];
        let turn = place.orientation;
        let of = |cells: usize, first: bool, backward: bool| {
            let mut terms = [cells as f64, 0.0, 0.0, 0.0];
            terms[if first { 2 } else { 3 }] = if backward { -1.0 } else { 1.0 };
            terms[1] = f64::from(u8::from(backward));
            terms
        };
        [
            of(place.column, !turn.swap, turn.flip_u),
            of(place.row, turn.swap, turn.flip_v),
        ]
    }

    /// Column and row of the texel beyond a side that has number k along it: of the texels of a side, the last, and k.
    fn beyond(&self, neighbor: Neighbor) -> [Terms; 2] {
        let constant = [f64::from(u8::from(neighbor.high)), 0.0];
        let along = if neighbor.reversed {
            [1.0, -1.0]
        } else {
            [0.0, 1.0]
        };
        let [i, j] = if neighbor.axis == 0 {
            [constant, along]
        } else {
            [along, constant]
        };
        self.stored(neighbor.face).map(|[cells, last, of_i, of_j]| {
            let both = |k: usize| of_i * i[k] + of_j * j[k];
            [cells, last + both(0), both(1), 0.0]
        })
    }

    /// Where faces are apart, the number of one as it is stored.
    fn number(&self, face: usize) -> f64 {
        if self.layout.is_atlas {
            0.0
        } else {
            self.layout.places[face].stored as f64
        }
    }

    /// Four columns, four rows, where faces are apart four faces, and four weights, of the texels about a place of a
    /// face, (u, v, face), in images with so many columns.
    pub fn taps<R: Real>(&self, [u, v, face]: [R; 3], width: R) -> Vec<R> {
        let side = width / R::new(self.layout.columns as f64);
        let [x, y] = [u, v].map(|place| Along::new(place, side, self.on_edges));
        let last = x.last;
        let is: Vec<R::Mask> = (0..FACES).map(|k| face.equals(R::new(k as f64))).collect();
        let own = Choice { masks: is.clone() };
        let cases: Vec<[Terms; 2]> = (0..FACES).map(|face| self.stored(face)).collect();
        let numbers: Vec<f64> = (0..FACES).map(|face| self.number(face)).collect();
        let number = own.number::<R>(&numbers);
        let here = |i: R, j: R| {
            let [column, row] = [0, 1].map(|k| {
                let cases: Vec<Terms> = cases.iter().map(|case| case[k]).collect();
                own.sum(&cases, [side, last, i, j])
            });
            [column, row, number]
        };
        // The texel beyond the side of an axis that lies at number k along it.
        let there = |axis: usize, before: R, k: R| {
            let low = before.less(R::ZERO);
            let sides = (0..FACES).flat_map(|face| [false, true].map(|high| (face, high)));
            let sides: Vec<(usize, bool)> = sides.collect();
            let neighbor =
                |(face, high): (usize, bool)| self.neighbors[face][axis][usize::from(high)];
            let choice = Choice {
                masks: sides
                    .iter()
                    .map(|&(face, high)| is[face] & if high { !low } else { low })
                    .collect(),
            };
            let [column, row] = [0, 1].map(|c| {
                let cases: Vec<Terms> =
                    sides.iter().map(|&s| self.beyond(neighbor(s))[c]).collect();
                choice.sum(&cases, [side, last, k, R::ZERO])
            });
            let numbers: Vec<f64> = sides
                .iter()
                .map(|&s| self.number(neighbor(s).face))
                .collect();
            [column, row, choice.number(&numbers)]
        };
        let ([left, right], [top, bottom]) = (x.both(), y.both());
        let mut weights = weights(x.part, y.part);
        let corners = [(left, top), (right, top), (left, bottom), (right, bottom)];
        if self.on_edges {
            let texels = corners.map(|(i, j)| here(x.held(i), y.held(j)));
            return self.listed(texels, weights);
        }
        let outside = |i: R| i.less(R::ZERO) | i.more(last);
        let missing = corners.map(|(i, j)| outside(i) & outside(j));
        let texels = corners.map(|(i, j)| {
            let (within_i, within_j) = (x.held(i), y.held(j));
            let [own, beside, over] = [
                here(within_i, within_j),
                there(0, x.before, within_j),
                there(1, y.before, within_i),
            ];
            let [column, row, number] = [0, 1, 2].map(|k| {
                let over = R::select(outside(j) & !outside(i), over[k], own[k]);
                R::select(outside(i) & !outside(j), beside[k], over)
            });
            [column, row, number]
        });
        // At most one of four is at a corner.
        let lost = missing.into_iter().zip(weights);
        let lost = lost
            .map(|(missing, weight)| R::select(missing, weight, R::ZERO))
            .reduce(|a, b| a + b)
            .unwrap_or(R::ZERO);
        let share = lost * R::new(1.0 / 3.0);
        for (weight, missing) in weights.iter_mut().zip(missing) {
            *weight = R::select(missing, R::ZERO, *weight + share);
        }
        self.listed(texels, weights)
    }

    fn listed<R: Real>(&self, texels: [[R; 3]; 4], weights: [R; 4]) -> Vec<R> {
        let numbers = if self.layout.is_atlas { 2 } else { 3 };
        let places = (0..numbers).flat_map(|k| texels.map(|texel| texel[k]));
        places.chain(weights).collect()
    }
}
