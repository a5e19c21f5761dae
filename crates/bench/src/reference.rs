//! The reference: a long render by the best method without bias, or an image that is given.

use std::path::Path;

use surelight_film::{Film, Metadata, read_exr, write_exr};
use surelight_prepare::Settings;
use surelight_render::{RenderError, Renderer};

use crate::{
    data::{Clock, ReferenceData},
    error::BenchError,
    measure::Reference,
    tracer::Run,
};

/// The stream of batches of its samples; repeats have the later streams.
const STREAM: u32 = 0;

/// Its number of batches: enough to estimate the variance of each pixel to a fifth.
const BATCHES: u32 = 64;

/// A reference and its data.
pub(crate) struct Made {
    pub(crate) reference: Reference,
    pub(crate) data: ReferenceData,
    pub(crate) film: Option<Film>,
}

/// Renders it with `samples` samples per pixel; `None` where `go_on` stopped it.
pub(crate) fn render(
    renderer: &mut Renderer<'_>,
    settings: &Settings,
    method: &str,
    samples: u32,
    clock: Clock,
    go_on: &mut dyn FnMut(u32) -> bool,
) -> Result<Option<Made>, RenderError> {
    let mut run = Run::new(settings, STREAM, renderer);
    let length = length(samples);
    let batches = (samples / length).max(2);
    // In parts, so that progress can be reported.
    for part in 1..=batches {
        let done = run.spp();
        if !run.grow_to(renderer, part * length, Some(length), &mut || go_on(done))? {
            return Ok(None);
        }
    }
    let reference = Reference::of(&run.film);
    let data = ReferenceData {
        source: method.to_owned(),
        spp: run.spp().into(),
        seconds: run.seconds(clock),
        uncertified: Some(1.0 - run.film.certify().share()),
        ..data_of(&reference)
    };
    Ok(Some(Made { reference, data, film: Some(run.film) }))
}

/// Samples of each batch.
fn length(samples: u32) -> u32 {
    match samples / BATCHES {
        0 => 1,
        share => (1 << share.ilog2()).min(4096),
    }
}

/// The errors of a reference by its own variance.
fn data_of(reference: &Reference) -> ReferenceData {
    let own = reference.own_error();
    ReferenceData { mean: own.mean, mean_se: own.mean_se, rel_mse: own.rel_mse, ..ReferenceData::default() }
}

/// Writes a rendered reference, so that a race can be resumed.
pub(crate) fn save(path: &Path, film: &Film, data: &ReferenceData, hash: &str) -> Result<(), BenchError> {
    let metadata = Metadata {
        version: env!("CARGO_PKG_VERSION").into(),
        scene_hash: hash.into(),
        sample_range: [0, data.spp],
        batches: film.degrees_of_freedom(0).round() as u32 + 1,
        ..Metadata::default()
    };
    Ok(write_exr(path, film, &metadata)?)
}

/// Reads one. Its variance is that of the file's layer, where the layer can be used.
pub(crate) fn load(path: &Path, size: [u32; 2]) -> Result<Made, BenchError> {
    let image = read_exr(path)?;
    let wrong = |cause: String| BenchError::Reference { path: path.into(), cause };
    if [image.width, image.height] != size.map(|n| n as usize) {
        return Err(wrong(format!(
            "it has {}x{} pixels, and {}x{} are rendered (--size sets the size)",
            image.width, image.height, size[0], size[1]
        )));
    }
    let rgb = image.rgb("").ok_or_else(|| wrong("it has no R, G, B channels".into()))?.map(<[f32]>::to_vec);
    let metadata = image.surelight_metadata();
    let trusted = metadata.as_ref().is_some_and(|m| m.batches >= 2);
    let variance = image.rgb("Variance").filter(|_| trusted).map(|planes| planes.map(<[f32]>::to_vec));
    let reuses_paths = metadata.as_ref().is_some_and(Metadata::reuses_paths);
    let reference = Reference { width: image.width, height: image.height, rgb, variance, reuses_paths };
    if reference.mean() <= 0.0 {
        return Err(wrong("it is black, or holds no finite value".into()));
    }
    let data = ReferenceData {
        source: path.display().to_string(),
        spp: metadata.map_or(0, |m| m.sample_range[1]),
        ..data_of(&reference)
    };
    Ok(Made { reference, data, film: None })
}

#[cfg(test)]
mod tests {
    use surelight_film::BatchSum;

    use super::*;

    #[test]
    fn batches_are_equal_and_many() {
        assert_eq!([1, 64, 127, 128, 1 << 20].map(length), [1, 1, 1, 2, 4096]);
    }

    #[test]
    fn what_was_saved_is_read_again() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("reference.exr");
        let mut film = Film::new(2, 1);
        for batch in [1.0f32, 2.0, 3.0, 4.0] {
            film.add_batch(8, &[0, 1], &[BatchSum::constant(8, [batch; 3]), BatchSum::constant(8, [1.0; 3])]).unwrap();
        }
        let reference = Reference::of(&film);
        let data = ReferenceData { spp: 32, ..data_of(&reference) };
        save(&path, &film, &data, "abc").unwrap();
        let again = load(&path, [2, 1]).unwrap();
        assert_eq!(again.reference.rgb, reference.rgb);
        assert_eq!(again.reference.variance, reference.variance);
        assert_eq!((again.data.spp, again.data.mean_se), (32, data.mean_se));
        assert!(load(&path, [1, 2]).err().unwrap().to_string().contains("2x1 pixels"));
    }
}
