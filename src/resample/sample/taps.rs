//! What a lookup at an edge comes to: stored texels with weights.

/// Stored texels and their weights.
pub(crate) struct Taps(Vec<(usize, f64)>);

impl Taps {
    pub(crate) fn new() -> Self {
        Taps(Vec::with_capacity(48))
    }

    pub(crate) fn push(&mut self, index: usize, weight: f64) {
        if weight != 0.0 {
            self.0.push((index, weight));
        }
    }

    pub(crate) fn list(&self) -> &[(usize, f64)] {
        &self.0
    }
}
