//! Options of `surelight bench`.

use std::path::PathBuf;
use std::time::Duration;

use clap::{Args, ValueEnum};
use surelight_bench::{Variations, data};

use crate::options::{CameraArgs, FileArgs, LightArgs};
use crate::parse::{self as value, Selector, Size};

/// `surelight bench SCENE…`.
#[derive(Debug, Args)]
pub(crate) struct BenchArgs {
    /// Scenes to benchmark, .glb or .gltf files
    #[arg(value_name = "SCENE", required_unless_present_any = ["compare", "map"])]
    pub(crate) scenes: Vec<PathBuf>,

    /// Folder of the report
    ///
    /// It gets index.html, charts, pictures, data.csv and data.json.
    #[arg(short, long, value_name = "FOLDER", default_value = "report")]
    pub(crate) output: PathBuf,

    /// Draw the failure map: where each estimator breaks, on built-in scenes
    ///
    /// The folder gets failure-map.md and its pictures. Takes minutes on a software driver.
    #[arg(long, conflicts_with_all = ["scenes", "compare", "resume"])]
    pub(crate) map: bool,

    /// Time per method, all its repeats together [default: 20s]
    ///
    /// The reference takes half of the time of all methods.
    #[arg(long, value_name = "TIME", value_parser = value::duration, conflicts_with = "spp")]
    pub(crate) time: Option<Duration>,

    /// Samples per pixel of each repeat, instead of --time
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(1..=1 << 24))]
    pub(crate) spp: Option<u32>,

    /// Take two minutes per scene: fewer methods, smaller pictures, three repeats
    #[arg(long)]
    pub(crate) quick: bool,

    /// Compare these values of an option; repeatable
    ///
    /// The option is integrator, sampler, scrambles, shared-paths, directions, max-bounces or
    /// max-radiance.
    #[arg(long, value_name = "SWITCH=A,B,…", value_parser = vary)]
    vary: Vec<String>,

    /// Independent repeats of each method [default: 4; 3 with --quick]
    ///
    /// Intervals and bands follow from their spread.
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(2..=1000))]
    pub(crate) repeats: Option<u32>,

    /// Reference image that errors are measured from [default: a long render]
    ///
    /// The variance of an EXR that Surelight wrote is accounted for.
    #[arg(long, value_name = "REF.exr")]
    pub(crate) reference: Option<PathBuf>,

    /// Continue the interrupted run in the report's folder
    ///
    /// Of a complete run, the report is written again.
    #[arg(long)]
    pub(crate) resume: bool,

    /// Draw the results of other renderers on the charts
    ///
    /// A CSV file with the columns scene, renderer, seconds, rel_mse and optionally spp and pixels,
    /// or a JSON array of objects with scene, renderer, spp, relmse, efficiency and mpaths.
    #[arg(long, value_name = "PEERS.csv|RACES.json")]
    pub(crate) overlay: Option<PathBuf>,

    /// Compare with an older report; exit code 4 means a regression
    ///
    /// Speed, accuracy and the picture's mean are compared. Without a scene, the existing report in
    /// the folder is compared.
    #[arg(long, value_name = "OLD/data.json")]
    pub(crate) compare: Option<PathBuf>,

    /// Growth of time or error, in percent, that --compare tolerates
    #[arg(long, value_name = "PERCENT", value_parser = value::percentage, default_value = "5", requires = "compare")]
    pub(crate) tolerance: f64,

    /// Clock of the charts [default: wall; cpu with a software driver]
    #[arg(long, value_enum)]
    pub(crate) clock: Option<Clock>,

    /// Resolution in pixels [default: 256 on the longer side; 160 with --quick]
    #[arg(long, value_name = "WxH", value_parser = value::size)]
    pub(crate) size: Option<Size>,

    /// Seed of the random numbers
    #[arg(long, value_name = "N", default_value_t = 0)]
    pub(crate) seed: u32,

    /// Exposure of the report's pictures, in stops
    #[arg(long, value_name = "EV", value_parser = value::exposure, default_value = "0", allow_hyphen_values = true)]
    pub(crate) exposure: f32,

    /// Note that the report shows
    #[arg(long, value_name = "TEXT", default_value = "")]
    pub(crate) note: String,

    /// Adapter to run on, by name or index [default: the fastest kind]
    #[arg(long, value_name = "NAME|INDEX", value_parser = value::selector)]
    pub(crate) adapter: Option<Selector>,

    #[command(flatten)]
    pub(crate) file: FileArgs,

    /// Print no progress
    #[arg(short, long)]
    pub(crate) quiet: bool,

    #[command(flatten)]
    pub(crate) camera: CameraArgs,

    #[command(flatten)]
    pub(crate) light: LightArgs,
}

/// Names of the clocks.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub(crate) enum Clock {
    /// Elapsed time
    Wall,
    /// Time of dispatches on the device
    Device,
    /// Processor time per core: for software drivers on a busy machine
    Cpu,
}

impl From<Clock> for data::Clock {
    fn from(clock: Clock) -> Self {
        match clock {
            Clock::Wall => Self::Wall,
            Clock::Device => Self::Device,
            Clock::Cpu => Self::Cpu,
        }
    }
}

/// A value of `--vary` that makes sense by itself.
fn vary(text: &str) -> Result<String, String> {
    Variations::default().add(text).map(|()| text.to_owned())
}

impl BenchArgs {
    /// The variations of `--vary`.
    pub(crate) fn variations(&self) -> Variations {
        let mut variations = Variations::default();
        for text in &self.vary {
            // Each was read before; doubles are refused by `conflict`.
            let _ = variations.add(text);
        }
        variations
    }

    /// The error in the combination, if any.
    pub(crate) fn conflict(&self) -> Option<String> {
        let mut variations = Variations::default();
        if let Some(wrong) = self.vary.iter().find_map(|text| variations.add(text).err()) {
            return Some(wrong);
        }
        (self.reference.is_some() && self.scenes.len() > 1)
            .then(|| "the argument '--reference' goes with one scene, of which it is the picture".to_owned())
    }
}
