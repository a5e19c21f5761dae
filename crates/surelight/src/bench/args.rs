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
    /// Scenes to race on, .glb or .gltf files
    #[arg(value_name = "SCENE", required_unless_present_any = ["compare", "map"])]
    pub(crate) scenes: Vec<PathBuf>,

    /// Folder of the report: index.html, charts, data.csv, data.json, pictures
    #[arg(short, long, value_name = "FOLDER", default_value = "report")]
    pub(crate) output: PathBuf,

    /// Instead of racing on a scene, draw the failure map: which estimator is good for what, and where it breaks, on scenes of its own. The folder
    /// gets failure-map.md and its pictures; minutes on a software driver
    #[arg(long, conflicts_with_all = ["scenes", "compare", "resume"])]
    pub(crate) map: bool,

    /// Each method runs this long, all its repeats together; the reference takes half of all methods' time [default: 20s]
    #[arg(long, value_name = "TIME", value_parser = value::duration, conflicts_with = "spp")]
    pub(crate) time: Option<Duration>,

    /// Each repeat has this many samples a pixel, instead of a time
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(1..=1 << 24))]
    pub(crate) spp: Option<u32>,

    /// Two minutes a scene: fewer methods, smaller pictures, three repeats
    #[arg(long)]
    pub(crate) quick: bool,

    /// Race these values of a switch; repeat it for several: integrator, sampler, scrambles, shared-paths, directions,
    /// max-bounces or max-radiance
    #[arg(long, value_name = "SWITCH=A,B,…", value_parser = vary)]
    vary: Vec<String>,

    /// Independent repeats of each method: intervals and bands come from them [default: 4; 3 with --quick]
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(2..=1000))]
    pub(crate) repeats: Option<u32>,

    /// Measure errors from this image instead of a long render; its variance is used where it is an EXR of Surelight
    #[arg(long, value_name = "REF.exr")]
    pub(crate) reference: Option<PathBuf>,

    /// Go on with the race that was interrupted in the folder of the report; of one that is complete, write the report again
    #[arg(long)]
    pub(crate) resume: bool,

    /// Draw other renderers' points on the charts: a CSV file with the columns scene, renderer, seconds, rel_mse and perhaps spp and pixels, or a JSON
    /// array of races with scene, renderer, spp, relmse, efficiency and mpaths
    #[arg(long, value_name = "PEERS.csv|RACES.json")]
    pub(crate) overlay: Option<PathBuf>,

    /// Hold the report against an older one, and exit with 4 where speed, accuracy or the picture have lost; without a scene, the report that is
    /// in the folder already
    #[arg(long, value_name = "OLD/data.json")]
    pub(crate) compare: Option<PathBuf>,

    /// Percent by which time or error may grow before --compare calls it a loss
    #[arg(long, value_name = "PERCENT", value_parser = value::percentage, default_value = "5", requires = "compare")]
    pub(crate) tolerance: f64,

    /// Which seconds the charts count [default: wall; cpu with a software driver]
    #[arg(long, value_enum)]
    pub(crate) clock: Option<Clock>,

    /// Pixels [default: 256 on the longer side, 160 with --quick; the camera's aspect]
    #[arg(long, value_name = "WxH", value_parser = value::size)]
    pub(crate) size: Option<Size>,

    /// Chooses the random numbers of the whole race
    #[arg(long, value_name = "N", default_value_t = 0)]
    pub(crate) seed: u32,

    /// Brightens the pictures of the report by this many stops
    #[arg(long, value_name = "EV", value_parser = value::exposure, default_value = "0", allow_hyphen_values = true)]
    pub(crate) exposure: f32,

    /// A remark that the report shows among its conditions
    #[arg(long, value_name = "TEXT", default_value = "")]
    pub(crate) note: String,

    /// Adapter, by part of its name or by its number in `surelight devices` [default: the fastest kind]
    #[arg(long, value_name = "NAME|INDEX", value_parser = value::selector)]
    pub(crate) adapter: Option<Selector>,

    #[command(flatten)]
    pub(crate) file: FileArgs,

    /// No progress, just the answers
    #[arg(short, long)]
    pub(crate) quiet: bool,

    // Their headings hold for what follows, so they come last.
    #[command(flatten)]
    pub(crate) camera: CameraArgs,

    #[command(flatten)]
    pub(crate) light: LightArgs,
}

/// Names of the clocks.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub(crate) enum Clock {
    /// Seconds that pass
    Wall,
    /// Seconds of dispatches to the device
    Device,
    /// Processor seconds over cores: for software drivers on a machine that does other things too
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
    /// What `--vary` asks for.
    pub(crate) fn variations(&self) -> Variations {
        let mut variations = Variations::default();
        for text in &self.vary {
            // Each was read before; doubles are refused by `conflict`.
            let _ = variations.add(text);
        }
        variations
    }

    /// What is wrong with the combination, if anything.
    pub(crate) fn conflict(&self) -> Option<String> {
        let mut variations = Variations::default();
        if let Some(wrong) = self.vary.iter().find_map(|text| variations.add(text).err()) {
            return Some(wrong);
        }
        (self.reference.is_some() && self.scenes.len() > 1)
            .then(|| "the argument '--reference' goes with one scene, of which it is the picture".to_owned())
    }
}
