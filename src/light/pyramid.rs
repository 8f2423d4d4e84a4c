//! A cube map of an image with its mip chain, for lookups with a footprint.
//!
//! Whatever the source's map, it becomes a cube whose texels are no larger than the source's (in the mean, and up to
//! [`LARGEST`]² a face). A source beyond that is first reduced within its own map ([`crate::resample::mips`]), which keeps
//! its light. Lookups make the finest level, and lose of a lone texel up to a tenth, or make as much; so four of its texels are as bright as what they
//! cover is by area: light is kept from there on. Below its first level the cube is reduced as any image is. Each face has
//! a border of one texel that continues into its neighbors, so that a bilinear lookup never meets an edge.
//!
//! Directions outside a source's coverage are black.

use crate::error::Error;
use crate::geometry::solid_angle;
use crate::geometry::solid_angle::Rect;
use crate::geometry::world::Worlds;
use crate::image::ImageView;
use crate::image::raster::Raster;
use crate::image::texel::Texel;
use crate::kernel;
use crate::kernel::Scalar;
use crate::kernel::SimdWork;
use crate::kernel::interrupt;
use crate::kernel::memory::expect_room;
use crate::map::Map;
use crate::resample::mips::half;
use crate::resample::{Options, Request, Window, convert, convert_light};
use fearless_simd::{Select, Simd, SimdBase, f32x16};

/// The largest face.
const LARGEST: usize = 512;

/// Up to four channels.
pub type Texel4 = [f32; 4];

/// One level: six faces of (n + 2)² texels.
#[derive(Debug)]
pub struct PyramidLevel {
    /// Texels along a face, without its border.
    pub n: usize,
    faces: Vec<Texel4>,
}

/// All levels, the finest first.
#[derive(Debug)]
pub struct Pyramid {
    /// The levels.
    pub levels: Vec<PyramidLevel>,
}

/// The direction at (p, q) in [-1, 1]² of a face, and beyond: the table that OpenGL, Direct3D and Vulkan share.
fn direction(face: usize, p: f64, q: f64) -> [f64; 3] {
    match face {
        0 => [1.0, -q, -p],
        1 => [-1.0, -q, p],
        2 => [p, 1.0, q],
        3 => [p, -1.0, -q],
        4 => [p, -q, 1.0],
        _ => [-p, -q, -1.0],
    }
}

/// The face of a direction, and (p, q) there.
fn place(d: [f64; 3]) -> (usize, f64, f64) {
    let [x, y, z] = d;
    let (ax, ay, az) = (x.abs(), y.abs(), z.abs());
    if ax >= ay && ax >= az {
        (usize::from(x < 0.0), -z / x, -y / ax)
    } else if ay >= az {
        (2 + usize::from(y < 0.0), x / ay, z / y)
    } else {
        (4 + usize::from(z < 0.0), x / z, -y / az)
    }
}

impl Pyramid {
    /// Of channels `first` to `first + 3` of an image.
    pub fn new<T: Texel>(image: &ImageView<'_, T>, first: usize) -> Result<Pyramid, Error> {
        let (map, mut shape) = (image.map(), image.shape().to_vec());
        let mut count = image.raster().texels();
        let four = |k: usize| -> [f64; 4] {
            let texel = image.texel(k);
            std::array::from_fn(|c| {
                if first + c < texel.len() {
                    texel[first + c].load().to_f64()
                } else {
                    0.0
                }
            })
        };
        // Four numbers twice; what a smaller version of them takes is asked for there.
        expect_room::<[u8; 48]>(count)?;
        // Fours, and not numbers by `flat_map`: LLVM 22 does not come to an end with that.
        let fours: Vec<[f64; 4]> = (0..count).map(four).collect();
        let mut values = fours.into_flattened();
        // Each takes a quarter of the one before.
        let mut done = 0.0;
        while count > 8 * LARGEST * LARGEST {
            let fine = ImageView::new(map, &shape, 4, &values)?;
            let Some(level) = interrupt::part(done, 0.75 + 0.25 * done, || half(&fine))? else {
                break;
            };
            done = 0.75 + 0.25 * done;
            (shape, values) = level;
            count = values.len() / 4;
        }
        let flat: Vec<f32> = values.iter().map(|x| *x as f32).collect();
        // The rest has room where it was.
        drop(values);
        let view = ImageView::new(map, &shape, 4, &flat)?;
        let mut n = 8;
        while 6 * n * n < count && n < LARGEST {
            n *= 2;
        }
        let level = interrupt::part(done, 1.0, || PyramidLevel::of(&view, n))?;
        let mut levels = vec![level];
        while let Some(next) = levels.last().filter(|l| l.n > 1).map(PyramidLevel::half) {
            levels.push(next);
        }
        Ok(Pyramid { levels })
    }
}

impl PyramidLevel {
    /// The finest level of an image of four channels.
    fn of(view: &ImageView<'_, f32>, n: usize) -> Result<PyramidLevel, Error> {
        let cube = Map::new("cube")?;
        let shape = [6, n, n];
        let mut seen = vec![0.0; 4 * 6 * n * n];
        let options = Options::new().worlds(Worlds::Literal).fill(0.0);
        interrupt::part(0.0, 0.2, || {
            convert(view, &cube, &shape, &options, &mut seen)
        })?;
        let half = n / 2;
        let shape = [6, half, half];
        let mut light = vec![0.0; 4 * 6 * half * half];
        let request = Request {
            image: view,
            map: &cube,
            shape: &shape,
            rotation: None,
            fill: &[0.0; 4],
            window: &Window::whole(&Raster::new(&cube, &shape)?),
        };
        interrupt::part(0.2, 1.0, || convert_light(request, &mut light))?;
        let (seen, light) = (seen.as_chunks::<4>().0, light.as_chunks::<4>().0);
        let mut level = PyramidLevel::empty(n);
        for j in 0..half {
            for i in 0..half {
                let (children, areas) = level.children(i, j);
                for face in 0..6 {
                    let own = children.map(|(x, y)| seen[(face * n + y) * n + x]);
                    let light = light[(face * half + j) * half + i];
                    let kept = with_light(own, areas, light);
                    for ((x, y), texel) in children.into_iter().zip(kept) {
                        let to = level.index(face, x + 1, y + 1);
                        level.faces[to] = texel;
                    }
                }
            }
        }
        level.close();
        Ok(level)
    }

    fn empty(n: usize) -> PyramidLevel {
        PyramidLevel {
            n,
            faces: vec![[0.0; 4]; 6 * (n + 2) * (n + 2)],
        }
    }

    fn index(&self, face: usize, i: usize, j: usize) -> usize {
        (face * (self.n + 2) + j) * (self.n + 2) + i
    }

    /// Fills the border from the neighbors.
    fn close(&mut self) {
        let n = self.n;
        for face in 0..6 {
            for k in 0..n + 2 {
                for (i, j) in [(k, 0), (k, n + 1), (0, k), (n + 1, k)] {
                    let at = |i: usize| (2.0 * i as f64 - 1.0) / n as f64 - 1.0;
                    let (other, p, q) = place(direction(face, at(i), at(j)));
                    let target = self.index(face, i, j);
                    self.faces[target] = self.within(other, p, q);
                }
            }
        }
    }

    /// Bilinear, from the texels inside a face alone.
    fn within(&self, face: usize, p: f64, q: f64) -> Texel4 {
        let n = self.n as f64;
        let split = |p: f64| {
            let x = (0.5 * (p + 1.0) * n + 0.5).clamp(1.0, n);
            let low = (x.floor()).min((n - 1.0).max(1.0));
            (low as usize, (x - low) as f32)
        };
        let ((i, a), (j, b)) = (split(p), split(q));
        let (k, l) = ((i + 1).min(self.n), (j + 1).min(self.n));
        let texel = |i, j| self.faces[self.index(face, i, j)];
        let (t00, t10, t01, t11) = (texel(i, j), texel(k, j), texel(i, l), texel(k, l));
        std::array::from_fn(|c| {
            let top = t00[c] + a * (t10[c] - t00[c]);
            let bottom = t01[c] + a * (t11[c] - t01[c]);
            top + b * (bottom - top)
        })
    }

    /// The next level.
    fn half(&self) -> PyramidLevel {
        let n = self.n / 2;
        let mut level = PyramidLevel::empty(n);
        for j in 0..n {
            for i in 0..n {
                let (children, areas) = self.children(i, j);
                for face in 0..6 {
                    let own = children.map(|(x, y)| self.faces[self.index(face, x + 1, y + 1)]);
                    let target = level.index(face, i + 1, j + 1);
                    level.faces[target] =
                        std::array::from_fn(|c| mean(own.map(|x| x[c]), areas) as f32);
                }
            }
        }
        level.close();
        level
    }

    /// The texels that one of the next level covers on any face, and how much of it each is.
    fn children(&self, i: usize, j: usize) -> ([(usize, usize); 4], [f64; 4]) {
        let children = [(0, 0), (1, 0), (0, 1), (1, 1)].map(|(a, b)| (2 * i + a, 2 * j + b));
        let edge = |k: usize| k as f64 / self.n as f64;
        let areas = children.map(|(i, j)| {
            solid_angle::cube(Rect {
                u0: edge(i),
                u1: edge(i + 1),
                v0: edge(j),
                v1: edge(j + 1),
            })
        });
        let total: f64 = areas.iter().sum();
        (children, areas.map(|area| area / total))
    }

    /// So many channels of its texels, as an image of the `cube`.
    pub fn texels(&self, channels: usize) -> Vec<f32> {
        let rows = (0..6).flat_map(|face| (1..=self.n).map(move |j| (face, j)));
        let mut texels = Vec::with_capacity(6 * self.n * self.n * channels);
        for (face, j) in rows {
            let row = &self.faces[self.index(face, 1, j)..][..self.n];
            row.iter()
                .for_each(|texel| texels.extend_from_slice(&texel[..channels]));
        }
        texels
    }

    /// The texels' mean solid angle.
    pub fn texel_area(&self) -> f64 {
        4.0 * std::f64::consts::PI / (6 * self.n * self.n) as f64
    }

    /// Adds `weight` times the value at each direction.
    pub fn add(&self, rows: &mut Rows, weight: f32, out: &mut [Texel4]) {
        kernel::run_simd(Places {
            rows,
            n: self.n as f32,
        });
        let stride = self.n + 2;
        let places = rows.index.as_flattened().iter();
        let fractions = rows.a.as_flattened().iter().zip(rows.b.as_flattened());
        for ((out, &index), (&a, &b)) in out.iter_mut().zip(places).zip(fractions) {
            let index = index as usize;
            let (Some([t00, t10]), Some([t01, t11])) = (
                self.faces.get(index..index + 2),
                self.faces.get(index + stride..index + stride + 2),
            ) else {
                continue;
            };
            let (wb, wt) = (weight * b, weight * (1.0 - b));
            for c in 0..4 {
                let top = t00[c] + a * (t10[c] - t00[c]);
                let bottom = t01[c] + a * (t11[c] - t01[c]);
                out[c] += wt * top + wb * bottom;
            }
        }
    }
}

fn mean(texels: [f32; 4], areas: [f64; 4]) -> f64 {
    let each = texels.into_iter().zip(areas);
    each.map(|(texel, area)| area * f64::from(texel)).sum()
}

/// Four texels as lookups found them, made to have this mean: as bright among each other as they were, if none is of another sign.
fn with_light(texels: [Texel4; 4], areas: [f64; 4], light: Texel4) -> [Texel4; 4] {
    let mut kept = texels;
    for c in 0..4 {
        let (own, wanted) = (texels.map(|x| x[c]), f64::from(light[c]));
        let found = mean(own, areas);
        let alike = own.iter().all(|x| f64::from(*x) * wanted >= 0.0);
        for (kept, own) in kept.iter_mut().zip(own.map(f64::from)) {
            let new = if alike && found != 0.0 {
                own / found * wanted
            } else {
                own + (wanted - found)
            };
            kept[c] = new.clamp(f64::from(f32::MIN), f64::from(f32::MAX)) as f32;
        }
    }
    kept
}

const LANES: usize = 16;

/// Directions of a run of texels and where they fall.
#[derive(Default)]
pub struct Rows {
    /// Tangents, bitangents and normals, component by component.
    pub frames: [Vec<[f32; LANES]>; 9],
    /// The direction to look up, in each texel's own frame.
    pub local: [f32; 3],
    index: Vec<[f32; LANES]>,
    a: Vec<[f32; LANES]>,
    b: Vec<[f32; LANES]>,
}

impl Rows {
    /// Room for the frames about these normals.
    pub fn new(normals: &[[f64; 3]]) -> Rows {
        let n = normals.len().div_ceil(LANES);
        let mut rows = Rows::default();
        for row in rows
            .frames
            .iter_mut()
            .chain([&mut rows.index, &mut rows.a, &mut rows.b])
        {
            row.resize(n, [0.0; LANES]);
        }
        for k in 0..n * LANES {
            let d = normals.get(k).copied().unwrap_or([0.0, 0.0, 1.0]);
            let d = if d[0].is_nan() { [0.0, 0.0, 1.0] } else { d };
            // Duff et al. 2017: a frame about any unit vector, without a singular point.
            let sign = 1.0_f64.copysign(d[2]);
            let a = -1.0 / (sign + d[2]);
            let b = d[0] * d[1] * a;
            let frame = [
                [1.0 + sign * d[0] * d[0] * a, sign * b, -sign * d[0]],
                [b, sign + d[1] * d[1] * a, -d[1]],
                d,
            ];
            for (row, value) in rows.frames.iter_mut().zip(frame.as_flattened()) {
                row[k / LANES][k % LANES] = *value as f32;
            }
        }
        rows
    }
}

/// One component of a direction given in a frame.
#[inline(always)]
fn turned<S: Simd>(simd: S, frame: [&[f32; LANES]; 3], local: [f32x16<S>; 3]) -> f32x16<S> {
    let [t, b, n] = frame;
    f32x16::load_array_ref(simd, t) * local[0]
        + f32x16::load_array_ref(simd, b) * local[1]
        + f32x16::load_array_ref(simd, n) * local[2]
}

struct Places<'a> {
    rows: &'a mut Rows,
    n: f32,
}

impl SimdWork for Places<'_> {
    #[inline(always)]
    fn run<S: Simd>(self, simd: S) {
        let number = |x: f32| f32x16::splat(simd, x);
        let [lx, ly, lz] = self.rows.local.map(number);
        let (half, zero) = (number(0.5 * self.n), number(0.0));
        // Rounds to the nearest integer.
        let magic = number(1.5 / f32::EPSILON);
        let stride = number(self.n + 2.0);
        let frames = &self.rows.frames;
        let out = self
            .rows
            .index
            .iter_mut()
            .zip(&mut self.rows.a)
            .zip(&mut self.rows.b);
        for (k, ((index, a), b)) in out.enumerate() {
            let local = [lx, ly, lz];
            let x = turned(simd, [&frames[0][k], &frames[3][k], &frames[6][k]], local);
            let y = turned(simd, [&frames[1][k], &frames[4][k], &frames[7][k]], local);
            let z = turned(simd, [&frames[2][k], &frames[5][k], &frames[8][k]], local);
            let (ax, ay, az) = (x.abs(), y.abs(), z.abs());
            let by_x = ax.simd_ge(ay) & ax.simd_ge(az);
            let by_y = ay.simd_ge(az);
            let largest = ax.max(ay).max(az);
            let signed =
                |by: f32x16<S>, value: f32x16<S>| by.simd_lt(zero).select(zero - value, value);
            let p = by_x.select(signed(x, zero - z), by_y.select(x, signed(z, x)));
            let down = zero - y;
            let q = by_x.select(down, by_y.select(signed(y, z), down));
            let axis = by_x.select(x, by_y.select(y, z));
            let first = by_x.select(zero, by_y.select(number(2.0), number(4.0)));
            let face = first + axis.simd_lt(zero).select(number(1.0), zero);
            // From the first texel's center on, the border being texel 0.
            let scale = half / largest;
            let offset = half + number(0.5);
            let (s, t) = (p * scale + offset, q * scale + offset);
            let (half_texel, bound) = (number(0.5), number(self.n));
            let i = ((s - half_texel + magic) - magic).max(zero).min(bound);
            let j = ((t - half_texel + magic) - magic).max(zero).min(bound);
            (s - i).store_array(a);
            (t - j).store_array(b);
            ((face * stride + j) * stride + i).store_array(index);
        }
    }
}
