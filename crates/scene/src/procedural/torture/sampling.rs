//! Sampling: cases 20 to 26.

use super::Case;

/// The group's cases.
pub const CASES: &[Case] = &[];
