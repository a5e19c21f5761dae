//! A measurement as a camera, whose every pixel is an estimate of the quantity.

use glam::{DAffine3, DMat3, DVec3};
use surelight_prepare::{Integrator, Settings};
use surelight_scene::{Camera, ClipRange, Projection, Scene};

use super::args::MeasureArgs;
use crate::camera::{self, View};
use crate::error::Error;

/// Sides of the square of pixels that estimate one point: few lanes feed a CPU, a GPU needs many.
const CPU_SIDE: u32 = 64;
const GPU_SIDE: u32 = 256;

/// Vertices are rounded to f32 relative to the measured point, by up to 2^-24 of their distance; a
/// surface through the point may be off by a few times that.
const ROUNDING: f64 = 1.0 / (1 << 21) as f64;

/// A measurement as a render.
pub(super) struct Setup {
    pub(super) camera: Camera,
    pub(super) settings: Settings,
    /// From the pixels' radiance to the quantity.
    pub(super) factor: f64,
    /// Whether all pixels estimate the same number; else their mean is the quantity.
    pub(super) same_quantity: bool,
    /// Pixels here for one of the user's.
    pub(super) parts: u32,
    pub(super) notes: Vec<String>,
}

/// Sets up the render.
pub(super) fn setup(args: &MeasureArgs, scene: &Scene, is_cpu: bool) -> Result<Setup, Error> {
    let side = if is_cpu { CPU_SIDE } else { GPU_SIDE };
    let mut settings = Settings::new(side, side);
    let mut notes = Vec::new();
    let (camera, factor, same_quantity, parts) = if let (Some(point), Some(direction)) = (args.point, args.direction) {
        (ray(point.into(), direction.into(), "--direction")?, 1.0, true, 1)
    } else if let (Some(point), Some(normal)) = (args.irradiance, args.normal) {
        settings.receiver = true;
        let (camera, lift) = receiver(scene, point.into(), normal.into())?;
        if lift > 0.0 {
            notes.push(format!(
                "the receiver is {lift:.1e} m off the point, so that a surface through it cannot hide it"
            ));
        }
        (camera, std::f64::consts::PI, true, 1)
    } else {
        let view = camera::choose(scene, args.scene.name(), &args.camera, args.size)?;
        notes.extend(view.note.clone());
        // clap requires one of the three.
        let region = args.region.unwrap_or([0, 0, view.size.width, view.size.height]);
        let [x0, y0, x1, y1] = region;
        if x1 > view.size.width || y1 > view.size.height {
            return Err(Error::Region { width: view.size.width, height: view.size.height });
        }
        let (width, height) = (x1 - x0, y1 - y0);
        let pixels = f64::from(width) * f64::from(height);
        let parts = (f64::from(side * side) / pixels).sqrt().ceil().max(1.0) as u32;
        (settings.width, settings.height) = (width * parts, height * parts);
        let (camera, stretch) = window(&view, region);
        settings.aperture = view.lens.map(|lens| lens.aperture);
        settings.focus = view.lens.map(|lens| (f64::from(lens.focus) * stretch) as f32);
        (camera, 1.0, false, parts * parts)
    };
    settings.max_bounces = args.max_bounces.0;
    settings.seed = args.seed;
    settings.integrator = match args.method.integrator() {
        // Pixels that share particles have no separate error bars.
        Integrator::Auto => Integrator::Mis,
        integrator => integrator,
    };
    settings.sampler = args.method.sampler();
    Ok(Setup { camera, settings, factor, same_quantity, parts, notes })
}

/// A camera all of whose rays are one.
fn ray(point: DVec3, direction: DVec3, option: &'static str) -> Result<Camera, Error> {
    let forward = direction.try_normalize().ok_or(Error::NoDirection(option))?;
    let (right, up) = forward.any_orthonormal_pair();
    Ok(Camera {
        name: String::new(),
        to_world: DAffine3 { matrix3: DMat3::from_cols(right, up, -forward), translation: point },
        projection: Projection::Perspective { yfov: 0.0, aspect: None },
        clip: ClipRange::NONE,
    })
}

/// The receiver's place, and by how much it is lifted off the point.
fn receiver(scene: &Scene, point: DVec3, normal: DVec3) -> Result<(Camera, f64), Error> {
    let camera = ray(point, normal, "--normal")?;
    let reach = scene.bounds().map_or(0.0, |(low, high)| (low - point).abs().max((high - point).abs()).max_element());
    let lift = reach * ROUNDING;
    let normal = normal.normalize();
    Ok((ray(point + lift * normal, normal, "--normal").unwrap_or(camera), lift))
}

/// A camera for this part of the view's image, and the factor on the distance of its plane of
/// focus.
///
/// Its axes are sheared so that the rays are those of the whole image: each is forward + a·right −
/// b·up for the point (a, b) of the image, and the window's middle takes the place of forward.
fn window(view: &View, [x0, y0, x1, y1]: [u32; 4]) -> (Camera, f64) {
    let (width, height) = (f64::from(view.size.width), f64::from(view.size.height));
    let share = [f64::from(x1 - x0) / width, f64::from(y1 - y0) / height];
    let middle = [f64::from(x0 + x1) / width - 1.0, f64::from(y0 + y1) / height - 1.0];
    let axes = view.camera.to_world.matrix3;
    let place = view.camera.to_world.translation;
    let aspect = width / height;
    // The renderer widens the horizontal axis by the aspect of the image it makes.
    let own_aspect = f64::from(x1 - x0) / f64::from(y1 - y0);
    match view.camera.projection {
        Projection::Perspective { yfov, .. } => {
            let tangent = (0.5 * yfov).tan();
            let (right, up) = (axes.x_axis * tangent * aspect, axes.y_axis * tangent);
            let forward = -axes.z_axis.normalize() + middle[0] * right - middle[1] * up;
            let stretch = forward.length();
            let matrix = DMat3::from_cols(
                right * (share[0] / own_aspect / stretch),
                up * (share[1] / stretch),
                -forward / stretch,
            );
            let projection = Projection::Perspective { yfov: std::f64::consts::FRAC_PI_2, aspect: None };
            let to_world = DAffine3 { matrix3: matrix, translation: place };
            (Camera { name: view.camera.name.clone(), to_world, projection, clip: view.camera.clip }, stretch)
        }
        Projection::Orthographic { ymag, xmag, .. } => {
            let (right, up) = (axes.x_axis * ymag * aspect, axes.y_axis * ymag);
            let translation = place + middle[0] * right - middle[1] * up;
            let projection = Projection::Orthographic { ymag: ymag * share[1], xmag: xmag * share[0] };
            let to_world = DAffine3 { matrix3: axes, translation };
            (Camera { name: view.camera.name.clone(), to_world, projection, clip: view.camera.clip }, 1.0)
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::parse::Size;

    /// Origin and direction of the ray through a point of an image, as `shaders/scene/camera.wesl`
    /// makes it: (0, 0) is the upper left corner and (1, 1) the lower right.
    fn camera_ray(camera: &Camera, aspect: f64, at: [f64; 2]) -> [DVec3; 2] {
        let axes = camera.to_world.matrix3;
        let (tangent, flat) = match camera.projection {
            Projection::Perspective { yfov, .. } => ((0.5 * yfov).tan(), false),
            Projection::Orthographic { ymag, .. } => (ymag, true),
        };
        let [a, b] = at.map(|c| 2.0 * c - 1.0);
        let across = a * axes.x_axis * tangent * aspect - b * axes.y_axis * tangent;
        let forward = -axes.z_axis.normalize();
        let origin = camera.to_world.translation;
        if flat { [origin + across, forward] } else { [origin, (forward + across).normalize()] }
    }

    #[test]
    fn a_window_has_the_rays_of_the_whole_image() {
        let rotation = DMat3::from_rotation_y(0.7) * DMat3::from_rotation_x(-0.4);
        for projection in [
            Projection::Perspective { yfov: 0.9, aspect: Some(1.5) },
            Projection::Orthographic { xmag: 3.0, ymag: 2.0 },
        ] {
            let to_world = DAffine3 { matrix3: rotation, translation: DVec3::new(1.0, 2.0, 3.0) };
            let camera = Camera { name: String::new(), to_world, projection, clip: ClipRange::NONE };
            let view = View { camera, size: Size { width: 60, height: 40 }, lens: None, note: None };
            for region in [[0, 0, 60, 40], [50, 3, 57, 20], [0, 39, 1, 40]] {
                let (part, stretch) = window(&view, region);
                let [x0, y0, x1, y1] = region.map(f64::from);
                for [u, v] in [[0.0, 0.0], [1.0, 0.0], [0.3, 0.8], [1.0, 1.0]] {
                    let whole = [(x0 + u * (x1 - x0)) / 60.0, (y0 + v * (y1 - y0)) / 40.0];
                    let wanted = camera_ray(&view.camera, 1.5, whole);
                    let found = camera_ray(&part, (x1 - x0) / (y1 - y0), [u, v]);
                    for (wanted, found) in wanted.iter().zip(found) {
                        assert!((*wanted - found).length() < 1e-12, "{region:?} {u} {v}");
                    }
                }
                assert!(stretch >= 1.0 - 1e-12);
            }
        }
    }

    #[test]
    fn a_ray_needs_a_direction() {
        assert!(ray(DVec3::ZERO, DVec3::ZERO, "--normal").is_err());
        let camera = ray(DVec3::X, DVec3::new(0.0, -3.0, 0.0), "--direction").unwrap();
        let [origin, direction] = camera_ray(&camera, 1.0, [0.1, 0.9]);
        assert_eq!((origin, direction), (DVec3::X, DVec3::NEG_Y));
    }
}
