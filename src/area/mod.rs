//! Conservative conversion: each target texel is the mean of the source over the texel's own solid angle.
//!
//! # What is computed
//!
//! With w_ij the solid angle that target texel i and source texel j have in common,
//! out_i = Σ_j w_ij L_j / Σ_j w_ij. This is first-order conservative remapping as climate models use it
//! (Jones 1999, First- and Second-Order Conservative Remapping Schemes for Grids in Spherical
//! Coordinates; SCRIP; ESMF). Since Σ_j w_ij is the texel's solid angle and Σ_i w_ij is the source
//! texel's, Σ L dω over the image is kept, whatever is converted into what: a sun of one texel keeps
//! its energy. Weights are not negative, so no texel is darker or brighter than the source, and a constant
//! stays that constant.
//!
//! SCRIP integrates along straight lines in latitude and longitude, ESMF cuts polygons with
//! great-circle edges, and both need special care at poles. Here cells are what they are: their edges
//! are the projection's own curves, cut at exact crossings and integrated until
//! the error is below 1e-9 of a cell (`overlay`), without a polygon anywhere. A cell of 22° is as exact
//! as one of a second of arc.
//!
//! # Rules
//!
//! - A target texel that the source covers in part is the mean over the covered part, and the energy
//!   that is kept is that of the covered part. One that the source does not cover takes `fill`.
//! - A target texel cut by a disk's rim is the mean over what of it is sphere, even where its centre lies
//!   outside the disk: its solid angle is not zero, and what it holds belongs to the sum.
//! - A source texel whose centre lies outside the disk holds no value (photographers print credits
//!   there). What of the sphere it covers is given to the nearest texel whose centre lies inside.
//! - NaN spreads to every texel that it touches, unless it is skipped: then its weight is 0.
//!
//! # Cost
//!
//! 20 to 250 µs a target texel on one core, growing with the source texels that it covers: the general path runs
//! everywhere. Nearly all texels lie inside one face of the source, where its rows could be swept in
//! (u, v); that path is not written yet.
//!
//! # What did not help
//!
//! Clipping polygons: for 1e-7 of a 16×8 image's texel an edge needs a thousand corners. Summing the
//! source's own prefix sums around each texel (Green's theorem for the light itself): cheap at
//! any size, but a sun of 1e9 leaves 1e-7 of rounding in every texel of its row, and an infinite
//! texel the whole row.

mod lattice;
mod overlay;
mod sphere;

use crate::error::Error;
use crate::image::{Raster, Texel};
use crate::map::Map;
use crate::real::Real;
use crate::threads;
use glam::DMat3;
use lattice::Lattice;
use ndarray::ArrayView2;
use overlay::Overlay;

/// What becomes of the values that a texel covers.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Statistic {
    /// Their mean, by solid angle.
    Mean,
    /// The one that covers most; of equals, the smallest. For labels.
    Mode,
}

impl Statistic {
    /// The names of all filters that take one.
    pub const NAMES: [&'static str; 2] = ["area", "mode"];

    /// The statistic that a filter of this name takes.
    pub fn find(filter: &str) -> Option<Statistic> {
        match filter {
            "area" => Some(Statistic::Mean),
            "mode" => Some(Statistic::Mode),
            _ => None,
        }
    }
}

/// An image and how it is read.
#[derive(Clone, Copy)]
pub struct Source<'a, T> {
    /// How it maps the sphere.
    pub map: &'a Map,
    /// Its shape, without channels.
    pub shape: &'a [usize],
    /// A row of channels for each texel.
    pub texels: ArrayView2<'a, T>,
    /// Whether NaN has no weight.
    pub skipna: bool,
}

/// Fills an image of `map` with the statistic of what each of its texels covers of `source`, turned by
/// `rotation`.
pub fn convert<T: Texel>(
    source: Source<'_, T>,
    map: &Map,
    shape: &[usize],
    rotation: Option<DMat3>,
    statistic: Statistic,
    fill: &[T],
    out: &mut [T],
) -> Result<(), Error> {
    let frame = frame(source.map, map, rotation);
    let from = Lattice::new(source.map, source.shape, None)?;
    let into = Lattice::new(map, shape, Some(frame))?;
    let channels = fill.len();
    let (columns, texels) = (into.raster.columns, into.raster.texels());
    if source.texels.ncols() != channels || source.texels.nrows() != from.raster.texels() {
        return Err(Error::Shape(format!(
            "Expected {} texels of {channels} channels, got {:?}.",
            from.raster.texels(),
            source.texels.dim()
        )));
    }
    threads::rows(out, columns * channels, texels * COST, |row, out| {
        let mut overlay = Overlay::new(&from, &into);
        let mut weights = Vec::new();
        let mut values = Vec::new();
        for run in into.raster.runs(row) {
            let out = &mut out[run.column * channels..][..run.length * channels];
            for (k, out) in out.chunks_exact_mut(channels).enumerate() {
                weights.clear();
                if let Some((face, start, step)) = run.face {
                    let [i, j] =
                        [0, 1].map(|axis| (start[axis] + k as isize * step[axis]) as usize);
                    collect(&mut overlay, &from, &into, face, [i, j], &mut weights);
                }
                if weights.is_empty() {
                    out.copy_from_slice(fill);
                    continue;
                }
                for (channel, out) in out.iter_mut().enumerate() {
                    values.clear();
                    values.extend(weights.iter().filter_map(|&(index, weight)| {
                        let value = source.texels[[index, channel]].load().to_f64();
                        (!(source.skipna && value.is_nan())).then_some((value, weight))
                    }));
                    let value = match statistic {
                        Statistic::Mean => mean(&values),
                        Statistic::Mode => mode(&mut values),
                    };
                    *out = T::store(<T::Float as Real>::new(value));
                }
            }
        }
    });
    Ok(())
}

/// Points that a texel counts for when threads are handed out.
const COST: usize = 256;

/// The source texels that target texel (i, j) covers, as stored, and how much of each.
fn collect(
    overlay: &mut Overlay<'_, '_>,
    from: &Lattice<'_>,
    into: &Lattice<'_>,
    face: usize,
    [i, j]: [usize; 2],
    weights: &mut Vec<(usize, f64)>,
) {
    let parts = into.refined;
    for y in j * parts..(j + 1) * parts {
        for x in i * parts..(i + 1) * parts {
            overlay.overlaps(face, [x, y], |face, cell, area| {
                let texel = cell.map(|c| c / from.refined);
                let [i, j] = valid_texel(&from.raster, texel);
                weights.push((from.raster.view(face).index(i, j), area));
            });
        }
    }
}

/// The texel itself, or the nearest one whose centre lies in the valid image.
fn valid_texel(raster: &Raster, [i, j]: [usize; 2]) -> [usize; 2] {
    if raster.holds(i as isize, j as isize) {
        return [i, j];
    }
    let centre = |i: usize, j: usize| {
        [
            raster.along_u.centre(i as f64),
            raster.along_v.centre(j as f64),
        ]
    };
    let [u, v] = centre(i, j);
    let mut reach = 2;
    loop {
        let mut best = (f64::INFINITY, [i, j]);
        for y in j.saturating_sub(reach)..=(j + reach).min(raster.height - 1) {
            for x in i.saturating_sub(reach)..=(i + reach).min(raster.width - 1) {
                let [p, q] = centre(x, y);
                let square = (p - u) * (p - u) + (q - v) * (q - v);
                // Of equally near ones the first, whatever rounding says.
                if square < best.0 * (1.0 - 1e-9) && raster.holds(x as isize, y as isize) {
                    best = (square, [x, y]);
                }
            }
        }
        if best.0 < f64::INFINITY || reach > raster.width.max(raster.height) {
            return best.1;
        }
        reach *= 2;
    }
}

/// The mean by weight, within the values; NaN of none.
fn mean(values: &[(f64, f64)]) -> f64 {
    let (mut sum, mut weights) = (0.0, 0.0);
    let (mut least, mut most) = (f64::INFINITY, f64::NEG_INFINITY);
    for &(value, weight) in values {
        sum += weight * value;
        weights += weight;
        least = least.min(value);
        most = most.max(value);
    }
    let mean = sum / weights;
    if mean < least {
        least
    } else if mean > most {
        most
    } else {
        mean
    }
}

/// The value of the largest weight; NaN of none.
fn mode(values: &mut [(f64, f64)]) -> f64 {
    values.sort_by(|a, b| a.0.total_cmp(&b.0));
    let (mut best, mut current) = ((f64::NAN, 0.0), (f64::NAN, 0.0));
    for &(value, weight) in values.iter() {
        if value.to_bits() == current.0.to_bits() {
            current.1 += weight;
        } else {
            current = (value, weight);
        }
        // Shares that differ by rounding are equal, and the smaller value stays.
        if current.1 > best.1 * (1.0 + 1e-9) || current.0.to_bits() == best.0.to_bits() {
            best = current;
        }
    }
    best.0
}

/// The matrix from the target's view frame to the source's.
///
/// The target is turned by a hair about an axis of no symmetry. Edges of the two images that would lie on
/// each other, as those of a latlong and a cube do, then cross instead, and rounding does not decide
/// again and again on which side of a seam a place lies. The turn moves light by 1e-9 of a texel
/// at 4096 columns, and loses none.
fn frame(source: &Map, target: &Map, rotation: Option<DMat3>) -> [[f64; 3]; 3] {
    const HAIR: [f64; 3] = [0.61e-11, -0.53e-11, 0.29e-11];
    let [x, y, z] = HAIR;
    let (into, from) = (source.turn(rotation), target.turn(None).inverse());
    let columns =
        [[1.0, z, -y], [-z, 1.0, x], [y, -x, 1.0]].map(|axis| into.apply(from.apply(axis)));
    [0, 1, 2].map(|row| [0, 1, 2].map(|column| columns[column][row]))
}
