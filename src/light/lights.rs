//! An image as a few directional lights.
//!
//! Texels are counted, whole, into a grid of latitude and longitude with about as many cells, at most 512×1024, and the
//! grid is cut into rectangles:
//!
//! - **median cut** (Debevec, "A Median Cut Algorithm for Light Probe Sampling", SIGGRAPH 2005 posters): the region
//!   with the most light is halved, across its longer side as the sphere has it;
//! - **variance** (Viriyothai & Debevec, "Variance Minimization Light Probe Sampling", SIGGRAPH 2009 posters): the
//!   region of the largest variance is cut where the larger variance of its parts is smallest, which does not go
//!   through lamps. The variance is Σ e |d - c|² = Σ e - |Σ e d|²/Σ e for unit d with energies e and centroid c.
//!
//! A light stands at the centroid of its region's luminance. Sums over rectangles are differences of a table of sums,
//! so a cut costs as many steps as the region has rows and columns. Negative luminance counts as none in cuts; in the
//! lights it is kept, so that they sum to the image's ∫ L dω.
//!
//! Singular: without light, or with the same from everywhere, a region has no centroid, and its direction is +y. Regions
//! that cannot be cut into two that both hold light stay whole: there are fewer lights where light comes from fewer
//! places. All sums run in stored order on one thread: neither threads nor SIMD levels change a bit.

use super::lit::{Counted, Lit};
use crate::error::Error;
use crate::image::ImageView;
use crate::image::texel::Texel;
use crate::kernel::memory::expect_room;
use crate::kernel::pages;
use crate::map::Map;
use crate::number::real::Real;
use std::cmp::Ordering;
use std::collections::BinaryHeap;
use std::f64::consts::PI;

/// Which region is cut, and where.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Method {
    /// The brightest, into halves.
    Median,
    /// That of the largest variance, where its parts have the least.
    Variance,
}

impl Method {
    /// The method of this name.
    ///
    /// # Errors
    /// For another name.
    ///
    /// ```
    /// use spheremap::light::lights::Method;
    /// assert_eq!(Method::find("median"), Ok(Method::Median));
    /// assert!(Method::find("mean").is_err());
    /// ```
    pub fn find(name: &str) -> Result<Method, Error> {
        match name {
            "median" => Ok(Method::Median),
            "variance" => Ok(Method::Variance),
            _ => Err(Error::unknown("method", name, &["median", "variance"])),
        }
    }
}

/// A directional light: a part of the sphere.
#[derive(Clone, Debug, PartialEq)]
pub struct Light {
    /// Toward it, in the world; a unit vector.
    pub direction: [f64; 3],
    /// ∫ L dω over its part, of each channel.
    pub irradiance: Vec<f64>,
    /// Of its part.
    pub solid_angle: f64,
}

/// At most `count` lights that stand for an image whose channels make luminance with these weights, brightest first.
///
/// # Errors
/// There are not as many weights as channels, or there is no memory for it.
///
/// ```
/// use spheremap::light::lights::{Method, lights};
/// use spheremap::{Map, image::ImageView};
/// let map = Map::new("latlong")?;
/// let mut sky = vec![0.0; 32 * 64];
/// (sky[5 * 64 + 9], sky[20 * 64 + 50]) = (300.0, 100.0);
/// let sky = ImageView::new(&map, &[32, 64], 1, &sky)?;
/// let lights = lights(&sky, &[1.0], 8, Method::Variance)?;
/// assert_eq!(lights.len(), 2); // light comes from two places only
/// assert!(lights[0].irradiance > lights[1].irradiance);
/// # Ok::<(), spheremap::Error>(())
/// ```
pub fn lights<T: Texel>(
    image: &ImageView<'_, T>,
    luminance: &[f64],
    count: usize,
    method: Method,
) -> Result<Vec<Light>, Error> {
    let counted = Counted::new(image, luminance)?;
    let mut grid = Grid::new(counted.covered(), image.channels())?;
    let places = grid.places;
    let latlong = Map::new("latlong")?;
    let see = |lit: Lit| (places.of(&latlong, &lit), lit);
    counted.in_bands(see, |(cells, lit)| grid.add(&cells, &lit))?;
    Ok(cut(&grid, count, method))
}

fn cut(grid: &Grid, count: usize, method: Method) -> Vec<Light> {
    let mut sums: Vec<Vec<f64>> = regions(grid, count, method)
        .into_iter()
        .map(|region| grid.sums(region))
        .collect();
    sums.sort_by(|a, b| b[1].total_cmp(&a[1]));
    let light = |sums: Vec<f64>| {
        let toward = [sums[2], sums[3], sums[4]];
        let length = toward.iter().map(|x| x * x).sum::<f64>().sqrt();
        let has_centroid = length > 1e-12 * sums[1];
        Light {
            direction: if has_centroid {
                toward.map(|x| x / length)
            } else {
                [0.0, 1.0, 0.0]
            },
            irradiance: sums[5..].to_vec(),
            solid_angle: sums[0],
        }
    };
    sums.into_iter().map(light).collect()
}

/// The cells of a latlong.
#[derive(Clone, Copy, Debug)]
struct Places {
    rows: usize,
    columns: usize,
}

impl Places {
    /// In which of them each of some texels is.
    fn of(self, latlong: &Map, lit: &Lit) -> Vec<u32> {
        let mut uv = vec![0.0; 2 * lit.direction.len()];
        latlong.encode_numbers(None, lit.direction.as_flattened(), &mut uv);
        let at = |x: f64, n: usize| ((x * n as f64) as usize).min(n - 1);
        let places = uv.as_chunks::<2>().0.iter();
        places
            .map(|[u, v]| (at(*v, self.rows) * self.columns + at(*u, self.columns)) as u32)
            .collect()
    }
}

/// Sums over the texels of each cell: solid angle, energy, energy times direction (3), and ∫ L dω.
struct Grid {
    places: Places,
    each: usize,
    cells: Vec<f64>,
}

impl Grid {
    /// An empty one for so many texels, which cover so much of the sphere.
    fn new((texels, covered): (usize, f64), channels: usize) -> Result<Grid, Error> {
        // As many cells on the whole sphere as it would have texels.
        let texels = texels as f64 * 4.0 * PI / covered;
        let rows = (0.5 * texels).sqrt().round_ties_even().clamp(2.0, 512.0) as usize;
        let (columns, each) = (2 * rows, 5 + channels);
        // A table of sums is made of it.
        expect_room::<f64>(rows * columns * (each + 4))?;
        Ok(Grid {
            places: Places { rows, columns },
            each,
            cells: pages::filled(rows * columns * each, 0.0),
        })
    }

    /// Adds texels, which are in these cells.
    fn add(&mut self, cells: &[u32], lit: &Lit) {
        for (k, cell) in cells.iter().enumerate() {
            let weight = lit.weight[k];
            let energy = lit.luminance[k].max(0.0) * weight;
            let direction = lit.direction[k].map(|x| energy * x);
            let light = lit.radiance(k).iter().map(|x| weight * x);
            let values = [weight, energy].into_iter().chain(direction).chain(light);
            let sums = &mut self.cells[*cell as usize * self.each..][..self.each];
            for (sum, value) in sums.iter_mut().zip(values) {
                *sum += value;
            }
        }
    }

    /// The sums over a region.
    fn sums(&self, region: Region) -> Vec<f64> {
        let mut sums = vec![0.0; self.each];
        for row in region.top..region.bottom {
            for column in region.left..region.right {
                let cell = (row * self.places.columns + column) * self.each;
                for (sum, value) in sums.iter_mut().zip(&self.cells[cell..]) {
                    *sum += value;
                }
            }
        }
        sums
    }
}

/// Rows and columns of the grid, the last ones excluded.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Region {
    top: usize,
    bottom: usize,
    left: usize,
    right: usize,
}

impl Region {
    /// Its first `lines` rows (axis 0) or columns, and the others.
    fn cut(self, axis: usize, lines: usize) -> [Region; 2] {
        if axis == 0 {
            let middle = self.top + lines;
            let (above, below) = (
                Region {
                    bottom: middle,
                    ..self
                },
                Region {
                    top: middle,
                    ..self
                },
            );
            return [above, below];
        }
        let middle = self.left + lines;
        let (left, right) = (
            Region {
                right: middle,
                ..self
            },
            Region {
                left: middle,
                ..self
            },
        );
        [left, right]
    }
}

/// Energy, and energy times direction.
type Moments = [f64; 4];

fn minus(a: Moments, b: Moments) -> Moments {
    [0, 1, 2, 3].map(|k| a[k] - b[k])
}

fn variance([energy, x, y, z]: Moments) -> f64 {
    if energy > 0.0 {
        (energy - (x * x + y * y + z * z) / energy).max(0.0)
    } else {
        0.0
    }
}

/// Sums over all rectangles that begin at the first cell.
struct Table {
    rows: usize,
    columns: usize,
    sums: Vec<Moments>,
    /// What a difference of sums rounds to where there is no light at all.
    dark: f64,
}

impl Table {
    fn new(grid: &Grid) -> Table {
        let Places { rows, columns } = grid.places;
        let width = columns + 1;
        let mut sums = pages::filled((rows + 1) * width, [0.0; 4]);
        // Down each column first, then along the rows.
        for row in 0..rows {
            for column in 0..columns {
                let cell = &grid.cells[(row * columns + column) * grid.each + 1..];
                let above = sums[row * width + column + 1];
                sums[(row + 1) * width + column + 1] = [0, 1, 2, 3].map(|k| above[k] + cell[k]);
            }
        }
        for row in sums.chunks_mut(width) {
            for column in 1..width {
                row[column] = [0, 1, 2, 3].map(|k| row[column - 1][k] + row[column][k]);
            }
        }
        let dark = 1e-13 * sums[sums.len() - 1][0];
        Table {
            rows,
            columns,
            sums,
            dark,
        }
    }

    fn at(&self, row: usize, column: usize) -> Moments {
        self.sums[row * (self.columns + 1) + column]
    }

    fn sum(&self, r: Region) -> Moments {
        let right = minus(self.at(r.bottom, r.right), self.at(r.top, r.right));
        let left = minus(self.at(r.bottom, r.left), self.at(r.top, r.left));
        minus(right, left)
    }

    /// The cut across an axis after the number of lines for which `badness` of the sums of both parts is least, with
    /// that; only cuts whose parts both hold light.
    fn best_cut(
        &self,
        r: Region,
        axis: usize,
        badness: impl Fn(Moments, Moments) -> f64,
    ) -> Option<(f64, usize)> {
        let total = self.sum(r);
        let line = |k: usize| {
            if axis == 0 {
                minus(self.at(r.top + k, r.right), self.at(r.top + k, r.left))
            } else {
                minus(self.at(r.bottom, r.left + k), self.at(r.top, r.left + k))
            }
        };
        let lines = if axis == 0 {
            r.bottom - r.top
        } else {
            r.right - r.left
        };
        let none = line(0);
        let mut best: Option<(f64, usize)> = None;
        for k in 1..lines {
            let first = minus(line(k), none);
            let second = minus(total, first);
            if first[0] > self.dark && second[0] > self.dark {
                let bad = badness(first, second);
                if best.is_none_or(|(least, _)| bad < least) {
                    best = Some((bad, k));
                }
            }
        }
        best
    }

    fn median_cut(&self, r: Region) -> Option<[Region; 2]> {
        let half_turns = 0.5 - 0.5 * (r.top + r.bottom) as f64 / self.rows as f64;
        let (_, cos) = f64::sin_cos_half_turns(half_turns);
        let wide = (r.right - r.left) as f64 * cos > (r.bottom - r.top) as f64;
        let half = 0.5 * self.sum(r)[0];
        let axes = if wide { [1, 0] } else { [0, 1] };
        axes.into_iter().find_map(|axis| {
            let cut = self.best_cut(r, axis, |first, _| (first[0] - half).abs());
            cut.map(|(_, lines)| r.cut(axis, lines))
        })
    }

    fn variance_cut(&self, r: Region) -> Option<[Region; 2]> {
        let larger = |first, second| variance(first).max(variance(second));
        let [down, across] = [0, 1].map(|axis| self.best_cut(r, axis, larger));
        match (down, across) {
            (Some((a, _)), Some((b, lines))) if b < a => Some(r.cut(1, lines)),
            (Some((_, lines)), _) => Some(r.cut(0, lines)),
            (None, Some((_, lines))) => Some(r.cut(1, lines)),
            (None, None) => None,
        }
    }
}

/// A region that may be cut: the highest rank first, of equals the one that was made first.
struct Candidate {
    rank: f64,
    made: usize,
    region: Region,
}

impl Ord for Candidate {
    fn cmp(&self, other: &Self) -> Ordering {
        let by_rank = self.rank.total_cmp(&other.rank);
        by_rank.then(other.made.cmp(&self.made))
    }
}

impl PartialOrd for Candidate {
    fn partial_cmp(&self, other: &Self) -> Option<Ordering> {
        Some(self.cmp(other))
    }
}

impl PartialEq for Candidate {
    fn eq(&self, other: &Self) -> bool {
        self.cmp(other) == Ordering::Equal
    }
}

impl Eq for Candidate {}

/// Cuts the grid into at most `count` regions.
fn regions(grid: &Grid, count: usize, method: Method) -> Vec<Region> {
    let table = Table::new(grid);
    let mut whole = Vec::new();
    let mut queue = BinaryHeap::from([Candidate {
        rank: 0.0,
        made: 0,
        region: Region {
            top: 0,
            bottom: grid.places.rows,
            left: 0,
            right: grid.places.columns,
        },
    }]);
    let mut made = 1;
    while queue.len() + whole.len() < count
        && let Some(Candidate { region, .. }) = queue.pop()
    {
        let parts = match method {
            Method::Median => table.median_cut(region),
            Method::Variance => table.variance_cut(region),
        };
        let Some(parts) = parts else {
            whole.push(region);
            continue;
        };
        for region in parts {
            let sums = table.sum(region);
            let rank = match method {
                Method::Median => sums[0],
                Method::Variance => variance(sums),
            };
            queue.push(Candidate { rank, made, region });
            made += 1;
        }
    }
    let mut rest = queue.into_vec();
    rest.sort_by_key(|candidate| candidate.made);
    whole.extend(rest.into_iter().map(|candidate| candidate.region));
    whole
}

#[cfg(test)]
mod tests {
    use super::*;

    fn lit(image: impl Fn(usize, usize) -> f64) -> Lit {
        let (rows, columns) = (16, 32);
        let map = Map::new("latlong").unwrap();
        let texels: Vec<f64> = (0..rows * columns)
            .map(|k| image(k / columns, k % columns))
            .collect();
        let view = ImageView::new(&map, &[16, 32], 1, &texels).unwrap();
        Lit::new(&view, &[1.0]).unwrap()
    }

    fn cut(lit: &Lit, count: usize, method: Method) -> Vec<Light> {
        let covered = (lit.weight.len(), lit.weight.iter().sum());
        let mut grid = Grid::new(covered, lit.channels).unwrap();
        let cells = grid.places.of(&Map::new("latlong").unwrap(), lit);
        grid.add(&cells, lit);
        super::cut(&grid, count, method)
    }

    const METHODS: [Method; 2] = [Method::Median, Method::Variance];

    #[test]
    fn nothing_is_lost() {
        let lit = lit(|j, i| ((j * 31 + i * 17) % 29) as f64 - 0.5);
        let integral: f64 = lit.light.iter().zip(&lit.weight).map(|(l, w)| l * w).sum();
        for method in METHODS {
            for count in [1, 7, 60] {
                let lights = cut(&lit, count, method);
                assert_eq!(lights.len(), count);
                let sum: f64 = lights.iter().map(|light| light.irradiance[0]).sum();
                // Rounding of 512 sums.
                assert!((sum / integral - 1.0).abs() < 1e-12);
                let covered: f64 = lights.iter().map(|light| light.solid_angle).sum();
                assert!((covered / (4.0 * PI) - 1.0).abs() < 1e-12);
            }
        }
    }

    #[test]
    fn there_are_no_more_lights_than_places() {
        let two = lit(|j, i| match (j, i) {
            (3, 4) => 5.0,
            (12, 20) => 1.0,
            _ => 0.0,
        });
        for method in METHODS {
            let found = cut(&two, 10, method);
            assert_eq!(found.len(), 2);
            let off = (0..3).map(|c| found[0].direction[c] - two.direction[3 * 32 + 4][c]);
            assert!(off.fold(0.0, |m: f64, x| m.max(x.abs())) < 1e-14);
        }
        let dark = cut(&lit(|_, _| 0.0), 10, Method::Median);
        assert_eq!((dark.len(), dark[0].direction), (1, [0.0, 1.0, 0.0]));
    }

    #[test]
    fn methods_have_names() {
        assert_eq!(Method::find("variance"), Ok(Method::Variance));
        assert!(Method::find("mean").is_err());
    }
}
