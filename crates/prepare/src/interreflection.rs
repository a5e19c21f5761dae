//! How much of the light of an image is reflected between surfaces: whether path reuse by
//! neighbouring pixels pays.
//!
//! Estimated by rays on the host: camera rays, then a continuation from their hits by the cosine.
//! Materials are judged by their factors, a texture as a half of its factor. A thousand rays give
//! the share to some hundredths, which is more than the decision needs.

use glam::{DVec3, Vec3};
use surelight_accel::{Accel, Ray};
use surelight_scene::{Camera, Material, Projection, Scene};

use super::{
    clip::Planes,
    lobes::{has_facets, mean_albedo},
    shared::View,
    surface::Surface,
    unreachable::{direction_around, point},
};

const RAYS: u32 = 1024;

/// Interreflection over reflection, Σ a(x) a(y) / Σ a(x): with the albedos a of the point x that a
/// camera ray hits and of the point y that a ray from there hits; 0 for emitters and for no hit.
pub(super) fn share(scene: &Scene, accel: &Accel, camera: &Camera, view: &View, planes: &Planes) -> f64 {
    let orthographic = matches!(camera.projection, Projection::Orthographic { .. });
    let [origin, right, up, forward] =
        [view.origin, view.right, view.up, view.forward].map(|v| Vec3::from(v).as_dvec3());
    let (mut visible, mut shared) = (0.0, 0.0);
    for i in 0..RAYS {
        let u = point(i, RAYS);
        let across = (2.0 * u.x - 1.0) * right - (2.0 * u.y - 1.0) * up;
        let (from, direction) = if orthographic { (origin + across, forward) } else { (origin, forward + across) };
        let from = planes.start(from, direction);
        let Some((distance, surface)) = hit(scene, accel, from, direction) else { continue };
        let albedo = albedo(surface.material);
        visible += albedo;
        let Some(normal) = surface.front.try_normalize() else { continue };
        let normal = if normal.dot(direction) > 0.0 { -normal } else { normal };
        // Two more dimensions of a low-discrepancy point.
        let v = [0.754_877_666_246_693, 0.569_840_290_998_053].map(|step| (f64::from(i) * step).fract());
        let at = from + direction * distance;
        let step = 1e-5 * (at.abs().max_element() + 1e-3);
        if let Some((_, next)) = hit(scene, accel, at + normal * step, direction_around(normal, v[0].sqrt(), v[1])) {
            shared += albedo * self::albedo(next.material);
        }
    }
    if visible > 0.0 { shared / visible } else { 0.0 }
}

/// The surface that a ray hits, and its distance.
fn hit<'a>(scene: &'a Scene, accel: &Accel, origin: DVec3, direction: DVec3) -> Option<(f64, Surface<'a>)> {
    let hit = accel.intersect(&Ray::new(origin.as_vec3(), direction.as_vec3()))?;
    Some((f64::from(hit.t), Surface::at(scene, accel, &hit)))
}

/// The albedo of what scatters and does not emit: mirrors and clear glass leave nothing to share.
fn albedo(m: &Material) -> f64 {
    let smooth = has_facets(m) && m.roughness < 0.01 && (m.metallic > 0.5 || m.transmission > 0.5);
    if m.is_emissive() || smooth { 0.0 } else { mean_albedo(m) }
}
