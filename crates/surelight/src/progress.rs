//! How far a render is: a bar where a person watches standard error, a line now and then in a log.

use std::path::Path;
use std::time::Duration;

use indicatif::{ProgressBar, ProgressDrawTarget, ProgressStyle};
use surelight_render::{self as render, Goal};

use crate::console;

/// Steps of the bar from start to target.
const STEPS: u64 = 1000;
/// Shortest time between two lines in a log, seconds.
const LOG_INTERVAL_SECONDS: f64 = 10.0;
/// Longest time between two lines in a log, seconds.
const MAX_LOG_INTERVAL_SECONDS: f64 = 300.0;

/// Share of the work that is done: the samples or the time, whichever is nearer its end.
fn done(status: &render::Progress, goal: Goal) -> f64 {
    let time = goal.time.map_or(0.0, |limit| match limit.as_secs_f64() {
        0.0 => 1.0,
        limit => status.seconds / limit,
    });
    status.share.unwrap_or(0.0).max(time).min(1.0)
}

/// "12 of 64 samples per pixel, 14.2 Mrays/s, 12 s left".
fn sentence(status: &render::Progress) -> String {
    let mut text = match status.target {
        // Tiles and batches finish at different times: an average says more than the samples that
        // all pixels have.
        Some(target) => {
            let samples = (status.share.unwrap_or(0.0) * f64::from(target)).floor();
            format!("{samples} of {target} samples per pixel")
        }
        None if status.pilot => "a pilot that finds out how many samples it will take".to_owned(),
        None => samples_per_pixel(status.spp.into()),
    };
    if status.counts.rays > 0 {
        text += &format!(", {:.3} Mrays/s", Significant(mega_rate(status.counts.rays, status.seconds)));
    }
    if let Some(left) = status.seconds_left {
        text += &format!(", {} left", human(left));
    }
    text
}

/// Shows the progress of a render; silent with `--quiet`.
#[derive(Debug)]
pub(crate) enum Progress {
    /// Nothing is shown.
    Quiet,
    /// A bar that is drawn over itself.
    Bar(ProgressBar),
    /// Lines of a log.
    Log {
        /// When the next line is due, in seconds since the first pass began.
        next: f64,
    },
}

impl Progress {
    /// Begins to show progress, unless it is unwanted.
    pub(crate) fn new(quiet: bool) -> Self {
        if quiet {
            return Self::Quiet;
        }
        if !console::watched() {
            return Self::Log { next: LOG_INTERVAL_SECONDS };
        }
        let bar = ProgressBar::with_draw_target(Some(STEPS), ProgressDrawTarget::stderr_with_hz(10));
        bar.set_style(ProgressStyle::with_template("{spinner} {msg}").unwrap_or_else(|_| ProgressStyle::default_bar()));
        bar.enable_steady_tick(Duration::from_millis(100));
        Self::Bar(bar)
    }

    /// Shows the stages before the first sample.
    pub(crate) fn stage(&self, what: &str, path: &Path) {
        if let Self::Bar(bar) = self {
            bar.set_message(console::printable(&format!("{what} {}", path.display())).into_owned());
        }
    }

    /// The first pass is about to begin.
    pub(crate) fn start_tracing(&self, width: u32, height: u32, adapter: &str, goal: Goal) {
        match self {
            Self::Quiet => {}
            Self::Bar(bar) => {
                let style = ProgressStyle::with_template("{wide_bar} {msg}");
                bar.set_style(style.unwrap_or_else(|_| ProgressStyle::default_bar()));
                bar.set_message("");
            }
            Self::Log { .. } => {
                let samples = goal.spp.map_or(String::new(), |spp| {
                    let most = if goal.precision.is_some() { "at most " } else { "" };
                    format!(", {most}{}", samples_per_pixel(spp.into()))
                });
                console::note(&format!("tracing {width}x{height} pixels{samples} on {adapter}"));
            }
        }
    }

    /// Shows the status, if it is time to.
    pub(crate) fn update(&mut self, status: &render::Progress, goal: Goal) {
        match self {
            Self::Quiet => {}
            Self::Bar(bar) => {
                bar.set_position((done(status, goal) * STEPS as f64) as u64);
                bar.set_message(sentence(status));
            }
            Self::Log { next } => {
                if status.seconds >= *next {
                    console::note(&sentence(status));
                    // Ever fewer lines: a log of a night is read in one glance.
                    *next =
                        status.seconds + (status.seconds / 4.0).clamp(LOG_INTERVAL_SECONDS, MAX_LOG_INTERVAL_SECONDS);
                }
            }
        }
    }

    /// Takes the bar away.
    pub(crate) fn finish(&self) {
        if let Self::Bar(bar) = self {
            bar.finish_and_clear();
        }
    }
}

/// "1 sample per pixel", "2 samples per pixel".
pub(crate) fn samples_per_pixel(count: u64) -> String {
    let plural = if count == 1 { "" } else { "s" };
    format!("{count} sample{plural} per pixel")
}

/// Millions per second.
pub(crate) fn mega_rate(count: u64, seconds: f64) -> f64 {
    if seconds > 0.0 { count as f64 / seconds / 1e6 } else { 0.0 }
}

/// A time as people say it: 0.4 s, 12 s, 3 min 20 s, 2 h 5 min.
pub(crate) fn human(seconds: f64) -> String {
    let whole = seconds.round() as u64;
    match whole {
        _ if seconds < 9.95 => format!("{seconds:.1} s"),
        0..60 => format!("{whole} s"),
        60..3600 => format!("{} min {} s", whole / 60, whole % 60),
        3600..8_640_000 => format!("{} h {} min", whole / 3600, whole / 60 % 60),
        _ => "more than 100 days".into(),
    }
}

/// Prints a number with about as many significant digits as the precision.
pub(crate) struct Significant(pub(crate) f64);

impl std::fmt::Display for Significant {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let digits = f.precision().unwrap_or(3);
        let magnitude = if self.0 == 0.0 { 0.0 } else { self.0.abs().log10().floor() };
        // Rates keep some digits when small, and few when large.
        let decimals = (digits as f64 - 1.0 - magnitude).clamp(0.0, 9.0) as usize;
        write!(f, "{:.decimals$}", self.0)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn status(spp: u32, share: Option<f64>, left: Option<f64>) -> render::Progress {
        let counts = render::Counts { rays: 30_000_000, ..render::Counts::default() };
        render::Progress {
            spp,
            target: share.map(|_| 64),
            share,
            pilot: false,
            seconds: 10.0,
            seconds_left: left,
            counts,
        }
    }

    fn goal(spp: Option<u32>, seconds: Option<u64>) -> Goal {
        Goal { spp, time: seconds.map(Duration::from_secs), ..Goal::default() }
    }

    #[test]
    fn the_nearer_end_counts() {
        assert_eq!(done(&status(16, Some(0.25), None), goal(Some(64), None)), 0.25);
        assert_eq!(done(&status(16, Some(0.25), None), goal(Some(64), Some(20))), 0.5);
        assert_eq!(done(&status(16, None, None), goal(None, Some(5))), 1.0);
        assert_eq!(done(&status(0, None, None), goal(None, Some(0))), 1.0);
    }

    #[test]
    fn a_status_reads_well() {
        assert_eq!(
            sentence(&status(16, Some(0.26), Some(30.0))),
            "16 of 64 samples per pixel, 3.00 Mrays/s, 30 s left"
        );
        assert_eq!(sentence(&status(5, None, Some(90.0))), "5 samples per pixel, 3.00 Mrays/s, 1 min 30 s left");
    }

    #[test]
    fn times_and_numbers_read_well() {
        for (seconds, text) in
            [(0.44, "0.4 s"), (9.96, "10 s"), (59.6, "1 min 0 s"), (200.0, "3 min 20 s"), (7500.0, "2 h 5 min")]
        {
            assert_eq!(human(seconds), text);
        }
        for (number, text) in
            [(0.0, "0.00"), (0.01234, "0.0123"), (3.0, "3.00"), (12.34, "12.3"), (123_456.7, "123457")]
        {
            assert_eq!(format!("{:.3}", Significant(number)), text);
        }
    }
}
