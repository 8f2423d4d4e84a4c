//! A verb of a map as a program: what goes in, what comes out, and the graph between.

use crate::code::verb::Verb;
use crate::geometry::axes::Rotation;
use crate::map::{Map, layout};
use crate::number::graph::{Id, Node, Style};
use crate::number::real::Real;
use crate::number::trace::{Trace, Width, record};
use crate::projections::projection::{Projection, Uv, Visitor};

/// What an argument of a function is.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Kind {
    /// A number.
    Number,
    /// So many numbers.
    Vector(usize),
}

/// An argument of a function.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Argument {
    /// Its name.
    pub name: &'static str,
    /// What it is.
    pub kind: Kind,
    /// The names of its numbers, where they are taken apart.
    pub parts: &'static [&'static str],
}

impl Argument {
    /// A direction.
    pub const DIRECTION: Argument = Argument {
        name: "d",
        kind: Kind::Vector(3),
        parts: &["x", "y", "z"],
    };

    /// Image coordinates, two or three.
    pub fn place(numbers: usize) -> Argument {
        Argument {
            name: place_name(numbers),
            kind: Kind::Vector(numbers),
            parts: &["u", "v", "face"],
        }
    }

    /// A number.
    pub fn number(name: &'static str) -> Argument {
        Argument {
            name,
            kind: Kind::Number,
            parts: &[],
        }
    }

    /// How many numbers it is.
    pub fn width(&self) -> usize {
        match self.kind {
            Kind::Number => 1,
            Kind::Vector(n) => n,
        }
    }
}

/// The name of image coordinates.
pub fn place_name(numbers: usize) -> &'static str {
    if numbers == 2 { "uv" } else { "uvf" }
}

/// What a function gives.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Gives {
    /// One number.
    Number,
    /// Two numbers of a shared function.
    Pair,
    /// Whether it is so.
    Truth,
    /// A vector of so many numbers, of this name where it has one: a direction, or image coordinates.
    Vector(usize, &'static str),
    /// Two directions.
    Columns,
}

/// A function as a graph.
#[derive(Clone, Debug)]
pub struct Program {
    /// What it takes.
    pub takes: Vec<Argument>,
    /// What it gives.
    pub gives: Gives,
    /// Nodes, each behind those that it is made of.
    pub nodes: Vec<Node>,
    /// The numbers, or the condition, that it gives.
    pub outputs: Vec<Id>,
}

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

struct Recorded<'a, T> {
    map: &'a Map,
    verb: Verb,
    width: std::marker::PhantomData<T>,
}

impl<T: Width> Recorded<'_, T> {
    /// The place on a canonical face, whether there is one, and how fast it changes along u and v of the image.
    fn place(&self) -> layout::Located<Trace<T>> {
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
}

impl<T: Width> Visitor for Recorded<'_, T> {
    type Output = Vec<Id>;

    fn visit<P: Projection>(self, p: P) -> Vec<Id> {
        let numbers = |numbers: &[Trace<T>]| numbers.iter().map(|x| x.id()).collect();
        let to_view = self.map.view_rotation(None);
        let to_world = to_view.inverse();
        match self.verb {
            Verb::Encode => {
                let view = turned(to_view, [0, 1, 2].map(Trace::input));
                let uv = p.encode(view);
                let canonical = [uv.u, uv.v, uv.face];
                let face_layout = self.map.face_layout();
                let stored = if face_layout.is_canonical() {
                    canonical
                } else {
                    layout::store_one(face_layout, canonical)
                };
                numbers(&stored[..self.map.uv_width()])
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
pub fn program<T: Width>(map: &Map, verb: Verb, style: Style) -> Program {
    let recorded = Recorded::<T> {
        map,
        verb,
        width: std::marker::PhantomData,
    };
    let (graph, outputs) = record(style, || map.visit_canonical(recorded));
    let width = map.uv_width();
    let (takes, gives) = match verb {
        Verb::Encode => (Argument::DIRECTION, Gives::Vector(width, place_name(width))),
        Verb::Decode => (Argument::place(width), Gives::Vector(3, "d")),
        Verb::Density => (Argument::place(width), Gives::Number),
        Verb::Valid => (Argument::place(width), Gives::Truth),
        Verb::Jacobian => (Argument::place(width), Gives::Columns),
    };
    Program {
        takes: vec![takes],
        gives,
        nodes: graph.into_nodes(),
        outputs,
    }
}
