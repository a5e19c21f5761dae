//! `surelight info`: the contents of a scene, the kernel parts that it needs, and unsupported
//! features.

mod contents;

use std::fmt::{self, Display};

use serde::Serialize;
use surelight_prepare::{Origin, Prepared, Row, Settings, TABLE};
use surelight_scene::Scene;

use crate::error::Error;
use crate::options::{CameraArgs, InfoArgs, LightArgs};
use crate::{camera, console, light};

use contents::Contents;

/// The contents of a scene; its fields are the keys of `--json`.
#[derive(Debug, Serialize)]
struct Info {
    /// The file as it was given.
    scene: String,
    #[serde(flatten)]
    contents: Contents,
    /// The triangles of the kernel.
    bvh: Bvh,
    /// Parts that the kernel may have.
    kernel: Vec<KernelPart>,
    /// Everything that was not read as written.
    warnings: Vec<String>,
}

/// A part that the kernel has or lacks because of the scene.
#[derive(Debug, Serialize)]
struct KernelPart {
    /// Name of the condition in the shaders.
    name: &'static str,
    /// Whether it is compiled in.
    included: bool,
    /// Its effect.
    meaning: &'static str,
    /// The elements of the scene that need it.
    because: Option<String>,
}

/// Loads the scene and reports its contents. No device is needed.
pub(crate) fn run(args: &InfoArgs) -> Result<(), Error> {
    let options = args.file.load_options();
    let scene = args.scene.load(&options)?;
    let info = describe(args, scene)?;
    let text = if args.json {
        serde_json::to_string_pretty(&info).map_err(|e| Error::Print(e.into()))? + "\n"
    } else {
        info.to_string()
    };
    console::result(&text)
}

fn describe(args: &InfoArgs, mut scene: Scene) -> Result<Info, Error> {
    // As `render` would with no other options: the kernel follows from it.
    let contents = Contents::of(&scene);
    let camera = CameraArgs::default();
    let view = camera::choose(&scene, args.scene.name(), &camera, None)?;
    let note = light::set(&mut scene, &LightArgs::default())?;
    let settings = Settings {
        integrator: args.method.integrator(),
        sampler: args.method.sampler(),
        ..Settings::new(view.size.width, view.size.height)
    };
    let unfound = args.method.warning(&scene);
    let prepared = Prepared::new(&scene, &view.camera, &settings)?;
    let key = prepared.key();
    // The absence of parts that options or the device select is no property of the scene.
    let is_relevant = |row: &Row| key.has(row.part) || matches!(row.origin, Origin::Scene(_) | Origin::Derived);
    let kernel = TABLE
        .iter()
        .filter(|row| is_relevant(row))
        .map(|row| {
            let included = key.has(row.part);
            let because = match row.origin {
                Origin::Scene(reason) if included => reason(&scene),
                _ => None,
            };
            KernelPart { name: row.name, included, meaning: row.meaning, because }
        })
        .collect();
    let mut warnings = scene.warnings;
    warnings.extend(camera::clipping_warning(&view.camera, prepared.cut));
    warnings.extend(view.note);
    warnings.extend(note);
    warnings.extend(unfound);
    warnings.extend(prepared.unreachable.iter().map(ToString::to_string));
    Ok(Info { scene: args.scene.name().display().to_string(), contents, bvh: Bvh::of(&prepared), kernel, warnings })
}

/// Counts of triangles.
#[derive(Debug, Serialize)]
struct Bvh {
    /// Nodes, triangles and instances of the kernel's stream.
    items: usize,
    /// Entries of the traversal stack.
    stack_depth: u32,
    /// Left out: corners that are not finite.
    non_finite_triangles: u64,
    /// Left out: no area.
    zero_area_triangles: u64,
}

impl Bvh {
    fn of(prepared: &Prepared) -> Self {
        let accel = &prepared.accel;
        Self {
            items: accel.items.len(),
            stack_depth: accel.stack_depth,
            non_finite_triangles: accel.skipped.non_finite,
            zero_area_triangles: accel.skipped.zero_area,
        }
    }
}

impl Display for Info {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        writeln!(f, "{}", self.scene)?;
        write!(f, "{}", self.contents)?;
        let bvh = &self.bvh;
        write!(f, "BVH         {} items, {} KiB", bvh.items, bvh.items.div_ceil(16))?;
        match bvh.non_finite_triangles + bvh.zero_area_triangles {
            0 => writeln!(f)?,
            _ => writeln!(
                f,
                "; left out: {} triangles that are not finite, {} without area",
                bvh.non_finite_triangles, bvh.zero_area_triangles
            )?,
        }
        writeln!(f, "\nThe kernel for it has")?;
        for part in self.kernel.iter().filter(|part| part.included) {
            write!(f, "  {:<27} {}", part.name, part.meaning.trim_end_matches('.'))?;
            match &part.because {
                Some(because) => writeln!(f, " ({because})")?,
                None => writeln!(f)?,
            }
        }
        let absent: Vec<_> = self.kernel.iter().filter(|part| !part.included).map(|part| part.name).collect();
        if !absent.is_empty() {
            writeln!(f, "and does without\n  {}", absent.join(", "))?;
        }
        if self.warnings.is_empty() {
            writeln!(f, "\nEverything in the file is supported.")
        } else {
            writeln!(f, "\nNot as written in the file")?;
            self.warnings.iter().try_for_each(|warning| writeln!(f, "  {warning}"))
        }
    }
}
