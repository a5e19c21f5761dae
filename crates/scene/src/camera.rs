use glam::DAffine3;

/// A camera of the file, or one made to frame the scene.
#[derive(Clone, Debug, PartialEq)]
pub struct Camera {
    /// Name of the node or camera; empty when the file gives none.
    pub name: String,
    /// Camera to world: orthonormal (node scale is taken out). The view direction is −Z, +Y is up.
    pub to_world: DAffine3,
    /// How directions spread.
    pub projection: Projection,
    /// The depths that it shows.
    pub clip: ClipRange,
}

/// The near and the far plane of a camera: surfaces nearer than the one or farther than the other
/// are clipped.
///
/// Depths are metres along the camera's view direction, so that both planes are parallel to the
/// image.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ClipRange {
    /// Depth of the near plane; 0 clips nothing.
    pub near: f64,
    /// Depth of the far plane; infinity clips nothing.
    pub far: f64,
}

impl ClipRange {
    /// Clips nothing.
    pub const NONE: Self = Self { near: 0.0, far: f64::INFINITY };

    /// Depths beyond this do not fit the renderer's f32 arithmetic.
    const MAX_DEPTH: f64 = 1e30;

    /// A range from these depths; `None` unless 0 ≤ near < far, with a near plane that f32 can
    /// hold.
    pub fn new(near: f64, far: f64) -> Option<Self> {
        (near >= 0.0 && near < far && near < Self::MAX_DEPTH).then_some(Self { near, far })
    }
}

impl Default for ClipRange {
    fn default() -> Self {
        Self::NONE
    }
}

/// How a camera maps the image plane to rays.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Projection {
    /// Pinhole (or thin lens, when the renderer is given an aperture).
    Perspective {
        /// Full vertical field of view, radians.
        yfov: f64,
        /// Width over height stated by the file, if any.
        aspect: Option<f64>,
    },
    /// Parallel rays.
    Orthographic {
        /// Half the width of the view, metres.
        xmag: f64,
        /// Half the height of the view, metres.
        ymag: f64,
    },
}

impl Camera {
    /// Width over height, where the file states one.
    pub fn aspect(&self) -> Option<f64> {
        match self.projection {
            Projection::Perspective { aspect, .. } => aspect,
            Projection::Orthographic { xmag, ymag } => Some((xmag / ymag).abs()),
        }
    }
}
