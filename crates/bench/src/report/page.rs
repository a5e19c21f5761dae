//! The page: everything in one file, without scripts and without the network.

use std::fmt::Write as _;
use std::path::Path;

use crate::{
    chart::{Chart, escape},
    conditions::Conditions,
    data::{Clock, Data, SceneData},
};

use super::{answer::answer, pictures::pictures, style::CSS, tables, text};

/// The page of a report whose pictures lie in `folder`.
pub(super) fn page(folder: &Path, data: &Data, scenes: &[(&SceneData, Vec<Chart>)]) -> String {
    let names: Vec<&str> = data.scenes.iter().map(|s| s.name.as_str()).collect();
    let title = format!("Speed against accuracy: {}", names.join(", "));
    let mut html = format!(
        "<!DOCTYPE html>\n<html lang=\"en\">\n<head>\n<meta charset=\"utf-8\"/>\n<meta name=\"viewport\" \
         content=\"width=device-width, initial-scale=1\"/>\n<title>{0}</title>\n<style>{CSS}</style>\n</head>\n<body>\n\
         <h1>{0}</h1>\n",
        escape(&title)
    );
    html += INTRODUCTION;
    if scenes.len() > 1 {
        html += "<ul>\n";
        for (scene, _) in scenes {
            let name = escape(&scene.name);
            let _ = writeln!(html, "<li><a href=\"#{name}\">{name}</a>: {}</li>", escape(&answer(scene)));
        }
        html += "</ul>\n";
    }
    for (scene, charts) in scenes {
        section(&mut html, folder, scene, charts);
    }
    conditions(&mut html, &data.conditions);
    html += "</body>\n</html>\n";
    html
}

const INTRODUCTION: &str = "<p>A path tracer estimates each pixel by random light paths: more paths, less noise. A \
<em>method</em> is a way to choose them. <strong>hemisphere</strong> samples directions and meets lights by chance, \
<strong>area</strong> samples points on lights, <strong>mis</strong> does both and weighs them, and <strong>caustics</strong> also sends \
light from the lamps through glass and by mirrors; <strong>whitted</strong> is \
the classic ray tracer of 1980, fast and not quite true. After the slash stands where the random numbers come from: \
<strong>independent</strong> ones, <strong>stratified</strong> ones, or well-spread <strong>sobol</strong> points. Below: which method \
comes to a given error first, whether it knows its own error, and what it costs.</p>\n";

fn section(html: &mut String, folder: &Path, scene: &SceneData, charts: &[Chart]) {
    // Writing to a string cannot fail, here and elsewhere on the page.
    let name = escape(&scene.name);
    let _ = writeln!(html, "<h2 id=\"{name}\">{name}</h2>\n<p class=\"answer\">{}</p>", escape(&answer(scene)));
    facts(html, scene);
    for warning in &scene.warnings {
        let _ = writeln!(html, "<p class=\"note\">{}.</p>", escape(warning.trim_end_matches('.')));
    }
    let figure = |html: &mut String, name: &str| {
        if let Some(chart) = charts.iter().find(|c| c.name == name) {
            self::figure(html, chart);
        }
    };

    paragraph(
        html,
        "How fast the error falls",
        "Further left is sooner, further down is more accurate. The relative RMS error is the root of the mean over \
        pixels of (difference)²/(reference² + 1 % of the mean square); bands span the repeats. Independent samples follow the faint \
        diagonals: four times the work halves the error. A line that flattens has a floor that time does not lower: a bias. One that jumps has met a \
        rare, bright path.",
    );
    figure(html, "error-time");
    figure(html, "error-samples");

    paragraph(
        html,
        "The fastest way to each error",
        "Points on the front have no other before them, both sooner and more accurate. Efficiency is 1/(error² · time), \
        what a second buys, relative to the best; it does not depend on when one stops as long as the slope is −½. Ratios are means over repeats with 95 % intervals.",
    );
    figure(html, "front");
    tables::fastest(html, scene);
    tables::efficiency(html, scene);

    paragraph(
        html,
        "Do the error bars hold?",
        "Each render estimates its own error from the spread of its batches. On the line it is right; above it the render thinks \
        better of itself than it should, because some bright path has not been met yet. Of 95 % intervals, 95 % should hold the reference. Pixels that a single sample \
        could still overturn are not certified.",
    );
    figure(html, "calibration");
    tables::calibration(html, scene);

    paragraph(
        html,
        "Bias",
        "The mean over the whole picture, less that of the reference. Noise averages out here, so what is left outside of the interval is a bias, or light that was \
        never found.",
    );
    figure(html, "bias");
    tables::bias(html, scene);

    let equal = match scene.seconds_a_method {
        _ if equal_samples(scene) => "equal samples".to_owned(),
        _ => "about equal time".to_owned(),
    };
    paragraph(
        html,
        &format!("Pictures at {equal}"),
        "Left the picture, right where it errs: warm is too bright, cool too dark, full colour at 50 % of the \
        reference, black where it is right. Grey hatching marks pixels whose error bar is not certified.",
    );
    pictures(html, folder, scene);

    paragraph(
        html,
        "Where the time goes",
        &format!(
            "Reading the file took {}. Tracing is the time of dispatches by the clock of the device, if it has one (see the conditions); \
             submitting and waiting is what they take longer on the host, where their sums are read and added to the film, too.",
            text::seconds(scene.load_seconds)
        ),
    );
    if let Some(walk) = &scene.walk {
        let percent = |x: f64| format!("{:.0} %", 100.0 * x);
        let _ = writeln!(
            html,
            "<p class=\"note\">The kernel is one program, so its stages have no clocks of their own. Of {}, {} ({} to {}) is walking rays through the \
             BVH: that much longer it takes when every ray is walked twice. The rest is shading, sampling, and keeping paths between dispatches.</p>",
            escape(&walk.method),
            percent(walk.share),
            percent(walk.low),
            percent(walk.high),
        );
    }
    figure(html, "stages");
    tables::stages(html, scene);
}

fn equal_samples(scene: &SceneData) -> bool {
    let mut ends = scene.methods.iter().map(|m| m.checkpoints.last());
    let first = ends.next();
    ends.all(|end| Some(end) == first)
}

fn facts(html: &mut String, scene: &SceneData) {
    let reference = &scene.reference;
    let own = match reference.rel_mse {
        Some(e) => format!("whose own error of {} is taken off and limits what can be read", text::percent(e.sqrt())),
        None => "whose own error is not known: lines that flatten may show the reference".into(),
    };
    let reason = if reference.reason.is_empty() { String::new() } else { format!(" ({})", escape(&reference.reason)) };
    let samples = if reference.spp > 0 { format!(" with {} samples a pixel", reference.spp) } else { String::new() };
    let clock = match scene.clock {
        Clock::Wall => "Times are those on the wall.",
        Clock::Device => "Times are those of dispatches by the clock of the device.",
        Clock::Cpu => "Times are processor seconds over cores, which other work on the machine hardly changes.",
    };
    let _ = writeln!(
        html,
        "<p class=\"note\">{}: {} × {} pixels, {} triangles; {} repeats of each method with samples of their own, in turn. Errors are measured from a \
         reference by {}{reason}{samples}, {own}. {clock}</p>",
        escape(&scene.file),
        scene.width,
        scene.height,
        scene.triangles,
        scene.repeats,
        escape(&reference.source),
    );
}

fn paragraph(html: &mut String, title: &str, body: &str) {
    let _ = writeln!(html, "<h3>{}</h3>\n<p class=\"note\">{}</p>", escape(title), escape(body));
}

fn figure(html: &mut String, chart: &Chart) {
    let inline = |svg: &str, class: &str| format!("<div class=\"{class}\">{}</div>", svg.trim());
    let _ = writeln!(html, "<figure>{}{}</figure>", inline(&chart.wide, "wide"), inline(&chart.narrow, "narrow"));
}

fn conditions(html: &mut String, c: &Conditions) {
    let commit = if c.commit.is_empty() { String::new() } else { format!(" ({})", c.commit) };
    let software = if c.software { ", a software driver" } else { "" };
    let load =
        if c.load.is_empty() { String::new() } else { format!("{} processes wanted to run before it began", c.load) };
    let rows = [
        ("Surelight", format!("{}{commit}", c.version)),
        ("Date", c.date.clone()),
        ("Device", format!("{}{software}", c.device)),
        ("Driver", format!("{}, {}", c.driver, c.backend)),
        ("Clock of the device", c.device_clock.clone()),
        ("Processor", format!("{}, {} threads", c.cpu, c.threads)),
        ("System", c.system.clone()),
        ("Load", load),
        ("Note", c.note.clone()),
    ];
    *html += "<h2>Conditions</h2>\n<dl>\n";
    for (name, value) in rows.iter().filter(|(_, value)| !value.is_empty()) {
        let _ = writeln!(html, "<dt>{name}</dt><dd>{}</dd>", escape(value));
    }
    *html += "</dl>\n";
}
