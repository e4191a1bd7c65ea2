//! Quadratic equations.

/// The real roots of `a t^2 + b t + c`, ascending.
///
/// `None` if there is no real root or if all coefficients but `c` are zero. The root of a linear equation (`a = 0`) is returned
/// twice. Each root is accurate to a few units in the last place of the coefficients: cancellation is possible only in the
/// discriminant, which is evaluated with a fused product.
///
/// # Source
/// @higham2002 section 1.8; discriminant after @kahan2004.
#[must_use]
pub fn roots(a: f64, b: f64, c: f64) -> Option<[f64; 2]> {
    if a == 0.0 {
        if b == 0.0 {
            return None;
        }
        let t = -c / b;
        return Some([t, t]);
    }
    let half = 0.5 * b;
    let discriminant = difference_of_products(half, half, a, c);
    if discriminant < 0.0 || discriminant.is_nan() {
        return None;
    }
    let q = -(half + discriminant.sqrt().copysign(half));
    let (t0, t1) = if q == 0.0 { (0.0, 0.0) } else { (q / a, c / q) };
    Some(if t0 <= t1 { [t0, t1] } else { [t1, t0] })
}

/// `a b - c d` to 1.5 units in the last place.
///
/// # Source
/// @jeannerod2013.
#[must_use]
pub fn difference_of_products(a: f64, b: f64, c: f64, d: f64) -> f64 {
    let cd = c * d;
    let difference = a.mul_add(b, -cd);
    let error = (-c).mul_add(d, cd);
    difference + error
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn roots_far_apart_lose_no_digits() {
        // (t - 1e8)(t - 1e-8)
        let [t0, t1] = roots(1.0, -(1e8 + 1e-8), 1.0).unwrap();
        assert!((t0 - 1e-8).abs() < 1e-23);
        assert!((t1 - 1e8).abs() < 1e-7);
    }

    #[test]
    fn linear_constant_and_rootless_equations() {
        assert_eq!(roots(0.0, 2.0, -4.0), Some([2.0, 2.0]));
        assert_eq!(roots(0.0, 0.0, 1.0), None);
        assert_eq!(roots(1.0, 0.0, 1.0), None);
        assert_eq!(roots(1.0, 0.0, 0.0), Some([0.0, 0.0]));
        assert_eq!(roots(f64::NAN, 0.0, 0.0), None);
    }

    #[test]
    fn double_root_is_found_where_the_discriminant_cancels() {
        // (t - 1.1)^2 with rounded coefficients: the root is accurate to at least half of the digits.
        if let Some([t0, t1]) = roots(1.0, -2.2, 1.21) {
            assert!((t0 - 1.1).abs() < 1e-7 && (t1 - 1.1).abs() < 1e-7);
        }
        let [t0, t1] = roots(1.0, -2.0, 1.0).unwrap();
        assert_eq!([t0, t1], [1.0, 1.0]);
    }
}
