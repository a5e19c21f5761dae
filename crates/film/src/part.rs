//! Parts of a render: films that can be continued, or joined, without losing a bit.

use std::io::Cursor;
use std::path::Path;

use ::exr::prelude::{FlatSamples, MetaData, ReadChannels, ReadLayers, Vec2};
use rayon::prelude::*;

use crate::error::io_cause;
use crate::exr::{attribute_text, cause_of, check_claim, to_floats};
use crate::moments::WORDS;
use crate::words::{COVERAGE_WORDS, checksum, coverage_of_words, word_name};
use crate::{Features, Film, Metadata, PixelMoments, ReadError, Window};

/// Values (pixels times channels) beyond which a file is refused: 16 GiB, 60 million pixels.
const MAX_VALUES: u64 = 1 << 32;

const NO_PART: &str = "it is no part of a render (--samples, --crop with --spp, and checkpoints make these)";

/// Reads the metadata and the position of a part, without its pixels.
///
/// # Errors
/// Where the file is missing, damaged, no part of a render, or has settings in another format.
pub fn read_part_header(path: &Path) -> Result<(Metadata, Window), ReadError> {
    let fail = |cause: String| ReadError::new(path, cause);
    let file = std::fs::File::open(path).map_err(|error| fail(io_cause(&error)))?;
    let meta = MetaData::read_from_buffered(std::io::BufReader::new(file), false).map_err(|e| fail(cause_of(e)))?;
    let header = meta.headers.first().ok_or_else(|| fail(NO_PART.into()))?;
    let json = attribute_text(&header.own_attributes.other);
    let corner = header.own_attributes.layer_position;
    let size = [header.layer_size.width(), header.layer_size.height()];
    judge_header(json.as_deref(), [corner.x(), corner.y()], size).map_err(fail)
}

/// The metadata of the attribute, if it agrees with the file's data window.
fn judge_header(json: Option<&str>, corner: [i32; 2], size: [usize; 2]) -> Result<(Metadata, Window), String> {
    let metadata: Metadata = serde_json::from_str(json.ok_or(NO_PART)?)
        .map_err(|_| "it is damaged: its metadata cannot be read".to_owned())?;
    let whole = metadata.part.as_ref().ok_or(NO_PART)?.size;
    metadata.check_settings()?;
    let edges = metadata.crop.unwrap_or([0, 0, whole[0], whole[1]]);
    let damaged = || "it is damaged: its attribute and its data window name different pixels".to_owned();
    let window = Window::crop(whole, edges).ok_or_else(damaged)?;
    let agrees = window.corner.map(i64::from) == corner.map(i64::from) && window.size.map(|x| x as usize) == size;
    let [first, end] = metadata.sample_range;
    if agrees && first <= end { Ok((metadata, window)) } else { Err(damaged()) }
}

/// Reads a part of a render, every bit of it.
///
/// # Errors
/// Where the file is missing, damaged, no part of a render, or has settings in another format.
pub fn read_part(path: &Path) -> Result<(Film, Metadata), ReadError> {
    let fail = |cause: String| ReadError::new(path, cause);
    let bytes = std::fs::read(path).map_err(|error| fail(io_cause(&error)))?;
    decode_part(&bytes).map_err(fail)
}

pub(crate) fn decode_part(bytes: &[u8]) -> Result<(Film, Metadata), String> {
    check_claim(bytes, MAX_VALUES)?;
    let file = ::exr::prelude::read()
        .no_deep_data()
        .largest_resolution_level()
        .all_channels()
        .first_valid_layer()
        .all_attributes()
        .from_buffered(Cursor::new(bytes))
        .map_err(cause_of)?;
    let layer = file.layer_data;
    let json = attribute_text(&layer.attributes.other);
    let corner = layer.attributes.layer_position;
    let (metadata, window) =
        judge_header(json.as_deref(), [corner.x(), corner.y()], [layer.size.width(), layer.size.height()])?;

    let mut channels = layer.channel_data.list;
    let mut take = |name: &str| {
        let at = channels.iter().position(|channel| channel.name.eq(name) && channel.sampling == Vec2(1, 1))?;
        Some(channels.remove(at).sample_data)
    };
    let mut words_of = |range: std::ops::Range<usize>| {
        let planes = range.map(|word| match take(&word_name(word)) {
            Some(FlatSamples::U32(values)) => Ok(values),
            _ => Err(format!("it is damaged: the channel {} is missing", word_name(word))),
        });
        planes.collect::<Result<Vec<Vec<u32>>, String>>()
    };
    let words = words_of(0..WORDS)?;
    let count = window.area() as usize;
    let coverage = match metadata.is_transparent() {
        true => {
            let words = words_of(WORDS..WORDS + COVERAGE_WORDS)?;
            let sum = |i: usize| coverage_of_words(std::array::from_fn(|word| words[word][i]));
            Some((0..count).map(sum).collect())
        }
        false => None,
    };
    let pixels: Vec<_> = (0..count).into_par_iter().map(|i| PixelMoments::from_words(|word| words[word][i])).collect();
    drop(words);
    let mut film = Film::from_pixels(window, pixels, coverage);
    if metadata.part.as_ref().is_none_or(|part| part.checksum != checksum(&film, metadata.sample_range)) {
        let version = env!("CARGO_PKG_VERSION");
        return Err(match metadata.version == version {
            true => "it is damaged: its totals are not those that were written".into(),
            false => format!(
                "it is of another version of Surelight, {:?}, whose totals this one, {version:?}, cannot check",
                metadata.version
            ),
        });
    }
    let mut plane = |name: &str| take(name).map(to_floats);
    let triple = |planes: [Option<Vec<f32>>; 3]| match planes {
        [Some(x), Some(y), Some(z)] => Some(x.into_iter().zip(y).zip(z).map(|((x, y), z)| [x, y, z]).collect()),
        _ => None,
    };
    let albedo = triple(["Albedo.R", "Albedo.G", "Albedo.B"].map(&mut plane));
    let normal = triple(["N.X", "N.Y", "N.Z"].map(&mut plane));
    if let (Some(albedo), Some(normal), Some(depth)) = (albedo, normal, plane("Depth.Z")) {
        film.set_features(Features { albedo, normal, depth }).map_err(|error| error.to_string())?;
    }
    Ok((film, metadata))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{BatchSum, RenderPart, encode_exr};

    fn part(window: Window) -> (Film, Metadata) {
        let mut film = Film::of_window(window);
        let count = window.area() as u32;
        let lanes: Vec<u32> = (0..count).collect();
        for batch in 1..6u32 {
            let sums: Vec<_> = (0..count)
                .map(|i| BatchSum::new([0.1 * batch as f32, 1e-20 * i as f32, 3e9], 7.0 * i as f32, 0.3))
                .collect();
            film.add_batch(batch, &lanes, &sums).unwrap();
        }
        let normal = vec![[0.6, -0.0, 0.8]; count as usize];
        let depth = (0..count).map(|i| i as f32).collect();
        film.set_features(Features { albedo: vec![[0.1, 0.2, 0.3]; count as usize], normal, depth }).unwrap();
        let metadata = Metadata {
            sample_range: [0, 15],
            crop: (!window.is_all()).then(|| window.edges()),
            part: Some(RenderPart { size: window.whole, planned_samples: Some(64), ..RenderPart::default() }),
            ..Metadata::default()
        };
        (film, metadata)
    }

    #[test]
    fn parts_come_back_bit_for_bit() {
        for window in [Window::all(5, 3), Window::crop([9, 70], [2, 3, 7, 41]).unwrap()] {
            let (film, metadata) = part(window);
            let (back, header) = decode_part(&encode_exr(&film, &metadata).unwrap()).unwrap();
            assert_eq!(back.window(), window);
            assert!(back.pixels() == film.pixels() && back.features() == film.features());
            let checksum = checksum(&film, [0, 15]);
            assert_eq!(header, Metadata { part: Some(RenderPart { checksum, ..metadata.part.unwrap() }), ..metadata });
        }
    }

    #[test]
    fn the_header_alone_states_place_and_samples() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("part.exr");
        let window = Window::crop([9, 70], [2, 3, 7, 41]).unwrap();
        let (film, metadata) = part(window);
        crate::write_exr(&path, &film, &metadata).unwrap();
        let (header, place) = read_part_header(&path).unwrap();
        assert_eq!((place, header.sample_range, header.crop), (window, [0, 15], Some([2, 3, 7, 41])));
    }

    #[test]
    fn a_finished_picture_is_no_part() {
        let (film, metadata) = part(Window::all(2, 2));
        let bytes = encode_exr(&film, &Metadata { part: None, ..metadata }).unwrap();
        assert_eq!(decode_part(&bytes).unwrap_err(), NO_PART);
    }

    #[test]
    fn parts_of_other_versions_and_damage_are_distinguished() {
        let (film, metadata) = part(Window::all(2, 2));
        for (version, words) in [("0.0.1", "it is of another version"), (env!("CARGO_PKG_VERSION"), "it is damaged")] {
            let metadata = Metadata { version: version.into(), ..metadata.clone() };
            let mut bytes = encode_exr(&film, &metadata).unwrap();
            let checksum = checksum(&film, [0, 15]);
            let at = bytes.windows(checksum.len()).position(|text| text == checksum.as_bytes()).unwrap();
            bytes[at..at + checksum.len()].fill(b'x');
            let cause = decode_part(&bytes).unwrap_err();
            assert!(cause.contains(words), "{cause}");
        }
    }

    #[test]
    fn settings_of_another_version_are_refused() {
        let header = |settings: &str| {
            let json = format!("{{\"settings\":{settings},\"part\":{{\"size\":[2,2]}}}}");
            judge_header(Some(&json), [0, 0], [2, 2])
        };
        assert!(header("{\"version\":1}").is_ok());
        assert!(header("{\"width\":2,\"sampler\":\"sobol\"}").unwrap_err().contains("an older version of Surelight"));
        assert!(header("{\"version\":2}").unwrap_err().contains("have version 2"));
        assert!(header("{\"version\":1,\"sampler\":2}").unwrap_err().contains("damaged"));
    }

    /// Any damage is reported, or has no effect on the result.
    #[test]
    fn damage_is_found() {
        let (film, metadata) = part(Window::crop([9, 9], [1, 1, 8, 9]).unwrap());
        let whole = encode_exr(&film, &metadata).unwrap();
        for length in (0..whole.len()).step_by(97) {
            assert!(decode_part(&whole[..length]).is_err(), "{length}");
        }
        let mut found = 0;
        for at in (0..whole.len()).step_by(13) {
            let mut bytes = whole.clone();
            bytes[at] ^= 0x10;
            match decode_part(&bytes) {
                Ok((back, _)) => assert!(back.pixels() == film.pixels() && back.window() == film.window(), "{at}"),
                Err(_) => found += 1,
            }
        }
        assert!(found > 50, "{found}");
    }
}
