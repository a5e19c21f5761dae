use glam::DVec3;

/// A light of KHR_lights_punctual: no extent, so only light sampling can find it.
#[derive(Clone, Debug, PartialEq)]
pub struct Light {
    /// Name of the light; empty when the file gives none.
    pub name: String,
    /// Its kind.
    pub kind: LightKind,
    /// Colour × intensity: candela for point and spot, lux for directional, linear Rec. 709.
    pub intensity: [f32; 3],
}

/// Shape of a punctual light, in world space.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum LightKind {
    /// Shines equally in all directions.
    Point {
        /// Where, metres.
        position: DVec3,
    },
    /// Shines into a cone, with the falloff that the extension recommends between the two angles.
    Spot {
        /// Where, metres.
        position: DVec3,
        /// Unit axis of the cone, away from the light.
        direction: DVec3,
        /// Half angle of full intensity, radians.
        inner: f32,
        /// Half angle where intensity reaches 0, radians; `inner < outer ≤ π/2`.
        outer: f32,
    },
    /// Parallel light.
    Directional {
        /// Unit direction in which the light travels.
        direction: DVec3,
    },
}
