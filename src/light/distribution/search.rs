//! Distribution functions, and their inverses by guide tables.

use super::row::Row;
use crate::kernel::threads;
use crate::number::math::{max, min};
use fearless_simd::{Simd, SimdBase, SimdMask, f64x8};

/// How many edges a search looks at in one go.
pub(super) const WINDOW: usize = 8;

/// Samples keep this share of a cell away from its edges, where rounding decides on whose side they are.
const MARGIN: f64 = 1.0 / (1 << 24) as f64;

/// The largest number below 1.
pub(super) const BELOW_ONE: f64 = 1.0 - f64::EPSILON / 2.0;

/// From solid angles to the sums of luminance times solid angle, row by row.
pub(super) fn accumulate(
    cells: &mut [f64],
    columns: usize,
    split: usize,
    rows: &[Row],
    light: &[f64],
) {
    let points = cells.len();
    threads::rows(cells, columns + 1, points, |row, cells| {
        let light = &light[rows[row].texel..][..columns / split];
        let mut sum = 0.0;
        for (cells, light) in cells[1..].chunks_exact_mut(split).zip(light) {
            for cell in cells {
                sum += cell.abs() * light;
                *cell = sum;
            }
        }
    });
}

/// A sum, term by term, becomes a distribution function; without any mass all of it is in the first cell.
pub(super) fn normalize(function: &mut [f64]) {
    let total = function[function.len() - 1];
    for x in &mut function[1..] {
        *x = if total > 0.0 { *x / total } else { 1.0 };
    }
}

/// The bucket of x < 1 in a guide of so many entries, one more than buckets.
#[inline(always)]
pub(super) fn bucket(x: f64, entries: usize) -> usize {
    (x * (entries - 1) as f64) as usize
}

/// For each k/K the cell that it falls into.
pub(super) fn fill_guide(function: &[f64], guide: &mut [u32]) {
    let last = guide.len() - 1;
    let mut cell = 0;
    for (k, guide) in guide.iter_mut().enumerate() {
        let x = (k as f64 / last as f64).min(BELOW_ONE);
        while function[cell + 1] <= x {
            cell += 1;
        }
        *guide = cell as u32;
    }
}

/// The cell with function[cell] <= x < function[cell + 1], for x < 1, from the one that the guide gave.
#[inline(always)]
pub(super) fn search<S: Simd>(
    simd: S,
    function: &[f64],
    guide: &[u32],
    guess: usize,
    x: f64,
) -> usize {
    let mut cell = guess;
    // A product that rounds up to the next bucket may have led too far.
    while function[cell] > x {
        cell -= 1;
    }
    if let Some(window) = function.get(cell + 1..cell + 1 + WINDOW) {
        // Counted without a branch: where a search ends is what no CPU foresees.
        let edges = f64x8::from_slice(simd, window);
        let passed = edges
            .simd_le(f64x8::splat(simd, x))
            .to_bitmask()
            .count_ones();
        cell += passed as usize;
        if passed < WINDOW as u32 {
            return cell;
        }
    }
    let last = guide[bucket(x, guide.len()) + 1] as usize + 1;
    let within = &function[cell + 1..=last.max(cell + 1)];
    cell + within.partition_point(|edge| *edge <= x)
}

/// Where x lies between two edges, 0 to 1, clear of them.
#[inline(always)]
pub(super) fn position(x: f64, [from, to]: [f64; 2]) -> f64 {
    let place = (x - from) / (to - from);
    min(max(place, MARGIN), 1.0 - MARGIN)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn search_finds_the_cell_of_every_number() {
        let mut function = vec![0.0];
        let mut sum = 0.0;
        // Empty cells at both ends and in the middle, tiny ones, and one that holds nearly all.
        for mass in [0.0, 0.0, 1e-9, 1e-12, 0.0, 5.0, 1e-3, 0.0, 2.0, 0.0] {
            sum += mass;
            function.push(sum);
        }
        normalize(&mut function);
        for entries in [2, 5, 11, 64] {
            let mut guide = vec![0; entries];
            fill_guide(&function, &mut guide);
            let edges = function
                .iter()
                .flat_map(|x| [x.next_down(), *x, x.next_up()]);
            let even = (0..1000).map(|k| f64::from(k) / 1000.0);
            for x in edges.chain(even).filter(|x| (0.0..1.0).contains(x)) {
                let guess = guide[bucket(x, entries)] as usize;
                let cell = fearless_simd::dispatch!(
                    fearless_simd::Level::baseline(),
                    simd => search(simd, &function, &guide, guess, x)
                );
                assert!(function[cell] <= x && x < function[cell + 1], "{x} {cell}");
            }
        }
    }
}
