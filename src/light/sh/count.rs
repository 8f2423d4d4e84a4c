//! How many coefficients there are.

/// The number of coefficients up to an order.
///
/// ```
/// assert_eq!(spheremap::light::sh::count(2), 9);
/// ```
pub fn count(order: usize) -> usize {
    let rows = order.saturating_add(1);
    rows.saturating_mul(rows)
}
