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

    /// Each texel once, where it first was, with the sum of its weights.
    pub(crate) fn by_texel(self) -> Vec<(usize, f64)> {
        let mut texels: Vec<(usize, f64)> = Vec::with_capacity(self.0.len());
        for (index, weight) in self.0 {
            match texels.iter_mut().find(|(texel, _)| *texel == index) {
                Some((_, sum)) => *sum += weight,
                None => texels.push((index, weight)),
            }
        }
        texels
    }

    pub(crate) fn list(&self) -> &[(usize, f64)] {
        &self.0
    }
}
