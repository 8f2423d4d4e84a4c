//! A map from its projection's type.

use crate::error::Error;
use crate::map::Map;
use crate::map::options::MapOptions;
use crate::projections::Projection;
use std::str::FromStr;

impl Map {
    /// The map of a projection by its type, for one that takes parameters or where options are wanted.
    ///
    /// # Errors
    /// As [`Map::with`].
    ///
    /// ```
    /// use spheremap::projections::Perspective;
    /// use spheremap::{Map, MapOptions};
    /// let camera = Map::of::<Perspective>(MapOptions::new().parameters(&[("fov", 75.0)]))?;
    /// assert_eq!(camera.parameters(), [75.0, 1.0, 0.0, 0.0]); // fov, aspect, cx, cy
    /// # Ok::<(), spheremap::Error>(())
    /// ```
    pub fn of<P: Projection>(options: MapOptions<'_>) -> Result<Map, Error> {
        Map::with(P::INFO.name, options)
    }
}

/// The map of a projection without parameters; one that takes some does not compile, and is made by [`Map::of`].
///
/// ```
/// use spheremap::Map;
/// use spheremap::projections::Octahedral;
/// assert_eq!(Map::from(Octahedral), Map::new("octahedral")?);
/// # Ok::<(), spheremap::Error>(())
/// ```
impl<P: Projection> From<P> for Map {
    fn from(_: P) -> Map {
        const {
            assert!(
                P::INFO.parameters.is_empty(),
                "a projection that takes parameters is made by `Map::of`"
            );
        }
        match Map::of::<P>(MapOptions::default()) {
            Ok(map) => map,
            Err(error) => unreachable!("a projection's own defaults are valid: {error}"),
        }
    }
}

/// The map of a name, as [`Map::new`] makes it.
impl FromStr for Map {
    type Err = Error;

    fn from_str(name: &str) -> Result<Map, Error> {
        Map::new(name)
    }
}
