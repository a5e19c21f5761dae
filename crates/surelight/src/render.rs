//! `surelight render`: from a file to images, stage by stage.

mod checkpoint;
mod prepare;
mod record;
mod report;

use std::io::{ErrorKind, Write};
use std::path::{Path, PathBuf};
use std::time::Instant;

use surelight_film::{
    Display, Film, Metadata, PixelMoments, Window, WriteError, encode_exr, encode_png, write_exr, write_png,
    write_png_with_exposure,
};
use surelight_render::{CheckpointSink, Counts, Device, Goal, Outcome, Renderer, ResumeState};

use crate::error::{Error, sentence};
use crate::exposure::{self, ResolvedExposure};
use crate::method::MethodArgs;
use crate::options::RenderArgs;
use crate::parse::{Format, OutputPath, STANDARD_OUTPUT};
use crate::progress::Progress;
use crate::summary::{Seconds, Summary};
use crate::{interrupt, output, saved};

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
    state: ResumeState,
    /// Samples per pixel from a checkpoint.
    resumed_spp: u32,
    /// The file that holds them.
    resumed_from: Option<String>,
    /// The checkpoint, where there is one.
    checkpoint: Option<PathBuf>,
    counts: Counts,
    device_bytes: u64,
    exposed: ResolvedExposure,
    seconds: Seconds,
}

/// Renders as the options say, writes the images and returns a summary.
pub(crate) fn run(args: &RenderArgs) -> Result<Summary, Error> {
    let start = Instant::now();
    interrupt::listen();
    let outputs = output::choose(&args.scene, &args.outputs);
    let inputs: Vec<_> = args.scene.file().into_iter().chain(args.light.env.as_deref()).map(Path::to_owned).collect();
    let mut checkpoint = Checkpoint::beside(&outputs);
    output::check(&outputs.iter().cloned().chain(checkpoint.output()).collect::<Vec<_>>(), &inputs)?;
    let mut earlier = checkpoint.find(&outputs, args.parts.resume, args.quiet)?;

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

    let window = args.parts.window(loaded.view.size)?;
    earlier.take_if(|earlier| {
        let args = &earlier.decided(args);
        let record = Record::new(args, &args.method, &loaded, &device, "", earlier.reuses_paths(), window);
        !earlier.is_of(&record, args.quiet)
    });
    let args = &earlier.as_ref().map_or_else(|| args.clone(), |earlier| earlier.decided(args));
    let settings = prepare::settings(args, &loaded.view);
    loaded.warnings.extend(args.method.warning(&loaded.scene));

    progress.stage("building the BVH of", args.scene.name());
    let (prepared, precompiled) = loaded.prepare(&device, &settings)?;
    seconds.bvh = stages.end()?;

    progress.stage("compiling the kernel for", args.scene.name());
    let mut renderer = Renderer::with_kernel(&device, &prepared, precompiled)?;
    let method = args.method.with(prepared.integrator);
    let choice = prepared.choice.clone();
    drop(prepared); // the device has its copy
    seconds.compile = stages.end()?;
    interrupt::begin();

    let shared_paths = renderer.key().reuses_paths();
    let mut record = Record::new(args, &method, &loaded, &device, &renderer.wgsl, shared_paths, window);
    check_memory(&window, args.transparent)?;
    let (mut film, mut state) = match &earlier {
        Some(earlier) => checkpoint.read(earlier, &mut record, args.planned())?,
        None => (Film::of_window(window), args.parts.start(&args.stop)),
    };
    let resumed_spp = if earlier.is_some() { state.next - state.first } else { 0 };
    stages.end()?; // of no stage: it counts in the total alone
    // An .exr shows first hits. They take as long as many samples, so the image comes first, unless
    // its time is limited or the stopping rule needs the pixels that light can reach. Under an
    // environment that is all of them.
    let shows_features = outputs.iter().any(|output| output.format == Format::Exr);
    let dark_surroundings = loaded.scene.environment.is_none() || args.transparent;
    let features_first =
        (shows_features && args.stop.time.is_some()) || (dark_surroundings && args.stop.error.is_some());
    if features_first {
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
    let sink = CheckpointSink {
        every: args.parts.checkpoint,
        save: &mut |film, state, counts| checkpoint.write(&record, film, state, counts),
    };
    // Once there are samples in the film, Ctrl-C ends the render: there is an image to write.
    let watch = &mut |status: &surelight_render::Progress| {
        progress.update(status, goal);
        !(interrupt::requested() && status.spp > 0)
    };
    let traced = surelight_render::render_from(&mut renderer, &mut film, &goal, &mut state, watch, Some(sink));
    seconds.trace = stages.lap();
    let metadata = |film: &Film, state: &ResumeState, counts: &Counts| {
        record.metadata(film, state, counts, args.parts.is_part(&args.stop))
    };
    let outcome = match traced {
        Ok(outcome) => outcome,
        Err(cause) => {
            // The samples in the film are kept, even where the device is lost.
            if state.next > state.first {
                // A second failure adds nothing: the message lists the files that were saved.
                let display = exposure::choose(args.exposure, args.tonemap, &film, &outputs).display;
                let _ = write(&outputs, &film, &display, &metadata(&film, &state, &renderer.counts));
                checkpoint.write(&record, &film, &state, &renderer.counts);
            }
            return Err(Error::Tracing { cause, saved: saved::clause() });
        }
    };
    let black = || film.pixels().iter().any(|pixel| pixel.largest() == 0.0);
    if !features_first && (shows_features || (dark_surroundings && black())) {
        renderer.trace_features(&mut film)?;
        seconds.features = stages.lap();
    }

    let exposed = exposure::choose(args.exposure, args.tonemap, &film, &outputs);
    let metadata = Metadata { exposure: exposed.record(), ..metadata(&film, &state, &renderer.counts) };
    let mut written = write(&outputs, &film, &exposed.display, &metadata);
    if outcome == Outcome::Done && written.is_ok() {
        checkpoint.remove();
    } else {
        checkpoint.write(&record, &film, &state, &renderer.counts);
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
    loaded.warnings.extend(unsaved.map(|cause| format!("no checkpoint was saved: {}", sentence(&cause))));
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
        state,
        resumed_spp,
        resumed_from: earlier.as_ref().map(checkpoint::Earlier::source),
        checkpoint: (outcome != Outcome::Done).then(|| checkpoint.kept()).flatten(),
        counts: renderer.counts,
        device_bytes: renderer.device_bytes,
        exposed,
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

    /// The same before anything is traced: Ctrl-C ends the render here, for there is nothing to
    /// save yet.
    fn end(&mut self) -> Result<f64, Error> {
        if interrupt::requested() { Err(Error::Interrupted) } else { Ok(self.lap()) }
    }
}

/// An error where memory does not suffice for a film: running out later would end the program
/// without a message.
pub(crate) fn check_memory(window: &Window, transparent: bool) -> Result<(), Error> {
    // Moments, 4 of scratch, the features, and the encoded image with its moments while it is
    // written.
    const BYTES_PER_PIXEL: u64 = size_of::<PixelMoments>() as u64 + 4 + 28 + 4 * (17 + 45);
    // The same for coverage.
    const COVERAGE_BYTES: u64 = 16 + 4 * 4;
    let bytes = window.area() * (BYTES_PER_PIXEL + if transparent { COVERAGE_BYTES } else { 0 });
    let reserved = usize::try_from(bytes).ok().filter(|&bytes| Vec::<u8>::new().try_reserve_exact(bytes).is_ok());
    let [width, height] = window.size;
    let gib = bytes as f64 / f64::from(1 << 30);
    reserved.map(drop).ok_or(Error::Memory { width, height, gib })
}

/// Writes all outputs; one that fails does not keep the others from being written.
pub(crate) fn write(outputs: &[OutputPath], film: &Film, display: &Display, metadata: &Metadata) -> Result<(), Error> {
    let (mut failed, mut done) = (Vec::new(), Vec::new());
    for output in outputs {
        let OutputPath { path, format } = output;
        let written = match format {
            _ if output.is_stdout() => write_stdout(*format, film, display, metadata),
            Format::Exr => write_exr(path, film, metadata),
            Format::Png => match &metadata.exposure {
                Some(exposure) => write_png_with_exposure(path, film, display, exposure),
                None => write_png(path, film, display),
            },
        };
        match written {
            Ok(()) => {
                if !output.is_stdout() {
                    saved::add(path);
                }
                done.push(path.clone());
            }
            Err(error) => failed.push(error),
        }
    }
    if failed.is_empty() { Ok(()) } else { Err(Error::Outputs { failed, saved: done, checkpoint: None }) }
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
