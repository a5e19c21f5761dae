//! The mathematics of Monte Carlo estimates, without any rendering: moments, intervals, tests,
//! tails, quadrature and low-discrepancy points.
//!
//! Names follow Bala's lecture "Monte Carlo Rendering" (CS 6620): a *primary estimator* is
//! f(x)/p(x) of one sample, a *secondary estimator* the mean of N of them, with variance σ²/N.
//! Every function names its source; arguments outside a function's domain give NaN unless an error
//! is documented.
//!
//! ```
//! use surelight_estimate::{Estimate, Moments, student_t_half_width, welch_test};
//!
//! // The lecture's example: ∫₀¹ 5x⁴ dx = 1 by four uniform samples.
//! let samples: Moments = [0.86f64, 0.41, 0.02, 0.38].into_iter().map(|x| 5.0 * x.powi(4)).collect();
//! let error = samples.variance_of_mean().sqrt();
//! assert!((samples.mean() - 0.75).abs() < 0.005);
//! // At 95 % the interval is wide, and holds the truth.
//! assert!((samples.mean() - 1.0).abs() < student_t_half_width(0.95, error, 3.0));
//! let measured = Estimate { mean: samples.mean(), variance: error * error, dof: 3.0 };
//! assert!(welch_test(&measured, &Estimate::exact(1.0)).p > 0.05);
//! ```

mod bounds;
mod distributions;
mod goodness;
mod hypothesis;
mod moments;
mod quadrature;
mod sequence;
pub mod sobol;
mod tail;
#[cfg(test)]
mod testing;

pub use bounds::{chebyshev_half_width, chebyshev_samples, student_t_half_width};
pub use distributions::{
    chi_squared_cdf, chi_squared_quantile, chi_squared_survival, normal_cdf, normal_quantile, normal_survival,
    student_t_cdf, student_t_quantile, student_t_survival,
};
pub use goodness::{ChiSquaredError, ChiSquaredTest, UniformityTest, chi_squared_test, uniformity_test};
pub use hypothesis::{
    Estimate, WelchTest, ZTest, detectable_bias, samples_to_detect, satterthwaite, sidak_adjusted, sidak_level,
    welch_test, z_test,
};
pub use moments::Moments;
pub use quadrature::{Rule, RuleError, gauss_legendre, integrate, integrate_box};
pub use sequence::{AsymptoticSequence, EmpiricalBernstein};
pub use tail::{ParetoFit, pareto_k};
