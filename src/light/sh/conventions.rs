//! The orders, signs and scales in which other programs write coefficients: one row of [`CONVENTIONS`] each.
//!
//! This library's own are real, orthonormal, without the Condon–Shortley phase, about z, in row l² + l + m. A row says
//! in what a program differs:
//!
//! - **phase**: the basis has the sign (-1)^m (Condon & Shortley 1935);
//! - **normalization**: the basis is √4π ("4π-normalized", geodesy's) or √(4π/(2l + 1)) (Schmidt's, semi-normalized)
//!   times the orthonormal one, and coefficients are divided by that;
//! - **about y**: its x, y and z stand where others have y, z and x, which is a turn of the world, not a permutation
//!   of coefficients from degree 2 on;
//! - **storage**: rows, two squares of cosines and sines, or complex numbers of m ≥ 0, a_l,m = (-1)^m (c_l,m - i c_l,-m)/√2;
//! - **irradiance**: coefficients of degree 0 to 2 convolved with the clamped cosine, over π, and multiplied by the
//!   constants of the basis, so that a shader evaluates plain polynomials.
//!
//! Nothing is lost on the way to a convention and back, but by irradiance what is above degree 2.

use super::evaluate::{scale_degrees, transformed};
use super::lobes;
use crate::error::Error;
use std::f64::consts::PI;

/// What a program's basis is, as a multiple of the orthonormal one.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Normalization {
    /// The orthonormal one itself.
    Orthonormal,
    /// Times √4π: the mean of Y² over the sphere is 1.
    FourPi,
    /// Times √(4π/(2l + 1)): Schmidt's.
    Schmidt,
}

/// In what array a program holds its coefficients; channels come last.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Storage {
    /// Row l² + l + m.
    Rows,
    /// Two squares `[m < 0][l][|m|]`, cosines and sines.
    Squares,
    /// Complex numbers of m ≥ 0, all degrees of an m together; each is two numbers in a row.
    Complex,
}

/// How a program writes coefficients.
#[derive(Clone, Copy, Debug)]
pub struct Convention {
    /// Its name.
    pub name: &'static str,
    /// Whether the basis has the sign (-1)^m.
    pub phase: bool,
    /// The size of its basis.
    pub normalization: Normalization,
    /// Whether the axis is y.
    pub about_y: bool,
    /// The array.
    pub storage: Storage,
    /// Whether it holds irradiance, ready for a shader.
    pub irradiance: bool,
    /// What distinguishes it, for people.
    pub note: &'static str,
    /// Where that is written.
    pub source: &'static str,
}

const ROW: Convention = Convention {
    name: "",
    phase: false,
    normalization: Normalization::Orthonormal,
    about_y: false,
    storage: Storage::Rows,
    irradiance: false,
    note: "",
    source: "",
};

/// All conventions.
pub const CONVENTIONS: [Convention; 11] = [
    Convention {
        name: "orthonormal",
        note: "this library's own: real, orthonormal, no phase, index l² + l + m",
        source: "Ramamoorthi & Hanrahan 2001",
        ..ROW
    },
    Convention {
        name: "graphics",
        note: "the same: Y_1 = 0.488603 (y, z, x)",
        source: "Ramamoorthi & Hanrahan 2001",
        ..ROW
    },
    Convention {
        name: "condon-shortley",
        phase: true,
        note: "real, orthonormal, with (-1)^m: Y_1 = 0.488603 (-y, z, -x)",
        source: "Sloan 2008, D3DXSHEvalDirection",
        ..ROW
    },
    Convention {
        name: "3dgs",
        phase: true,
        note: "Condon-Shortley; a color is the sum + 0.5, which is no part of the coefficients",
        source: "Kerbl et al. 2023, sh_utils.eval_sh",
        ..ROW
    },
    Convention {
        name: "threejs",
        note: "SphericalHarmonics3: radiance, nine coefficients; getIrradianceAt convolves",
        source: "three.js math/SphericalHarmonics3.js",
        ..ROW
    },
    Convention {
        name: "e3nn",
        about_y: true,
        note: "normalization='integral': orthonormal about y, degree 1 in the order x, y, z",
        source: "e3nn o3.spherical_harmonics",
        ..ROW
    },
    Convention {
        name: "e3nn-component",
        about_y: true,
        normalization: Normalization::FourPi,
        note: "normalization='component': the basis times √4π",
        source: "e3nn o3.spherical_harmonics",
        ..ROW
    },
    Convention {
        name: "e3nn-norm",
        about_y: true,
        normalization: Normalization::Schmidt,
        note: "normalization='norm': the basis times √(4π/(2l + 1))",
        source: "e3nn o3.spherical_harmonics",
        ..ROW
    },
    Convention {
        name: "pyshtools",
        normalization: Normalization::FourPi,
        storage: Storage::Squares,
        note: "4π-normalized, no phase; an array (2, order + 1, order + 1): cosines, sines",
        source: "pyshtools SHCoeffs, normalization='4pi', csphase=1",
        ..ROW
    },
    Convention {
        name: "healpy",
        storage: Storage::Complex,
        note: "complex a_lm of m ≥ 0 with the phase, in the order of Alm.getidx",
        source: "healpy.map2alm",
        ..ROW
    },
    Convention {
        name: "filament-irradiance",
        irradiance: true,
        note: "order 2: convolved with the cosine, over π, times the basis' constants",
        source: "Filament libs/ibl CubemapSH, computeIrradianceSH3Bands",
        ..ROW
    },
];

/// The convention of this name.
///
/// # Errors
/// No convention has it.
///
/// ```
/// assert_eq!(spheremap::light::sh::conventions::find("3dgs")?.name, "3dgs");
/// # Ok::<(), spheremap::Error>(())
/// ```
pub fn find(name: &str) -> Result<&'static Convention, Error> {
    let found = CONVENTIONS.iter().find(|row| row.name == name);
    found.ok_or_else(|| Error::unknown("convention", name, &CONVENTIONS.map(|row| row.name)))
}

/// Rewrites the coefficients of one convention for another: the function stays the same.
///
/// `values` are as `src` stores them, `channels` numbers (complex ones with two each) an entry.
///
/// # Errors
/// There are not as many numbers as `src` has of some order, or `dst` needs a higher one.
///
/// ```
/// use spheremap::light::sh::conventions::{convert, find};
/// let there = convert(&[1.0, 2.0, 3.0, 4.0], 1, find("orthonormal")?, find("3dgs")?)?;
/// assert_eq!(there, [1.0, -2.0, 3.0, -4.0]);
/// # Ok::<(), spheremap::Error>(())
/// ```
pub fn convert(
    values: &[f64],
    channels: usize,
    src: &Convention,
    dst: &Convention,
) -> Result<Vec<f64>, Error> {
    dst.write(src.read(values, channels)?, channels)
}

impl Storage {
    /// The count of numbers that a channel has up to an order.
    ///
    /// ```
    /// assert_eq!(spheremap::light::sh::conventions::Storage::Rows.numbers(2), 9);
    /// ```
    pub fn numbers(self, order: usize) -> usize {
        let n = order.saturating_add(1);
        match self {
            Storage::Rows => n.saturating_mul(n),
            Storage::Squares => n.saturating_mul(n).saturating_mul(2),
            Storage::Complex => n.saturating_mul(n.saturating_add(1)),
        }
    }

    /// The order that has so many numbers a channel, if one does.
    ///
    /// ```
    /// assert_eq!(spheremap::light::sh::conventions::Storage::Rows.order(9), Some(2));
    /// ```
    pub fn order(self, numbers: usize) -> Option<usize> {
        let n = match self {
            Storage::Rows => numbers.isqrt(),
            Storage::Squares => (numbers / 2).isqrt(),
            Storage::Complex => (numbers.saturating_mul(4).saturating_add(1).isqrt() - 1) / 2,
        };
        (n > 0 && self.numbers(n - 1) == numbers).then(|| n - 1)
    }

    /// Where the number of degree l and order m is, and which factor it has there. `channel` is one of `channels`.
    fn place(
        self,
        [l, m]: [usize; 2],
        sine: bool,
        order: usize,
        (channel, channels): (usize, usize),
    ) -> (usize, f64) {
        let n = order + 1;
        match self {
            Storage::Rows => {
                let row = if sine { l * l + l - m } else { l * l + l + m };
                (row * channels + channel, 1.0)
            }
            Storage::Squares => {
                let entry = (usize::from(sine) * n + l) * n + m;
                (entry * channels + channel, 1.0)
            }
            Storage::Complex => {
                let entry = m * (2 * n - m - 1) / 2 + l;
                let sign = if (m % 2 == 1) == sine { 1.0 } else { -1.0 };
                let factor = if m == 0 { 1.0 } else { sign / 2.0_f64.sqrt() };
                (2 * (entry * channels + channel) + usize::from(sine), factor)
            }
        }
    }
}

impl Convention {
    /// This library's own coefficients of those that the program has.
    fn read(&self, values: &[f64], channels: usize) -> Result<Vec<f64>, Error> {
        let order = channels
            .checked_sub(1)
            .filter(|_| values.len().is_multiple_of(channels))
            .and_then(|_| self.storage.order(values.len() / channels))
            .ok_or_else(|| {
                Error::Shape(format!(
                    "'{}' has no {} numbers for {channels} channels.",
                    self.name,
                    values.len()
                ))
            })?;
        let mut own = vec![0.0; (order + 1) * (order + 1) * channels];
        for_each(order, channels, |degree, sine, channel| {
            let (from, factor) = self.storage.place(degree, sine, order, channel);
            let (to, _) = Storage::Rows.place(degree, sine, order, channel);
            own[to] = values[from] / factor / self.factor(degree);
        });
        if self.irradiance {
            if order != 2 {
                return Err(Error::Shape(format!(
                    "'{}' has 9 coefficients, got {}.",
                    self.name,
                    values.len() / channels
                )));
            }
            for (row, constant) in own.chunks_mut(channels).zip(shader_constants()) {
                row.iter_mut().for_each(|x| *x /= constant);
            }
            own = scale_degrees(&own, channels, &irradiance_factors()?.map(|a| 1.0 / a))?;
        }
        if self.about_y {
            // The transpose of `TO_Y`.
            own = transformed(
                &own,
                channels,
                order,
                &[0, 1, 2].map(|i| TO_Y.map(|row| row[i])),
            )?;
        }
        Ok(own)
    }

    /// The program's coefficients of this library's own.
    fn write(&self, mut own: Vec<f64>, channels: usize) -> Result<Vec<f64>, Error> {
        let mut order = (own.len() / channels).isqrt() - 1;
        if self.about_y {
            own = transformed(&own, channels, order, &TO_Y)?;
        }
        if self.irradiance {
            if order < 2 {
                return Err(Error::Shape(format!(
                    "'{}' needs order 2, got order {order}.",
                    self.name
                )));
            }
            order = 2;
            own.truncate(9 * channels);
            own = scale_degrees(&own, channels, &irradiance_factors()?)?;
            for (row, constant) in own.chunks_mut(channels).zip(shader_constants()) {
                row.iter_mut().for_each(|x| *x *= constant);
            }
        }
        let mut values = vec![0.0; self.storage.numbers(order) * channels];
        for_each(order, channels, |degree, sine, channel| {
            let (from, _) = Storage::Rows.place(degree, sine, order, channel);
            let (to, factor) = self.storage.place(degree, sine, order, channel);
            values[to] = own[from] * self.factor(degree) * factor;
        });
        Ok(values)
    }

    /// What a coefficient of degree l and order m is multiplied by.
    fn factor(&self, [l, m]: [usize; 2]) -> f64 {
        let scale = match self.normalization {
            Normalization::Orthonormal => 1.0,
            Normalization::FourPi => 1.0 / (4.0 * PI).sqrt(),
            Normalization::Schmidt => 1.0 / (4.0 * PI).sqrt() * ((2 * l + 1) as f64).sqrt(),
        };
        if self.phase && m % 2 == 1 {
            -scale
        } else {
            scale
        }
    }
}

/// Its x, y and z stand where this library has y, z and x: rows are its axes' (x, y, z).
const TO_Y: [[f64; 3]; 3] = [[0.0, 0.0, 1.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]];

/// The constants of the basis of order 2 over the polynomials 1, y, z, x, yx, yz, 3z² - 1, zx, x² - y².
fn shader_constants() -> [f64; 9] {
    let first = (3.0 / (4.0 * PI)).sqrt();
    let second = (15.0 / (4.0 * PI)).sqrt();
    [
        (1.0 / (4.0 * PI)).sqrt(),
        first,
        first,
        first,
        second,
        second,
        (5.0 / (16.0 * PI)).sqrt(),
        second,
        (15.0 / (16.0 * PI)).sqrt(),
    ]
}

/// The clamped cosine's factors over π, of degrees 0 to 2.
fn irradiance_factors() -> Result<[f64; 3], Error> {
    let factors = lobes::find("cosine")?.factors(0.0, 2)?;
    Ok([0, 1, 2].map(|l| factors[l] / PI))
}

/// Calls `work` with degree and order, whether it is the sine of the order (m < 0), and the channel of how many.
fn for_each(order: usize, channels: usize, mut work: impl FnMut([usize; 2], bool, (usize, usize))) {
    for l in 0..=order {
        for m in 0..=l {
            for sine in [false, true] {
                if sine && m == 0 {
                    continue;
                }
                for channel in 0..channels {
                    work([l, m], sine, (channel, channels));
                }
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::light::sh::evaluate::evaluate;

    fn numbers(n: usize) -> Vec<f64> {
        (0..n)
            .map(|k| ((k * 37 + 11) % 101) as f64 / 50.0 - 1.0)
            .collect()
    }

    #[test]
    fn every_convention_comes_back() {
        for row in &CONVENTIONS {
            for channels in [1, 3] {
                let order = if row.irradiance { 2 } else { 6 };
                let own = numbers((order + 1) * (order + 1) * channels);
                let there = row.write(own.clone(), channels).unwrap();
                assert_eq!(there.len(), row.storage.numbers(order) * channels);
                assert_eq!(row.storage.order(there.len() / channels), Some(order));
                let back = row.read(&there, channels).unwrap();
                // A turn of degree 6 rounds sums of 13² terms up to 1.
                let off = back.iter().zip(&own).map(|(a, b)| (a - b).abs());
                assert!(off.fold(0.0, f64::max) < 1e-13, "{}", row.name);
            }
        }
    }

    #[test]
    fn about_y_the_first_degree_is_x_y_z() {
        let row = find("e3nn").unwrap();
        let there = convert(&[1.0, 2.0, 3.0, 4.0], 1, &CONVENTIONS[0], row).unwrap();
        for (got, want) in there.iter().zip([1.0, 4.0, 2.0, 3.0]) {
            assert!((got - want).abs() < 1e-14);
        }
    }

    #[test]
    fn a_shader_evaluates_irradiance_by_plain_polynomials() {
        let own = numbers(16);
        let there = convert(
            &own,
            1,
            &CONVENTIONS[0],
            find("filament-irradiance").unwrap(),
        )
        .unwrap();
        let [x, y, z] = [0.48, -0.6, 0.64];
        let polynomials = [
            1.0,
            y,
            z,
            x,
            y * x,
            y * z,
            3.0 * z * z - 1.0,
            z * x,
            x * x - y * y,
        ];
        let got: f64 = there.iter().zip(polynomials).map(|(c, p)| c * p).sum();
        let cosine = lobes::find("cosine").unwrap().factors(0.0, 2).unwrap();
        let mut want = [0.0];
        evaluate(
            &scale_degrees(&own[..9], 1, &cosine).unwrap(),
            1,
            &[x, y, z],
            &mut want,
        )
        .unwrap();
        assert!((got - want[0] / PI).abs() < 1e-14);
    }

    #[test]
    fn numbers_of_no_order_are_errors() {
        let own = find("orthonormal").unwrap();
        for (name, numbers) in [("orthonormal", 5), ("pyshtools", 9), ("healpy", 4)] {
            let row = find(name).unwrap();
            assert!(convert(&vec![1.0; numbers], 1, row, own).is_err(), "{name}");
            assert!(convert(&[], 1, row, own).is_err() && convert(&[1.0], 0, row, own).is_err());
        }
        let irradiance = find("filament-irradiance").unwrap();
        assert!(convert(&[1.0; 16], 1, irradiance, own).is_err());
        assert!(convert(&[1.0; 4], 1, own, irradiance).is_err());
        assert!(find("blender").is_err());
    }
}
