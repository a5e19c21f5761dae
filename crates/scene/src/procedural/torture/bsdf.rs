//! Surfaces: cases 27 to 33.

use super::Case;

/// The group's cases.
pub const CASES: &[Case] = &[];
