//! The budget of each method, and its checkpoints.

use std::path::PathBuf;

use crate::{data::Clock, method::Method, overlay::Peer};

/// The budget of a race.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Budget {
    /// Seconds for each method, all its repeats together.
    Seconds(f64),
    /// Samples per pixel in each repeat.
    Samples(u32),
    /// Seconds for the whole scene, including setup and the reference.
    Total(f64),
}

/// The methods of a race and its budget.
#[derive(Clone, Debug)]
pub struct Plan {
    /// The methods.
    pub methods: Vec<Method>,
    /// Repeats of each, at least 2: bands and intervals come from them.
    pub repeats: u32,
    /// The budget.
    pub budget: Budget,
    /// The clock of the budget.
    pub clock: Clock,
    /// An image as reference, instead of a render.
    pub reference: Option<PathBuf>,
    /// Other renderers' points, for the charts.
    pub peers: Vec<Peer>,
    /// Exposure of the report's pictures, in stops.
    pub exposure: f64,
}

/// The part of the time of all methods together that is spent on the reference.
pub(crate) const REFERENCE_SHARE: f64 = 0.5;

/// Maximum samples per pixel of a run: f32 counts are exact up to this number.
pub(crate) const MAX_SAMPLES: f64 = 16_777_216.0;

/// Seconds of one sample per pixel.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Cost {
    /// By the clock of the budget.
    pub(crate) clock: f64,
    /// By the wall clock.
    pub(crate) wall: f64,
}

impl Plan {
    /// Samples per pixel in each repeat of each method, after `spent` wall-clock seconds.
    pub(crate) fn lengths(&self, costs: &[Cost], spent: f64) -> Vec<u32> {
        let repeats = f64::from(self.repeats);
        let methods = self.methods.len() as f64;
        let length = |seconds: f64, cost: f64| (seconds / repeats / cost).clamp(1.0, MAX_SAMPLES) as u32;
        match self.budget {
            Budget::Samples(n) => vec![n; costs.len()],
            Budget::Seconds(s) => costs.iter().map(|cost| length(s, cost.clock)).collect(),
            Budget::Total(s) => {
                let reference = if self.reference.is_some() { 0.0 } else { REFERENCE_SHARE };
                let left = (s - spent).max(0.1 * s);
                // A tenth is for pictures and figures.
                let a_method = 0.9 * left / (1.0 + reference) / methods;
                // Equal time by the clock of the budget, though the remaining time is wall-clock
                // time.
                let [wall, clock] = [costs.iter().map(|c| c.wall).sum::<f64>(), costs.iter().map(|c| c.clock).sum()];
                costs.iter().map(|cost| length(a_method * clock / wall, cost.clock)).collect()
            }
        }
    }
}

/// Powers of two up to `length`, and `length`; the last power is omitted where it is close to the
/// end.
pub(crate) fn checkpoints(length: u32) -> Vec<u32> {
    let powers = (0..32).map(|k| 1u32 << k).take_while(|&n| 5 * u64::from(n) <= 4 * u64::from(length));
    powers.chain([length]).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn time_is_shared_out() {
        let plan = |budget| Plan {
            methods: vec![Method::DEFAULT; 2],
            repeats: 4,
            budget,
            clock: Clock::Wall,
            reference: None,
            peers: Vec::new(),
            exposure: 0.0,
        };
        let costs = [Cost { clock: 0.01, wall: 0.01 }, Cost { clock: 0.02, wall: 0.02 }];
        assert_eq!(plan(Budget::Samples(7)).lengths(&costs, 0.0), [7, 7]);
        assert_eq!(plan(Budget::Seconds(8.0)).lengths(&costs, 99.0), [200, 100]);
        // 90 s of 110 remain, nine tenths of them for the race: 81 s, a third of it for the
        // reference, 27 s per method.
        assert_eq!(plan(Budget::Total(110.0)).lengths(&costs, 20.0), [675, 337]);
        // A machine with half its time for others: the same wall-clock time, half the CPU time.
        let shared = costs.map(|cost| Cost { wall: 2.0 * cost.clock, ..cost });
        assert_eq!(plan(Budget::Total(110.0)).lengths(&shared, 20.0), [337, 168]);
        // At least one sample, regardless of the time spent.
        assert_eq!(plan(Budget::Total(1e-9)).lengths(&costs, 20.0), [1, 1]);
    }

    #[test]
    fn checkpoints_double_and_end_where_the_time_does() {
        assert_eq!(checkpoints(1), [1]);
        assert_eq!(checkpoints(16), [1, 2, 4, 8, 16]);
        assert_eq!(checkpoints(19), [1, 2, 4, 8, 19]);
        assert_eq!(checkpoints(20), [1, 2, 4, 8, 16, 20]);
        assert_eq!(checkpoints(100), [1, 2, 4, 8, 16, 32, 64, 100]);
    }
}
