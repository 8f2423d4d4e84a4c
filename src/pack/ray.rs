//! Points of a lattice that lie along one ray from its middle, and so are one direction: which of them stands for all.
//!
//! In whole numbers, so that equal directions are found to be equal: a quotient would round.

/// The largest number that divides all of them; 0 if they are 0.
fn common_factor(numbers: &[i64]) -> i64 {
    let of_two = |a: u64, b: u64| {
        let (mut a, mut b) = (a, b);
        while b != 0 {
            (a, b) = (b, a % b);
        }
        a
    };
    let all = numbers
        .iter()
        .fold(0, |all, x| of_two(all, x.unsigned_abs()));
    all as i64
}

/// A point without its common factor, and the square of its length; None for the middle, which has no direction.
fn primitive<const K: usize>(point: [i64; K]) -> Option<([i64; K], u64)> {
    let factor = common_factor(&point);
    if factor == 0 {
        return None;
    }
    let point = point.map(|x| x / factor);
    let square = point.iter().map(|x| x.unsigned_abs().pow(2)).sum();
    Some((point, square))
}

/// The point of the ray of this one that is nearest to a sphere of this radius, among those in the cube about it. With
/// `odd`, of a lattice of odd numbers.
pub fn nearest_to_sphere(point: [i64; 3], radius: i64, odd: bool) -> [i64; 3] {
    let Some((step, square)) = primitive(point) else {
        return point;
    };
    let radius = radius.unsigned_abs();
    let stride = if odd { 2 } else { 1 };
    let last_of = |most: u64| {
        if odd {
            most.saturating_sub(1) | 1
        } else {
            most
        }
    };
    let within = last_of((radius * radius / square).isqrt()).max(1);
    // The middle to the next one is inside as well: that one is nearer.
    let more = (2 * within + stride).pow(2) * square < 4 * radius * radius;
    let longest = step.iter().fold(1, |most, x| x.unsigned_abs().max(most));
    let times = (within + if more { stride } else { 0 }).min(last_of(radius / longest));
    step.map(|x| x * times as i64)
}

/// The point of the ray of this one that is the first on a circle of this radius, or beyond it.
pub fn first_beyond_circle(point: [i64; 2], radius: i64) -> [i64; 2] {
    let Some((step, square)) = primitive(point) else {
        return point;
    };
    // The least whose square is no less than this quotient.
    let least = radius.unsigned_abs().pow(2).div_ceil(square);
    let times = least.saturating_sub(1).isqrt() + 1;
    step.map(|x| x * times as i64)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn one_point_of_a_ray_stands_for_it() {
        for k in 1..=127 {
            assert_eq!(nearest_to_sphere([k, 0, 0], 127, false), [127, 0, 0]);
            // 73√3 = 126.4, 74√3 = 128.2.
            let k = k.min(73);
            assert_eq!(nearest_to_sphere([-k, k, k], 127, false), [-73, 73, 73]);
        }
        assert_eq!(nearest_to_sphere([127, 126, 0], 127, false), [127, 126, 0]);
        assert_eq!(nearest_to_sphere([0, 0, 0], 127, false), [0, 0, 0]);
        // 147√3 = 254.6, and even numbers are not of the lattice.
        assert_eq!(
            nearest_to_sphere([255, -255, 255], 255, true),
            [147, -147, 147]
        );
        assert_eq!(nearest_to_sphere([251, 1, 1], 255, true), [251, 1, 1]);
    }

    #[test]
    fn no_multiple_is_nearer_to_the_sphere() {
        for (radius, odd) in [(127, false), (255, true)] {
            let stride = if odd { 2 } else { 1 };
            for point in [[1, 1, 3], [1, 3, 5], [7, 1, 9], [11, 3, 1], [1, 1, 1]] {
                let chosen = nearest_to_sphere(point, radius, odd);
                let off = |times: i64| {
                    let square: i64 = point.iter().map(|x| (x * times).pow(2)).sum();
                    ((square as f64).sqrt() - radius as f64).abs()
                };
                let times = chosen[0] / point[0];
                assert_eq!(point.map(|x| x * times), chosen);
                let longest = point.iter().max().unwrap();
                let mut all = (1..=radius / longest).step_by(stride);
                assert!(all.all(|other| off(times) <= off(other)), "{point:?}");
            }
        }
    }

    #[test]
    fn the_first_point_beyond_a_circle() {
        assert_eq!(first_beyond_circle([127, -127], 127), [90, -90]);
        assert_eq!(first_beyond_circle([0, 13], 127), [0, 127]);
        // On the circle.
        assert_eq!(first_beyond_circle([336, 385], 511), [336, 385]);
        assert_eq!(first_beyond_circle([382, 383], 511), [382, 383]);
        let most = (1 << 31) - 1;
        assert_eq!(
            first_beyond_circle([most, most - 1], most),
            [most, most - 1]
        );
    }
}
