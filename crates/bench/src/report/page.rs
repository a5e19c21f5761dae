//! The page: everything in one file, without scripts and without the network.

use std::path::Path;

use maud::{DOCTYPE, Markup, PreEscaped, html};

use crate::{
    chart::Chart,
    conditions::Conditions,
    data::{Clock, Data, SceneData, WalkData},
};

use super::{answer::answer, pictures::pictures, style::CSS, tables, text};

/// The page of a report whose pictures are in `folder`.
pub(super) fn page(folder: &Path, data: &Data, scenes: &[(&SceneData, Vec<Chart>)]) -> String {
    let names: Vec<&str> = data.scenes.iter().map(|s| s.name.as_str()).collect();
    let title = format!("Speed against accuracy: {}", names.join(", "));
    let page = html! {
        (DOCTYPE)
        html lang="en" {
            head {
                meta charset="utf-8";
                meta name="viewport" content="width=device-width, initial-scale=1";
                title { (title) }
                style { (PreEscaped(CSS)) }
            }
            body {
                h1 { (title) }
                (introduction())
                @if scenes.len() > 1 {
                    ul {
                        @for (scene, _) in scenes {
                            li { a href={ "#" (scene.name) } { (scene.name) } ": " (answer(scene)) }
                        }
                    }
                }
                @for (scene, charts) in scenes { (section(folder, scene, charts)) }
                (conditions(&data.conditions))
            }
        }
    };
    page.into_string()
}

fn introduction() -> Markup {
    html! {
        p {
            "A path tracer estimates each pixel by random light paths: more paths, less noise. A "
            em { "method" } " is a way to choose them. "
            strong { "hemisphere" } " samples directions and hits lights by chance, "
            strong { "area" } " samples points on lights, "
            strong { "mis" } " does both and weighs them, and "
            strong { "caustics" } " also sends light from the lamps through glass and by mirrors; "
            strong { "whitted" } " is the classic ray tracer of 1980, fast and not quite true. "
            "After the slash is the source of the random numbers: "
            strong { "independent" } " ones, " strong { "stratified" } " ones, or well-spread "
            strong { "sobol" } " points. Below: which method reaches a given error first, whether it "
            "knows its own error, and its cost."
        }
    }
}

fn section(folder: &Path, scene: &SceneData, charts: &[Chart]) -> Markup {
    let figure = |name: &str| html! { @for chart in charts.iter().filter(|c| c.name == name) { (figure(chart)) } };
    let equal = if equal_samples(scene) { "equal samples" } else { "about equal time" };
    html! {
        h2 id=(scene.name) { (scene.name) }
        p.answer { (answer(scene)) }
        (facts(scene))
        @for warning in &scene.warnings { p.note { (warning.trim_end_matches('.')) "." } }

        h3 { "How fast the error falls" }
        p.note {
            "Further left is sooner, further down is more accurate. The relative RMS error is the root of "
            "the mean over pixels of (difference)²/(reference² + 1 % of the mean square); bands span the "
            "repeats. Independent samples follow the faint diagonals: four times the work halves the "
            "error. A line that flattens has a floor that time does not lower: a bias. One that jumps has "
            "sampled a rare, bright path."
        }
        (figure("error-time"))
        (figure("error-samples"))

        h3 { "The fastest way to each error" }
        p.note {
            "Points on the front have no other before them, both sooner and more accurate. Efficiency is "
            "1/(error² · time), the gain per second, relative to the best; it does not depend on when one "
            "stops as long as the slope is −½. Ratios are means over repeats with 95 % intervals."
        }
        (figure("front"))
        (tables::fastest(scene))
        (tables::efficiency(scene))

        h3 { "Do the error bars hold?" }
        p.note {
            "Each render estimates its own error from the spread of its batches. On the line it is right; "
            "above it the render thinks better of itself than it should, because some bright path has not "
            "been sampled yet. Of 95 % intervals, 95 % should hold the reference. Pixels that a single sample "
            "could still overturn are not certified."
        }
        (figure("calibration"))
        (tables::calibration(scene))

        h3 { "Bias" }
        p.note {
            "The mean over the whole picture, less that of the reference. Noise averages out here, so an "
            "error beyond the interval is a bias, or light that was never found."
        }
        (figure("bias"))
        (tables::bias(scene))

        h3 { "Pictures at " (equal) }
        p.note {
            "Left the picture, right the map of its errors: warm is too bright, cool too dark, full colour "
            "at 50 % of the reference, black where it is right. Grey hatching marks pixels that are not "
            "certified."
        }
        (pictures(folder, scene))

        h3 { "Where the time goes" }
        p.note {
            "Reading the file took " (text::seconds(scene.load_seconds)) ". Tracing is the time of "
            "dispatches by the clock of the device, if it has one (see the conditions); submitting and "
            "waiting is their additional time on the host, where their sums are read and added to the "
            "film, too."
        }
        @if let Some(walk) = &scene.walk { (self::walk(walk)) }
        (figure("stages"))
        (tables::stages(scene))
    }
}

fn equal_samples(scene: &SceneData) -> bool {
    let mut ends = scene.methods.iter().map(|m| m.checkpoints.last());
    let first = ends.next();
    ends.all(|end| Some(end) == first)
}

fn facts(scene: &SceneData) -> Markup {
    let reference = &scene.reference;
    let own = match reference.rel_mse {
        Some(e) => {
            format!("whose own error of {} is subtracted; smaller errors cannot be resolved", text::percent(e.sqrt()))
        }
        None => "whose own error is unknown: lines that flatten may show the error of the reference".into(),
    };
    let clock = match scene.clock {
        Clock::Wall => "Times are wall-clock times.",
        Clock::Device => "Times are those of dispatches by the clock of the device.",
        Clock::Cpu => "Times are CPU seconds divided by cores, which other work on the machine hardly changes.",
    };
    html! {
        p.note {
            (scene.file) ": " (scene.width) " × " (scene.height) " pixels, " (scene.triangles) " triangles; "
            (scene.repeats) " repeats of each method with independent samples, in turn. Errors are "
            "measured against a reference by " (reference.source)
            @if !reference.reason.is_empty() { " (" (reference.reason) ")" }
            @if reference.spp > 0 { " with " (reference.spp) " samples per pixel" }
            ", " (own) ". " (clock)
        }
    }
}

fn walk(walk: &WalkData) -> Markup {
    let percent = |x: f64| format!("{:.0} %", 100.0 * x);
    html! {
        p.note {
            "The kernel is one program, so its stages have no clocks of their own. Of " (walk.method) ", "
            (percent(walk.share)) " (" (percent(walk.low)) " to " (percent(walk.high)) ") is traversal "
            "of the BVH: the additional time when every ray is traversed twice. The rest is "
            "shading, sampling, and saving paths between dispatches."
        }
    }
}

fn figure(chart: &Chart) -> Markup {
    html! {
        figure {
            div.wide { (PreEscaped(chart.wide.trim())) }
            div.narrow { (PreEscaped(chart.narrow.trim())) }
        }
    }
}

fn conditions(c: &Conditions) -> Markup {
    let commit = if c.commit.is_empty() { String::new() } else { format!(" ({})", c.commit) };
    let software = if c.software { ", a software driver" } else { "" };
    let load = if c.load.is_empty() { String::new() } else { format!("{} on average before the start", c.load) };
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
    html! {
        h2 { "Conditions" }
        dl {
            @for (name, value) in rows.iter().filter(|(_, value)| !value.is_empty()) {
                dt { (name) }
                dd { (value) }
            }
        }
    }
}
