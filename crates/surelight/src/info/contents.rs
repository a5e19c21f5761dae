//! Counts of a scene's contents.

use std::fmt::{self, Display};

use serde::Serialize;
use surelight_scene::{Camera, ClipRange, Environment, Light, LightKind, Projection, Scene};

/// The contents of a scene.
#[derive(Debug, Serialize)]
pub(super) struct Contents {
    meshes: usize,
    instances: usize,
    /// Stored once each.
    triangles: usize,
    /// Every instance counted.
    triangles_placed: usize,
    materials: usize,
    emissive_materials: usize,
    textures: usize,
    images: Vec<Image>,
    /// Bytes of all images, decoded.
    image_bytes: usize,
    lights: Vec<String>,
    cameras: Vec<String>,
    extensions: Vec<Extension>,
    /// Corners of the box around everything, metres.
    bounds: Option<[[f64; 3]; 2]>,
}

#[derive(Debug, Serialize)]
struct Image {
    name: String,
    width: u32,
    height: u32,
}

#[derive(Debug, Serialize)]
struct Extension {
    name: String,
    required: bool,
    honoured: bool,
}

impl Contents {
    pub(super) fn of(scene: &Scene) -> Self {
        Self {
            meshes: scene.meshes.len(),
            instances: scene.instances.len(),
            triangles: scene.meshes.iter().map(|mesh| mesh.triangles.len()).sum(),
            triangles_placed: scene.triangle_count(),
            materials: scene.materials.len(),
            emissive_materials: scene.materials.iter().filter(|material| material.is_emissive()).count(),
            textures: scene.textures.len(),
            images: scene
                .images
                .iter()
                .map(|image| Image { name: image.name.clone(), width: image.width, height: image.height })
                .collect(),
            image_bytes: scene.images.iter().map(|image| image.rgba.len()).sum(),
            lights: scene.lights.iter().map(light).chain(scene.environment.iter().map(environment)).collect(),
            cameras: scene.cameras.iter().map(camera).collect(),
            extensions: scene
                .extensions
                .iter()
                .map(|e| Extension { name: e.name.clone(), required: e.required, honoured: e.honoured })
                .collect(),
            bounds: scene.bounds().map(|(low, high)| [low.to_array(), high.to_array()]),
        }
    }
}

fn light(light: &Light) -> String {
    let [r, g, b] = light.intensity;
    let (kind, unit) = match light.kind {
        LightKind::Point { .. } => ("point", "cd"),
        LightKind::Spot { .. } => ("spot", "cd"),
        LightKind::Directional { .. } => ("directional", "lx"),
    };
    format!("\"{}\" {kind}, {r} {g} {b} {unit}", light.name)
}

/// The file's own, of EXT_lights_image_based.
fn environment(environment: &Environment) -> String {
    match environment {
        Environment::Uniform([r, g, b]) => format!("the sky, {r} {g} {b} nt"),
        Environment::Map { map, scale, .. } => {
            format!("an environment of {} x {} texels, times {scale}", map.width, map.height)
        }
    }
}

fn camera(camera: &Camera) -> String {
    let name = &camera.name;
    let ClipRange { near, far } = camera.clip;
    let near = if near > 0.0 { format!(", znear {near} m") } else { String::new() };
    let far = if far.is_finite() { format!(", zfar {far} m") } else { String::new() };
    match camera.projection {
        Projection::Perspective { yfov, aspect } => {
            let aspect = aspect.map_or(String::new(), |aspect| format!(", aspect {aspect:.3}"));
            format!("\"{name}\" perspective, {:.1} degrees high{aspect}{near}{far}", yfov.to_degrees())
        }
        Projection::Orthographic { xmag, ymag } => {
            format!("\"{name}\" orthographic, {} x {} m{near}{far}", 2.0 * xmag.abs(), 2.0 * ymag.abs())
        }
    }
}

impl Display for Contents {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        writeln!(
            f,
            "meshes      {} with {} triangles; {} placed, {} triangles",
            self.meshes, self.triangles, self.instances, self.triangles_placed
        )?;
        if let Some([low, high]) = self.bounds {
            let size: Vec<_> = (0..3).map(|k| format!("{:.4}", high[k] - low[k])).collect();
            let middle: Vec<_> = (0..3).map(|k| format!("{:.4}", (high[k] + low[k]) / 2.0)).collect();
            writeln!(f, "size        {} m around {}", size.join(" x "), middle.join(", "))?;
        }
        writeln!(f, "materials   {}, of which {} emit light", self.materials, self.emissive_materials)?;
        let mib = self.image_bytes as f64 / f64::from(1 << 20);
        writeln!(f, "textures    {} of {} images, {mib:.1} MiB decoded", self.textures, self.images.len())?;
        list(f, "lights", &self.lights)?;
        list(f, "cameras", &self.cameras)?;
        let extensions: Vec<_> = self
            .extensions
            .iter()
            .map(|extension| {
                let required = if extension.required { "required, " } else { "" };
                let fate = if extension.honoured { "honoured" } else { "ignored" };
                format!("{} ({required}{fate})", extension.name)
            })
            .collect();
        list(f, "extensions", &extensions)
    }
}

/// A numbered list, cut where it would fill screens.
fn list(f: &mut fmt::Formatter<'_>, title: &str, lines: &[String]) -> fmt::Result {
    const SHOWN: usize = 16;
    if lines.is_empty() {
        return writeln!(f, "{title:<11} none");
    }
    for (i, line) in lines.iter().take(SHOWN).enumerate() {
        let title = if i == 0 { title } else { "" };
        writeln!(f, "{title:<11} {i}  {line}")?;
    }
    match lines.len() {
        0..=SHOWN => Ok(()),
        more => writeln!(f, "{:<11} and {} more (--json lists all)", "", more - SHOWN),
    }
}
