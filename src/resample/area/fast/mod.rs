//! Eight cells of the target at once: edges as cubics, sums by Green's theorem.

pub(in crate::resample::area) mod edges;
pub(in crate::resample::area) mod eight;
pub(in crate::resample::area) mod lanes;
pub(in crate::resample::area) mod plane;
