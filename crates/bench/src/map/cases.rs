//! The rows of the map.

use std::f64::consts::PI;

use glam::{DAffine3, DMat3, DQuat, DVec3};
use surelight_prepare::Integrator;
use surelight_scene::{Camera, ClipRange, Instance, Light, LightKind, Material, Projection, Scene, Volume};
use surelight_scenes::{
    cornell_box, furnace, glass,
    shapes::Shape,
    torture::{light, sampling},
};

use super::{Case, SIDE, Truth};

pub(super) const CASES: &[Case] = &[
    Case {
        name: "small-light",
        title: "A small light",
        build: || sampling::spot(1.0 / 4096.0).0,
        truth: || Truth::Mean(sampling::spot(1.0 / 4096.0).1),
        samples: 64,
        exposure: 6.0,
        why: "A lamp that covers 1/4096 of the hemisphere. The hemisphere form waits until a direction happens \
              to hit it: most pixels have hit it never or once, and are not certified. The area form never \
              misses it; such lights are its purpose. Whitted's one shadow ray to the middle of each of the \
              lamp's two triangles is nearly right for so small a lamp.",
    },
    Case {
        name: "large-light-on-gloss",
        title: "A large light on gloss",
        build: gloss,
        truth: || Truth::Long(Integrator::Hemisphere(surelight_prepare::Directions::Bsdf), 4),
        samples: 64,
        exposure: 0.0,
        why: "A metal plate of α = 0.01 mirrors a wall of light. The BSDF restricts the incident directions to \
              a cone of a degree, and the hemisphere form samples it. The area form takes points all over the \
              wall; one in thousands lies in that cone and then has a weight of thousands: heavy tails. \
              Combined by their pdfs, the form with the better density has the weight.",
    },
    Case {
        name: "contact-light",
        title: "A light that touches a surface",
        build: contact,
        truth: contact_truth,
        samples: 64,
        exposure: 0.0,
        why: "A lamp is on the floor, and the picture is of the centimetre before it. The area form's \
              integrand has 1/r² in it, and r goes to zero: a sample exceeds x with a probability of x^−1.5, \
              so that it has a mean and no variance, and no number of samples gives an error bar. The tail \
              test detects it. The hemisphere form has the 1/r² in its solid angle and is unaffected, and mis \
              leaves the close points to it. Whitted's single point ignores the lamp's extent.",
    },
    Case {
        name: "bulb-in-glass",
        title: "A lamp in a globe of glass",
        build: || globe(0.03),
        truth: || Truth::Long(Integrator::Caustics, 4),
        samples: 64,
        exposure: 3.0,
        why: "From the camera every unbiased estimator fails: a smooth interface refracts a direction into one \
              other, so no point on the lamp can be connected with the floor. Chance alone is left, in three \
              columns alike. Rays from the lamp detect that before the first sample, and the summary states \
              it; the pixels are not certified. Whitted leaves such light out. Light tracing from the lamp \
              finds all of it on the floor, which is visible to the camera.",
    },
    Case {
        name: "point-in-glass",
        title: "A point light in a globe of glass",
        build: point,
        truth: || Truth::Mean(point_mean()),
        samples: 64,
        exposure: 3.0,
        why: "The same with a light that has no extent. Chance has nothing to hit: the probability is zero, \
              and so is the picture, with an error bar of zero. Only rays from the light detect it: all of \
              them hit smooth glass first. The picture's metadata and the summary list the light as \
              unreachable. Particles from the light are unaffected.",
    },
    Case {
        name: "point-on-mirror",
        title: "A point light by a mirror",
        build: mirror,
        truth: || Truth::Mean(mirror_mean()),
        samples: 256,
        exposure: 0.0,
        why: "A wall that a point light reaches by a mirror alone; a screen blocks the direct way. The closed \
              form is that of the light's mirror image. No path from the camera finds it, and all estimators \
              without light tracing say so.",
    },
    Case {
        name: "interreflection",
        title: "Light between surfaces",
        build: cornell_box::cornell_box,
        truth: || Truth::Long(Integrator::Mis, 2),
        samples: 256,
        exposure: 0.0,
        why: "The Cornell box. Whitted's picture is free of noise and wrong: light between diffuse surfaces is \
              left out, and no error bar covers light that is never sampled. It is recorded as biased. The \
              others agree. The hemisphere form pays for finding a lamp of moderate size by chance, again at \
              every bounce.",
    },
    Case {
        name: "contact-shadow",
        title: "A contact shadow",
        build: shadow,
        truth: || Truth::Long(Integrator::Mis, 2),
        samples: 256,
        exposure: 0.0,
        why: "A ball on a floor under a broad lamp: black where they touch, a wide penumbra around. Shadow rays to points all over the lamp \
              and chance directions both find it. A shadow ray to the middle draws a hard edge in the wrong place.",
    },
    Case {
        name: "caustics",
        title: "Caustics",
        build: glass::glass,
        truth: || Truth::Long(Integrator::Caustics, 8),
        samples: 64,
        exposure: 0.0,
        why: "Glass beside a lamp in the open: most light is connected, and light through glass is found by \
              chance, seldom and bright. These are the fireflies. They are not clamped, since that would be a \
              bias; the pixels that have them, and their neighbours that have none so far, are not certified. \
              Traced from the lamp, the floor is clean; only the caustics seen through the glass are left to \
              chance.",
    },
    Case {
        name: "deep-paths",
        title: "Albedo 0.99",
        build: || sampling::room(0.99),
        truth: || Truth::Mean(1.0),
        samples: 16,
        exposure: 0.0,
        why: "A closed room that keeps 99 % of the light a bounce: half of the visible light has been \
              reflected 69 times and more. A depth limit would cut it off. Roulette that ended paths with a \
              constant chance of 5 % a bounce would be unbiased and have no variance, since weights would grow \
              faster than paths die; here the chance falls with the depth. The area form alone fights 1/r² in \
              every corner.",
    },
    Case {
        name: "far-from-origin",
        title: "A million metres from the origin",
        build: far,
        truth: || Truth::Mean(f64::from(furnace::RADIANCE[1])),
        samples: 64,
        exposure: 0.0,
        why: "A furnace of two metres at (10⁶, 10⁶, 10⁶), where an f32 has steps of 6 cm. Positions are made \
              relative to the camera in f64 before they are rounded, so that nothing is lost; rays start off a \
              surface by the bound of their own rounding. Whitted leaves out the light between the walls, and \
              the area form has 1/r² in the corners again.",
    },
];

fn material(name: &str) -> Material {
    Material { name: name.into(), double_sided: true, ..Material::default() }
}

fn lambert(reflectance: f32) -> Material {
    let base_color = [reflectance, reflectance, reflectance, 1.0];
    Material { base_color, metallic: 0.0, specular: 0.0, ..material("diffuse") }
}

fn emitter(radiance: f32) -> Material {
    Material { emissive: [radiance; 3], double_sided: false, ..lambert(0.0) }
}

fn add(scene: &mut Scene, shape: Shape, material: Material) {
    scene.materials.push(material);
    scene.meshes.push(shape.bare().into_mesh("", scene.materials.len() - 1, false));
    scene.instances.push(Instance { mesh: scene.meshes.len() - 1, to_world: DAffine3::IDENTITY });
}

fn camera(eye: DVec3, target: DVec3, yfov: f64) -> Camera {
    let z = (eye - target).normalize();
    let x = DVec3::Y.cross(z).normalize();
    let to_world = DAffine3::from_mat3_translation(DMat3::from_cols(x, z.cross(x), z), eye);
    Camera {
        name: String::new(),
        to_world,
        projection: Projection::Perspective { yfov: yfov.to_radians(), aspect: Some(1.0) },
        clip: ClipRange::NONE,
    }
}

/// Eye and target of the view of the floor beside a globe.
const FLOOR_VIEW: [DVec3; 2] = [DVec3::new(0.0, 1.2, 3.0), DVec3::new(0.0, 0.0, 0.9)];

/// The globe of the torture list about a bulb; the camera is directed past it at the floor.
fn globe(radius: f64) -> Scene {
    let mut scene = light::sds(Some(radius));
    scene.cameras[0] = camera(FLOOR_VIEW[0], FLOOR_VIEW[1], 30.0);
    scene
}

/// A point light of 40 cd at the centre of a smooth globe: its rays are radii of the globe, and are
/// not refracted.
fn point() -> Scene {
    let mut scene = Scene::default();
    // Dark, so that light back from the globe is negligible.
    add(&mut scene, Shape::parallelogram(DVec3::ZERO, DVec3::X * 20.0, DVec3::NEG_Z * 20.0), lambert(0.02));
    let volume = Volume { attenuation_distance: f32::INFINITY, attenuation_color: [1.0; 3] };
    let glass =
        Material { metallic: 0.0, transmission: 1.0, roughness: 0.0, volume: Some(volume), ..material("globe") };
    scene.materials.push(glass);
    scene.meshes.push(Shape::icosphere(4).placed(0.4, DVec3::Y).into_mesh("", 1, false));
    scene.instances.push(Instance { mesh: 1, to_world: DAffine3::IDENTITY });
    scene.lights.push(Light {
        name: "bulb".into(),
        kind: LightKind::Point { position: DVec3::Y },
        intensity: [40.0; 3],
    });
    scene.cameras.push(camera(FLOOR_VIEW[0], FLOOR_VIEW[1], 30.0));
    scene
}

/// ρ/π·I·cosθ/r² over the picture: reflections by the globe leave on its other side.
fn point_mean() -> f64 {
    const GRID: u32 = 256;
    let [eye, target] = FLOOR_VIEW;
    let z = (eye - target).normalize();
    let x = DVec3::Y.cross(z).normalize();
    let y = z.cross(x);
    let half = 15f64.to_radians().tan();
    let at = |k: u32| ((f64::from(k) + 0.5) / f64::from(GRID) * 2.0 - 1.0) * half;
    let points = (0..GRID * GRID).map(|k| {
        let direction = x * at(k % GRID) + y * at(k / GRID) - z;
        let p = eye - direction * (eye.y / direction.y);
        0.02 / PI * 40.0 / (p.x * p.x + p.z * p.z + 1.0).powf(1.5)
    });
    points.sum::<f64>() / f64::from(GRID * GRID)
}

/// A plate of metal before a wall that shines.
fn gloss() -> Scene {
    let mut scene = Scene::default();
    let metal = Material { base_color: [0.9, 0.9, 0.9, 1.0], roughness: 0.1, ..material("metal") };
    add(&mut scene, Shape::parallelogram(DVec3::ZERO, DVec3::X * 2.0, DVec3::NEG_Z * 2.0), metal);
    add(&mut scene, Shape::parallelogram(DVec3::new(0.0, 4.0, -4.0), DVec3::X * 8.0, DVec3::Y * 4.0), emitter(1.0));
    scene.cameras.push(camera(DVec3::new(0.0, 1.5, 2.0), DVec3::ZERO, 20.0));
    scene
}

/// Half of a centimetre's side.
const CLOSE: f64 = 0.005;

/// The contact light of the torture list, seen so close that every pixel is near the edge.
fn contact() -> Scene {
    let mut scene = light::contact_light();
    let turn = DMat3::from_quat(DQuat::from_rotation_x(-std::f64::consts::FRAC_PI_2));
    scene.cameras[0].to_world = DAffine3::from_mat3_translation(turn, DVec3::new(0.0, 3.0, CLOSE));
    scene.cameras[0].projection = Projection::Orthographic { xmag: CLOSE, ymag: CLOSE };
    scene
}

fn contact_truth() -> Truth {
    const GRID: u32 = 8 * SIDE;
    let at = |k: u32| (f64::from(k) + 0.5) / f64::from(GRID) * 2.0 * CLOSE;
    let points = (0..GRID * GRID).map(|k| light::contact_radiance(at(k % GRID) - CLOSE, at(k / GRID)));
    Truth::Mean(points.sum::<f64>() / f64::from(GRID * GRID))
}

/// A floor that mirrors, a wall, a point light, and a screen between light and wall.
fn mirror() -> Scene {
    let mut scene = Scene::default();
    let smooth = Material { roughness: 0.0, ..material("mirror") };
    add(&mut scene, Shape::parallelogram(DVec3::new(0.0, 0.0, -0.65), DVec3::X * 0.25, DVec3::NEG_Z * 0.25), smooth);
    add(&mut scene, Shape::parallelogram(DVec3::new(0.0, 0.5, -1.0), DVec3::X * 0.15, DVec3::Y * 0.15), lambert(0.5));
    add(&mut scene, Shape::parallelogram(DVec3::new(0.0, 0.975, -0.3), DVec3::X * 0.5, DVec3::Y * 0.325), lambert(0.0));
    let kind = LightKind::Point { position: DVec3::Y };
    scene.lights.push(Light { name: "bulb".into(), kind, intensity: [10.0; 3] });
    scene.cameras.push(Camera {
        name: String::new(),
        to_world: DAffine3::from_translation(DVec3::new(0.0, 0.5, -0.5)),
        projection: Projection::Orthographic { xmag: 0.1, ymag: 0.1 },
        clip: ClipRange::NONE,
    });
    scene
}

/// ρ/π·I·cosθ/r² from the light's mirror image at (0, −1, 0), over the picture.
fn mirror_mean() -> f64 {
    const GRID: u32 = 64;
    let at = |k: u32| (f64::from(k) + 0.5) / f64::from(GRID) * 0.2 - 0.1;
    let points = (0..GRID * GRID).map(|k| {
        let (x, y) = (at(k % GRID), 1.5 + at(k / GRID));
        0.5 / PI * 10.0 / (x * x + y * y + 1.0).powf(1.5)
    });
    points.sum::<f64>() / f64::from(GRID * GRID)
}

/// A ball on a floor under a broad lamp.
fn shadow() -> Scene {
    let mut scene = Scene::default();
    add(&mut scene, Shape::parallelogram(DVec3::ZERO, DVec3::X * 4.0, DVec3::NEG_Z * 4.0), lambert(0.7));
    add(&mut scene, Shape::icosphere(4).placed(0.5, DVec3::Y * 0.5), lambert(0.5));
    add(&mut scene, Shape::parallelogram(DVec3::new(0.6, 2.0, 0.0), DVec3::X * 0.5, DVec3::Z * 0.5), emitter(8.0));
    scene.cameras.push(camera(DVec3::new(-0.5, 1.0, 3.0), DVec3::new(-0.2, 0.3, 0.0), 40.0));
    scene
}

/// The furnace with its camera, far away.
fn far() -> Scene {
    let mut scene = furnace::furnace();
    let away = DVec3::splat(1e6);
    scene.instances.iter_mut().for_each(|i| i.to_world.translation += away);
    scene.cameras.iter_mut().for_each(|c| c.to_world.translation += away);
    scene
}
