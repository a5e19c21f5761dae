//! `surelight render`: from a file to images, stage by stage.

mod auto;
mod prepare;
mod report;

use std::time::Instant;

use surelight_film::{Display, Film, Metadata, ToneMap, write_exr, write_png};
use surelight_render::{Counts, Device, Goal, Outcome, Renderer};

use crate::args::{RenderArgs, Tonemap};
use crate::error::Error;
use crate::method::MethodArgs;
use crate::parse::{Format, OutputPath, Size};
use crate::progress::Progress;
use crate::summary::{Seconds, Summary, Tried};
use crate::{interrupt, output};

use prepare::Loaded;
pub(crate) use prepare::adapter_choice;

/// A render that has ended.
struct Finished<'a> {
    args: &'a RenderArgs,
    outputs: &'a [OutputPath],
    loaded: Loaded,
    method: MethodArgs,
    tried: Vec<Tried>,
    device: &'a Device,
    film: Film,
    goal: Goal,
    outcome: Outcome,
    counts: Counts,
    device_bytes: u64,
    seconds: Seconds,
}

/// Renders as the options say, writes the images and tells how it went.
pub(crate) fn run(args: &RenderArgs) -> Result<Summary, Error> {
    let start = Instant::now();
    interrupt::listen();
    let outputs = output::choose(&args.scene, &args.output);
    let inputs: Vec<_> = std::iter::once(&args.scene).chain(&args.light.env).cloned().collect();
    output::check(&outputs, &inputs)?;

    let mut progress = Progress::new(args.quiet);
    let mut stages = Stages(Instant::now());
    let mut seconds = Seconds::default();

    progress.stage("loading", &args.scene);
    let mut loaded = Loaded::new(args, &outputs)?;
    seconds.load = stages.end()?;

    progress.stage("opening a device for", &args.scene);
    let device = Device::new(&prepare::adapter_choice(args.adapter.as_ref()))?;
    seconds.device = stages.end()?;

    let mut settings = prepare::settings(args, &loaded.view);
    if args.method.is_auto() {
        progress.stage("trying integrators on", &args.scene);
    }
    let (method, tried) = auto::choose(&args.method, &device, &loaded, &settings)?;
    settings.integrator = method.integrator();
    loaded.warnings.extend(method.warning(&loaded.scene));
    seconds.trials = stages.end()?;

    progress.stage("building the BVH of", &args.scene);
    let prepared = loaded.prepare(&settings)?;
    seconds.bvh = stages.end()?;

    progress.stage("compiling the kernel for", &args.scene);
    let mut renderer = Renderer::new(&device, &prepared)?;
    drop(prepared); // the device has its copy
    seconds.compile = stages.end()?;

    let mut film = new_film(loaded.view.size)?;
    stages.end()?; // of no stage: it counts in the total alone

    let goal = args.stop.goal(start.elapsed());
    progress.start_tracing(film.width(), film.height(), &device.info.name, goal);
    // Once something is in the film, Ctrl-C need not wait: there is an image to write.
    let outcome = surelight_render::render(&mut renderer, &mut film, &goal, &mut |status| {
        progress.update(status, goal);
        !(interrupt::requested() && status.spp > 0)
    })?;
    seconds.trace = stages.lap();
    renderer.trace_features(&mut film)?;
    seconds.features = stages.lap();

    let mut finished = Finished {
        args,
        outputs: &outputs,
        loaded,
        method,
        tried,
        device: &device,
        film,
        goal,
        outcome,
        counts: renderer.counts,
        device_bytes: renderer.device_bytes,
        seconds,
    };
    write(&outputs, &finished.film, args, &finished.metadata())?;
    finished.seconds.write = stages.lap();
    progress.finish();
    finished.seconds.total = start.elapsed().as_secs_f64();
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

/// A film, or a sentence where memory does not suffice: running out later would end the program without a word.
fn new_film(size: Size) -> Result<Film, Error> {
    // 168 bytes of moments and 4 of scratch a pixel, the features, and the encoded image while it is written.
    const BYTES_A_PIXEL: u64 = 168 + 4 + 28 + 60;
    let bytes = u64::from(size.width) * u64::from(size.height) * BYTES_A_PIXEL;
    let reserved = usize::try_from(bytes).ok().filter(|&bytes| Vec::<u8>::new().try_reserve_exact(bytes).is_ok());
    match reserved {
        Some(_) => Ok(Film::new(size.width, size.height)),
        None => Err(Error::Memory { width: size.width, height: size.height, gib: bytes as f64 / f64::from(1 << 30) }),
    }
}

fn write(outputs: &[OutputPath], film: &Film, args: &RenderArgs, metadata: &Metadata) -> Result<(), Error> {
    let tonemap = match args.tonemap {
        Tonemap::Neutral => ToneMap::Neutral,
        Tonemap::Agx => ToneMap::Agx,
        Tonemap::Aces => ToneMap::Aces,
        Tonemap::None => ToneMap::None,
    };
    let display = Display { exposure_ev: args.exposure.into(), tonemap };
    for OutputPath { path, format } in outputs {
        match format {
            Format::Exr => write_exr(path, film, metadata)?,
            Format::Png => write_png(path, film, &display)?,
        }
    }
    Ok(())
}
