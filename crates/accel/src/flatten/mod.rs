//! From trees to the items that a kernel reads.

pub(crate) mod binary;
