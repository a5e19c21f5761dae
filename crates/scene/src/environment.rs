mod load;
mod openexr;
mod radiance;

use std::sync::Arc;

pub use load::{load_environment, load_environment_with_warnings};

/// Light from infinitely far away.
#[derive(Clone, Debug, PartialEq)]
pub enum Environment {
    /// The same radiance from every direction, linear Rec. 709, nit.
    Uniform([f32; 3]),
    /// An equirectangular map.
    Map {
        /// Its texels.
        map: Arc<EnvironmentMap>,
        /// Turns the map about +Y, radians, counter-clockwise seen from above.
        rotation: f32,
        /// Factor on every texel.
        scale: f32,
    },
}

/// An equirectangular (latitude–longitude) radiance map, row 0 at the zenith.
///
/// A direction (x, y, z) in glTF space is found at u = ½ + atan2(z, x)/2π, v = ½ − asin(y)/π. Every
/// texel is finite and non-negative: the loader ensures it.
#[derive(Clone, Debug, PartialEq)]
pub struct EnvironmentMap {
    /// Texels in a row.
    pub width: u32,
    /// Rows.
    pub height: u32,
    /// Linear Rec. 709 radiance, `width * height` texels, row by row.
    pub texels: Vec<[f32; 3]>,
}
