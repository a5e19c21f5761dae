//! `surelight measure`: one number with its error bar.

mod args;
mod report;
mod sampling;
mod tally;
mod view;

use std::time::Instant;

use surelight_estimate::{Estimate, student_t_half_width};
use surelight_prepare::Prepared;
use surelight_render::{Device, Renderer};

pub(crate) use self::args::MeasureArgs;
use self::report::{Report, Value};
use self::sampling::Measurement;
use crate::error::Error;
use crate::{camera, console, light, method, render};

/// Measures and prints the result; returns whether the target was reached.
pub(crate) fn run(args: &MeasureArgs) -> Result<bool, Error> {
    let start = Instant::now();
    let options = args.file.load_options();
    let mut scene = args.scene.load(&options)?;
    let light_note = light::set(&mut scene, &args.light)?;
    let mut warnings = std::mem::take(&mut scene.warnings);
    warnings.extend(light_note);
    warnings.extend(args.method.warning(&scene));
    let device = Device::new(&render::adapter_choice(args.adapter.as_ref()))?;
    let setup = view::setup(args, &scene, device.info.is_cpu)?;
    let prepared = Prepared::new(&scene, &setup.camera, &setup.settings)?;
    warnings.extend(camera::clipping_warning(&setup.camera, prepared.cut));
    let mut measurement = Measurement { renderer: Renderer::new(&device, &prepared)?, setup };
    let unreachable = prepared.unreachable.clone();
    drop(prepared);
    let plan = measurement.plan(args, start)?;
    let (mut tally, stopped) = measurement.carry_out(&plan)?;

    let Measurement { renderer, setup, .. } = measurement;
    let mut biased: Vec<String> = args.method.bias(&scene).into_iter().collect();
    biased.extend(unreachable.iter().filter(|light| light.is_bias()).map(ToString::to_string));
    warnings.extend(unreachable.iter().filter(|light| !light.is_bias()).map(ToString::to_string));
    if let Some(bounces) = args.max_bounces.0 {
        biased.push(format!("max-bounces {bounces}"));
    }
    let estimates = tally.estimates(setup.factor);
    let values = estimates.map(|e| value(&e, args.confidence));
    let luminance = values[3];
    let relative_error = luminance.half_width.filter(|_| luminance.value != 0.0).map(|h| h / luminance.value.abs());
    let tail = tally.tail();
    let mut report = Report {
        scene: args.scene.name().display().to_string(),
        quantity: if setup.settings.receiver {
            "irradiance"
        } else if setup.same_quantity {
            "radiance"
        } else {
            "mean radiance"
        },
        place: place(args),
        rgb: [values[0], values[1], values[2]],
        luminance,
        unit: if setup.settings.receiver { "lx" } else { "nit" },
        confidence: args.confidence,
        relative_error,
        target_error: args.error,
        stopped,
        samples: plan.pixels * u64::from(plan.samples) * u64::from(tally.batches()),
        replicates: tally.replicates(),
        pilot_samples: plan.pilot_samples,
        tail: tail.map(|t| [t.k, t.limit]),
        certified: true,
        integrator: method::word(args.method.with(setup.settings.integrator).integrator),
        seed: args.seed,
        adapter: device.info.name.clone(),
        rays: renderer.counts.rays,
        seconds: 0.0,
        dropped_samples: renderer.counts.dropped,
        truncated_rays: renderer.counts.truncated,
        biased,
        warnings,
        notes: setup.notes,
    };
    judge(&mut report);
    report.seconds = start.elapsed().as_secs_f64();
    let text = if args.json {
        serde_json::to_string(&report).map_err(|e| Error::Print(e.into()))? + "\n"
    } else {
        report.to_string()
    };
    console::result(&text)?;
    Ok(report.stopped == "done")
}

/// Notes reasons to doubt the error bar, and whether the target is reached.
fn judge(report: &mut Report) {
    let mut doubts = Vec::new();
    if let Some([k, limit]) = report.tail.filter(|[k, limit]| k > limit) {
        doubts.push(format!(
            "the estimates have a heavy tail (Pareto k = {k:.2}, above {limit:.2}): rare bright paths may be missing, \
             and the error bar cannot be trusted"
        ));
    }
    if report.luminance.value == 0.0 {
        doubts.push(
            "every sample was black: either there is no light here, or its paths are too rare to be found".to_owned(),
        );
    }
    if report.dropped_samples > 0 {
        doubts.push(format!("{} samples were not finite and were left out", report.dropped_samples));
    }
    if report.truncated_rays > 0 {
        doubts.push(format!("{} rays were cut short, their samples are incomplete", report.truncated_rays));
    }
    if report.luminance.half_width.is_none() {
        doubts.push("one estimate alone has no error bar".to_owned());
    }
    report.certified = doubts.is_empty();
    report.notes.extend(doubts);
    if !report.biased.is_empty() {
        report.notes.push("the error bar holds for the biased quantity, not for the true one".to_owned());
    }
    if let Some(target) = report.target_error
        && report.stopped == "done"
        && !(report.certified && report.relative_error.is_some_and(|e| e <= target))
    {
        report.stopped = if report.certified { "missed" } else { "unreachable" };
    }
    report.notes.push("± is the error of sampling; f32 rounding may add about 1e-6 of the value".to_owned());
}

fn value(estimate: &Estimate, confidence: f64) -> Value {
    let known = estimate.dof >= 1.0 && estimate.variance.is_finite();
    // Without spread the degrees of freedom do not matter.
    let dof = if estimate.dof.is_finite() { estimate.dof } else { 1e9 };
    let half_width = known.then(|| student_t_half_width(confidence, estimate.variance.sqrt(), dof));
    Value { value: estimate.mean, half_width }
}

fn place(args: &MeasureArgs) -> String {
    let point = |p: [f64; 3]| format!("{},{},{}", p[0], p[1], p[2]);
    match (args.point, args.direction, args.irradiance, args.normal, args.region) {
        (Some(p), Some(d), ..) => format!("at {} from the direction {}", point(p), point(d)),
        (_, _, Some(p), Some(n), _) => format!("at {} on a surface facing {}", point(p), point(n)),
        (.., Some([x0, y0, x1, y1])) => format!("of the pixels {x0},{y0} to {x1},{y1} (the latter outside)"),
        _ => String::new(),
    }
}
