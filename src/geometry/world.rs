//! The world that directions live in, and what takes one world to another.
//!
//! Programs do not agree where up is, what lies ahead, or whether x, y, z are a left hand or a right one. A [`World`] says
//! which axes point to the right, up and ahead of a person who stands in it. Two worlds are *matched* by the signed
//! permutation that takes right to right, up to up and ahead to ahead: what the person sees does not change, so that nothing is
//! tilted and nothing mirrored, whatever becomes of the numbers (x, y, z). Between a right-handed world and a left-handed one its
//! determinant is -1.
//!
//! "Ahead" is what a camera of the program looks along that nobody has turned; the table of conventions says what it is of
//! each program, and what it was taken from where a program has no camera.

use crate::error::Error;
use crate::geometry::axes::Axes;
use std::fmt;
use std::str::FromStr;

/// The world that directions live in: the axes that point to the right, up and ahead of a person in it.
///
/// ```
/// use spheremap::World;
/// let unreal = World::new("+z", "+x", true);
/// assert_eq!((unreal.right(), unreal.up(), unreal.ahead()), ("+y", "+z", "+x"));
/// assert_eq!(unreal.to_string(), "+y +z +x");
/// assert_eq!("+y +z +x".parse::<World>()?, unreal);
/// assert_eq!(World::OURS.to_string(), "+x +y -z");
/// # Ok::<(), spheremap::Error>(())
/// ```
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct World {
    /// (x, y, z) to (right, up, ahead).
    frame: Axes,
}

impl World {
    /// The world of names without a convention: +y up, -z ahead, right-handed.
    pub const OURS: World = World::new("+y", "-z", false);

    /// The world in which these axes point up and ahead.
    ///
    /// # Panics
    /// For what is no axis, or one axis given twice.
    ///
    /// ```
    /// assert!(spheremap::World::new("+y", "+z", true).left_handed());
    /// ```
    pub const fn new(up: &str, ahead: &str, left_handed: bool) -> World {
        let ((up, down), (ahead, behind)) = (axis(up), axis(ahead));
        assert!(up != ahead, "one axis is not both up and ahead");
        let right = 3 - up - ahead;
        // Of a right hand, right is ahead × up.
        let cyclic = (ahead + 1) % 3 == up;
        World {
            frame: Axes {
                world: [right, up, ahead],
                negative: [down ^ behind ^ !cyclic ^ left_handed, down, behind],
            },
        }
    }

    /// (x, y, z) to (right, up, ahead).
    pub(crate) fn frame(self) -> Axes {
        self.frame
    }

    /// The axis that points to the right.
    ///
    /// ```
    /// assert_eq!(spheremap::World::OURS.right(), "+x");
    /// ```
    pub fn right(self) -> &'static str {
        self.name(0)
    }

    /// The axis that points up.
    ///
    /// ```
    /// assert_eq!(spheremap::World::OURS.up(), "+y");
    /// ```
    pub fn up(self) -> &'static str {
        self.name(1)
    }

    /// The axis that points ahead.
    ///
    /// ```
    /// assert_eq!(spheremap::World::OURS.ahead(), "-z");
    /// ```
    pub fn ahead(self) -> &'static str {
        self.name(2)
    }

    /// Whether x, y, z are a left-handed frame.
    ///
    /// ```
    /// assert!(!spheremap::World::OURS.left_handed());
    /// ```
    pub fn left_handed(self) -> bool {
        // (right, up, ahead) itself is a left hand.
        !self.frame.mirrored()
    }

    /// The signed permutation that takes directions of this world to those of another, as a person sees them.
    ///
    /// ```
    /// use spheremap::World;
    /// use spheremap::glam::DVec3;
    /// let blender = World::new("+z", "+y", false);
    /// assert_eq!(blender.to(World::OURS).matrix() * DVec3::Z, DVec3::Y); // up
    /// assert_eq!(blender.to(World::OURS).matrix() * DVec3::Y, DVec3::NEG_Z); // ahead
    /// ```
    pub fn to(self, other: World) -> Axes {
        other.frame.inverse().after(self.frame)
    }

    /// Up, ahead and a left hand, in words.
    pub(crate) fn words(self) -> String {
        let hand = if self.left_handed() {
            ", left-handed"
        } else {
            ""
        };
        format!("{} up, {} ahead{hand}", self.up(), self.ahead())
    }

    fn name(self, k: usize) -> &'static str {
        let names = [["+x", "-x"], ["+y", "-y"], ["+z", "-z"]];
        names[usize::from(self.frame.world[k])][usize::from(self.frame.negative[k])]
    }
}

/// The number of an axis such as "+x", and whether it is a negative one.
const fn axis(name: &str) -> (u8, bool) {
    match name.as_bytes() {
        [sign @ (b'+' | b'-'), letter @ b'x'..=b'z'] => (*letter - b'x', *sign == b'-'),
        _ => panic!("an axis is a sign and a letter, as in +x"),
    }
}

impl fmt::Display for World {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        self.frame.fmt(f)
    }
}

impl FromStr for World {
    type Err = Error;

    /// The axes that point to the right, up and ahead, as in "+x +y -z".
    fn from_str(text: &str) -> Result<World, Error> {
        let frame = Axes::of_world(text)?;
        Ok(World { frame })
    }
}

/// What a conversion does where the worlds of its two maps differ.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Worlds {
    /// What is up stays up, what is ahead stays ahead, and nothing is mirrored.
    #[default]
    Match,
    /// (x, y, z) stays (x, y, z), whatever the programs mean by it.
    Literal,
}

impl Worlds {
    /// The one of this name, "match" or "literal".
    ///
    /// # Errors
    /// No other name is one.
    ///
    /// ```
    /// use spheremap::Worlds;
    /// assert_eq!(Worlds::find("literal")?, Worlds::Literal);
    /// assert!(Worlds::find("same").is_err());
    /// # Ok::<(), spheremap::Error>(())
    /// ```
    pub fn find(name: &str) -> Result<Worlds, Error> {
        match name {
            "match" => Ok(Worlds::Match),
            "literal" => Ok(Worlds::Literal),
            _ => Err(Error::unknown("world", name, &["match", "literal"])),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn worlds_print_as_they_parse_and_know_their_hand() {
        for up in ["+x", "-x", "+y", "-y", "+z", "-z"] {
            for ahead in ["+x", "-x", "+y", "-y", "+z", "-z"] {
                if up[1..] == ahead[1..] {
                    continue;
                }
                for left in [false, true] {
                    let world = World::new(up, ahead, left);
                    assert_eq!((world.up(), world.ahead()), (up, ahead));
                    assert_eq!(world.left_handed(), left);
                    assert_eq!(world.to_string().parse::<World>().unwrap(), world);
                    assert_eq!(world.to(world).to_string(), "+x +y +z");
                }
            }
        }
        assert_eq!(World::OURS.right(), "+x");
        assert_eq!(World::new("+y", "+z", true).right(), "+x");
        assert!("+x +y".parse::<World>().is_err());
    }
}
