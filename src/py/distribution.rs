//! The class `Distribution`: an importance distribution in the core.

use super::images::{PyTexel, split, view};
use super::projection::PyProjection;
use super::stopping::stoppable;
use crate::light::distribution::{Distribution, Radiance};
use crate::map::Map;
use crate::py::arrays::fits;
use crate::py::arrays::{
    Float, contiguous, disjoint, finish, leading, output, points, reals, run, with_reals, writable,
};
use numpy::{PyReadonlyArrayDyn, PyUntypedArrayMethods};
use pyo3::exceptions::PyTypeError;
use pyo3::prelude::*;
use pyo3::types::PyTuple;

/// A density on the sphere, proportional to the luminance of an image.
#[pyclass(name = "Distribution", module = "spheremap._core", frozen)]
pub struct PyDistribution {
    distribution: Distribution,
    /// The shape of a texel: () or (channels,).
    texel: Vec<usize>,
}

/// What `sample` returns: directions, densities and, if asked for, weights.
type Outputs<'py> = [Option<Bound<'py, PyAny>>; 3];

#[pymethods]
impl PyDistribution {
    /// `luminance` is float64 of the image's shape, `radiance` float32 or float64 with its channels.
    #[new]
    #[pyo3(signature = (projection, luminance, radiance, /))]
    fn new(
        py: Python<'_>,
        projection: &PyProjection,
        luminance: &Bound<'_, PyAny>,
        radiance: &Bound<'_, PyAny>,
    ) -> PyResult<Self> {
        let unfit = || PyTypeError::new_err("Expected contiguous float arrays.");
        let luminance = contiguous::<f64>(luminance)?.ok_or_else(unfit)?;
        if let Some(radiance) = contiguous::<f32>(radiance)? {
            return Self::of(py, &projection.0, &radiance, &luminance);
        }
        let radiance = contiguous::<f64>(radiance)?.ok_or_else(unfit)?;
        Self::of(py, &projection.0, &radiance, &luminance)
    }

    /// ∫ L dω of the luminance.
    #[getter]
    fn integral(&self) -> f64 {
        self.distribution.integral()
    }

    /// Density per steradian: (..., 3) -> (...).
    #[pyo3(signature = (directions, /, *, out=None))]
    fn pdf<'py>(
        &self,
        py: Python<'py>,
        directions: &Bound<'py, PyAny>,
        out: Option<&Bound<'py, PyAny>>,
    ) -> PyResult<Bound<'py, PyAny>> {
        let reals = reals(directions, "directions", out)?;
        with_reals!(&reals, d => {
            let work = |d: &[_], pdf: &mut [_]| fits(self.distribution.pdf(d, pdf));
            points(py, d, "directions", 3, out, d.dtype(), &[], &work)
        })
    }

    /// (directions, pdf) or (directions, pdf, weights) of numbers in [0, 1]: (..., 2), contiguous floats.
    #[pyo3(signature = (xi, /, *, weights=false, out=None))]
    fn sample<'py>(
        &self,
        py: Python<'py>,
        xi: &Bound<'py, PyAny>,
        weights: bool,
        out: Option<Outputs<'py>>,
    ) -> PyResult<Bound<'py, PyTuple>> {
        let out = out.unwrap_or_default();
        if let Some(xi) = contiguous::<f32>(xi)? {
            return self.draw(py, &xi, weights, &out);
        }
        let xi = contiguous::<f64>(xi)?
            .ok_or_else(|| PyTypeError::new_err("Expected contiguous floats."))?;
        self.draw(py, &xi, weights, &out)
    }
}

impl PyDistribution {
    fn of<T: Radiance + PyTexel>(
        py: Python<'_>,
        map: &Map,
        radiance: &PyReadonlyArrayDyn<'_, T>,
        luminance: &PyReadonlyArrayDyn<'_, f64>,
    ) -> PyResult<Self> {
        let (image, luminance) = (view(map, radiance)?, luminance.as_slice()?);
        let (_, _, texel) = split(map, radiance.shape())?;
        Ok(PyDistribution {
            distribution: stoppable(py, || Distribution::new(&image, luminance))?,
            texel: texel.to_vec(),
        })
    }

    fn draw<'py, T: Float>(
        &self,
        py: Python<'py>,
        xi: &PyReadonlyArrayDyn<'py, T>,
        weights: bool,
        out: &Outputs<'py>,
    ) -> PyResult<Bound<'py, PyTuple>> {
        let lead = leading(xi.shape(), 2, "xi")?;
        let shape = |tail: &[usize]| [lead, tail].concat();
        let array =
            |k: usize, tail: &[usize]| output::<T>(py, out[k].as_ref(), T::NAME, &shape(tail));
        let (directions, pdf) = (array(0, &[3])?, array(1, &[])?);
        let weight = if weights {
            Some(array(2, &self.texel)?)
        } else {
            None
        };
        {
            let (mut d, mut p) = (writable(&directions)?, writable(&pdf)?);
            let mut w = weight.as_ref().map(writable).transpose()?;
            let input = xi.as_slice()?;
            let (d, p) = (d.as_slice_mut()?, p.as_slice_mut()?);
            let w = match &mut w {
                Some(w) => w.as_slice_mut()?,
                None => &mut [],
            };
            disjoint(input, d)?;
            disjoint(input, p)?;
            disjoint(input, w)?;
            disjoint(d, p)?;
            disjoint(d, w)?;
            disjoint(p, w)?;
            run(py, input.len(), || self.distribution.sample(input, d, p, w))??;
        }
        let mut results = vec![
            finish(directions, out[0].is_some())?,
            finish(pdf, out[1].is_some())?,
        ];
        if let Some(weight) = weight {
            results.push(finish(weight, out[2].is_some())?);
        }
        PyTuple::new(py, results)
    }
}
