//! The glTF 2.0 importer.
//!
//! [`load`] goes once through the file: container and JSON ([`glb`], [`document`]), extensions
//! ([`extensions`]), the node hierarchy ([`nodes`]), then, in parallel, images ([`images`]) and
//! primitives ([`primitives`], over [`accessor`] and [`buffers`]); last, meshes that are not closed
//! lose their volume ([`open_volumes`]). An animation is applied first: to nodes as poses
//! ([`animation`]), to anything else in the JSON, which is then parsed again ([`pointers`]).
//! Nothing is trusted: every index, offset and count is checked where it is used, and optional
//! parts (textures, lights, factors out of range) are left out with a warning.

mod accessor;
mod animation;
mod basis;
mod buffers;
mod cameras;
mod document;
mod draco;
mod error;
mod extensions;
mod glb;
mod image_based_light;
mod images;
mod instancing;
mod json;
mod lights;
mod material_draft;
mod material_extensions;
mod material_layers;
mod materials;
mod meshopt;
mod nodes;
mod normals;
mod open_volumes;
mod pointers;
mod primitives;
mod shapes;
mod skins;
mod specular_glossiness;
mod tangents;
mod textures;
mod triangles;
mod uri;
mod variants;
mod warnings;

use std::path::{Path, PathBuf};

use self::accessor::Accessors;
use self::animation::Motion;
use self::buffers::Buffers;
use self::document::Document;
pub use self::error::LoadError;
use self::error::{Fault, Result};
use self::images::Sources;
use self::uri::Folders;
use self::warnings::Warnings;
use crate::Scene;

/// The part of a file to load, and limits on memory.
#[derive(Clone, Debug, PartialEq)]
pub struct LoadOptions {
    /// Index of the scene to show; `None` takes the file's default, else its first.
    pub scene: Option<usize>,
    /// Name of the material variant to show (or its index, when none has that name); `None` keeps
    /// the file's own materials.
    pub variant: Option<String>,
    /// The moment of an animation to show; `None` shows the file at rest.
    pub animation: Option<Moment>,
    /// Folders outside the scene's own that buffers and images may lie in, at any depth; a URI that
    /// leads elsewhere, be it by a link, is refused. Folders that do not exist hold nothing.
    pub allow_outside: Vec<PathBuf>,
    /// Most pixels of one image; a larger one is left out with a warning. All images together may
    /// have 16 times as many.
    pub max_image_pixels: u64,
    /// Most bytes of the scene file, and of each file or data URI that it refers to.
    pub max_buffer_bytes: u64,
    /// Bytes of vertices and triangles that any file may take. A file whose own buffers are larger
    /// than an eighth of this may take eight times its buffers.
    pub max_geometry_bytes: u64,
    /// Most placed meshes.
    pub max_instances: usize,
    /// Whether to refuse a scene that refers to other files: one that comes through a pipe has no
    /// folder to find them in.
    pub self_contained: bool,
}

/// A moment of an animation.
#[derive(Clone, Debug, PartialEq)]
pub struct Moment {
    /// Name of the animation (or its index, when none has that name).
    pub animation: String,
    /// Seconds from its start; before its first and after its last keyframe a property keeps their
    /// values.
    pub seconds: f64,
}

impl Default for LoadOptions {
    fn default() -> Self {
        Self {
            scene: None,
            variant: None,
            animation: None,
            allow_outside: Vec::new(),
            max_image_pixels: 64 << 20,
            max_buffer_bytes: 16 << 30,
            max_geometry_bytes: 1 << 30,
            max_instances: 4 << 20,
            self_contained: false,
        }
    }
}

/// Loads a .glb or .gltf file with everything it refers to.
///
/// # Errors
/// When the file or a buffer of it cannot be read, is no glTF 2.0, requires an unknown extension,
/// breaks rules that leave nothing sensible to draw (accessors and indices out of range, node
/// cycles), or needs more than `options` allow. Defects of optional parts are reported in
/// [`Scene::warnings`] instead.
pub fn load(path: &Path, options: &LoadOptions) -> std::result::Result<Scene, LoadError> {
    load_bytes(&read_file(path, options.max_buffer_bytes)?, path, options)
}

/// Loads a .glb or .gltf file that is in memory already; `path` names it in messages, and URIs are
/// relative to its folder.
///
/// # Errors
/// See [`load`].
pub fn load_bytes(file: &[u8], path: &Path, options: &LoadOptions) -> std::result::Result<Scene, LoadError> {
    read(file, path, options).map_err(|fault| fault.at(path))
}

/// A whole file, for readers outside the importer.
pub(crate) fn read_file(path: &Path, limit: u64) -> std::result::Result<Vec<u8>, LoadError> {
    uri::read_file(path, limit, "the file").map_err(|fault| fault.at(path))
}

fn read(file: &[u8], path: &Path, options: &LoadOptions) -> Result<Scene> {
    let mut warnings = Warnings::default();
    let container = glb::split(file, &mut warnings)?;
    let text = document::text(container.json)?;
    let document = document::parse(text)?;
    check_version(&document)?;
    if options.self_contained {
        document.check_self_contained()?;
    }
    let extensions = extensions::check(&document, &mut warnings)?;

    // A bare file name has an empty parent, which is no path to a file system.
    let folder = path.parent().filter(|p| !p.as_os_str().is_empty()).unwrap_or(Path::new("."));
    let folders = Folders::new(folder, &options.allow_outside);
    let buffers = Buffers::new(&document, &folders, container.bin, options);
    let quantized = extensions.iter().any(|e| e.name == "KHR_mesh_quantization");
    let accessors = Accessors { document: &document, buffers: &buffers, quantized };

    let Motion { poses, edits } = match &options.animation {
        Some(moment) => animation::motion(&accessors, moment, &mut warnings)?,
        None => Motion::default(),
    };
    let moved = match edits.is_empty() {
        true => None,
        false => Some(document::parse(&pointers::apply(text, edits, &mut warnings)?)?),
    };
    let document = moved.as_ref().unwrap_or(&document);
    let accessors = Accessors { document, ..accessors };
    let sources = Sources { document, buffers: &buffers, folders: &folders, options };
    let placed = nodes::place(document, options.scene, &poses, &mut warnings)?;
    let mut scene = Scene {
        name: path.file_stem().unwrap_or_default().to_string_lossy().into_owned(),
        extensions,
        cameras: cameras::read(document, &placed, &mut warnings)?,
        lights: lights::read(document, &placed, &mut warnings),
        environment: image_based_light::read(sources, options.scene, &mut warnings),
        ..Scene::default()
    };
    shapes::read(&mut scene, &accessors, sources, &placed, &poses, &mut warnings)?;
    scene.warnings = warnings.into_texts();
    Ok(scene)
}

fn check_version(document: &Document) -> Result<()> {
    let asset = &document.asset;
    let needed = asset.min_version.as_deref().unwrap_or(&asset.version);
    let major = needed.split('.').next();
    let supported = match &asset.min_version {
        // A later 2.x may be read when the file says that 2.0 is enough.
        Some(min) => min == "2.0",
        None => major == Some("2"),
    };
    if supported {
        return Ok(());
    }
    Err(Fault::Format(format!("it needs glTF version {}, and only 2.0 is supported", uri::shown(needed))))
}
