//! Options that commands have in common, and those of the smaller commands.

use std::path::PathBuf;
use std::time::Duration;

use clap::{Args, ValueEnum};
use surelight_film::MIN_CERTIFIED_SAMPLES;
use surelight_render::Goal;
use surelight_scene::{LoadOptions, Moment};

use crate::exposure::Exposure;
use crate::input::{SceneSource, scene_sources};
use crate::method::{MethodArgs, Sampler};
use crate::parse::{self as value, Bounces, Format, OutputName, OutputPath, Selector, Size};
use crate::parts::PartArgs;
use crate::stopping::StopArgs;

/// Headings of `--help`. Options that most people need first have none.
pub(crate) mod heading {
    pub(crate) const SAMPLING: &str = "Sampling";
    pub(crate) const CAMERA: &str = "Camera";
    pub(crate) const ENVIRONMENT: &str = "Environment";
    pub(crate) const SCENE: &str = "Scene";
    pub(crate) const PICTURE: &str = "Picture";
    pub(crate) const PARTS: &str = "Parts and resuming";
    pub(crate) const DEVICE: &str = "Device and summary";
}

/// `surelight [render] SCENE`. The order of the options is that of `--help`.
#[derive(Clone, Debug, Args)]
pub(crate) struct RenderArgs {
    /// Scene to render, a .glb or .gltf file; `-` reads one without external files from standard
    /// input
    #[arg(value_name = "SCENE", value_parser = scene_sources())]
    pub(crate) scene: SceneSource,

    /// File to write, .png, .exr or `-`; repeatable [default: both]
    ///
    /// A .png is tone mapped and sRGB; an .exr holds linear radiance, its variance and all other
    /// layers. By default both are written to the current folder, under the scene's name. `-` is
    /// standard output: it needs --format, and the summary goes to standard error.
    #[arg(short, long, value_name = "PATH", value_parser = value::output_names())]
    pub(crate) output: Vec<OutputName>,

    /// Outputs by --output and --format; set once both are known
    #[arg(skip)]
    pub(crate) outputs: Vec<OutputPath>,

    /// Resolution [default: 1024 on the longer side, camera's aspect]
    #[arg(long, value_name = "WxH", value_parser = value::size)]
    pub(crate) size: Option<Size>,

    #[command(flatten)]
    pub(crate) stop: StopArgs,

    #[command(flatten)]
    pub(crate) method: MethodArgs,

    #[command(flatten)]
    pub(crate) light: LightArgs,

    #[command(flatten)]
    pub(crate) camera: CameraArgs,

    /// Exposure of the PNG in stops, or `auto` [default: 0]
    ///
    /// `auto` shows the log-average luminance of the picture as middle grey (Reinhard et al. 2002).
    /// The summary and the files record the exposure it chose. The EXR always holds unscaled
    /// radiance.
    #[arg(
        long,
        value_name = "EV|auto",
        value_parser = value::exposure_or_auto,
        allow_hyphen_values = true
    )]
    pub(crate) exposure: Option<Exposure>,

    /// Print no progress
    #[arg(short, long)]
    pub(crate) quiet: bool,

    /// Limit paths to N scattering events; biased
    ///
    /// 0 is emission alone, 1 is direct light. Passing straight through a pane is no event. By
    /// default paths have no limit and end by Russian roulette. A limit biases the picture, and the
    /// files record it.
    #[arg(long, value_name = "N", value_parser = value::bounces, default_value = "unlimited", help_heading = heading::SAMPLING)]
    pub(crate) max_bounces: Bounces,

    /// Clamp each sample to this radiance; biased
    ///
    /// Removes fireflies, and with them energy: the picture is biased, and the files record it.
    #[arg(long, value_name = "X", value_parser = value::positive, help_heading = heading::SAMPLING)]
    pub(crate) max_radiance: Option<f32>,

    /// Seed of the random numbers
    ///
    /// The same seed on the same device gives the same image, bit for bit.
    #[arg(long, value_name = "N", default_value_t = 0, help_heading = heading::SAMPLING)]
    pub(crate) seed: u32,

    /// Distribute samples by noise: a quarter to eight times --spp per pixel
    ///
    /// A short pilot render, whose samples are discarded, estimates the noise of each region.
    /// Unbiased.
    #[arg(long, help_heading = heading::SAMPLING)]
    pub(crate) adaptive: bool,

    /// Reuse paths among the four pixels of each 2×2 block
    ///
    /// Reduces noise greatly where most light is indirect and diffuse, at the price of noise that
    /// is correlated within blocks. Unbiased. Needs the `mis` integrator.
    #[arg(long, value_enum, default_value_t = PathReuse::Auto, help_heading = heading::SAMPLING)]
    pub(crate) shared_paths: PathReuse,

    /// Draw all samples of a pixel from one scrambled Sobol sequence
    ///
    /// Lowers the error, but error bars become upper bounds. Renders below 256 samples per pixel
    /// always do so.
    #[arg(long, conflicts_with = "error", help_heading = heading::SAMPLING)]
    pub(crate) one_scramble: bool,

    #[command(flatten)]
    pub(crate) file: FileArgs,

    /// Compensate rough reflections for the energy that single scattering loses
    ///
    /// The microfacet BSDFs of glTF model single scattering, which darkens rough metals. With this
    /// option, they scale reflections so that a rough metal reflects as much as a smooth one.
    #[arg(long, help_heading = heading::SCENE)]
    pub(crate) multiple_scattering: bool,

    /// Let the environment light the scene, but not show
    ///
    /// A is the covered share of the pixel: premultiplied in the EXR, straight in the PNG. The view
    /// straight through a pane is uncovered; reflections and refractions are covered.
    #[arg(long, help_heading = heading::PICTURE)]
    pub(crate) transparent: bool,

    /// Format of `-o -`, and of names that end in neither .png nor .exr
    #[arg(long, value_enum, requires = "output", help_heading = heading::PICTURE)]
    pub(crate) format: Option<Format>,

    /// Tone-mapping operator of the PNG
    #[arg(long, value_enum, default_value_t = Tonemap::Neutral, help_heading = heading::PICTURE)]
    pub(crate) tonemap: Tonemap,

    #[command(flatten)]
    pub(crate) parts: PartArgs,

    /// Adapter to render on, by name or index [default: the fastest kind]
    ///
    /// A part of the name is enough. `surelight devices` lists names and indices.
    #[arg(long, value_name = "NAME|INDEX", value_parser = value::selector, help_heading = heading::DEVICE)]
    pub(crate) adapter: Option<Selector>,

    /// Print the summary as one JSON object
    #[arg(long, help_heading = heading::DEVICE)]
    pub(crate) json: bool,
}

impl RenderArgs {
    /// Whether all points of a pixel are of one sequence. Without independent batches the reported
    /// error is an upper bound; below the number of samples that a certificate takes, that is a
    /// small price for a better picture.
    pub(crate) fn is_one_sequence(&self) -> bool {
        let short = self.planned().is_some_and(|spp| u64::from(spp) < MIN_CERTIFIED_SAMPLES);
        self.method.sampler == Sampler::Sobol && (self.one_scramble || short)
    }

    /// Whether an image goes to standard output.
    pub(crate) fn writes_to_stdout(&self) -> bool {
        self.outputs.iter().any(OutputPath::is_stdout)
    }

    /// The error in the combination of outputs with other options, if any.
    pub(crate) fn output_conflict(&self) -> Option<&'static str> {
        let only_stdout = self.writes_to_stdout() && self.outputs.len() == 1;
        if self.json && self.writes_to_stdout() {
            Some("the arguments '--json' and '-o -' both use standard output; name a file for one of them")
        } else if self.parts.resume && only_stdout {
            Some("the argument '--resume' needs an output that is a file: the checkpoint is beside it")
        } else {
            None
        }
    }

    /// Samples per pixel that are planned from the beginning.
    pub(crate) fn planned(&self) -> Option<u32> {
        let Goal { spp, precision, .. } = self.stop.goal(Duration::ZERO);
        spp.filter(|_| precision.is_none())
    }
}

/// Where the picture is taken from.
#[derive(Clone, Debug, Default, Args)]
pub(crate) struct CameraArgs {
    /// Camera of the scene, by name or index [default: the first]
    ///
    /// A scene without a camera is framed as a whole.
    #[arg(long, value_name = "NAME|INDEX", value_parser = value::selector, conflicts_with = "eye")]
    pub(crate) camera: Option<Selector>,

    /// Position of the eye, in metres
    #[arg(
        long,
        value_name = "x,y,z",
        value_parser = value::point,
        requires = "target",
        allow_hyphen_values = true,
        help_heading = heading::CAMERA
    )]
    pub(crate) eye: Option<[f64; 3]>,

    /// Point at the middle of the picture, in metres
    #[arg(
        long,
        value_name = "x,y,z",
        value_parser = value::point,
        requires = "eye",
        allow_hyphen_values = true,
        help_heading = heading::CAMERA
    )]
    pub(crate) target: Option<[f64; 3]>,

    /// Vertical field of view, in degrees [default: the camera's; 45 with --eye]
    #[arg(long, value_name = "DEG", value_parser = value::field_of_view, help_heading = heading::CAMERA)]
    pub(crate) fov: Option<f64>,

    /// Diameter of a thin lens, in metres [default: a pinhole]
    ///
    /// Surfaces nearer or farther than --focus blur.
    #[arg(long, value_name = "METRES", value_parser = value::positive, help_heading = heading::CAMERA)]
    pub(crate) aperture: Option<f32>,

    /// Focus distance, in metres [default: --target, or the middle of the scene]
    #[arg(
        long,
        value_name = "METRES",
        value_parser = value::positive,
        requires = "aperture",
        help_heading = heading::CAMERA
    )]
    pub(crate) focus: Option<f32>,

    /// Clip camera rays at the near and far planes of the scene's camera
    ///
    /// Clipped surfaces still cast shadows and show in reflections.
    #[arg(long, value_enum, default_value_t = Clip::On, help_heading = heading::CAMERA)]
    pub(crate) clip: Clip,
}

/// Whether camera rays end at the camera's clipping planes.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, ValueEnum)]
pub(crate) enum Clip {
    /// Camera rays begin at znear and end at zfar
    #[default]
    On,
    /// Camera rays begin at the camera and have no end
    Off,
}

/// Light from far away.
#[derive(Clone, Debug, Default, Args)]
pub(crate) struct LightArgs {
    /// Environment map, .hdr or .exr, equirectangular
    ///
    /// A scene with no light of any kind gets a uniform white sky.
    #[arg(long, value_name = "FILE")]
    pub(crate) env: Option<PathBuf>,

    /// Rotate the map about the vertical axis, in degrees
    ///
    /// Counter-clockwise from above.
    #[arg(
        long,
        value_name = "DEG",
        value_parser = value::finite,
        requires = "env",
        allow_hyphen_values = true,
        help_heading = heading::ENVIRONMENT
    )]
    pub(crate) env_rotate: Option<f32>,

    /// Scale the radiance of the map
    #[arg(
        long,
        value_name = "X",
        value_parser = value::positive,
        requires = "env",
        help_heading = heading::ENVIRONMENT
    )]
    pub(crate) env_scale: Option<f32>,

    /// Uniform radiance from every direction, linear Rec. 709
    #[arg(
        long,
        value_name = "R,G,B",
        value_parser = value::radiance,
        conflicts_with = "env",
        allow_hyphen_values = true,
        help_heading = heading::ENVIRONMENT
    )]
    pub(crate) sky: Option<[f32; 3]>,
}

/// The parts of a file to use.
#[derive(Clone, Debug, Default, Args)]
pub(crate) struct FileArgs {
    /// Scene of the file, by index [default: the file's default scene]
    #[arg(long = "scene", id = "scene_index", value_name = "N", help_heading = heading::SCENE)]
    pub(crate) scene: Option<usize>,

    /// Material variant, by name or index [default: the file's own materials]
    #[arg(long, value_name = "NAME|INDEX", value_parser = value::selector, help_heading = heading::SCENE)]
    pub(crate) variant: Option<Selector>,

    /// Animation, by name or index, posed at --at [default: the scene at rest]
    #[arg(long, value_name = "NAME|INDEX", value_parser = value::selector, help_heading = heading::SCENE)]
    pub(crate) animation: Option<Selector>,

    /// Time within --animation, in seconds [default: 0]
    #[arg(
        long,
        value_name = "SECONDS",
        value_parser = value::finite,
        requires = "animation",
        allow_hyphen_values = true,
        help_heading = heading::SCENE
    )]
    pub(crate) at: Option<f32>,

    /// Read textures and buffers from this folder, too; repeatable
    ///
    /// By default a URI cannot leave the folder of the scene. Folders below DIR are included;
    /// symbolic links that lead out of it are not followed.
    #[arg(long, value_name = "DIR", value_parser = value::folders(), help_heading = heading::SCENE)]
    pub(crate) allow_outside: Vec<PathBuf>,

    /// Largest texture to load, in pixels [default: 67108864]
    ///
    /// A larger one is left out with a warning.
    #[arg(
        long,
        value_name = "N",
        value_parser = clap::value_parser!(u64).range(1..),
        help_heading = heading::SCENE
    )]
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
            allow_outside: self.allow_outside.clone(),
            ..usual
        }
    }
}

/// `surelight info SCENE`.
#[derive(Debug, Args)]
pub(crate) struct InfoArgs {
    /// Scene to inspect, a .glb or .gltf file; `-` reads one without external files from standard
    /// input
    #[arg(value_name = "SCENE", value_parser = scene_sources())]
    pub(crate) scene: SceneSource,

    #[command(flatten)]
    pub(crate) file: FileArgs,

    #[command(flatten)]
    pub(crate) method: MethodArgs,

    /// Print one JSON object
    #[arg(long)]
    pub(crate) json: bool,
}

/// `surelight devices`.
#[derive(Debug, Args)]
pub(crate) struct DevicesArgs {
    /// Print one JSON array
    #[arg(long)]
    pub(crate) json: bool,
}

/// When pixels share paths.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub(crate) enum PathReuse {
    /// Where it pays for the scene, and more than 262,144 paths are planned
    Auto,
    /// Always
    On,
    /// Never: errors of pixels are independent
    Off,
}

/// Names of the tone-mapping operators.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub(crate) enum Tonemap {
    /// Khronos PBR Neutral: preserves base colours
    Neutral,
    /// AgX: low contrast, desaturated highlights
    Agx,
    /// ACES filmic curve: high contrast
    Aces,
    /// No operator: clipped at 1
    None,
}
