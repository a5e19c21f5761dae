//! Axes with ticks at round numbers.

use std::ops::Range;

use plotters::coord::ranged1d::{KeyPointHint, NoDefaultFormatting, Ranged, ValueFormatter};

/// The quantity on an axis.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Unit {
    /// Plain numbers.
    Plain,
    /// Fractions, shown in percent.
    Percent,
}

/// An axis, logarithmic or not.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Axis {
    pub(super) low: f64,
    pub(super) high: f64,
    pub(super) log: bool,
    pub(super) unit: Unit,
}

impl Axis {
    /// A logarithmic axis around some values above zero, with a little room.
    pub(super) fn log(values: impl Iterator<Item = f64>, unit: Unit) -> Self {
        let usable = values.filter(|v| *v > 0.0 && v.is_finite());
        let (low, high) = usable.fold((f64::MAX, 0.0f64), |(l, h), v| (l.min(v), h.max(v)));
        let (low, high) = if low > high { (0.1, 1.0) } else { (low, high) };
        // At least a factor of ten: a smaller range suggests a difference where there is none.
        let lack = (10.0 * low / high).max(1.0).sqrt();
        Self { low: low / lack / 1.15, high: high * lack * 1.15, log: true, unit }
    }

    /// A linear axis.
    pub(super) fn linear(low: f64, high: f64, unit: Unit) -> Self {
        Self { low, high, log: false, unit }
    }

    /// The position of a value on the axis, 0 to 1.
    pub(super) fn at(&self, value: f64) -> f64 {
        if self.log {
            (value / self.low).ln() / (self.high / self.low).ln()
        } else {
            (value - self.low) / (self.high - self.low)
        }
    }

    /// Values with labels, at most about `most`.
    pub(super) fn ticks(&self, most: usize) -> Vec<f64> {
        if !self.log {
            return self.linear_ticks(most);
        }
        let (first, last) = (self.low.log10().floor() as i32, self.high.log10().ceil() as i32);
        let inside = |v: &f64| (self.low..=self.high).contains(v);
        let of = |digits: &[f64]| -> Vec<f64> {
            (first..=last).flat_map(|k| digits.iter().map(move |d| d * 10f64.powi(k))).filter(inside).collect()
        };
        for digits in [&[1.0, 2.0, 5.0][..], &[1.0, 3.0], &[1.0]] {
            let ticks = of(digits);
            if ticks.len() <= most {
                return ticks;
            }
        }
        let decades = of(&[1.0]);
        decades.iter().copied().step_by(decades.len().div_ceil(most.max(1))).collect()
    }

    fn linear_ticks(&self, most: usize) -> Vec<f64> {
        let rough = (self.high - self.low) / most.max(1) as f64;
        let decade = 10f64.powf(rough.log10().floor());
        let step = [1.0, 2.0, 5.0, 10.0].map(|d| d * decade).into_iter().find(|&s| s >= rough * 0.999).unwrap_or(rough);
        let (first, last) = ((self.low / step - 1e-9).ceil() as i64, (self.high / step + 1e-9).floor() as i64);
        (first..=last).map(|k| k as f64 * step).collect()
    }

    /// All multiples 1 to 9 of all decades, for light lines.
    fn fine(&self) -> Vec<f64> {
        if !self.log {
            return Vec::new();
        }
        let (first, last) = (self.low.log10().floor() as i32, self.high.log10().ceil() as i32);
        let all = (first..=last).flat_map(|k| (1..10).map(move |d| f64::from(d) * 10f64.powi(k)));
        all.filter(|v| (self.low..=self.high).contains(v)).collect()
    }

    /// The label of a tick.
    pub(super) fn label(&self, value: f64) -> String {
        match self.unit {
            Unit::Plain => plain(value),
            Unit::Percent => format!("{} %", plain(100.0 * value)),
        }
    }
}

/// The number at a tick, without insignificant digits.
fn plain(value: f64) -> String {
    if value == 0.0 {
        return "0".into();
    }
    let size = value.abs();
    if size >= 9999.5 {
        return if size < 999_999.5 { format!("{:.0}k", value / 1e3) } else { format!("{}M", plain(value / 1e6)) };
    }
    if size < 0.99e-4 {
        return format!("{value:.0e}");
    }
    let decimals = (2.0 - size.log10().floor()).clamp(0.0, 6.0) as usize;
    let text = format!("{value:.decimals$}");
    let text = if text.contains('.') { text.trim_end_matches('0').trim_end_matches('.') } else { &text };
    text.replace('-', "−")
}

impl Ranged for Axis {
    type FormatOption = NoDefaultFormatting;
    type ValueType = f64;

    fn map(&self, value: &f64, limit: (i32, i32)) -> i32 {
        limit.0 + (f64::from(limit.1 - limit.0) * self.at(*value)).round() as i32
    }

    fn key_points<Hint: KeyPointHint>(&self, hint: Hint) -> Vec<f64> {
        if hint.weight().allow_light_points() { self.fine() } else { self.ticks(hint.bold_points()) }
    }

    fn range(&self) -> Range<f64> {
        self.low..self.high
    }
}

impl ValueFormatter<f64> for Axis {
    fn format_ext(&self, value: &f64) -> String {
        self.label(*value)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn labels(axis: &Axis, most: usize) -> Vec<String> {
        axis.ticks(most).into_iter().map(|t| axis.label(t)).collect()
    }

    #[test]
    fn ticks_are_round_and_few() {
        let errors = Axis::log([0.004, 0.9].into_iter(), Unit::Percent);
        assert_eq!(labels(&errors, 8), ["0.5 %", "1 %", "2 %", "5 %", "10 %", "20 %", "50 %", "100 %"]);
        assert_eq!(labels(&errors, 4), ["1 %", "10 %", "100 %"]);
        let wide = Axis::log([1e-6, 1e6].into_iter(), Unit::Plain);
        assert!(wide.ticks(5).len() <= 5);
        assert_eq!(labels(&Axis::linear(-0.05, 0.05, Unit::Percent), 5), ["−4 %", "−2 %", "0 %", "2 %", "4 %"]);
        assert_eq!(labels(&Axis::linear(0.0, 7.3, Unit::Plain), 5), ["0", "2", "4", "6"]);
    }

    #[test]
    fn nothing_and_one_value_make_an_axis() {
        for axis in [Axis::log([].into_iter(), Unit::Plain), Axis::log([3.0].into_iter(), Unit::Plain)] {
            assert!(axis.low > 0.0 && axis.high / axis.low >= 10.0 && !axis.ticks(6).is_empty());
        }
    }

    #[test]
    fn numbers_read_well() {
        let numbers = [0.0, 0.012, 12.0, 0.1, 20_000.0, 5e6, -0.5, 1e-7];
        let texts = ["0", "0.012", "12", "0.1", "20k", "5M", "−0.5", "1e-7"];
        for (number, text) in numbers.into_iter().zip(texts) {
            assert_eq!(plain(number), text);
        }
    }
}
