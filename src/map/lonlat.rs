//! Longitudes and latitudes of directions, and back, in any world.
//!
//! Source: the latlong map without its picture (Snyder 1987, Map Projections: A Working Manual, p. 90). The longitude is 0 ahead and grows to the right, the latitude
//! is 0 at the horizon and grows upward.
//!
//! Domain: directions of any length, angles of any size. Singular: the poles, where the longitude is 0; behind the viewer it is half a turn,
//! for zeros of either sign. Both angles are arctangents, right to rounding near 0 and near the poles, where the places of a latlong are differences.
//! An angle is brought below a turn after it has become half turns: that is off by less than numbers of its size are apart. From 2⁵⁰ half turns on these are
//! a quarter turn apart and more, and count as none.
//!
//! f32 is computed in f64, so that a degree has all of its digits: 180° of f32 have no more than five behind the point.

use crate::geometry::axes::Rotation;
use crate::geometry::world::World;
use crate::kernel::threads;
use crate::kernel::tile::{Rows, Tuples, TuplesMut, W};
use crate::kernel::{Instructions, Point, Scalar, Scratch};
use crate::map::verbs::{frame_in, frame_out, only_if, prepared, run};
use crate::number::real::Real;

/// What lies to the right, up and ahead to longitude and latitude, in angles of which half a turn has so many.
#[derive(Clone, Copy)]
struct ToAngles(f64);

impl ToAngles {
    #[inline(always)]
    fn of<R: Real>(self, d: [R; 3]) -> [R; 2] {
        let ([x, y, z], ok) = prepared(d);
        // What is dropped is an angle from the pole below any rounding unit.
        let (across, ahead) = (x.squarable(), z.squarable());
        let level = (across * across + ahead * ahead).sqrt();
        let half_turn = R::new(self.0);
        let longitude = R::half_turns(x.abs(), z) * half_turn;
        let latitude = R::half_turns(y.abs(), level) * half_turn;
        let (west, below) = (x.less(R::ZERO), y.less(R::ZERO));
        only_if(ok, [longitude.negated_if(west), latitude.negated_if(below)])
    }
}

impl<R: Scalar> Point<R, 3, 2> for ToAngles {
    const EVERY_LEVEL: bool = false;
    const SINGLE: bool = false;

    #[inline(always)]
    fn apply(self, d: [R; 3]) -> [R; 2] {
        self.of(d)
    }

    fn alone(self, _: Instructions, chunk: &mut Scratch<R, 3, 2>) {
        chunk.output = Rows([[R::NAN; W]; 2]);
    }
}

/// The way back.
#[derive(Clone, Copy)]
struct OfAngles(f64);

impl OfAngles {
    /// Half turns of an angle, from 0 to 2.
    #[inline(always)]
    fn turns<R: Real>(self, angle: R) -> R {
        let turns = angle * R::new(1.0 / self.0);
        let counts = turns.abs().less(R::new((1_u64 << 50) as f64));
        let turns = R::select(counts, turns, R::ZERO);
        turns - R::TWO * (turns * R::HALF).floor()
    }

    #[inline(always)]
    fn of<R: Real>(self, [longitude, latitude]: [R; 2]) -> [R; 3] {
        let infinity = R::new(f64::INFINITY);
        let ok = longitude.abs().less(infinity) & latitude.abs().less(infinity);
        let (across, ahead) = R::sin_cos_half_turns(self.turns(longitude));
        let (up, level) = R::sin_cos_half_turns(self.turns(latitude));
        only_if(ok, [level * across, up, level * ahead])
    }
}

impl<R: Scalar> Point<R, 2, 3> for OfAngles {
    const EVERY_LEVEL: bool = false;
    const SINGLE: bool = false;

    #[inline(always)]
    fn apply(self, angles: [R; 2]) -> [R; 3] {
        self.of(angles)
    }

    fn alone(self, _: Instructions, chunk: &mut Scratch<R, 2, 3>) {
        chunk.output = Rows([[R::NAN; W]; 3]);
    }
}

/// The longitudes and latitudes of directions of a world, two numbers each, in angles of which half a turn has so many.
pub(crate) fn of_directions<R: Scalar>(
    world: World,
    half_turn: f64,
    directions: &[R],
    lonlat: &mut [R],
) {
    let frame = frame_in(Rotation::new(world.frame(), None));
    threads::blocks(directions, 3, lonlat, 2, |directions, lonlat| {
        let (input, output) = (Tuples::of(directions), TuplesMut::of(lonlat));
        run(ToAngles(half_turn), &frame, input, output);
    });
}

/// The way back, to unit directions.
pub(crate) fn directions_of<R: Scalar>(
    world: World,
    half_turn: f64,
    lonlat: &[R],
    directions: &mut [R],
) {
    let frame = frame_out(Rotation::new(world.frame(), None).inverse());
    threads::blocks(lonlat, 2, directions, 3, |lonlat, directions| {
        let (input, output) = (Tuples::of(lonlat), TuplesMut::of(directions));
        run(OfAngles(half_turn), &frame, input, output);
    });
}
