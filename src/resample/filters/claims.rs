//! What a filter is, and what it claims about itself.
//!
//! [`FilterInfo`] is a list of claims, each of which is a test over the table. Filters that look places up have a
//! [`Lookup`] as well: it shows its visitor how a window of texels is weighted. Most are separable, and
//! their whole formula is a [`Kernel`].

use crate::number::real::Real;

/// How a filter makes a texel of a conversion.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Method {
    /// It weights the texels around a place: for `sample` as for `convert`.
    Lookup,
    /// It looks a footprint up in a mip chain: for `convert`, and for `sample` where it is told how much lookups see.
    Mipmapped,
    /// It takes all that the texel covers: for `convert` alone.
    Area,
}

impl Method {
    /// The word for it.
    ///
    /// ```
    /// use spheremap::resample::Filter;
    /// assert_eq!(Filter::Area.info().method.name(), "area");
    /// ```
    pub fn name(self) -> &'static str {
        match self {
            Method::Lookup => "lookup",
            Method::Mipmapped => "mipmapped",
            Method::Area => "area",
        }
    }
}

/// What a filter claims about itself.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct FilterInfo {
    /// The name it is asked for by.
    pub name: &'static str,
    /// Other names of the same filter.
    pub also: &'static [&'static str],
    /// Its full name.
    pub title: &'static str,
    /// Where it comes from.
    pub source: &'static str,
    /// What it takes, in a few words.
    pub takes: &'static str,
    /// What it is for, in one line.
    pub summary: &'static str,
    /// How it makes a texel.
    pub method: Method,
    /// How many texels from the place its weights end, along each axis; none where that depends on the footprint.
    pub support: Option<f64>,
    /// At a texel's center it gives that texel.
    pub interpolates: bool,
    /// Some of its weights are negative: values overshoot beside an edge.
    pub ringing: bool,
    /// Its results are values of the source, so that labels stay labels.
    pub takes_labels: bool,
    /// `convert` averages it over texels that see more than one texel of the source.
    pub antialiased: bool,
}

/// A filter.
pub trait Claims: Copy {
    /// Its claims.
    const INFO: FilterInfo;
}

/// A separable kernel over TAPS texels along each side, an even number of them.
///
/// Sums of weights are 1 but for rounding. Where that would show, callers add differences from one of
/// the texels, so that a constant stays constant to the bit.
pub trait Kernel<const TAPS: usize>: Copy {
    /// The weights of the texels `1 - TAPS/2 … TAPS/2` from the left one, where `t` in [0, 1) is how far the place lies
    /// from the texel on its left to the one on its right.
    fn weights<R: Real>(t: R) -> [R; TAPS];
}

/// A filter that looks places up.
pub trait Lookup: Claims {
    /// Shows how: calls the one method of the visitor that is its own.
    fn visit<V: Visitor>(visitor: V) -> V::Output;
}

/// What is done for each way to weight texels around a place.
pub trait Visitor {
    /// What comes of it.
    type Output;
    /// The texel that holds the place.
    fn nearest(self) -> Self::Output;
    /// The four texels around it.
    fn bilinear(self) -> Self::Output;
    /// TAPS × TAPS texels, by a kernel along u and along v.
    fn separable<K: Kernel<TAPS>, const TAPS: usize>(self) -> Self::Output;
}
