//! The command line for clap: the commands, and errors in combinations of options.

use std::ffi::OsString;

use clap::error::{ContextKind, ContextValue, ErrorKind};
use clap::{Args, CommandFactory, FromArgMatches, Parser, Subcommand};

use crate::bench::BenchArgs;
use crate::compare::CompareArgs;
use crate::integrate::IntegrateArgs;
use crate::measure::MeasureArgs;
use crate::merge::MergeArgs;
use crate::method::Sampler;
use crate::options::{DevicesArgs, InfoArgs, RenderArgs};
use crate::parse;

/// The program with its commands; options of `render` are added in [`parse()`].
#[derive(Debug, Parser)]
#[command(
    name = "surelight",
    version,
    after_long_help = "\
Examples:
  surelight scene.glb --spp 256
  surelight scene.gltf --env studio.hdr --size 1920x1080 --time 2m --exposure auto
  surelight scene.glb --error 3% -o picture.png -o picture.exr
  surelight COMMAND --help

Exit codes:
  0  done
  1  error: bad input, device or disk
  2  wrong usage
  3  stopped before the target; image and checkpoint are written
  4  compare: the images differ; bench --compare: a regression
  5  compare --strict: the test is inconclusive",
    args_conflicts_with_subcommands = true,
    subcommand_negates_reqs = true,
    arg_required_else_help = true
)]
struct Cli {
    #[command(subcommand)]
    command: Option<Command>,
}

/// Parses the words of a command line. `surelight SCENE` is `surelight render SCENE`.
pub(crate) fn parse<I, T>(words: I) -> Result<Command, clap::Error>
where
    I: IntoIterator<Item = T>,
    T: Into<OsString> + Clone,
{
    let words: Vec<OsString> = words.into_iter().map(Into::into).collect();
    let mut cli = definition();
    if words.iter().any(|word| word == "-h") {
        cli = with_short_help(cli);
    }
    let matches = cli.try_get_matches_from_mut(words).map_err(|error| clarify(error, &mut cli))?;
    let mut command = match Cli::from_arg_matches(&matches)?.command {
        Some(command) => command,
        None => Command::Render(Box::new(RenderArgs::from_arg_matches(&matches)?)),
    };
    if let Command::Render(args) = &mut command {
        args.outputs = parse::outputs(&args.output, args.format)
            .map_err(|message| cli.error(ErrorKind::ValueValidation, message))?;
    }
    let conflict = match &command {
        Command::Render(args) => {
            let unscrambled = args.one_scramble && args.method.sampler != Sampler::Sobol;
            let unscrambled = unscrambled.then(|| {
                "the argument '--one-scramble' needs '--sampler sobol': other samplers have no sequence".into()
            });
            let parts = || args.parts.conflict(&args.stop, &args.outputs);
            let own = args.method.conflict().or_else(|| args.output_conflict()).map(String::from);
            own.or(unscrambled).or_else(parts)
        }
        Command::Info(args) => args.method.conflict().map(String::from),
        Command::Measure(args) => args.conflict().map(String::from),
        Command::Bench(args) => args.conflict(),
        _ => None,
    };
    match conflict {
        Some(message) => Err(cli.error(ErrorKind::ArgumentConflict, message)),
        None => Ok(command),
    }
}

/// Lays `-h` out for one screen: options without a heading on a line each, the names of the others.
fn with_short_help(command: clap::Command) -> clap::Command {
    const MAX_WIDTH: usize = 98;
    let mut headings: Vec<(String, Vec<String>)> = Vec::new();
    for arg in command.get_arguments() {
        let (Some(heading), Some(long)) = (arg.get_help_heading(), arg.get_long()) else { continue };
        match headings.iter_mut().find(|(known, _)| known == heading) {
            Some((_, names)) => names.push(format!(" --{long}")),
            None => headings.push((heading.to_owned(), vec![format!(" --{long}")])),
        }
    }
    let width = headings.iter().map(|(heading, _)| heading.len()).max().unwrap_or(0);
    let mut lines = Vec::new();
    for (heading, names) in &headings {
        let mut line = format!("  {heading:width$} ");
        for name in names {
            if line.len() + name.len() > MAX_WIDTH {
                lines.push(std::mem::replace(&mut line, " ".repeat(width + 3)));
            }
            line += name;
        }
        lines.push(line);
    }
    let footer = match lines.is_empty() {
        true => String::new(),
        false => format!("More options, explained by --help:\n{}", lines.join("\n")),
    };
    command
        .mut_args(|arg| {
            let more = arg.get_help_heading().is_some();
            arg.hide_short_help(more).hide_possible_values(true)
        })
        .mut_subcommands(with_short_help)
        .after_help(footer)
}

/// The whole definition, as clap has it before help is laid out.
pub(crate) fn definition() -> clap::Command {
    RenderArgs::augment_args(Cli::command())
        .about("Renders glTF scenes by path tracing, with an error bar on every pixel.")
        .long_about(None)
        .allow_negative_numbers(true)
}

/// clap mistakes a second scene for a command in the wrong place.
fn clarify(error: clap::Error, cli: &mut clap::Command) -> clap::Error {
    match (error.kind(), error.get(ContextKind::InvalidSubcommand)) {
        (ErrorKind::ArgumentConflict, Some(ContextValue::String(word))) if cli.find_subcommand(word).is_none() => {
            let message = format!("unexpected argument '{word}': one scene at a time, and a command comes first");
            cli.error(ErrorKind::UnknownArgument, message)
        }
        _ => error,
    }
}

/// The command.
#[derive(Debug, Subcommand)]
pub(crate) enum Command {
    /// Render a scene to PNG and EXR; the default command
    Render(Box<RenderArgs>),
    /// Show the contents of a scene, the kernel features that it needs, and unsupported features
    Info(InfoArgs),
    /// Measure radiance, irradiance or the mean of an image region, with an error bar
    Measure(Box<MeasureArgs>),
    /// Integrate a formula by Monte Carlo, quasi-Monte Carlo and quadrature, on the device
    Integrate(Box<IntegrateArgs>),
    /// Compare two images: metrics, and a test whether noise explains the difference
    Compare(CompareArgs),
    /// Benchmark integrators and samplers on scenes: charts of error against time
    Bench(Box<BenchArgs>),
    /// Merge parts of one render into the bytes of a single run
    Merge(MergeArgs),
    /// List adapters, drivers and their limits
    Devices(DevicesArgs),
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::exposure::Exposure;
    use crate::method::Integrator;
    use crate::options::Tonemap;
    use crate::parse::Bounces;

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
        assert_eq!(short.exposure, Some(Exposure::Stops(-1.0)));
        assert_eq!(short.file.scene, Some(1));
        assert_eq!(short.output.len(), 2);
    }

    #[test]
    fn defaults_are_those_of_the_manual() {
        let args = render("surelight a.glb");
        assert_eq!((args.stop.spp, args.stop.time, args.seed, args.exposure), (None, None, 0, None));
        assert_eq!(args.max_bounces, Bounces(None));
        assert_eq!(args.tonemap, Tonemap::Neutral);
        assert_eq!((args.method.integrator, args.method.sampler), (Integrator::Auto, Sampler::Sobol));
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
            ("surelight a.glb -o -", ErrorKind::ValueValidation),
            ("surelight a.glb -o - -o - --format png", ErrorKind::ValueValidation),
            ("surelight a.glb -o a.png --format png", ErrorKind::ValueValidation),
            ("surelight a.glb --format png", ErrorKind::MissingRequiredArgument),
            ("surelight a.glb -o - --format png --json", ErrorKind::ArgumentConflict),
            ("surelight a.glb -o - --format exr --resume", ErrorKind::ArgumentConflict),
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
            // Options of work to come are absent, not inert.
            ("surelight a.glb --samples 0..16", ErrorKind::MissingRequiredArgument),
        ] {
            assert_eq!(typed(line).expect_err(line).kind(), kind, "{line}");
        }
    }
}
