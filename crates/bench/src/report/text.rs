//! Numbers as text.

use crate::analysis::Interval;

/// A number with two significant digits.
pub(super) fn short(x: f64) -> String {
    if x == 0.0 || !x.is_finite() {
        return if x == 0.0 { "0".into() } else { "–".into() };
    }
    // Rounded first: 0.9997 is 1.0, and not 1.00.
    let x: f64 = format!("{x:.1e}").parse().unwrap_or(x);
    if x.abs() >= 1e6 || x.abs() < 1e-5 {
        return format!("{x:.1e}").replace('-', "−");
    }
    let decimals = (1.0 - x.abs().log10().floor()).clamp(0.0, 7.0) as usize;
    format!("{x:.decimals$}").replace('-', "−")
}

/// A fraction in percent.
pub(super) fn percent(x: f64) -> String {
    format!("{} %", short(100.0 * x))
}

/// An error level, which is a round number.
pub(super) fn level(x: f64) -> String {
    let text = format!("{:.4}", 100.0 * x);
    format!("{} %", text.trim_end_matches('0').trim_end_matches('.'))
}

/// Seconds.
pub(super) fn seconds(x: f64) -> String {
    if x >= 120.0 { format!("{:.1} min", x / 60.0) } else { format!("{} s", short(x)) }
}

/// "4.2 × (3.9 to 4.6)"; near 1, where a few percent matter, with two decimals.
pub(crate) fn factor(interval: &Interval) -> String {
    let one = |x: f64| if (0.5..2.0).contains(&x) { format!("{x:.2}") } else { short(x) };
    if interval.low > 0.0 && interval.high.is_finite() && interval.high / interval.low < 1e6 {
        format!("{} × ({} to {})", one(interval.value), one(interval.low), one(interval.high))
    } else {
        format!("{} ×", one(interval.value))
    }
}

/// "−0.51 ± 0.02".
pub(super) fn plus_minus(interval: &Interval) -> String {
    let half = (interval.high - interval.low) / 2.0;
    if !half.is_finite() {
        return format!("{:.3}", interval.value).replace('-', "−");
    }
    let decimals = (1.0 - half.max(1e-6).log10().floor()).clamp(1.0, 4.0) as usize;
    format!("{:.decimals$} ± {half:.decimals$}", interval.value).replace('-', "−")
}

/// Bytes.
pub(super) fn bytes(n: u64) -> String {
    match n {
        0..1_048_576 => format!("{} KiB", short(n as f64 / 1024.0)),
        1_048_576..1_073_741_824 => format!("{} MiB", short(n as f64 / 1_048_576.0)),
        _ => format!("{} GiB", short(n as f64 / 1_073_741_824.0)),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_read_well() {
        assert_eq!((percent(0.0213), level(0.02), level(0.005)), ("2.1 %".into(), "2 %".into(), "0.5 %".into()));
        assert_eq!(
            (seconds(3.12), seconds(0.0123), seconds(300.0)),
            ("3.1 s".into(), "0.012 s".into(), "5.0 min".into())
        );
        assert_eq!(factor(&Interval { value: 4.2, low: 3.9, high: 4.6 }), "4.2 × (3.9 to 4.6)");
        assert_eq!(factor(&Interval { value: 1.12, low: 0.9, high: 3.0 }), "1.12 × (0.90 to 3.0)");
        assert_eq!(plus_minus(&Interval { value: -0.512, low: -0.54, high: -0.484 }), "−0.512 ± 0.028");
        assert_eq!(
            (short(1234.5), short(0.0), short(0.9997), bytes(3 << 20)),
            ("1200".into(), "0".into(), "1.0".into(), "3.0 MiB".into())
        );
    }
}
