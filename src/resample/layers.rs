//! Views of one panorama put together: each a layer of values times their weights, with the weights as one more channel.

use crate::image::texel::Texel;
use crate::kernel::Scalar;
use crate::kernel::threads;
use crate::number::real::Real;

/// Texels that a thread takes at a time.
const CHUNK: usize = 1 << 12;

/// Adds a layer of so many channels and a weight to those before it, or puts it where it weighs more than they do.
pub(crate) fn add<F: Scalar>(total: &mut [F], layer: &[F], channels: usize, nearest: bool) {
    let width = channels + 1;
    let count = total.len() / width;
    threads::rows(total, CHUNK * width, count, |chunk, total| {
        let layer = &layer[chunk * CHUNK * width..][..total.len()];
        if !nearest {
            for (a, b) in total.iter_mut().zip(layer) {
                *a = *a + *b;
            }
            return;
        }
        let pairs = total.chunks_exact_mut(width).zip(layer.chunks_exact(width));
        for (a, b) in pairs {
            if b[channels].more(a[channels]) {
                a.copy_from_slice(b);
            }
        }
    });
}

/// Writes values by their weights, rounded once; where no view sees anything, what stands for that.
pub(crate) fn divide<T: Texel>(total: &[T::Float], channels: usize, out: &mut [T]) {
    match channels {
        1 => divide_all::<T, 1>(total, channels, out),
        3 => divide_all::<T, 3>(total, channels, out),
        4 => divide_all::<T, 4>(total, channels, out),
        _ => divide_all::<T, 0>(total, channels, out),
    }
}

/// `KNOWN` channels, of which the compiler makes more, or of any number where that is 0.
fn divide_all<T: Texel, const KNOWN: usize>(total: &[T::Float], channels: usize, out: &mut [T]) {
    let channels = if KNOWN > 0 { KNOWN } else { channels };
    let (width, nothing) = (channels + 1, T::from_f64(T::NOTHING));
    let count = out.len() / channels;
    threads::rows(out, CHUNK * channels, count, |chunk, out| {
        let total = total[chunk * CHUNK * width..].chunks_exact(width);
        for (out, sum) in out.chunks_exact_mut(channels).zip(total) {
            let weight = sum[channels];
            let is_seen = weight.more(T::Float::ZERO);
            for (texel, value) in out.iter_mut().zip(sum) {
                let found = T::store(*value / weight);
                *texel = if is_seen { found } else { nothing };
            }
        }
    });
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn layers_are_added_or_the_heavier_one_is_taken() {
        let mut sum = [1.0_f32, 2.0, 0.5, 4.0, 6.0, 2.0];
        let more = [3.0, 1.0, 1.0, 1.0, 1.0, 1.0];
        let mut best = sum;
        add(&mut sum, &more, 2, false);
        assert_eq!(sum, [4.0, 3.0, 1.5, 5.0, 7.0, 3.0]);
        add(&mut best, &more, 2, true);
        assert_eq!(best, [3.0, 1.0, 1.0, 4.0, 6.0, 2.0]);
    }

    #[test]
    fn what_no_view_sees_is_nothing() {
        let total = [30.0_f32, 60.0, 90.0, 3.0, 0.0, 0.0, 0.0, 0.0];
        let mut bytes = [7_u8; 6];
        divide(&total, 3, &mut bytes);
        assert_eq!(bytes, [10, 20, 30, 0, 0, 0]);
        let mut floats = [7.0_f32; 4];
        divide(&total, 1, &mut floats);
        assert_eq!(floats[..2], [0.5, 30.0]);
        assert!(floats[2..].iter().all(|x| x.is_nan()));
    }
}
