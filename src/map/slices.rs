//! The verbs of a map over slices, and of one point.
//!
//! What a caller may get wrong, the lengths of slices and the numbers a point has, is an error here; the verbs below
//! (`encode_numbers` and its like) take it as given. What data may be, zero, NaN or outside the coverage, is no error: it gives NaN.

use crate::error::{Error, expect_length};
use crate::map::Map;
use crate::map::element::{Element, expect_points, points, reading, writing};
use crate::map::layout;
use crate::map::verbs::{DecodeOne, EncodeOne};
use glam::{DVec2, DVec3};

impl Map {
    /// Takes a verb from points of `inputs` numbers to as many of `outputs`.
    fn verb<A: Element, B: Element<Number = A::Number>>(
        (from, input, inputs): (&'static str, &[A], usize),
        (into, output, outputs): (&'static str, &mut [B], usize),
        work: impl Fn(&[A::Number], &mut [A::Number]) + Sync,
    ) -> Result<(), Error> {
        let count = points(from, input, inputs)?;
        expect_points(into, output, count, outputs)?;
        // One number for each element of the output, or as many as a point has.
        let each = outputs / B::WIDTH;
        reading(input, inputs, output, each, |input, output| {
            writing(input, inputs, output, outputs, &work);
        });
        Ok(())
    }

    /// Image coordinates of directions: (u, v), or (u, v, face) where faces are apart ([`Map::uv_width`]).
    ///
    /// Directions have any length. Zero, NaN and infinite ones and those outside the coverage give NaN.
    ///
    /// # Errors
    /// The slices' lengths do not go together, or their points do not have three numbers and [`Map::uv_width`] numbers.
    ///
    /// ```
    /// use spheremap::Map;
    /// use spheremap::glam::{Vec2, Vec3};
    /// let map = Map::new("octahedral")?;
    /// let mut uv = [Vec2::ZERO; 2];
    /// map.encode(&[Vec3::Z, Vec3::new(3.0, 0.0, 0.0)], &mut uv)?;
    /// assert_eq!(uv, [Vec2::new(0.5, 0.5), Vec2::new(1.0, 0.5)]);
    ///
    /// let cube = Map::new("cube")?; // six faces apart: three numbers
    /// assert!(cube.encode(&[[0.0_f32, 0.0, 1.0]], &mut [[0.0_f32; 2]]).is_err());
    /// # Ok::<(), spheremap::Error>(())
    /// ```
    pub fn encode<D: Element, U: Element<Number = D::Number>>(
        &self,
        directions: &[D],
        uv: &mut [U],
    ) -> Result<(), Error> {
        let input = ("directions", directions, 3);
        let output = ("uv", uv, self.uv_width());
        Map::verb(input, output, |d, uv| self.encode_numbers(None, d, uv))
    }

    /// Unit directions at image coordinates, NaN outside the valid image.
    ///
    /// # Errors
    /// The slices' lengths do not go together, or their points do not have [`Map::uv_width`] numbers and three numbers.
    ///
    /// ```
    /// use spheremap::Map;
    /// let map = Map::new("latlong")?;
    /// let mut directions = [[0.0_f64; 3]; 2];
    /// map.decode(&[[0.5, 0.5], [0.5, 0.0]], &mut directions)?;
    /// assert_eq!(directions, [[0.0, 0.0, -1.0], [0.0, 1.0, 0.0]]); // ahead, and straight up
    /// # Ok::<(), spheremap::Error>(())
    /// ```
    pub fn decode<U: Element, D: Element<Number = U::Number>>(
        &self,
        uv: &[U],
        directions: &mut [D],
    ) -> Result<(), Error> {
        let input = ("uv", uv, self.uv_width());
        let output = ("directions", directions, 3);
        Map::verb(input, output, |uv, d| self.decode_numbers(None, uv, d))
    }

    /// Derivatives of the direction by u and v at image coordinates: rows (∂x/∂u, ∂x/∂v), then y's and z's.
    ///
    /// # Errors
    /// The slices' lengths do not go together, or their points do not have [`Map::uv_width`] numbers and six numbers.
    ///
    /// ```
    /// use spheremap::Map;
    /// let map = Map::new("latlong")?;
    /// let mut jacobian = [[[0.0_f64; 2]; 3]];
    /// map.jacobian(&[[0.5, 0.5]], &mut jacobian)?;
    /// let [[x_u, _], [_, y_v], _] = jacobian[0];
    /// let pi = std::f64::consts::PI;
    /// assert!((x_u - 2.0 * pi).abs() < 1e-14); // right along u, a whole turn
    /// assert!((y_v + pi).abs() < 1e-14); // down along v, half of one
    /// # Ok::<(), spheremap::Error>(())
    /// ```
    pub fn jacobian<U: Element, J: Element<Number = U::Number>>(
        &self,
        uv: &[U],
        jacobians: &mut [J],
    ) -> Result<(), Error> {
        let input = ("uv", uv, self.uv_width());
        let output = ("jacobians", jacobians, 6);
        Map::verb(input, output, |uv, j| self.jacobian_numbers(None, uv, j))
    }

    /// Steradians per unit of image area, dω/(du dv), at image coordinates; NaN outside the valid image.
    ///
    /// # Errors
    /// The slices' lengths do not go together, or points do not have [`Map::uv_width`] numbers.
    ///
    /// ```
    /// use spheremap::Map;
    /// let map = Map::new("concentric")?; // equal-area: the same everywhere
    /// let mut density = [0.0_f64; 2];
    /// map.density(&[[0.5, 0.5], [0.1, 0.7]], &mut density)?;
    /// assert!((density[0] / density[1] - 1.0).abs() < 1e-14);
    /// # Ok::<(), spheremap::Error>(())
    /// ```
    pub fn density<U: Element>(&self, uv: &[U], density: &mut [U::Number]) -> Result<(), Error> {
        let width = self.uv_width();
        expect_length("density", density.len(), points("uv", uv, width)?)?;
        reading(uv, width, density, 1, |uv, density| {
            self.density_numbers(uv, density);
        });
        Ok(())
    }

    /// Whether image coordinates lie in the valid image.
    ///
    /// # Errors
    /// The slices' lengths do not go together, or points do not have [`Map::uv_width`] numbers.
    ///
    /// ```
    /// use spheremap::Map;
    /// let map = Map::new("angular")?; // a disk in its square
    /// let mut valid = [false; 2];
    /// map.valid(&[[0.5_f32, 0.5], [0.0, 0.0]], &mut valid)?;
    /// assert_eq!(valid, [true, false]);
    /// # Ok::<(), spheremap::Error>(())
    /// ```
    pub fn valid<U: Element>(&self, uv: &[U], valid: &mut [bool]) -> Result<(), Error> {
        let width = self.uv_width();
        expect_length("valid", valid.len(), points("uv", uv, width)?)?;
        reading(uv, width, valid, 1, |uv, valid| {
            self.valid_numbers(uv, valid)
        });
        Ok(())
    }

    /// Whether directions lie in the coverage.
    ///
    /// # Errors
    /// The slices' lengths do not go together, or points do not have three numbers.
    ///
    /// ```
    /// use spheremap::Map;
    /// let map = Map::new("hemioctahedral")?; // what lies above the horizon
    /// let mut covered = [false; 2];
    /// map.covers(&[[0.0_f32, 0.0, 1.0], [0.0, 0.0, -1.0]], &mut covered)?;
    /// assert_eq!(covered, [true, false]);
    /// # Ok::<(), spheremap::Error>(())
    /// ```
    pub fn covers<D: Element>(&self, directions: &[D], covered: &mut [bool]) -> Result<(), Error> {
        let count = points("directions", directions, 3)?;
        expect_length("covered", covered.len(), count)?;
        reading(directions, 3, covered, 1, |d, covered| {
            self.covers_numbers(None, d, covered);
        });
        Ok(())
    }

    /// The face and the image coordinates of one direction; none for zero, NaN, infinity and what lies outside the coverage.
    ///
    /// The face is 0 where faces are not apart. The numbers are those that [`Map::encode`] gives.
    ///
    /// ```
    /// use spheremap::Map;
    /// use spheremap::glam::{DVec2, DVec3};
    /// let map = Map::new("cube")?;
    /// assert_eq!(map.encode_one(DVec3::Y), Some((2, DVec2::new(0.5, 0.5))));
    /// assert_eq!(map.encode_one(DVec3::ZERO), None);
    /// # Ok::<(), spheremap::Error>(())
    /// ```
    pub fn encode_one(&self, direction: DVec3) -> Option<(usize, DVec2)> {
        let turn = self.view_rotation(None);
        let direction = turn.apply(direction.to_array());
        let canonical = self.visit_canonical(EncodeOne(direction));
        if canonical[0].is_nan() {
            return None;
        }
        let [u, v, face] = if self.face_layout().is_canonical() {
            canonical
        } else {
            layout::store_one(self.face_layout(), canonical)
        };
        let face = if self.uv_width() > 2 {
            face as usize
        } else {
            0
        };
        Some((face, DVec2::new(u, v)))
    }

    /// The unit direction at one place of a face; none outside the valid image.
    ///
    /// The face is 0 where faces are not apart. The numbers are those that [`Map::decode`] gives.
    ///
    /// ```
    /// use spheremap::Map;
    /// use spheremap::glam::{DVec2, DVec3};
    /// let map = Map::new("cube")?;
    /// assert_eq!(map.decode_one(2, DVec2::new(0.5, 0.5)), Some(DVec3::Y));
    /// assert_eq!(map.decode_one(6, DVec2::new(0.5, 0.5)), None); // there are six, from 0 on
    /// # Ok::<(), spheremap::Error>(())
    /// ```
    pub fn decode_one(&self, face: usize, uv: DVec2) -> Option<DVec3> {
        if face >= self.faces() {
            return None;
        }
        let place = [uv.x, uv.y, face as f64];
        let canonical = if self.face_layout().is_canonical() {
            place
        } else {
            layout::locate_one(self.face_layout(), place)
        };
        let direction = self.visit_canonical(DecodeOne(canonical));
        let direction = DVec3::from(self.view_rotation(None).inverse().apply(direction));
        (!direction.is_nan()).then_some(direction)
    }
}
