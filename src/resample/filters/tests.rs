//! The claims of every filter that weights the texels around a place, held over its weights.

use super::Filter;
use super::claims::{Kernel, Method, Visitor};

/// Holds a kernel's weights to a formula of the distance, divided by their sum where they are `normalized`.
pub fn check_weights<const TAPS: usize, K: Kernel<TAPS>>(
    formula: impl Fn(f64) -> f64,
    normalized: bool,
) {
    for k in 0..=1000 {
        let t = f64::from(k) / 1000.0;
        let distance = |i: usize| i as f64 + 1.0 - (TAPS / 2) as f64 - t;
        let expected: Vec<f64> = (0..TAPS).map(|i| formula(distance(i))).collect();
        let sum: f64 = if normalized {
            expected.iter().sum()
        } else {
            1.0
        };
        let got = K::weights(t);
        let single = K::weights(t as f32);
        for i in 0..TAPS {
            let expected = expected[i] / sum;
            // The papers' expanded cubics have terms up to 16, and round by some of their ε.
            assert!((got[i] - expected).abs() < 1e-14, "{t} {i}: {}", got[i]);
            // A sinc near its zero is what is left of numbers near π: some eight ε.
            assert!((f64::from(single[i]) - expected).abs() < 1e-6, "{t} {i}");
        }
    }
}

/// Mitchell and Netravali 1988, equation 8.
pub fn cubic(b: f64, c: f64) -> impl Fn(f64) -> f64 {
    move |x: f64| {
        let x = x.abs();
        (if x < 1.0 {
            (12.0 - 9.0 * b - 6.0 * c) * x.powi(3) + (-18.0 + 12.0 * b + 6.0 * c) * x * x + 6.0
                - 2.0 * b
        } else if x < 2.0 {
            (-b - 6.0 * c) * x.powi(3)
                + (6.0 * b + 30.0 * c) * x * x
                + (-12.0 * b - 48.0 * c) * x
                + 8.0 * b
                + 24.0 * c
        } else {
            0.0
        }) / 6.0
    }
}

/// The weights along a side for a place t of a texel from its left neighbor; empty for the nearest texel, which has none.
struct Weights(f64);

impl Visitor for Weights {
    type Output = Vec<f64>;
    fn nearest(self) -> Vec<f64> {
        Vec::new()
    }
    fn bilinear(self) -> Vec<f64> {
        vec![1.0 - self.0, self.0]
    }
    fn separable<K: Kernel<TAPS>, const TAPS: usize>(self) -> Vec<f64> {
        K::weights(self.0).to_vec()
    }
}

#[test]
fn weights_keep_the_claims() {
    for filter in Filter::ALL {
        let info = filter.info();
        assert_eq!(filter.lookup().is_ok(), info.method == Method::Lookup);
        let Ok(lookup) = filter.lookup() else {
            assert_eq!(info.support, None, "{}", info.name);
            continue;
        };
        let mut least = 0.0_f64;
        for k in 0..1000 {
            let weights = lookup.visit(Weights(f64::from(k) / 1000.0));
            if weights.is_empty() {
                assert_eq!(info.support, Some(0.5));
                continue;
            }
            assert_eq!(info.support, Some(0.5 * weights.len() as f64));
            // Six weights of at most 1, each rounded a few times.
            let sum: f64 = weights.iter().sum();
            assert!((sum - 1.0).abs() < 1e-14, "{}: {sum}", info.name);
            least = weights.iter().copied().fold(least, f64::min);
        }
        // What is left of a sinc's zero in rounding is no lobe.
        assert_eq!(least < -1e-9, info.ringing, "{}: {least}", info.name);
        let at_center = lookup.visit(Weights(0.0));
        if let Some(middle) = at_center.len().checked_sub(2) {
            let mut one = vec![0.0; at_center.len()];
            one[middle / 2] = 1.0;
            let apart = one.iter().zip(&at_center).map(|(a, b)| (a - b).abs());
            // Zero is zero but for the rounding of sin(π).
            let exact = apart.fold(0.0, f64::max) < 1e-15;
            assert_eq!(exact, info.interpolates, "{}", info.name);
        }
    }
}

#[test]
fn names_are_unique_and_found() {
    let names: Vec<_> = Filter::ALL.iter().flat_map(|f| f.names()).collect();
    for (k, name) in names.iter().enumerate() {
        assert!(!names[..k].contains(name), "{name}");
        let found = Filter::find(name).unwrap();
        assert!(found.names().any(|own| own == *name));
    }
    assert_eq!(Filter::ALL.len(), Filter::TABLE.len());
}

#[test]
fn labels_are_not_averaged() {
    for info in Filter::TABLE {
        assert!(!(info.takes_labels && (info.antialiased || info.ringing)));
        assert!(!info.antialiased || info.method == Method::Lookup);
    }
}
