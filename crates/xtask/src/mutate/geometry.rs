//! Mutations for the group `geometry`.

use super::Mutation;

pub(super) const ROWS: &[Mutation] = &[];
