//! Differences between two versions, with their standard errors.

use surelight_estimate::{Moments, normal_survival, satterthwaite, student_t_quantile, student_t_survival};

use crate::{
    analysis::{CONFIDENCE, Interval},
    data::Row,
};

/// A logarithm of a ratio with its standard error.
pub(super) struct Shift {
    pub(super) value: f64,
    pub(super) se: f64,
    pub(super) dof: f64,
}

impl Shift {
    /// Probability of a value at least as far above zero by chance.
    fn p(&self, beyond: f64) -> f64 {
        let far = self.value - beyond;
        if self.se == 0.0 {
            return if far > 0.0 { 0.0 } else { 1.0 };
        }
        if self.dof.is_finite() { student_t_survival(far / self.se, self.dof) } else { normal_survival(far / self.se) }
    }

    /// Whether it is above a limit, one-sided.
    pub(super) fn exceeds(&self, limit: f64, level: f64) -> bool {
        self.p(limit) < level
    }

    /// Whether it is further from zero than a limit, either way.
    pub(super) fn differs(&self, limit: f64, level: f64) -> bool {
        let mirrored = Self { value: -self.value, ..*self };
        self.p(limit) < level / 2.0 || mirrored.p(limit) < level / 2.0
    }

    /// 95 % interval.
    pub(super) fn interval(&self, of: impl Fn(f64) -> f64) -> Interval {
        let half = if self.se == 0.0 { 0.0 } else { student_t_quantile(0.5 + 0.5 * CONFIDENCE, self.dof) * self.se };
        Interval { value: of(self.value), low: of(self.value - half), high: of(self.value + half) }
    }
}

/// Welch's difference of two means; `None` where one has no variance.
pub(super) fn shift([old, new]: &[Moments; 2]) -> Option<Shift> {
    if old.count() < 2 || new.count() < 2 {
        return None;
    }
    let (a, b) = (old.variance_of_mean(), new.variance_of_mean());
    let dof = satterthwaite(&[(a, old.count() as f64 - 1.0), (b, new.count() as f64 - 1.0)]);
    Some(Shift { value: new.mean() - old.mean(), se: (a + b).sqrt(), dof })
}

/// Relative difference of the mean radiance.
pub(super) fn mean_shift(rows: &[Vec<&Row>; 2]) -> Option<Shift> {
    let of = |rows: &[&Row]| {
        let n = rows.len() as f64;
        let variance: f64 = rows.iter().map(|r| r.mean_se.map(|se| se * se)).sum::<Option<f64>>()? / (n * n);
        Some((rows.iter().map(|r| r.mean).sum::<f64>() / n, variance))
    };
    let ((old, a), (new, b)) = (of(&rows[0])?, of(&rows[1])?);
    (old > 0.0).then(|| Shift { value: (new - old) / old, se: (a + b).sqrt() / old, dof: f64::INFINITY })
}
