//! The measurements of a race, as `data.json` keeps it and `data.csv` lists it.

mod table;

use serde::{Deserialize, Serialize};

pub use self::table::CSV_COLUMNS;
use crate::{conditions::Conditions, method::MethodWords};

/// Number of the layout of `data.json`; another one is refused.
pub const SCHEMA: u32 = 1;

/// A report without its pictures.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Data {
    /// [`SCHEMA`].
    pub schema: u32,
    /// Machine, driver, version, date.
    pub conditions: Conditions,
    /// One entry per scene.
    pub scenes: Vec<SceneData>,
}

/// The clock of a report's seconds.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Clock {
    /// Wall-clock seconds of tracing and adding up.
    #[default]
    Wall,
    /// Seconds of dispatches by the device's timestamps; including the wait for them where it has
    /// none.
    Device,
    /// CPU seconds divided by the number of cores: for software drivers on a shared machine.
    Cpu,
}

/// A scene and the methods that were raced on it.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct SceneData {
    /// Short name, unique in the report; also the name of its folder.
    pub name: String,
    /// The path of the file, as given.
    pub file: String,
    /// Hash of the loaded scene.
    pub hash: String,
    /// Pixels per row.
    pub width: u32,
    /// Rows.
    pub height: u32,
    /// Triangles in the BVH.
    pub triangles: u64,
    /// Repeats of each method, each with independent samples.
    pub repeats: u32,
    /// Seconds per method, all repeats together; `None` where the number of samples was given.
    pub seconds_a_method: Option<f64>,
    /// The clock of the charts.
    pub clock: Clock,
    /// Seconds to read the file.
    pub load_seconds: f64,
    /// The reference of the errors.
    pub reference: ReferenceData,
    /// The methods.
    pub methods: Vec<MethodData>,
    /// The fraction of the device's time that traversal takes; `None` where it was not measured.
    #[serde(default)]
    pub walk: Option<WalkData>,
    /// Checkpoints, in the order of measurement.
    pub rows: Vec<Row>,
    /// Irregularities.
    pub warnings: Vec<String>,
}

/// The reference of the errors.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct ReferenceData {
    /// The method that rendered it, or the file.
    pub source: String,
    /// The reason for this method; empty for a file and in older reports.
    #[serde(default)]
    pub reason: String,
    /// Samples per pixel; 0 where a file does not state them.
    pub spp: u64,
    /// Seconds it took.
    pub seconds: f64,
    /// Mean over pixels and channels, radiance.
    pub mean: f64,
    /// Standard error of that mean; `None` where the file has no variance.
    pub mean_se: Option<f64>,
    /// Its own relative mean square error, which is subtracted from the errors of the methods;
    /// `None` where unknown.
    pub rel_mse: Option<f64>,
    /// Fraction of its pixels whose error bar is not certified.
    pub uncertified: Option<f64>,
}

/// The fraction of a kernel's time that traversal of the BVH takes.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct WalkData {
    /// The method it was measured with.
    pub method: String,
    /// Fraction of the time.
    pub share: f64,
    /// Lower end of its 95 % interval.
    pub low: f64,
    /// Upper end.
    pub high: f64,
}

/// A method and the cost of its setup.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct MethodData {
    /// Short name.
    pub name: String,
    /// Its parts.
    #[serde(flatten)]
    pub words: MethodWords,
    /// The reason for which its expected picture is not the true one; `None` where it is.
    pub biased: Option<String>,
    /// Samples per pixel at each checkpoint.
    pub checkpoints: Vec<u32>,
    /// Seconds to build the BVH, the lights and the textures.
    pub prepare_seconds: f64,
    /// Seconds to compile the kernel and upload the scene.
    pub compile_seconds: f64,
    /// Bytes held on the device.
    pub device_bytes: u64,
}

/// A checkpoint: the picture after a number of samples, compared with the reference.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Row {
    /// Index of the method.
    pub method: usize,
    /// Index of the repeat.
    pub repeat: u32,
    /// Samples per pixel.
    pub spp: u32,
    /// Number of independent batches.
    pub batches: u32,
    /// Rays traced so far.
    pub rays: u64,
    /// Camera paths so far.
    pub paths: u64,
    /// Seconds of dispatches so far, by the device's timestamps where it has them
    /// ([`Conditions::device_clock`]).
    pub device_seconds: f64,
    /// Seconds from the submission of each dispatch to its completion on the host; `None` in older
    /// reports.
    #[serde(default)]
    pub dispatch_seconds: Option<f64>,
    /// Seconds of reading sums back from the device so far; `None` as above.
    #[serde(default)]
    pub read_seconds: Option<f64>,
    /// Seconds of adding these sums to the film so far; `None` as above.
    #[serde(default)]
    pub film_seconds: Option<f64>,
    /// Wall-clock seconds so far, of tracing and adding up.
    pub wall_seconds: f64,
    /// CPU seconds divided by the number of cores so far; `None` where the system does not report
    /// them.
    pub cpu_seconds: Option<f64>,
    /// Mean over pixels and channels, radiance.
    pub mean: f64,
    /// Standard error of that mean; `None` below two batches.
    pub mean_se: Option<f64>,
    /// (mean − reference's) / reference's.
    pub mean_error: f64,
    /// Mean square error in radiance, less the reference's own: negative where noise exceeds the
    /// difference.
    pub mse: f64,
    /// Mean of (x − r)²/(r² + 0.01·r̄²), less the reference's own, too.
    pub rel_mse: f64,
    /// The method's own estimate of the same from its batches; `None` below two.
    pub predicted_rel_mse: Option<f64>,
    /// Fraction of the pixels' channels whose 95 % interval contains the reference; `None` below
    /// two batches.
    pub coverage: Option<f64>,
    /// Fraction of the pixels that the film does not certify; `None` where it was not requested.
    pub uncertified: Option<f64>,
    /// Mean FLIP of the displayed picture, in the first repeat.
    pub flip: Option<f64>,
    /// Samples that were not finite and are excluded.
    pub dropped: u64,
    /// Rays whose traversal ended at its limit; their samples are incomplete.
    pub truncated: u64,
}

impl Row {
    /// Seconds by a clock; the wall clock where CPU seconds are unknown.
    pub fn seconds(&self, clock: Clock) -> f64 {
        match clock {
            Clock::Wall => self.wall_seconds,
            Clock::Device => self.device_seconds,
            Clock::Cpu => self.cpu_seconds.unwrap_or(self.wall_seconds),
        }
    }

    /// √ of the relative mean square error; `None` where that is not above zero.
    pub fn rel_rmse(&self) -> Option<f64> {
        (self.rel_mse > 0.0).then(|| self.rel_mse.sqrt())
    }
}

impl SceneData {
    /// Rows of a method, as measured.
    pub fn rows_of(&self, method: usize) -> impl Iterator<Item = &Row> {
        self.rows.iter().filter(move |row| row.method == method)
    }

    /// Whether a repeat of a method has all its checkpoints.
    pub fn is_complete(&self, method: usize, repeat: u32) -> bool {
        let last = self.methods[method].checkpoints.last();
        self.rows.iter().any(|r| r.method == method && r.repeat == repeat && Some(&r.spp) == last)
    }

    /// Whether every repeat of every method has all its checkpoints.
    pub fn is_all(&self) -> bool {
        (0..self.methods.len()).all(|method| (0..self.repeats).all(|repeat| self.is_complete(method, repeat)))
    }
}

/// A name for file names and anchors.
pub fn slug(name: &str) -> String {
    let mut slug = String::new();
    for c in name.chars() {
        match c {
            'a'..='z' | 'A'..='Z' | '0'..='9' => slug.push(c),
            '.' if !slug.is_empty() => slug.push(c),
            _ if slug.is_empty() || slug.ends_with('-') => {}
            _ => slug.push('-'),
        }
    }
    slug.trim_end_matches(['-', '.']).to_owned()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn fields_with_commas_are_quoted() {
        let mut scene = crate::testing::synthetic(1, &[1.0], 0.0, 0.0);
        scene.name = "a,b \"c\"".into();
        let data = Data { schema: SCHEMA, conditions: Conditions::default(), scenes: vec![scene] };
        let text = String::from_utf8(data.csv().unwrap()).unwrap();
        let lines: Vec<&str> = text.lines().collect();
        assert_eq!(lines[0], CSV_COLUMNS.join(","));
        assert!(lines[1].starts_with("\"a,b \"\"c\"\"\",method0/sobol,method0,,sobol,"), "{}", lines[1]);
    }

    #[test]
    fn slugs_are_file_names() {
        assert_eq!(slug("mis/sobol ≤ 4 bounces"), "mis-sobol-4-bounces");
        assert_eq!(slug("../x y.2"), "x-y.2");
        assert_eq!(slug("///"), "");
    }

    #[test]
    fn errors_below_the_reference_are_no_numbers() {
        let row = Row { rel_mse: -1e-6, ..Row::default() };
        assert_eq!(row.rel_rmse(), None);
        assert_eq!(Row { rel_mse: 4e-4, ..Row::default() }.rel_rmse(), Some(0.02));
    }
}
