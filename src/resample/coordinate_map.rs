//! From places of one image to those of another that show the same directions.

use crate::geometry::axes::Rotation;
use crate::kernel::Scalar;
use crate::kernel::tile::{TILE, Tile};
use crate::map::Map;
use crate::map::verbs::{DecodeTile, DensityCanonical, EncodeTile, JacobianTile};
use crate::projections::projection::Visitor;
use crate::projections::projection::one;
use crate::projections::projection::{Projection, Uv};
use glam::DMat3;

/// The way from a target's canonical (u, v, face) to a source's.
#[derive(Clone, Copy)]
pub struct CoordinateMap<'a> {
    source: &'a Map,
    target: &'a Map,
    from_target: Rotation,
    into_source: Rotation,
    /// Both are one formula, and nothing is turned.
    same: bool,
}

impl<'a> CoordinateMap<'a> {
    /// From `target` to a `source` that is turned by `rotation`.
    pub fn new(source: &'a Map, target: &'a Map, rotation: Option<DMat3>) -> Self {
        CoordinateMap {
            source,
            target,
            from_target: target.view_rotation(None).inverse(),
            into_source: source.view_rotation(rotation),
            same: rotation.is_none() && source.same_formula(target),
        }
    }

    /// Whether places stay what they are.
    pub fn same(&self) -> bool {
        self.same
    }

    /// Whether both formulas are smooth between [`CoordinateMap::creases`].
    pub fn smooth(&self) -> bool {
        let smooth = |map: &Map| map.info().smooth || !map.info().creases.is_empty();
        self.same || smooth(self.source) && smooth(self.target)
    }

    /// Those of the target and of the source, in p and q. Places that stay what they are bend nowhere.
    pub fn creases(&self) -> [&'static [[f64; 3]]; 2] {
        if self.same {
            return [&[]; 2];
        }
        [self.target.info().creases, self.source.info().creases]
    }

    /// Takes the first `count` places of a tile along. NaN where either image holds nothing.
    pub fn take<R: Scalar>(&self, uv: &mut Tile<R, 3>, count: usize) {
        if self.same {
            return self.target.visit_canonical(OnlyValid(uv, count));
        }
        let mut directions = Tile::new();
        self.target.visit_canonical(DecodeTile {
            turn: self.from_target,
            input: uv,
            output: directions.first_mut(count),
        });
        self.source.visit_canonical(EncodeTile {
            turn: self.into_source,
            input: directions.first(count),
            output: uv,
        });
    }

    /// Of a target whose rows are parallels: what a width of 1 is at the equator, in radians.
    pub fn around(&self) -> Option<f64> {
        let edge = self.target.meridians();
        edge.map(|edge| 2.0 * std::f64::consts::PI * edge)
    }

    /// dω/(du dv) at the first `count` places of the target.
    pub fn densities<R: Scalar>(&self, uv: &Tile<R, 3>, count: usize, densities: &mut [f64; TILE]) {
        let mut input = [[0.0; 3]; TILE];
        for (k, input) in input[..count].iter_mut().enumerate() {
            *input = uv.at(k).map(Scalar::to_f64);
        }
        self.target.visit_canonical(DensityCanonical {
            input: input[..count].as_flattened(),
            output: &mut densities[..count],
        });
    }

    /// The derivatives of world directions by (u, v) at `count` places of the target, and at the places of the source
    /// that show the same directions.
    pub fn jacobians(
        &self,
        count: usize,
        [target, source]: [&Tile<f64, 3>; 2],
        [by_target, by_source]: [&mut Tile<f64, 6>; 2],
    ) {
        self.target.visit_canonical(JacobianTile {
            turn: self.from_target,
            input: target,
            count,
            output: by_target,
        });
        self.source.visit_canonical(JacobianTile {
            turn: self.into_source.inverse(),
            input: source,
            count,
            output: by_source,
        });
    }
}

/// Makes NaN of coordinates outside the valid image.
struct OnlyValid<'a, R>(&'a mut Tile<R, 3>, usize);

impl<R: Scalar> Visitor for OnlyValid<'_, R> {
    type Output = ();
    fn visit<P: Projection>(self, p: P) {
        for k in 0..self.1 {
            let [u, v, face] = self.0.at(k);
            if !one::contains(p, Uv { u, v, face }) {
                self.0.0[0][k] = R::NAN;
            }
        }
    }
}
