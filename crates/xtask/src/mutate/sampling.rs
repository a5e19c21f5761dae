//! Mutations for the group `sampling`.

use super::Mutation;

pub(super) const ROWS: &[Mutation] = &[];
