//! Images whose channels are planes, as tensors are stored, into texels with their channels side by side, and back.
//!
//! Several images are turned together, the channels of all of them side by side: lookups at one place serve them all. Blocks of texels
//! are small enough that what is read in one order and written in another stays in the nearest cache.

use crate::kernel::threads;

/// Texels that a thread takes at a time.
const BLOCK: usize = 1 << 12;

/// Texels that are turned together.
const TOGETHER: usize = 64;

/// How images are stored as planes, (images, faces, channels, texels of a face).
#[derive(Clone, Copy, Debug)]
pub(crate) struct Planes {
    pub images: usize,
    pub faces: usize,
    pub channels: usize,
    pub side: usize,
}

impl Planes {
    /// Channels of all images.
    fn width(self) -> usize {
        self.images * self.channels
    }

    /// Where the plane of a face begins that is number k among those of all images.
    fn start(self, face: usize, k: usize) -> usize {
        let (image, channel) = (k / self.channels, k % self.channels);
        ((image * self.faces + face) * self.channels + channel) * self.side
    }

    fn texels(self) -> usize {
        self.faces * self.side
    }

    /// Writes texels (faces and texels, images and channels).
    pub fn texels_of<T: Copy + Send + Sync>(self, planes: &[T], texels: &mut [T]) {
        let width = self.width();
        if texels.is_empty() {
            return;
        }
        let faces = texels.chunks_mut(self.side * width).enumerate();
        let blocks = faces.flat_map(|(face, texels)| {
            let blocks = texels.chunks_mut(BLOCK * width).enumerate();
            blocks.map(move |(block, texels)| (face, block * BLOCK, texels))
        });
        let blocks: Vec<_> = blocks.collect();
        threads::each(
            self.texels(),
            blocks.into_iter(),
            |(face, first, texels)| {
                for (part, texels) in texels.chunks_mut(TOGETHER * width).enumerate() {
                    let (first, count) = (first + part * TOGETHER, texels.len() / width);
                    for k in 0..width {
                        let plane = &planes[self.start(face, k) + first..][..count];
                        for (texel, &x) in texels.chunks_exact_mut(width).zip(plane) {
                            texel[k] = x;
                        }
                    }
                }
            },
        );
    }

    /// Fills planes with such texels.
    pub fn planes_of<T: Copy + Send + Sync>(self, texels: &[T], planes: &mut [T]) {
        let width = self.width();
        if planes.is_empty() {
            return;
        }
        let per_face = self.side.div_ceil(BLOCK);
        let mut blocks: Vec<Vec<&mut [T]>> = Vec::new();
        blocks.resize_with(self.faces * per_face, || Vec::with_capacity(width));
        for (number, plane) in planes.chunks_mut(self.side).enumerate() {
            let face = number / self.channels % self.faces;
            let own = &mut blocks[face * per_face..][..per_face];
            for (block, part) in own.iter_mut().zip(plane.chunks_mut(BLOCK)) {
                block.push(part);
            }
        }
        let blocks = blocks.into_iter().enumerate();
        threads::each(self.texels(), blocks, |(number, mut planes)| {
            let (face, block) = (number / per_face, number % per_face);
            let count = planes[0].len();
            let first = face * self.side + block * BLOCK;
            let texels = &texels[first * width..][..count * width];
            for (part, texels) in texels.chunks(TOGETHER * width).enumerate() {
                for (k, plane) in planes.iter_mut().enumerate() {
                    let plane = &mut plane[part * TOGETHER..];
                    for (x, texel) in plane.iter_mut().zip(texels.chunks_exact(width)) {
                        *x = texel[k];
                    }
                }
            }
        });
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    proptest! {
        #[test]
        fn texels_have_the_numbers_of_planes_and_go_back(
            images in 1_usize..4,
            faces in 1_usize..4,
            channels in 1_usize..5,
            side in prop::sample::select(vec![1_usize, 63, 64, 65, BLOCK, BLOCK + 1]),
        ) {
            let shape = Planes { images, faces, channels, side };
            let planes: Vec<u32> = (0..(images * faces * channels * side) as u32).collect();
            let (mut texels, mut back) = (vec![0; planes.len()], vec![0; planes.len()]);
            shape.texels_of(&planes, &mut texels);
            for (number, &x) in texels.iter().enumerate() {
                let (texel, k) = (number / shape.width(), number % shape.width());
                prop_assert_eq!(x, planes[shape.start(texel / side, k) + texel % side]);
            }
            shape.planes_of(&texels, &mut back);
            prop_assert_eq!(planes, back);
        }
    }

    #[test]
    fn nothing_is_turned_into_nothing() {
        let shape = Planes {
            images: 0,
            faces: 1,
            channels: 3,
            side: 4,
        };
        shape.texels_of::<f32>(&[], &mut []);
        shape.planes_of::<f32>(&[], &mut []);
    }
}
