//! How much of the light of a picture comes from surface to surface: whether it pays that neighbouring pixels share it.
//!
//! Found by rays on the host: through the picture, then onward from what they meet, by the cosine. Materials are judged by their factors, a texture as
//! a half of its factor. A thousand rays know the share to some hundredths, which is more than the decision needs.

use glam::{DVec3, Vec3};
use surelight_accel::{Accel, Hit, NO_INSTANCE, Ray};
use surelight_scene::{Camera, Material, Projection, Scene};

use super::{
    clip::Planes,
    lobes::has_facets,
    shared::View,
    unreachable::{direction_around, point},
};

const RAYS: u32 = 1024;

/// What the next surfaces reflect, over what is seen: Σ a(x) a(y) / Σ a(x) with the albedos a of what a ray through the picture meets, x, and
/// of what a ray from there meets, y, 0 for emitters and for nothing.
pub(super) fn share(scene: &Scene, accel: &Accel, camera: &Camera, view: &View, planes: &Planes) -> f64 {
    let orthographic = matches!(camera.projection, Projection::Orthographic { .. });
    let [origin, right, up, forward] =
        [view.origin, view.right, view.up, view.forward].map(|v| Vec3::from(v).as_dvec3());
    let (mut seen, mut shared) = (0.0, 0.0);
    for i in 0..RAYS {
        let u = point(i, RAYS);
        let across = (2.0 * u.x - 1.0) * right - (2.0 * u.y - 1.0) * up;
        let (from, direction) = if orthographic { (origin + across, forward) } else { (origin, forward + across) };
        let from = planes.start(from, direction);
        let Some((hit, albedo)) = meet(scene, accel, from, direction) else { continue };
        seen += albedo;
        let Some(normal) = normal(scene, accel, &hit) else { continue };
        let normal = if normal.dot(direction) > 0.0 { -normal } else { normal };
        // Two more even numbers.
        let v = [0.754_877_666_246_693, 0.569_840_290_998_053].map(|step| (f64::from(i) * step).fract());
        let at = from + direction * f64::from(hit.t);
        let step = 1e-5 * (at.abs().max_element() + 1e-3);
        if let Some((_, next)) = meet(scene, accel, at + normal * step, direction_around(normal, v[0].sqrt(), v[1])) {
            shared += albedo * next;
        }
    }
    if seen > 0.0 { shared / seen } else { 0.0 }
}

/// What a ray meets, and its albedo.
fn meet(scene: &Scene, accel: &Accel, origin: DVec3, direction: DVec3) -> Option<(Hit, f64)> {
    let hit = accel.intersect(&Ray::new(origin.as_vec3(), direction.as_vec3()))?;
    let mesh = accel.triangles[hit.prim as usize].mesh as usize;
    Some((hit, albedo(&scene.materials[scene.meshes[mesh].material])))
}

/// What scatters and does not shine: mirrors and clear glass send light on without a place for it to be shared.
fn albedo(m: &Material) -> f64 {
    let smooth = has_facets(m) && m.roughness < 0.01 && (m.metallic > 0.5 || m.transmission > 0.5);
    if m.unlit || m.is_emissive() || smooth {
        return 0.0;
    }
    let factor = m.base_color[..3].iter().map(|&c| f64::from(c)).sum::<f64>() / 3.0;
    if m.base_color_texture.is_some() { 0.5 * factor } else { factor }
}

fn normal(scene: &Scene, accel: &Accel, hit: &Hit) -> Option<DVec3> {
    let source = &accel.triangles[hit.prim as usize];
    let instance = if hit.instance == NO_INSTANCE {
        source.instance
    } else {
        accel.instances[hit.instance as usize].scene_instance
    };
    let to_world = scene.instances[instance as usize].to_world;
    let mesh = &scene.meshes[source.mesh as usize];
    let [a, b, c] = source.corners.map(|i| to_world.transform_point3(mesh.positions[i as usize].as_dvec3()));
    (b - a).cross(c - a).try_normalize()
}
