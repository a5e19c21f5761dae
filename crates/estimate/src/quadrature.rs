//! Deterministic quadrature on an interval and, as tensor products, on boxes.

use std::f64::consts::PI;

/// A rule on an interval.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Rule {
    /// Midpoints of n equal parts: error O(n⁻²), no evaluation at the ends.
    Midpoint,
    /// Simpson's composite rule on n points (odd, at least 3): error O(n⁻⁴).
    Simpson,
    /// Gauss–Legendre on n points: exact for polynomials of degree 2n − 1.
    GaussLegendre,
}

/// Why there is no such rule.
#[derive(Debug, Clone, Copy, PartialEq, Eq, thiserror::Error)]
#[non_exhaustive]
pub enum RuleError {
    /// No points.
    #[error("a quadrature rule needs at least one point")]
    NoPoints,
    /// Simpson's rule on an even number of points, or fewer than three.
    #[error("Simpson's rule needs an odd number of points, at least 3, and not {0}")]
    Simpson(usize),
    /// The tensor product has too many points to count.
    #[error("{points} points in each of {dimensions} dimensions are too many")]
    TooMany {
        /// Points per dimension.
        points: usize,
        /// Dimensions.
        dimensions: usize,
    },
}

impl Rule {
    /// Nodes and weights on [−1, 1]; the weights sum to 2.
    ///
    /// # Errors
    /// Where the rule does not exist for this number of points.
    pub fn nodes(self, points: usize) -> Result<Vec<(f64, f64)>, RuleError> {
        if points == 0 {
            return Err(RuleError::NoPoints);
        }
        match self {
            Self::Midpoint => {
                let h = 2.0 / points as f64;
                Ok((0..points).map(|i| ((i as f64 + 0.5) * h - 1.0, h)).collect())
            }
            Self::Simpson if points < 3 || points.is_multiple_of(2) => Err(RuleError::Simpson(points)),
            Self::Simpson => {
                let h = 2.0 / (points - 1) as f64;
                let weight = |i: usize| match i {
                    0 => 1.0,
                    i if i == points - 1 => 1.0,
                    i if i % 2 == 1 => 4.0,
                    _ => 2.0,
                };
                Ok((0..points).map(|i| (i as f64 * h - 1.0, weight(i) * h / 3.0)).collect())
            }
            Self::GaussLegendre => Ok(gauss_legendre(points)),
        }
    }
}

/// Nodes and weights of Gauss–Legendre quadrature on [−1, 1], in ascending order.
///
/// Nodes are the zeros of the Legendre polynomial, by Newton's method from Tricomi's approximation
/// cos(π(i − ¼)/(n + ½)); weights 2/((1 − x²) P′(x)²) (Davis & Rabinowitz, "Methods of Numerical
/// Integration", 1984, section 2.7).
pub fn gauss_legendre(points: usize) -> Vec<(f64, f64)> {
    let n = points as f64;
    let mut nodes = vec![(0.0, 0.0); points];
    for i in 0..points.div_ceil(2) {
        let mut x = (PI * (i as f64 + 0.75) / (n + 0.5)).cos();
        if 2 * i + 1 == points {
            x = 0.0;
        }
        let mut slope = 1.0;
        for _ in 0..100 {
            let (value, derivative) = legendre(points, x);
            slope = derivative;
            let step = value / derivative;
            x -= step;
            if step.abs() <= 2.0 * f64::EPSILON {
                slope = legendre(points, x).1;
                break;
            }
        }
        let weight = 2.0 / ((1.0 - x * x) * slope * slope);
        nodes[i] = (-x, weight);
        nodes[points - 1 - i] = (x, weight);
    }
    nodes
}

/// Legendre polynomial of degree n and its derivative, by Bonnet's recurrence.
fn legendre(n: usize, x: f64) -> (f64, f64) {
    let (mut before, mut value) = (1.0, x);
    if n == 0 {
        return (1.0, 0.0);
    }
    for k in 2..=n {
        let k = k as f64;
        (before, value) = (value, ((2.0 * k - 1.0) * x * value - (k - 1.0) * before) / k);
    }
    (value, n as f64 * (x * value - before) / (x * x - 1.0))
}

/// ∫ f over [a, b] by a rule of so many points.
///
/// # Errors
/// Where the rule does not exist for this number of points.
pub fn integrate(rule: Rule, points: usize, [a, b]: [f64; 2], mut f: impl FnMut(f64) -> f64) -> Result<f64, RuleError> {
    integrate_box(rule, points, &[[a, b]], |x| f(x[0]))
}

/// ∫ f over a box by the tensor product of a rule: `points`^dimensions evaluations. Without
/// dimensions it is f at the only point.
///
/// # Errors
/// Where the rule does not exist for this number of points, or the number of evaluations exceeds
/// 2⁴⁸.
pub fn integrate_box(
    rule: Rule,
    points: usize,
    bounds: &[[f64; 2]],
    mut f: impl FnMut(&[f64]) -> f64,
) -> Result<f64, RuleError> {
    let nodes = rule.nodes(points)?;
    let total = u32::try_from(bounds.len())
        .ok()
        .and_then(|dimensions| (points as u64).checked_pow(dimensions))
        .filter(|&total| total <= 1 << 48)
        .ok_or(RuleError::TooMany { points, dimensions: bounds.len() })?;
    let mut x = vec![0.0; bounds.len()];
    let mut digits = vec![0usize; bounds.len()];
    let mut sum = 0.0;
    for _ in 0..total {
        let mut weight = 1.0;
        for ((x, &digit), [a, b]) in x.iter_mut().zip(&digits).zip(bounds) {
            let (node, w) = nodes[digit];
            let half = 0.5 * (b - a);
            *x = 0.5 * (a + b) + half * node;
            weight *= half * w;
        }
        sum += weight * f(&x);
        for digit in &mut digits {
            *digit += 1;
            if *digit < points {
                break;
            }
            *digit = 0;
        }
    }
    Ok(sum)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn gauss_legendre_is_exact_to_its_degree_and_no_further() {
        for n in [1usize, 2, 3, 7, 16, 33] {
            for degree in 0..=2 * n {
                let exact = if degree % 2 == 0 { 2.0 / (degree as f64 + 1.0) } else { 0.0 };
                let found = integrate(Rule::GaussLegendre, n, [-1.0, 1.0], |x| x.powi(degree as i32)).unwrap();
                // The error at degree 2n is known: 2^(2n+1) (n!)⁴ / ((2n+1) ((2n)!)²).
                let miss: f64 = (1..=n).fold(2.0, |m, i| {
                    let i = i as f64;
                    m * 4.0 * i * i * i * i / ((2.0 * i) * (2.0 * i - 1.0)).powi(2)
                }) / (2.0 * n as f64 + 1.0);
                let expected_miss = if degree == 2 * n { miss } else { 0.0 };
                assert!((exact - found - expected_miss).abs() < 1e-13, "{n} {degree}");
            }
        }
    }

    #[test]
    fn published_nodes() {
        // Abramowitz & Stegun, table 25.4, n = 5.
        let nodes = gauss_legendre(5);
        let expected = [
            (-0.906_179_845_938_664, 0.236_926_885_056_189),
            (-0.538_469_310_105_683, 0.478_628_670_499_366),
            (0.0, 0.568_888_888_888_889),
        ];
        for (found, expected) in nodes.iter().zip(expected) {
            assert!((found.0 - expected.0).abs() < 1e-14 && (found.1 - expected.1).abs() < 1e-14);
        }
        let many = gauss_legendre(1000);
        assert!((many.iter().map(|n| n.1).sum::<f64>() - 2.0).abs() < 1e-12);
        assert!(many.windows(2).all(|w| w[0].0 < w[1].0));
    }

    #[test]
    fn orders_of_the_simple_rules() {
        let error = |rule, n| {
            let found = integrate(rule, n, [0.0, 1.0], f64::exp).unwrap();
            (found - (1f64.exp() - 1.0)).abs()
        };
        let midpoint = (error(Rule::Midpoint, 32) / error(Rule::Midpoint, 64)).log2();
        let simpson = (error(Rule::Simpson, 17) / error(Rule::Simpson, 33)).log2();
        assert!((midpoint - 2.0).abs() < 0.01 && (simpson - 4.0).abs() < 0.02, "{midpoint} {simpson}");
        assert!((integrate(Rule::Simpson, 3, [0.0, 2.0], |x| x.powi(3)).unwrap() - 4.0).abs() < 1e-14);
    }

    #[test]
    fn boxes() {
        // ∫∫∫ x y² z³ over [0,1]×[0,2]×[−1,3] = 1/2 · 8/3 · 20.
        let bounds = [[0.0, 1.0], [0.0, 2.0], [-1.0, 3.0]];
        let found = integrate_box(Rule::GaussLegendre, 3, &bounds, |x| x[0] * x[1].powi(2) * x[2].powi(3)).unwrap();
        assert!((found - 80.0 / 3.0).abs() < 1e-12, "{found}");
        let mut calls = 0;
        integrate_box(Rule::Midpoint, 4, &bounds, |_| {
            calls += 1;
            0.0
        })
        .unwrap();
        assert_eq!(calls, 64);
    }

    #[test]
    fn impossible_rules_are_refused() {
        assert_eq!(Rule::Simpson.nodes(4), Err(RuleError::Simpson(4)));
        assert_eq!(Rule::Midpoint.nodes(0), Err(RuleError::NoPoints));
        let bounds = [[0.0, 1.0]; 40];
        assert!(matches!(integrate_box(Rule::Midpoint, 10, &bounds, |_| 0.0), Err(RuleError::TooMany { .. })));
    }
}
