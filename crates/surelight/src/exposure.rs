//! `--exposure`: the brightness of a PNG, chosen by the user or from the picture, and a hint where
//! most of the PNG shows nothing.

use std::fmt::{self, Display};

use serde::Serialize;
use surelight_film::{self as film, AutoExposure, ExposureRecord, Film, Loss, LostPixels, ToneMap};

use crate::options::Tonemap;
use crate::parse::{Format, OutputPath};
use crate::progress::Significant;
use crate::summary::Percent;

/// The value of `--exposure`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Exposure {
    /// As many stops.
    Stops(f32),
    /// Derived from the picture.
    Auto,
}

/// How the PNGs of a film are exposed.
#[derive(Clone, Copy, Debug)]
pub(crate) struct ResolvedExposure {
    pub(crate) display: film::Display,
    /// The exposure that was computed.
    pub(crate) auto: Option<Automatic>,
    /// A hint at a better exposure.
    pub(crate) hint: Option<Hint>,
}

/// An exposure that follows from the picture; its fields are keys of `--json`.
#[derive(Clone, Copy, Debug, Serialize)]
pub(crate) struct Automatic {
    /// Exposure in stops.
    pub(crate) ev: f64,
    /// Always: an exposure of the user is not shown.
    automatic: bool,
    /// Log-average luminance of the picture; `null` where it is black.
    log_average_luminance: Option<f64>,
}

/// Pixels without detail, and what to try; its fields are keys of `--json`.
#[derive(Clone, Copy, Debug, Serialize)]
pub(crate) struct Hint {
    /// Share of the pixels.
    share: f64,
    /// Whether they are black or clipped.
    loss: Loss,
    /// The exposure to try, in whole stops.
    try_ev: f64,
}

/// Decides how the PNGs of a film are exposed.
pub(crate) fn choose(
    wanted: Option<Exposure>,
    tonemap: Tonemap,
    film: &Film,
    outputs: &[OutputPath],
) -> ResolvedExposure {
    let tonemap = match tonemap {
        Tonemap::Neutral => ToneMap::Neutral,
        Tonemap::Agx => ToneMap::Agx,
        Tonemap::Aces => ToneMap::Aces,
        Tonemap::None => ToneMap::None,
    };
    let display = |exposure_ev| film::Display { exposure_ev, tonemap };
    match wanted {
        Some(Exposure::Stops(ev)) => ResolvedExposure { display: display(ev.into()), auto: None, hint: None },
        Some(Exposure::Auto) => {
            let AutoExposure { ev, log_average } = AutoExposure::of(film);
            let auto = Automatic { ev, automatic: true, log_average_luminance: log_average };
            ResolvedExposure { display: display(ev), auto: Some(auto), hint: None }
        }
        None => {
            let display = display(0.0);
            let shown = outputs.iter().any(|output| output.format == Format::Png);
            ResolvedExposure { display, auto: None, hint: shown.then(|| Hint::of(film, &display)).flatten() }
        }
    }
}

impl ResolvedExposure {
    /// The exposure record of files.
    pub(crate) fn record(&self) -> Option<ExposureRecord> {
        self.auto.map(|auto| ExposureRecord { ev: auto.ev, automatic: true })
    }
}

impl Hint {
    fn of(film: &Film, display: &film::Display) -> Option<Self> {
        let LostPixels { share, loss } = LostPixels::of(film, display)?;
        let try_ev = AutoExposure::of(film).ev.round();
        // Where the average is as it should be, another exposure would lose the rest.
        let helps = if loss == Loss::Black { try_ev > 0.0 } else { try_ev < 0.0 };
        helps.then_some(Self { share, loss, try_ev })
    }
}

impl Display for Automatic {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "exposure {:+.1} EV (auto: ", self.ev)?;
        match self.log_average_luminance {
            Some(luminance) => write!(f, "log-average luminance {:.2})", Significant(luminance)),
            None => write!(f, "the picture is black)"),
        }
    }
}

impl Display for Hint {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let (what, share) = match self.loss {
            Loss::Black => ("black, though light reaches them", Percent(self.share)),
            Loss::Clipped => ("clipped to white", Percent(self.share)),
        };
        write!(f, "{share} of the PNG's pixels are {what}; try --exposure auto or --exposure {:+}", self.try_ev)
    }
}

#[cfg(test)]
mod tests {
    use surelight_film::BatchSum;

    use super::*;
    use crate::parse::output_path;

    fn film(radiance: f32) -> Film {
        let mut film = Film::new(2, 1);
        film.add_batch(2, &[0, 1], &[[radiance; 3]; 2].map(|c| BatchSum::constant(2, c))).unwrap();
        film
    }

    fn exposed(wanted: Option<Exposure>, radiance: f32, output: &str) -> ResolvedExposure {
        choose(wanted, Tonemap::None, &film(radiance), &[output_path(output).unwrap()])
    }

    #[test]
    fn automatic_exposures_say_what_they_follow_from() {
        let auto = exposed(Some(Exposure::Auto), 0.045, "a.png");
        assert_eq!(auto.display.exposure_ev, 2.0);
        assert_eq!(auto.record(), Some(ExposureRecord { ev: 2.0, automatic: true }));
        assert_eq!(auto.auto.unwrap().to_string(), "exposure +2.0 EV (auto: log-average luminance 0.045)");
        let black = exposed(Some(Exposure::Auto), 0.0, "a.png").auto.unwrap();
        assert_eq!(black.to_string(), "exposure +0.0 EV (auto: the picture is black)");
    }

    #[test]
    fn hints_say_what_to_try() {
        let hint = |radiance, output| exposed(None, radiance, output).hint.map(|hint| hint.to_string());
        let dark =
            "100 % of the PNG's pixels are black, though light reaches them; try --exposure auto or --exposure +10";
        assert_eq!(hint(0.18 / 1024.0, "a.png").as_deref(), Some(dark));
        let bright = "100 % of the PNG's pixels are clipped to white; try --exposure auto or --exposure -6";
        assert_eq!(hint(0.18 * 64.0, "a.png").as_deref(), Some(bright));
        assert_eq!((hint(0.5, "a.png"), hint(0.0, "a.png"), hint(1e-6, "a.exr")), (None, None, None));
        assert!(exposed(Some(Exposure::Stops(0.0)), 1e-6, "a.png").hint.is_none());
    }
}
