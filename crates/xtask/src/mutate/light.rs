//! Mutations for the group `light`.

use super::Mutation;

pub(super) const ROWS: &[Mutation] = &[];
