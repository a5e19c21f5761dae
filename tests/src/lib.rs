//! Shared helpers of the device tests.

pub mod bsdf;
pub mod bsdf_oracle;
pub mod probe;
pub mod sphere;
