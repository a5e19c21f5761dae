//! Accumulation, random numbers and drivers: cases 40 to 44.

use super::Case;

/// The group's cases.
pub const CASES: &[Case] = &[];
