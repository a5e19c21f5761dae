//! The camera and everything else that is constant over a render, as the kernel reads it.

use bytemuck::{Pod, Zeroable};
use glam::{DVec3, Vec3};
use surelight_scene::{Camera, Projection};

use super::Settings;

/// Counterpart of `View` in `shaders/scene/view.wesl`.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, Pod, Zeroable)]
pub struct View {
    pub(crate) origin: [f32; 3],
    pub(crate) lens_radius: f32,
    pub(crate) right: [f32; 3],
    pub(crate) focus: f32,
    pub(crate) up: [f32; 3],
    /// Seed of all samples.
    pub seed: u32,
    pub(crate) forward: [f32; 3],
    pub(crate) max_bounces: u32,
    pub(crate) environment: [f32; 3],
    pub(crate) environment_rotation: f32,
    /// Pixels a row and rows.
    pub size: [u32; 2],
    pub(crate) environment_size: [u32; 2],
    pub(crate) environment_probability: f32,
    pub(crate) light_density: f32,
    pub(crate) light_count: u32,
    pub(crate) max_radiance: f32,
}

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
