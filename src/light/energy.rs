//! What light an image holds: its energy, its brightest and darkest texels, its sun.
//!
//! Every texel counts with the solid angle that it stands for ([`super::lit`]); what lies outside the valid image counts
//! for nothing. Negative numbers, which compression makes, are counted and kept. Sums are those of sheets ([`super::survey`]).
//! Singular: an image without light has no darkest texel, which is then NaN.

use super::lit::Counted;
use super::sun::{self, Sun};
use super::survey::Survey;
use crate::error::Error;
use crate::image::ImageView;
use crate::image::texel::Texel;
use crate::kernel::interrupt;

/// The light of an image.
#[derive(Clone, Debug, PartialEq)]
pub struct Energy {
    /// What the image covers.
    pub solid_angle: f64,
    /// ∫ L dω of each channel.
    pub integral: Vec<f64>,
    /// The mean luminance.
    pub luminance: f64,
    /// The largest luminance of a texel.
    pub peak: f64,
    /// Where that is, in the world.
    pub peak_direction: [f64; 3],
    /// The smallest luminance above 0; NaN if none is.
    pub darkest: f64,
    /// Texels with a number below 0.
    pub negative: usize,
    /// The sun, if there is one.
    pub sun: Option<Sun>,
}

/// The light of an image whose channels make luminance with these weights; none of one that holds no sphere.
///
/// # Errors
/// There are not as many weights as channels, or there is no memory for it.
///
/// ```
/// use spheremap::light::energy;
/// use spheremap::{Map, image::ImageView};
/// let map = Map::new("latlong")?;
/// let mut sky = vec![0.5; 32 * 64];
/// sky[5 * 64 + 9] = 2000.0;
/// let sky = ImageView::new(&map, &[32, 64], 1, &sky)?;
/// let light = energy(&sky, &[1.0])?.expect("a latlong holds the sphere");
/// assert_eq!((light.peak, light.darkest, light.negative), (2000.0, 0.5, 0));
/// assert!(light.sun.is_some());
/// # Ok::<(), spheremap::Error>(())
/// ```
pub fn energy<T: Texel>(
    image: &ImageView<'_, T>,
    luminance: &[f64],
) -> Result<Option<Energy>, Error> {
    let counted = Counted::new(image, luminance)?;
    let survey = interrupt::part(0.5, 0.8, || Survey::new(&counted))?;
    let Some((peak, place)) = survey.peak else {
        return Ok(None);
    };
    Ok(Some(Energy {
        sun: sun::of(&counted, &survey)?.map(|(sun, ..)| sun),
        solid_angle: survey.solid_angle,
        integral: survey.integral,
        luminance: survey.luminance / survey.solid_angle,
        peak,
        peak_direction: counted.direction(place),
        darkest: survey.darkest,
        negative: survey.negative,
    }))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::light::lit::Lit;
    use crate::map::Map;

    #[test]
    fn a_report() {
        let map = Map::new("latlong").unwrap();
        let mut image = vec![0.5; 32 * 64];
        (image[5 * 64 + 9], image[30 * 64], image[31 * 64]) = (2048.0, 0.125, -7.0);
        let of = |image: &[f64]| {
            let view = ImageView::new(&map, &[32, 64], 1, image).unwrap();
            (
                energy(&view, &[1.0]).unwrap().unwrap(),
                Lit::new(&view, &[1.0]).unwrap(),
            )
        };
        let (light, sky) = of(&image);
        assert_eq!(
            (light.peak, light.darkest, light.negative),
            (2048.0, 0.125, 1)
        );
        assert_eq!(light.peak_direction, sky.direction[5 * 64 + 9]);
        // A quotient and a product.
        assert!((light.luminance * light.solid_angle / light.integral[0] - 1.0).abs() < 1e-15);
        assert!(light.sun.is_some());
        assert!(of(&vec![0.0; 32 * 64]).0.darkest.is_nan());
    }
}
