//! The camera and everything else that is constant over a render, as the kernel reads it.

use glam::{DVec3, Vec3};
use surelight_scene::{Camera, Projection};

use super::Settings;
use crate::shared::View;

impl View {
    /// Camera and limits; light fields are left for the lights to fill in. `origin`: where the
    /// scene's origin was moved to.
    pub(crate) fn new(camera: &Camera, settings: &Settings, origin: DVec3) -> Self {
        let axes = camera.to_world.matrix3;
        let aspect = f64::from(settings.width) / f64::from(settings.height);
        let (half_width, half_height) = match camera.projection {
            Projection::Perspective { yfov, .. } => {
                let t = (0.5 * yfov).tan();
                (t * aspect, t)
            }
            Projection::Orthographic { ymag, .. } => (ymag * aspect, ymag),
        };
        let vec = |v: DVec3| -> [f32; 3] { v.as_vec3().to_array() };
        Self {
            origin: vec(camera.to_world.translation - origin),
            lens_radius: settings.aperture.map_or(0.0, |diameter| 0.5 * diameter),
            right: vec(axes.x_axis * half_width),
            focus: settings.focus.unwrap_or(1.0),
            up: vec(axes.y_axis * half_height),
            seed: settings.seed,
            forward: Vec3::normalize(-axes.z_axis.as_vec3()).to_array(),
            max_bounces: settings.max_bounces.unwrap_or(u32::MAX),
            size: [settings.width, settings.height],
            max_radiance: settings.max_radiance.unwrap_or(f32::MAX),
            ..Self::default()
        }
    }
}
