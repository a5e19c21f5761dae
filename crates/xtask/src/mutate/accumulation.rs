//! Mutations for the group `accumulation`.

use super::Mutation;

pub(super) const ROWS: &[Mutation] = &[];
