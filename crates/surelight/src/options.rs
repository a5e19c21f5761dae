//! Options that commands have in common, and those of the smaller commands.

use std::path::PathBuf;
use std::time::Duration;

use clap::{Args, ValueEnum};
use surelight_film::LEAST_SAMPLES;
use surelight_render::Goal;
use surelight_scene::{LoadOptions, Moment};

use crate::input::{SceneSource, scene_sources};
use crate::method::{MethodArgs, Sampler};
use crate::parse::{self as value, Bounces, Format, OutputName, OutputPath, Selector, Size};
use crate::parts::PartArgs;
use crate::stopping::StopArgs;

/// `surelight [render] SCENE`.
#[derive(Debug, Args)]
pub(crate) struct RenderArgs {
    /// The scene, a .glb or .gltf file; `-` reads one that needs no other files from standard input
    #[arg(value_name = "SCENE", value_parser = scene_sources())]
    pub(crate) scene: SceneSource,

    /// File to write; repeat it for several. .exr: linear, all layers; .png: tone mapped, sRGB;
    /// `-`: standard output, and the summary goes to standard error [default: the scene's name as
    /// .png and .exr in the current folder]
    #[arg(short, long, value_name = "PATH", value_parser = value::output_names())]
    pub(crate) output: Vec<OutputName>,

    /// What to write to `-o -`, and under names that end in neither .png nor .exr
    #[arg(long, value_enum, requires = "output")]
    pub(crate) format: Option<Format>,

    /// What `--output` and `--format` come to; set once both are known
    #[arg(skip)]
    pub(crate) outputs: Vec<OutputPath>,

    /// Pixels [default: 1024 on the longer side, the camera's aspect]
    #[arg(long, value_name = "WxH", value_parser = value::size)]
    pub(crate) size: Option<Size>,

    #[command(flatten)]
    pub(crate) stop: StopArgs,

    #[command(flatten)]
    pub(crate) method: MethodArgs,

    /// Scattering events a path may have: 0 emission only, 1 direct light, … or `unlimited`; going straight through a
    /// pane is none
    #[arg(long, value_name = "N", value_parser = value::bounces, default_value = "unlimited")]
    pub(crate) max_bounces: Bounces,

    /// Chooses the random numbers; the same seed gives the same image
    #[arg(long, value_name = "N", default_value_t = 0)]
    pub(crate) seed: u32,

    /// All Sobol points of a pixel from one sequence, as below 256 samples anyway: a smaller error, but the error told is then
    /// too large
    #[arg(long, conflicts_with = "error")]
    pub(crate) one_scramble: bool,

    /// Whether the four pixels of each 2×2 square use what one another's paths find, under `mis`: far less noise where most light comes
    /// from surface to surface, in squares; no bias. `auto`: in such scenes, unless fewer than 262,144 paths are planned
    #[arg(long, value_enum, default_value_t = SharedPaths::Auto)]
    pub(crate) shared_paths: SharedPaths,

    /// From a quarter of --spp to eight times as many samples a pixel, by how noisy a short look finds its surroundings; no bias
    #[arg(long)]
    pub(crate) adaptive: bool,

    /// The environment lights the scene but does not show: A is the share of a pixel that something
    /// covers; premultiplied in the EXR, straight in the PNG. What a pane shows straight through it
    /// is not covered, what is reflected or refracted is
    #[arg(long)]
    pub(crate) transparent: bool,

    /// Brightens the PNG by this many stops
    #[arg(
        long,
        value_name = "EV",
        value_parser = value::exposure,
        default_value = "0",
        allow_hyphen_values = true
    )]
    pub(crate) exposure: f32,

    /// How the PNG brings radiance into what a screen can show
    #[arg(long, value_enum, default_value_t = Tonemap::Neutral)]
    pub(crate) tonemap: Tonemap,

    /// Adapter, by part of its name or by its number in `surelight devices` [default: the fastest kind]
    #[arg(long, value_name = "NAME|INDEX", value_parser = value::selector)]
    pub(crate) adapter: Option<Selector>,

    #[command(flatten)]
    pub(crate) file: FileArgs,

    /// Rough reflections get back what their facets lose by scattering once, as glTF has it: rough metal is then no darker than
    /// smooth metal
    #[arg(long)]
    pub(crate) multiple_scattering: bool,

    /// Clamp every sample to this radiance: fewer bright specks, but biased, and recorded as such
    #[arg(long, value_name = "X", value_parser = value::positive)]
    pub(crate) max_radiance: Option<f32>,

    /// No progress, just the summary
    #[arg(short, long)]
    pub(crate) quiet: bool,

    /// The summary as one JSON object on standard output
    #[arg(long)]
    pub(crate) json: bool,

    // Their headings hold for what follows, so they come last.
    #[command(flatten)]
    pub(crate) camera: CameraArgs,

    #[command(flatten)]
    pub(crate) light: LightArgs,

    #[command(flatten)]
    pub(crate) parts: PartArgs,
}

impl RenderArgs {
    /// Whether all points of a pixel are of one sequence. Without independent batches the error told is an upper bound; below the
    /// number of samples that a certificate takes, that is a small price for a better picture.
    pub(crate) fn is_one_sequence(&self) -> bool {
        let short = self.planned().is_some_and(|spp| u64::from(spp) < LEAST_SAMPLES);
        self.method.sampler == Sampler::Sobol && (self.one_scramble || short)
    }

    /// Whether an image goes to standard output.
    pub(crate) fn writes_to_stdout(&self) -> bool {
        self.outputs.iter().any(OutputPath::is_stdout)
    }

    /// What is wrong with the way outputs are combined with other options, if anything.
    pub(crate) fn output_conflict(&self) -> Option<&'static str> {
        let only_stdout = self.writes_to_stdout() && self.outputs.len() == 1;
        if self.json && self.writes_to_stdout() {
            Some("the arguments '--json' and '-o -' both want standard output; name a file for one of them")
        } else if self.parts.resume && only_stdout {
            Some("the argument '--resume' needs an output that is a file: the checkpoint lies beside it")
        } else {
            None
        }
    }

    /// Samples a pixel that are planned from the beginning.
    pub(crate) fn planned(&self) -> Option<u32> {
        let Goal { spp, precision, .. } = self.stop.goal(Duration::ZERO);
        spp.filter(|_| precision.is_none())
    }
}

/// Where the picture is taken from.
#[derive(Debug, Default, Args)]
#[command(next_help_heading = "Camera")]
pub(crate) struct CameraArgs {
    /// Camera of the file, by name or number [default: the first; the whole model framed when there is none]
    #[arg(long, value_name = "NAME|INDEX", value_parser = value::selector, conflicts_with = "eye")]
    pub(crate) camera: Option<Selector>,

    /// Look from here, metres
    #[arg(
        long,
        value_name = "x,y,z",
        value_parser = value::point,
        requires = "target",
        allow_hyphen_values = true
    )]
    pub(crate) eye: Option<[f64; 3]>,

    /// … towards here, metres
    #[arg(
        long,
        value_name = "x,y,z",
        value_parser = value::point,
        requires = "eye",
        allow_hyphen_values = true
    )]
    pub(crate) target: Option<[f64; 3]>,

    /// Vertical field of view, degrees [default: the camera's; 45 with --eye]
    #[arg(long, value_name = "DEG", value_parser = value::field_of_view)]
    pub(crate) fov: Option<f64>,

    /// Diameter of a thin lens, metres: what is nearer or farther than --focus blurs
    #[arg(long, value_name = "METRES", value_parser = value::positive)]
    pub(crate) aperture: Option<f32>,

    /// Distance of what is sharp, metres [default: --target, or the middle of the model]
    #[arg(long, value_name = "METRES", value_parser = value::positive, requires = "aperture")]
    pub(crate) focus: Option<f32>,

    /// Whether the file's camera shows only what lies between its near and far planes; what it does
    /// not show still casts shadows and is reflected
    #[arg(long, value_enum, default_value_t = Clip::On)]
    pub(crate) clip: Clip,
}

/// Whether camera rays end at the camera's clipping planes.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, ValueEnum)]
pub(crate) enum Clip {
    /// They begin at znear and end at zfar
    #[default]
    On,
    /// They begin at the camera and have no end
    Off,
}

/// Light from far away.
#[derive(Debug, Default, Args)]
#[command(next_help_heading = "Environment")]
pub(crate) struct LightArgs {
    /// Equirectangular map, .hdr or .exr [default: none; a uniform white sky when nothing else gives light]
    #[arg(long, value_name = "FILE")]
    pub(crate) env: Option<PathBuf>,

    /// Turn the map about the vertical axis, degrees, counter-clockwise seen from above
    #[arg(
        long,
        value_name = "DEG",
        value_parser = value::finite,
        requires = "env",
        allow_hyphen_values = true
    )]
    pub(crate) env_rotate: Option<f32>,

    /// Factor on the map's radiance
    #[arg(long, value_name = "X", value_parser = value::positive, requires = "env")]
    pub(crate) env_scale: Option<f32>,

    /// The same radiance from every direction, linear Rec. 709
    #[arg(
        long,
        value_name = "R,G,B",
        value_parser = value::radiance,
        conflicts_with = "env",
        allow_hyphen_values = true
    )]
    pub(crate) sky: Option<[f32; 3]>,
}

/// What to take out of a file.
#[derive(Debug, Default, Args)]
pub(crate) struct FileArgs {
    /// Scene of the file, by number [default: the one the file names]
    #[arg(long = "scene", id = "scene_index", value_name = "N")]
    pub(crate) scene: Option<usize>,

    /// Material variant, by name or number [default: the file's own materials]
    #[arg(long, value_name = "NAME|INDEX", value_parser = value::selector)]
    pub(crate) variant: Option<Selector>,

    /// Animation, by name or number, whose moment --at is shown [default: the file at rest]
    #[arg(long, value_name = "NAME|INDEX", value_parser = value::selector)]
    pub(crate) animation: Option<Selector>,

    /// Moment of --animation, seconds from its start [default: 0]
    #[arg(long, value_name = "SECONDS", value_parser = value::finite, requires = "animation", allow_hyphen_values = true)]
    pub(crate) at: Option<f32>,

    /// Most pixels that an image of the file may have; larger ones are left out with a warning [default: 67108864]
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u64).range(1..))]
    pub(crate) max_image_pixels: Option<u64>,
}

impl FileArgs {
    /// As the importer takes it.
    pub(crate) fn load_options(&self) -> LoadOptions {
        let usual = LoadOptions::default();
        LoadOptions {
            scene: self.scene,
            variant: self.variant.as_ref().map(|variant| variant.0.clone()),
            animation: self
                .animation
                .as_ref()
                .map(|animation| Moment { animation: animation.0.clone(), seconds: self.at.unwrap_or(0.0).into() }),
            max_image_pixels: self.max_image_pixels.unwrap_or(usual.max_image_pixels),
            ..usual
        }
    }
}

/// `surelight info SCENE`.
#[derive(Debug, Args)]
pub(crate) struct InfoArgs {
    /// The scene, a .glb or .gltf file; `-` reads one that needs no other files from standard input
    #[arg(value_name = "SCENE", value_parser = scene_sources())]
    pub(crate) scene: SceneSource,

    #[command(flatten)]
    pub(crate) file: FileArgs,

    #[command(flatten)]
    pub(crate) method: MethodArgs,

    /// One JSON object on standard output
    #[arg(long)]
    pub(crate) json: bool,
}

/// `surelight devices`.
#[derive(Debug, Args)]
pub(crate) struct DevicesArgs {
    /// One JSON array on standard output
    #[arg(long)]
    pub(crate) json: bool,
}

/// When pixels share paths.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub(crate) enum SharedPaths {
    /// Where it pays, by a look at the scene
    Auto,
    /// Wherever they can
    On,
    /// Never: each pixel's error is its own
    Off,
}

/// Names of the tone maps.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub(crate) enum Tonemap {
    /// Khronos PBR Neutral: base colours come out as they are
    Neutral,
    /// AgX: soft, desaturates highlights
    Agx,
    /// ACES filmic curve: contrasty
    Aces,
    /// No curve: clipped at 1
    None,
}
