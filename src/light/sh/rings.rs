//! Images whose texels lie on rings: evenly spaced latitudes and longitudes.
//!
//! Along a ring, Σ f cos mφ and Σ f sin mφ, sheet by sheet ([`crate::light::patches`]); across the rings, Fejér's first rule where they lie at (j + ½)π/H, and
//! Clenshaw and Curtis's where they lie at jπ/(H - 1), poles included (Waldvogel 2006 for both). With the weights
//! w_j = (2/H) (1 - 2 Σ cos(2kθ_j)/(4k² - 1)) the sum over H rings is exact for all
//! polynomials of cos θ of a degree below H; the exact solid angles of the rings are not, and leak. But they are what light
//! is measured by: w_0 is 12 % above the solid angle of the ring beside the pole, however many rings there are. So images
//! of points are summed with w_j, and those of means with the solid angles, of which a fit (`fit`) takes the leaks.

use super::basis::{Basis, Points, Sums};
use super::count::count;
use crate::error::Error;
use crate::image::ImageView;
use crate::image::raster::Raster;
use crate::image::texel::Texel;
use crate::kernel;
use crate::kernel::Scalar;
use crate::kernel::SimdWork;
use crate::kernel::tile::{TILE, Tile, TuplesMut};
use crate::kernel::{interrupt, threads};
use crate::light::patches::{LANES, SHEET, SIDE, add_lanes};
use crate::map::Map;
use crate::map::verbs::DecodeTile;
use crate::number::real::Real;
use fearless_simd::{Simd, SimdBase, f64x8};
use std::f64::consts::PI;
use std::ops::Range;

/// Columns of a sheet, which are summed by themselves.
const ALONG: usize = SIDE * SHEET;

/// Angles at (2k + offset)/(2 parts) of a turn, or of half a turn across the rings.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Spacing {
    n: usize,
    parts: usize,
    offset: usize,
}

impl Spacing {
    fn of(n: usize, first: f64) -> Spacing {
        if first == 0.0 && n > 1 {
            Spacing {
                n,
                parts: n - 1,
                offset: 0,
            }
        } else {
            Spacing {
                n,
                parts: n,
                offset: 1,
            }
        }
    }

    /// Whether the first and the last lie on the ends.
    fn on_ends(self) -> bool {
        self.offset == 0
    }

    /// How much of a place counts on a circle: where both ends are the same meridian, half of each.
    fn share(self, k: usize) -> f64 {
        let end = self.on_ends() && (k == 0 || k == self.n - 1);
        if end { 0.5 } else { 1.0 }
    }

    fn place(self, k: usize) -> f64 {
        (2 * k + self.offset) as f64 / (2 * self.parts) as f64
    }
}

/// The texels of an image that lie on rings.
pub struct Rings {
    across: Spacing,
    along: Spacing,
    /// Columns: what the image's own x (φ = 0), y (φ = 90°) and z (its pole) are in the world, by rows.
    pub frame: [[f64; 3]; 3],
}

impl Rings {
    /// The rings of an image, if it is made of them.
    pub fn of(map: &Map, shape: &[usize]) -> Result<Option<Rings>, Error> {
        let raster = Raster::new(map, shape)?;
        if map.face_layout().faces != 1 || raster.has_rim() {
            return Ok(None);
        }
        let (w, h) = (raster.width, raster.height);
        let (along, across) = (
            Spacing::of(w, raster.along_u.center(0.0)),
            Spacing::of(h, raster.along_v.center(0.0)),
        );
        // The pole, the meridian of u = 0 and a quarter of a turn from it; then texels of every row and column.
        let mut uv = vec![[0.5, 0.0, 0.0], [0.0, 0.5, 0.0], [0.25, 0.5, 0.0]];
        let some = (0..h)
            .map(|j| (j * 7919 % w, j))
            .chain((0..w).map(|i| (i, i * 7919 % h)));
        for (i, j) in some {
            uv.push([along.place(i), across.place(j), 0.0]);
        }
        let mut directions = vec![[0.0; 3]; uv.len()];
        let mut tile = Tile::new();
        for (uv, directions) in uv.chunks(TILE).zip(directions.chunks_mut(TILE)) {
            uv.iter().enumerate().for_each(|(k, uv)| tile.set(k, *uv));
            map.visit_canonical(DecodeTile {
                turn: map.view_rotation(None).inverse(),
                input: &tile,
                output: TuplesMut::Interleaved(directions),
            });
        }
        let [pole, first, quarter] = [directions[0], directions[1], directions[2]];
        let near = |a: f64, b: f64| (a - b).abs() < 1e-12;
        let regular = uv.iter().zip(&directions).all(|(uv, d)| {
            let (sin, cos) = f64::sin_cos_half_turns(uv[1]);
            let (east, north) = f64::sin_cos_half_turns(2.0 * uv[0]);
            (0..3).all(|k| {
                near(
                    d[k],
                    sin * (north * first[k] + east * quarter[k]) + cos * pole[k],
                )
            })
        });
        let frame = [0, 1, 2].map(|k| [first[k], quarter[k], pole[k]]);
        Ok(regular.then_some(Rings {
            across,
            along,
            frame,
        }))
    }

    /// The highest order whose functions the rings tell apart exactly.
    pub fn highest(&self) -> usize {
        ((self.across.n - 1) / 2).min((self.along.parts.max(1) - 1) / 2)
    }

    /// The weights with which sums over an image of points are exact.
    pub fn exact(&self) -> Vec<f64> {
        quadrature(self.across)
    }

    /// The exact solid angles of the rings, over 2π.
    pub fn solid_angles(&self) -> Vec<f64> {
        let Spacing { n, parts, .. } = self.across;
        let edge = |k: usize| {
            // Between two rings; the first and the last end at the poles.
            let twice = if self.across.on_ends() {
                (2 * k).saturating_sub(1)
            } else {
                2 * k
            };
            f64::sin_cos_half_turns(twice.min(2 * parts) as f64 / (2 * parts) as f64).1
        };
        (0..n).map(|k| edge(k) - edge(k + 1)).collect()
    }

    /// The texels in the image's own frame, row by row, with these weights of the rings.
    pub fn points(&self, weights: &[f64]) -> Points {
        let mut points = Points::default();
        for (j, weight) in weights.iter().enumerate() {
            let (sin, cos) = f64::sin_cos_half_turns(self.across.place(j));
            for i in 0..self.along.n {
                let (y, x) = f64::sin_cos_half_turns(2.0 * self.along.place(i));
                let area = weight * 2.0 * PI / self.along.parts as f64;
                points.push([sin * x, sin * y, cos], area * self.along.share(i));
            }
        }
        points.fill_up();
        points
    }

    /// The coefficients in the image's own frame, with these weights of the rings.
    pub fn analyze<T: Texel>(
        &self,
        image: &ImageView<'_, T>,
        order: usize,
        weights: &[f64],
    ) -> Vec<f64> {
        let channels = image.channels();
        let per = (order + 1) * 2 * channels;
        // For each ring, m, part (cosine, sine) and channel.
        let mut fourier = vec![0.0; self.across.n * per];
        let tables = Tables::new(self.along, order);
        let points = image.texels().len() * (order + 1) / 4;
        let work = |ring: usize, out: &mut [f64]| {
            let mut part = vec![0.0; per];
            for first in (0..self.along.n).step_by(ALONG) {
                let columns = first..(first + ALONG).min(self.along.n);
                tables.sums(image, ring, columns, &mut part);
                out.iter_mut().zip(&part).for_each(|(sum, x)| *sum += x);
            }
        };
        interrupt::part(0.0, 1.0, || {
            threads::rows(&mut fourier, per, points, work);
        });
        self.sum(&fourier, channels, order, weights)
    }

    /// The Fourier sums of some rings over some columns, from one sheet: for each ring, m, part and channel. Those of a ring are the
    /// sums of its sheets from the first column on.
    pub fn fourier_of<T: Texel>(
        &self,
        image: &ImageView<'_, T>,
        order: usize,
        rings: Range<usize>,
        columns: Range<usize>,
    ) -> Vec<f64> {
        let per = (order + 1) * 2 * image.channels();
        let mut fourier = vec![0.0; rings.len() * per];
        let tables = Tables::new(self.along, order);
        let points = rings.len() * columns.len() * per / 8;
        threads::rows(&mut fourier, per, points, |ring, out| {
            tables.sums(image, rings.start + ring, columns.clone(), out);
        });
        fourier
    }

    /// The same of a constant 1.
    pub fn analyze_one(&self, order: usize, weights: &[f64]) -> Vec<f64> {
        let parts = order + 1;
        let mut fourier = vec![0.0; self.across.n * parts * 2];
        for ring in fourier.chunks_exact_mut(2 * parts) {
            ring[0] = self.along.parts as f64;
        }
        self.sum(&fourier, 1, order, weights)
    }

    /// The coefficients from the Fourier sums of each ring.
    pub fn sum(&self, fourier: &[f64], channels: usize, order: usize, weights: &[f64]) -> Vec<f64> {
        let (h, parts) = (self.across.n, order + 1);
        let padded = h.next_multiple_of(LANES);
        let (mut z, mut power) = (vec![0.0; padded], vec![0.0; padded]);
        let mut sin = vec![0.0; padded];
        for (ring, weight) in weights.iter().enumerate() {
            (sin[ring], z[ring]) = f64::sin_cos_half_turns(self.across.place(ring));
            power[ring] = weight * 2.0 * PI / self.along.parts as f64;
        }
        let basis = Basis::new(order);
        let mut sums = Sums::new(order, channels);
        let mut rows = vec![vec![0.0; padded]; 2 * channels];
        for m in 0..=order {
            for ring in 0..h {
                let values = &fourier[(ring * parts + m) * 2 * channels..][..2 * channels];
                for (row, value) in rows.iter_mut().zip(values) {
                    row[ring] = power[ring] * value;
                }
            }
            sums.add_rings(&basis, m, &z, |c| [&rows[c], &rows[channels + c]]);
            power.iter_mut().zip(&sin).for_each(|(p, s)| *p *= s);
        }
        let mut out = vec![0.0; count(order) * channels];
        sums.finish(&mut out);
        out
    }
}

/// cos mφ and sin mφ of every place along a ring, for each m.
struct Tables {
    n: usize,
    rows: Vec<[Vec<f64>; 2]>,
}

impl Tables {
    fn new(along: Spacing, order: usize) -> Tables {
        let turn = 2 * along.parts;
        let angle = |k: usize| f64::sin_cos_half_turns(k as f64 / along.parts as f64);
        let circle: Vec<(f64, f64)> = (0..turn).map(angle).collect();
        let padded = along.n.next_multiple_of(LANES);
        let row = |m: usize| {
            let mut row = [vec![0.0; padded], vec![0.0; padded]];
            for k in 0..along.n {
                let (sin, cos) = circle[m * (2 * k + along.offset) % turn];
                let weight = along.share(k);
                row[0][k] = weight * cos;
                row[1][k] = weight * sin;
            }
            row
        };
        Tables {
            n: along.n,
            rows: (0..=order).map(row).collect(),
        }
    }

    /// The sums of a ring over some columns, which begin at whole lanes.
    fn sums<T: Texel>(
        &self,
        image: &ImageView<'_, T>,
        ring: usize,
        columns: Range<usize>,
        out: &mut [f64],
    ) {
        let channels = image.channels();
        let texels = &image.texels()[(ring * self.n + columns.start) * channels..];
        let padded = columns.len().next_multiple_of(LANES);
        let mut values = vec![0.0; padded * channels];
        for (c, row) in values.chunks_exact_mut(padded).enumerate() {
            let own = texels[c..].iter().step_by(channels);
            for (value, texel) in row.iter_mut().zip(own).take(columns.len()) {
                *value = texel.load().to_f64();
            }
        }
        let mut sums = [[0.0; LANES]; 6];
        for (m, tables) in self.rows.iter().enumerate() {
            let [cos, sin] = tables.each_ref().map(|t| &t[columns.start..][..padded]);
            let out = &mut out[m * 2 * channels..][..2 * channels];
            let mut first = 0;
            while first < channels {
                let row = |k: usize| &values[(first + k) * padded..][..padded];
                let size = if channels - first >= 3 {
                    kernel::run_simd(Products {
                        tables: [cos, sin],
                        rows: [row(0), row(1), row(2)],
                        sums: &mut sums,
                    });
                    3
                } else {
                    kernel::run_simd(Products {
                        tables: [cos, sin],
                        rows: [row(0)],
                        sums: &mut sums,
                    });
                    1
                };
                for k in 0..size {
                    out[first + k] = add_lanes(&sums[k]);
                    out[channels + first + k] = add_lanes(&sums[3 + k]);
                }
                first += size;
            }
        }
    }
}

struct Products<'a, const N: usize> {
    tables: [&'a [f64]; 2],
    rows: [&'a [f64]; N],
    sums: &'a mut [[f64; LANES]; 6],
}

impl<const N: usize> SimdWork for Products<'_, N> {
    #[inline(always)]
    fn run<S: Simd>(self, simd: S) {
        let [cos, sin] = self.tables.map(|t| t.as_chunks::<LANES>().0);
        let n = cos.len();
        let sin = &sin[..n];
        let rows = self.rows.map(|r| &r.as_chunks::<LANES>().0[..n]);
        let zero = f64x8::splat(simd, 0.0);
        let (mut a, mut b) = ([zero; N], [zero; N]);
        for i in 0..n {
            let cos = f64x8::load_array_ref(simd, &cos[i]);
            let sin = f64x8::load_array_ref(simd, &sin[i]);
            for k in 0..N {
                let value = f64x8::load_array_ref(simd, &rows[k][i]);
                a[k] += value * cos;
                b[k] += value * sin;
            }
        }
        for k in 0..N {
            a[k].store_array(&mut self.sums[k]);
            b[k].store_array(&mut self.sums[3 + k]);
        }
    }
}

/// Weights of ∫ f(cos θ) sin θ dθ at the rings.
fn quadrature(across: Spacing) -> Vec<f64> {
    let n = across.parts;
    let turn = 4 * n;
    let circle: Vec<f64> = (0..turn)
        .map(|k| f64::sin_cos_half_turns(k as f64 / (2 * n) as f64).1)
        .collect();
    let half = n / 2;
    let weight = |j: usize| {
        // 2kθ = k (2j + offset)/n half turns, in steps of 1/(2n).
        let step = 2 * (2 * j + across.offset) % turn;
        let mut place = 0;
        let mut sum = 0.0;
        for k in 1..=half {
            place = (place + step) % turn;
            // The last cosine of Clenshaw and Curtis's rule counts half; in Fejér's it is 0.
            let last = if 2 * k == n { 0.5 } else { 1.0 };
            sum += last * circle[place] / (4 * k * k - 1) as f64;
        }
        let end = across.on_ends() && (j == 0 || j == across.n - 1);
        (if end { 1.0 } else { 2.0 }) / n as f64 * (1.0 - 2.0 * sum)
    };
    (0..across.n).map(weight).collect()
}

/// A grid whose sums are exact for functions up to order `degree`, with its weights.
pub fn grid(degree: usize) -> Points {
    let n = degree + 1;
    let rings = Rings {
        across: Spacing::of(n, 0.5),
        along: Spacing::of(n + n % 2, 0.5),
        frame: [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]],
    };
    rings.points(&rings.exact())
}
