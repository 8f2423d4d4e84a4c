//! A verb of a map as a program: its formula, recorded.

use crate::code::interface::Program;
use crate::code::taps::{self, Rule};
use crate::code::verb::Verb;
use crate::geometry::axes::Rotation;
use crate::geometry::mirror::mirrored;
use crate::map::{Map, layout};
use crate::number::graph::{Id, Style};
use crate::number::real::Real;
use crate::number::trace::{Trace, record};
use crate::projections::projection::{Projection, Uv, Visitor};

/// A direction turned; terms that are zero are left out, which no bit of the sum but the sign of a zero sees.
fn turned<R: Real>(rotation: Rotation, d: [R; 3]) -> [R; 3] {
    match rotation {
        Rotation::Axes(axes) => [0, 1, 2].map(|k| {
            let x = d[axes.world[k] as usize];
            if axes.negative[k] { -x } else { x }
        }),
        Rotation::Matrix(m) => m.map(|row| {
            let terms = row.into_iter().zip(d).filter(|(factor, _)| *factor != 0.0);
            terms
                .map(|(factor, x)| R::new(factor) * x)
                .reduce(|sum, term| sum + term)
                .unwrap_or(R::ZERO)
        }),
    }
}

/// What of a verb that gives numbers is the projection's own: the rest is compiled once for all of them.
struct Formula {
    verb: Verb,
    /// A direction of the view frame, or a place on a canonical face.
    at: [Trace; 3],
}

impl Visitor for Formula {
    type Output = Vec<Trace>;

    fn visit<P: Projection>(self, p: P) -> Vec<Trace> {
        let [u, v, face] = self.at;
        let place = Uv { u, v, face };
        match self.verb {
            Verb::Encode | Verb::Taps => {
                let uv = p.encode(self.at);
                vec![uv.u, uv.v, uv.face]
            }
            Verb::Decode => p.decode(place).to_vec(),
            Verb::Density => vec![p.density(place)],
            Verb::Jacobian => p.jacobian(place).concat(),
            Verb::Valid | Verb::Reflect => Vec::new(),
        }
    }
}

/// Whether the canonical image holds something at a place.
struct Held(Uv<Trace>);

impl Visitor for Held {
    type Output = <Trace as Real>::Mask;

    fn visit<P: Projection>(self, p: P) -> Self::Output {
        p.contains(self.0)
    }
}

/// The numbers that a projection's formula gives.
fn numbers<const N: usize>(map: &Map, verb: Verb, at: [Trace; 3]) -> [Trace; N] {
    let numbers = map.visit_canonical(Formula { verb, at });
    std::array::from_fn(|k| numbers[k])
}

/// The place on a canonical face, whether there is one, and how fast it changes along u and v of the image.
fn located(map: &Map) -> layout::Located<Trace> {
    let uv = Uv {
        u: Trace::input(0),
        v: Trace::input(1),
        face: if map.uv_width() > 2 {
            Trace::input(2)
        } else {
            Trace::ZERO
        },
    };
    let face_layout = map.face_layout();
    if face_layout.is_canonical() {
        layout::Located::canonical(uv)
    } else {
        layout::place_one(face_layout, uv)
    }
}

/// The outputs of a verb of a map.
fn outputs(map: &Map, verb: Verb) -> Vec<Id> {
    let ids = |numbers: &[Trace]| numbers.iter().map(|x| x.id()).collect();
    let to_world = map.view_rotation(None).inverse();
    let canonical = || {
        let view = turned(map.view_rotation(None), [0, 1, 2].map(Trace::input));
        numbers::<3>(map, Verb::Encode, view)
    };
    let at = |uv: Uv<Trace>| [uv.u, uv.v, uv.face];
    match verb {
        Verb::Encode => {
            let face_layout = map.face_layout();
            let mut stored = canonical();
            if !face_layout.is_canonical() {
                stored = layout::store_one(face_layout, stored);
            }
            ids(&stored[..map.uv_width()])
        }
        Verb::Taps => {
            let size = [3, 4].map(Trace::input);
            let [u, v, face] = canonical();
            ids(&match taps::rule(map) {
                Ok(Rule::Cube(cube)) => cube.taps([u, v, face], size[0]),
                Ok(Rule::Rectangle(seam)) => taps::rectangle(seam, map.grid(), [u, v], size),
                Err(_) => Vec::new(),
            })
        }
        Verb::Decode => ids(&turned(
            to_world,
            numbers::<3>(map, verb, at(located(map).place)),
        )),
        Verb::Density => {
            let [density] = numbers(map, verb, at(located(map).place));
            ids(&[density * Trace::new(map.cells())])
        }
        Verb::Valid => {
            let place = located(map);
            vec![(place.found & map.visit_canonical(Held(place.place))).id()]
        }
        Verb::Reflect => {
            let vector = |first: u8| [first, first + 1, first + 2].map(Trace::input);
            ids(&mirrored(vector(0), vector(3)))
        }
        Verb::Jacobian => {
            let place = located(map);
            let [x, y, z, u, v, w] = numbers(map, verb, at(place.place));
            let [a, b] = [[x, y, z], [u, v, w]].map(|column| turned(to_world, column));
            let [along, down] = place.slope;
            let choose = |a, b| Trace::choose(place.swapped, a, b);
            let of = |k: usize| (choose(b[k], a[k]) * along, choose(a[k], b[k]) * down);
            let [x, y, z] = [0, 1, 2].map(of);
            ids(&[x.0, y.0, z.0, x.1, y.1, z.1])
        }
    }
}

/// A verb of a map, recorded.
pub fn program(map: &Map, verb: Verb, style: Style) -> Program {
    let (graph, outputs) = record(style, || outputs(map, verb));
    let (takes, gives) = verb.signature(map.uv_width());
    Program {
        takes,
        gives,
        nodes: graph.into_nodes(),
        outputs,
    }
}
