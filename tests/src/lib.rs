//! Shared helpers of the device tests.

pub mod bsdf;
pub mod bsdf_oracle;
pub mod chi2;
pub mod differential;
pub mod forget;
pub mod kernel_keys;
pub mod layer_oracle;
pub mod light;
pub mod path_oracle;
pub mod probe;
pub mod random;
pub mod render;
pub mod respawn;
pub mod sampler;
pub mod scenes;
pub mod seeds;
pub mod sphere;
pub mod traversal;
pub mod welch;
