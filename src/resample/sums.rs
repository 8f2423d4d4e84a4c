//! Sums of the texels of planes by a sparse matrix: images as networks have them, one channel after the other.
//!
//! Rows are taken in blocks, whose weights stay in a core's cache, through a few planes at a time: a row's weights are read once for these,
//! and the texels of one plane that a block needs lie together. Each sum is in the order of its row.

use crate::error::{Error, expect_length};
use crate::kernel::Scalar;
use crate::kernel::threads;

/// Rows that are summed together.
const ROWS: usize = 1 << 11;

/// Planes that a row's weights are read for at once.
const PLANES: usize = 6;

/// Sums of texels of each channel of several images, by the rows of a sparse matrix.
///
/// Row k adds the texels `columns[ends[k]..ends[k + 1]]`, each times its weight. Images have `channels` planes for each of their faces: (N, F, C,
/// texels), `source` as many faces as `faces` says first, and `target` as many as it says then. Columns are places in the first channel of the
/// first image: of texel t of face f that is f · C · texels + t.
///
/// # Errors
/// For lengths that do not fit, and columns that an image does not have.
///
/// ```
/// use spheremap::resample::sums_of_planes;
/// let mut target = [0.0; 4];
/// // Two rows, the first of two texels; one image of two channels of three texels.
/// let matrix = (&[0, 2, 3][..], &[0, 2, 1][..], &[0.5, 0.5, 2.0][..]);
/// sums_of_planes(matrix, 2, [1, 1], &[1.0, 2.0, 3.0, 4.0, 5.0, 6.0], &mut target)?;
/// assert_eq!(target, [2.0, 4.0, 5.0, 10.0]);
/// # Ok::<(), spheremap::Error>(())
/// ```
pub fn sums_of_planes<T: Scalar>(
    (ends, columns, weights): (&[i32], &[i32], &[T]),
    channels: usize,
    faces: [usize; 2],
    source: &[T],
    target: &mut [T],
) -> Result<(), Error> {
    let rows = ends.len().saturating_sub(1);
    let (channels, faces) = (channels.max(1), faces.map(|faces| faces.max(1)));
    // Rows of a face, numbers of a channel of the source's faces, and images.
    let height = rows / faces[1];
    let images = target.len().checked_div(rows * channels).unwrap_or(0);
    let image = source.len().checked_div(images).unwrap_or(0);
    let plane = image / (faces[0] * channels);
    expect_length("ends", rows, height * faces[1])?;
    expect_length("target", target.len(), images * channels * rows)?;
    expect_length("source", source.len(), images * faces[0] * channels * plane)?;
    expect_length("weights", weights.len(), columns.len())?;
    let ordered = ends.is_sorted() && ends.first().is_none_or(|first| *first >= 0);
    let last = ends.last().map_or(0, |last| *last as usize);
    // What the last channel of an image has of its last face.
    let end = image.saturating_sub((channels - 1) * plane);
    let known = |column: &i32| usize::try_from(*column).is_ok_and(|column| column < end);
    if !ordered || last > columns.len() || !columns.iter().all(known) {
        return Err(Error::Shape(
            "Expected rows in order, and columns that an image has.".to_owned(),
        ));
    }
    if images == 0 || height == 0 {
        return Ok(());
    }
    let starts: Vec<usize> = (0..images * channels)
        .map(|k| k / channels * image + k % channels * plane)
        .collect();
    // Of each face the blocks of its rows, of each block its part of every plane.
    let each = height.div_ceil(ROWS);
    let mut blocks: Vec<Vec<&mut [T]>> = (0..faces[1] * each)
        .map(|_| Vec::with_capacity(starts.len()))
        .collect();
    for (number, plane) in target.chunks_mut(height).enumerate() {
        let face = number / channels % faces[1];
        for (block, part) in blocks[face * each..].iter_mut().zip(plane.chunks_mut(ROWS)) {
            block.push(part);
        }
    }
    let work = blocks.iter_mut().enumerate();
    threads::each(rows * starts.len(), work, |(number, targets)| {
        let first = number / each * height + number % each * ROWS;
        let matrix = (&ends[first..], columns, weights);
        for (targets, starts) in targets.chunks_mut(PLANES).zip(starts.chunks(PLANES)) {
            match (targets.as_chunks_mut(), starts.as_chunks()) {
                (([targets], []), ([starts], [])) => {
                    together::<T, PLANES>(matrix, source, starts, targets);
                }
                _ => {
                    for (target, &start) in targets.iter_mut().zip(starts) {
                        let target: &mut [&mut [T]; 1] = std::array::from_mut(target);
                        together(matrix, source, &[start], target);
                    }
                }
            }
        }
    });
    Ok(())
}

/// The rows of a block, of a few planes at once.
fn together<T: Scalar, const N: usize>(
    (ends, columns, weights): (&[i32], &[i32], &[T]),
    source: &[T],
    starts: &[usize; N],
    targets: &mut [&mut [T]; N],
) {
    let sources = starts.map(|start| &source[start..]);
    let count = targets[0].len();
    for row in 0..count {
        let range = ends[row] as usize..ends[row + 1] as usize;
        let mut sums = [T::ZERO; N];
        for (&column, &weight) in columns[range.clone()].iter().zip(&weights[range]) {
            for (sum, source) in sums.iter_mut().zip(&sources) {
                *sum = *sum + weight * source[column as usize];
            }
        }
        for (target, sum) in targets.iter_mut().zip(sums) {
            target[row] = sum;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn sums_are_those_of_a_dense_matrix() {
        let (faces, channels, images) = ([2, 3], 3, 3);
        let (height, texels) = (ROWS + 5, 40);
        let rows = faces[1] * height;
        let number = |k: usize| (k * 7919 % 101) as f64;
        let (mut ends, mut columns, mut weights) = (vec![0], Vec::new(), Vec::new());
        for row in 0..rows {
            for k in 0..row % 4 {
                let texel = (row * 3 + k * 7) % (faces[0] * texels);
                columns.push((texel + texel / texels * (channels - 1) * texels) as i32);
                weights.push(number(row + k));
            }
            ends.push(columns.len() as i32);
        }
        let image = faces[0] * channels * texels;
        let source: Vec<f64> = (0..images * image).map(number).collect();
        let mut target = vec![0.0; images * channels * rows];
        let matrix = (&ends[..], &columns[..], &weights[..]);
        sums_of_planes(matrix, channels, faces, &source, &mut target).unwrap();
        for (k, &found) in target.iter().enumerate() {
            let (plane, row) = (k / height, k % height);
            let (of_image, channel) = (plane / (channels * faces[1]), plane % channels);
            let row = plane / channels % faces[1] * height + row;
            let start = of_image * image + channel * texels;
            let wanted: f64 = (ends[row] as usize..ends[row + 1] as usize)
                .map(|k| weights[k] * source[start + columns[k] as usize])
                .sum();
            // Whole numbers.
            assert_eq!(found, wanted);
        }
        for columns in [[40], [-1]] {
            let matrix = (&[0, 1][..], &columns[..], &[1.0][..]);
            assert!(sums_of_planes(matrix, 1, [1, 1], &[0.0; 40], &mut [0.0]).is_err());
        }
        let matrix = (&[0, 2][..], &[1][..], &[1.0][..]);
        assert!(sums_of_planes(matrix, 1, [1, 1], &[0.0; 3], &mut [0.0]).is_err());
    }
}
