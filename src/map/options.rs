//! What a caller may say about a map besides its name.

/// What may be said about a map besides its projection's name; what is not said is the convention's, else the projection's own.
///
/// ```
/// use spheremap::{Map, MapOptions};
/// let options = MapOptions::new().parameters(&[("fov", 75.0), ("aspect", 16.0 / 9.0)]);
/// let camera = Map::with("perspective", options)?;
/// assert_eq!(camera.face_size(90), (160, 90));
/// # Ok::<(), spheremap::Error>(())
/// ```
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[non_exhaustive]
pub struct MapOptions<'a> {
    /// A program's name.
    pub convention: Option<&'a str>,
    /// Which world axes point right, down and forward.
    pub axes: Option<&'a str>,
    /// Where texel centers lie.
    pub grid: Option<&'a str>,
    /// How several faces are laid out.
    pub layout: Option<&'a str>,
    /// Parameters by name.
    pub parameters: &'a [(&'a str, f64)],
}

impl<'a> MapOptions<'a> {
    /// Options that say nothing.
    ///
    /// ```
    /// use spheremap::{Map, MapOptions};
    /// assert_eq!(Map::with("latlong", MapOptions::new())?, Map::new("latlong")?);
    /// # Ok::<(), spheremap::Error>(())
    /// ```
    pub fn new() -> MapOptions<'a> {
        MapOptions::default()
    }

    /// These options with a convention: the map is laid out as this program does it.
    ///
    /// ```
    /// use spheremap::{Map, MapOptions};
    /// let map = Map::with("latlong", MapOptions::new().convention("mitsuba"))?;
    /// assert_eq!(map, Map::new("latlong:mitsuba")?);
    /// # Ok::<(), spheremap::Error>(())
    /// ```
    pub fn convention(self, name: &'a str) -> MapOptions<'a> {
        let convention = Some(name);
        MapOptions { convention, ..self }
    }

    /// These options with axes: the world axes that point right, down and forward.
    ///
    /// ```
    /// use spheremap::{Map, MapOptions};
    /// let map = Map::with("latlong", MapOptions::new().axes("+y -z +x"))?;
    /// assert_eq!(map.axes().to_string(), "+y -z +x");
    /// # Ok::<(), spheremap::Error>(())
    /// ```
    pub fn axes(self, axes: &'a str) -> MapOptions<'a> {
        let axes = Some(axes);
        MapOptions { axes, ..self }
    }

    /// These options with a grid, one of "centers", "corners" and "corners-v": where texel centers lie.
    ///
    /// ```
    /// use spheremap::{Grid, Map, MapOptions};
    /// let map = Map::with("latlong", MapOptions::new().grid("corners-v"))?;
    /// assert_eq!(map.grid(), Grid::CornersV);
    /// # Ok::<(), spheremap::Error>(())
    /// ```
    pub fn grid(self, name: &'a str) -> MapOptions<'a> {
        let grid = Some(name);
        MapOptions { grid, ..self }
    }

    /// These options with a layout of several faces, such as "faces", "strip" or a cube's "cross".
    ///
    /// ```
    /// use spheremap::{Map, MapOptions};
    /// let map = Map::with("cube", MapOptions::new().layout("cross"))?;
    /// assert_eq!((map.faces(), map.uv_width()), (1, 2)); // one image, with no face in its coordinates
    /// # Ok::<(), spheremap::Error>(())
    /// ```
    pub fn layout(self, name: &'a str) -> MapOptions<'a> {
        let layout = Some(name);
        MapOptions { layout, ..self }
    }

    /// These options with parameters by name, such as a field of view in degrees.
    ///
    /// ```
    /// use spheremap::{Map, MapOptions};
    /// let map = Map::with("equisolid", MapOptions::new().parameters(&[("fov", 220.0)]))?;
    /// assert_eq!(map.parameters(), [220.0]);
    /// # Ok::<(), spheremap::Error>(())
    /// ```
    pub fn parameters(self, parameters: &'a [(&'a str, f64)]) -> MapOptions<'a> {
        MapOptions { parameters, ..self }
    }
}
