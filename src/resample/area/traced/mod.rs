//! A cell that meets a seam or a pole, followed edge by edge.

pub(in crate::resample::area) mod arc;
pub(in crate::resample::area) mod density;
pub(in crate::resample::area) mod seams;
pub(in crate::resample::area) mod shares;
