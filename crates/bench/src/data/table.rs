//! The rows of a race as a table, `data.csv`.

use super::Data;

/// Columns of `data.csv`.
pub const CSV_COLUMNS: [&str; 33] = [
    "scene",
    "method",
    "integrator",
    "directions",
    "sampler",
    "scrambles",
    "shared_paths",
    "max_bounces",
    "max_radiance",
    "biased",
    "repeat",
    "spp",
    "batches",
    "rays",
    "paths",
    "device_s",
    "dispatch_s",
    "read_s",
    "film_s",
    "wall_s",
    "cpu_s",
    "mean",
    "mean_se",
    "mean_error",
    "rmse",
    "rel_mse",
    "rel_rmse",
    "predicted_rel_rmse",
    "coverage_95",
    "uncertified",
    "flip",
    "dropped",
    "truncated",
];

impl Data {
    /// All rows as CSV, one line per checkpoint; an unknown figure is an empty field.
    ///
    /// # Errors
    /// Never in practice: rows of equal length are written to memory.
    pub fn csv(&self) -> Result<Vec<u8>, csv::Error> {
        let mut csv = csv::Writer::from_writer(Vec::new());
        csv.write_record(CSV_COLUMNS)?;
        for scene in &self.scenes {
            for row in &scene.rows {
                let method = &scene.methods[row.method];
                let words = &method.words;
                let number = |x: f64| format!("{x:.6e}");
                let maybe = |x: Option<f64>| x.map_or(String::new(), number);
                let fields: [String; CSV_COLUMNS.len()] = [
                    scene.name.clone(),
                    method.name.clone(),
                    words.integrator.clone(),
                    words.directions.clone().unwrap_or_default(),
                    words.sampler.clone(),
                    words.scrambles.clone(),
                    words.shared_paths.clone(),
                    words.max_bounces.clone(),
                    words.max_radiance.clone(),
                    u8::from(method.biased.is_some()).to_string(),
                    row.repeat.to_string(),
                    row.spp.to_string(),
                    row.batches.to_string(),
                    row.rays.to_string(),
                    row.paths.to_string(),
                    number(row.device_seconds),
                    maybe(row.dispatch_seconds),
                    maybe(row.read_seconds),
                    maybe(row.film_seconds),
                    number(row.wall_seconds),
                    maybe(row.cpu_seconds),
                    number(row.mean),
                    maybe(row.mean_se),
                    number(row.mean_error),
                    maybe((row.mse > 0.0).then(|| row.mse.sqrt())),
                    number(row.rel_mse),
                    maybe(row.rel_rmse()),
                    maybe(row.predicted_rel_mse.map(f64::sqrt)),
                    maybe(row.coverage),
                    maybe(row.uncertified),
                    maybe(row.flip),
                    row.dropped.to_string(),
                    row.truncated.to_string(),
                ];
                csv.write_record(fields)?;
            }
        }
        csv.into_inner().map_err(|error| error.into_error().into())
    }
}
