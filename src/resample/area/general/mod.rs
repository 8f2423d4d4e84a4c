//! Any cell, cut at exact crossings.

pub(in crate::resample::area) mod overlay;
