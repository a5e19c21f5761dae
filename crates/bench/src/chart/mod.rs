//! The charts of a report, as SVG; `canvas` converts each to PNG, too.

mod axis;
mod canvas;
mod lines;
pub mod plain;
mod rows;

use crate::{
    analysis::STAGES,
    data::{Clock, SceneData},
    error::BenchError,
    overlay::Peer,
};

use axis::{Axis, Unit};
use canvas::{COLORS, Dash, Fill, INK, Style};
use lines::{Guide, Lines, Series};
use rows::{Content, Rows};

pub use canvas::Format;
pub(crate) use canvas::{escape, png};

/// A chart in both formats.
pub struct Chart {
    /// Stem of its files.
    pub name: &'static str,
    /// For large screens and print.
    pub wide: String,
    /// For phones.
    pub narrow: String,
}

/// Draws a chart in both formats.
fn both(name: &'static str, draw: impl Fn(Format) -> Result<String, BenchError>) -> Result<Chart, BenchError> {
    Ok(Chart { name, wide: draw(Format::Wide)?, narrow: draw(Format::Narrow)? })
}

/// Styles of the methods: a colour and a shape for each integrator with its options, fill and
/// dashes for samplers.
fn styles(scene: &SceneData) -> Vec<Style> {
    let mut groups = Vec::new();
    let methods = scene.methods.iter().map(|method| {
        let words = &method.words;
        let limits = (&words.max_bounces, &words.max_radiance);
        let group = (&words.integrator, &words.directions, limits, &words.scrambles, &words.shared_paths);
        let index = groups.iter().position(|g| *g == group).unwrap_or_else(|| {
            groups.push(group);
            groups.len() - 1
        });
        let (fill, dash) = match words.sampler.as_str() {
            "sobol" => (Fill::Full, Dash::Solid),
            "stratified" => (Fill::Dot, Dash::Dashed),
            _ => (Fill::White, Dash::Dotted),
        };
        lines::style(index, fill, dash)
    });
    methods.collect()
}

/// The meaning of the seconds.
pub(crate) fn seconds_label(clock: Clock) -> &'static str {
    match clock {
        Clock::Wall => "time (s)",
        Clock::Device => "device time (s)",
        Clock::Cpu => "processor time / cores (s)",
    }
}

const ERROR_LABEL: &str = "relative RMS error";

/// The name of a method, marked where it is biased.
fn named(scene: &SceneData, method: usize) -> String {
    let data = &scene.methods[method];
    format!("{}{}", data.name, if data.biased.is_some() { " (biased)" } else { "" })
}

/// Methods from the least accurate to the most, so that the legend is in the order of the lines'
/// ends.
fn by_final_error(scene: &SceneData) -> Vec<usize> {
    let mut order: Vec<usize> = (0..scene.methods.len()).collect();
    let last = |m: usize| scene.curve(m).last().map_or(f64::MAX, |p| p.error);
    order.sort_by(|&a, &b| last(b).total_cmp(&last(a)));
    order
}

/// The level of the reference's own error, where it is within the axis.
fn own_error(scene: &SceneData, y: &Axis) -> Option<Guide> {
    let own = scene.reference.rel_mse.map(f64::sqrt).filter(|own| (y.low..y.high).contains(own))?;
    Some(Guide::Level { at: own, name: "the reference's own".into() })
}

/// Other renderers' points, one series per renderer.
fn peers(scene: &SceneData, peers: &[Peer], over_samples: bool) -> Vec<Series> {
    let mut series: Vec<Series> = Vec::new();
    for peer in peers.iter().filter(|p| p.scene == scene.name) {
        let x = if over_samples { peer.spp.map(f64::from) } else { Some(peer.seconds) };
        let Some(x) = x else { continue };
        let point = (x, peer.rel_mse.sqrt());
        match series.iter_mut().find(|s| s.name == peer.renderer) {
            Some(found) => found.points.push(point),
            None => {
                let style = Style { color: INK, shape: 5 - series.len() % 3, fill: Fill::White, dash: Dash::Dotted };
                series.push(Series { name: peer.renderer.clone(), style, points: vec![point], band: Vec::new() });
            }
        }
    }
    series.iter_mut().for_each(|s| s.points.sort_by(|a, b| a.0.total_cmp(&b.0)));
    series
}

/// Error against time or samples, log–log, one line per method.
pub fn convergence(scene: &SceneData, others: &[Peer], over_samples: bool) -> Result<Chart, BenchError> {
    let styles = styles(scene);
    let x_of = |p: &crate::analysis::Point| if over_samples { f64::from(p.spp) } else { p.seconds };
    let own = by_final_error(scene).into_iter().map(|m| {
        let curve = scene.curve(m);
        Series {
            name: named(scene, m),
            style: styles[m],
            points: curve.iter().map(|p| (x_of(p), p.error)).collect(),
            band: curve.iter().map(|p| p.band).collect(),
        }
    });
    let series: Vec<Series> = own.chain(peers(scene, others, over_samples)).collect();
    let points = || series.iter().flat_map(|s| s.points.iter().copied());
    let x = Axis::log(points().map(|p| p.0), Unit::Plain);
    let y = Axis::log(points().map(|p| p.1), Unit::Percent);
    let mut guides = vec![Guide::Power { exponent: -0.5, name: "slope −½: half for 4 ×".into() }];
    guides.extend(own_error(scene, &y));
    let (name, what, x_label) = match over_samples {
        true => ("error-samples", "samples", "samples a pixel"),
        false => ("error-time", "time", seconds_label(scene.clock)),
    };
    let lines = Lines {
        name: name.into(),
        title: format!("{}: error against {what}", scene.name),
        x,
        y,
        x_label: x_label.into(),
        y_label: ERROR_LABEL.into(),
        series,
        guides,
    };
    both(name, |format| lines.draw(format))
}

/// The fastest way to each error: every checkpoint of the methods without bias, and their Pareto
/// front.
pub fn front(scene: &SceneData, others: &[Peer]) -> Result<Chart, BenchError> {
    let styles = styles(scene);
    let order = by_final_error(scene).into_iter().filter(|&m| scene.methods[m].biased.is_none());
    let mut series: Vec<Series> = order
        .map(|m| Series {
            name: named(scene, m),
            style: Style { dash: Dash::None, ..styles[m] },
            points: scene.curve(m).iter().map(|p| (p.seconds, p.error)).collect(),
            band: Vec::new(),
        })
        .collect();
    series.extend(peers(scene, others, false));
    let front = scene.front();
    let points = || series.iter().flat_map(|s| s.points.iter().copied());
    let x = Axis::log(points().map(|p| p.0), Unit::Plain);
    let y = Axis::log(points().map(|p| p.1), Unit::Percent);
    let guides = own_error(scene, &y).into_iter().collect();
    // Drawn below the marks.
    let style = Style { color: COLORS[4], shape: usize::MAX, fill: Fill::Full, dash: Dash::Solid };
    let points = front.iter().map(|&(_, point)| (point.seconds, point.error)).collect();
    series.insert(0, Series { name: "the front".into(), style, points, band: Vec::new() });
    let lines = Lines {
        name: "front".into(),
        title: format!("{}: the fastest way to each error", scene.name),
        x,
        y,
        x_label: seconds_label(scene.clock).into(),
        y_label: ERROR_LABEL.into(),
        series,
        guides,
    };
    both("front", |format| lines.draw(format))
}

/// Predicted against real error: on the diagonal the error bars are right, above it they are too
/// narrow.
pub fn calibration(scene: &SceneData) -> Result<Chart, BenchError> {
    let styles = styles(scene);
    let series: Vec<Series> = by_final_error(scene)
        .into_iter()
        .map(|m| Series {
            name: named(scene, m),
            style: Style { dash: Dash::None, ..styles[m] },
            points: scene.calibration(m),
            band: Vec::new(),
        })
        .collect();
    let both_axes = || series.iter().flat_map(|s| s.points.iter().flat_map(|p| [p.0, p.1]));
    let axis = Axis::log(both_axes(), Unit::Percent);
    let lines = Lines {
        name: "calibration".into(),
        title: format!("{}: do the error bars hold?", scene.name),
        x: axis.clone(),
        y: axis,
        x_label: "error that the render predicts of itself".into(),
        y_label: "real relative RMS error".into(),
        series,
        guides: vec![Guide::Diagonal { name: "as predicted".into() }],
    };
    both("calibration", |format| lines.draw(format))
}

/// Mean signed error with its interval, one row per method.
pub fn bias(scene: &SceneData) -> Result<Chart, BenchError> {
    let styles = styles(scene);
    let known: Vec<_> = (0..scene.methods.len()).filter_map(|m| Some((m, scene.bias(m)?))).collect();
    // The scale is that of the methods without bias; arrows mark values of the others beyond it.
    let honest = known.iter().filter(|(m, _)| scene.methods[*m].biased.is_none());
    let reach = |all: &mut dyn Iterator<Item = f64>| all.fold(0.0f64, |r, end| r.max(end.abs()));
    let of_honest = reach(&mut honest.flat_map(|(_, i)| [i.low, i.high]));
    let of_all = reach(&mut known.iter().flat_map(|(_, i)| [i.low, i.high]));
    let half = if of_honest > 0.0 { 1.25 * of_honest } else { (1.25 * of_all).max(1e-3) };
    let rows = known.iter().map(|&(m, i)| {
        let content = Content::Interval { style: styles[m], ends: [i.low, i.value, i.high] };
        (named(scene, m), content)
    });
    let chart = Rows {
        name: "bias".into(),
        title: format!("{}: mean error of the whole picture", scene.name),
        x: Axis::linear(-half, half, Unit::Percent),
        x_label: "mean signed error, 95 % interval".into(),
        rows: rows.collect(),
        parts: Vec::new(),
    };
    both("bias", |format| chart.draw(format))
}

/// The stages of the time, one bar per method.
pub fn stages(scene: &SceneData) -> Result<Chart, BenchError> {
    let rows: Vec<(String, Content)> = (0..scene.methods.len())
        .map(|m| (scene.methods[m].name.clone(), Content::Parts(scene.stages(m).to_vec())))
        .collect();
    let longest = (0..scene.methods.len()).map(|m| scene.stages(m).iter().sum::<f64>()).fold(0.0, f64::max);
    let chart = Rows {
        name: "stages".into(),
        title: format!("{}: where the time goes", scene.name),
        x: Axis::linear(0.0, (1.02 * longest).max(1e-3), Unit::Plain),
        x_label: "seconds on the wall, all repeats".into(),
        rows,
        parts: STAGES.map(Into::into).to_vec(),
    };
    both("stages", |format| chart.draw(format))
}

#[cfg(test)]
mod tests;
