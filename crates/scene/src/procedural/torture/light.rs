//! Lights: cases 34 to 39.

use super::Case;

/// The group's cases.
pub const CASES: &[Case] = &[];
