//! Mutations for the group `bsdf`.

use super::Mutation;

pub(super) const ROWS: &[Mutation] = &[];
