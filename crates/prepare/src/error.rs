//! Errors of preparing a scene.

use surelight_accel::AccelError;
use surelight_scene::SceneError;

use crate::kernel_key::KeyError;

/// An error of a compiler.
pub type Source = Box<dyn std::error::Error + Send + Sync>;

/// An error of this crate.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum PrepareError {
    /// The scene is not valid.
    #[error(transparent)]
    Scene(#[from] SceneError),
    /// The scene could not be made into a BVH.
    #[error(transparent)]
    Accel(#[from] AccelError),
    /// Parts of a kernel that exclude one another: a defect of this crate, or a blueprint of a
    /// caller.
    #[error("the kernel cannot be made: {0}")]
    Kernel(#[from] KeyError),
    /// A shader did not compose or validate: a defect of this program.
    #[error("Surelight has a defect, please report it: the shader {root} does not compile: {message}")]
    Shader {
        /// Root module.
        root: String,
        /// The compiler's message, with the lines of the source where there are some.
        message: String,
        /// The compiler's error; none where a resource is missing.
        source: Option<Source>,
    },
}
