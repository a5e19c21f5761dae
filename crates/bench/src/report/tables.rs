//! The tables of a scene.

use maud::{Markup, Render, html};

use crate::{analysis::ratio, data::SceneData};

use super::{
    answer::sooner,
    text::{bytes, factor, level, percent, plus_minus, seconds, short},
};

const UNKNOWN: &str = "–";

/// A table: a head, and rows of cells.
fn table<const N: usize>(head: [&str; N], rows: impl IntoIterator<Item = [Markup; N]>) -> Markup {
    let rows: Vec<[Markup; N]> = rows.into_iter().collect();
    // Columns of words are aligned to the left, those of figures to the right.
    let is_word = |cell: &Markup| cell.0.starts_with(|c: char| c.is_alphabetic() || c == '<');
    let class = |column: usize| rows.iter().any(|row| is_word(&row[column])).then_some("words");
    html! {
        div.scroll {
            table {
                thead {
                    tr { @for (column, cell) in head.iter().enumerate() { th class=[class(column)] { (cell) } } }
                }
                tbody {
                    @for row in &rows {
                        tr { @for (column, cell) in row.iter().enumerate() { td class=[class(column)] { (cell) } } }
                    }
                }
            }
        }
    }
}

/// A cell of text.
fn cell(text: impl Render) -> Markup {
    html! { (text) }
}

fn name(scene: &SceneData, method: usize) -> Markup {
    let data = &scene.methods[method];
    html! { (data.name) @if data.biased.is_some() { " " span.biased { "biased" } } }
}

fn or_unknown(text: Option<impl Render>) -> Markup {
    text.map_or_else(|| cell(UNKNOWN), cell)
}

/// The fastest method to each error level.
pub(super) fn fastest(scene: &SceneData) -> Markup {
    let rows = scene.levels().into_iter().map(|e| {
        let ranking = scene.ranking(e, false);
        let Some(&(best, time)) = ranking.first() else {
            return [&level(e), "only biased methods", UNKNOWN, UNKNOWN, UNKNOWN].map(cell);
        };
        let second = ranking.get(1).map(|r| r.0);
        let later = second.and_then(|m| sooner(scene, m, best, e));
        [
            cell(level(e)),
            html! { span.best { (name(scene, best)) } },
            cell(format!("{} ({} to {})", seconds(time.value), short(time.low), short(time.high))),
            or_unknown(second.map(|m| name(scene, m))),
            or_unknown(later.map(|f| if f.holds(1.0) { format!("{}, may be none", factor(&f)) } else { factor(&f) })),
        ]
    });
    table(["error", "fastest", "time, 95 % interval", "next", "takes longer by"], rows)
}

/// Efficiency, slope and error at the end of each method, the best first.
pub(super) fn efficiency(scene: &SceneData) -> Markup {
    let geometric = |m: usize| {
        let all = scene.efficiencies(m);
        (!all.is_empty()).then(|| (all.iter().map(|e| e.ln()).sum::<f64>() / all.len() as f64).exp())
    };
    let mut order: Vec<usize> = (0..scene.methods.len()).collect();
    let key = |m: usize| (scene.methods[m].biased.is_some(), -geometric(m).unwrap_or(0.0));
    order.sort_by(|&a, &b| key(a).0.cmp(&key(b).0).then(key(a).1.total_cmp(&key(b).1)));
    let best = order.first().copied().filter(|&m| scene.methods[m].biased.is_none());
    let rows = order.into_iter().map(|m| {
        let relative = best.filter(|&b| b != m && scene.methods[m].biased.is_none());
        let relative = relative.and_then(|b| ratio(&scene.efficiencies(m), &scene.efficiencies(b)));
        let curve = scene.curve(m);
        [
            name(scene, m),
            match relative {
                _ if Some(m) == best => cell("1 (the best)"),
                Some((interval, _)) => cell(factor(&interval)),
                None => cell(UNKNOWN),
            },
            or_unknown(scene.slope(m).map(|s| plus_minus(&s))),
            or_unknown(scene.methods[m].checkpoints.last().map(u32::to_string)),
            or_unknown(curve.last().map(|p| seconds(p.seconds))),
            or_unknown(curve.last().map(|p| percent(p.error))),
            or_unknown(scene.rows_of(m).filter_map(|r| r.flip).last().map(short)),
        ]
    });
    let head = ["method", "efficiency", "slope", "samples", "time", "error then", "FLIP"];
    table(head, rows)
}

/// Predicted and real error at the end, coverage, and pixels without a certificate.
pub(super) fn calibration(scene: &SceneData) -> Markup {
    let rows = (0..scene.methods.len()).map(|m| {
        let last = scene.calibration(m).last().copied();
        [
            name(scene, m),
            or_unknown(last.map(|p| percent(p.0))),
            or_unknown(last.map(|p| percent(p.1))),
            or_unknown(last.map(|p| short(p.1 / p.0))),
            or_unknown(scene.at_end(m, |r| r.coverage).map(|c| format!("{:.1} %", 100.0 * c))),
            or_unknown(scene.at_end(m, |r| r.uncertified).map(|u| format!("{:.1} %", 100.0 * u))),
        ]
    });
    table(["method", "predicted", "real", "real / predicted", "95 % intervals that hold", "pixels not certified"], rows)
}

/// Mean signed error, and its meaning.
pub(super) fn bias(scene: &SceneData) -> Markup {
    let rows = (0..scene.methods.len()).map(|m| {
        let data = &scene.methods[m];
        let interval = scene.bias(m);
        let says = match (&data.biased, interval) {
            (Some(why), seen) => {
                let little =
                    if seen.is_some_and(|i| i.holds(0.0)) { ", too little to show in the mean here" } else { "" };
                html! { span.biased { "biased: " (why) (little) } }
            }
            (None, None) => cell(UNKNOWN),
            (None, Some(i)) if i.holds(0.0) => cell("none detected"),
            // The half width is 1.96 standard errors; among a dozen methods an error beyond 3 is
            // not due to chance.
            (None, Some(i)) if i.value.abs() < 1.53 * (i.high - i.low) / 2.0 => {
                cell("within the chance of one in twenty")
            }
            (None, Some(_)) => cell("more than chance explains: error bars that are too short, or a defect"),
        };
        [name(scene, m), or_unknown(interval.map(|i| format!("{} %", plus_minus(&percent_of(i))))), says]
    });
    table(["method", "mean error, 95 % interval", "bias"], rows)
}

fn percent_of(i: crate::analysis::Interval) -> crate::analysis::Interval {
    crate::analysis::Interval { value: 100.0 * i.value, low: 100.0 * i.low, high: 100.0 * i.high }
}

/// The stages of the time.
pub(super) fn stages(scene: &SceneData) -> Markup {
    let rows = (0..scene.methods.len()).map(|m| {
        let data = &scene.methods[m];
        let last = data.checkpoints.last();
        let ends: Vec<_> = scene.rows_of(m).filter(|r| Some(&r.spp) == last).collect();
        let [rays, paths] = [ends.iter().map(|r| r.rays).sum::<u64>(), ends.iter().map(|r| r.paths).sum()];
        let device: f64 = ends.iter().map(|r| r.device_seconds).sum();
        let lost: u64 = ends.iter().map(|r| r.dropped + r.truncated).sum();
        let known = |x: f64| or_unknown((x.is_finite() && x > 0.0).then(|| short(x)));
        [
            name(scene, m),
            cell(seconds(data.prepare_seconds)),
            cell(seconds(data.compile_seconds)),
            known(paths as f64 / device / 1e6),
            known(rays as f64 / device / 1e6),
            known(rays as f64 / paths as f64),
            cell(bytes(data.device_bytes)),
            cell(lost),
        ]
    });
    let head = [
        "method",
        "BVH etc.",
        "compiling",
        "Mpaths/s",
        "Mrays/s",
        "rays per path",
        "device memory",
        "samples dropped or cut",
    ];
    table(head, rows)
}
