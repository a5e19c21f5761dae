//! A finished image as the beginning of a longer render.

use std::path::Path;

use rayon::prelude::*;

use crate::exr::{ExrImage, read_exr};
use crate::{DoubleDouble, Film, Metadata, PixelMoments, ReadError, Window, read_part, read_part_header};

/// Reads the film of a finished render, to which more samples can be added.
///
/// A part comes back bit for bit ([`read_part`]). Of other images, mean, variance, number of
/// samples and tail come back as the file rounds them, to 24 bits; error bars of the extended
/// render hold.
///
/// # Errors
/// Where the file is missing, damaged, not a render of Surelight from its first sample on, or has
/// settings in another format.
pub fn read_finished(path: &Path) -> Result<(Film, Metadata), ReadError> {
    if read_part_header(path).is_ok() {
        return read_part(path);
    }
    let image = read_exr(path)?;
    rebuild(&image).map_err(|cause| ReadError::new(path, cause))
}

fn rebuild(image: &ExrImage) -> Result<(Film, Metadata), String> {
    let metadata = image.surelight_metadata().ok_or("it is no render of Surelight")?;
    metadata.check_settings()?;
    let incomplete = || "it lacks layers that a render of this version has".to_owned();
    let channel = |name: &str| image.channels.get(name).ok_or_else(incomplete);
    let mean = image.rgb("").ok_or_else(incomplete)?;
    let variance = image.rgb("Variance");
    let (samples, largest, squares) = (channel("Samples.N")?, channel("Tail.Max")?, channel("Tail.Squares")?);
    let size = [image.width as u32, image.height as u32];
    let whole = metadata.settings.as_ref().map_or(size, |settings| settings.size);
    let edges = metadata.crop.unwrap_or([0, 0, size[0], size[1]]);
    let window = Window::crop(whole, edges).filter(|window| window.size == size);
    let window = window.ok_or("it is damaged: its size is not that of its metadata")?;
    let batches = f64::from(metadata.batches);
    let pixel = |i: usize| {
        let variance = variance.map(|v| v.map(|v| v[i])).filter(|v| v.iter().all(|v| v.is_finite() && *v >= 0.0));
        let (n, mean) = (samples[i], mean.map(|m| m[i]));
        let sound = (0.0..=f32::from(u16::MAX) * 65_536.0).contains(&n) && mean.iter().all(|m| m.is_finite());
        sound.then(|| PixelMoments::from_estimate(n as u64, batches, mean, variance, [largest[i], squares[i]]))
    };
    let pixels: Option<Vec<PixelMoments>> = (0..samples.len()).into_par_iter().map(pixel).collect();
    let pixels = pixels.ok_or("it is damaged: some of its pixels are no numbers")?;
    let coverage = metadata.is_transparent().then(|| channel("A")).transpose()?;
    let covered = |(alpha, &n): (&f32, &f32)| DoubleDouble { hi: f64::from(*alpha) * f64::from(n), lo: 0.0 };
    let coverage = coverage.map(|alpha| alpha.iter().zip(samples).map(covered).collect());
    Ok((Film::from_pixels(window, pixels, coverage), metadata))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{BatchSum, RenderSettings, write_exr};

    fn film(batches: std::ops::Range<u32>) -> Film {
        let mut film = Film::of_window(Window::crop([5, 4], [1, 1, 4, 3]).unwrap());
        for batch in batches {
            let noise = f32::from(((batch * 7919) % 31) as u8) / 31.0;
            let sums: Vec<_> =
                (0..6).map(|i| BatchSum::new([4.0 + noise, i as f32, 0.0], 3.0 + noise, 7.0 + noise)).collect();
            film.add_batch(4, &[0, 1, 2, 3, 4, 5], &sums).unwrap();
        }
        film
    }

    fn metadata(film: &Film) -> Metadata {
        let batches = film.degrees_of_freedom(0).round() as u32 + 1;
        let settings = RenderSettings { size: [5, 4], ..RenderSettings::default() };
        let crop = Some([1, 1, 4, 3]);
        Metadata { batches, sample_range: [0, 64], crop, settings: Some(settings), ..Metadata::default() }
    }

    #[test]
    fn a_finished_image_can_be_extended() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("image.exr");
        let first = film(0..16);
        write_exr(&path, &first, &metadata(&first)).unwrap();
        let (mut extended, read) = read_finished(&path).unwrap();
        assert_eq!(read, metadata(&first));
        // Written again, its picture and statistics are the same; tails are rounded.
        let again = folder.path().join("again.exr");
        write_exr(&again, &extended, &read).unwrap();
        let [before, after] = [&path, &again].map(|path| read_exr(path).unwrap());
        for name in ["R", "G", "B", "Samples.N", "Tail.Max", "Tail.Squares"] {
            assert_eq!(before.channels[name], after.channels[name], "{name}");
        }
        extended.merge(&film(16..48)).unwrap();
        let direct = film(0..48);
        for i in 0..6 {
            let (found, expected) = (extended.mean(i)[0], direct.mean(i)[0]);
            assert!((found / expected - 1.0).abs() < 1e-7, "{found} {expected}");
            let [found, expected] = [&extended, &direct].map(|film| film.variance_of_mean(i).unwrap()[0]);
            assert!((found / expected - 1.0).abs() < 0.05, "{found} {expected}");
        }
        assert_eq!(extended.certify().certified, direct.certify().certified);
    }

    #[test]
    fn other_files_are_refused() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("image.exr");
        assert!(read_finished(&path).is_err());
        let first = film(0..16);
        write_exr(&path, &first, &Metadata { crop: Some([0, 0, 2, 2]), ..metadata(&first) }).unwrap();
        assert!(read_finished(&path).unwrap_err().to_string().contains("its size"));
        let mut image = ExrImage { width: 1, height: 1, ..ExrImage::default() };
        assert!(rebuild(&image).unwrap_err().contains("no render of Surelight"));
        image.metadata = Some("{}".into());
        assert!(rebuild(&image).unwrap_err().contains("lacks layers"));
        image.metadata = Some("{\"settings\":{\"width\":1}}".into());
        assert!(rebuild(&image).unwrap_err().contains("an older version of Surelight"));
        image.metadata = Some("{}".into());
        for name in ["R", "G", "B", "Samples.N", "Tail.Max", "Tail.Squares"] {
            image.channels.insert(name.into(), vec![f32::NAN]);
        }
        assert!(rebuild(&image).unwrap_err().contains("no numbers"));
    }
}
