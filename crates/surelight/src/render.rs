//! `surelight render`: from a file to images, stage by stage.

mod checkpoint;
mod prepare;
mod record;
mod report;

use std::io::{ErrorKind, Write};
use std::path::{Path, PathBuf};
use std::time::Instant;

use surelight_film::{
    Display, Film, Metadata, PixelMoments, ToneMap, Window, WriteError, encode_exr, encode_png, write_exr, write_png,
};
use surelight_render::{Counts, Device, Goal, Keeper, Outcome, Renderer, Standing};

use crate::error::Error;
use crate::method::MethodArgs;
use crate::options::{RenderArgs, Tonemap};
use crate::parse::{Format, OutputPath, STANDARD_OUTPUT};
use crate::progress::Progress;
use crate::summary::{Seconds, Summary};
use crate::{interrupt, output};

use checkpoint::Checkpoint;
use prepare::Loaded;
pub(crate) use prepare::adapter_choice;
use record::Record;

/// A render that has ended.
struct Finished<'a> {
    args: &'a RenderArgs,
    outputs: &'a [OutputPath],
    loaded: Loaded,
    /// The integrator, and why it was chosen where the scene decides.
    method: MethodArgs,
    choice: Option<String>,
    device: &'a Device,
    film: Film,
    record: Record,
    goal: Goal,
    outcome: Outcome,
    standing: Standing,
    /// Samples a pixel that come from a checkpoint.
    resumed_spp: u32,
    /// The checkpoint that is left.
    checkpoint: Option<PathBuf>,
    counts: Counts,
    device_bytes: u64,
    seconds: Seconds,
}

/// Renders as the options say, writes the images and tells how it went.
pub(crate) fn run(args: &RenderArgs) -> Result<Summary, Error> {
    let start = Instant::now();
    interrupt::listen();
    let outputs = output::choose(&args.scene, &args.outputs);
    let inputs: Vec<_> = args.scene.file().into_iter().chain(args.light.env.as_deref()).map(Path::to_owned).collect();
    let mut checkpoint = Checkpoint::beside(&outputs);
    output::check(&outputs.iter().cloned().chain(checkpoint.output()).collect::<Vec<_>>(), &inputs)?;
    let earlier = checkpoint.look(args.parts.resume, args.quiet)?;

    let mut progress = Progress::new(args.quiet);
    let mut stages = Stages(Instant::now());
    let mut seconds = Seconds::default();

    progress.stage("loading", args.scene.name());
    // Drivers take their time to open a device; files are read meanwhile.
    let adapter = prepare::adapter_choice(args.adapter.as_ref());
    let (loaded, device) = std::thread::scope(|scope| {
        let device = scope.spawn(|| Device::new(&adapter));
        let loaded = Loaded::new(args, &outputs).and_then(|loaded| {
            seconds.load = stages.end()?;
            progress.stage("opening a device for", args.scene.name());
            Ok(loaded)
        });
        (loaded, device.join())
    });
    let mut loaded = loaded?;
    let device = device.unwrap_or_else(|panic| std::panic::resume_unwind(panic))?;
    seconds.device = stages.end()?;

    let settings = prepare::settings(args, &loaded.view);
    loaded.warnings.extend(args.method.warning(&loaded.scene));

    progress.stage("building the BVH of", args.scene.name());
    let (prepared, ahead) = loaded.prepare(&device, &settings)?;
    seconds.bvh = stages.end()?;

    progress.stage("compiling the kernel for", args.scene.name());
    let mut renderer = Renderer::with_kernel(&device, &prepared, ahead)?;
    let method = args.method.with(prepared.integrator);
    let choice = prepared.choice.clone();
    drop(prepared); // the device has its copy
    seconds.compile = stages.end()?;

    let window = args.parts.window(loaded.view.size)?;
    let mut record = Record::new(args, &method, &loaded, &device, &renderer, window);
    check_memory(&window, args.transparent)?;
    let (mut film, standing) = if earlier.is_some() {
        checkpoint.read(&mut record)?
    } else {
        (Film::of_window(window), args.parts.start(&args.stop))
    };
    let resumed_spp = if earlier.is_some() { standing.next - standing.first } else { 0 };
    stages.end()?; // of no stage: it counts in the total alone
    // Only an .exr shows first hits. They take as long as many samples, so the picture comes first, unless its time is limited.
    let shows_features = outputs.iter().any(|output| output.format == Format::Exr);
    if shows_features && args.stop.time.is_some() {
        renderer.trace_features(&mut film)?;
        seconds.features = stages.end()?;
    }

    if args.adaptive {
        progress.stage("looking for noise in", args.scene.name());
        renderer.adapt(args.planned(), &mut |_| !interrupt::requested())?;
        seconds.adapt = stages.end()?;
    }
    let goal = Goal { end: args.parts.samples.map(|[_, end]| end), ..args.stop.goal(start.elapsed()) };
    progress.start_tracing(film.width(), film.height(), &device.info.name, goal);
    let keeper = Keeper {
        every: args.parts.checkpoint,
        keep: &mut |film, standing, counts| checkpoint.write(&record, film, standing, counts),
    };
    // Once something is in the film, Ctrl-C need not wait: there is an image to write.
    let watch = &mut |status: &surelight_render::Progress| {
        progress.update(status, goal);
        !(interrupt::requested() && status.spp > 0)
    };
    let (outcome, standing) =
        surelight_render::render_from(&mut renderer, &mut film, &goal, standing, watch, Some(keeper))?;
    seconds.trace = stages.lap();
    if shows_features && args.stop.time.is_none() {
        renderer.trace_features(&mut film)?;
        seconds.features = stages.lap();
    }

    let metadata = record.metadata(&film, &standing, &renderer.counts, args.parts.is_part(&args.stop));
    let mut written = write(&outputs, &film, &display(args.exposure, args.tonemap), &metadata);
    if outcome == Outcome::Done && written.is_ok() {
        checkpoint.remove();
    } else {
        checkpoint.write(&record, &film, &standing, &renderer.counts);
    }
    if let Err(Error::Outputs { checkpoint: kept, .. }) = &mut written {
        *kept = checkpoint.kept();
    }
    written?;
    seconds.write = stages.lap();
    progress.finish();
    seconds.total = start.elapsed().as_secs_f64();
    let nowhere = outcome != Outcome::Done && checkpoint.path().is_none();
    let nowhere = nowhere.then(|| format!("{STANDARD_OUTPUT} has no place beside it; add an output that is a file"));
    let unsaved = checkpoint.failure.take().or(nowhere);
    loaded.warnings.extend(unsaved.map(|cause| format!("no checkpoint was saved: {cause}")));
    let finished = Finished {
        args,
        outputs: &outputs,
        loaded,
        method,
        choice,
        device: &device,
        film,
        record,
        goal,
        outcome,
        standing,
        resumed_spp,
        checkpoint: checkpoint.path().filter(|_| outcome != Outcome::Done).map(Path::to_owned),
        counts: renderer.counts,
        device_bytes: renderer.device_bytes,
        seconds,
    };
    Ok(finished.summary())
}

/// The clock of the stages.
struct Stages(Instant);

impl Stages {
    /// Seconds since the last call.
    fn lap(&mut self) -> f64 {
        let now = Instant::now();
        (now - std::mem::replace(&mut self.0, now)).as_secs_f64()
    }

    /// The same before anything is traced: Ctrl-C ends the render here, for there is nothing to save yet.
    fn end(&mut self) -> Result<f64, Error> {
        if interrupt::requested() { Err(Error::Interrupted) } else { Ok(self.lap()) }
    }
}

/// A sentence where memory does not suffice for a film: running out later would end the program without a word.
pub(crate) fn check_memory(window: &Window, transparent: bool) -> Result<(), Error> {
    // Moments, 4 of scratch, the features, and the encoded image with its moments while it is written.
    const BYTES_A_PIXEL: u64 = size_of::<PixelMoments>() as u64 + 4 + 28 + 4 * (17 + 45);
    // Coverage likewise.
    const COVERAGE_BYTES: u64 = 16 + 4 * 4;
    let bytes = window.area() * (BYTES_A_PIXEL + if transparent { COVERAGE_BYTES } else { 0 });
    let reserved = usize::try_from(bytes).ok().filter(|&bytes| Vec::<u8>::new().try_reserve_exact(bytes).is_ok());
    let [width, height] = window.size;
    let gib = bytes as f64 / f64::from(1 << 30);
    reserved.map(drop).ok_or(Error::Memory { width, height, gib })
}

/// How PNGs show radiance.
pub(crate) fn display(exposure: f32, tonemap: Tonemap) -> Display {
    let tonemap = match tonemap {
        Tonemap::Neutral => ToneMap::Neutral,
        Tonemap::Agx => ToneMap::Agx,
        Tonemap::Aces => ToneMap::Aces,
        Tonemap::None => ToneMap::None,
    };
    Display { exposure_ev: exposure.into(), tonemap }
}

/// Writes all outputs; one that fails does not keep the others from being written.
pub(crate) fn write(outputs: &[OutputPath], film: &Film, display: &Display, metadata: &Metadata) -> Result<(), Error> {
    let (mut failed, mut saved) = (Vec::new(), Vec::new());
    for output in outputs {
        let OutputPath { path, format } = output;
        let written = match format {
            _ if output.is_stdout() => write_stdout(*format, film, display, metadata),
            Format::Exr => write_exr(path, film, metadata),
            Format::Png => write_png(path, film, display),
        };
        match written {
            Ok(()) => saved.push(path.clone()),
            Err(error) => failed.push(error),
        }
    }
    if failed.is_empty() { Ok(()) } else { Err(Error::Outputs { failed, saved, checkpoint: None }) }
}

/// Writes an image to standard output.
fn write_stdout(format: Format, film: &Film, display: &Display, metadata: &Metadata) -> Result<(), WriteError> {
    let fail = |cause: String| WriteError { path: "-".into(), cause };
    let bytes = match format {
        Format::Exr => encode_exr(film, metadata),
        Format::Png => encode_png(film, display),
    };
    let mut out = std::io::stdout().lock();
    out.write_all(&bytes.map_err(fail)?).and_then(|()| out.flush()).map_err(|error| match error.kind() {
        ErrorKind::BrokenPipe => fail("the program that reads it has ended".into()),
        ErrorKind::StorageFull => fail("the disk is full".into()),
        _ => fail(error.to_string()),
    })
}
