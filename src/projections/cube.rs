//! Cube map: the direction's largest component chooses a face, the others over it are the place.
//!
//! Source: the OpenGL specification's table of cube-map faces, which Direct3D and Vulkan share. In the
//! view frame, with p, q in [-1, 1], the faces are right (1, q, -p), left (-1, q, p), up (p, -1, q), down
//! (p, 1, -q), front (p, q, 1), back (-p, q, -1), in this order; with axes "+x -y +z" they are the table's
//! +x -x +y -y +z -z.
//!
//! Domain: all directions; no singular point; the density varies 5.196:1. Ties, which the table leaves
//! open: x wins over y wins over z.

use crate::geometry::solid_angle;
use crate::geometry::solid_angle::Rect;
use crate::number::real::Real;
use crate::projections::faces::{CUBE_LAYOUTS, LayoutSpec};
use crate::projections::projection::{Coverage, Edge, Info, Projection, Seam, Uv};

/// The components of a direction in the plane of its face, the largest one's size, and the face. Ties: x wins over y wins
/// over z.
#[inline(always)]
pub(super) fn to_face<R: Real>([x, y, z]: [R; 3]) -> ([R; 2], R, R) {
    let zero = R::ZERO;
    let (ax, ay, az) = (x.abs(), y.abs(), z.abs());
    let by_x = ax.at_least(ay) & ax.at_least(az);
    let by_y = ay.at_least(az);
    let of_axis = |x: R, y: R, z: R| R::select(by_x, x, R::select(by_y, y, z));
    let major = of_axis(ax, ay, az);
    let (xn, yn, zn) = (x.less(zero), y.less(zero), z.less(zero));
    let p_side = R::either(xn, || z, || -z);
    let p_front = R::either(zn, || -x, || x);
    let p = of_axis(p_side, x, p_front);
    let q_poles = R::either(yn, || z, || -z);
    let q = of_axis(y, q_poles, y);
    let (f0, f1, f2) = (R::ZERO, R::ONE, R::TWO);
    let (f3, f4, f5) = (R::new(3.0), R::new(4.0), R::new(5.0));
    let face_x = R::select(xn, f1, f0);
    let face_y = R::select(yn, f2, f3);
    let face_z = R::select(zn, f5, f4);
    let face = of_axis(face_x, face_y, face_z);
    ([p, q], major, face)
}

/// (right, down, forward) of a face in the view frame.
#[inline(always)]
pub(super) fn axis_of_face<R: Real>([pn, qn, n]: [R; 3], face: R) -> [R; 3] {
    let side = face.less(R::new(1.5));
    let pole = face.less(R::new(3.5));
    let odd = face.equals(R::ONE) | face.equals(R::new(3.0)) | face.equals(R::new(5.0));
    let of_pair = |x: R, y: R, z: R| R::select(side, x, R::select(pole, y, z));
    // Up is the even one of its pair and has y negative: down the image is +y.
    let x_side = R::either(odd, || -n, || n);
    let x_front = R::either(odd, || -pn, || pn);
    let x = of_pair(x_side, pn, x_front);
    let y_pole = R::either(odd, || n, || -n);
    let y = of_pair(qn, y_pole, qn);
    let z_side = R::either(odd, || pn, || -pn);
    let z_pole = R::either(odd, || -qn, || qn);
    let z_front = R::either(odd, || -n, || n);
    let z = of_pair(z_side, z_pole, z_front);
    [x, y, z]
}

/// The unit direction at gnomonic (p, q) of a face.
#[inline(always)]
pub(super) fn from_face<R: Real>([p, q]: [R; 2], face: R) -> [R; 3] {
    let one = R::ONE;
    let n = one / (one + p * p + q * q).sqrt();
    axis_of_face([p * n, q * n, n], face)
}

/// Six gnomonic faces.
#[derive(Clone, Copy, Debug)]
pub struct Cube;

const LAYOUTS: &[LayoutSpec] = CUBE_LAYOUTS;

impl Projection for Cube {
    const INFO: Info = Info {
        name: "cube",
        title: "Cube map",
        known_as: &["cube_map", "skybox"],
        source: "OpenGL 4.6 specification, section 8.13, table 8.19",
        summary: "Six perspective views of 90 degrees; what graphics hardware samples.",
        singular: "None; on ties x wins over y wins over z.",
        axes: "+x -y +z",
        faces: 6,
        layouts: LAYOUTS,
        smooth: true,
        ..Info::PLAIN
    };
    const MEMORY_BOUND: bool = true;

    fn with_parameters(_: &[f64]) -> Self {
        Cube
    }

    fn coverage(self) -> Coverage {
        Coverage::Sphere
    }

    fn density_range(self) -> (f64, f64) {
        (4.0 / 27f64.sqrt(), 4.0)
    }

    fn seam(self) -> Seam {
        Seam::Faces
    }

    #[inline(always)]
    fn encode<R: Real>(self, d: [R; 3]) -> Uv<R> {
        let ([p, q], major, face) = to_face(d);
        Uv::centered(p / major, q / major, face)
    }

    #[inline(always)]
    fn decode<R: Real>(self, uv: Uv<R>) -> [R; 3] {
        let (p, q) = uv.pq();
        from_face([p, q], uv.face)
    }

    fn beside(self, _: Edge, along: f64, inset: f64) -> f64 {
        // The mirror images (1 - h, q') and (1, q', 1 - h) have their middle at q'/(1 - h/2).
        along * (1.0 - 0.5 * inset)
    }

    fn across(self, edge: Edge, along: f64, inset: f64) -> Uv<f64> {
        // The plane of this face, continued to the direction (1, q, 1 - h); a face of one texel has its
        // row in the middle, where the plane would be infinitely far.
        let inset = (1.0 - inset).max(1e-6);
        let mut at = [along / inset; 2];
        at[edge.axis] = if edge.high { 1.0 / inset } else { -1.0 / inset };
        let [u, v] = at.map(|x| 0.5 * x + 0.5);
        self.beyond(Uv {
            u,
            v,
            face: edge.face,
        })
    }

    fn solid_angle(self, rect: Rect) -> f64 {
        solid_angle::cube(rect)
    }

    #[inline(always)]
    fn density<R: Real>(self, uv: Uv<R>) -> R {
        let (p, q) = uv.pq();
        let w = R::ONE + p * p + q * q;
        R::new(4.0) / (w * w.sqrt())
    }
}
