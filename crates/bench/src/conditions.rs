//! The conditions of a measurement: without them a speed has no meaning.

use std::time::{SystemTime, UNIX_EPOCH};

use serde::{Deserialize, Serialize};
use surelight_render::AdapterInfo;

/// Machine, driver, version, date.
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct Conditions {
    /// Version of Surelight.
    pub version: String,
    /// Commit of the build, with `+` where files had changed; empty where unknown.
    pub commit: String,
    /// Date and time, UTC.
    pub date: String,
    /// Device.
    pub device: String,
    /// Its driver.
    pub driver: String,
    /// `Vulkan`, `Metal` or `Dx12`.
    pub backend: String,
    /// Whether the device is a software driver.
    pub software: bool,
    /// Source of device seconds: `timestamp queries`, or `waiting for dispatches` where the device
    /// has none; empty in older reports.
    #[serde(default)]
    pub device_clock: String,
    /// Processor.
    pub cpu: String,
    /// Threads of the processor that this program may use.
    pub threads: usize,
    /// Operating system and architecture.
    pub system: String,
    /// Load average of the last minute before the start; empty where unknown.
    pub load: String,
    /// The user's note on the conditions.
    pub note: String,
}

impl Conditions {
    /// The conditions now, on this device.
    pub fn now(device: &AdapterInfo, note: &str) -> Self {
        let load = std::fs::read_to_string("/proc/loadavg").unwrap_or_default();
        Self {
            version: env!("CARGO_PKG_VERSION").into(),
            commit: env!("SURELIGHT_COMMIT").into(),
            date: date(SystemTime::now().duration_since(UNIX_EPOCH).map_or(0, |d| d.as_secs())),
            device: device.name.clone(),
            driver: device.driver.clone(),
            backend: device.backend.clone(),
            software: device.is_cpu,
            device_clock: if device.timestamps { "timestamp queries" } else { "waiting for dispatches" }.into(),
            cpu: cpu().unwrap_or_else(|| "unknown processor".into()),
            threads: threads(),
            system: format!("{} {}", std::env::consts::OS, std::env::consts::ARCH),
            load: load.split_whitespace().next().unwrap_or_default().into(),
            note: note.into(),
        }
    }
}

/// Threads that run at once.
pub fn threads() -> usize {
    std::thread::available_parallelism().map_or(1, std::num::NonZero::get)
}

fn cpu() -> Option<String> {
    if let Ok(text) = std::fs::read_to_string("/proc/cpuinfo") {
        let line = text.lines().find(|line| line.starts_with("model name") || line.starts_with("Model"))?;
        return Some(line.split_once(':')?.1.trim().to_owned());
    }
    std::env::var("PROCESSOR_IDENTIFIER").ok()
}

/// `2026-01-31 23:59 UTC` from seconds since 1970 (Hinnant, "chrono-compatible low-level date
/// algorithms", civil_from_days).
fn date(seconds: u64) -> String {
    let (days, rest) = (seconds / 86_400, seconds % 86_400);
    let z = days + 719_468;
    let (era, day_of_era) = (z / 146_097, z % 146_097);
    let year_of_era = (day_of_era - day_of_era / 1_460 + day_of_era / 36_524 - day_of_era / 146_096) / 365;
    let day_of_year = day_of_era - (365 * year_of_era + year_of_era / 4 - year_of_era / 100);
    let shifted_month = (5 * day_of_year + 2) / 153;
    let day = day_of_year - (153 * shifted_month + 2) / 5 + 1;
    let month = if shifted_month < 10 { shifted_month + 3 } else { shifted_month - 9 };
    let year = year_of_era + era * 400 + u64::from(month <= 2);
    format!("{year}-{month:02}-{day:02} {:02}:{:02} UTC", rest / 3600, rest / 60 % 60)
}

/// CPU seconds of this process so far, summed over its live threads; `None` where the system does
/// not report them.
pub fn cpu_seconds() -> Option<f64> {
    threads_nanoseconds().map(|n| n as f64 * 1e-9).or_else(process_seconds)
}

/// To the nanosecond, where Linux keeps scheduler statistics: the first field of each thread's
/// schedstat.
fn threads_nanoseconds() -> Option<u64> {
    let mut sum = 0u64;
    for task in std::fs::read_dir("/proc/self/task").ok()? {
        // A thread may end while the files are read.
        let Ok(text) = std::fs::read_to_string(task.ok()?.path().join("schedstat")) else { continue };
        sum += text.split_whitespace().next()?.parse::<u64>().ok()?;
    }
    (sum > 0).then_some(sum)
}

/// To a hundredth of a second, on every Linux.
fn process_seconds() -> Option<f64> {
    // Fields 14 and 15 of proc(5)'s stat: user and system time in ticks, 100 per second on every
    // Linux that Rust runs on. The program's name, which may hold spaces, ends with the last
    // parenthesis.
    let text = std::fs::read_to_string("/proc/self/stat").ok()?;
    let mut fields = text.rsplit_once(')')?.1.split_whitespace().skip(11);
    let user: f64 = fields.next()?.parse().ok()?;
    let system: f64 = fields.next()?.parse().ok()?;
    Some((user + system) / 100.0)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn dates_are_those_of_the_calendar() {
        for (seconds, text) in [
            (0, "1970-01-01 00:00 UTC"),
            (951_782_399, "2000-02-28 23:59 UTC"),
            (951_782_400, "2000-02-29 00:00 UTC"),
            (1_798_761_600, "2027-01-01 00:00 UTC"),
        ] {
            assert_eq!(date(seconds), text);
        }
    }

    #[test]
    #[cfg(target_os = "linux")]
    fn work_takes_processor_time() {
        let takes = || {
            let before = (cpu_seconds().unwrap(), process_seconds().unwrap());
            let start = std::time::Instant::now();
            while start.elapsed().as_millis() < 200 {}
            (cpu_seconds().unwrap() - before.0, process_seconds().unwrap() - before.1)
        };
        // Threads of other tests end meanwhile; their seconds are no longer included.
        let taken: Vec<_> = (0..20).map(|_| takes()).collect();
        assert!(taken.iter().any(|t| t.0 >= 0.01), "{taken:?}");
        assert!(taken.iter().any(|t| t.1 >= 0.01), "{taken:?}");
    }
}
