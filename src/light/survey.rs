//! What one pass over an image tells of its light: sums, and the brightest and darkest of its texels.
//!
//! Each row of a sheet ([`super::patches`]) is summed by itself, the rows of a sheet in their order, and sheets in theirs: nothing
//! shows how many threads there are, and sheets may be looked at apart.

use super::lit::{Counted, luminance_of};
use super::patches::{Patches, ROOM, Sheet};
use crate::error::Error;
use crate::image::ImageView;
use crate::image::texel::Texel;
use crate::kernel::{Scalar, interrupt, threads};
use std::ops::Range;

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
    /// Of no texels.
    fn none(channels: usize) -> Survey {
        Survey {
            solid_angle: 0.0,
            integral: vec![0.0; channels],
            luminance: 0.0,
            peak: None,
            darkest: f64::NAN,
            negative: 0,
            widest: 0.0,
        }
    }

    /// Of all texels of an image.
    pub fn new<T: Texel>(counted: &Counted<'_, T>) -> Result<Survey, Error> {
        let (image, patches) = (counted.image(), counted.patches());
        let none = Survey::none(image.channels());
        let sheets = patches.sheets();
        let Some(first) = sheets.first() else {
            return Ok(none);
        };
        let in_row: Vec<_> = sheets
            .iter()
            .take_while(|s| s.strips == first.strips)
            .collect();
        let mut strips = vec![none.clone(); patches.strips() * in_row.len()];
        let work = image.raster().texels() * image.channels();
        threads::rows(&mut strips, in_row.len(), work, |strip, surveys| {
            for (sheet, survey) in in_row.iter().zip(surveys) {
                let columns = &sheet.columns;
                *survey = Survey::of_strip(image, counted.weights(), patches, strip, columns);
            }
        });
        interrupt::check()?;
        let of = |(k, sheet): (usize, &Sheet)| {
            let column = k % in_row.len();
            let own = sheet
                .strips
                .clone()
                .map(|strip| &strips[strip * in_row.len() + column]);
            own.cloned().fold(none.clone(), Survey::and)
        };
        Ok(sheets
            .iter()
            .enumerate()
            .map(of)
            .fold(none.clone(), Survey::and))
    }

    /// Of the texels of a sheet.
    pub fn of_sheet<T: Texel>(
        image: &ImageView<'_, T>,
        luminance: &[f64],
        patches: &Patches<'_>,
        sheet: &Sheet,
    ) -> Survey {
        let none = Survey::none(image.channels());
        let mut strips = vec![none.clone(); sheet.strips.len()];
        let work = sheet.strips.len() * sheet.columns.len() * ROOM * image.channels();
        threads::rows(&mut strips, 1, work, |strip, surveys| {
            let strip = sheet.strips.start + strip;
            surveys[0] = Survey::of_strip(image, luminance, patches, strip, &sheet.columns);
        });
        strips.into_iter().fold(none, Survey::and)
    }

    /// Of all sheets of an image, from those of each.
    pub fn of_sheets(sheets: impl IntoIterator<Item = Survey>, channels: usize) -> Survey {
        sheets.into_iter().fold(Survey::none(channels), Survey::and)
    }

    /// Of some columns of a row of patches.
    fn of_strip<T: Texel>(
        image: &ImageView<'_, T>,
        luminance: &[f64],
        patches: &Patches<'_>,
        strip: usize,
        columns: &Range<usize>,
    ) -> Survey {
        let weights = patches.strip_weights(strip, columns);
        let view = patches.raster().view(patches.face(strip));
        let mut all = Survey::none(image.channels());
        for (j, row) in patches.rows(strip).zip(weights.rows()) {
            let mut survey = Survey::none(image.channels());
            for (i, &weight) in (weights.first()..).zip(row) {
                if weight > 0.0 {
                    let index = view.index(i, j);
                    survey.see(weight, index, image.texel(index), luminance);
                }
            }
            all = all.and(survey);
        }
        all
    }

    fn see<T: Texel>(&mut self, weight: f64, index: usize, texel: &[T], of_channels: &[f64]) {
        let luminance = luminance_of(texel, of_channels);
        self.solid_angle += weight;
        self.luminance += weight * luminance;
        let mut below = false;
        for (sum, x) in self.integral.iter_mut().zip(texel) {
            let x = x.load().to_f64();
            *sum += weight * x;
            below |= x < 0.0;
        }
        self.negative += usize::from(below);
        self.widest = self.widest.max(weight);
        if luminance > 0.0 {
            self.darkest = self.darkest.min(luminance);
        }
        self.brighter((luminance, index));
    }

    /// As numbers, of which [`Survey::of_numbers`] makes it again.
    pub fn numbers(&self) -> Vec<f64> {
        let (most, index) = self.peak.unwrap_or((f64::NAN, 0));
        let mut numbers = vec![
            self.solid_angle,
            self.luminance,
            f64::from(u8::from(self.peak.is_some())),
            most,
            // Below 2⁵³, as whole numbers are that floats hold.
            index as f64,
            self.darkest,
            self.negative as f64,
            self.widest,
        ];
        numbers.extend(&self.integral);
        numbers
    }

    /// From its numbers; none of too few.
    pub fn of_numbers(numbers: &[f64]) -> Option<Survey> {
        let (
            &[
                solid_angle,
                luminance,
                held,
                most,
                index,
                darkest,
                negative,
                widest,
            ],
            integral,
        ) = numbers.split_first_chunk::<8>()?;
        Some(Survey {
            solid_angle,
            integral: integral.to_vec(),
            luminance,
            peak: (held != 0.0).then_some((most, index as usize)),
            darkest,
            negative: negative as usize,
            widest,
        })
    }

    fn brighter(&mut self, (luminance, index): (f64, usize)) {
        let first =
            |(most, at): (f64, usize)| luminance > most || (luminance == most && index < at);
        if self.peak.is_none_or(first) {
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
