//! Textures as `sm.write_ktx2` and `sm.write_dds` write them, read by crates that others keep.
//!
//! `tests/data/cube.ktx2` and `cube.dds` are a cube of 4, 2 and 1 texels a side; tests/light/test_bake.py checks that they are
//! still what is written.

use half::f16;

const FACES: usize = 6;
const SIDES: [usize; 3] = [4, 2, 1];

/// What a channel of a texel holds: a number that no other one does.
fn number(face: usize, level: usize, texel: usize, channel: usize) -> f32 {
    (256 * face + 64 * level + 4 * texel + channel) as f32
}

/// Whether bytes are the halves of one face of one level.
fn check(bytes: &[u8], face: usize, level: usize) {
    let values: Vec<f32> = bytes
        .as_chunks::<2>()
        .0
        .iter()
        .map(|pair| f16::from_le_bytes(*pair).to_f32())
        .collect();
    assert_eq!(values.len(), 4 * SIDES[level] * SIDES[level]);
    for (k, value) in values.into_iter().enumerate() {
        assert_eq!(
            value,
            number(face, level, k / 4, k % 4),
            "{face} {level} {k}"
        );
    }
}

#[test]
fn ktx2() {
    let reader = ktx2::Reader::new(&include_bytes!("data/cube.ktx2")[..]).unwrap();
    let header = reader.header();
    assert_eq!(header.format, Some(ktx2::Format::R16G16B16A16_SFLOAT));
    assert_eq!((header.pixel_width, header.pixel_height), (4, 4));
    assert_eq!(header.face_count as usize, FACES);
    assert_eq!(header.supercompression_scheme, None);
    assert_eq!(
        reader.transfer_function(),
        Some(ktx2::TransferFunction::Linear)
    );
    assert_eq!(reader.color_primaries(), Some(ktx2::ColorPrimaries::BT709));
    assert_eq!(
        reader.writer().map(|name| name.trim_end_matches('\0')),
        Some("spheremap")
    );
    assert_eq!(reader.levels().len(), SIDES.len());
    for (level, stored) in reader.levels().enumerate() {
        let face = stored.data.len() / FACES;
        for (k, bytes) in stored.data.chunks_exact(face).enumerate() {
            check(bytes, k, level);
        }
    }
}

#[test]
fn dds() {
    let file = ddsfile::Dds::read(&include_bytes!("data/cube.dds")[..]).unwrap();
    assert_eq!(
        file.get_d3d_format(),
        Some(ddsfile::D3DFormat::A16B16G16R16F)
    );
    assert_eq!((file.get_width(), file.get_height()), (4, 4));
    assert_eq!(file.get_num_array_layers() as usize, FACES);
    assert_eq!(file.get_num_mipmap_levels() as usize, SIDES.len());
    for face in 0..FACES {
        let mut rest = file.get_data(face as u32).unwrap();
        for (level, side) in SIDES.into_iter().enumerate() {
            let (bytes, after) = rest.split_at(8 * side * side);
            check(bytes, face, level);
            rest = after;
        }
        assert!(rest.is_empty());
    }
}
