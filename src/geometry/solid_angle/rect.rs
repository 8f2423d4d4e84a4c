//! The rectangle of an image that a texel is.

/// A rectangle of the unit square: u0 <= u <= u1, v0 <= v <= v1.
#[derive(Clone, Copy, Debug)]
pub struct Rect {
    /// Left.
    pub u0: f64,
    /// Right.
    pub u1: f64,
    /// Top.
    pub v0: f64,
    /// Bottom.
    pub v1: f64,
}

impl Rect {
    /// The unit square.
    pub const WHOLE: Rect = Rect {
        u0: 0.0,
        u1: 1.0,
        v0: 0.0,
        v1: 1.0,
    };

    pub(super) fn du(self) -> f64 {
        self.u1 - self.u0
    }

    pub(super) fn dv(self) -> f64 {
        self.v1 - self.v0
    }

    /// Its area in the image.
    ///
    /// ```
    /// use spheremap::geometry::Rect;
    /// assert_eq!(Rect { u0: 0.5, ..Rect::WHOLE }.area(), 0.5);
    /// ```
    pub fn area(self) -> f64 {
        self.du() * self.dv()
    }

    pub(super) fn quarters(self) -> [Self; 4] {
        let (u, v) = (0.5 * (self.u0 + self.u1), 0.5 * (self.v0 + self.v1));
        let (left, right) = (Self { u1: u, ..self }, Self { u0: u, ..self });
        [
            Self { v1: v, ..left },
            Self { v1: v, ..right },
            Self { v0: v, ..left },
            Self { v0: v, ..right },
        ]
    }
}
