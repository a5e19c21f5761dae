//! When a render ends: `--spp`, `--time`, `--error`.

use std::time::Duration;

use clap::{Args, ValueEnum};
use surelight_film::{self as film, Precision};
use surelight_render::Goal;

use crate::parse as value;

/// Samples a pixel when nothing says when to stop.
const DEFAULT_SPP: u32 = 64;

/// Whichever comes first.
#[derive(Clone, Debug, Default, Args)]
pub(crate) struct StopArgs {
    /// Stop after this many samples a pixel [default: 64, unless --time or --error is given; at most 65536 with --error]
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(1..))]
    pub(crate) spp: Option<u32>,

    /// Stop after this long, loading included, for example 90s, 1.5m, 2h
    #[arg(long, value_name = "TIME", value_parser = value::duration)]
    pub(crate) time: Option<Duration>,

    /// Stop when the error bars are this narrow: nine tenths of the certified pixels have an interval whose half-width is
    /// within this share of their luminance (of a tenth of the picture's mean, where they are darker), and half of all
    /// pixels are certified
    #[arg(long, value_name = "E%", value_parser = value::relative_error)]
    pub(crate) error: Option<f64>,

    /// Confidence of the intervals of --error [default: 95%]
    #[arg(long, value_name = "C%", value_parser = value::confidence, requires = "error")]
    pub(crate) confidence: Option<f64>,

    /// What makes an interval of a pixel's standard error [default: clt]
    #[arg(long, value_enum, requires = "error")]
    pub(crate) bound: Option<Bound>,
}

/// Names of the bounds.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub(crate) enum Bound {
    /// Student's t: the mean of many samples is about normal (central limit theorem)
    Clt,
    /// Chebyshev's inequality: makes no use of the distribution, and is more than twice as wide
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

    /// What makes an interval.
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
