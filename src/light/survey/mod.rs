//! What one pass over an image tells of its light: sums, and the brightest and darkest of its texels.
//!
//! Each row of a sheet ([`super::patches`]) is summed by itself, the rows of a sheet in their order, and sheets in theirs: nothing
//! shows how many threads there are, and sheets may be looked at apart.

mod row;

use super::lit::{Counted, luminance_of};
use super::patches::{Patches, ROOM, Sheet};
use crate::error::Error;
use crate::image::ImageView;
use crate::image::texel::Texel;
use crate::kernel::{interrupt, threads};
use row::Row;
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
    /// The largest luminance, NaN where none is a number, and the first stored texel that has it; none of an image that holds no sphere.
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
        let channels = image.channels();
        let straight = view.steps()[0] == 1;
        let mut turned = Vec::new();
        let mut all = Survey::none(channels);
        for (j, row) in patches.rows(strip).zip(weights.rows()) {
            let index = |k: usize| view.index(weights.first() + k, j);
            let texels = if straight {
                &image.texels()[index(0) * channels..][..row.len() * channels]
            } else {
                turned.clear();
                (0..row.len()).for_each(|k| turned.extend_from_slice(image.texel(index(k))));
                &turned
            };
            let Some(first) = row.iter().position(|solid_angle| *solid_angle > 0.0) else {
                continue;
            };
            let seen = Row::of(texels, row, luminance);
            let brightest = seen.brightest;
            all = all.and(Survey {
                solid_angle: seen.solid_angle,
                integral: seen.integral,
                luminance: seen.luminance,
                peak: None,
                darkest: seen.darkest,
                negative: seen.negative,
                widest: seen.widest,
            });
            if all
                .peak
                .is_none_or(|(most, _)| brightest >= most || most.is_nan())
            {
                let of = |k: usize| luminance_of(&texels[k * channels..][..channels], luminance);
                let places = (first..row.len()).filter(|&k| row[k] > 0.0 && of(k) == brightest);
                let place = places.map(index).min();
                // Of a row in which no luminance is a number, the first.
                all.brighter(match place {
                    Some(place) => (brightest, place),
                    None => (f64::NAN, index(first)),
                });
            }
        }
        all
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
        let first = |(most, at): (f64, usize)| {
            luminance > most
                || (luminance == most && index < at)
                || (most.is_nan() && !luminance.is_nan())
        };
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

#[cfg(test)]
mod tests {
    use super::*;
    use crate::image::raster::shape_of_size;
    use crate::map::Map;

    /// A survey is what a list of all texels tells.
    #[test]
    fn a_survey_is_that_of_its_texels() {
        for name in [
            "latlong",
            "angular",
            "cube",
            "cube_equiangular:ffmpeg-eac",
            "mollweide",
        ] {
            let map = Map::new(name).unwrap();
            for (size, channels) in [(1, 1), (13, 1), (37, 2), (70, 3), (33, 4)] {
                let shape = shape_of_size(&map, size);
                let count = shape.iter().product::<usize>() * channels;
                // Some below zero; the brightest come again and again.
                let numbers: Vec<f32> = (0..count).map(|k| (k * 37 % 101) as f32 - 4.0).collect();
                let image = ImageView::new(&map, &shape, channels, &numbers).unwrap();
                let weights = &[0.5, 0.0, 2.0, 1.0][..channels];
                let counted = Counted::new(&image, weights).unwrap();
                let survey = Survey::new(&counted).unwrap();
                let all = counted.listed(None).unwrap();
                let texels = || (all.luminance.iter().copied()).zip(all.light.chunks(channels));
                let most = all
                    .luminance
                    .iter()
                    .copied()
                    .fold(f64::NEG_INFINITY, f64::max);
                let first = all.luminance.iter().position(|x| *x == most);
                assert_eq!(
                    survey.peak,
                    first.map(|k| (most, all.index[k])),
                    "{name} {size}"
                );
                let above = all.luminance.iter().copied().filter(|x| *x > 0.0);
                assert_eq!(
                    survey.darkest.to_bits(),
                    above.fold(f64::NAN, f64::min).to_bits()
                );
                let negative = texels().filter(|(_, light)| light.iter().any(|x| *x < 0.0));
                assert_eq!(survey.negative, negative.count(), "{name} {size}");
                assert_eq!(
                    survey.widest,
                    all.weight.iter().copied().fold(0.0, f64::max)
                );
                let sum = |of: &dyn Fn(usize) -> f64| (0..all.weight.len()).map(of).sum::<f64>();
                // Some ten thousand sums of f64, of which few cancel.
                let near = |a: f64, b: f64| (a - b).abs() <= 1e-11 * (1.0 + b.abs());
                assert!(near(survey.solid_angle, sum(&|k| all.weight[k])));
                assert!(near(
                    survey.luminance,
                    sum(&|k| all.weight[k] * all.luminance[k])
                ));
                for (c, integral) in survey.integral.iter().enumerate() {
                    let light = |k: usize| all.weight[k] * all.light[k * channels + c];
                    assert!(near(*integral, sum(&light)), "{name} {size} {c}");
                }
            }
        }
    }

    #[test]
    fn what_is_no_number_is_the_brightest_of_nothing_else_alone() {
        let map = Map::new("latlong").unwrap();
        let mut numbers = vec![f64::NAN; 4 * 8];
        let peak = |numbers: &[f64]| {
            let image = ImageView::new(&map, &[4, 8], 1, numbers).unwrap();
            let survey = Survey::new(&Counted::new(&image, &[1.0]).unwrap()).unwrap();
            survey.peak.unwrap()
        };
        let (most, place) = peak(&numbers);
        assert!(most.is_nan() && place == 0);
        numbers[9] = f64::NEG_INFINITY;
        assert_eq!(peak(&numbers), (f64::NEG_INFINITY, 9));
        (numbers[25], numbers[30]) = (3.0, 3.0);
        assert_eq!(peak(&numbers), (3.0, 25));
    }
}
