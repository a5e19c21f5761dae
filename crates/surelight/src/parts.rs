//! Renders in parts: `--samples`, `--crop`, `--checkpoint`, `--resume`.

use std::time::Duration;

use clap::Args;
use surelight_film::Window;
use surelight_render::ResumeState;

use crate::error::Error;
use crate::options::heading;
use crate::parse::{self as value, Format, OutputPath, Size};
use crate::stopping::StopArgs;

/// Which part of a render is done, and how it is kept.
#[derive(Clone, Debug, Args)]
pub(crate) struct PartArgs {
    /// Render this rectangle of pixels; X1 and Y1 are excluded
    ///
    /// `surelight merge` joins .exr files of one render.
    #[arg(long, value_name = "X0,Y0,X1,Y1", value_parser = value::rectangle, help_heading = heading::PARTS)]
    pub(crate) crop: Option<[u32; 4]>,

    /// Render the samples from A to B of --spp; B is excluded
    ///
    /// `surelight merge` joins .exr files of one render.
    #[arg(
        long,
        value_name = "A..B",
        value_parser = value::samples,
        requires = "spp",
        conflicts_with = "error",
        help_heading = heading::PARTS
    )]
    pub(crate) samples: Option<[u32; 2]>,

    /// Continue or extend an earlier run
    ///
    /// From its checkpoint, bit for bit; or from the finished .exr of the same name, to which the
    /// samples that --spp, --time or --error still require are added: same mean, valid error bars.
    /// The .exr keeps the necessary sums. Without either, the render starts over.
    #[arg(long, help_heading = heading::PARTS)]
    pub(crate) resume: bool,

    /// Interval between checkpoints
    ///
    /// Checkpoints are saved as NAME.checkpoint.exr beside the first output; less often where
    /// saving would take more than 5 % of the time.
    #[arg(
        long,
        value_name = "TIME",
        value_parser = value::duration,
        default_value = "60s",
        help_heading = heading::PARTS
    )]
    pub(crate) checkpoint: Duration,
}

impl PartArgs {
    /// The error in the combination, if any.
    pub(crate) fn conflict(&self, stop: &StopArgs, outputs: &[OutputPath]) -> Option<String> {
        let ([first, end], spp) = self.samples.zip(stop.spp)?;
        if end > spp {
            return Some(format!(
                "'--samples {first}..{end}' goes beyond '--spp {spp}', the samples of the whole render"
            ));
        }
        for at in [first, end] {
            if let Err([below, above]) = ResumeState::before(at, spp) {
                return Some(format!(
                    "'--samples {first}..{end}' cuts a batch in two: of {spp} samples, those next to {at} where a part can begin or end are {below} and {above}"
                ));
            }
        }
        let lost = !outputs.is_empty() && outputs.iter().all(|output| output.format != Format::Exr);
        lost.then(|| "'--samples' needs an output that ends in .exr: only such parts can be merged".to_owned())
    }

    /// Whether the images are parts that can be merged.
    pub(crate) fn is_part(&self, stop: &StopArgs) -> bool {
        let counted = stop.error.is_none() && (stop.spp.is_some() || stop.time.is_none());
        counted && (self.samples.is_some() || self.crop.is_some())
    }

    /// The pixels to render.
    pub(crate) fn window(&self, size: Size) -> Result<Window, Error> {
        let Size { width, height } = size;
        match self.crop {
            None => Ok(Window::all(width, height)),
            Some(edges) => Window::crop([width, height], edges).ok_or(Error::Region { width, height }),
        }
    }

    /// The state before the first sample of a render that is not resumed.
    pub(crate) fn start(&self, stop: &StopArgs) -> ResumeState {
        let first = self.samples.zip(stop.spp).and_then(|([first, _], spp)| ResumeState::before(first, spp).ok());
        first.unwrap_or_default()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn conflict(samples: [u32; 2], spp: u32, output: &str) -> Option<String> {
        let checkpoint = Duration::from_secs(60);
        let args = PartArgs { crop: None, samples: Some(samples), resume: false, checkpoint };
        args.conflict(&StopArgs { spp: Some(spp), ..StopArgs::default() }, &[value::output_path(output).unwrap()])
    }

    #[test]
    fn parts_begin_and_end_between_batches() {
        for good in [[0, 64], [0, 1], [1, 2], [16, 32], [60, 64]] {
            assert_eq!(conflict(good, 64, "a.exr"), None, "{good:?}");
        }
        assert!(conflict([0, 65], 64, "a.exr").unwrap().contains("beyond '--spp 64'"));
        let text = conflict([0, 250], 1000, "a.exr").unwrap();
        assert!(text.contains("224 and 256"), "{text}");
        assert!(conflict([0, 16], 64, "a.png").unwrap().contains(".exr"));
    }
}
