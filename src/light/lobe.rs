//! Exact sums of light under a lobe: irradiance, cones, Phong and von Mises–Fisher lobes, GGX and Charlie.
//!
//! For every wanted direction n the sum Σ L K(n·ω) dω over all texels, in f64. K is a function of the cosine
//! alone. The sum is taken block by block ([`crate::light::texels`]), and a block is a patch of the sphere with an axis
//! and a radius, which bound n·ω:
//!
//! - where K is 0 over the whole bound, the block is skipped;
//! - where K is linear over the whole bound, K = a + b t, the block's sum is a Σ L dω + b n·Σ L ω dω, and both
//!   sums are known beforehand;
//! - the rest is summed texel by texel, in eight lanes.
//!
//! That is the same sum, with fewer roundings. The clamped cosine is 0 or linear but for the blocks that
//! the horizon of n crosses, about one in ten, and a cone is constant but at its edge: this, and not the packed
//! arithmetic, makes irradiance a hundred times faster than a matrix product.
//!
//! **Normalization.** The sum of K dω over texels differs from its integral by the texels' size. On maps of the whole
//! sphere the result is therefore divided by the first and multiplied by the second, which makes it exact for a constant
//! image at any size. Where the coverage is a part of the sphere, what is not seen is black, and the
//! sum of the cosine is divided by nothing. Other lobes may be as narrow as a few texels, and have more of themselves on these than
//! they are: they are divided by the larger of both, so that no result is brighter than the image, and narrower ones ([`FEW`]) by the sum in any
//! case, as between texels they have less.
//!
//! **Order.** Each n has eight lanes of its own for each sheet and meets its blocks in their order; lanes are
//! added last, as a tree, and then the sheets. Neither threads, levels nor the other directions change a bit, and sheets may be
//! summed apart ([`under_sheet`]).
//!
//! Sources: clamped cosine, Lambert 1760 (E = ∫ L max(0, n·ω) dω); Phong 1975, normalized by Lewis 1994; Fisher
//! 1953; GGX, Walter et al. 2007; Charlie, Estevez & Kulla 2017. The last two are the lobes of n = v = r,
//! Karis 2013.
//!
//! What did not help: lanes over directions (blocks must then be dark for all of them at once), f32 (half
//! of the time, for seven digits).

use crate::error::{Error, expect_length, expect_multiple};
use crate::image::ImageView;
use crate::image::texel::Texel;
use crate::kernel;
use crate::kernel::SimdWork;
use crate::kernel::{interrupt, threads};
use crate::light::integrate::{Moments, add_sheets, block_moments};
use crate::light::patches::{LANES, Patches, Sheet, add_lanes};
use crate::light::texels::{Block, Texels, texels};
use crate::map::Map;
use crate::number::real::Real;
use crate::projections::projection::Coverage;
use crate::resample::lod::lod;
use fearless_simd::{Bytes, Select, Simd, SimdBase, f64x8, u64x8};
use std::f64::consts::{LN_2, PI};

/// A function of the cosine between the wanted direction and the light.
///
/// ```
/// use spheremap::light::Lobe;
/// assert_eq!(Lobe::Cosine.integral(), std::f64::consts::PI);
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub enum Lobe {
    /// max(0, t): the integral is irradiance.
    Cosine,
    /// 1 for t of at least this cosine.
    Cone(f64),
    /// max(0, t)^exponent.
    Phong(f64),
    /// exp(κ (t - 1)).
    VonMisesFisher(f64),
    /// GGX of this α seen along its normal, times the cosine: D(h) max(0, t).
    Ggx(f64),
    /// Charlie of this α, times the cosine.
    Charlie(f64),
}

/// What a lobe is over a range of cosines.
enum Over {
    Zero,
    /// a + b t.
    Linear(f64, f64),
    Other,
}

/// A lobe of fewer texels has not even about its integral on them; and a cone, whose edge cuts them.
const FEW: f64 = 8.0;
const FEW_CUT: f64 = 64.0;

/// exp(x) is below the smallest number from here on.
const VANISHES: f64 = -745.2;

impl Lobe {
    /// The lobe of this name.
    ///
    /// # Errors
    /// No lobe has it.
    ///
    /// ```
    /// use spheremap::light::Lobe;
    /// assert_eq!(Lobe::find("phong", 20.0)?, Lobe::Phong(20.0));
    /// # Ok::<(), spheremap::Error>(())
    /// ```
    pub fn find(name: &str, parameter: f64) -> Result<Lobe, Error> {
        const NAMES: [&str; 6] = ["cosine", "cone", "phong", "vmf", "ggx", "charlie"];
        Ok(match name {
            "cosine" => Lobe::Cosine,
            "cone" => Lobe::Cone(parameter),
            "phong" => Lobe::Phong(parameter),
            "vmf" => Lobe::VonMisesFisher(parameter),
            "ggx" => Lobe::Ggx(parameter),
            "charlie" => Lobe::Charlie(parameter),
            _ => return Err(Error::unknown("lobe", name, &NAMES)),
        })
    }

    /// An error where its parameter is negative or no number. A cosine may be negative.
    pub(crate) fn expect(self) -> Result<(), Error> {
        let (name, value, least) = match self {
            Lobe::Cosine => return Ok(()),
            Lobe::Cone(cos) => ("cosine", cos, f64::NEG_INFINITY),
            Lobe::Phong(exponent) => ("exponent", exponent, 0.0),
            Lobe::VonMisesFisher(kappa) => ("kappa", kappa, 0.0),
            Lobe::Ggx(alpha) | Lobe::Charlie(alpha) => ("alpha", alpha, 0.0),
        };
        if value >= least {
            return Ok(());
        }
        let and = if least == 0.0 {
            " and not negative"
        } else {
            ""
        };
        Err(Error::Contradiction(format!(
            "`{name}` of a lobe must be a number{and}, got {value}."
        )))
    }

    /// Its integral over the sphere, where that is part of the result: π for the cosine, whose result is
    /// irradiance, and 1 for the others, whose result is a mean.
    fn scale(self) -> f64 {
        match self {
            Lobe::Cosine => PI,
            _ => 1.0,
        }
    }

    /// The integral of the lobe over the sphere.
    ///
    /// ```
    /// use spheremap::light::Lobe;
    /// let half = Lobe::Cone(0.0).integral();
    /// assert_eq!(half, 2.0 * std::f64::consts::PI);
    /// ```
    pub fn integral(self) -> f64 {
        match self {
            Lobe::Cosine => PI,
            Lobe::Cone(cos) => 2.0 * PI * (1.0 - cos),
            Lobe::Phong(e) => 2.0 * PI / (e + 1.0),
            Lobe::VonMisesFisher(k) if k < 1e-8 => 4.0 * PI * (1.0 - k),
            Lobe::VonMisesFisher(k) => {
                // 1 - exp(-2k) without its cancellation; beyond, the exponential is rounding.
                let (sinh, cosh) = Real::sinh_cosh(k.min(20.0));
                4.0 * PI * sinh / ((sinh + cosh) * k)
            }
            Lobe::Ggx(alpha) => quadrature(|nodes| {
                let along = |s: &f64| {
                    let d = (1.0 - s.powi(4)) * (alpha * alpha - 1.0) + 1.0;
                    alpha * alpha / (PI * d * d)
                };
                nodes.iter().map(along).collect()
            }),
            Lobe::Charlie(alpha) => {
                (2.0 + 1.0 / alpha) / (2.0 * PI) * quadrature(|nodes| power(nodes, 2.0 / alpha))
            }
        }
    }

    /// How much of the sphere it would be if it were as high as on its axis everywhere; of the cosine, whose result is no mean, and of Charlie's,
    /// which is 0 there, it does not matter.
    fn extent(self) -> f64 {
        match self {
            Lobe::Cosine | Lobe::Charlie(_) => f64::INFINITY,
            Lobe::Cone(_) | Lobe::Phong(_) | Lobe::VonMisesFisher(_) => self.integral(),
            Lobe::Ggx(alpha) => self.integral() * PI * alpha * alpha,
        }
    }

    /// What it is for cosines from `low` to `high`.
    fn over(self, low: f64, high: f64) -> Over {
        // The bounds are rounded, and so are the cosines that they bound.
        let (low, high) = (low - 1e-14, high + 1e-14);
        match self {
            Lobe::Cosine if low >= 0.0 => Over::Linear(0.0, 1.0),
            Lobe::Cone(cos) if high < cos => Over::Zero,
            Lobe::Cone(cos) if low >= cos => Over::Linear(1.0, 0.0),
            Lobe::VonMisesFisher(k) if k * (high - 1.0) < VANISHES => Over::Zero,
            Lobe::Phong(e) if high > 0.0 && -e * LN_2 * lod(1.0 / high.min(1.0)) < VANISHES => {
                Over::Zero
            }
            Lobe::Cosine | Lobe::Phong(_) | Lobe::Ggx(_) | Lobe::Charlie(_) if high <= 0.0 => {
                Over::Zero
            }
            _ => Over::Other,
        }
    }
}

/// ∫ K(t) max(0, t) dω by the midpoint rule in s, t = 1 - 2s⁴, of which K is a function: the peak of a small α lies at s = 0.
fn quadrature(lobe: impl Fn(&[f64]) -> Vec<f64>) -> f64 {
    const N: usize = 1 << 14;
    let step = 0.5_f64.sqrt().sqrt() / N as f64;
    let nodes: Vec<f64> = (0..N).map(|i| (i as f64 + 0.5) * step).collect();
    let each = nodes.iter().zip(lobe(&nodes));
    let terms = each.map(|(s, k)| k * (1.0 - 2.0 * s.powi(4)) * 8.0 * s.powi(3));
    2.0 * PI * terms.sum::<f64>() * step
}

/// A lobe in lanes.
trait Shape: Copy {
    fn value<S: Simd>(self, simd: S, t: f64x8<S>) -> f64x8<S>;
}

macro_rules! shape {
    ($name:ident, |$self:ident, $simd:ident, $t:ident| $value:expr) => {
        impl Shape for $name {
            #[inline(always)]
            fn value<S: Simd>($self, $simd: S, $t: f64x8<S>) -> f64x8<S> {
                $value
            }
        }
    };
}

#[derive(Clone, Copy)]
struct Cosine;
shape!(Cosine, |self, simd, t| t.max(f64x8::splat(simd, 0.0)));

#[derive(Clone, Copy)]
struct Cone(f64);
shape!(Cone, |self, simd, t| t
    .simd_ge(f64x8::splat(simd, self.0))
    .select(f64x8::splat(simd, 1.0), f64x8::splat(simd, 0.0)));

#[derive(Clone, Copy)]
struct Phong(f64);
shape!(Phong, |self, simd, t| {
    let zero = f64x8::splat(simd, 0.0);
    let power = exp(simd, ln(simd, t) * f64x8::splat(simd, self.0));
    t.simd_gt(zero).select(power, zero)
});

#[derive(Clone, Copy)]
struct VonMisesFisher(f64);
shape!(VonMisesFisher, |self, simd, t| {
    exp(
        simd,
        (t - f64x8::splat(simd, 1.0)) * f64x8::splat(simd, self.0),
    )
});

#[derive(Clone, Copy)]
struct Ggx {
    /// (α² - 1)/2.
    slope: f64,
    /// α²/π.
    scale: f64,
}
shape!(Ggx, |self, simd, t| {
    let one = f64x8::splat(simd, 1.0);
    let d = (t + one) * f64x8::splat(simd, self.slope) + one;
    let up = t.max(f64x8::splat(simd, 0.0));
    up * f64x8::splat(simd, self.scale) / (d * d)
});

#[derive(Clone, Copy)]
struct Charlie {
    /// 1/(2α).
    exponent: f64,
    /// (2 + 1/α)/(2π).
    scale: f64,
}
shape!(Charlie, |self, simd, t| {
    let half = f64x8::splat(simd, 0.5);
    let power = exp(
        simd,
        ln(simd, half - t * half) * f64x8::splat(simd, self.exponent),
    );
    let up = t.max(f64x8::splat(simd, 0.0));
    power * up * f64x8::splat(simd, self.scale)
});

/// exp(x) for x ≤ 0, within 3e-16 of it for |x| < 1 and 1e-16 |x| beyond; 0 below [`VANISHES`].
#[inline(always)]
fn exp<S: Simd>(simd: S, x: f64x8<S>) -> f64x8<S> {
    const ROUND: f64 = 1.5 / f64::EPSILON;
    let number = |x| f64x8::splat(simd, x);
    let x = x.max(number(-708.0));
    let shifted = x * number(std::f64::consts::LOG2_E) + number(ROUND);
    let n = shifted - number(ROUND);
    // ln 2 in two parts, the first with zeros at its end: n times it is exact.
    let r = x - n * number(0.693_147_180_369_123_8) - n * number(1.908_214_929_270_587_7e-10);
    // The series of exp to r¹³; |r| ≤ ln 2/2 leaves 4e-18.
    let mut p = number(1.0 / 6_227_020_800.0);
    for c in [
        1.0 / 479_001_600.0,
        1.0 / 39_916_800.0,
        1.0 / 3_628_800.0,
        1.0 / 362_880.0,
        1.0 / 40_320.0,
        1.0 / 5_040.0,
        1.0 / 720.0,
        1.0 / 120.0,
        1.0 / 24.0,
        1.0 / 6.0,
        0.5,
        1.0,
        1.0,
    ] {
        p = p * r + number(c);
    }
    // 2ⁿ from its bits: the low bits of the magic sum hold n.
    let bits: u64x8<S> = shifted.bitcast();
    let power: f64x8<S> = ((bits + u64x8::splat(simd, 1023)) << 52).bitcast();
    let result = p * power;
    x.simd_gt(number(-708.0)).select(result, number(0.0))
}

/// ln(x), within 4e-16 of the larger of it and 1; a large negative number for x ≤ 0.
#[inline(always)]
fn ln<S: Simd>(simd: S, x: f64x8<S>) -> f64x8<S> {
    let number = |x| f64x8::splat(simd, x);
    let x = x.max(number(f64::MIN_POSITIVE));
    // x = 2ⁿ m with m in [√½, √2): the mantissa of √½ is taken off before the exponent is read.
    const HALF_ROOT: u64 = 0x3fe6_a09e_667f_3bcd;
    let bits: u64x8<S> = x.bitcast();
    let offset = bits - u64x8::splat(simd, HALF_ROOT - (1022 << 52));
    let exponent = offset >> 52;
    let m: f64x8<S> = (bits - (exponent << 52) + u64x8::splat(simd, 1022 << 52)).bitcast();
    const MAGIC: u64 = 0x4330_0000_0000_0000;
    let n: f64x8<S> = (exponent | u64x8::splat(simd, MAGIC)).bitcast();
    let n = n - number(4_503_599_627_370_496.0 + 1022.0);
    // ln m = 2 artanh s.
    let one = number(1.0);
    let s = (m - one) / (m + one);
    let q = s * s;
    let mut p = number(2.0 / 23.0);
    for c in [21.0, 19.0, 17.0, 15.0, 13.0, 11.0, 9.0, 7.0, 5.0, 3.0] {
        p = p * q + number(2.0 / c);
    }
    let tail = s * q * p + n * number(1.908_214_929_270_587_7e-10);
    n * number(0.693_147_180_369_123_8) + (s + s + tail)
}

/// The sums of one block over `N` rows of numbers, for some of the directions.
struct Sum<'a, L, const N: usize> {
    shape: L,
    points: [&'a [f64]; 3],
    rows: [&'a [f64]; N],
    normals: &'a [[f64; 3]],
    chosen: &'a [u32],
    sums: &'a mut [[f64; LANES]],
    stride: usize,
    first: usize,
}

impl<L: Shape, const N: usize> SimdWork for Sum<'_, L, N> {
    #[inline(always)]
    fn run<S: Simd>(self, simd: S) {
        let [x, y, z] = self.points.map(|p| p.as_chunks::<LANES>().0);
        let rows = self.rows.map(|r| r.as_chunks::<LANES>().0);
        let n = x.len();
        let (y, z) = (&y[..n], &z[..n]);
        let rows = rows.map(|r| &r[..n]);
        for &target in self.chosen {
            let target = target as usize;
            let [a, b, c] = self.normals[target].map(|k| f64x8::splat(simd, k));
            let place = target * self.stride + self.first;
            let Some(sums) = self.sums.get_mut(place..place + N) else {
                return;
            };
            let mut sum: [f64x8<S>; N] =
                std::array::from_fn(|k| f64x8::load_array_ref(simd, &sums[k]));
            for i in 0..n {
                let t = f64x8::load_array_ref(simd, &x[i]) * a
                    + f64x8::load_array_ref(simd, &y[i]) * b
                    + f64x8::load_array_ref(simd, &z[i]) * c;
                let value = self.shape.value(simd, t);
                for k in 0..N {
                    sum[k] += value * f64x8::load_array_ref(simd, &rows[k][i]);
                }
            }
            for k in 0..N {
                sum[k].store_array(&mut sums[k]);
            }
        }
    }
}

/// Directions that one thread takes through all blocks: enough to read each block seldom.
const TARGETS: usize = 256;

/// As many directions take about as long as finding the texels.
const FINDING: f64 = 3000.0;

/// The light of an image under a lobe about each direction: one number a channel. Directions are of unit length; one that is
/// none, and a lobe so narrow that it meets no texel, give NaN.
///
/// # Errors
/// The slices' lengths do not go together, the lobe's parameter is negative or NaN, or there is no memory for it.
///
/// ```
/// use spheremap::light::{Lobe, under};
/// use spheremap::{Map, image::ImageView};
/// let map = Map::new("latlong")?;
/// let white = vec![1.0_f32; 16 * 32];
/// let white = ImageView::new(&map, &[16, 32], 1, &white)?;
/// let mut irradiance = [0.0];
/// under(&white, Lobe::Cosine, &[0.0, 1.0, 0.0], &mut irradiance)?;
/// assert!((irradiance[0] - std::f64::consts::PI).abs() < 1e-12);
/// # Ok::<(), spheremap::Error>(())
/// ```
pub fn under<T: Texel>(
    image: &ImageView<'_, T>,
    lobe: Lobe,
    normals: &[f64],
    out: &mut [f64],
) -> Result<(), Error> {
    lobe.expect()?;
    expect_multiple("normals", normals.len(), 3)?;
    expect_length("out", out.len(), normals.len() / 3 * image.channels())?;
    if out.is_empty() {
        return Ok(());
    }
    // Finding texels takes as long as so many directions do.
    let start = FINDING / (FINDING + normals.len() as f64 / 3.0);
    let texels = interrupt::part(0.0, start, || texels(image.map(), image.shape()))?;
    let whole = image.map().coverage() == Coverage::Sphere;
    interrupt::part(start, 1.0, || {
        sums_under(&texels, image, lobe, whole, normals, out)
    })
}

/// The light of `image` under the lobe about each direction (three numbers of unit length each); NaN for a
/// direction that is none. `whole` says that the texels cover the sphere.
///
/// A lobe so narrow that it meets no texel gives NaN as well.
fn sums_under<T: Texel>(
    texels: &Texels,
    image: &ImageView<'_, T>,
    lobe: Lobe,
    whole: bool,
    normals: &[f64],
    out: &mut [f64],
) -> Result<(), Error> {
    let channels = image.channels();
    let rows = channels + 1;
    let ready = Ready::new(texels, image)?;
    let divisor = if whole {
        Divisor::Sum
    } else {
        let texel = image.map().coverage().solid_angle() / texels.x.len() as f64;
        Divisor::of_part(lobe, texel)
    };
    let mut covered = Vec::new();
    if !whole && divisor == Divisor::Sum {
        covered.resize(normals.len() / 3, false);
        image.map().covers(normals, &mut covered)?;
    }
    let normals = normals.as_chunks::<3>().0;
    // At least a few parts for the threads to share; each direction is by itself.
    let part = (normals.len() / 8).clamp(1, TARGETS);
    let work = texels.x.len() / 16 * normals.len();
    let sum = |number: usize, out: &mut [f64]| {
        let normals = &normals[number * part..][..out.len() / channels];
        let mut sheets = vec![0.0; texels.sheets.len() * normals.len() * rows];
        let each = texels.sheets.iter();
        for (blocks, sums) in each.zip(sheets.chunks_exact_mut(normals.len() * rows)) {
            ready.sums(blocks, lobe, normals, sums);
        }
        let sums = add_sheets(&sheets, normals.len() * rows);
        let covered = covered.get(number * part..).unwrap_or(&[]);
        let divisor = |direction: usize| match covered.get(direction) {
            // What is left of it within the image is no mean.
            Some(false) => Divisor::Larger(lobe.integral()),
            _ => divisor,
        };
        of_sums(lobe, divisor, &sums, channels, out);
    };
    interrupt::part(0.1, 1.0, || {
        threads::rows(out, part * channels, work, sum);
    });
    Ok(())
}

/// The sums of a sheet under a lobe about each direction, one for each channel and, last, one of the constant 1. The sums of all
/// sheets together ([`add_sheets`]) are what [`under`] makes light of, as [`of_all_sheets`] does.
///
/// # Errors
/// The slices' lengths do not go together, or there is no memory for it.
pub fn under_sheet<T: Texel>(
    image: &ImageView<'_, T>,
    patches: &Patches<'_>,
    sheet: &Sheet,
    lobe: Lobe,
    normals: &[f64],
    out: &mut [f64],
) -> Result<(), Error> {
    let rows = image.channels() + 1;
    expect_multiple("normals", normals.len(), 3)?;
    expect_length("out", out.len(), normals.len() / 3 * rows)?;
    let texels = Texels::of_sheet(patches, sheet)?;
    let ready = Ready::new(&texels, image)?;
    let normals = normals.as_chunks::<3>().0;
    let part = (normals.len() / 8).clamp(1, TARGETS);
    let work = texels.x.len() / 16 * normals.len();
    threads::rows(out, part * rows, work, |number, out| {
        let normals = &normals[number * part..][..out.len() / rows];
        for blocks in &texels.sheets {
            ready.sums(blocks, lobe, normals, out);
        }
    });
    interrupt::check()
}

/// The light under a lobe, from the sums of all sheets; on a map of a part of the sphere one that is wider than some texels.
///
/// # Errors
/// The slices' lengths do not go together.
pub fn of_all_sheets(
    map: &Map,
    lobe: Lobe,
    sums: &[f64],
    channels: usize,
    out: &mut [f64],
) -> Result<(), Error> {
    expect_multiple("sums", sums.len(), channels + 1)?;
    expect_length("out", out.len(), sums.len() / (channels + 1) * channels)?;
    let divisor = if map.coverage() == Coverage::Sphere {
        Divisor::Sum
    } else {
        Divisor::of_part(lobe, 0.0)
    };
    of_sums(lobe, |_| divisor, sums, channels, out);
    Ok(())
}

/// What a sum of light under a lobe is divided by.
#[derive(Clone, Copy, PartialEq)]
enum Divisor {
    /// The sum of the lobe.
    Sum,
    /// Its integral.
    Integral(f64),
    /// The larger of the two.
    Larger(f64),
}

impl Divisor {
    /// On a map of a part of the sphere, with texels of about this solid angle.
    fn of_part(lobe: Lobe, texel: f64) -> Divisor {
        let few = match lobe {
            Lobe::Cone(_) => FEW_CUT,
            _ => FEW,
        };
        if lobe == Lobe::Cosine {
            Divisor::Integral(lobe.integral())
        } else if lobe.extent() < few * texel {
            Divisor::Sum
        } else {
            Divisor::Larger(lobe.integral())
        }
    }

    fn with(self, sum: f64) -> f64 {
        match self {
            Divisor::Sum => sum,
            Divisor::Integral(integral) => integral,
            Divisor::Larger(integral) => integral.max(sum),
        }
    }
}

/// The light of each direction, from its sums.
fn of_sums(
    lobe: Lobe,
    divisor: impl Fn(usize) -> Divisor,
    sums: &[f64],
    channels: usize,
    out: &mut [f64],
) {
    let each = sums.chunks_exact(channels + 1);
    for (direction, (sums, out)) in each.zip(out.chunks_exact_mut(channels)).enumerate() {
        let divisor = divisor(direction).with(sums[channels]);
        for (sum, out) in sums.iter().zip(out) {
            *out = if divisor > 0.0 {
                lobe.scale() * sum / divisor
            } else {
                f64::NAN
            };
        }
    }
}

/// What is known of the blocks before any direction.
struct Ready<'a> {
    texels: &'a Texels,
    rows: usize,
    flux: Vec<f64>,
    moments: Vec<Moments>,
}

impl<'a> Ready<'a> {
    fn new<T: Texel>(texels: &'a Texels, image: &ImageView<'_, T>) -> Result<Self, Error> {
        let rows = image.channels() + 1;
        let flux = interrupt::part(0.0, 0.05, || texels.flux(image, true))?;
        let moments = interrupt::part(0.05, 0.1, || block_moments(texels, &flux, rows));
        Ok(Ready {
            texels,
            rows,
            flux,
            moments,
        })
    }

    /// The sums of some blocks for each direction: all channels, and the constant 1.
    fn sums(&self, blocks: &[usize], lobe: Lobe, normals: &[[f64; 3]], out: &mut [f64]) {
        let rows = self.rows;
        let mut sums = vec![[0.0; LANES]; normals.len() * rows];
        out.fill(0.0);
        let mut chosen = Vec::with_capacity(normals.len());
        for &number in blocks {
            let block = &self.texels.blocks[number];
            let moments = &self.moments[number * rows..][..rows];
            chosen.clear();
            let sin_radius = (1.0 - block.cos_radius * block.cos_radius).max(0.0).sqrt();
            for (target, n) in normals.iter().enumerate() {
                let (low, high) = block.cosines(sin_radius, n);
                match lobe.over(low, high) {
                    Over::Zero => {}
                    Over::Linear(a, b) => {
                        let sums = &mut out[target * rows..][..rows];
                        for (sum, m) in sums.iter_mut().zip(moments) {
                            *sum += a * m[0] + b * (n[0] * m[1] + n[1] * m[2] + n[2] * m[3]);
                        }
                    }
                    Over::Other => chosen.push(target as u32),
                }
            }
            if !chosen.is_empty() {
                let values = &self.flux[rows * block.start..][..rows * block.length];
                add_block(
                    self.texels,
                    block,
                    values,
                    rows,
                    lobe,
                    normals,
                    &chosen,
                    &mut sums,
                );
            }
        }
        // Lanes, and then what whole blocks gave.
        for (out, sums) in out.iter_mut().zip(&sums) {
            *out += add_lanes(sums);
        }
    }
}

#[expect(clippy::too_many_arguments, reason = "one inner step of `under`")]
fn add_block(
    texels: &Texels,
    block: &Block,
    values: &[f64],
    rows: usize,
    lobe: Lobe,
    normals: &[[f64; 3]],
    chosen: &[u32],
    sums: &mut [[f64; LANES]],
) {
    fn go<L: Shape, const N: usize>(shape: L, first: usize, all: &mut Whole<'_>) {
        let length = all.length;
        kernel::run_simd(Sum::<L, N> {
            shape,
            points: all.points,
            rows: std::array::from_fn(|k| &all.values[(first + k) * length..][..length]),
            normals: all.normals,
            chosen: all.chosen,
            sums: all.sums,
            stride: all.rows,
            first,
        });
    }
    fn groups<L: Shape>(shape: L, all: &mut Whole<'_>) {
        let mut first = 0;
        while first < all.rows {
            first += match all.rows - first {
                1 => {
                    go::<L, 1>(shape, first, all);
                    1
                }
                2 | 3 => {
                    go::<L, 2>(shape, first, all);
                    2
                }
                _ => {
                    go::<L, 4>(shape, first, all);
                    4
                }
            };
        }
    }
    struct Whole<'a> {
        points: [&'a [f64]; 3],
        values: &'a [f64],
        length: usize,
        rows: usize,
        normals: &'a [[f64; 3]],
        chosen: &'a [u32],
        sums: &'a mut [[f64; LANES]],
    }
    let span = block.start..block.start + block.length;
    let all = &mut Whole {
        points: [
            &texels.x[span.clone()],
            &texels.y[span.clone()],
            &texels.z[span],
        ],
        values,
        length: block.length,
        rows,
        normals,
        chosen,
        sums,
    };
    match lobe {
        Lobe::Cosine => groups(Cosine, all),
        Lobe::Cone(cos) => groups(Cone(cos), all),
        Lobe::Phong(e) => groups(Phong(e), all),
        Lobe::VonMisesFisher(k) => groups(VonMisesFisher(k), all),
        Lobe::Ggx(alpha) => {
            let (slope, scale) = (0.5 * (alpha * alpha - 1.0), alpha * alpha / PI);
            groups(Ggx { slope, scale }, all);
        }
        Lobe::Charlie(alpha) => {
            let (exponent, scale) = (0.5 / alpha, (2.0 + 1.0 / alpha) / (2.0 * PI));
            groups(Charlie { exponent, scale }, all);
        }
    }
}

impl Block {
    /// The smallest and the largest cosine between a unit vector and the block's points.
    fn cosines(&self, sin_radius: f64, n: &[f64; 3]) -> (f64, f64) {
        let cos = n[0] * self.axis[0] + n[1] * self.axis[1] + n[2] * self.axis[2];
        let cos = cos.clamp(-1.0, 1.0);
        let sin = (1.0 - cos * cos).sqrt();
        let (along, aside) = (cos * self.cos_radius, sin * sin_radius);
        // Within the cone, and within the cone about the opposite point, the extremes are the poles.
        let high = if cos >= self.cos_radius {
            1.0
        } else {
            along + aside
        };
        let low = if -cos >= self.cos_radius {
            -1.0
        } else {
            along - aside
        };
        (low, high)
    }
}

/// x^exponent of positive numbers, the same bits everywhere.
pub fn power(numbers: &[f64], exponent: f64) -> Vec<f64> {
    struct Power<'a>(&'a mut [[f64; LANES]], f64);
    impl SimdWork for Power<'_> {
        #[inline(always)]
        fn run<S: Simd>(self, simd: S) {
            for x in self.0 {
                let log = ln(simd, f64x8::load_array_ref(simd, x));
                exp(simd, log * f64x8::splat(simd, self.1)).store_array(x);
            }
        }
    }
    let mut lanes = vec![[1.0; LANES]; numbers.len().div_ceil(LANES)];
    lanes.as_flattened_mut()[..numbers.len()].copy_from_slice(numbers);
    kernel::run_simd(Power(&mut lanes, exponent));
    lanes.as_flattened()[..numbers.len()].to_vec()
}
