//! Axes and rotations: from the world to the view frame of an image.
//!
//! Formulas live in the view frame: x to the image's right, y down, z toward its center. `Axes` says
//! which signed world axes those are, as in "+x -y -z"; it is one of 48 signed permutations, and -1 as its
//! determinant means that the picture is mirrored as seen from inside, in a right-handed world. Signed
//! permutations are applied exactly (a sign flip rounds nothing, and keeps ±0 and NaN), general
//! rotations as a 3×3 matrix.
//!
//! A rotation turns the map in the world, like the `to_world` of a renderer's environment light: a
//! direction d looks up what the unturned map shows at Rᵀd.

use crate::error::Error;
use crate::number::real::Real;
use glam::{DMat3, DVec3};
use std::fmt;
use std::str::FromStr;

/// The signed world axes that point right, down and forward.
///
/// # Panics
/// What takes them expects them to be a permutation, as those are that were parsed: where a number of `world` is more than 2, it
/// may panic.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct Axes {
    /// `world[k]` is the number of the world axis along view axis k.
    pub world: [u8; 3],
    /// Whether view axis k runs against it.
    pub negative: [bool; 3],
}

impl Axes {
    /// The sign of each view axis, ±1.
    ///
    /// ```
    /// use spheremap::geometry::Axes;
    /// let axes: Axes = "+x -y -z".parse()?;
    /// assert_eq!(axes.signs(), [1.0, -1.0, -1.0]);
    /// # Ok::<(), spheremap::Error>(())
    /// ```
    pub fn signs(self) -> [f64; 3] {
        self.negative
            .map(|negative| if negative { -1.0 } else { 1.0 })
    }

    /// The view axis that lies along each world axis.
    ///
    /// ```
    /// use spheremap::geometry::Axes;
    /// let axes: Axes = "+y -z +x".parse()?;
    /// assert_eq!(axes.inverse().inverse(), axes);
    /// assert_eq!(axes.inverse().to_string(), "+z +x -y");
    /// # Ok::<(), spheremap::Error>(())
    /// ```
    pub fn inverse(self) -> Axes {
        let mut inverse = self;
        for (view, &world) in self.world.iter().enumerate() {
            inverse.world[world as usize] = view as u8;
            inverse.negative[world as usize] = self.negative[view];
        }
        inverse
    }

    /// The axes of a map behind another signed permutation: `first` is applied to a direction, then these.
    ///
    /// ```
    /// use spheremap::geometry::Axes;
    /// let axes: Axes = "+y -z +x".parse()?;
    /// assert_eq!(axes.after(axes.inverse()).to_string(), "+x +y +z");
    /// assert_eq!(axes.after("-x +z +y".parse()?).to_string(), "+z -y -x");
    /// # Ok::<(), spheremap::Error>(())
    /// ```
    pub fn after(self, first: Axes) -> Axes {
        let through = |k: usize| usize::from(self.world[k]);
        Axes {
            world: [0, 1, 2].map(|k| first.world[through(k)]),
            negative: [0, 1, 2].map(|k| self.negative[k] ^ first.negative[through(k)]),
        }
    }

    /// The matrix that takes world directions to the view frame.
    ///
    /// ```
    /// use spheremap::geometry::Axes;
    /// use spheremap::glam::DVec3;
    /// let axes: Axes = "+x -y -z".parse()?;
    /// assert_eq!(axes.matrix() * DVec3::Y, DVec3::NEG_Y); // up is against the rows
    /// # Ok::<(), spheremap::Error>(())
    /// ```
    pub fn matrix(self) -> DMat3 {
        let rows = [0, 1, 2].map(|k| {
            let mut row = [0.0; 3];
            row[self.world[k] as usize] = self.signs()[k];
            DVec3::from(row)
        });
        DMat3::from_cols(rows[0], rows[1], rows[2]).transpose()
    }

    /// Whether a view frame (right, down, forward) with these axes is left-handed.
    ///
    /// ```
    /// use spheremap::geometry::Axes;
    /// assert!(!"+x -y -z".parse::<Axes>()?.mirrored()); // a photo
    /// assert!("+x -y +z".parse::<Axes>()?.mirrored()); // a cube map of OpenGL
    /// # Ok::<(), spheremap::Error>(())
    /// ```
    pub fn mirrored(self) -> bool {
        self.matrix().determinant() < 0.0
    }
}

impl FromStr for Axes {
    type Err = Error;

    fn from_str(text: &str) -> Result<Self, Error> {
        Axes::parse(text, "right, down and forward").map_err(|why| Error::Axes {
            text: text.to_owned(),
            why,
        })
    }
}

impl Axes {
    /// The axes of a world that point to the right, up and ahead of a person in it.
    ///
    /// # Errors
    /// They are no three signed axes.
    pub(crate) fn of_world(text: &str) -> Result<Self, Error> {
        Axes::parse(text, "right, up and ahead").map_err(|why| Error::World {
            text: text.to_owned(),
            why,
        })
    }

    /// `three` are what they stand for; or why they are none.
    fn parse(text: &str, three: &str) -> Result<Self, String> {
        let error = str::to_owned;
        let parts: Vec<&str> = text.split_whitespace().collect();
        if parts.len() != 3 {
            return Err(format!("there must be three, for {three}"));
        }
        let mut axes = Axes {
            world: [0; 3],
            negative: [false; 3],
        };
        for (k, part) in parts.iter().enumerate() {
            let mut letters = part.chars();
            axes.negative[k] = match letters.next() {
                Some('+') => false,
                Some('-') => true,
                _ => return Err(error("each needs a sign, as in \"+x -y -z\"")),
            };
            axes.world[k] = match (letters.next(), letters.next()) {
                (Some('x'), None) => 0,
                (Some('y'), None) => 1,
                (Some('z'), None) => 2,
                _ => return Err(error("each must be x, y or z")),
            };
        }
        let mut seen = axes.world;
        seen.sort_unstable();
        if seen != [0, 1, 2] {
            return Err(error("x, y and z must each appear once"));
        }
        Ok(axes)
    }
}

impl fmt::Display for Axes {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        for k in 0..3 {
            let sign = if self.negative[k] { '-' } else { '+' };
            let axis = ['x', 'y', 'z'][self.world[k] as usize];
            write!(f, "{}{sign}{axis}", if k > 0 { " " } else { "" })?;
        }
        Ok(())
    }
}

/// What takes world directions to the view frame.
#[derive(Clone, Copy, Debug)]
pub enum Rotation {
    /// A signed permutation.
    Axes(Axes),
    /// Any rotation, mirrored or not; row by row.
    Matrix([[f64; 3]; 3]),
}

impl Rotation {
    /// World to view for an image with these axes that `rotation` has turned in the world.
    pub fn new(axes: Axes, rotation: Option<DMat3>) -> Rotation {
        match rotation {
            None => Rotation::Axes(axes),
            Some(r) => Rotation::Matrix(rows(axes.matrix() * r.transpose())),
        }
    }

    /// View to world.
    pub fn inverse(self) -> Rotation {
        match self {
            Rotation::Axes(axes) => Rotation::Axes(axes.inverse()),
            Rotation::Matrix(m) => Rotation::Matrix([0, 1, 2].map(|i| [m[0][i], m[1][i], m[2][i]])),
        }
    }

    /// One direction, turned.
    pub fn apply(self, d: [f64; 3]) -> [f64; 3] {
        match self {
            Rotation::Axes(axes) => {
                let signs = axes.signs();
                [0, 1, 2].map(|k| signs[k] * d[axes.world[k] as usize])
            }
            Rotation::Matrix(m) => m.map(|row| row[0] * d[0] + row[1] * d[1] + row[2] * d[2]),
        }
    }
}

/// The rows of a matrix.
///
/// ```
/// use spheremap::geometry::{rotation, rows};
/// let quarter = [[0.0, 0.0, 1.0], [0.0, 1.0, 0.0], [-1.0, 0.0, 0.0]];
/// assert_eq!(rows(rotation(quarter)?), quarter);
/// # Ok::<(), spheremap::Error>(())
/// ```
pub fn rows(m: DMat3) -> [[f64; 3]; 3] {
    m.transpose().to_cols_array_2d()
}

/// A proper rotation from its rows, or why it is none. float32 matrices pass: the tolerance is a few
/// of their rounding units.
///
/// # Errors
/// The rows are not orthonormal, or mirror.
///
/// ```
/// use spheremap::geometry::rotation;
/// assert!(rotation([[0.0, 0.0, 1.0], [0.0, 1.0, 0.0], [-1.0, 0.0, 0.0]]).is_ok());
/// assert!(rotation([[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, -1.0]]).is_err());
/// ```
pub fn rotation(rows: [[f64; 3]; 3]) -> Result<DMat3, Error> {
    let m = DMat3::from_cols_array_2d(&rows).transpose();
    expect_rotation(Some(m))?;
    Ok(m)
}

/// An error if a matrix, where there is one, is no proper rotation: by the rules of [`rotation`].
pub(crate) fn expect_rotation(matrix: Option<DMat3>) -> Result<(), Error> {
    let Some(m) = matrix else {
        return Ok(());
    };
    let defect = m * m.transpose() - DMat3::IDENTITY;
    if !defect
        .to_cols_array()
        .iter()
        .all(|entry| entry.abs() <= 1e-5)
    {
        return Err(Error::Rotation("its rows must be orthonormal".to_owned()));
    }
    if m.determinant() < 0.0 {
        return Err(Error::Rotation(
            "its determinant is -1, a mirror image; use `axes` for that".to_owned(),
        ));
    }
    Ok(())
}

/// The rotation of these angles in degrees: roll about +z, then pitch about +x, then yaw about +y, each
/// right-handed.
///
/// ```
/// use spheremap::geometry::from_angles;
/// use spheremap::glam::DVec3;
/// let turned = from_angles(90.0, 0.0, 0.0) * DVec3::NEG_Z; // what lay ahead lies to the left
/// assert_eq!(turned, DVec3::NEG_X);
/// ```
pub fn from_angles(yaw: f64, pitch: f64, roll: f64) -> DMat3 {
    // In half turns, right angles are exact.
    let [(sy, cy), (sx, cx), (sz, cz)] =
        [yaw, pitch, roll].map(|degrees| f64::sin_cos_half_turns(degrees % 360.0 / 180.0));
    let of_rows = |rows| DMat3::from_cols_array_2d(&rows).transpose();
    let about_y = of_rows([[cy, 0.0, sy], [0.0, 1.0, 0.0], [-sy, 0.0, cy]]);
    let about_x = of_rows([[1.0, 0.0, 0.0], [0.0, cx, -sx], [0.0, sx, cx]]);
    let about_z = of_rows([[cz, -sz, 0.0], [sz, cz, 0.0], [0.0, 0.0, 1.0]]);
    about_y * about_x * about_z
}

#[cfg(test)]
mod tests {
    use super::*;

    fn all() -> Vec<Axes> {
        let mut all = Vec::new();
        for order in [
            [0, 1, 2],
            [0, 2, 1],
            [1, 0, 2],
            [1, 2, 0],
            [2, 0, 1],
            [2, 1, 0],
        ] {
            for bits in 0..8 {
                let negative = [bits & 1 != 0, bits & 2 != 0, bits & 4 != 0];
                all.push(Axes {
                    world: order,
                    negative,
                });
            }
        }
        all
    }

    #[test]
    fn axes_print_as_they_parse_and_invert() {
        assert_eq!(all().len(), 48);
        for axes in all() {
            assert_eq!(axes.to_string().parse::<Axes>().unwrap(), axes);
            let d = [1.0, -2.0, 3.0];
            let turned = Rotation::Axes(axes).apply(d);
            assert_eq!(Rotation::Axes(axes).inverse().apply(turned), d);
            assert_eq!(Rotation::Matrix(rows(axes.matrix())).apply(d), turned);
        }
        assert_eq!(all().iter().filter(|axes| axes.mirrored()).count(), 24);
    }

    #[test]
    fn a_photo_is_not_mirrored_and_the_opengl_cube_is() {
        assert!(!"+x -y -z".parse::<Axes>().unwrap().mirrored());
        assert!("+x -y +z".parse::<Axes>().unwrap().mirrored());
    }

    #[test]
    fn bad_axes_say_why() {
        for (text, why) in [
            ("+x -y", "three"),
            ("x y z", "sign"),
            ("+x -y +w", "x, y or z"),
            ("+x -x +z", "each appear once"),
        ] {
            assert!(
                text.parse::<Axes>().unwrap_err().to_string().contains(why),
                "{text}"
            );
        }
    }

    #[test]
    fn rotations_are_checked() {
        assert!(rotation(rows(from_angles(10.0, 20.0, 30.0))).is_ok());
        assert!(rotation([[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, -1.0]]).is_err());
        assert!(rotation([[f64::NAN; 3]; 3]).is_err());
        assert!(rotation([[2.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]]).is_err());
    }
}
