//! The registry: one line per projection.
//!
//! The macro makes the enum of all kinds, the list of their claims and the static dispatch. A new
//! projection is one file and one line here; everything else (encode, decode, jacobian, solid
//! angles, sampling, conversion, the command line, tests, benchmarks, tables) iterates the registry.
//!
//! A projection is a type here ([`Octahedral`]) and a name elsewhere ("octahedral"). [`Map`](crate::Map) takes either, and is
//! what programs work with: it adds axes, grid, layout and all verbs over slices. The type alone has the bare formula of
//! one point, in the view frame, for code that wants it inlined:
//!
//! ```
//! use spheremap::projections::{Octahedral, Projection, Uv};
//! let Uv { u, v, .. } = Octahedral.encode([0.0_f32, 0.0, 1.0]);
//! assert_eq!((u, v), (0.5, 0.5));
//! assert_eq!(Octahedral.decode(Uv { u, v, face: 0.0 }), [0.0, 0.0, 1.0]);
//! ```

mod common;
// For the table of the documentation, which the Python package makes.
#[cfg(feature = "python")]
pub(crate) mod cost;
pub(crate) mod faces;
pub(crate) mod projection;

pub use faces::{
    Cells, FaceLayout, FacePlacement, FaceTable, LayoutCell, LayoutSpec, MAX_FACES, Orientation,
};
pub use projection::{Coverage, Edge, Info, Outline, Parameter, Projection, Seam, Uv};

use crate::projections::projection::Visitor;

macro_rules! projections {
    ($($module:ident::$name:ident),+ $(,)?) => {
        $(mod $module;)+
        $(pub use $module::$name;)+

        /// The types alone.
        pub(crate) mod types {
            $(pub use super::$module::$name;)+
        }

        /// Any registered projection.
        #[expect(clippy::large_enum_variant, reason = "a map holds one, and a lens has two polynomials")]
        #[derive(Clone, Copy, Debug)]
        pub(crate) enum Kind {
            $(
                #[doc = concat!("[`", stringify!($name), "`]")]
                $name($name)
            ),+
        }

        /// The claims of every registered projection, in the order of the registry.
        ///
        /// ```
        /// use spheremap::projections::REGISTRY;
        /// let equal_area: Vec<_> = REGISTRY.iter().filter(|info| info.equal_area).map(|info| info.name).collect();
        /// assert!(equal_area.contains(&"healpix"));
        /// ```
        pub const REGISTRY: &[Info] = &[$($name::INFO),+];

        impl Kind {
            /// The projection of this name, with its parameters in the order of its `Info`.
            pub fn new(name: &str, parameters: &[f64]) -> Option<Self> {
                $(
                    if name == $name::INFO.name {
                        return Some(Kind::$name($name::with_parameters(parameters)));
                    }
                )+
                None
            }

            /// Whether parameters, each within its range, go together for the projection of this name.
            pub fn check(name: &str, parameters: &[f64]) -> Result<(), String> {
                $(
                    if name == $name::INFO.name {
                        return $name::check(parameters);
                    }
                )+
                Ok(())
            }

            /// Calls the visitor with the projection inside.
            pub fn visit<V: Visitor>(self, visitor: V) -> V::Output {
                match self {
                    $(Kind::$name(p) => p.accept(visitor)),+
                }
            }
        }
    };
}

projections! {
    sphere::Sphere,
    matcap::Matcap,
    dual_paraboloid::DualParaboloid,
    cube::Cube,
    angular::Angular,
    octahedral::Octahedral,
    hemioctahedral::Hemioctahedral,
    latlong::Latlong,
    perspective::Perspective,
    cylindrical::Cylindrical,
    equisolid::Equisolid,
    stereographic::Stereographic,
    orthographic::Orthographic,
    equal_area::EqualArea,
    concentric::Concentric,
    lambert_cylindrical::LambertCylindrical,
    cube_equiangular::CubeEquiangular,
    cube_quadratic::CubeQuadratic,
    cube_equal_area::CubeEqualArea,
    healpix::Healpix,
    dual_fisheye::DualFisheye,
    kannala_brandt::KannalaBrandt,
    unified::Unified,
    double_sphere::DoubleSphere,
    pannini::Pannini,
    mercator::Mercator,
    miller::Miller,
    hemi_latlong::HemiLatlong,
    mollweide::Mollweide,
    hammer::Hammer,
    sinusoidal::Sinusoidal,
    tetrahedral::Tetrahedral,
    icosahedral::Icosahedral,
    camera_pinhole::CameraPinhole,
    camera_brown_conrady::CameraBrownConrady,
    camera_kannala_brandt::CameraKannalaBrandt,
    camera_unified::CameraUnified,
    camera_double_sphere::CameraDoubleSphere,
    camera_eucm::CameraEucm,
    camera_fov::CameraFov,
    camera_thin_prism_fisheye::CameraThinPrismFisheye,
    camera_rad_tan_thin_prism_fisheye::CameraRadTanThinPrismFisheye,
}
