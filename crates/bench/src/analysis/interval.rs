//! Figures with their confidence intervals.

use surelight_estimate::{Estimate, Moments, student_t_quantile, welch_test};

use super::CONFIDENCE;

/// An estimate with its confidence interval.
#[derive(Clone, Copy, Debug, PartialEq, serde::Serialize)]
pub struct Interval {
    /// Point estimate.
    pub value: f64,
    /// Lower end.
    pub low: f64,
    /// Upper end.
    pub high: f64,
}

impl Interval {
    /// Mean of independent figures and its Student interval; infinite for one figure alone.
    pub(crate) fn of(figures: &[f64]) -> Option<Self> {
        let moments: Moments = figures.iter().copied().collect();
        if moments.count() == 0 {
            return None;
        }
        let half = half_width(&moments);
        Some(Self { value: moments.mean(), low: moments.mean() - half, high: moments.mean() + half })
    }

    /// The same on a logarithmic scale: geometric mean and interval of figures above zero.
    pub(super) fn of_ratio(figures: &[f64]) -> Option<Self> {
        let logs: Vec<f64> = figures.iter().map(|x| x.ln()).collect();
        Self::of(&logs).map(|i| Self { value: i.value.exp(), low: i.low.exp(), high: i.high.exp() })
    }

    /// Whether the interval contains a value.
    pub fn holds(&self, value: f64) -> bool {
        self.low <= value && value <= self.high
    }
}

fn half_width(moments: &Moments) -> f64 {
    match moments.count() {
        0 | 1 => f64::INFINITY,
        n => student_t_quantile(0.5 + 0.5 * CONFIDENCE, (n - 1) as f64) * moments.variance_of_mean().sqrt(),
    }
}

/// Ratio of two sets of independent figures above zero, by Welch's t on their logarithms.
pub(crate) fn ratio(a: &[f64], b: &[f64]) -> Option<(Interval, f64)> {
    let [x, y] = [a, b].map(|figures| {
        let moments: Moments = figures.iter().map(|x| x.ln()).collect();
        let variance = if moments.count() < 2 { f64::INFINITY } else { moments.variance_of_mean() };
        (moments.count() > 0).then(|| Estimate {
            mean: moments.mean(),
            variance,
            dof: (moments.count() as f64 - 1.0).max(1.0),
        })
    });
    let test = welch_test(&x?, &y?);
    let dof = if test.dof.is_finite() && test.dof > 0.0 { test.dof } else { 1e9 };
    let half = if test.standard_error == 0.0 {
        0.0
    } else {
        student_t_quantile(0.5 + 0.5 * CONFIDENCE, dof) * test.standard_error
    };
    let d = test.difference;
    Some((Interval { value: d.exp(), low: (d - half).exp(), high: (d + half).exp() }, test.p))
}
