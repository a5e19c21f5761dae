//! Goodness of fit: do samples follow their stated density, are p-values uniform?

use crate::chi_squared_survival;

/// Why a χ² test could not be made.
#[derive(Debug, Clone, Copy, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum ChiSquaredError {
    /// The tables differ in length.
    #[error("there are {observed} observed cells and {expected} expected ones")]
    Length {
        /// Cells observed.
        observed: usize,
        /// Cells expected.
        expected: usize,
    },
    /// An expected count is negative or not a number.
    #[error("cell {cell} is expected {value} times")]
    Expected {
        /// The cell.
        cell: usize,
        /// Its expected count.
        value: f64,
    },
    /// The expected counts do not add up to the number of samples: the density does not integrate
    /// to one.
    #[error("{observed} samples were drawn, but the density expects {expected}")]
    Total {
        /// Samples drawn.
        observed: u64,
        /// Sum of the expected counts.
        expected: f64,
    },
    /// Fewer than two cells are left after pooling.
    #[error("there are too few samples for two cells")]
    TooFew,
}

/// Result of [`chi_squared_test`].
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ChiSquaredTest {
    /// Σ (observed − expected)²/expected over the cells left.
    pub statistic: f64,
    /// Cells left less one.
    pub dof: f64,
    /// Probability of at least this statistic where the samples follow the density.
    pub p: f64,
    /// Cells that went into the pooled one.
    pub pooled: usize,
}

/// Pearson's χ² test of cell counts. Cells expected fewer than `min_expected` times (5 is
/// customary, after Cochran 1954) are pooled into one, smallest first, until that reaches it. A
/// sample in a cell of no probability is a certain failure.
///
/// # Errors
/// Where the tables do not fit, an expected count is negative, the totals differ by more than 0.1 %
/// (an error of the density, to be reported and not tested), or fewer than two cells remain.
pub fn chi_squared_test(
    observed: &[u64],
    expected: &[f64],
    min_expected: f64,
) -> Result<ChiSquaredTest, ChiSquaredError> {
    if observed.len() != expected.len() {
        return Err(ChiSquaredError::Length { observed: observed.len(), expected: expected.len() });
    }
    if let Some((cell, &value)) = expected.iter().enumerate().find(|(_, value)| !(**value >= 0.0 && value.is_finite()))
    {
        return Err(ChiSquaredError::Expected { cell, value });
    }
    let (drawn, total): (u64, f64) = (observed.iter().sum(), expected.iter().sum());
    if (total - drawn as f64).abs() > 1e-3 * drawn as f64 {
        return Err(ChiSquaredError::Total { observed: drawn, expected: total });
    }
    let mut order: Vec<usize> = (0..expected.len()).collect();
    order.sort_by(|&a, &b| expected[a].total_cmp(&expected[b]));
    let impossible = order.iter().any(|&cell| expected[cell] == 0.0 && observed[cell] > 0);

    let (mut statistic, mut cells, mut pooled) = (0.0, 0usize, 0usize);
    let mut add = |count: f64, mean: f64| {
        statistic += (count - mean).powi(2) / mean;
        cells += 1;
    };
    let mut order = order.into_iter().peekable();
    let (mut pool_count, mut pool_mean) = (0.0, 0.0);
    while let Some(&cell) = order.peek()
        && (expected[cell] < min_expected || (pool_mean > 0.0 && pool_mean < min_expected))
    {
        pool_count += observed[cell] as f64;
        pool_mean += expected[cell];
        pooled += 1;
        order.next();
    }
    if pool_mean > 0.0 {
        add(pool_count, pool_mean);
    }
    for cell in order {
        add(observed[cell] as f64, expected[cell]);
    }
    if cells < 2 {
        return Err(ChiSquaredError::TooFew);
    }
    let dof = (cells - 1) as f64;
    let (statistic, p) =
        if impossible { (f64::INFINITY, 0.0) } else { (statistic, chi_squared_survival(statistic, dof)) };
    Ok(ChiSquaredTest { statistic, dof, p, pooled })
}

/// Result of [`uniformity_test`].
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct UniformityTest {
    /// Largest distance between the empirical distribution and the uniform one.
    pub distance: f64,
    /// Probability of at least this distance where the values are uniform.
    pub p: f64,
}

/// Kolmogorov–Smirnov test that values, such as p-values, are uniform on [0, 1].
///
/// The p-value is Kolmogorov's series with Stephens' correction for finite n ("Use of the
/// Kolmogorov–Smirnov, Cramér–von Mises and related statistics without extensive tables", JRSS B 32
/// (1970)): good to three digits from n = 8 on. No values, or one that is not a number, give NaN.
pub fn uniformity_test(values: &[f64]) -> UniformityTest {
    let n = values.len() as f64;
    if values.is_empty() || values.iter().any(|value| value.is_nan()) {
        return UniformityTest { distance: f64::NAN, p: f64::NAN };
    }
    let mut sorted = values.to_vec();
    sorted.sort_by(f64::total_cmp);
    let distance =
        sorted.iter().enumerate().map(|(i, &x)| (x - i as f64 / n).max((i + 1) as f64 / n - x)).fold(0.0, f64::max);
    let lambda = (n.sqrt() + 0.12 + 0.11 / n.sqrt()) * distance;
    UniformityTest { distance, p: kolmogorov_survival(lambda) }
}

/// P(K > λ) of Kolmogorov's distribution: 2 Σ (−1)^(k−1) exp(−2k²λ²), or its theta transform where
/// that converges faster.
fn kolmogorov_survival(lambda: f64) -> f64 {
    use std::f64::consts::{PI, TAU};
    if lambda < 0.04 {
        1.0
    } else if lambda < 1.0 {
        let term = |k: i32| (-(f64::from(2 * k - 1) * PI / lambda).powi(2) / 8.0).exp();
        1.0 - TAU.sqrt() / lambda * (1..=4).map(term).sum::<f64>()
    } else {
        let term = |k: i32| (if k % 2 == 1 { 2.0 } else { -2.0 }) * (-2.0 * (f64::from(k) * lambda).powi(2)).exp();
        (1..=5).map(term).sum()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::testing::Random;

    #[test]
    fn die_by_hand() {
        // 60 throws: (5² + 2² + 1² + 0² + 1² + 7²)/10 = 8 on 5 degrees of freedom, p = 0.1562356.
        let test = chi_squared_test(&[5, 8, 9, 10, 11, 17], &[10.0; 6], 5.0).unwrap();
        assert!((test.statistic - 8.0).abs() < 1e-12);
        assert_eq!((test.dof, test.pooled), (5.0, 0));
        assert!((test.p - 0.156_235_6).abs() < 1e-6, "{}", test.p);
    }

    #[test]
    fn small_cells_are_pooled() {
        // Expected 1, 2, 3 pool to 6; the rest remain alone.
        let test = chi_squared_test(&[1, 40, 2, 3, 54], &[2.0, 42.0, 1.0, 3.0, 52.0], 5.0).unwrap();
        assert_eq!((test.pooled, test.dof), (3, 2.0));
        assert!((test.statistic - (4.0 / 42.0 + 4.0 / 52.0)).abs() < 1e-12);
        // Too little for a separate cell: the next larger one joins the pool.
        let test = chi_squared_test(&[1, 40, 59], &[1.0, 40.0, 59.0], 5.0).unwrap();
        assert_eq!((test.pooled, test.dof), (2, 1.0));
    }

    #[test]
    fn impossible_samples_and_wrong_densities_are_found() {
        let impossible = chi_squared_test(&[50, 49, 1], &[50.0, 50.0, 0.0], 5.0).unwrap();
        assert_eq!(impossible.p, 0.0);
        assert!(chi_squared_test(&[50, 50, 0], &[50.0, 50.0, 0.0], 5.0).unwrap().p > 0.99);
        let total = chi_squared_test(&[50, 50], &[50.0, 51.0], 5.0);
        assert!(matches!(total, Err(ChiSquaredError::Total { .. })));
        assert!(matches!(chi_squared_test(&[1], &[], 5.0), Err(ChiSquaredError::Length { .. })));
        assert!(matches!(chi_squared_test(&[1, 0], &[2.0, -1.0], 5.0), Err(ChiSquaredError::Expected { cell: 1, .. })));
        assert!(matches!(chi_squared_test(&[3, 1], &[3.0, 1.0], 5.0), Err(ChiSquaredError::TooFew)));
    }

    #[test]
    fn fair_cells_pass_and_a_tilt_of_two_percent_fails() {
        let run = |tilt: f64| {
            let mut random = Random::new(5);
            let mut counts = [0u64; 32];
            for _ in 0..1_000_000 {
                let u = random.uniform();
                // Density 1 + tilt·(2u − 1), by its inverse distribution function to first order.
                let x = u - tilt * u * (u - 1.0);
                counts[((x * 32.0) as usize).min(31)] += 1;
            }
            chi_squared_test(&counts, &[31250.0; 32], 5.0).unwrap().p
        };
        assert!(run(0.0) > 0.01, "{}", run(0.0));
        assert!(run(0.02) < 1e-6);
    }

    #[test]
    fn kolmogorov_table() {
        // Critical values of the limiting distribution: 1.2238 (10 %), 1.3581 (5 %), 1.6276 (1 %);
        // median 0.82757.
        for (lambda, p) in [(1.22385, 0.1), (1.35810, 0.05), (1.62762, 0.01), (0.827574, 0.5)] {
            assert!((kolmogorov_survival(lambda) - p).abs() < 2e-5, "{lambda}");
        }
        assert!((kolmogorov_survival(0.999_999) - kolmogorov_survival(1.000_001)).abs() < 1e-5);
        // Exact 5 % point for n = 10 is D = 0.40925 (Miller 1956).
        let at = |d: f64| kolmogorov_survival((10f64.sqrt() + 0.12 + 0.11 / 10f64.sqrt()) * d);
        assert!((at(0.40925) - 0.05).abs() < 1e-3);
    }

    #[test]
    fn uniform_values_pass_and_others_fail() {
        let mut random = Random::new(9);
        let values: Vec<f64> = (0..1000).map(|_| random.uniform()).collect();
        assert!(uniformity_test(&values).p > 0.01);
        let bent: Vec<f64> = values.iter().map(|x| x.powf(1.2)).collect();
        assert!(uniformity_test(&bent).p < 0.01);
        assert!(uniformity_test(&[]).p.is_nan());
        // One value: D = max(x, 1 − x).
        assert!((uniformity_test(&[0.3]).distance - 0.7).abs() < 1e-15);
    }
}
