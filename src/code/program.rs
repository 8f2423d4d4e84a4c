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

struct Recorded<'a> {
    map: &'a Map,
    verb: Verb,
}

impl Recorded<'_> {
    /// The place on a canonical face, whether there is one, and how fast it changes along u and v of the image.
    fn place(&self) -> layout::Located<Trace> {
        let width = self.map.uv_width();
        let uv = Uv {
            u: Trace::input(0),
            v: Trace::input(1),
            face: if width > 2 {
                Trace::input(2)
            } else {
                Trace::ZERO
            },
        };
        let face_layout = self.map.face_layout();
        if face_layout.is_canonical() {
            layout::Located::canonical(uv)
        } else {
            layout::place_one(face_layout, uv)
        }
    }

    /// The canonical coordinates of a direction: a function of its own, for two verbs begin with it.
    #[inline(never)]
    fn canonical<P: Projection>(&self, p: P) -> [Trace; 3] {
        let view = turned(self.map.view_rotation(None), [0, 1, 2].map(Trace::input));
        let uv = p.encode(view);
        [uv.u, uv.v, uv.face]
    }
}

impl Visitor for Recorded<'_> {
    type Output = Vec<Id>;

    fn visit<P: Projection>(self, p: P) -> Vec<Id> {
        let numbers = |numbers: &[Trace]| numbers.iter().map(|x| x.id()).collect();
        let to_world = self.map.view_rotation(None).inverse();
        let encoded = |p: P| {
            let canonical = self.canonical(p);
            let face_layout = self.map.face_layout();
            if face_layout.is_canonical() {
                canonical
            } else {
                layout::store_one(face_layout, canonical)
            }
        };
        match self.verb {
            Verb::Encode => numbers(&encoded(p)[..self.map.uv_width()]),
            Verb::Taps => {
                let size = [3, 4].map(Trace::input);
                let grid = self.map.grid();
                let [u, v, face] = self.canonical(p);
                numbers(&match taps::rule(self.map) {
                    Ok(Rule::Cube(cube)) => cube.taps([u, v, face], size[0]),
                    Ok(Rule::Rectangle(seam)) => taps::rectangle(seam, grid, [u, v], size),
                    Err(_) => Vec::new(),
                })
            }
            Verb::Decode => numbers(&turned(to_world, p.decode(self.place().place))),
            Verb::Density => {
                let density = p.density(self.place().place);
                numbers(&[density * Trace::new(self.map.cells())])
            }
            Verb::Valid => {
                let at = self.place();
                vec![(at.found & p.contains(at.place)).id()]
            }
            Verb::Reflect => {
                let vector = |first: u8| [first, first + 1, first + 2].map(Trace::input);
                numbers(&mirrored(vector(0), vector(3)))
            }
            Verb::Jacobian => {
                let at = self.place();
                let [a, b] = p.jacobian(at.place).map(|column| turned(to_world, column));
                let [along, down] = at.slope;
                let choose = |a, b| Trace::choose(at.swapped, a, b);
                let of = |k: usize| (choose(b[k], a[k]) * along, choose(a[k], b[k]) * down);
                let [x, y, z] = [0, 1, 2].map(of);
                numbers(&[x.0, y.0, z.0, x.1, y.1, z.1])
            }
        }
    }
}

/// A verb of a map, recorded.
pub fn program(map: &Map, verb: Verb, style: Style) -> Program {
    let recorded = Recorded { map, verb };
    let (graph, outputs) = record(style, || map.visit_canonical(recorded));
    let (takes, gives) = verb.signature(map.uv_width());
    Program {
        takes,
        gives,
        nodes: graph.into_nodes(),
        outputs,
    }
}
