//! From a scene to plain bytes: the inputs of a device, made without one.
//!
//! [`Prepared`] takes a [`surelight_scene::Scene`], a camera and [`Settings`], and holds the BVH,
//! lights, textures and records as arrays by the names that the shaders bind
//! ([`Prepared::arrays`]), and the [`KernelKey`]: the parts of the kernel. [`compose`] makes WGSL
//! of a key. Any host that can run WGSL needs exactly this; `surelight-render` is the one that uses
//! wgpu.
//!
//! ```
//! use surelight_prepare::{KernelKey, Part};
//!
//! let key = KernelKey::from_names(&["clearcoat", "punctual_lights"])?;
//! assert!(key.has(Part::Ggx) && key.has(Part::LightSampling));
//! # Ok::<(), surelight_prepare::KeyError>(())
//! ```

mod alias;
mod attributes;
mod batches;
mod blueprint;
mod casters;
mod caustics;
mod choice;
mod clip;
mod compose;
mod emitters;
mod environment;
mod error;
mod instances;
mod interreflection;
mod kernel_key;
mod light_flow;
mod light_tree;
mod lights;
mod lobes;
mod lowering;
mod luminance;
mod materials;
mod media;
mod microfacets;
mod needs;
mod octahedral;
mod parallelograms;
mod prepared;
mod records;
mod reflect;
mod settings;
pub mod shared;
mod sheen;
mod slots;
mod surface;
pub mod syntax;
mod textures;
mod unreachable;
mod view;

pub use batches::Batches;
pub use blueprint::Blueprint;
pub use choice::may_have_caustics;
pub use clip::ActiveClipPlanes;
pub use compose::{Composed, Constant, compose, compose_modules, compose_with, path_kernel, shader_modules};
pub use error::{PrepareError, Source};
pub use kernel_key::{
    CameraModel, EnvironmentKind, Estimator, KernelKey, KeyError, Origin, Part, Parts, PointSet, Row, TABLE,
};
pub use lowering::images::IMAGE_WIDTH;
pub use luminance::luminance;
pub use materials::material_fields;
pub use prepared::{Instrument, Prepared};
pub use records::{LightTracing, SceneArray};
pub use reflect::{Access, Binding, RecordLayout, bindings};
pub use settings::{Directions, Integrator, PathReuse, Sampler, Settings};
pub use shared::{View, host_layouts};
pub use sheen::sheen_albedos;
pub use unreachable::Unreachable;
