//! Coefficients by least squares, for texels that lie anywhere.
//!
//! The fit of order F minimizes Σ w (L - Σ c Y)² and solves G c = b with b = Σ w L Y over texels and
//! G = Σ w Y Yᵀ. G is near the identity, by as much as the texels are a good quadrature. It is never
//! built: a product of two Y of order F is of order 2F, so G hangs on the moments m = Σ w Y up to order 2F alone,
//! and G c is the analysis of (Σ m Y) (Σ c Y) on a small grid of rings that integrates order 4F exactly. Conjugate
//! gradients need 4 to 8 of such steps. The moments belong to the texels' places and not to what they
//! show, so they are kept with them.
//!
//! F is two above the order that is wanted, where there are texels enough: what lies just above the order then does not
//! leak into it either.
//!
//! What did not help: weights that make sums exact (solving for them takes G up to order 4F), and
//! analysis of the residual over all texels (two passes over the image a step).

use super::count::count;
use super::rings::{self, Rings};
use crate::error::Error;
use crate::image::ImageView;
use crate::image::texel::Texel;
use crate::kernel::{interrupt, threads};
use crate::light::integrate::add_sheets;
use crate::light::patches::LANES;
use crate::light::sh::basis::{self, Basis, Points};
use crate::light::texels::Texels;
use std::sync::Arc;

/// Blocks whose sums one thread makes: each such group has all sums.
const GROUP: usize = 64;

/// Plain sums Σ flux · Y: sheet by sheet, so that they may be made apart.
pub fn sums(texels: &Texels, flux: &[f64], channels: usize, order: usize) -> Vec<f64> {
    let basis = Basis::new(order);
    let per = count(order) * channels;
    let all = texels.blocks.len().max(1) as f64;
    let mut done = 0;
    let mut sheets = Vec::with_capacity(texels.sheets.len() * per);
    for blocks in &texels.sheets {
        let mut parts = vec![0.0; blocks.len().div_ceil(GROUP) * per];
        let points = blocks.len() * LANES * LANES * 4;
        let work = |number: usize, part: &mut [f64]| {
            let mut sums = basis::Sums::new(order, channels);
            for &block in blocks[number * GROUP..].iter().take(GROUP) {
                let block = &texels.blocks[block];
                let values = &flux[channels * block.start..][..channels * block.length];
                sums.add(&basis, texels.directions(block), |c| {
                    &values[c * block.length..][..block.length]
                });
            }
            sums.finish(part);
        };
        let here = [done, done + blocks.len()].map(|blocks| blocks as f64 / all);
        interrupt::part(here[0], here[1], || {
            threads::rows(&mut parts, per, points * (order + 1), work);
        });
        done += blocks.len();
        sheets.extend(basis::add_parts(&parts, per));
    }
    add_sheets(&sheets, per)
}

/// The order of the fit of an image of so many texels that hold a value.
pub fn order_of_fit(order: usize, texels: usize) -> usize {
    let wide = order + 2;
    if 4 * count(wide) <= texels {
        wide
    } else {
        order
    }
}

/// The equations of a fit.
pub struct Normal {
    /// The order of the fit.
    pub high: usize,
    /// Σ w Y up to twice that order.
    moments: Arc<Vec<f64>>,
}

impl Normal {
    /// Those of texels that lie anywhere.
    pub fn moments_of(texels: &Texels, order: usize) -> Normal {
        let n = texels.weight.iter().filter(|w| **w > 0.0).count();
        let high = order_of_fit(order, n);
        let moments = texels.moments(high, || {
            // In the same blocks, one row each: a constant image.
            interrupt::part(0.5, 1.0, || sums(texels, &texels.weight, 1, 2 * high))
        });
        Normal { high, moments }
    }

    /// Those of these moments, up to twice the order of the fit.
    pub fn of_moments(high: usize, moments: Vec<f64>) -> Normal {
        Normal {
            high,
            moments: Arc::new(moments),
        }
    }

    /// Those of texels on rings.
    pub fn moments_of_rings(rings: &Rings, order: usize) -> Normal {
        let high = (order + 2).min(rings.highest());
        let moments = Arc::new(rings.analyze_one(2 * high, &rings.solid_angles()));
        Normal { high, moments }
    }

    /// What the fit makes of sums with the basis, up to its order; none where the texels do not determine it.
    pub fn fitted(&self, right: &[f64], channels: usize) -> Option<Vec<f64>> {
        let mut whole = vec![0.0; count(self.high) * channels];
        whole[..right.len()].copy_from_slice(right);
        solve(&Operator::new(&self.moments, self.high), &whole, channels)
    }

    /// What flows back to the sums, from coefficients of means: their order 0 is a sum, and no part of the fit.
    pub fn transposed(&self, gradient: &[f64], channels: usize) -> Option<Vec<f64>> {
        let mut others = gradient.to_vec();
        others[..channels].fill(0.0);
        let mut found = self.fitted(&others, channels)?;
        for (found, first) in found.iter_mut().zip(&gradient[..channels]) {
            *found += first;
        }
        Some(found)
    }
}

/// The sums of an image, and the equations of their fit.
pub struct Sums {
    /// The equations.
    pub normal: Normal,
    /// Σ w L Y up to the order of the fit.
    pub right: Vec<f64>,
}

impl Sums {
    /// Those of texels that lie anywhere.
    pub fn new<T: Texel>(
        texels: &Texels,
        image: &ImageView<'_, T>,
        order: usize,
    ) -> Result<Sums, Error> {
        let flux = texels.flux(image, false)?;
        let normal = Normal::moments_of(texels, order);
        let high = normal.high;
        let right = interrupt::part(0.0, 0.5, || sums(texels, &flux, image.channels(), high));
        Ok(Sums { normal, right })
    }

    /// Those of texels on rings.
    pub fn of_rings<T: Texel>(rings: &Rings, image: &ImageView<'_, T>, order: usize) -> Sums {
        let normal = Normal::moments_of_rings(rings, order);
        let right = rings.analyze(image, normal.high, &rings.solid_angles());
        Sums { normal, right }
    }

    /// The coefficients of the least squares fit up to `order`; none where the texels do not determine them.
    pub fn solution(&self, channels: usize, order: usize) -> Option<Vec<f64>> {
        let mut solution = self.normal.fitted(&self.right, channels)?;
        solution.truncate(count(order) * channels);
        Some(solution)
    }
}

struct Operator {
    grid: Points,
    basis: Basis,
    high: usize,
}

impl Operator {
    fn new(moments: &[f64], high: usize) -> Operator {
        let mut grid = rings::grid(4 * high + 1);
        let mut density = vec![0.0; grid.len()];
        Basis::new(2 * high).synthesize(&grid, moments, 1, &mut density);
        for (weight, density) in grid.weight.iter_mut().zip(density) {
            *weight *= density;
        }
        Operator {
            grid,
            basis: Basis::new(high),
            high,
        }
    }

    fn apply(&self, coefficients: &[f64], channels: usize) -> Vec<f64> {
        let mut values = vec![0.0; self.grid.len() * channels];
        self.basis
            .synthesize(&self.grid, coefficients, channels, &mut values);
        basis::analyze_points(&self.grid, &values, channels, self.high)
    }
}

/// Conjugate gradients, each channel by itself.
fn solve(operator: &Operator, right: &[f64], channels: usize) -> Option<Vec<f64>> {
    const STEPS: usize = 200;
    let products = |a: &[f64], b: &[f64]| -> Vec<f64> {
        let mut sums = vec![0.0; channels];
        for (a, b) in a.chunks_exact(channels).zip(b.chunks_exact(channels)) {
            for c in 0..channels {
                sums[c] += a[c] * b[c];
            }
        }
        sums
    };
    let mut x = right.to_vec();
    let image = operator.apply(&x, channels);
    let mut residual: Vec<f64> = right.iter().zip(&image).map(|(b, i)| b - i).collect();
    let mut direction = residual.clone();
    let mut left = products(&residual, &residual);
    let goal: Vec<f64> = products(right, right).iter().map(|b| b * 1e-26).collect();
    let reached = |left: &[f64], factor: f64| left.iter().zip(&goal).all(|(l, g)| *l <= g * factor);
    let mut least = f64::INFINITY;
    for _ in 0..STEPS {
        let total: f64 = left.iter().sum();
        // Rounding ends the descent a little before or after the goal.
        if reached(&left, 1.0) || (reached(&left, 1e4) && total >= least) {
            break;
        }
        least = least.min(total);
        let image = operator.apply(&direction, channels);
        let slope = products(&direction, &image);
        let step: Vec<f64> = (0..channels)
            .map(|c| {
                if slope[c] > 0.0 {
                    left[c] / slope[c]
                } else {
                    0.0
                }
            })
            .collect();
        for (k, x) in x.iter_mut().enumerate() {
            *x += step[k % channels] * direction[k];
            residual[k] -= step[k % channels] * image[k];
        }
        let now = products(&residual, &residual);
        for (k, d) in direction.iter_mut().enumerate() {
            let c = k % channels;
            let turn = if left[c] > 0.0 { now[c] / left[c] } else { 0.0 };
            *d = residual[k] + turn * *d;
        }
        left = now;
    }
    reached(&left, 1e8).then_some(x)
}
