//! The measurements, as JSON and as Markdown.

use std::{fmt::Write, panic::AssertUnwindSafe, path::PathBuf, time::Instant};

use serde_json::{Value, json};
use surelight_bench::conditions::Conditions;
use surelight_render::AdapterInfo;

/// Figures by name, in order.
pub(crate) type Row = Vec<(&'static str, Value)>;

/// A row of names and figures.
macro_rules! row {
    ($($name:literal: $value:expr),+ $(,)?) => {
        vec![$(($name, serde_json::json!($value))),+]
    };
}
pub(crate) use row;

struct Step {
    name: String,
    seconds: f64,
    outcome: Result<Vec<Row>, String>,
}

/// All steps so far.
pub(crate) struct Report {
    folder: PathBuf,
    started: Instant,
    about: Value,
    steps: Vec<Step>,
}

impl Report {
    pub(crate) fn new(folder: PathBuf, started: Instant) -> Self {
        Self { folder, started, about: Value::Null, steps: Vec::new() }
    }

    /// Which device is measured.
    pub(crate) fn about(&mut self, info: &AdapterInfo) {
        let conditions = serde_json::to_value(Conditions::now(info, "")).unwrap_or_default();
        self.about = json!({
            "adapter": info.name, "driver": info.driver, "backend": info.backend, "kind": info.kind,
            "max_binding_mib": info.max_binding >> 20, "timestamps": info.timestamps, "conditions": conditions,
        });
    }

    /// Runs a step; panics and errors are recorded.
    pub(crate) fn step(&mut self, name: &str, work: impl FnOnce() -> Result<Vec<Row>, String>) {
        let started = Instant::now();
        let outcome = std::panic::catch_unwind(AssertUnwindSafe(work)).unwrap_or_else(|panic| {
            let text = panic.downcast_ref::<String>().cloned();
            Err(text.or_else(|| panic.downcast_ref::<&str>().map(ToString::to_string)).unwrap_or("a panic".into()))
        });
        let seconds = started.elapsed().as_secs_f64();
        println!("{name}: {}", outcome.as_ref().map_or_else(ToString::to_string, |_| format!("{seconds:.1} s")));
        self.steps.push(Step { name: name.into(), seconds, outcome });
        for (file, text) in [("gpu.json", self.json()), ("gpu.md", self.markdown())] {
            if let Err(e) = std::fs::write(self.folder.join(file), text) {
                eprintln!("{file}: {e}");
            }
        }
    }

    fn json(&self) -> String {
        let steps: Vec<Value> = self
            .steps
            .iter()
            .map(|s| match &s.outcome {
                Ok(rows) => {
                    let object = |row: &Row| row.iter().map(|(n, v)| ((*n).to_owned(), v.clone())).collect::<Value>();
                    let rows: Vec<Value> = rows.iter().map(object).collect();
                    json!({"step": s.name, "seconds": s.seconds, "rows": rows})
                }
                Err(e) => json!({"step": s.name, "seconds": s.seconds, "error": e}),
            })
            .collect();
        let all = json!({"about": self.about, "seconds": self.started.elapsed().as_secs_f64(), "steps": steps});
        serde_json::to_string_pretty(&all).unwrap_or_default()
    }

    fn markdown(&self) -> String {
        let mut out = String::new();
        if let Some(about) = self.about.as_object() {
            for (name, value) in about {
                let _ = writeln!(out, "- {name}: {}", cell(value));
            }
        }
        for step in &self.steps {
            let _ = writeln!(out, "\n## {}\n", step.name);
            match &step.outcome {
                Err(e) => {
                    let _ = writeln!(out, "Failed: {e}");
                }
                Ok(rows) => table(&mut out, rows),
            }
        }
        out
    }
}

fn table(out: &mut String, rows: &[Row]) {
    let Some(first) = rows.first() else { return };
    let names: Vec<&str> = first.iter().map(|(name, _)| *name).collect();
    let _ = writeln!(out, "| {} |\n|{}", names.join(" | "), "---|".repeat(names.len()));
    for row in rows {
        // A row that failed has its scene's name and the error, in place of figures.
        let mut cells: Vec<String> = row.iter().map(|(_, value)| cell(value)).collect();
        cells.resize(names.len().max(cells.len()), String::new());
        let _ = writeln!(out, "| {} |", cells.join(" | "));
    }
}

/// Four digits are more than the precision of these figures.
fn cell(value: &Value) -> String {
    match value {
        Value::String(text) => text.clone(),
        Value::Number(n) if n.is_f64() => {
            let x = n.as_f64().unwrap_or(f64::NAN);
            let digits = (3.0 - x.abs().max(1e-9).log10().floor()).clamp(0.0, 6.0) as usize;
            format!("{x:.digits$}")
        }
        other => other.to_string(),
    }
}
