//! The grids of quadrature rules: the device evaluates the formula at the nodes, the host adds up.

use surelight_estimate::{Rule, RuleError};

use super::{Integrand, MAX_NODES};
use crate::error::RenderError;
use surelight_prepare::shared::IntegrationTask;

/// The result of a quadrature rule.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Grid {
    /// The integral.
    pub estimate: f64,
    /// Values that were not finite, counted as 0.
    pub non_finite: u64,
    /// Evaluations of the formula.
    pub evaluations: u64,
}

impl Integrand<'_> {
    /// The tensor product of a rule with `points` nodes per dimension; fewer than 2^32 in all.
    ///
    /// # Errors
    /// Where the rule does not exist (the inner error) or the device fails.
    pub fn grid(&mut self, rule: Rule, points: usize) -> Result<Result<Grid, RuleError>, RenderError> {
        let dimensions = self.bounds.len();
        let nodes = match rule.nodes(points) {
            Ok(nodes) => nodes,
            Err(error) => return Ok(Err(error)),
        };
        let total = u32::try_from(dimensions).ok().and_then(|d| (points as u64).checked_pow(d));
        let Some(total) = total.filter(|&t| t <= u64::from(u32::MAX) && points * dimensions <= MAX_NODES) else {
            return Ok(Err(RuleError::TooMany { points, dimensions }));
        };
        let axes: Vec<Vec<f32>> = self
            .bounds
            .iter()
            .map(|[a, b]| nodes.iter().map(|(x, _)| (0.5 * (a + b) + 0.5 * (b - a) * x) as f32).collect())
            .collect();
        let (mut sum, mut non_finite) = (0.0, 0);
        let scale = self.volume() / 2f64.powi(dimensions as i32);
        self.nodes(&axes, total as u32, &mut |first, values| {
            // Indices of the first node on all axes, then incremented.
            let mut digits = vec![0; dimensions];
            let mut rest = first as usize;
            for digit in &mut digits {
                *digit = rest % points;
                rest /= points;
            }
            for value in values {
                if value.is_finite() {
                    sum += f64::from(*value) * digits.iter().map(|&d| nodes[d].1).product::<f64>();
                } else {
                    non_finite += 1;
                }
                for digit in &mut digits {
                    *digit += 1;
                    if *digit < points {
                        break;
                    }
                    *digit = 0;
                }
            }
        })?;
        Ok(Ok(Grid { estimate: sum * scale, non_finite, evaluations: total }))
    }

    /// Values at all nodes, in runs: the index of the first node, and the values.
    pub(super) fn nodes(
        &mut self,
        axes: &[Vec<f32>],
        total: u32,
        take: &mut dyn FnMut(u32, &[f32]),
    ) -> Result<(), RenderError> {
        self.device
            .scoped("nodes", || self.device.queue.write_buffer(&self.nodes, 0, bytemuck::cast_slice(&axes.concat())))?;
        let samples = axes[0].len() as u32;
        let mut first = 0;
        while first < total {
            let count = self.lanes.min(total - first);
            let (values, seconds) = self.run(
                &self.nodes_kernel,
                &IntegrationTask { first, count, samples, ..IntegrationTask::default() },
                count,
            )?;
            take(first, &values);
            first += count;
            self.adapt(count, seconds);
        }
        Ok(())
    }
}
