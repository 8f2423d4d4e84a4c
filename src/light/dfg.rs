//! The table of the split sum: what a rough surface reflects of a white environment.
//!
//! For cos θ = n·v along a row and roughness down the rows (α = roughness²), the two integrals
//!
//! E = ∫ D V (n·l) dω and B = ∫ D V (n·l) (1 - v·h)⁵ dω,
//!
//! so that a surface of Fresnel's F0 (Schlick 1994) reflects F0 (E - B) + B. Single scattering loses 1 - E of a white
//! metal; multiplying by 1 + F0 (1/E - 1) gives it back (Turquin 2019). V is the height-correlated Smith term for GGX
//! (Heitz 2014) and Neubelt and Pettineo's 1/(4(n·l + n·v - (n·l)(n·v))) for Charlie.
//!
//! Both are integrated over half vectors. For a given height of h, l is above the horizon for azimuths up to one that
//! is known in closed form, so that Gauss–Legendre points over just those see a smooth function. Heights follow the
//! distribution itself: cos²θ = (1 - ξ)/(1 + (α² - 1) ξ) for GGX, where D cos θ dω is uniform in ξ, and cos θ for Charlie,
//! in which D is near to a Gaussian of width √α. Entries are within 1e-4 of the integrals; the tests compare with sums over
//! visible normals.
//!
//! What did not help: evenly spaced visible normals (the horizon is a kink: 3e-4 with 8192 of them).

use super::prefilter::Distribution;
use crate::error::{Error, expect_length};
use crate::kernel::{interrupt, threads};
use crate::light::lobe;
use crate::number::real::Real;
use std::f64::consts::PI;

/// Points over the heights of h, and over the azimuths above the horizon.
const ALONG: usize = 192;
const AROUND: usize = 20;

/// Fills a square table: E and B of each entry, which lies at the center of its cell.
///
/// # Errors
/// `out` does not hold 2 size² numbers.
///
/// ```
/// use spheremap::light::{dfg, prefilter::Distribution};
/// let mut table = [0.0; 2 * 4 * 4];
/// dfg::fill(Distribution::Ggx, 4, &mut table)?;
/// assert!(table.iter().all(|x| (0.0..=1.0).contains(x)));
/// # Ok::<(), spheremap::Error>(())
/// ```
pub fn fill(distribution: Distribution, size: usize, out: &mut [f64]) -> Result<(), Error> {
    expect_length(
        "out",
        out.len(),
        size.saturating_mul(size).saturating_mul(2),
    )?;
    let along = gauss_legendre(ALONG);
    let around = gauss_legendre(AROUND);
    let at = |k: usize| (k as f64 + 0.5) / size as f64;
    let work = |row: usize, out: &mut [f64]| {
        let alpha = at(row) * at(row);
        let rough = rough_normals(alpha, &along);
        for (column, out) in out.chunks_exact_mut(2).enumerate() {
            let cos = at(column);
            let (e, b) = match distribution {
                Distribution::Ggx => {
                    let square = alpha * alpha;
                    let mask = |c: f64| (square + (1.0 - square) * c * c).sqrt();
                    let own = mask(cos);
                    let visible = |l: f64| 0.5 / (l * own + cos * mask(l));
                    integrals(&rough, cos, &around, visible)
                }
                Distribution::Charlie => {
                    let normals = cloth_normals(alpha, cos, &along);
                    let visible = |l: f64| 0.25 / (l + cos - l * cos);
                    integrals(&normals, cos, &around, visible)
                }
            };
            (out[0], out[1]) = (e, b);
        }
    };
    interrupt::part(0.0, 1.0, || {
        threads::rows(out, 2 * size, size * size * ALONG * AROUND, work);
    });
    Ok(())
}

/// (cos θ, D dω/dφ) of half vectors.
fn rough_normals(alpha: f64, along: &[(f64, f64)]) -> Vec<(f64, f64)> {
    // ξ = 1 - (1 - s)⁴: what is left beyond cos θ = ½, of the order of α², then has points of its own.
    let normal = |&(s, weight): &(f64, f64)| {
        let cubed = (1.0 - s) * (1.0 - s) * (1.0 - s);
        let left = cubed * (1.0 - s);
        let cos = (left / (left + alpha * alpha * (1.0 - left))).sqrt();
        (cos, weight * 4.0 * cubed / (2.0 * PI * cos))
    };
    along.iter().map(normal).collect()
}

/// The same, from the lowest h that reflects anything above the horizon.
fn cloth_normals(alpha: f64, cos: f64, along: &[(f64, f64)]) -> Vec<(f64, f64)> {
    // Beyond this, D is below 1e-17 of its largest.
    let reach = (80.0 * alpha).sqrt().min(1.0);
    // Half of the way from v to the horizon: cos²(45° + θ/2) = (1 - sin θ)/2.
    let sin = (1.0 - cos * cos).sqrt();
    let lowest = cos / (2.0 * (1.0 + sin)).sqrt();
    let span = (reach - lowest).max(0.0);
    // The range of azimuths opens like a root, which a square makes smooth.
    let cosines: Vec<f64> = along.iter().map(|(s, _)| lowest + span * s * s).collect();
    let sin2: Vec<f64> = cosines.iter().map(|c| 1.0 - c * c).collect();
    let scale = (2.0 + 1.0 / alpha) / (2.0 * PI) * span;
    let powers = lobe::power(&sin2, 0.5 / alpha);
    let both = cosines.into_iter().zip(powers).zip(along);
    both.map(|((c, p), (s, weight))| (c, weight * 2.0 * s * scale * p))
        .collect()
}

fn integrals(
    normals: &[(f64, f64)],
    cos: f64,
    around: &[(f64, f64)],
    visible: impl Fn(f64) -> f64,
) -> (f64, f64) {
    let sin = (1.0 - cos * cos).sqrt();
    let (mut e, mut b) = (0.0, 0.0);
    for &(hz, density) in normals {
        let h = (1.0 - hz * hz).max(0.0).sqrt();
        // n·l = 2 (v·h) (n·h) - n·v > 0 holds where the cosine of the azimuth is above this.
        let horizon = (0.5 * cos / hz - cos * hz) / (sin * h).max(f64::MIN_POSITIVE);
        if horizon >= 1.0 {
            continue;
        }
        let horizon = horizon.max(-1.0);
        let span = f64::half_turns((1.0 - horizon * horizon).sqrt(), horizon);
        let (mut row_e, mut row_b) = (0.0, 0.0);
        for &(place, weight) in around {
            let (_, cos_phi) = f64::sin_cos_half_turns(span * place);
            let vh = (sin * h * cos_phi + cos * hz).clamp(0.0, 1.0);
            let lz = (2.0 * vh * hz - cos).clamp(0.0, 1.0);
            let value = weight * visible(lz) * lz * 4.0 * vh;
            let grazing = 1.0 - vh;
            let square = grazing * grazing;
            row_e += value;
            row_b += value * square * square * grazing;
        }
        // Both halves of the circle.
        e += density * 2.0 * PI * span * row_e;
        b += density * 2.0 * PI * span * row_b;
    }
    (e, b)
}

/// Points and weights of Gauss and Legendre's rule on [0, 1].
fn gauss_legendre(n: usize) -> Vec<(f64, f64)> {
    let point = |k: usize| {
        let mut x = f64::sin_cos_half_turns((k as f64 + 0.75) / (n as f64 + 0.5)).1;
        let mut slope = 1.0;
        for _ in 0..8 {
            let (mut low, mut high) = (1.0, x);
            for l in 2..=n {
                let l = l as f64;
                (low, high) = (high, ((2.0 * l - 1.0) * x * high - (l - 1.0) * low) / l);
            }
            slope = n as f64 * (x * high - low) / (x * x - 1.0);
            x -= high / slope;
        }
        (0.5 - 0.5 * x, 1.0 / ((1.0 - x * x) * slope * slope))
    };
    (0..n).map(point).collect()
}
