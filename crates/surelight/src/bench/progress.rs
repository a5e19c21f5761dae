//! How far a race is and how long it will take, on standard error.

use std::time::Instant;

use indicatif::{ProgressBar, ProgressDrawTarget, ProgressStyle};
use surelight_bench::Status;

use crate::console;
use crate::progress::human;

/// Steps of a bar.
const STEPS: u64 = 1000;

/// Seconds between lines of a log.
const LOG_INTERVAL_SECONDS: f64 = 15.0;

/// A bar where someone watches, lines of a log where not, or nothing.
pub(super) enum Progress {
    Quiet,
    Bar { bar: ProgressBar, scenes: usize },
    Log { last: Option<Instant>, scenes: usize },
}

impl Progress {
    pub(super) fn new(quiet: bool, scenes: usize) -> Self {
        if quiet {
            return Self::Quiet;
        }
        if !console::watched() {
            return Self::Log { last: None, scenes };
        }
        let bar = ProgressBar::with_draw_target(Some(STEPS), ProgressDrawTarget::stderr_with_hz(5));
        let style = ProgressStyle::with_template("{wide_bar} {msg}");
        bar.set_style(style.unwrap_or_else(|_| ProgressStyle::default_bar()));
        Self::Bar { bar, scenes }
    }

    /// Shows the progress of the race on a scene.
    pub(super) fn update(&mut self, scene: &str, number: usize, status: &Status) {
        match self {
            Self::Quiet => {}
            Self::Bar { bar, scenes } => {
                bar.set_position((status.share * STEPS as f64) as u64);
                bar.set_message(sentence(scene, number, *scenes, status));
            }
            Self::Log { last, scenes } => {
                if last.is_none_or(|last| last.elapsed().as_secs_f64() >= LOG_INTERVAL_SECONDS) {
                    *last = Some(Instant::now());
                    console::note(&sentence(scene, number, *scenes, status));
                }
            }
        }
    }

    /// Takes the bar away.
    pub(super) fn finish(&self) {
        if let Self::Bar { bar, .. } = self {
            bar.finish_and_clear();
        }
    }
}

/// "veach-mis (scene 2 of 5): mis/sobol, repeat 1 of 4, 40 % done, 1 min 20 s left".
fn sentence(scene: &str, number: usize, scenes: usize, status: &Status) -> String {
    let which = if scenes > 1 { format!(" (scene {} of {scenes})", number + 1) } else { String::new() };
    let mut text = format!("{scene}{which}: {}", status.stage);
    if status.share > 0.0 {
        text += &format!(", {:.0} % done", 100.0 * status.share);
        if status.share > 0.02 {
            text += &format!(", {} left", human(status.seconds * (1.0 - status.share) / status.share));
        }
    }
    text
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_status_reads_well() {
        let status = Status { stage: "mis/sobol, repeat 1 of 4".into(), share: 0.4, seconds: 40.0 };
        assert_eq!(sentence("box", 0, 1, &status), "box: mis/sobol, repeat 1 of 4, 40 % done, 1 min 0 s left");
        assert!(sentence("box", 1, 5, &status).starts_with("box (scene 2 of 5): mis/sobol"));
    }
}
