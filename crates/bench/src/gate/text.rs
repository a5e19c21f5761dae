//! A comparison in words.

use super::Comparison;
use crate::report::text::factor;

impl std::fmt::Display for Comparison {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        for change in &self.methods {
            let error = change.error.map_or("–".into(), |e| factor(&e));
            writeln!(
                f,
                "{} {} at {} samples: time {}, mean square error {error}",
                change.scene,
                change.method,
                change.spp,
                factor(&change.time)
            )?;
            for loss in &change.losses {
                writeln!(f, "  LOSS {loss}")?;
            }
        }
        for note in &self.notes {
            writeln!(f, "note: {note}")?;
        }
        let verdict =
            if self.is_loss() { "the new version has losses" } else { "no loss beyond the tolerance and chance" };
        writeln!(f, "verdict: {verdict}")
    }
}
