//! The command line as clap sees it: commands, options, defaults, help.

use std::ffi::OsString;
use std::path::PathBuf;

use clap::error::{ContextKind, ContextValue, ErrorKind};
use clap::{Args, CommandFactory, FromArgMatches, Parser, Subcommand, ValueEnum};

use crate::bench::BenchArgs;
use crate::compare::CompareArgs;
use crate::integrate::IntegrateArgs;
use crate::measure::MeasureArgs;
use crate::merge::MergeArgs;
use crate::method::{MethodArgs, Sampler};
use crate::parse::{self as value, Bounces, OutputPath, Selector, Size};
use crate::parts::PartArgs;
use crate::stopping::StopArgs;

/// The program with its commands; options of `render` are added in [`parse`].
#[derive(Debug, Parser)]
#[command(
    name = "surelight",
    version,
    after_help = "Exit codes: 0 done, 1 error, 2 wrong usage, 3 stopped before the target (image and checkpoint are written), 4 compare: they differ; bench --compare: something was lost.",
    args_conflicts_with_subcommands = true,
    subcommand_negates_reqs = true,
    arg_required_else_help = true
)]
struct Cli {
    #[command(subcommand)]
    command: Option<Command>,
}

/// What the words of a command line ask for. `surelight SCENE` is `surelight render SCENE`.
pub(crate) fn parse<I, T>(words: I) -> Result<Command, clap::Error>
where
    I: IntoIterator<Item = T>,
    T: Into<OsString> + Clone,
{
    let mut cli = definition();
    let matches = cli.try_get_matches_from_mut(words).map_err(|error| clearer(error, &mut cli))?;
    let command = match Cli::from_arg_matches(&matches)?.command {
        Some(command) => command,
        None => Command::Render(Box::new(RenderArgs::from_arg_matches(&matches)?)),
    };
    let conflict = match &command {
        Command::Render(args) => {
            let unscrambled = args.one_scramble && args.method.sampler != Sampler::Sobol;
            let unscrambled = unscrambled
                .then(|| "the argument '--one-scramble' needs '--sampler sobol': other samplers have no sequence".into());
            let parts = || args.parts.conflict(&args.stop, &args.method, &args.output);
            args.method.conflict().map(String::from).or(unscrambled).or_else(parts)
        }
        Command::Info(args) => args.method.conflict_without_trial().map(String::from),
        Command::Measure(args) => args.conflict().map(String::from),
        Command::Bench(args) => args.conflict(),
        _ => None,
    };
    match conflict {
        Some(message) => Err(cli.error(ErrorKind::ArgumentConflict, message)),
        None => Ok(command),
    }
}

fn definition() -> clap::Command {
    RenderArgs::augment_args(Cli::command())
        .about("Renders glTF scenes by path tracing on the GPU, with an error bar on every pixel.")
        .long_about(None)
        .allow_negative_numbers(true)
}

/// clap takes a second scene for a command in the wrong place.
fn clearer(error: clap::Error, cli: &mut clap::Command) -> clap::Error {
    match (error.kind(), error.get(ContextKind::InvalidSubcommand)) {
        (ErrorKind::ArgumentConflict, Some(ContextValue::String(word))) if cli.find_subcommand(word).is_none() => {
            let message = format!("unexpected argument '{word}': one scene at a time, and a command comes first");
            cli.error(ErrorKind::UnknownArgument, message)
        }
        _ => error,
    }
}

/// What to do.
#[derive(Debug, Subcommand)]
pub(crate) enum Command {
    /// Render a scene to PNG and EXR (this is what happens without a command too)
    Render(Box<RenderArgs>),
    /// Tell what is in a scene, what the kernel will include because of it, and what is not supported
    Info(InfoArgs),
    /// Measure one number with its error bar: radiance, irradiance and illuminance, or the mean of an image region
    Measure(Box<MeasureArgs>),
    /// Monte Carlo, quasi-Monte Carlo and quadrature side by side on a formula, on the device
    Integrate(Box<IntegrateArgs>),
    /// Tell how far apart two images are, and whether more than their noise explains it
    Compare(CompareArgs),
    /// Race the methods on scenes: which reaches a given error first, charted
    Bench(Box<BenchArgs>),
    /// Join parts of one render: the same bytes as if it had been rendered in one go
    Merge(MergeArgs),
    /// List adapters, drivers and limits
    Devices(DevicesArgs),
}

/// `surelight [render] SCENE`.
#[derive(Debug, Args)]
pub(crate) struct RenderArgs {
    /// The scene, a .glb or .gltf file
    #[arg(value_name = "SCENE")]
    pub(crate) scene: PathBuf,

    /// File to write; repeat it for several. .exr: linear, all layers; .png: tone mapped, sRGB
    /// [default: the scene's name as .png and .exr in the current folder]
    #[arg(short, long, value_name = "PATH", value_parser = value::output_path)]
    pub(crate) output: Vec<OutputPath>,

    /// Pixels [default: 1024 on the longer side, the camera's aspect]
    #[arg(long, value_name = "WxH", value_parser = value::size)]
    pub(crate) size: Option<Size>,

    #[command(flatten)]
    pub(crate) stop: StopArgs,

    #[command(flatten)]
    pub(crate) method: MethodArgs,

    /// Scattering events a path may have: 0 emission only, 1 direct light, … or `unlimited`
    #[arg(long, value_name = "N", value_parser = value::bounces, default_value = "unlimited")]
    pub(crate) max_bounces: Bounces,

    /// Chooses the random numbers; the same seed gives the same image
    #[arg(long, value_name = "N", default_value_t = 0)]
    pub(crate) seed: u32,

    /// All Sobol points of a pixel from one sequence: a smaller error, but the error told is then too large
    #[arg(long, conflicts_with = "error")]
    pub(crate) one_scramble: bool,

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
#[derive(Debug, Args)]
pub(crate) struct FileArgs {
    /// Scene of the file, by number [default: the one the file names]
    #[arg(long = "scene", id = "scene_index", value_name = "N")]
    pub(crate) scene: Option<usize>,
}

/// `surelight info SCENE`.
#[derive(Debug, Args)]
pub(crate) struct InfoArgs {
    /// The scene, a .glb or .gltf file
    #[arg(value_name = "SCENE")]
    pub(crate) scene: PathBuf,

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

#[cfg(test)]
mod tests {
    use super::*;
    use crate::method::Integrator;

    fn typed(line: &str) -> Result<Command, clap::Error> {
        super::parse(line.split_whitespace())
    }

    fn render(line: &str) -> RenderArgs {
        match typed(line) {
            Ok(Command::Render(args)) => *args,
            other => panic!("{line}: {other:?}"),
        }
    }

    #[test]
    fn the_definition_is_consistent() {
        definition().debug_assert();
    }

    #[test]
    fn render_may_be_left_out() {
        let tail = "a.glb -o x.png -o y.EXR --size 640x480 --spp 8 --time 90s --max-bounces 3 --seed 7 \
                    --eye -1,2,3 --target 0,0,-1 --fov 30 --aperture 0.1 --focus 2 --sky 1,2,3 --exposure -1 \
                    --tonemap agx --adapter llvm --scene 1 --max-radiance 10 --quiet --json \
                    --integrator hemisphere --directions cosine --sampler stratified";
        let (short, long) = (render(&format!("surelight {tail}")), render(&format!("surelight render {tail}")));
        assert_eq!(format!("{short:?}"), format!("{long:?}"));
        assert_eq!(short.camera.eye, Some([-1.0, 2.0, 3.0]));
        assert_eq!(short.exposure, -1.0);
        assert_eq!(short.file.scene, Some(1));
        assert_eq!(short.output.len(), 2);
    }

    #[test]
    fn defaults_are_those_of_the_manual() {
        let args = render("surelight a.glb");
        assert_eq!((args.stop.spp, args.stop.time, args.seed, args.exposure), (None, None, 0, 0.0));
        assert_eq!(args.max_bounces, Bounces(None));
        assert_eq!(args.tonemap, Tonemap::Neutral);
        assert_eq!((args.method.integrator, args.method.sampler), (Integrator::Mis, Sampler::Sobol));
        assert!(args.output.is_empty() && args.size.is_none() && !args.quiet && !args.json);
    }

    #[test]
    fn wrong_usage_is_refused() {
        for (line, kind) in [
            ("surelight --spp 4", ErrorKind::MissingRequiredArgument),
            ("surelight render", ErrorKind::MissingRequiredArgument),
            ("surelight a.glb b.glb", ErrorKind::UnknownArgument),
            ("surelight --quiet info a.glb", ErrorKind::UnknownArgument),
            ("surelight a.glb -o a.jpg", ErrorKind::ValueValidation),
            ("surelight a.glb --size 0x4", ErrorKind::ValueValidation),
            ("surelight a.glb --spp 0", ErrorKind::ValueValidation),
            ("surelight a.glb --eye 0,0,0", ErrorKind::MissingRequiredArgument),
            ("surelight a.glb --error 0%", ErrorKind::ValueValidation),
            ("surelight a.glb --confidence 95%", ErrorKind::MissingRequiredArgument),
            ("surelight a.glb --bound chebyshev", ErrorKind::MissingRequiredArgument),
            ("surelight a.glb --focus 2", ErrorKind::MissingRequiredArgument),
            ("surelight a.glb --env-rotate 20", ErrorKind::MissingRequiredArgument),
            ("surelight a.glb --env a.hdr --sky 1,1,1", ErrorKind::ArgumentConflict),
            ("surelight a.glb --camera 0 --eye 0,0,0 --target 1,1,1", ErrorKind::ArgumentConflict),
            ("surelight a.glb --tonemap reinhard", ErrorKind::InvalidValue),
            ("surelight compare a.exr", ErrorKind::MissingRequiredArgument),
            ("surelight compare a.exr b.exr --map map.exr", ErrorKind::ValueValidation),
            ("surelight a.glb --directions cosine", ErrorKind::ArgumentConflict),
            ("surelight info a.glb --integrator area --directions cosine", ErrorKind::ArgumentConflict),
            ("surelight a.glb --sampler halton", ErrorKind::InvalidValue),
            ("surelight a.glb --one-scramble --sampler stratified", ErrorKind::ArgumentConflict),
            ("surelight a.glb --one-scramble --error 1%", ErrorKind::ArgumentConflict),
            ("surelight info a.glb --integrator auto", ErrorKind::ArgumentConflict),
            ("surelight measure a.glb --integrator auto --point 0,0,0 --direction 0,0,1", ErrorKind::ArgumentConflict),
            // Options of work to come are absent, not inert.
            ("surelight a.glb --samples 0..16", ErrorKind::MissingRequiredArgument),
        ] {
            assert_eq!(typed(line).expect_err(line).kind(), kind, "{line}");
        }
    }
}
