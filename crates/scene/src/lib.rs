//! A glTF or HDR file in, a validated [`Scene`] out: plain data, no GPU.
//!
//! This is the only crate that reads glTF. Everything downstream (BVH, lights, kernels) reads
//! [`Scene`] and can rely on the invariants of its types: indices in range, finite numbers where
//! stated, textures decoded.
//!
//! ```
//! use std::path::Path;
//! use surelight_scene::{LoadOptions, load};
//!
//! let scene = load(Path::new("../../assets/cornell-box.glb"), &LoadOptions::default())?;
//! assert_eq!(scene.triangle_count(), 38);
//! assert!(scene.warnings.is_empty());
//! # Ok::<(), surelight_scene::LoadError>(())
//! ```

mod camera;
mod environment;
mod framing;
mod import;
mod kind;
mod layers;
mod light;
mod material;
mod mesh;
mod scene;
mod texture;
mod validate;

pub use camera::{Camera, ClipRange, Projection};
pub use environment::{Environment, EnvironmentMap, load_environment, load_environment_with_warnings};
pub use import::{LoadError, LoadOptions, Moment, load, load_bytes};
pub use layers::{Anisotropy, Clearcoat, DiffuseTransmission, Iridescence, Sheen};
pub use light::{Light, LightKind};
pub use material::{AlphaMode, Material, Volume};
pub use mesh::{Instance, Mesh};
pub use scene::{ExtensionUse, Scene};
pub use texture::{Filter, Image, NormalTexture, Texture, TextureRef, Wrap};
pub use validate::SceneError;
