//! OpenEXR: the layers of a film, and any flat EXR read back by channel name.

mod write;

use std::collections::{BTreeMap, HashMap};
use std::io::Cursor;
use std::path::Path;

use ::exr::prelude::{AttributeValue, FlatSamples, MetaData, ReadChannels, ReadLayers, Text};

use crate::error::io_cause;
use crate::words::PREFIX;
use crate::{Metadata, ReadError};

pub use write::{encode_exr, write_exr};

/// Name of the text attribute that carries [`Metadata`] as JSON.
const ATTRIBUTE: &str = "surelight";

/// Values (pixels times channels) beyond which a file is refused: 4 GiB of floats.
const MAX_VALUES: u64 = 1 << 30;

/// No compression of the format shrinks further than this; a header that states more is wrong, and
/// would cost memory before the error is found.
const MAX_EXPANSION: u64 = 1 << 14;

/// An EXR in memory: channels as 32-bit floats under their full names, row 0 at the top.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct ExrImage {
    /// Pixels a row of the data window.
    pub width: usize,
    /// Rows of the data window.
    pub height: usize,
    /// Position of the data window's first pixel.
    pub position: [i32; 2],
    /// Channels by name. In a file of several named parts the name is `part.channel`.
    pub channels: BTreeMap<String, Vec<f32>>,
    /// The JSON of the `surelight` attribute, where there is one.
    pub metadata: Option<String>,
}

impl ExrImage {
    /// The three channels of a layer, as `[red, green, blue]` slices.
    ///
    /// An empty `layer` means the picture itself: `R G B`, else the one beauty pass that other
    /// renderers name differently (Blender `….Combined.R`, one colour layer alone in the file),
    /// else `Y` thrice. A layer is found by its name or as the last part of a longer name
    /// (`ViewLayer.Albedo` for `Albedo`), where only one matches.
    pub fn rgb(&self, layer: &str) -> Option<[&[f32]; 3]> {
        if layer.is_empty() {
            return self
                .triple("")
                .or_else(|| self.triple(&self.only_prefix(|name| name.ends_with("Combined."))?))
                .or_else(|| self.triple(&self.only_prefix(|_| true)?))
                .or_else(|| self.channels.get("Y").map(|y| [y.as_slice(); 3]));
        }
        let exact = format!("{layer}.");
        let nested = format!(".{layer}.");
        self.triple(&exact).or_else(|| self.triple(&self.only_prefix(|name| name.ends_with(&nested))?))
    }

    /// The only prefix of an R, G, B triple that satisfies `wanted`.
    fn only_prefix(&self, wanted: impl Fn(&str) -> bool) -> Option<String> {
        let mut prefixes = self
            .channels
            .keys()
            .filter_map(|name| name.strip_suffix('R'))
            .filter(|prefix| wanted(prefix) && self.triple(prefix).is_some());
        match (prefixes.next(), prefixes.next()) {
            (Some(prefix), None) => Some(prefix.to_owned()),
            _ => None,
        }
    }

    fn triple(&self, prefix: &str) -> Option<[&[f32]; 3]> {
        let channel = |name: char| self.channels.get(&format!("{prefix}{name}")).map(Vec::as_slice);
        Some([channel('R')?, channel('G')?, channel('B')?])
    }

    /// The metadata that Surelight wrote; `None` for files of other programs.
    pub fn surelight_metadata(&self) -> Option<Metadata> {
        serde_json::from_str(self.metadata.as_deref()?).ok()
    }
}

/// Reads a flat EXR of any program: full resolution, all channels of all parts, as 32-bit floats.
///
/// # Errors
/// Where the file is missing, damaged, deep, subsampled, larger than 2³⁰ values, or made of parts
/// of different sizes.
pub fn read_exr(path: &Path) -> Result<ExrImage, ReadError> {
    let fail = |cause: String| ReadError::new(path, cause);
    let bytes = std::fs::read(path).map_err(|error| fail(io_cause(&error)))?;
    decode(&bytes).map_err(fail)
}

/// Size, place and metadata of a flat EXR of any program, without its channels.
///
/// # Errors
/// Where the file is missing or damaged.
pub fn read_exr_header(path: &Path) -> Result<ExrImage, ReadError> {
    let fail = |cause: String| ReadError::new(path, cause);
    let file = std::fs::File::open(path).map_err(|error| fail(io_cause(&error)))?;
    let meta = MetaData::read_from_buffered(std::io::BufReader::new(file), false).map_err(|e| fail(cause_of(e)))?;
    let first = meta.headers.first().ok_or_else(|| fail("it has no picture in it".into()))?;
    let attributes = meta.headers.iter().flat_map(|h| [&h.own_attributes.other, &h.shared_attributes.other]);
    Ok(ExrImage {
        width: first.layer_size.width(),
        height: first.layer_size.height(),
        position: [first.own_attributes.layer_position.x(), first.own_attributes.layer_position.y()],
        metadata: attributes.into_iter().find_map(attribute_text),
        ..ExrImage::default()
    })
}

fn decode(bytes: &[u8]) -> Result<ExrImage, String> {
    check_claim(bytes, MAX_VALUES)?;
    let file = ::exr::prelude::read()
        .no_deep_data()
        .largest_resolution_level()
        .all_channels()
        .all_layers()
        .all_attributes()
        .from_buffered(Cursor::new(bytes))
        .map_err(cause_of)?;
    let parts = file.layer_data;
    let first = parts.first().ok_or("it has no picture in it")?;
    let mut image = ExrImage {
        width: first.size.width(),
        height: first.size.height(),
        position: [first.attributes.layer_position.x(), first.attributes.layer_position.y()],
        ..ExrImage::default()
    };
    image.metadata =
        parts.iter().map(|part| &part.attributes.other).chain([&file.attributes.other]).find_map(attribute_text);
    let (size, position, several) = (first.size, first.attributes.layer_position, parts.len() > 1);
    for part in parts {
        if (part.size, part.attributes.layer_position) != (size, position) {
            return Err("its parts differ in size or place".into());
        }
        let prefix = match &part.attributes.layer_name {
            Some(name) if several => format!("{}.", decode_text(name)),
            _ => String::new(),
        };
        for channel in part.channel_data.list {
            if channel.sampling.0 != 1 || channel.sampling.1 != 1 {
                return Err(format!("its channel \"{}\" is subsampled", channel.name));
            }
            let name = prefix.clone() + &decode_text(&channel.name);
            if name.starts_with(PREFIX) {
                continue; // of a part of a render: no floats
            }
            // Parts may repeat their own name in their channels, or share one name: first come,
            // first kept.
            image.channels.entry(name).or_insert_with(|| to_floats(channel.sample_data));
        }
    }
    Ok(image)
}

/// The text of our attribute, where there is one.
pub(crate) fn attribute_text(attributes: &HashMap<Text, AttributeValue>) -> Option<String> {
    match attributes.get(&Text::from(ATTRIBUTE))? {
        AttributeValue::Text(text) => Some(decode_text(text)),
        _ => None,
    }
}

/// A text of a file: UTF-8, as OpenEXR writes it today, else Latin-1.
fn decode_text(text: &Text) -> String {
    std::str::from_utf8(text.bytes()).map_or_else(|_| text.to_string(), str::to_owned)
}

/// Samples of any kind as floats.
pub(crate) fn to_floats(samples: FlatSamples) -> Vec<f32> {
    match samples {
        FlatSamples::F32(values) => values,
        FlatSamples::F16(values) => values.into_iter().map(|x| x.to_f32()).collect(),
        FlatSamples::U32(values) => values.into_iter().map(|x| x as f32).collect(),
    }
}

/// Refuses a header that claims more than the file can hold, before anything is allocated for it.
pub(crate) fn check_claim(bytes: &[u8], most: u64) -> Result<(), String> {
    let meta = MetaData::read_from_buffered(Cursor::new(bytes), false).map_err(cause_of)?;
    let mut values = 0u64;
    for header in &meta.headers {
        let pixels = (header.layer_size.width() as u64).saturating_mul(header.layer_size.height() as u64);
        values = values.saturating_add(pixels.saturating_mul(header.channels.list.len() as u64));
    }
    if values > most {
        return Err(format!("it holds {values} values; the limit is {most}"));
    }
    if values * 2 > (bytes.len() as u64).saturating_mul(MAX_EXPANSION) {
        return Err("its header claims more pixels than the file can hold".into());
    }
    Ok(())
}

pub(crate) fn cause_of(error: ::exr::error::Error) -> String {
    use ::exr::error::Error;
    match error {
        Error::NotSupported(what) => format!("it uses a feature of OpenEXR that is not supported ({what})"),
        // Messages about other damage name parts of the decoder.
        Error::Invalid(what) if what.contains("identifier missing") => "it is not an OpenEXR file".into(),
        Error::Invalid(what) if what.contains("missing bytes") => "it is empty or cut short".into(),
        Error::Invalid(_) => "it is damaged or cut short".into(),
        Error::Io(error) => io_cause(&error),
        Error::Aborted => "reading was stopped".into(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{BatchSum, Features, Film, RenderSettings};

    fn film() -> Film {
        let mut film = Film::new(3, 2);
        let lanes: Vec<u32> = (0..6).collect();
        for batch in 0..4 {
            let sums: Vec<_> = (0..6).map(|i| BatchSum::constant(8, [i as f32, batch as f32, 0.1])).collect();
            film.add_batch(8, &lanes, &sums).unwrap();
        }
        film.set_features(Features {
            albedo: (0..6).map(|i| [0.1 * i as f32, 0.5, 0.25]).collect(),
            normal: vec![[0.0, 1.0, 0.0]; 6],
            depth: (0..6).map(|i| i as f32).collect(),
        })
        .unwrap();
        film
    }

    fn metadata() -> Metadata {
        let settings = RenderSettings { size: [3, 2], max_bounces: Some(4), ..RenderSettings::default() };
        Metadata { seed: 7, batches: 4, settings: Some(settings), ..Metadata::default() }
    }

    #[test]
    fn layers_come_back_bit_for_bit() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("image.exr");
        let film = film();
        write_exr(&path, &film, &metadata()).unwrap();
        let image = read_exr(&path).unwrap();
        assert_eq!((image.width, image.height, image.position), (3, 2, [0, 0]));
        let names: Vec<_> = image.channels.keys().map(String::as_str).collect();
        assert_eq!(
            names,
            [
                "A",
                "Albedo.B",
                "Albedo.G",
                "Albedo.R",
                "B",
                "Certified.V",
                "Depth.Z",
                "G",
                "N.X",
                "N.Y",
                "N.Z",
                "R",
                "Samples.N",
                "Tail.K",
                "Tail.Max",
                "Tail.Squares",
                "Variance.B",
                "Variance.G",
                "Variance.R"
            ]
        );
        let picture = image.rgb("").unwrap();
        let variance = image.rgb("Variance").unwrap();
        for i in 0..6 {
            for channel in 0..3 {
                assert_eq!(picture[channel][i], film.mean(i)[channel] as f32);
                assert_eq!(variance[channel][i], film.variance_of_mean(i).unwrap()[channel] as f32);
            }
        }
        // Batch means 0, 1, 2, 3 in green: s² = 5/3, over four batches 5/12.
        assert!((variance[1][2] - 5.0 / 12.0).abs() < 1e-7);
        assert_eq!(image.channels["Samples.N"], [32.0; 6]);
        assert_eq!(image.channels["Depth.Z"], film.features().unwrap().depth);
        assert_eq!(image.channels["Certified.V"], [0.0; 6]); // four batches are too few
        assert_eq!(image.channels["Tail.K"], film.certify().tail);
        assert_eq!(image.channels["A"], [1.0; 6]);
        assert_eq!(image.surelight_metadata(), Some(metadata()));
    }

    /// Names in all scripts, of files and of their contents, are read back unchanged.
    #[test]
    fn metadata_may_hold_any_characters() {
        let names = ["日本.glb", "a–b.glb", "❤.glb", "e\u{301}", "é", "😀\u{10ffff}", "\u{fffd}", "\"\\\n\u{7f}"];
        let mut metadata = metadata();
        metadata.device = "Intel® Arc™".into();
        let settings = RenderSettings { scene: names.concat(), ..RenderSettings::default() };
        metadata.settings = Some(settings);
        let bytes = encode_exr(&film(), &metadata).unwrap();
        let image = decode(&bytes).unwrap();
        assert!(image.metadata.as_ref().is_some_and(|json| json.is_ascii()), "{:?}", image.metadata);
        assert_eq!(image.surelight_metadata(), Some(metadata));
    }

    #[test]
    fn the_file_names_its_colour_space() {
        let bytes = encode_exr(&film(), &metadata()).unwrap();
        let meta = MetaData::read_from_buffered(Cursor::new(&bytes), false).unwrap();
        let found = meta.headers[0].shared_attributes.chromaticities.unwrap();
        let points = [found.red, found.green, found.blue, found.white].map(|point| [point.x(), point.y()]);
        assert_eq!(points, [[0.64, 0.33], [0.3, 0.6], [0.15, 0.06], [0.3127, 0.329]]);
    }

    #[test]
    fn texts_are_utf_8_or_latin_1() {
        let decoded = |bytes: &[u8]| decode_text(&Text::from_slice_unchecked(bytes));
        assert_eq!(decoded("光.R".as_bytes()), "光.R");
        assert_eq!(decoded(b"Stra\xdfe.R"), "Straße.R");
    }

    #[test]
    fn equal_films_give_equal_bytes() {
        let first = encode_exr(&film(), &metadata()).unwrap();
        for _ in 0..8 {
            assert!(encode_exr(&film(), &metadata()).unwrap() == first);
        }
    }

    #[test]
    fn unknown_variance_is_not_zero() {
        let mut film = Film::new(2, 1);
        film.add_batch(4, &[0, 1], &[BatchSum::constant(4, [0.25; 3]); 2]).unwrap();
        let one = decode(&encode_exr(&film, &metadata()).unwrap()).unwrap();
        assert!(one.rgb("Variance").is_none());
        film.add_batch(4, &[0], &[BatchSum::constant(4, [0.25; 3])]).unwrap();
        let two = decode(&encode_exr(&film, &metadata()).unwrap()).unwrap();
        assert_eq!(two.rgb("Variance").unwrap()[0], [0.0, f32::INFINITY]);
    }

    #[test]
    fn names_of_other_renderers_are_understood() {
        let plane = |x: f32| vec![x; 4];
        let mut image = ExrImage { width: 2, height: 2, ..ExrImage::default() };
        for (i, c) in ["R", "G", "B"].iter().enumerate() {
            image.channels.insert(format!("ViewLayer.Combined.{c}"), plane(i as f32));
            image.channels.insert(format!("ViewLayer.DiffCol.{c}"), plane(9.0));
        }
        assert_eq!(image.rgb("").unwrap()[2][0], 2.0);
        assert_eq!(image.rgb("DiffCol").unwrap()[0][0], 9.0);
        assert!(image.rgb("Col").is_none());
        image.channels.insert("R".into(), plane(5.0));
        assert_eq!(image.rgb("").unwrap()[0][0], 0.0, "a lone R is no picture");
        for c in ["G", "B"] {
            image.channels.insert(c.into(), plane(5.0));
        }
        assert_eq!(image.rgb("").unwrap()[0][0], 5.0);
    }

    #[test]
    fn damage_is_reported_in_a_sentence() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("image.exr");
        assert!(read_exr(&path).unwrap_err().to_string().ends_with("it does not exist."));
        let whole = encode_exr(&film(), &metadata()).unwrap();
        for length in [0, 3, 8, 100, whole.len() / 2, whole.len() - 1] {
            std::fs::write(&path, &whole[..length]).unwrap();
            let text = read_exr(&path).unwrap_err().to_string();
            assert!(text.contains("image.exr") && text.contains("cut short"), "{length}: {text}");
        }
    }

    #[test]
    fn a_boastful_header_is_refused() {
        let mut bytes = encode_exr(&film(), &metadata()).unwrap();
        let at = bytes.windows(10).position(|w| w == b"dataWindow").unwrap();
        // "dataWindow\0box2i\0" and a length of four bytes, then x0 y0 x1 y1.
        let x1 = at + 11 + 6 + 4 + 8;
        bytes[x1..x1 + 8].copy_from_slice(&[0xff, 0xff, 0x0f, 0, 0xff, 0xff, 0x0f, 0]);
        let text = decode(&bytes).unwrap_err();
        assert!(text.contains("the limit is"), "{text}");
    }

    #[test]
    fn an_empty_image_is_refused() {
        assert!(encode_exr(&Film::new(0, 4), &metadata()).is_err());
    }
}
