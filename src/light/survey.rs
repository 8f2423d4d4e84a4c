//! What one pass over an image tells of its light: sums, and the brightest and darkest of its texels.
//!
//! Each stored row is summed by itself, and rows in their order, so that nothing shows how many threads there are.

use super::lit::Counted;
use crate::error::Error;
use crate::image::texel::Texel;
use crate::kernel::{Scalar, interrupt, threads};

/// Sums and extremes of the texels that hold sphere.
#[derive(Clone, Debug, PartialEq)]
pub struct Survey {
    /// What they cover.
    pub solid_angle: f64,
    /// ∫ L dω of each channel.
    pub integral: Vec<f64>,
    /// ∫ of the luminance.
    pub luminance: f64,
    /// The largest luminance, and the first stored texel that has it; none of an image that holds no sphere.
    pub peak: Option<(f64, usize)>,
    /// The smallest luminance above 0; NaN if none is.
    pub darkest: f64,
    /// Texels with a number below 0.
    pub negative: usize,
    /// The largest solid angle of a texel.
    pub widest: f64,
}

impl Survey {
    /// Of all texels of an image.
    pub fn new<T: Texel>(counted: &Counted<'_, T>) -> Result<Survey, Error> {
        let image = counted.image();
        let columns = image.raster().columns;
        let none = Survey {
            solid_angle: 0.0,
            integral: vec![0.0; image.channels()],
            luminance: 0.0,
            peak: None,
            darkest: f64::NAN,
            negative: 0,
            widest: 0.0,
        };
        let mut rows = vec![none.clone(); counted.stored_rows()];
        let texels = image.raster().texels();
        threads::rows(&mut rows, 1, texels * image.channels(), |row, survey| {
            let survey = &mut survey[0];
            counted.row(row, |column, weight, texel| {
                let luminance = counted.luminance(texel);
                survey.solid_angle += weight;
                survey.luminance += weight * luminance;
                let mut below = false;
                for (sum, x) in survey.integral.iter_mut().zip(texel) {
                    let x = x.load().to_f64();
                    *sum += weight * x;
                    below |= x < 0.0;
                }
                survey.negative += usize::from(below);
                survey.widest = survey.widest.max(weight);
                if luminance > 0.0 {
                    survey.darkest = survey.darkest.min(luminance);
                }
                survey.brighter((luminance, row * columns + column));
            });
        });
        interrupt::check()?;
        Ok(rows.into_iter().fold(none, Survey::and))
    }

    fn brighter(&mut self, (luminance, index): (f64, usize)) {
        if self.peak.is_none_or(|(most, _)| luminance > most) {
            self.peak = Some((luminance, index));
        }
    }

    /// This and what comes after it.
    fn and(mut self, next: Survey) -> Survey {
        self.solid_angle += next.solid_angle;
        self.luminance += next.luminance;
        for (sum, x) in self.integral.iter_mut().zip(next.integral) {
            *sum += x;
        }
        self.negative += next.negative;
        self.widest = self.widest.max(next.widest);
        self.darkest = self.darkest.min(next.darkest);
        if let Some(peak) = next.peak {
            self.brighter(peak);
        }
        self
    }
}
