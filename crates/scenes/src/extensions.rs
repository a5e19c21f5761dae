//! One small file for each material extension: a plate or a slab, viewed straight on, whose
//! radiance is known.
//!
//! All but `anisotropy`, which has a lamp, are meant for a white sky of radiance 1, so that every
//! pixel of the picture has the stated mean.

use glam::{DAffine3, DVec3};
use surelight_scene::{
    Anisotropy, Camera, Clearcoat, ClipRange, DiffuseTransmission, Instance, Iridescence, Light, LightKind, Material,
    Projection, Scene, Sheen, Volume,
};

use crate::Entry;
use crate::shapes::Shape;

/// A file of `assets/gltf/`.
pub struct ExtensionFile {
    /// Its name, its subject, its closed form, and its generator.
    pub entry: Entry,
    /// Radiance of every pixel on average, under a white sky; none where the file's sentence says
    /// something else.
    pub radiance: Option<[f64; 3]>,
}

/// The files, by the names of their extensions.
pub const FILES: &[ExtensionFile] = &[
    ExtensionFile {
        entry: Entry {
            name: "anisotropy",
            shows: "Three brushed plates under a slanting sun: turned by the extension, turned as a whole, not turned.",
            known: "The first two are equal, the third is not.",
            build: anisotropy,
        },
        radiance: None,
    },
    ExtensionFile {
        entry: Entry {
            name: "clearcoat",
            shows: "Half a smooth coat over black.",
            known: "0.04/2.",
            build: || {
                plate("clearcoat", Material { clearcoat: Clearcoat { factor: 0.5, ..Clearcoat::default() }, ..black() })
            },
        },
        radiance: Some([0.02; 3]),
    },
    ExtensionFile {
        entry: Entry {
            name: "diffuse-transmission",
            shows: "A leaf: a quarter of its diffuse light comes through.",
            known: "0.75·(0.1, 0.2, 0.3) + 0.25·(0.8, 0.4, 0.2), without noise.",
            build: diffuse_transmission,
        },
        radiance: Some([0.275, 0.25, 0.275]),
    },
    ExtensionFile {
        entry: Entry {
            name: "dispersion",
            shows: "A tinted slab with an index for each colour.",
            known: "r + (1 − r)²τ/(1 − rτ) with τ = 0.5 and r = 0.04: straight on, no colour goes another way.",
            build: || slab("dispersion", Material { dispersion: 5.0, ..tinted([0.5; 3]) }),
        },
        radiance: Some([through(0.5); 3]),
    },
    ExtensionFile {
        entry: Entry {
            name: "emissive-strength",
            shows: "A black plate that shines.",
            known: "7·(0.1, 0.5, 0.9), without noise.",
            build: || plate("emissive-strength", Material { emissive: [0.7, 3.5, 6.3], ..black() }),
        },
        radiance: Some([0.7, 3.5, 6.3]),
    },
    ExtensionFile {
        entry: Entry {
            name: "ior",
            shows: "Smooth black of index 2.",
            known: "((2 − 1)/(2 + 1))² = 1/9.",
            build: || plate("ior", Material { ior: 2.0, specular: 1.0, roughness: 0.0, ..black() }),
        },
        radiance: Some([1.0 / 9.0; 3]),
    },
    ExtensionFile {
        entry: Entry {
            name: "iridescence",
            shows: "A film of no thickness on smooth black of index 1.5.",
            known: "0.04: there is no film.",
            build: iridescence,
        },
        radiance: Some([0.04; 3]),
    },
    ExtensionFile {
        entry: Entry {
            name: "sheen",
            shows: "Fibres over black.",
            known: "In the proportions of its colour, 1 : 0.5 : 0.25, and below 1.",
            build: || {
                let sheen = Sheen { color: [1.0, 0.5, 0.25], roughness: 0.7, ..Sheen::default() };
                plate("sheen", Material { sheen, ..black() })
            },
        },
        radiance: None,
    },
    ExtensionFile {
        entry: Entry {
            name: "specular",
            shows: "Smooth black of index 1.5 with half a coloured reflection.",
            known: "0.04·0.5·(1, 0.5, 0.25).",
            build: || {
                let color = [1.0, 0.5, 0.25];
                plate("specular", Material { specular: 0.5, specular_color: color, roughness: 0.0, ..black() })
            },
        },
        radiance: Some([0.02, 0.01, 0.005]),
    },
    ExtensionFile {
        entry: Entry {
            name: "transmission",
            shows: "A tinted pane without thickness.",
            known: "0.04 + 0.96·(0.25, 0.5, 0.75).",
            build: transmission,
        },
        radiance: Some([0.28, 0.52, 0.76]),
    },
    ExtensionFile {
        entry: Entry {
            name: "unlit",
            shows: "A plate that is shown as it is.",
            known: "(0.25, 0.5, 0.75), without noise.",
            build: || plate("unlit", Material { base_color: [0.25, 0.5, 0.75, 1.0], unlit: true, ..black() }),
        },
        radiance: Some([0.25, 0.5, 0.75]),
    },
    ExtensionFile {
        entry: Entry {
            name: "volume",
            shows: "A tinted slab of index 1.5.",
            known: "r + (1 − r)²τ/(1 − rτ) with r = 0.04 and τ = (0.25, 0.5, 0.75).",
            build: || slab("volume", tinted([0.25, 0.5, 0.75])),
        },
        radiance: Some([through(0.25), through(0.5), through(0.75)]),
    },
];

/// Radiance of a slab of index 1.5 and one-way transmittance τ under a white sky, straight on.
const fn through(tau: f64) -> f64 {
    let r = 0.04;
    r + (1.0 - r) * (1.0 - r) * tau / (1.0 - r * tau)
}

/// Reflects nothing.
fn black() -> Material {
    Material {
        name: "material".to_owned(),
        base_color: [0.0, 0.0, 0.0, 1.0],
        metallic: 0.0,
        specular: 0.0,
        double_sided: true,
        ..Material::default()
    }
}

/// Glass that lets this colour through half a metre.
fn tinted(color: [f32; 3]) -> Material {
    let volume = Volume { attenuation_distance: 0.5, attenuation_color: color };
    Material { volume: Some(volume), double_sided: false, ..pane([1.0; 3]) }
}

/// Smooth clear glass with a base colour.
fn pane([r, g, b]: [f32; 3]) -> Material {
    Material { base_color: [r, g, b, 1.0], transmission: 1.0, specular: 1.0, roughness: 0.0, ..black() }
}

fn scene(name: &str, shapes: Vec<(Shape, DAffine3, Material)>) -> Scene {
    let camera = Camera {
        name: "camera".to_owned(),
        to_world: DAffine3::from_translation(DVec3::Z * 3.0),
        projection: Projection::Orthographic { xmag: 0.5, ymag: 0.5 },
        clip: ClipRange::NONE,
    };
    let mut scene = Scene { name: name.to_owned(), cameras: vec![camera], ..Scene::default() };
    for (shape, to_world, material) in shapes {
        let brushed = material.anisotropy != Anisotropy::default();
        let shape = if brushed { shape } else { shape.bare() };
        let index = scene.materials.len();
        scene.meshes.push(shape.into_mesh("plate", index, brushed));
        scene.materials.push(material);
        scene.instances.push(Instance { mesh: index, to_world });
    }
    scene
}

fn square(half: f64) -> Shape {
    Shape::parallelogram(DVec3::ZERO, DVec3::X * half, DVec3::Y * half)
}

fn plate(name: &str, material: Material) -> Scene {
    scene(name, vec![(square(1.0), DAffine3::IDENTITY, material)])
}

/// Half a metre thick.
fn slab(name: &str, material: Material) -> Scene {
    let corner = DVec3::new(1.0, 1.0, 0.25);
    scene(name, vec![(Shape::cuboid(-corner, corner), DAffine3::IDENTITY, material)])
}

fn diffuse_transmission() -> Scene {
    let leaf = DiffuseTransmission { factor: 0.25, color: [0.8, 0.4, 0.2], ..DiffuseTransmission::default() };
    plate("diffuse-transmission", Material { base_color: [0.1, 0.2, 0.3, 1.0], diffuse_transmission: leaf, ..black() })
}

fn iridescence() -> Scene {
    let film =
        Iridescence { factor: 1.0, ior: 1.3, thickness_minimum: 0.0, thickness_maximum: 0.0, ..Iridescence::default() };
    plate("iridescence", Material { iridescence: film, specular: 1.0, roughness: 0.0, ..black() })
}

fn transmission() -> Scene {
    plate("transmission", pane([0.25, 0.5, 0.75]))
}

fn anisotropy() -> Scene {
    let brushed = |rotation| Material {
        base_color: [0.9, 0.8, 0.7, 1.0],
        metallic: 1.0,
        specular: 1.0,
        roughness: 0.5,
        anisotropy: Anisotropy { strength: 0.8, rotation, texture: None },
        ..black()
    };
    let quarter = std::f64::consts::FRAC_PI_2;
    let third = |i: f64| DAffine3::from_translation(DVec3::X * (i / 3.0));
    let turned = third(0.0) * DAffine3::from_rotation_z(quarter);
    let mut scene = scene(
        "anisotropy",
        vec![
            (square(1.0 / 6.0), third(-1.0), brushed(quarter as f32)),
            (square(1.0 / 6.0), turned, brushed(0.0)),
            (square(1.0 / 6.0), third(1.0), brushed(0.0)),
        ],
    );
    let direction = DVec3::new(-0.5, 0.0, -1.0).normalize();
    let kind = LightKind::Directional { direction };
    scene.lights.push(Light { name: "sun".to_owned(), kind, intensity: [2.0; 3] });
    scene
}
