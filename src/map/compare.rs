//! What turns one map into another, in words and as a matrix.
//!
//! Two maps of one formula differ by axes, the order and orientation of faces, grid and layout. None of that is read off
//! their definitions: both decode the same places of the image, in no symmetric position, and the signed permutation
//! that takes the first's directions to the second's is looked for, component by component. So whatever a convention is
//! made of, what is told is what an image shows. Where all faces agree there is one matrix; where they do not, faces may
//! be the same ones in another order (their axes say which matrix to expect), or each is told on its own.
//!
//! A matrix in words is a mirror, if its determinant is -1 (of three the one that leaves the shortest turn, and of equals
//! one that keeps up where it is), then a rotation of the cube: yaw about the axis that is up in the first map's world,
//! or a turn about its own axis, right-handed, in degrees.
//!
//! What a program means by up and ahead cannot be told from an image: that is [`worlds`].

use crate::error::Error;
use crate::geometry::axes::Axes;
use crate::map::Map;

/// A signed permutation, row by row.
pub type SignedPermutation = [[i8; 3]; 3];

const IDENTITY: SignedPermutation = [[1, 0, 0], [0, 1, 0], [0, 0, 1]];

/// Inside a face, in no symmetric position, and enough of them for outlines that leave some out.
const PLACES: [[f64; 2]; 7] = [
    [0.3, 0.4],
    [0.7, 0.35],
    [0.45, 0.8],
    [0.62, 0.58],
    [0.47, 0.44],
    [0.41, 0.63],
    [0.55, 0.27],
];

/// How an image read in one way differs from the same image read in another.
#[derive(Clone, Debug, PartialEq)]
pub struct Comparison {
    /// Takes the direction that the first sees at a place of the image to the one that the second sees there, the order
    /// of faces and the layout aside; none where no single one does.
    pub matrix: Option<SignedPermutation>,
    /// Everything that differs, one phrase each.
    pub differences: Vec<String>,
}

impl Comparison {
    /// Whether the matrix is a mirror image.
    ///
    /// ```
    /// use spheremap::{Map, compare::compare};
    /// let (a, b) = (Map::new("latlong")?, Map::new("latlong:unity")?);
    /// assert_eq!(compare(&a, &b)?.mirrored(), Some(true));
    /// # Ok::<(), spheremap::Error>(())
    /// ```
    pub fn mirrored(&self) -> Option<bool> {
        self.matrix.map(|m| determinant(m) < 0)
    }
}

/// Tells what turns the first map into the second.
///
/// ```
/// use spheremap::{Map, compare::compare};
/// let map = |name| Map::new(name);
/// let found = compare(&map("latlong:skylibs")?, &map("latlong:filament")?)?;
/// assert_eq!(found.matrix, Some([[1, 0, 0], [0, 1, 0], [0, 0, -1]]));
/// assert_eq!(found.differences[0], "mirrored (z changes sign)");
/// # Ok::<(), spheremap::Error>(())
/// ```
pub fn compare(a: &Map, b: &Map) -> Result<Comparison, Error> {
    if a.info().name != b.info().name || a.parameters() != b.parameters() {
        return Ok(of_kinds(a, b));
    }
    let (mut p, mut q) = (a.clone(), b.clone());
    let mut differences = Vec::new();
    if let (Some(first), Some(second)) = (p.layout(), q.layout())
        && first != second
    {
        differences.push(format!("layout differs: {first} and {second}"));
        (p, q) = (p.with_layout("faces")?, q.with_layout("faces")?);
    }
    let up = up(&p);
    let faces: Vec<(String, SignedPermutation)> = cells(&p)
        .into_iter()
        .map(|(name, uv)| (name, between(&decoded(&p, &uv), &decoded(&q, &uv))))
        .collect();
    let together = faces.windows(2).all(|pair| pair[0].1 == pair[1].1);
    let order = if together { None } else { order(&p, &q) };
    let matrix = match (&order, faces.first()) {
        (Some(_), _) => Some(of_axes(&p, &q)),
        (None, Some((_, matrix))) if together => Some(*matrix),
        _ => None,
    };
    match matrix {
        Some(matrix) => {
            let words = words(matrix, up);
            if !words.is_empty() {
                differences.insert(0, words);
            }
        }
        None => {
            let moved = faces.iter().filter(|(_, matrix)| *matrix != IDENTITY);
            differences.extend(moved.map(|(name, m)| format!("{name}: {}", words(*m, up))));
        }
    }
    if let Some(order) = order {
        let order: Vec<String> = order.iter().map(usize::to_string).collect();
        differences.push(format!(
            "face order differs: 0 1 2 ... of the first are {} of the second",
            order.join(" ")
        ));
    }
    if p.grid() != q.grid() {
        let (p, q) = (p.grid().name(), q.grid().name());
        differences.push(format!("grid differs: {p} and {q}, by up to half a texel"));
    }
    Ok(Comparison {
        matrix,
        differences,
    })
}

/// What a conversion that matches worlds does with directions, in words; none where both maps are of one world.
///
/// ```
/// use spheremap::{Map, compare::worlds};
/// let map = |name| Map::new(name);
/// let words = worlds(&map("latlong:blender")?, &map("cube:opengl")?).unwrap();
/// assert_eq!(
///     words,
///     "blender (+z up, +y ahead) → opengl (+y up, -z ahead): turned by 90° about -x"
/// );
/// assert_eq!(worlds(&map("latlong:threejs")?, &map("cube:opengl")?), None);
/// # Ok::<(), spheremap::Error>(())
/// ```
pub fn worlds(src: &Map, dst: &Map) -> Option<String> {
    let (from, to) = (src.world(), dst.world());
    if from == to {
        return None;
    }
    let title = |map: &Map| {
        let name = map.convention().unwrap_or(map.info().name);
        format!("{name} ({})", map.world().words())
    };
    let matrix = rows(from.to(to));
    let done = if determinant(matrix) > 0 {
        let (angle, axis) = angle_and_axis(matrix)?;
        format!("turned by {angle}° about {}", axis_words(axis))
    } else {
        let axes = from.to(to).to_string().replace(' ', ", ").replace('+', "");
        format!("(x, y, z) becomes ({axes}), another hand, so that nothing is mirrored")
    };
    Some(format!("{} → {}: {done}", title(src), title(dst)))
}

/// Maps of two formulas, or of one with two sets of parameters.
fn of_kinds(p: &Map, q: &Map) -> Comparison {
    let title = |map: &Map| {
        let parameters = map.info().parameters.iter().zip(map.parameters());
        let parameters =
            parameters.map(|(parameter, x)| format!(", {} {}", parameter.name, six_digits(*x)));
        format!("{}{}", map.info().name, parameters.collect::<String>())
    };
    let mut differences = vec![format!(
        "another kind of image: {} and {}; convert turns one into the other",
        title(p),
        title(q)
    )];
    let ahead = |map: &Map| signed_axis(map.axes().world[2], map.axes().negative[2]);
    if ahead(p) != ahead(q) {
        differences.push(format!(
            "the middle of the picture differs: {} and {}",
            ahead(p),
            ahead(q)
        ));
    }
    if p.faces().max(q.faces()) == 1 && p.mirrored()[0] != q.mirrored()[0] {
        differences.push("one is mirrored".to_owned());
    }
    if p.grid() != q.grid() {
        let (p, q) = (p.grid().name(), q.grid().name());
        differences.push(format!("grid differs: {p} and {q}"));
    }
    Comparison {
        matrix: None,
        differences,
    }
}

/// A number with six significant digits at most.
fn six_digits(x: f64) -> String {
    format!("{x:.5e}").parse::<f64>().unwrap_or(x).to_string()
}

fn signed_axis(axis: u8, negative: bool) -> String {
    let sign = if negative { '-' } else { '+' };
    format!("{sign}{}", ['x', 'y', 'z'][usize::from(axis) % 3])
}

/// Image coordinates of places inside each face that is stored, with its name.
fn cells(map: &Map) -> Vec<(String, Vec<f64>)> {
    if map.layout().is_none() {
        // Around the middle, where every map holds sphere.
        let uv = PLACES.as_flattened().iter().map(|x| 0.5 + 0.4 * (x - 0.5));
        return vec![("the image".to_owned(), uv.collect())];
    }
    let layout = map.face_layout();
    if map.faces() > 1 {
        let face = |k: usize| {
            let uv = PLACES.map(|[u, v]| [u, v, k as f64]);
            (format!("face {k}"), valid(map, uv.as_flattened()))
        };
        return (0..map.faces()).map(face).collect();
    }
    let size = [layout.columns, layout.rows].map(|n| n as f64);
    let cell = |j: usize, i: usize| {
        let uv = PLACES.map(|[u, v]| [(u + i as f64) / size[0], (v + j as f64) / size[1]]);
        (format!("cell ({i}, {j})"), valid(map, uv.as_flattened()))
    };
    (0..layout.rows)
        .flat_map(|j| (0..layout.columns).map(move |i| (j, i)))
        .map(|(j, i)| cell(j, i))
        .filter(|(_, uv)| !uv.is_empty())
        .collect()
}

/// Those of the coordinates that lie in the valid image.
fn valid(map: &Map, uv: &[f64]) -> Vec<f64> {
    let width = map.uv_width();
    let mut valid = vec![false; uv.len() / width];
    map.valid_numbers(uv, &mut valid);
    let places = uv.chunks(width).zip(valid).filter(|(_, valid)| *valid);
    places.flat_map(|(uv, _)| uv).copied().collect()
}

fn decoded(map: &Map, uv: &[f64]) -> Vec<[f64; 3]> {
    let mut directions = vec![[0.0; 3]; uv.len() / map.uv_width()];
    map.decode_numbers(None, uv, directions.as_flattened_mut());
    directions
}

/// The signed permutation M with e = M d.
fn between(d: &[[f64; 3]], e: &[[f64; 3]]) -> SignedPermutation {
    [0, 1, 2].map(|i| {
        // Component i of e is a component of d, but for its sign.
        let far = [0, 1, 2].map(|k| {
            let pairs = d.iter().zip(e);
            let off = pairs.map(|(d, e)| (d[k].abs() - e[i].abs()).abs());
            off.fold(0.0, f64::max)
        });
        let k = (1..3).fold(0, |best, k| if far[k] < far[best] { k } else { best });
        let product: f64 = d.iter().zip(e).map(|(d, e)| d[k] * e[i]).sum();
        let mut row = [0; 3];
        row[k] = if product > 0.0 { 1 } else { -1 };
        row
    })
}

/// Which faces of `q` show what the faces of `p` show, as their axes say it.
fn order(p: &Map, q: &Map) -> Option<Vec<usize>> {
    if p.faces() != q.faces() || p.faces() < 2 {
        return None;
    }
    let matrix = of_axes(p, q).map(|row| row.map(f64::from));
    let shown: Vec<_> = cells(q).iter().map(|(_, uv)| decoded(q, uv)).collect();
    let find = |uv: &[f64]| {
        let turned = |d: [f64; 3]| matrix.map(|row| row[0] * d[0] + row[1] * d[1] + row[2] * d[2]);
        let wanted: Vec<[f64; 3]> = decoded(p, uv).into_iter().map(turned).collect();
        shown.iter().position(|shown| same(&wanted, shown))
    };
    cells(p).iter().map(|(_, uv)| find(uv)).collect()
}

/// Whether directions are the same but for rounding, with room for formulas of single precision.
fn same(a: &[[f64; 3]], b: &[[f64; 3]]) -> bool {
    let mut pairs = a.as_flattened().iter().zip(b.as_flattened());
    a.len() == b.len() && pairs.all(|(a, b)| (a - b).abs() <= 1e-8 + 1e-5 * b.abs())
}

/// What the axes of two maps alone say.
fn of_axes(p: &Map, q: &Map) -> SignedPermutation {
    product(rows(q.axes().inverse()), rows(p.axes()))
}

/// The signed permutation from the world to the view frame.
fn rows(axes: Axes) -> SignedPermutation {
    [0, 1, 2].map(|k| {
        let mut row = [0; 3];
        row[usize::from(axes.world[k])] = if axes.negative[k] { -1 } else { 1 };
        row
    })
}

fn product(a: SignedPermutation, b: SignedPermutation) -> SignedPermutation {
    a.map(|row| [0, 1, 2].map(|k| row[0] * b[0][k] + row[1] * b[1][k] + row[2] * b[2][k]))
}

fn determinant(m: SignedPermutation) -> i8 {
    let minor = |i: usize, j: usize| m[1][i] * m[2][j] - m[1][j] * m[2][i];
    m[0][0] * minor(1, 2) - m[0][1] * minor(0, 2) + m[0][2] * minor(0, 1)
}

fn trace(m: SignedPermutation) -> i8 {
    m[0][0] + m[1][1] + m[2][2]
}

/// The axis that is up in the world of a map, and its sign.
fn up(map: &Map) -> (usize, i8) {
    let up = map.world().up().as_bytes();
    (
        usize::from(up[1] - b'x'),
        if up[0] == b'-' { -1 } else { 1 },
    )
}

/// A signed permutation as a mirror, if need be, and turns; empty for none.
fn words(whole: SignedPermutation, up: (usize, i8)) -> String {
    if whole == IDENTITY {
        return String::new();
    }
    let (mut parts, mut matrix) = (Vec::new(), whole);
    if determinant(whole) < 0 {
        let mirror = |axis: usize| {
            let mut mirror = IDENTITY;
            mirror[axis][axis] = -1;
            product(whole, mirror)
        };
        let others = (0..3).filter(|axis| *axis != up.0).chain([up.0]);
        let better = |best: usize, axis: usize| {
            if trace(mirror(axis)) > trace(mirror(best)) {
                axis
            } else {
                best
            }
        };
        let axis = others.reduce(better).unwrap_or(0);
        parts.push(format!("mirrored ({} changes sign)", ['x', 'y', 'z'][axis]));
        matrix = mirror(axis);
    }
    parts.extend(turn(matrix, up));
    let text = parts.join(", then ");
    let rises = whole.map(|row| row[up.0] * up.1);
    let axis = rises.iter().position(|x| *x != 0).unwrap_or(0);
    if (axis, rises[axis]) == up {
        return text;
    }
    let was = signed_axis(up.0 as u8, up.1 < 0);
    let goes = signed_axis(axis as u8, rises[axis] < 0);
    format!("{text}: {was}, which is up, becomes {goes}")
}

/// A rotation of the cube in words: yaw about up, or a turn about its own axis; none for none.
fn turn(r: SignedPermutation, up: (usize, i8)) -> Option<String> {
    let (angle, axis) = angle_and_axis(r)?;
    if axis.iter().filter(|x| **x != 0).count() == 1 && axis[up.0] != 0 {
        let sign = if angle == 180 { 1 } else { axis[up.0] * up.1 };
        return Some(format!("yaw {}°", i32::from(sign) * angle));
    }
    Some(format!("turned by {angle}° about {}", axis_words(axis)))
}

/// The angle of a rotation of the cube, in degrees, and its axis, the right-handed way; none for none.
fn angle_and_axis(r: SignedPermutation) -> Option<(i32, [i8; 3])> {
    // The trace is 1 + 2 cos of the angle.
    let angle = match trace(r) {
        3 => return None,
        1 => 90,
        0 => 120,
        _ => 180,
    };
    let axis = if angle == 180 {
        // r + 1 = 2 a aᵀ: the first column that is not 0 is along a, and begins with a positive number.
        let column = |k: usize| [0, 1, 2].map(|i| (r[i][k] + i8::from(i == k)).signum());
        (0..3).map(column).find(|column| *column != [0; 3])?
    } else {
        [r[2][1] - r[1][2], r[0][2] - r[2][0], r[1][0] - r[0][1]].map(i8::signum)
    };
    Some((angle, axis))
}

fn axis_words(axis: [i8; 3]) -> String {
    let along = axis.iter().filter(|x| **x != 0).count();
    match axis.iter().position(|x| *x != 0) {
        Some(k) if along == 1 => signed_axis(k as u8, axis[k] < 0),
        _ => format!("({:+} {:+} {:+})", axis[0], axis[1], axis[2]),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::map::MapOptions;

    fn map(name: &str) -> Map {
        Map::new(name).unwrap()
    }

    /// All maps of one formula: what the matrix says holds for the axes that made them.
    #[test]
    fn axes_are_found_by_decoding() {
        for name in ["latlong", "octahedral", "mollweide", "cube"] {
            let with = |axes| {
                let options = MapOptions {
                    axes: Some(axes),
                    ..MapOptions::default()
                };
                Map::with(name, options).unwrap()
            };
            let (p, q) = (with("+x -y -z"), with("-z +x -y"));
            let found = compare(&p, &q).unwrap();
            assert_eq!(found.matrix, Some(of_axes(&p, &q)), "{name}");
            assert_eq!(compare(&p, &p).unwrap().differences, [""; 0]);
            assert_eq!(
                found.mirrored(),
                Some(p.axes().mirrored() != q.axes().mirrored())
            );
        }
    }

    #[test]
    fn matrices_in_words() {
        let up = (1, 1);
        let said = |m| words(m, up);
        assert_eq!(said(IDENTITY), "");
        assert_eq!(said([[0, 0, 1], [0, 1, 0], [-1, 0, 0]]), "yaw 90°");
        assert_eq!(said([[-1, 0, 0], [0, 1, 0], [0, 0, -1]]), "yaw 180°");
        assert_eq!(
            said([[-1, 0, 0], [0, 1, 0], [0, 0, 1]]),
            "mirrored (x changes sign)"
        );
        assert_eq!(
            said([[1, 0, 0], [0, 0, -1], [0, 1, 0]]),
            "turned by 90° about +x: +y, which is up, becomes +z"
        );
        assert_eq!(
            said([[0, 0, 1], [1, 0, 0], [0, 1, 0]]),
            "turned by 120° about (+1 +1 +1): +y, which is up, becomes +z"
        );
    }

    #[test]
    fn worlds_in_words() {
        let said = |a, b| worlds(&map(a), &map(b));
        let hand = "blender (+z up, +y ahead) → unity (+y up, +z ahead, left-handed): \
                    (x, y, z) becomes (x, z, y), another hand, so that nothing is mirrored";
        assert_eq!(said("latlong:blender", "cube:unity").unwrap(), hand);
        let behind =
            "latlong (+y up, -z ahead) → mitsuba (+y up, +z ahead): turned by 180° about +y";
        assert_eq!(said("latlong", "latlong:mitsuba").unwrap(), behind);
        assert_eq!(said("cube:unity", "latlong:py360convert"), None);
    }

    #[test]
    fn other_kinds_have_no_matrix() {
        let found = compare(&map("latlong"), &map("cube")).unwrap();
        assert_eq!((found.matrix, found.mirrored()), (None, None));
        assert!(found.differences[0].starts_with("another kind of image: latlong and cube"));
        assert_eq!(six_digits(63.434_948_822), "63.4349");
    }
}
