//! Writes a report: the page, the charts, the data.

mod answer;
mod page;
mod pictures;
mod style;
mod tables;
pub(crate) mod text;

use std::path::Path;

use surelight_film::write_file;

use crate::{
    chart::{self, Chart, png},
    data::{Data, SCHEMA, SceneData},
    error::BenchError,
    overlay::Peer,
};

pub use answer::answer;

/// Writes `data.json` alone: an interrupted race is resumed from it.
pub fn write_data(folder: &Path, data: &Data) -> Result<(), BenchError> {
    let path = folder.join("data.json");
    let text = serde_json::to_string_pretty(data).map_err(|e| BenchError::file(&path, e))?;
    Ok(write_file(&path, text.as_bytes())?)
}

/// Reads `data.json`.
pub fn read_data(path: &Path) -> Result<Data, BenchError> {
    let text = std::fs::read_to_string(path)
        .map_err(|e| BenchError::file(path, format!("cannot be read: {}", surelight_film::io_cause(&e))))?;
    let wrong = |cause: String| BenchError::file(path, cause);
    let any: serde_json::Value = serde_json::from_str(&text).map_err(|e| wrong(format!("is not JSON: {e}")))?;
    let schema = any.get("schema").and_then(serde_json::Value::as_u64);
    if schema != Some(SCHEMA.into()) {
        let found = schema.map_or("no schema number".to_owned(), |n| format!("schema {n}"));
        return Err(wrong(format!("is not a report of this version: it has {found} instead of schema {SCHEMA}")));
    }
    let data: Data = serde_json::from_value(any).map_err(|e| wrong(format!("is not a report: {e}")))?;
    let fits = |scene: &SceneData| scene.rows.iter().all(|row| row.method < scene.methods.len());
    if !data.scenes.iter().all(fits) {
        return Err(wrong("is damaged: it has rows of methods that it does not list".into()));
    }
    Ok(data)
}

/// The charts of a scene.
fn charts(scene: &SceneData, peers: &[Peer]) -> Result<Vec<Chart>, BenchError> {
    Ok(vec![
        chart::convergence(scene, peers, false)?,
        chart::convergence(scene, peers, true)?,
        chart::front(scene, peers)?,
        chart::calibration(scene)?,
        chart::bias(scene)?,
        chart::stages(scene)?,
    ])
}

/// Writes everything: page, charts as SVG and PNG, `data.csv`, `data.json`. Other renderers' points
/// are drawn on the charts of their scenes.
pub fn write_report(folder: &Path, data: &Data, peers: &[Peer]) -> Result<(), BenchError> {
    write_data(folder, data)?;
    let table = folder.join("data.csv");
    write_file(&table, &data.csv().map_err(|e| BenchError::file(&table, e))?)?;
    let mut scenes = Vec::new();
    for scene in &data.scenes {
        let charts = charts(scene, peers)?;
        let place = folder.join(&scene.name);
        std::fs::create_dir_all(&place)
            .map_err(|e| BenchError::file(&place, format!("cannot be made: {}", surelight_film::io_cause(&e))))?;
        for chart in &charts {
            write_file(&place.join(format!("{}.svg", chart.name)), chart.wide.as_bytes())?;
            write_file(&place.join(format!("{}.png", chart.name)), &png(chart.name, &chart.wide)?)?;
        }
        scenes.push((scene, charts));
    }
    let page = page::page(folder, data, &scenes);
    Ok(write_file(&folder.join("index.html"), page.as_bytes())?)
}
