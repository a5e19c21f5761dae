//! The tables of a scene.

use std::fmt::Write as _;

use crate::{analysis::ratio, chart::escape, data::SceneData};

use super::{
    answer::sooner,
    text::{bytes, factor, level, percent, plus_minus, seconds, short},
};

const UNKNOWN: &str = "–";

/// A table: a head, and rows of cells that are HTML already.
fn table(html: &mut String, head: &[&str], rows: impl IntoIterator<Item = Vec<String>>) {
    *html += "<div class=\"scroll\"><table>\n<thead><tr>";
    let rows: Vec<Vec<String>> = rows.into_iter().collect();
    // Columns of words stand to the left, those of figures to the right.
    let is_word = |cell: &String| cell.starts_with(|c: char| c.is_alphabetic() || c == '<');
    let words = |column: usize| rows.iter().filter_map(|row| row.get(column)).any(is_word);
    let class = |column: usize| if words(column) { " class=\"words\"" } else { "" };
    for (column, cell) in head.iter().enumerate() {
        let _ = write!(html, "<th{}>{cell}</th>", class(column));
    }
    *html += "</tr></thead>\n<tbody>\n";
    for row in &rows {
        *html += "<tr>";
        for (column, cell) in row.iter().enumerate() {
            let _ = write!(html, "<td{}>{cell}</td>", class(column));
        }
        *html += "</tr>\n";
    }
    *html += "</tbody></table></div>\n";
}

fn name(scene: &SceneData, method: usize) -> String {
    let data = &scene.methods[method];
    let biased = if data.biased.is_some() { " <span class=\"biased\">biased</span>" } else { "" };
    escape(&data.name) + biased
}

fn or_unknown(text: Option<String>) -> String {
    text.unwrap_or_else(|| UNKNOWN.into())
}

/// Which method is the fastest to each error level.
pub(super) fn fastest(html: &mut String, scene: &SceneData) {
    let rows = scene.levels().into_iter().map(|e| {
        let ranking = scene.ranking(e, false);
        let Some(&(best, time)) = ranking.first() else {
            return vec![level(e), "only biased methods".into(), UNKNOWN.into(), UNKNOWN.into(), UNKNOWN.into()];
        };
        let second = ranking.get(1).map(|r| r.0);
        let later = second.and_then(|m| sooner(scene, m, best, e));
        vec![
            level(e),
            format!("<span class=\"best\">{}</span>", name(scene, best)),
            format!("{} ({} to {})", seconds(time.value), short(time.low), short(time.high)),
            or_unknown(second.map(|m| name(scene, m))),
            or_unknown(later.map(|f| if f.holds(1.0) { format!("{}, may be none", factor(&f)) } else { factor(&f) })),
        ]
    });
    table(html, &["error", "fastest", "time, 95 % interval", "next", "takes longer by"], rows);
}

/// Efficiency, slope and error at the end of each method, the best first.
pub(super) fn efficiency(html: &mut String, scene: &SceneData) {
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
        vec![
            name(scene, m),
            match relative {
                _ if Some(m) == best => "1 (the best)".into(),
                Some((interval, _)) => factor(&interval),
                None => UNKNOWN.into(),
            },
            or_unknown(scene.slope(m).map(|s| plus_minus(&s))),
            or_unknown(scene.methods[m].checkpoints.last().map(u32::to_string)),
            or_unknown(curve.last().map(|p| seconds(p.seconds))),
            or_unknown(curve.last().map(|p| percent(p.error))),
            or_unknown(scene.rows_of(m).filter_map(|r| r.flip).last().map(short)),
        ]
    });
    let head = ["method", "efficiency", "slope", "samples", "time", "error then", "FLIP"];
    table(html, &head, rows);
}

/// Predicted and real error at the end, coverage, and what is not certified.
pub(super) fn calibration(html: &mut String, scene: &SceneData) {
    let rows = (0..scene.methods.len()).map(|m| {
        let last = scene.calibration(m).last().copied();
        vec![
            name(scene, m),
            or_unknown(last.map(|p| percent(p.0))),
            or_unknown(last.map(|p| percent(p.1))),
            or_unknown(last.map(|p| short(p.1 / p.0))),
            or_unknown(scene.at_end(m, |r| r.coverage).map(|c| format!("{:.1} %", 100.0 * c))),
            or_unknown(scene.at_end(m, |r| r.uncertified).map(|u| format!("{:.1} %", 100.0 * u))),
        ]
    });
    table(
        html,
        &["method", "predicted", "real", "real / predicted", "95 % intervals that hold", "pixels not certified"],
        rows,
    );
}

/// Mean signed error, and what it means.
pub(super) fn bias(html: &mut String, scene: &SceneData) {
    let rows = (0..scene.methods.len()).map(|m| {
        let data = &scene.methods[m];
        let interval = scene.bias(m);
        let says = match (&data.biased, interval) {
            (Some(why), seen) => {
                let little =
                    if seen.is_some_and(|i| i.holds(0.0)) { ", too little to show in the mean here" } else { "" };
                format!("<span class=\"biased\">biased: {}{little}</span>", escape(why))
            }
            (None, None) => UNKNOWN.into(),
            (None, Some(i)) if i.holds(0.0) => "none seen".into(),
            // 1.96 standard errors are the half width; beyond 3 chance is no excuse for any of a dozen methods.
            (None, Some(i)) if i.value.abs() < 1.53 * (i.high - i.low) / 2.0 => {
                "within what chance does once in twenty".into()
            }
            (None, Some(_)) => "more than chance explains: error bars that are too short, or a defect".into(),
        };
        vec![name(scene, m), or_unknown(interval.map(|i| format!("{} %", plus_minus(&percent_of(i))))), says]
    });
    table(html, &["method", "mean error, 95 % interval", "bias"], rows);
}

fn percent_of(i: crate::analysis::Interval) -> crate::analysis::Interval {
    crate::analysis::Interval { value: 100.0 * i.value, low: 100.0 * i.low, high: 100.0 * i.high }
}

/// Where the time goes.
pub(super) fn stages(html: &mut String, scene: &SceneData) {
    let rows = (0..scene.methods.len()).map(|m| {
        let data = &scene.methods[m];
        let last = data.checkpoints.last();
        let ends: Vec<_> = scene.rows_of(m).filter(|r| Some(&r.spp) == last).collect();
        let [rays, paths] = [ends.iter().map(|r| r.rays).sum::<u64>(), ends.iter().map(|r| r.paths).sum()];
        let device: f64 = ends.iter().map(|r| r.device_seconds).sum();
        let lost: u64 = ends.iter().map(|r| r.dropped + r.truncated).sum();
        let known = |x: f64| if x.is_finite() && x > 0.0 { short(x) } else { UNKNOWN.into() };
        vec![
            name(scene, m),
            seconds(data.prepare_seconds),
            seconds(data.compile_seconds),
            known(paths as f64 / device / 1e6),
            known(rays as f64 / device / 1e6),
            known(rays as f64 / paths as f64),
            bytes(data.device_bytes),
            lost.to_string(),
        ]
    });
    let head = [
        "method",
        "BVH etc.",
        "compiling",
        "Mpaths/s",
        "Mrays/s",
        "rays a path",
        "device memory",
        "samples dropped or cut",
    ];
    table(html, &head, rows);
}
