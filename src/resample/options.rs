//! What a lookup or a conversion may be asked for.

use crate::error::Error;
use crate::geometry::axes::expect_rotation;
use crate::geometry::world::Worlds;
use crate::image::texel::Texel;
use crate::resample::filters::Filter;
use crate::resample::window::Window;
use glam::DMat3;

/// The value where an image holds nothing.
#[derive(Clone, Debug, Default, PartialEq)]
#[non_exhaustive]
pub enum Fill {
    /// NaN, or 0 for integers.
    #[default]
    Nothing,
    /// One number for all channels.
    All(f64),
    /// One number for each channel.
    Channels(Vec<f64>),
}

impl From<f64> for Fill {
    fn from(value: f64) -> Fill {
        Fill::All(value)
    }
}

impl From<Vec<f64>> for Fill {
    fn from(values: Vec<f64>) -> Fill {
        Fill::Channels(values)
    }
}

impl From<&[f64]> for Fill {
    fn from(values: &[f64]) -> Fill {
        Fill::Channels(values.to_vec())
    }
}

impl Fill {
    /// It as a texel of so many channels; an error where it has another number of them or T cannot hold it.
    pub(crate) fn texel<T: Texel>(&self, channels: usize) -> Result<Vec<T>, Error> {
        let values = match self {
            Fill::Nothing => return Ok(vec![T::from_f64(T::NOTHING); channels]),
            Fill::All(value) => &vec![*value; channels],
            Fill::Channels(values) => values,
        };
        if values.len() != channels {
            return Err(Error::Shape(format!(
                "Expected `fill` to have one number for each of {channels} channels, got {}.",
                values.len()
            )));
        }
        if let Some(value) = values.iter().find(|value| !T::fits(**value)) {
            return Err(Error::Contradiction(format!(
                "`fill` {value} is no value of {}.",
                T::NAME
            )));
        }
        Ok(values.iter().map(|value| T::from_f64(*value)).collect())
    }
}

/// How an image is looked up or converted.
///
/// ```
/// use spheremap::resample::{Filter, Options};
///
/// let options = Options::new().filter(Filter::Area).fill(0.0);
/// assert!(options.antialias && !options.skipna);
/// ```
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub struct Options {
    /// How a value is made of texels; bilinear by default.
    pub filter: Filter,
    /// Turns the content in its own world, that of what is looked up; none by default. A matrix that is no rotation is an
    /// [`Error::Rotation`] of whatever takes these options.
    pub rotation: Option<DMat3>,
    /// What a conversion does where the worlds of its maps differ; by default they are matched.
    pub worlds: Worlds,
    /// Whether a texel that sees more than one texel of the source is the mean of what it sees; by default it is. It does
    /// not concern filters that are not [`antialiased`](crate::resample::filters::claims::FilterInfo::antialiased), nor
    /// lookups of directions.
    pub antialias: bool,
    /// The value where there is none; by default [`Fill::Nothing`], NaN for floats and 0 for integers. (In Python it is 0.)
    pub fill: Fill,
    /// The channel that says how opaque a texel is, if there is one: the others are then means by opacity.
    pub alpha: Option<usize>,
    /// Whether NaN and infinity have no weight. By default they spread to all that they touch.
    pub skipna: bool,
    /// The part of a target that a conversion makes, with the bits of the whole; all by default.
    pub window: Option<Window>,
}

impl Default for Options {
    fn default() -> Options {
        Options {
            filter: Filter::Bilinear,
            rotation: None,
            worlds: Worlds::Match,
            antialias: true,
            fill: Fill::Nothing,
            alpha: None,
            skipna: false,
            window: None,
        }
    }
}

impl Options {
    /// The default ones.
    ///
    /// ```
    /// use spheremap::resample::{Filter, Options};
    /// assert_eq!(Options::new().filter, Filter::Bilinear);
    /// ```
    pub fn new() -> Options {
        Options::default()
    }

    /// With another [`Options::filter`].
    ///
    /// ```
    /// use spheremap::resample::{Filter, Options};
    /// assert_eq!(Options::new().filter(Filter::Area).filter, Filter::Area);
    /// ```
    pub fn filter(mut self, filter: Filter) -> Options {
        self.filter = filter;
        self
    }

    /// With another [`Options::rotation`], or none.
    ///
    /// ```
    /// use spheremap::{geometry::from_angles, resample::Options};
    /// assert!(Options::new().rotation(from_angles(90.0, 0.0, 0.0)).rotation.is_some());
    /// ```
    pub fn rotation(mut self, rotation: impl Into<Option<DMat3>>) -> Options {
        self.rotation = rotation.into();
        self
    }

    /// With another [`Options::worlds`].
    ///
    /// ```
    /// use spheremap::Worlds;
    /// use spheremap::resample::Options;
    /// assert_eq!(Options::new().worlds, Worlds::Match);
    /// let literal = Options::new().worlds(Worlds::Literal);
    /// assert_eq!(literal.worlds, Worlds::Literal);
    /// ```
    pub fn worlds(mut self, worlds: Worlds) -> Options {
        self.worlds = worlds;
        self
    }

    /// With another [`Options::antialias`].
    ///
    /// ```
    /// use spheremap::resample::Options;
    /// assert!(!Options::new().antialias(false).antialias);
    /// ```
    pub fn antialias(mut self, antialias: bool) -> Options {
        self.antialias = antialias;
        self
    }

    /// With another [`Options::fill`].
    ///
    /// ```
    /// use spheremap::resample::{Fill, Options};
    /// assert_eq!(Options::new().fill(0.0).fill, Fill::All(0.0));
    /// assert_eq!(Options::new().fill(vec![0.0, 1.0]).fill, Fill::Channels(vec![0.0, 1.0]));
    /// ```
    pub fn fill(mut self, fill: impl Into<Fill>) -> Options {
        self.fill = fill.into();
        self
    }

    /// With another [`Options::alpha`], or none.
    ///
    /// ```
    /// use spheremap::resample::Options;
    /// assert_eq!(Options::new().alpha(3).alpha, Some(3));
    /// ```
    pub fn alpha(mut self, alpha: impl Into<Option<usize>>) -> Options {
        self.alpha = alpha.into();
        self
    }

    /// With another [`Options::skipna`].
    ///
    /// ```
    /// use spheremap::resample::Options;
    /// assert!(Options::new().skipna(true).skipna);
    /// ```
    pub fn skipna(mut self, skipna: bool) -> Options {
        self.skipna = skipna;
        self
    }

    /// With another [`Options::window`], or none.
    ///
    /// ```
    /// use spheremap::resample::{Options, Window};
    /// let upper = Window { rows: 0..8, columns: 0..32 };
    /// assert_eq!(Options::new().window(upper.clone()).window, Some(upper));
    /// ```
    pub fn window(mut self, window: impl Into<Option<Window>>) -> Options {
        self.window = window.into();
        self
    }

    /// The rotation, where it is one.
    pub(crate) fn turn(&self) -> Result<Option<DMat3>, Error> {
        expect_rotation(self.rotation)?;
        Ok(self.rotation)
    }

    /// The channel of opacity, where it weights anything: labels are not averaged.
    pub(crate) fn opacity(&self, channels: usize) -> Result<Option<usize>, Error> {
        let Some(alpha) = self.alpha else {
            return Ok(None);
        };
        if channels < 2 || alpha >= channels {
            return Err(Error::Contradiction(format!(
                "Expected `alpha` to be the number of one of at least 2 channels, got {alpha} for {channels}."
            )));
        }
        if self.filter == Filter::Mode {
            return Err(Error::Contradiction(
                "`alpha` weights colors, and filter 'mode' is for labels.".to_owned(),
            ));
        }
        Ok(Some(alpha).filter(|_| !self.filter.info().takes_labels))
    }
}
