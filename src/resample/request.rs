//! What is to be converted into what.

use crate::image::view::ImageView;
use crate::map::Map;
use crate::resample::window::Window;
use glam::DMat3;

/// An image, and the one that is to be made of it.
#[derive(Clone, Copy)]
pub(crate) struct Request<'a, T> {
    /// What is converted.
    pub(crate) image: &'a ImageView<'a, T>,
    /// How the result maps the sphere.
    pub(crate) map: &'a Map,
    /// Its shape, without channels.
    pub(crate) shape: &'a [usize],
    /// Turns the content in the world.
    pub(crate) rotation: Option<DMat3>,
    /// A texel where there is nothing.
    pub(crate) fill: &'a [T],
    /// The part of it that is made.
    pub(crate) window: &'a Window,
}

impl<'a, T> Request<'a, T> {
    /// Where it looks.
    pub(crate) fn sight(&self) -> Sight<'a> {
        Sight {
            map: self.map,
            shape: self.shape,
            rotation: self.rotation,
            window: self.window,
        }
    }
}

/// A request as far as it says where it looks, and not at what.
#[derive(Clone, Copy)]
pub(crate) struct Sight<'a> {
    /// How the result maps the sphere.
    pub(crate) map: &'a Map,
    /// Its shape, without channels.
    pub(crate) shape: &'a [usize],
    /// Turns the content in the world.
    pub(crate) rotation: Option<DMat3>,
    /// The part of it that is made.
    pub(crate) window: &'a Window,
}
