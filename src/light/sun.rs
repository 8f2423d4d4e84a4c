//! The sun of an image: found, taken out, put back.
//!
//! A sun is the brightest texel and what belongs to it, if that is small (10° about it) and far above the rest (10 times
//! its surround). From the peak outward everything counts up to the first gap in the texels above a tenth of it, and one
//! and a half texels more for its blurred edge. The surround is the median of a ring around that, channel by channel. The
//! sun's irradiance is what it adds to the surround, and its solid angle that of a disc of its peak's luminance with the
//! same light: for a disc of one brightness the disc's, for one in a single texel the texel's.
//!
//! What is darker than the surround, as the moat that a sharpening filter digs, takes nothing from the sun: it counts for
//! nothing and is left as it is. So no channel is negative, the direction lies within the sun's own reach, and taking a sun
//! out brightens no texel. Signed sums instead led directions astray by up to 19°, where a moat outweighs a peak of one texel.
//!
//! Put back, it is a disc with an edge as wide as a texel, scaled to the irradiance that it must have, or the nearest
//! texel where the disc is narrower.
//!
//! Angles are twice the angle of half a chord, which keeps its digits near 0; no angle comes from a math library. All
//! sums run in stored order, so nothing about the machine shows in a result. Singular: an image without light
//! above its dull part, whose brightest texel is NaN or infinite, or whose light around the peak sums to nothing (a bright texel among negative ones), has no sun.

use super::lit::{Cap, Counted, Lit};
use super::survey::Survey;
use crate::error::{Error, expect_length};
use crate::image::ImageView;
use crate::image::texel::Texel;
use crate::kernel::Scalar;
use crate::number::real::Real;
use std::f64::consts::PI;

/// How many times brighter than its surround a sun is at least.
const CONTRAST: f64 = 10.0;

/// How far from its peak a sun goes at most, in radians.
const LARGEST: f64 = PI / 18.0;

/// Where texels are no wider, nothing farther than twice [`LARGEST`] from the peak is asked for: a ring that begins at most one
/// and a half texels beyond [`LARGEST`] ends at most three texels, or half its radius, farther.
const FINE: f64 = 2.0 * LARGEST / 9.0;

/// Down to this part of its brightness a texel belongs to the sun for sure.
const CORE: f64 = 0.1;

/// A small bright source on a duller surround.
#[derive(Clone, Debug, PartialEq)]
pub struct Sun {
    /// Toward the middle of its light, in the world; a unit vector.
    pub direction: [f64; 3],
    /// Of the disc that gives its irradiance at its peak's luminance.
    pub solid_angle: f64,
    /// What it adds to its surround: ∫ max(L - surround, 0) dω of each channel.
    pub irradiance: Vec<f64>,
    /// The radiance around it.
    pub surround: Vec<f64>,
    /// From its brightest texel to the end of what counts as sun, in radians.
    pub reach: f64,
}

/// The sun of an image whose channels make luminance with these weights, if it has one.
///
/// # Errors
/// There are not as many weights as channels, or there is no memory for it.
///
/// ```
/// use spheremap::light::sun;
/// use spheremap::{Map, image::ImageView};
/// let map = Map::new("latlong")?;
/// let mut sky = vec![0.5; 32 * 64];
/// assert_eq!(sun::find(&ImageView::new(&map, &[32, 64], 1, &sky)?, &[1.0])?, None);
/// sky[5 * 64 + 9] = 2000.0;
/// let sun = sun::find(&ImageView::new(&map, &[32, 64], 1, &sky)?, &[1.0])?.expect("a sun");
/// assert!((sun.irradiance[0] / (1999.5 * sun.solid_angle) - 1.0).abs() < 1e-12);
/// # Ok::<(), spheremap::Error>(())
/// ```
pub fn find<T: Texel>(image: &ImageView<'_, T>, luminance: &[f64]) -> Result<Option<Sun>, Error> {
    let counted = Counted::new(image, luminance)?;
    Ok(of(&counted, &Survey::new(&counted)?)?.map(|(sun, ..)| sun))
}

/// Writes an image whose sun is painted over with its surround: it has lost the sun's irradiance.
///
/// # Errors
/// `out` is of another length than the image, there are not as many weights as channels, or there is no memory for it.
///
/// ```
/// use spheremap::light::sun;
/// use spheremap::{Map, image::ImageView};
/// let map = Map::new("latlong")?;
/// let mut sky = vec![0.5; 32 * 64];
/// sky[5 * 64 + 9] = 2000.0;
/// let mut dull = vec![0.0; 32 * 64];
/// let sun = sun::remove(&ImageView::new(&map, &[32, 64], 1, &sky)?, &[1.0], &mut dull)?;
/// assert!(sun.is_some() && dull.iter().all(|x| *x == 0.5));
/// # Ok::<(), spheremap::Error>(())
/// ```
pub fn remove<T: Texel>(
    image: &ImageView<'_, T>,
    luminance: &[f64],
    out: &mut [T],
) -> Result<Option<Sun>, Error> {
    expect_length("out", out.len(), image.texels().len())?;
    let counted = Counted::new(image, luminance)?;
    let found = of(&counted, &Survey::new(&counted)?)?;
    out.copy_from_slice(image.texels());
    let Some((sun, lit, region)) = found else {
        return Ok(None);
    };
    for k in region {
        let texel = &mut out[lit.index[k] * lit.channels..][..lit.channels];
        for (texel, surround) in texel.iter_mut().zip(&sun.surround) {
            if texel.load().to_f64() > *surround {
                *texel = T::from_f64(*surround);
            }
        }
    }
    Ok(Some(sun))
}

/// Writes an image with a sun added: a disc of its solid angle and irradiance.
///
/// # Errors
/// `out` is of another length than the image, the sun has other channels or is where the image covers nothing, or there is
/// no memory for it.
///
/// ```
/// use spheremap::light::{integrate, sun};
/// use spheremap::{Map, image::ImageView};
/// let (map, shape) = (Map::new("latlong")?, [32, 64]);
/// let disc = sun::Sun {
///     direction: [0.0, 0.6, -0.8],
///     solid_angle: 0.02,
///     irradiance: vec![5.0],
///     surround: vec![0.0],
///     reach: 0.0,
/// };
/// let mut sky = vec![0.0; 32 * 64];
/// sun::add(&ImageView::new(&map, &shape, 1, &vec![0.0; 32 * 64])?, &disc, &mut sky)?;
/// assert!((integrate(&ImageView::new(&map, &shape, 1, &sky)?)?[0] - 5.0).abs() < 1e-12);
/// # Ok::<(), spheremap::Error>(())
/// ```
pub fn add<T: Texel>(image: &ImageView<'_, T>, sun: &Sun, out: &mut [T]) -> Result<(), Error> {
    expect_length("out", out.len(), image.texels().len())?;
    if sun.irradiance.len() != image.channels() {
        return Err(Error::Shape(format!(
            "Expected a sun of {} channels, got {}.",
            image.channels(),
            sun.irradiance.len()
        )));
    }
    let mut covered = [false];
    let map = image.map();
    map.covers_numbers(None, &sun.direction, &mut covered);
    if covered != [true] {
        return Err(Error::Contradiction(format!(
            "The image does not cover the sun at {:?}.",
            sun.direction
        )));
    }
    // No luminance is needed, so any weights will do.
    let weights = vec![1.0; image.channels()];
    let counted = Counted::new(image, &weights)?;
    let radius = radius(sun.solid_angle);
    let solid_angles = counted.patches().face_weights().iter();
    let widest = solid_angles.fold(0.0, |most: f64, x| most.max(*x));
    let (lit, angles) = around_disc(&counted, sun.direction, radius + widest.sqrt())?;
    out.copy_from_slice(image.texels());
    let closest = least(&angles) * (1.0 + 1e-9);
    let is_nearest = |k: usize| angles[k] <= closest;
    // A texel's width is the width of the disc's blurred edge.
    let share = |k: usize| (0.5 + (radius - angles[k]) / lit.weight[k].sqrt()).clamp(0.0, 1.0);
    let mut shares: Vec<(usize, f64)> = (0..angles.len())
        .map(|k| (k, share(k)))
        .filter(|(_, share)| *share > 0.0)
        .collect();
    let texel = (0..angles.len()).filter(|k| is_nearest(*k));
    let largest = texel
        .clone()
        .fold(0.0, |most: f64, k| most.max(lit.weight[k]));
    if sun.solid_angle <= largest || shares.is_empty() {
        shares = texel.map(|k| (k, 1.0)).collect();
    }
    let total: f64 = shares.iter().map(|(k, share)| share * lit.weight[*k]).sum();
    for (k, share) in shares {
        let texel = &mut out[lit.index[k] * lit.channels..][..lit.channels];
        let gains = sun.irradiance.iter().map(|e| share * (e / total));
        for ((texel, light), gain) in texel.iter_mut().zip(lit.radiance(k)).zip(gains) {
            *texel = T::from_f64(light + gain);
        }
    }
    Ok(())
}

/// The texels that lie so near to a direction, or nearly, the nearest of all among them; and how far from it they are.
fn around_disc<T: Texel>(
    counted: &Counted<'_, T>,
    direction: [f64; 3],
    mut radius: f64,
) -> Result<(Lit, Vec<f64>), Error> {
    loop {
        // Where a texel is thin, the nearest center may be farther than its side would be if it were a square.
        let cap = (radius < PI).then(|| Cap::new(direction, radius));
        let lit = counted.listed(cap)?;
        let angles = angles(&lit, direction);
        if cap.is_none() || least(&angles) < 0.99 * radius {
            return Ok((lit, angles));
        }
        radius *= 4.0;
    }
}

/// The least of some numbers, ∞ of none.
fn least(numbers: &[f64]) -> f64 {
    numbers.iter().fold(f64::INFINITY, |least, x| least.min(*x))
}

/// The sun of an image, texels around it, and which of them it is in.
pub(super) fn of<T: Texel>(
    counted: &Counted<'_, T>,
    survey: &Survey,
) -> Result<Option<(Sun, Lit, Vec<usize>)>, Error> {
    let Some((_, peak)) = survey.peak else {
        return Ok(None);
    };
    let cap = around(survey.widest).map(|radius| Cap::new(counted.direction(peak), radius));
    let lit = counted.listed(cap)?;
    Ok(found(&lit).map(|(sun, region)| (sun, lit, region)))
}

/// How far from the brightest texel a sun is looked for, in radians, by the largest solid angle of a texel; none if everywhere.
pub(crate) fn around(widest: f64) -> Option<f64> {
    // A hundredth more, for rounding.
    (widest <= FINE * FINE).then_some(1.01 * 2.0 * LARGEST)
}

/// The sun among the texels around the brightest, in the order in which they are stored.
pub(crate) fn among(lit: &Lit) -> Option<Sun> {
    Some(found(lit)?.0)
}

/// The sun and the texels that it is in, among all that lie around the brightest.
fn found(lit: &Lit) -> Option<(Sun, Vec<usize>)> {
    let peak = lit.brightest()?;
    let angles = angles(lit, lit.direction[peak]);
    let within = |from: f64, to: f64| {
        let inside = (0..angles.len()).filter(|k| angles[*k] > from && angles[*k] <= to);
        inside.collect::<Vec<usize>>()
    };
    let luminances = |texels: &[usize]| texels.iter().map(|k| lit.luminance[*k]).collect();
    let near = within(-1.0, 2.0 * LARGEST);
    if near.is_empty() {
        // No center of a texel sees the sphere, as in the corners of the square around a disk.
        return None;
    }
    let widest = near
        .iter()
        .fold(0.0, |most: f64, k| most.max(lit.weight[*k]));
    let step = widest.sqrt();
    let (brightest, dull) = (lit.luminance[peak], median(luminances(&near)));
    if brightest <= dull {
        return None;
    }
    let bright = dull + CORE * (brightest - dull);
    let core = near.iter().filter(|k| lit.luminance[**k] > bright);
    let mut core: Vec<f64> = core.map(|k| angles[*k]).collect();
    core.sort_by(f64::total_cmp);
    // From the peak outward, as far as there is a bright texel in every step.
    let gap = core
        .windows(2)
        .position(|pair| pair[1] - pair[0] > 1.5 * step);
    // Nothing is above NaN, nor above the infinite.
    let last = *core.get(gap.unwrap_or(core.len().saturating_sub(1)))?;
    let reach = last + 1.5 * step;
    if last > LARGEST {
        return None;
    }
    let region = within(-1.0, reach);
    let ring = within(reach, (1.5 * reach).max(reach + 3.0 * step));
    let (mut surround, mut dull) = (vec![0.0; lit.channels], 0.0);
    if !ring.is_empty() {
        dull = median(luminances(&ring));
        for (channel, surround) in surround.iter_mut().enumerate() {
            *surround = median(ring.iter().map(|k| lit.radiance(*k)[channel]).collect());
        }
    }
    let highest = brightest - dull;
    if highest <= CONTRAST * dull.max(0.0) {
        return None;
    }
    let (mut signed, mut above, mut toward) = (0.0, 0.0, [0.0; 3]);
    let mut irradiance = vec![0.0; lit.channels];
    for &k in &region {
        let part = (lit.luminance[k] - dull) * lit.weight[k];
        signed += part;
        let part = part.max(0.0);
        above += part;
        for (sum, x) in toward.iter_mut().zip(lit.direction[k]) {
            *sum += part * x;
        }
        let light = lit.radiance(k).iter().zip(&surround);
        for (sum, (light, surround)) in irradiance.iter_mut().zip(light) {
            *sum += lit.weight[k] * (light - surround).max(0.0);
        }
    }
    // A bright texel among deep negative ones is noise.
    if signed <= 0.0 {
        return None;
    }
    let length = toward.iter().map(|x| x * x).sum::<f64>().sqrt();
    let sun = Sun {
        direction: toward.map(|x| x / length),
        solid_angle: above / highest,
        irradiance,
        surround,
        reach,
    };
    Some((sun, region))
}

/// Twice the angle whose sine this is, at most π.
fn twice_arcsine(sine: f64) -> f64 {
    let sine = sine.min(1.0);
    let cosine = ((1.0 - sine) * (1.0 + sine)).sqrt();
    2.0 * PI * f64::half_turns(sine, cosine)
}

/// The angular radius of a disc, without the cancellation of 1 - cos.
fn radius(solid_angle: f64) -> f64 {
    twice_arcsine((solid_angle / (4.0 * PI)).sqrt())
}

/// How far all texels are from a unit vector, in radians.
fn angles(lit: &Lit, axis: [f64; 3]) -> Vec<f64> {
    let angle = |d: &[f64; 3]| {
        let squares = [0, 1, 2].map(|c| (d[c] - axis[c]) * (d[c] - axis[c]));
        twice_arcsine(0.5 * (squares[0] + squares[1] + squares[2]).sqrt())
    };
    lit.direction.iter().map(angle).collect()
}

/// The median of at least one number: the mean of the middle two of an even number.
fn median(mut values: Vec<f64>) -> f64 {
    let half = values.len() / 2;
    let (_, middle, _) = values.select_nth_unstable_by(half, f64::total_cmp);
    let middle = *middle;
    if values.len() % 2 == 1 {
        return middle;
    }
    let below = values[..half]
        .iter()
        .fold(f64::NEG_INFINITY, |most, x| most.max(*x));
    0.5 * (below + middle)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::map::Map;
    use std::sync::LazyLock;

    const SHAPE: [usize; 2] = [64, 128];

    static LATLONG: LazyLock<Map> = LazyLock::new(|| Map::new("latlong").unwrap());

    fn view(image: &[f64]) -> ImageView<'_, f64> {
        ImageView::new(&LATLONG, &SHAPE, 1, image).unwrap()
    }

    fn solid_angles() -> Vec<f64> {
        let dark = vec![0.0; 64 * 128];
        Lit::new(&view(&dark), &[1.0]).unwrap().weight
    }

    #[test]
    fn a_sun_in_one_texel_is_taken_out_and_put_back() {
        let mut image = vec![0.5; 64 * 128];
        image[20 * 128 + 40] = 1000.0;
        let mut dull = image.clone();
        let sun = remove(&view(&image), &[1.0], &mut dull).unwrap().unwrap();
        assert!(dull.iter().all(|x| *x == 0.5));
        assert!((sun.solid_angle / solid_angles()[20 * 128 + 40] - 1.0).abs() < 1e-12);
        assert_eq!(find(&view(&dull), &[1.0]), Ok(None));
        let mut again = dull.clone();
        add(&view(&dull), &sun, &mut again).unwrap();
        let off = image.iter().zip(&again).map(|(a, b)| (a - b).abs());
        // A relative rounding or two of 1000.
        assert!(off.fold(0.0, f64::max) < 1e-11);
    }

    #[test]
    fn a_sun_of_any_size_keeps_its_irradiance() {
        let dark = vec![0.0; 64 * 128];
        let weight = solid_angles();
        for solid_angle in [1e-9, 1e-4, 0.3] {
            let sun = Sun {
                direction: [0.48, 0.6, 0.64],
                solid_angle,
                irradiance: vec![1.5],
                surround: vec![0.0],
                reach: 0.0,
            };
            let mut image = dark.clone();
            add(&view(&dark), &sun, &mut image).unwrap();
            let sum: f64 = image.iter().zip(&weight).map(|(l, w)| l * w).sum();
            assert!((sum - 1.5).abs() < 1e-12);
        }
    }

    #[test]
    fn the_nearest_texel_is_found_however_thin_texels_are() {
        // Rows of 45°, of which the sun is far from the middle: a side of a square as large would be 2°.
        let shape = [4, 4096];
        let dark = vec![0.0; 4 * 4096];
        let image = ImageView::new(&LATLONG, &shape, 1, &dark).unwrap();
        let (sin, cos) = 0.4_f64.sin_cos();
        let sun = Sun {
            direction: [0.0, -sin, -cos],
            solid_angle: 1e-9,
            irradiance: vec![1.5],
            surround: vec![0.0],
            reach: 0.0,
        };
        let mut lit = dark.clone();
        add(&image, &sun, &mut lit).unwrap();
        let all = Lit::new(&image, &[1.0]).unwrap();
        let sum: f64 = lit.iter().zip(&all.weight).map(|(l, w)| l * w).sum();
        assert!((sum - 1.5).abs() < 1e-12);
        let angles = angles(&all, sun.direction);
        let closest = least(&angles) * (1.0 + 1e-9);
        for (light, angle) in lit.iter().zip(angles) {
            assert_eq!(*light > 0.0, angle <= closest);
        }
    }

    #[test]
    fn a_moat_takes_nothing_from_a_sun() {
        // A peak of one texel at the corner of a moat that holds nearly as much.
        let mut image = vec![1.0; 64 * 128];
        for j in 28..35 {
            image[j * 128 + 36..j * 128 + 45].fill(0.79);
        }
        image[28 * 128 + 36] = 15.0;
        let mut dull = image.clone();
        let sun = remove(&view(&image), &[1.0], &mut dull).unwrap().unwrap();
        let sky = Lit::new(&view(&image), &[1.0]).unwrap();
        assert!(sun.irradiance[0] > 0.0);
        let peak = sky.direction[28 * 128 + 36];
        let cosine: f64 = (0..3).map(|k| sun.direction[k] * peak[k]).sum();
        assert!(cosine > 1.0 - 1e-12);
        assert!(dull.iter().zip(&image).all(|(dull, image)| dull <= image));
        let lost: f64 = image
            .iter()
            .zip(&dull)
            .zip(&sky.weight)
            .map(|((a, b), w)| (a - b) * w)
            .sum();
        // Sums of a dozen doubles.
        assert!((lost / sun.irradiance[0] - 1.0).abs() < 1e-12);
    }

    #[test]
    fn what_is_no_sun() {
        assert_eq!(find(&view(&vec![1.0; 64 * 128]), &[1.0]), Ok(None));
        // As wide as a hemisphere.
        let half: Vec<f64> = (0..64 * 128)
            .map(|k| if k < 32 * 128 { 100.0 } else { 0.1 })
            .collect();
        assert_eq!(find(&view(&half), &[1.0]), Ok(None));
    }

    #[test]
    fn a_sun_must_fit() {
        let sun = Sun {
            direction: [0.0, 0.0, -1.0],
            solid_angle: 1e-4,
            irradiance: vec![1.0],
            surround: vec![0.0],
            reach: 0.0,
        };
        let matcap = Map::new("matcap").unwrap();
        let dark = ImageView::new(&matcap, &[8, 8], 1, &[0.0; 64]).unwrap();
        let error = add(&dark, &sun, &mut [0.0; 64]).unwrap_err();
        assert!(error.to_string().contains("does not cover the sun"));
        let rgb = Sun {
            irradiance: vec![1.0; 3],
            ..sun
        };
        let error = add(&dark, &rgb, &mut [0.0; 64]).unwrap_err();
        assert!(error.to_string().contains("of 1 channels, got 3"));
    }

    #[test]
    fn medians_and_angles() {
        assert_eq!(median(vec![3.0, 1.0, 2.0]), 2.0);
        assert_eq!(median(vec![4.0, 1.0, 2.0, 3.0]), 2.5);
        assert!((twice_arcsine(0.5) - PI / 3.0).abs() < 1e-15);
        assert_eq!(twice_arcsine(1.5), PI);
    }

    #[test]
    fn what_is_no_number_is_no_sun() {
        let mut infinite = vec![0.5; 64 * 128];
        infinite[20 * 128 + 40] = f64::INFINITY;
        let mut half = vec![f64::NAN; 64 * 128];
        half[..32 * 128].fill(1.0);
        for image in [vec![f64::NAN; 64 * 128], infinite, half] {
            assert_eq!(find(&view(&image), &[1.0]), Ok(None));
            let mut out = vec![0.0; image.len()];
            assert_eq!(remove(&view(&image), &[1.0], &mut out), Ok(None));
            assert!(
                out.iter()
                    .zip(&image)
                    .all(|(a, b)| a.to_bits() == b.to_bits())
            );
        }
        assert_eq!(find(&view(&[1.0; 64 * 128]), &[f64::NAN]), Ok(None));
    }
}
