//! One simple root inside a bracket, to the last digits.
//!
//! Chandrupatla's method: inverse quadratic interpolation where the last three points allow it,
//! bisection otherwise. Source: T. R. Chandrupatla, Adv. Eng. Software 28 (1997) 145-149.

/// Root of `f` in [a, b], given f(a) and f(b) of opposite sign.
pub fn root_in_bracket(
    mut f: impl FnMut(f64) -> f64,
    (mut a, mut fa): (f64, f64),
    (mut b, mut fb): (f64, f64),
) -> f64 {
    if fa == 0.0 {
        return a;
    }
    let mut step = 0.5;
    // Bisection alone needs fewer than 1100 halvings of any double interval.
    for _ in 0..1200 {
        let x = a + step * (b - a);
        let fx = f(x);
        let (c, fc) = if (fx > 0.0) == (fa > 0.0) {
            (a, fa)
        } else {
            let old = (b, fb);
            (b, fb) = (a, fa);
            old
        };
        (a, fa) = (x, fx);
        let (best, f_best) = if fa.abs() < fb.abs() { (a, fa) } else { (b, fb) };
        let tolerance = f64::EPSILON * best.abs() + f64::MIN_POSITIVE;
        let limit = tolerance / (b - a).abs();
        if limit > 0.5 || f_best == 0.0 {
            return best;
        }
        let xi = (a - b) / (c - b);
        let phi = (fa - fb) / (fc - fb);
        let interpolate = phi * phi < xi && (1.0 - phi).powi(2) < 1.0 - xi;
        step = if interpolate {
            fa / (fb - fa) * fc / (fb - fc) + (c - a) / (b - a) * fa / (fc - fa) * fb / (fc - fb)
        } else {
            0.5
        };
        step = step.clamp(limit, 1.0 - limit);
    }
    if fa.abs() < fb.abs() { a } else { b }
}

#[cfg(test)]
mod tests {
    use super::root_in_bracket;

    #[test]
    fn finds_roots_of_known_functions_to_the_last_digits() {
        let root = root_in_bracket(|x| x * x - 2.0, (0.0, -2.0), (2.0, 2.0));
        assert!((root - std::f64::consts::SQRT_2).abs() <= 2.0 * f64::EPSILON);
        // Flat at the root: interpolation is useless and bisection must take over.
        let root = root_in_bracket(|x| (x - 1.0).powi(9), (0.0, -1.0), (3.0, 512.0));
        assert!((root - 1.0).abs() < 1e-12);
    }

    #[test]
    fn needs_few_evaluations_where_the_function_is_smooth() {
        let mut calls = 0;
        let root = root_in_bracket(
            |x| {
                calls += 1;
                x.exp() - 3.0
            },
            (0.0, -2.0),
            (2.0, 2.0_f64.exp() - 3.0),
        );
        assert!((root - 3.0_f64.ln()).abs() < 1e-15);
        assert!(calls < 16, "{calls}");
    }
}
