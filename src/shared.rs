//! What programs ask for with types of their own choice, compiled with the library where compilers can share it.
//!
//! A generic function is compiled for each program that calls it. For these that is every formula at every level of instructions:
//! minutes for each example and for those of the documentation, of what all of them have alike. Below `opt-level = 2` a program takes
//! from the library what the library has compiled for itself, and here it does. An optimized program compiles its own, of what it calls, so
//! there this is left out.

use crate::kernel::Scalar;
use crate::map::Map;
use crate::resample::convert;
use half::f16;

/// Where the functions are, for nobody to call: what is named is compiled.
pub fn functions() -> Vec<*const ()> {
    let conversions = [
        convert::<u8> as *const (),
        convert::<u16> as *const (),
        convert::<f16> as *const (),
        convert::<f32> as *const (),
        convert::<f64> as *const (),
    ];
    [&verbs::<f32>()[..], &verbs::<f64>(), &conversions].concat()
}

fn verbs<R: Scalar>() -> [*const (); 6] {
    [
        Map::encode_numbers::<R> as *const (),
        Map::decode_numbers::<R> as *const (),
        Map::jacobian_numbers::<R> as *const (),
        Map::density_numbers::<R> as *const (),
        Map::valid_numbers::<R> as *const (),
        Map::covers_numbers::<R> as *const (),
    ]
}
