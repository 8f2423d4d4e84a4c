//! Longitudes and latitudes.

use super::arrays::{points, reals, with_reals};
use crate::geometry::world::World;
use crate::map::lonlat;
use pyo3::prelude::*;

/// Longitudes and latitudes of directions, in a world: (..., 3) -> (..., 2).
#[pyfunction]
#[pyo3(signature = (directions, world, half_turn, /))]
pub fn directions_to_lonlat<'py>(
    py: Python<'py>,
    directions: &Bound<'py, PyAny>,
    world: &str,
    half_turn: f64,
) -> PyResult<Bound<'py, PyAny>> {
    let world = world.parse::<World>()?;
    with_reals!(&reals(directions, "directions", None)?, d => {
        let work = |d: &[_], out: &mut [_]| lonlat::of_directions(world, half_turn, d, out);
        points(py, d, "directions", 3, None, d.dtype(), &[2], &work)
    })
}

/// The way back, to unit directions: (..., 2) -> (..., 3).
#[pyfunction]
#[pyo3(signature = (lonlat, world, half_turn, /))]
pub fn lonlat_to_directions<'py>(
    py: Python<'py>,
    lonlat: &Bound<'py, PyAny>,
    world: &str,
    half_turn: f64,
) -> PyResult<Bound<'py, PyAny>> {
    let world = world.parse::<World>()?;
    with_reals!(&reals(lonlat, "lonlat", None)?, angles => {
        let work = |angles: &[_], d: &mut [_]| lonlat::directions_of(world, half_turn, angles, d);
        points(py, angles, "lonlat", 2, None, angles.dtype(), &[3], &work)
    })
}
