//! What a part of a target image sees of the source image.
//!
//! To first order a rectangle of the target, du × dv about a place, is a parallelogram in the source, spanned by
//! J·(du, 0) and J·(0, dv). J, the derivative of one image's coordinates by the other's, comes from the two maps' own
//! Jacobians (`decode` on dual numbers): with T = ∂d/∂(u, v) of the target and S of the source, S J = T, and since both have the
//! sphere's tangent plane for a range, J = (Sᵀ S)⁻¹ Sᵀ T. Differences between neighboring places were the first
//! thought; they mean nothing across seams and beside poles.
//!
//! What a caller says of a picture of their own takes the same way, but by triple products with the direction, which lose half as
//! many digits where both columns of S are nearly parallel, at the rim of a disk. On a cube this is the quotient rule
//! by which graphics APIs take derivatives to a face.
//!
//! Where the source is singular (a pole of a latlong) a place has no extent in it; lengths are infinite there.

use crate::geometry::axes::Rotation;
use crate::geometry::vector::{cross, dot, norm};
use crate::image::raster::Raster;
use crate::kernel::tile::{TILE, Tile};
use crate::kernel::vectorize;
use crate::map::Map;
use crate::map::verbs::JacobianTile;
use crate::number::real::max;
use crate::resample::coordinate_map::CoordinateMap;

/// A rectangle of a target face.
#[derive(Clone, Copy, Debug, Default)]
pub struct Part {
    /// Its center, canonical (u, v, face).
    pub uv: [f64; 3],
    /// Its sides.
    pub size: [f64; 2],
}

impl Part {
    /// The rectangle of the texel whose center lies there.
    pub fn of_texel(raster: &Raster, uv: [f64; 3]) -> Part {
        let side = |(scale, _): (f64, f64), x: f64| {
            let half = 0.5 / scale;
            let (low, high) = ((x - half).max(0.0), (x + half).min(1.0));
            (0.5 * (low + high), high - low)
        };
        let (u, width) = side(raster.along_u.index(), uv[0]);
        let (v, height) = side(raster.along_v.index(), uv[1]);
        Part {
            uv: [u, v, uv[2]],
            size: [width, height],
        }
    }
}

/// What it sees.
#[derive(Clone, Copy, Debug, Default)]
pub struct Footprint {
    /// The place of its center in the source; NaN where nothing is seen.
    pub source: [f64; 3],
    /// Its two sides in the source, in texels along u and v.
    pub sides: [[f64; 2]; 2],
}

impl Footprint {
    /// Of a place and the sides there, in texels. One that is not finite, at a singular place or given so, sees everything.
    pub fn of_sides(source: [f64; 3], sides: [[f64; 2]; 2]) -> Footprint {
        let finite = sides.as_flattened().iter().all(|x| x.is_finite());
        let everything = [[f64::INFINITY, 0.0], [0.0, f64::INFINITY]];
        Footprint {
            source,
            sides: if finite { sides } else { everything },
        }
    }

    /// How many source texels each side crosses. Infinite at a singular place, 0 where nothing is seen.
    pub fn lengths(&self) -> [f64; 2] {
        if self.source[0].is_nan() {
            return [0.0; 2];
        }
        self.sides.map(|[x, y]| {
            let length = (x * x + y * y).sqrt();
            if length.is_nan() {
                f64::INFINITY
            } else {
                length
            }
        })
    }
}

/// What up to a [`TILE`] of parts see: their [`Footprint`]s and more, in rows, and what measuring needs in between. Kept from call to
/// call: of few parts, to clear so much took longer than the rest.
pub struct Measuring {
    places: [Tile<f64, 3>; 2],
    jacobians: [Tile<f64, 6>; 2],
    /// The sides of the parts.
    pub sizes: Tile<f64, 2>,
    /// The first and the second side in the source, in texels along u and v.
    pub sides: Tile<f64, 4>,
    /// Their lengths in radians.
    pub angles: Tile<f64, 2>,
    /// The longer side of a source texel, in radians; and the solid angle of the part.
    pub extents: Tile<f64, 2>,
}

impl Measuring {
    /// Room for it.
    pub fn new() -> Box<Self> {
        Box::new(Measuring {
            places: [Tile::new(); 2],
            jacobians: [Tile::new(); 2],
            sizes: Tile::new(),
            sides: Tile::new(),
            angles: Tile::new(),
            extents: Tile::new(),
        })
    }

    /// The centers of the parts, and where they are in the source: NaN where nothing is seen.
    pub fn centers(&self) -> [&Tile<f64, 3>; 2] {
        self.places.each_ref()
    }

    /// What a part sees.
    pub fn at(&self, k: usize) -> Footprint {
        let [ax, ay, bx, by] = self.sides.at(k);
        Footprint {
            source: self.places[1].at(k),
            sides: [[ax, ay], [bx, by]],
        }
    }

    /// Finds what parts of a target see of a source with the given raster; at most a [`TILE`] of parts. Returns how many there are.
    pub fn measure(
        &mut self,
        coordinate_map: &CoordinateMap<'_>,
        source: &Raster,
        parts: impl Iterator<Item = Part>,
    ) -> usize {
        let mut n = 0;
        for part in parts.take(TILE) {
            self.places[0].set(n, part.uv);
            self.sizes.set(n, part.size);
            n += 1;
        }
        self.measure_first(coordinate_map, source, n);
        n
    }

    /// The same of the first n, which are in place: whichever parts these were.
    #[inline(never)]
    fn measure_first(&mut self, coordinate_map: &CoordinateMap<'_>, source: &Raster, n: usize) {
        let [from, into] = &mut self.places;
        for (into, from) in into.0.iter_mut().zip(&from.0) {
            into[..n].copy_from_slice(&from[..n]);
        }
        coordinate_map.take(into, n);
        let [by_target, by_source] = &mut self.jacobians;
        coordinate_map.jacobians(n, [from, into], [by_target, by_source]);
        let scale = [source.along_u.index().0, source.along_v.index().0];
        vectorize(
            #[inline(always)]
            || self.sides_of(n, scale),
        );
    }

    /// From the derivatives of both images: J = (Sᵀ S)⁻¹ Sᵀ T times the sides.
    #[inline(always)]
    fn sides_of(&mut self, n: usize, [su, sv]: [f64; 2]) {
        let [
            Tile([a0, b0, a1, b1, a2, b2]),
            Tile([p0, q0, p1, q1, p2, q2]),
        ] = &self.jacobians;
        let Tile([width, height]) = &self.sizes;
        let Tile([ax, ay, bx, by]) = &mut self.sides;
        let (Tile([angle_a, angle_b]), Tile([texel, solid])) =
            (&mut self.angles, &mut self.extents);
        for k in 0..n.min(TILE) {
            let (p, q) = ([p0[k], p1[k], p2[k]], [q0[k], q1[k], q2[k]]);
            let (a, b) = ([a0[k], a1[k], a2[k]], [b0[k], b1[k], b2[k]]);
            let (pp, pq, qq) = (dot(p, p), dot(p, q), dot(q, q));
            let one_over = 1.0 / (pp * qq - pq * pq);
            let (pa, qa, pb, qb) = (dot(p, a), dot(q, a), dot(p, b), dot(q, b));
            ax[k] = (qq * pa - pq * qa) * one_over * width[k] * su;
            ay[k] = (pp * qa - pq * pa) * one_over * width[k] * sv;
            bx[k] = (qq * pb - pq * qb) * one_over * height[k] * su;
            by[k] = (pp * qb - pq * pb) * one_over * height[k] * sv;
            let (aa, ab, bb) = (dot(a, a), dot(a, b), dot(b, b));
            angle_a[k] = aa.sqrt() * width[k];
            angle_b[k] = bb.sqrt() * height[k];
            texel[k] = max(pp.sqrt() / su, qq.sqrt() / sv);
            solid[k] = max(aa * bb - ab * ab, 0.0).sqrt() * width[k] * height[k];
        }
    }
}

/// Writes the sides of what pixels see of an image whose world is taken to its view by `turn`, in texels along u and v; at most a
/// [`TILE`] of them. Their directions, of any length, change to the next pixel right and down as `derivatives` say, and lie at the places
/// `uv` of the image.
pub fn measure_pixels(
    (map, turn): (&Map, Rotation),
    raster: &Raster,
    uv: &Tile<f64, 3>,
    (directions, derivatives): (&[[f64; 3]], [&[[f64; 3]]; 2]),
    sides: &mut Tile<f64, 4>,
) {
    let mut by_source = Tile::new();
    map.visit_canonical(JacobianTile {
        turn: turn.inverse(),
        input: uv,
        count: directions.len(),
        output: &mut by_source,
    });
    let scale = [raster.along_u.index().0, raster.along_v.index().0];
    vectorize(
        #[inline(always)]
        || sides_of_pixels(&by_source, directions, derivatives, scale, sides),
    );
}

#[inline(always)]
fn sides_of_pixels(
    Tile([p0, q0, p1, q1, p2, q2]): &Tile<f64, 6>,
    directions: &[[f64; 3]],
    [right, down]: [&[[f64; 3]]; 2],
    [su, sv]: [f64; 2],
    Tile([ax, ay, bx, by]): &mut Tile<f64, 4>,
) {
    let n = directions.len().min(TILE);
    for (k, ((direction, right), down)) in directions[..n].iter().zip(right).zip(down).enumerate() {
        // Of any length: neither its square nor its reciprocal need be a number.
        let largest = direction.iter().fold(0.0, |a: f64, x| a.max(x.abs()));
        let unit = direction.map(|x| x / largest);
        let length = norm(unit);
        let unit = unit.map(|x| x / length);
        let (p, q) = ([p0[k], p1[k], p2[k]], [q0[k], q1[k], q2[k]]);
        let area = dot(cross(p, q), unit);
        let side = |derivative: &[f64; 3]| {
            let d = derivative.map(|x| x / largest / length);
            let (along_u, along_v) = (
                dot(cross(d, q), unit) / area * su,
                dot(cross(p, d), unit) / area * sv,
            );
            // Also at a singular place.
            let still = derivative.iter().all(|x| *x == 0.0);
            (
                if still { 0.0 } else { along_u },
                if still { 0.0 } else { along_v },
            )
        };
        (ax[k], ay[k]) = side(right);
        (bx[k], by[k]) = side(down);
    }
}
