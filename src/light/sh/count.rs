//! How many coefficients there are.

/// The number of coefficients up to an order.
pub fn count(order: usize) -> usize {
    (order + 1) * (order + 1)
}
