use glam::DAffine3;

/// A camera of the file, or one made to frame the scene.
#[derive(Clone, Debug, PartialEq)]
pub struct Camera {
    /// Name of the node or camera; empty when the file gives none.
    pub name: String,
    /// Camera to world: orthonormal (node scale is taken out). The camera looks along its −Z, +Y is up.
    pub to_world: DAffine3,
    /// How directions spread.
    pub projection: Projection,
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
    /// Width over height that the file asks for, if it does.
    pub fn aspect(&self) -> Option<f64> {
        match self.projection {
            Projection::Perspective { aspect, .. } => aspect,
            Projection::Orthographic { xmag, ymag } => Some((xmag / ymag).abs()),
        }
    }
}
