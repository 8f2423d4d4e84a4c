//! The texels of a row, seen in lanes.
//!
//! Texel k counts in lane k mod 8, and the lanes of a sum are joined as a tree. Where a solid angle is zero there is no texel, whatever
//! is stored.
//!
//! Texel by texel took four tenths of the time that the energy of a panorama did.

use crate::image::texel::Texel;
use crate::kernel::{Scalar, vectorize};
use crate::light::patches::{LANES, add_lanes};

type Lanes = [f64; LANES];

/// Sums and extremes, a number in each lane.
struct Seen {
    solid_angle: Lanes,
    luminance: Lanes,
    negative: Lanes,
    widest: Lanes,
    brightest: Lanes,
    darkest: Lanes,
    integral: Vec<Lanes>,
}

/// Sums and extremes of a row.
pub(super) struct Row {
    pub(super) solid_angle: f64,
    pub(super) integral: Vec<f64>,
    pub(super) luminance: f64,
    /// The largest luminance that is a number, -∞ if none is.
    pub(super) brightest: f64,
    /// The smallest luminance above 0; NaN if none is.
    pub(super) darkest: f64,
    pub(super) negative: usize,
    pub(super) widest: f64,
}

impl Row {
    /// Of these texels, which see these solid angles; `luminance` has what each channel counts with.
    pub(super) fn of<T: Texel>(texels: &[T], solid_angles: &[f64], luminance: &[f64]) -> Row {
        let seen = vectorize(
            #[inline(always)]
            || match luminance.len() {
                1 => Seen::of::<T, 1>(texels, solid_angles, luminance),
                3 => Seen::of::<T, 3>(texels, solid_angles, luminance),
                4 => Seen::of::<T, 4>(texels, solid_angles, luminance),
                _ => Seen::of::<T, 0>(texels, solid_angles, luminance),
            },
        );
        let most = |lanes: Lanes| lanes.into_iter().fold(f64::NEG_INFINITY, f64::max);
        let brightest = most(seen.brightest);
        let darkest = -most(seen.darkest.map(|x| -x));
        Row {
            solid_angle: add_lanes(&seen.solid_angle),
            integral: seen.integral.iter().map(add_lanes).collect(),
            luminance: add_lanes(&seen.luminance),
            brightest,
            darkest: if brightest > 0.0 { darkest } else { f64::NAN },
            negative: add_lanes(&seen.negative) as usize,
            widest: most(seen.widest),
        }
    }
}

impl Seen {
    /// CHANNELS is 0 where their number is known at run time only.
    #[inline(always)]
    fn of<T: Texel, const CHANNELS: usize>(
        texels: &[T],
        solid_angles: &[f64],
        luminance: &[f64],
    ) -> Seen {
        let channels = if CHANNELS > 0 {
            CHANNELS
        } else {
            luminance.len()
        };
        let mut seen = Seen {
            solid_angle: [0.0; LANES],
            luminance: [0.0; LANES],
            negative: [0.0; LANES],
            widest: [0.0; LANES],
            brightest: [f64::NEG_INFINITY; LANES],
            darkest: [f64::INFINITY; LANES],
            integral: vec![[0.0; LANES]; channels],
        };
        let (eights, rest) = solid_angles.as_chunks::<LANES>();
        let mut of_eights = texels.chunks_exact(LANES * channels);
        for (own, texels) in eights.iter().zip(&mut of_eights) {
            seen.see::<T, CHANNELS>(texels, own, luminance);
        }
        if !rest.is_empty() {
            let mut own = [0.0; LANES];
            own[..rest.len()].copy_from_slice(rest);
            let mut last = vec![T::default(); LANES * channels];
            last[..rest.len() * channels].copy_from_slice(of_eights.remainder());
            seen.see::<T, CHANNELS>(&last, &own, luminance);
        }
        seen
    }

    /// Takes as many texels in as there are lanes.
    #[inline(always)]
    fn see<T: Texel, const CHANNELS: usize>(
        &mut self,
        texels: &[T],
        solid_angles: &Lanes,
        of_channels: &[f64],
    ) {
        let channels = if CHANNELS > 0 {
            CHANNELS
        } else {
            of_channels.len()
        };
        let texels = &texels[..LANES * channels];
        let held = solid_angles.map(|x| x > 0.0);
        let solid_angles = solid_angles.map(|x| if x > 0.0 { x } else { 0.0 });
        let mut luminance = [-0.0; LANES];
        let mut least = [0.0; LANES];
        for ((c, sum), of_channel) in
            (self.integral[..channels].iter_mut().enumerate()).zip(of_channels)
        {
            let mut value = [0.0; LANES];
            for k in 0..LANES {
                let x = texels[k * channels + c].load().to_f64();
                value[k] = if held[k] { x } else { 0.0 };
                sum[k] += solid_angles[k] * value[k];
                least[k] = if value[k] < least[k] {
                    value[k]
                } else {
                    least[k]
                };
            }
            if *of_channel != 0.0 {
                for k in 0..LANES {
                    luminance[k] += value[k] * of_channel;
                }
            }
        }
        for k in 0..LANES {
            let (solid_angle, x) = (solid_angles[k], luminance[k]);
            self.solid_angle[k] += solid_angle;
            self.luminance[k] += solid_angle * x;
            self.negative[k] += if least[k] < 0.0 { 1.0 } else { 0.0 };
            self.widest[k] = if solid_angle > self.widest[k] {
                solid_angle
            } else {
                self.widest[k]
            };
            let brighter = held[k] & (x > self.brightest[k]);
            self.brightest[k] = if brighter { x } else { self.brightest[k] };
            let darker = held[k] & (x > 0.0) & (x < self.darkest[k]);
            self.darkest[k] = if darker { x } else { self.darkest[k] };
        }
    }
}
