//! From places of one image to those of another that show the same directions.

use crate::frame::Turn;
use crate::kernel::Scalar;
use crate::map::Map;
use crate::projection::{Projection, Uv};
use crate::projections::Visitor;
use crate::sample::TILE;
use crate::verbs::{DecodeCanonical, EncodeCanonical, JacobianCanonical};
use glam::DMat3;

/// The way from a target's canonical (u, v, face) to a source's.
#[derive(Clone, Copy)]
pub struct Route<'a> {
    source: &'a Map,
    target: &'a Map,
    from_target: Turn,
    into_source: Turn,
    /// Both are one formula, and nothing is turned.
    same: bool,
}

impl<'a> Route<'a> {
    /// From `target` to a `source` that is turned by `rotation`.
    pub fn new(source: &'a Map, target: &'a Map, rotation: Option<DMat3>) -> Self {
        Route {
            source,
            target,
            from_target: target.turn(None).inverse(),
            into_source: source.turn(rotation),
            same: rotation.is_none() && source.same_formula(target),
        }
    }

    /// Whether places stay what they are.
    pub fn same(&self) -> bool {
        self.same
    }

    /// Takes at most [`TILE`] places along. NaN where either image holds nothing.
    pub fn take<R: Scalar>(&self, uv: &mut [[R; 3]]) {
        if self.same {
            return self.target.visit_canonical(OnlyValid(uv));
        }
        let mut directions = [[R::default(); 3]; TILE];
        let directions = &mut directions[..uv.len()];
        self.target.visit_canonical(DecodeCanonical {
            turn: self.from_target,
            input: uv.as_flattened(),
            output: directions.as_flattened_mut(),
        });
        self.source.visit_canonical(EncodeCanonical {
            turn: self.into_source,
            input: directions.as_flattened(),
            output: uv.as_flattened_mut(),
        });
    }

    /// The derivatives of world directions by (u, v) at places of the target, and at the places of the source that
    /// show the same directions.
    pub fn jacobians(
        &self,
        target: &[[f64; 3]],
        source: &[[f64; 3]],
        [by_target, by_source]: [&mut [[f64; 6]]; 2],
    ) {
        self.target.visit_canonical(JacobianCanonical {
            turn: self.from_target,
            input: target.as_flattened(),
            output: by_target.as_flattened_mut(),
        });
        self.source.visit_canonical(JacobianCanonical {
            turn: self.into_source.inverse(),
            input: source.as_flattened(),
            output: by_source.as_flattened_mut(),
        });
    }
}

/// Makes NaN of coordinates outside the valid image.
struct OnlyValid<'a, R>(&'a mut [[R; 3]]);

impl<R: Scalar> Visitor for OnlyValid<'_, R> {
    type Output = ();
    fn visit<P: Projection>(self, p: P) {
        for [u, v, face] in self.0 {
            let uv = Uv {
                u: *u,
                v: *v,
                face: *face,
            };
            if !p.contains(uv) {
                *u = R::new(f64::NAN);
            }
        }
    }
}
