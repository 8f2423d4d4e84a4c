//! Coefficients of images whose sheets are summed apart: by whom, and in what order, shows in no bit.
//!
//! A sheet ([`crate::light::patches`]) gives numbers that depend on it alone: of rings their Fourier sums over its columns, and
//! elsewhere plain sums with the basis and, for the fit, the sums of the basis itself. [`Apart::project`] makes of all of them
//! what [`super::project`] makes of the image.

use super::evaluate::transformed;
use super::fit::{self, Normal, order_of_fit};
use super::rings::Rings;
use super::{HIGHEST, Samples, count, too_high};
use crate::error::{Error, expect_length};
use crate::image::ImageView;
use crate::image::texel::Texel;
use crate::light::integrate::add_sheets;
use crate::light::patches::{LANES, Patches, SHEET, SIDE, Sheet};
use crate::light::texels::Texels;
use crate::map::Map;
use crate::projections::projection::Coverage;

/// Images of fewer texels are too small for this: the order of a fit depends on how many of them hold a value.
pub const LEAST_TEXELS: usize = (SIDE * SHEET) * (SIDE * SHEET);

/// The coefficients of an image of this map and shape up to an order, by sheets.
pub struct Apart<'a> {
    patches: Patches<'a>,
    shape: &'a [usize],
    rings: Option<Rings>,
    /// Whether the coverage is the sphere, and coefficients are those of a fit.
    fitted: bool,
    order: usize,
    samples: Samples,
}

impl<'a> Apart<'a> {
    /// Those of an image that is large enough.
    ///
    /// # Errors
    /// The image cannot hold the order.
    pub fn new(
        map: &'a Map,
        shape: &'a [usize],
        order: usize,
        samples: Samples,
    ) -> Result<Self, Error> {
        let patches = Patches::of_parts(map, shape)?;
        let fitted = map.coverage() == Coverage::Sphere;
        let rings = if fitted { Rings::of(map, shape)? } else { None };
        let highest = rings.as_ref().map_or(HIGHEST, Rings::highest);
        if order > HIGHEST.min(highest) || patches.raster().texels() < LEAST_TEXELS {
            return Err(too_high(shape, order, HIGHEST.min(highest)));
        }
        Ok(Apart {
            patches,
            shape,
            rings,
            fitted,
            order,
            samples,
        })
    }

    /// The patches of the image.
    pub fn patches(&self) -> &Patches<'a> {
        &self.patches
    }

    /// The order up to which sums are needed.
    fn high(&self) -> usize {
        match (&self.rings, self.samples) {
            (Some(_), Samples::Points) => self.order,
            (Some(rings), Samples::Means) => (self.order + 2).min(rings.highest()),
            (None, _) if self.fitted => order_of_fit(self.order, LEAST_TEXELS),
            (None, _) => self.order,
        }
    }

    /// What a sheet gives.
    ///
    /// # Errors
    /// There is no memory for it.
    pub fn of_sheet<T: Texel>(
        &self,
        image: &ImageView<'_, T>,
        sheet: &Sheet,
    ) -> Result<Vec<f64>, Error> {
        let high = self.high();
        if let Some(rings) = &self.rings {
            let [rows, columns] = self.patches.stored(sheet);
            return Ok(rings.fourier_of(image, high, rows, columns));
        }
        let texels = Texels::of_sheet(&self.patches, sheet)?;
        let flux = texels.flux(image, false)?;
        let mut found = fit::sums(&texels, &flux, image.channels(), high);
        if self.fitted {
            found.extend(fit::sums(&texels, &texels.weight, 1, 2 * high));
        }
        Ok(found)
    }

    /// The coefficients, from what all sheets give in their order.
    ///
    /// # Errors
    /// The numbers are not as many as they have to be, or the texels do not determine the coefficients.
    pub fn project(&self, parts: &[f64], channels: usize) -> Result<Vec<f64>, Error> {
        let (high, wanted) = (self.high(), count(self.order) * channels);
        let of_means = self.samples == Samples::Means;
        if let Some(rings) = &self.rings {
            let fourier = self.fourier(parts, (high + 1) * 2 * channels)?;
            let own = if of_means {
                let right = rings.sum(&fourier, channels, high, &rings.solid_angles());
                let normal = Normal::moments_of_rings(rings, self.order);
                self.kept(&normal, &right, channels, rings.highest() / 2)?
            } else {
                rings.sum(&fourier, channels, high, &rings.exact())
            };
            return transformed(&own, channels, self.order, &rings.frame);
        }
        let moments = if self.fitted { count(2 * high) } else { 0 };
        let per = count(high) * channels + moments;
        expect_length("parts", parts.len(), self.patches.sheets().len() * per)?;
        let mut right = add_sheets(parts, per);
        if !self.fitted {
            return Ok(right);
        }
        let normal = Normal::of_moments(high, right.split_off(per - moments));
        if of_means {
            return self.kept(&normal, &right, channels, HIGHEST);
        }
        let mut found = normal
            .fitted(&right, channels)
            .ok_or_else(|| too_high(self.shape, self.order, HIGHEST))?;
        found.truncate(wanted);
        Ok(found)
    }

    /// The fit, but for order 0, as [`super::kept`].
    fn kept(
        &self,
        normal: &Normal,
        right: &[f64],
        channels: usize,
        highest: usize,
    ) -> Result<Vec<f64>, Error> {
        let mut found = normal
            .fitted(right, channels)
            .ok_or_else(|| too_high(self.shape, self.order, highest))?;
        found.truncate(count(self.order) * channels);
        found[..channels].copy_from_slice(&right[..channels]);
        Ok(found)
    }

    /// The Fourier sums of each ring, from those of the sheets along it.
    fn fourier(&self, parts: &[f64], per: usize) -> Result<Vec<f64>, Error> {
        let sheets = self.patches.sheets();
        let spans: Vec<_> = sheets.iter().map(|s| self.patches.stored(s)).collect();
        let length: usize = spans.iter().map(|[rows, _]| rows.len() * per).sum();
        expect_length("parts", parts.len(), length)?;
        let mut fourier = vec![0.0; self.patches.raster().height * per];
        let mut rest = parts;
        for [rows, _] in spans {
            let (own, after) = rest.split_at(rows.len() * per);
            let sums = &mut fourier[rows.start * per..rows.end * per];
            sums.iter_mut().zip(own).for_each(|(sum, x)| *sum += x);
            rest = after;
        }
        Ok(fourier)
    }
}

// Sheets begin at whole lanes.
const _: () = assert!((SIDE * SHEET).is_multiple_of(LANES));
