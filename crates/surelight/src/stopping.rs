//! When a render ends: `--spp`, `--time`, `--error`.

use std::time::Duration;

use clap::{Args, ValueEnum};
use surelight_film::{self as film, Precision};
use surelight_render::Goal;

use crate::options::heading;
use crate::parse as value;

/// Default samples per pixel, without any limit.
const DEFAULT_SPP: u32 = 64;

/// Whichever comes first.
#[derive(Clone, Debug, Default, Args)]
pub(crate) struct StopArgs {
    /// Samples per pixel [default: 64 without --time and --error]
    ///
    /// Of --spp, --time and --error, the one that is reached first ends the render. With --error,
    /// the default is 65536.
    #[arg(long, value_name = "N", value_parser = value::count)]
    pub(crate) spp: Option<u32>,

    /// Time limit, loading included, for example 90s, 1.5m or 2h
    #[arg(long, value_name = "TIME", value_parser = value::duration)]
    pub(crate) time: Option<Duration>,

    /// Target of the relative error, for example 2%
    ///
    /// The render ends when half of all pixels are certified, and the confidence intervals of nine
    /// tenths of these have a half-width of at most this share of the pixel's luminance. Pixels
    /// darker than a tenth of the picture's mean are treated as if they had that luminance.
    #[arg(long, value_name = "E%", value_parser = value::relative_error)]
    pub(crate) error: Option<f64>,

    /// Confidence level of the intervals of --error [default: 95%]
    #[arg(
        long,
        value_name = "C%",
        value_parser = value::confidence,
        requires = "error",
        help_heading = heading::SAMPLING
    )]
    pub(crate) confidence: Option<f64>,

    /// How an interval follows from the standard error of a pixel [default: clt]
    #[arg(long, value_enum, requires = "error", help_heading = heading::SAMPLING)]
    pub(crate) bound: Option<Bound>,
}

/// Names of the bounds.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub(crate) enum Bound {
    /// Student's t distribution, by the central limit theorem
    Clt,
    /// Chebyshev's inequality: holds for any distribution, at more than twice the width
    Chebyshev,
}

impl StopArgs {
    /// The precision that the render is to reach.
    pub(crate) fn precision(&self) -> Option<Precision> {
        self.error.map(|error| Precision { error, confidence: self.confidence(), bound: self.bound() })
    }

    /// Confidence of intervals.
    pub(crate) fn confidence(&self) -> f64 {
        self.confidence.unwrap_or(0.95)
    }

    /// The bound of an interval.
    pub(crate) fn bound(&self) -> film::Bound {
        match self.bound {
            Some(Bound::Chebyshev) => film::Bound::Chebyshev,
            Some(Bound::Clt) | None => film::Bound::Clt,
        }
    }

    /// The goal, when `spent` of the time is over.
    pub(crate) fn goal(&self, spent: Duration) -> Goal {
        let limited = self.time.is_some() || self.error.is_some();
        Goal {
            spp: self.spp.or((!limited).then_some(DEFAULT_SPP)),
            time: self.time.map(|limit| limit.saturating_sub(spent)),
            precision: self.precision(),
            ..Goal::default()
        }
    }
}
