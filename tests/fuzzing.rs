//! Targets for bytes of no meaning: maps with any parameters, codes, pixel numbers, conversions.
//!
//! `cargo test` runs each on bytes that are the same every time. SPHEREMAP_FUZZ_SECONDS=600 runs each for so long on others; what
//! panics is then found again by the seed that is printed.

use arbtest::arbitrary::{Result, Unstructured};
use spheremap::healpix::{NONE, Order, Pixels};
use spheremap::image::{ImageView, shape_of_size, weights};
use spheremap::pack::{self, Invalid, Packing};
use spheremap::projections::{Coverage, REGISTRY};
use spheremap::resample::{Filter, Options, converted};
use spheremap::{Element, Map, MapOptions, Scalar};
use std::fmt::Debug;
use std::sync::LazyLock;

/// What takes bytes apart and asserts something of what comes out; an error where there are too few of them.
type Target = fn(&mut Unstructured<'_>) -> Result<()>;

fn drive(target: Target, cases: u64) {
    if let Ok(seconds) = std::env::var("SPHEREMAP_FUZZ_SECONDS") {
        let seconds: u64 = seconds.parse().expect("whole seconds");
        arbtest::arbtest(target).budget_ms(1000 * seconds);
        return;
    }
    for case in 0..cases {
        // Too few bytes are no finding.
        let _ = target(&mut Unstructured::new(&bytes(case)));
    }
}

/// A kilobyte of Steele, Lea and Flood's SplitMix64, from this seed.
fn bytes(seed: u64) -> Vec<u8> {
    let mut state = seed.wrapping_mul(0xD1B5_4A32_D192_ED03);
    let words = std::iter::repeat_with(|| {
        state = state.wrapping_add(0x9E37_79B9_7F4A_7C15);
        let mut z = (state ^ (state >> 30)).wrapping_mul(0xBF58_476D_1CE4_E5B9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94D0_49BB_1331_11EB);
        z ^ (z >> 31)
    });
    words.take(128).flat_map(u64::to_le_bytes).collect()
}

/// A float type, made of bits.
trait Float: Scalar + Element<Number = Self> + Debug {
    /// How far from 1 the length of a unit vector may be: the sum of three squares and a few roundings before.
    const UNIT: f64;
    fn of(bits: u64) -> Self;
}

impl Float for f32 {
    const UNIT: f64 = 1e-6;
    fn of(bits: u64) -> f32 {
        f32::from_bits(bits as u32)
    }
}

impl Float for f64 {
    const UNIT: f64 = 1e-14;
    fn of(bits: u64) -> f64 {
        f64::from_bits(bits)
    }
}

/// A number of any kind: any bits, one of [0, 1], one that formulas might not expect, a whole one.
fn number<R: Float>(u: &mut Unstructured<'_>) -> Result<R> {
    let odd = [0.0, -0.0, 0.5, 1.0, -1.0, 1e-30, 5e-324, 1e30, f64::MAX];
    let infinite = [f64::INFINITY, f64::NEG_INFINITY, f64::NAN];
    Ok(match u.int_in_range(0..=9)? {
        0 => R::of(u.arbitrary()?),
        1 => R::new(*u.choose(&odd)?),
        2 => R::new(*u.choose(&infinite)?),
        3 => R::new(f64::from(u.int_in_range(0..=12)?)),
        4 => R::new(share(u)? * 2.0 - 1.0),
        _ => R::new(share(u)?),
    })
}

fn share(u: &mut Unstructured<'_>) -> Result<f64> {
    Ok(u.arbitrary::<u32>()? as f64 / f64::from(u32::MAX))
}

fn numbers<R: Float>(u: &mut Unstructured<'_>, count: usize) -> Result<Vec<R>> {
    (0..count).map(|_| number(u)).collect()
}

/// Any map that can be made; none of parameters that do not go together.
fn map(u: &mut Unstructured<'_>) -> Result<Option<Map>> {
    let info = u.choose(REGISTRY)?;
    let mut parameters = Vec::new();
    for parameter in info.parameters {
        let (low, high) = (parameter.above, parameter.maximum);
        let value = match u.int_in_range(0..=5)? {
            0 => low + (high - low) * 1e-9,
            1 => high,
            2 => low + (high - low) * share(u)?,
            // Where calibrations are.
            3 => parameter.default + (high - low) * 0.01 * (share(u)? - 0.5),
            _ => continue,
        };
        parameters.push((parameter.name, value));
    }
    let mut options = MapOptions::new().parameters(&parameters);
    if !info.layouts.is_empty() && u.arbitrary()? {
        options = options.layout(u.choose(info.layouts)?.name);
    }
    if u.arbitrary()? {
        options = options.grid(u.choose(&["centers", "corners", "corners-v"])?);
    }
    if u.arbitrary()? {
        options = options.axes(u.choose(&["+x +y +z", "-z +y -x", "+y -z +x"])?);
    }
    Ok(Map::with(info.name, options).ok())
}

fn formulas_of<R: Float>(u: &mut Unstructured<'_>) -> Result<()> {
    const COUNT: usize = 9;
    let Some(map) = map(u)? else { return Ok(()) };
    let name = || {
        format!(
            "{} {:?} {:?}",
            map.info().name,
            map.layout(),
            map.parameters()
        )
    };
    let width = map.uv_width();
    let d = numbers::<R>(u, 3 * COUNT)?;
    let mut uv = vec![R::default(); width * COUNT];
    map.encode(&d, &mut uv).unwrap();
    for (uv, d) in uv.chunks(width).zip(d.chunks(3)) {
        let place: Vec<f64> = uv.iter().map(|x| x.to_f64()).collect();
        let nowhere = place.iter().all(|x| x.is_nan());
        let within = place[..2].iter().all(|x| (0.0..=1.0).contains(x));
        let face = place.get(2).copied().unwrap_or(0.0);
        let of_a_face = face.fract() == 0.0 && (0.0..map.faces() as f64).contains(&face);
        assert!(nowhere || within && of_a_face, "{} {d:?} -> {uv:?}", name());
    }

    let uv = numbers::<R>(u, width * COUNT)?;
    let (mut d, mut density) = (vec![R::default(); 3 * COUNT], vec![R::default(); COUNT]);
    let (mut slopes, mut valid) = (vec![R::default(); 6 * COUNT], vec![false; COUNT]);
    map.decode(&uv, &mut d).unwrap();
    map.density(&uv, &mut density).unwrap();
    map.jacobian(&uv, &mut slopes).unwrap();
    map.valid(&uv, &mut valid).unwrap();
    for (k, uv) in uv.chunks(width).enumerate() {
        let d: Vec<f64> = d[3 * k..][..3].iter().map(|x| x.to_f64()).collect();
        let length = d.iter().map(|x| x * x).sum::<f64>().sqrt();
        let what = || format!("{} {uv:?} -> {d:?}", name());
        if valid[k] {
            assert!((length - 1.0).abs() <= R::UNIT, "{}", what());
            assert!(density[k].to_f64() >= 0.0, "{} {:?}", what(), density[k]);
        } else {
            assert!(d.iter().all(|x| x.is_nan()), "{}", what());
            assert!(density[k].to_f64().is_nan(), "{} {:?}", what(), density[k]);
        }
    }
    Ok(())
}

fn formulas(u: &mut Unstructured<'_>) -> Result<()> {
    if u.arbitrary()? {
        formulas_of::<f32>(u)
    } else {
        formulas_of::<f64>(u)
    }
}

static PACKINGS: LazyLock<Vec<Packing>> = LazyLock::new(|| {
    let names = pack::names().map(|name| name.0);
    names.map(|name| Packing::new(&name).unwrap()).collect()
});

fn codes(u: &mut Unstructured<'_>) -> Result<()> {
    const COUNT: usize = 9;
    let packing = u.choose(&PACKINGS)?;
    let rounding = *u.choose(packing.family.roundings)?;
    let single = u.arbitrary()?;
    let mut codes = [0_u64; COUNT];
    if single {
        let d = numbers::<f32>(u, 3 * COUNT)?;
        packing.pack(rounding, Invalid::Zero, &d, &mut codes)
    } else {
        let d = numbers::<f64>(u, 3 * COUNT)?;
        packing.pack(rounding, Invalid::Zero, &d, &mut codes)
    }
    .unwrap();
    let out = packing.first_out_of_range(&codes);
    assert_eq!(out, None, "{} {codes:?}", packing.name);

    // Any code there is, and what it stands for.
    for code in &mut codes {
        let all = packing.codes().wrapping_sub(1);
        *code = u.int_in_range(0..=all)?;
    }
    let mut directions = [0.0_f64; 3 * COUNT];
    packing.unpack(&codes, &mut directions).unwrap();
    for (d, code) in directions.chunks(3).zip(codes) {
        let length = d.iter().map(|x| x * x).sum::<f64>().sqrt();
        // Those that repeat other programs compute as these do: lengths are off by no more than directions.
        let off = packing.bound(rounding).unwrap_or(0.0);
        let unit = (length - 1.0).abs() <= f32::UNIT + off;
        assert!(unit, "{} {code} -> {d:?}", packing.name);
    }
    Ok(())
}

fn pixels(u: &mut Unstructured<'_>) -> Result<()> {
    let nested = u.arbitrary()?;
    let shift = u.int_in_range(0..=29)?;
    let nside = if nested || u.arbitrary()? {
        1_i64 << shift
    } else {
        u.int_in_range(1..=1 << shift)?
    };
    let order = if nested { Order::Nested } else { Order::Ring };
    let pixels = Pixels::new(nside, order).unwrap();
    let last = 12 * nside * nside - 1;
    let pixel = match u.int_in_range(0..=3)? {
        0 => u.int_in_range(0..=last.min(20))?,
        1 => last - u.int_in_range(0..=last.min(20))?,
        _ => u.int_in_range(0..=last)?,
    };
    let (mut center, mut back) = ([0.0; 3], [0]);
    pixels.directions(&[pixel], &mut center).unwrap();
    pixels.of_directions(&center, &mut back).unwrap();
    assert_eq!(back, [pixel], "{nside} {order:?} {center:?}");

    let (mut around, mut their) = ([0; 8], [0; 8]);
    pixels.neighbors(&[pixel], &mut around).unwrap();
    for neighbor in around.into_iter().filter(|k| *k != NONE) {
        assert!(
            (0..=last).contains(&neighbor),
            "{nside} {order:?} {pixel} {around:?}"
        );
        pixels.neighbors(&[neighbor], &mut their).unwrap();
        assert!(
            their.contains(&pixel),
            "{nside} {order:?} {pixel} {neighbor} {their:?}"
        );
    }
    if nside & (nside - 1) == 0 {
        let other = if nested { Order::Ring } else { Order::Nested };
        let (mut there, mut back) = ([0], [0]);
        pixels.reordered(&[pixel], &mut there).unwrap();
        let others = Pixels::new(nside, other).unwrap();
        others.reordered(&there, &mut back).unwrap();
        assert_eq!(back, [pixel], "{nside} {order:?} {there:?}");
    }

    let any: i64 = u.arbitrary()?;
    pixels.neighbors(&[any], &mut around).unwrap();
    pixels.directions(&[any], &mut center).unwrap();
    let known = (0..=last).contains(&any);
    assert_eq!(
        center[0].is_nan(),
        !known,
        "{nside} {order:?} {any} {center:?}"
    );
    Ok(())
}

/// Overlaps of texels: they add up to the constant that was there, and to the light.
fn overlaps(u: &mut Unstructured<'_>) -> Result<()> {
    let (Some(source), Some(target)) = (map(u)?, map(u)?) else {
        return Ok(());
    };
    let shape = |u: &mut Unstructured<'_>, map: &Map| -> Result<Vec<usize>> {
        Ok(shape_of_size(map, u.int_in_range(2..=9)?))
    };
    let (from, into) = (shape(u, &source)?, shape(u, &target)?);
    let name = || {
        let of = |map: &Map| {
            format!(
                "{} {:?} {:?}",
                map.info().name,
                map.layout(),
                map.parameters()
            )
        };
        format!("{} {from:?} to {} {into:?}", of(&source), of(&target))
    };
    let texels: usize = from.iter().product();
    // A map of a sliver would be a panorama of many thousands; no shape of this size is one.
    if texels.max(into.iter().product()) > 4096 {
        return Ok(());
    }
    let options = Options::new().filter(Filter::Area);
    let convert = |image: &[f64]| {
        let view = ImageView::new(&source, &from, 1, image).ok()?;
        converted(&view, &target, &into, &options).ok()
    };
    let value = share(u)?;
    let Some(flat) = convert(&vec![value; texels]) else {
        return Ok(());
    };
    let constant = flat.iter().all(|x| x.is_nan() || *x == value);
    assert!(constant, "{} {value} {flat:?}", name());
    if [&source, &target]
        .iter()
        .any(|map| map.coverage() != Coverage::Sphere)
    {
        return Ok(());
    }
    let light: Vec<f64> = (0..texels).map(|_| share(u)).collect::<Result<_>>()?;
    let Some(seen) = convert(&light) else {
        return Ok(());
    };
    let total = |map: &Map, shape: &[usize], image: &[f64]| {
        let mut cells = vec![0.0; image.len()];
        weights(map, shape, &mut cells).unwrap();
        let seen = cells.iter().zip(image).filter(|(w, _)| **w > 0.0);
        seen.map(|(w, x)| w * x).sum::<f64>()
    };
    let (before, after) = (total(&source, &from, &light), total(&target, &into, &seen));
    // The stated bound of energy, of all the light that there could be.
    assert!(
        (before - after).abs() <= 1e-6 * 4.0 * std::f64::consts::PI,
        "{} {before} {after}",
        name()
    );
    Ok(())
}

#[test]
fn any_map_of_any_numbers() {
    drive(formulas, 4000);
}

#[test]
fn any_code_of_any_packing() {
    drive(codes, 4000);
}

#[test]
fn any_pixel_of_any_nside() {
    drive(pixels, 4000);
}

#[test]
fn any_two_maps_overlap_and_keep_the_light() {
    drive(overlaps, 300);
}
