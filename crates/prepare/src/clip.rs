//! Which of a camera's clipping planes cut something off the picture (glTF 2.0, section 3.10.3).
//!
//! Only then does the kernel contain them. Triangles are clipped, in f64, to the part of the view
//! between the camera and the near plane, and to the part beyond the far plane: a triangle with a
//! remainder there is clipped.

use glam::{DAffine3, DMat3, DVec3, DVec4};
use surelight_scene::{Camera, ClipRange, Material, Mesh, Projection, Scene};

use super::{Settings, lobes::transmits};

/// Rounding must not clip a surface in a plane: the planes are moved outwards by this share of
/// their depth.
const MARGIN: f64 = 1e-6;

/// After this many triangles the planes are assumed to clip, without further tests.
const MAX_TRIANGLES: u64 = 1 << 26;

/// The planes at which a camera's clipping removes surfaces.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct ActiveClipPlanes {
    /// The near plane cuts something.
    pub near: bool,
    /// The far plane does.
    pub far: bool,
    /// The near plane cuts the surface of a medium, so that rays may start inside.
    pub medium: bool,
}

impl ActiveClipPlanes {
    /// Whether anything is cut.
    pub fn any(self) -> bool {
        self.near || self.far
    }

    /// Tests every triangle of the scene.
    pub fn find(scene: &Scene, camera: &Camera, settings: &Settings) -> Self {
        if camera.clip == ClipRange::NONE || settings.receiver {
            return Self::default();
        }
        match Frustum::new(camera, settings) {
            Some(frustum) => frustum.cut(scene),
            None => Self::default(),
        }
    }
}

/// The planes between which camera rays run.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Planes {
    near: f64,
    far: f64,
    /// Of the image plane, away from the camera, unit.
    normal: DVec3,
}

impl Planes {
    /// Those of a camera; none where they clip nothing.
    pub(super) fn new(camera: &Camera, cut: ActiveClipPlanes) -> Self {
        let axes = camera.to_world.matrix3;
        let normal = axes.y_axis.cross(axes.x_axis).normalize_or_zero();
        let ClipRange { near, far } = if cut.any() { camera.clip } else { ClipRange::NONE };
        Self { near: near * (1.0 - MARGIN), far: far * (1.0 + MARGIN), normal }
    }

    /// Where a camera ray crosses the near plane.
    pub(super) fn start(&self, origin: DVec3, direction: DVec3) -> DVec3 {
        if self.near > 0.0 { origin + direction * (self.near / direction.dot(self.normal)) } else { origin }
    }

    /// Depths of the near and the far plane as bits of f32, for the kernel.
    pub(super) fn bits(&self) -> [u32; 2] {
        // FAR in shaders.
        const FAR: f64 = 3e38;
        [self.near, self.far].map(|depth| (depth.min(FAR) as f32).to_bits())
    }
}

/// The view frustum of a camera. Points have the coordinates x and y along the camera's axes, and
/// the distance along its view axis.
struct Frustum {
    to_camera: DAffine3,
    /// Four sides, then the camera itself. A point is inside where the dot product with
    /// (x, y, distance, 1) is positive.
    sides: [DVec4; 5],
    /// A slab that is nearer than the near plane.
    before: DVec4,
    /// A slab that is beyond the far plane.
    beyond: DVec4,
}

impl Frustum {
    fn new(camera: &Camera, settings: &Settings) -> Option<Self> {
        let axes = camera.to_world.matrix3;
        // The view axis need not be at right angles to the image.
        let forward = -axes.z_axis.try_normalize()?;
        let basis = DMat3::from_cols(axes.x_axis, axes.y_axis, forward);
        let inverse = basis.inverse();
        let eye = camera.to_world.translation;
        let planes = Planes::new(camera, ActiveClipPlanes { near: true, ..ActiveClipPlanes::default() });
        let cosine = forward.dot(planes.normal);
        let aspect = f64::from(settings.width) / f64::from(settings.height);
        // Half the picture's height at a distance s is `slope`·s + `base`. A lens of radius r in
        // focus at f blurs a point by r·|1 − s/f| at most, which is below r + s·r/f.
        let (slope, base, lens) = match camera.projection {
            Projection::Perspective { yfov, .. } => {
                let radius = settings.aperture.map_or(0.0, |diameter| 0.5 * f64::from(diameter));
                let focus = f64::from(settings.focus.unwrap_or(1.0));
                ((0.5 * yfov).tan(), 0.0, [radius / focus, radius])
            }
            Projection::Orthographic { ymag, .. } => (0.0, ymag.abs(), [0.0; 2]),
        };
        let side = |normal: DVec3, width: f64, axis: DVec3| {
            let [slope, base] = [slope * width + lens[0] / axis.length(), base * width + lens[1] / axis.length()];
            DVec4::new(normal.x, normal.y, slope, base)
        };
        let frustum = Self {
            to_camera: DAffine3 { matrix3: inverse, translation: -(inverse * eye) },
            sides: [
                side(DVec3::X, aspect, axes.x_axis),
                side(DVec3::NEG_X, aspect, axes.x_axis),
                side(DVec3::Y, 1.0, axes.y_axis),
                side(DVec3::NEG_Y, 1.0, axes.y_axis),
                DVec4::Z,
            ],
            before: DVec4::new(0.0, 0.0, -cosine, planes.near),
            beyond: DVec4::new(0.0, 0.0, cosine, -planes.far),
        };
        (frustum.to_camera.is_finite() && cosine > 0.0).then_some(frustum)
    }

    fn cut(&self, scene: &Scene) -> ActiveClipPlanes {
        let boxes: Vec<Option<[DVec3; 8]>> = scene.meshes.iter().map(corners).collect();
        let mut cut = ActiveClipPlanes::default();
        let mut tested = 0;
        for instance in &scene.instances {
            let mesh = &scene.meshes[instance.mesh];
            let material = &scene.materials[mesh.material];
            let is_medium = has_medium(material);
            if cut.near && cut.far && (cut.medium || !is_medium) {
                continue;
            }
            let place = self.to_camera * instance.to_world;
            if boxes[instance.mesh].is_some_and(|corners| {
                let corners = corners.map(|corner| place.transform_point3(corner).extend(1.0));
                self.misses(&corners, self.before) && self.misses(&corners, self.beyond)
            }) {
                continue;
            }
            for triangle in &mesh.triangles {
                tested += 1;
                // Indices out of range are the BVH's to refuse.
                let position = |i: u32| mesh.positions.get(i as usize).map_or(DVec3::NAN, |p| p.as_dvec3());
                let corners = triangle.map(|i| place.transform_point3(position(i)).extend(1.0));
                if (!cut.near || is_medium && !cut.medium) && self.holds(&corners, self.before) {
                    cut.near = true;
                    cut.medium |= is_medium;
                }
                cut.far = cut.far || self.holds(&corners, self.beyond);
                if cut.near && cut.far && (cut.medium || !is_medium) {
                    break;
                }
                if tested >= MAX_TRIANGLES {
                    return ActiveClipPlanes { near: true, far: true, medium: true };
                }
            }
        }
        cut
    }

    /// Whether all points lie outside one and the same plane of the view's part: nothing between
    /// them is inside.
    fn misses(&self, points: &[DVec4], slab: DVec4) -> bool {
        self.sides.iter().chain([&slab]).any(|plane| points.iter().all(|point| plane.dot(*point) <= 0.0))
    }

    /// Whether some of a triangle lies inside the view's part (Sutherland & Hodgman 1974).
    fn holds(&self, triangle: &[DVec4; 3], slab: DVec4) -> bool {
        if self.misses(triangle, slab) || !triangle.iter().all(|corner| corner.is_finite()) {
            return false;
        }
        let mut polygon = triangle.to_vec();
        for plane in self.sides.iter().chain([&slab]) {
            let mut clipped = Vec::with_capacity(polygon.len() + 1);
            for (i, &to) in polygon.iter().enumerate() {
                let from = polygon[(i + polygon.len() - 1) % polygon.len()];
                let (a, b) = (plane.dot(from), plane.dot(to));
                if (a > 0.0) != (b > 0.0) {
                    clipped.push(from + (to - from) * (a / (a - b)));
                }
                if b > 0.0 {
                    clipped.push(to);
                }
            }
            polygon = clipped;
        }
        !polygon.is_empty()
    }
}

/// Corners of a mesh's box; `None` where some vertex is not finite.
fn corners(mesh: &Mesh) -> Option<[DVec3; 8]> {
    let first = mesh.positions.first()?.as_dvec3();
    let mut bounds = (first, first);
    for position in &mesh.positions {
        if !position.is_finite() {
            return None;
        }
        bounds = (bounds.0.min(position.as_dvec3()), bounds.1.max(position.as_dvec3()));
    }
    let pick = |i: usize, axis: usize| if i >> axis & 1 == 0 { bounds.0[axis] } else { bounds.1[axis] };
    Some(std::array::from_fn(|i| DVec3::new(pick(i, 0), pick(i, 1), pick(i, 2))))
}

fn has_medium(material: &Material) -> bool {
    material.volume.is_some() && transmits(material)
}
