//! Estimators compared with one another on any scene, by the verdict of `surelight compare`.

use surelight_estimate::sidak_level;
use surelight_film::compare::{CompareOptions, Outcome, Picture, Verdict, compare};
use surelight_film::{Film, Metadata, read_exr, write_exr};
use surelight_prepare::{Directions, Integrator, Prepared, Settings};
use surelight_render::{Position, Renderer, sample_batches};
use surelight_scene::{Camera, Material, Scene};

use crate::render::{ALPHA, device};

/// Batches of a picture.
const BATCHES: u32 = 16;

/// Results of the comparisons.
#[derive(Debug, Default)]
pub struct Tally {
    /// Comparisons that a difference would have shown in.
    pub reported: usize,
    /// Comparisons without a verdict.
    pub open: usize,
    /// A sentence for each that differs.
    pub failures: Vec<String>,
}

/// Renders a scene by every unbiased estimator and compares the pictures: `mis` with `area`, and
/// with `hemisphere` where no light is without extent. `of`: comparisons in all, for Šidák's level;
/// `side`: pixels of the longer side; `samples` of a batch.
pub fn compare_estimators(name: &str, scene: &Scene, side: u32, samples: u32, of: usize, tally: &mut Tally) {
    let camera = scene.cameras.first().cloned().unwrap_or_else(|| scene.frame_camera(1.0));
    let folder = tempfile::tempdir().expect("a folder for pictures");
    let path = folder.path().join("picture.exr");
    let mut integrators = vec![Integrator::Mis];
    if scene.materials.iter().any(is_nearly_smooth) {
        println!("{name}: without area, which hits narrow lobes one time in millions");
    } else {
        integrators.push(Integrator::Area);
    }
    if scene.lights.is_empty() {
        integrators.push(Integrator::Hemisphere(Directions::Bsdf));
    }
    let images: Vec<_> = integrators
        .iter()
        .zip(1..)
        .map(|(&integrator, seed)| {
            let film = picture(scene, &camera, integrator, seed, side, samples);
            write_exr(&path, &film, &Metadata { batches: BATCHES, ..Metadata::default() }).expect("it can be written");
            read_exr(&path).expect("it can be read")
        })
        .collect();
    let [mis, others @ ..] = &images[..] else { unreachable!("there are several integrators") };
    for (integrator, image) in integrators[1..].iter().zip(others) {
        let [a, b] = [image, mis].map(|image| Picture::of(image, None).expect("a picture"));
        let options = CompareOptions { alpha: sidak_level(ALPHA, of), ..CompareOptions::default() };
        let comparison = compare(&a, &b, &options).expect("they can be compared");
        let verdict: Verdict = comparison.verdict.expect("both have error estimates");
        let text = format!(
            "{name}: {integrator:?} − mis {:+.2} % ± {:.2} %, {:?}, {:.1} % would be detected",
            100.0 * comparison.metrics.mean_relative,
            100.0 * comparison.metrics.mean_relative_error,
            verdict.outcome,
            100.0 * verdict.detectable,
        );
        println!("{text}");
        match verdict.outcome {
            Outcome::Same => tally.reported += 1,
            Outcome::CannotTell => tally.open += 1,
            Outcome::Differ => tally.failures.push(text),
        }
    }
}

/// Whether a lobe is no delta, but so narrow that a sampled point on a light rarely falls into it.
fn is_nearly_smooth(m: &Material) -> bool {
    const NARROW: std::ops::Range<f32> = 0.0101..0.2;
    NARROW.contains(&m.roughness) || m.clearcoat.factor > 0.0 && NARROW.contains(&m.clearcoat.roughness)
}

fn picture(scene: &Scene, camera: &Camera, integrator: Integrator, seed: u32, side: u32, samples: u32) -> Film {
    let settings = Settings { integrator, seed, ..Settings::new(side, side) };
    let prepared = Prepared::new(scene, camera, &settings).unwrap_or_else(|e| panic!("{}: {e}", scene.name));
    let mut renderer = Renderer::new(device(), &prepared).unwrap_or_else(|e| panic!("{}: {e}", scene.name));
    let mut film = Film::new(side, side);
    sample_batches(&mut renderer, &mut film, Position::default(), BATCHES, samples)
        .unwrap_or_else(|e| panic!("{}: {e}", scene.name));
    film
}
