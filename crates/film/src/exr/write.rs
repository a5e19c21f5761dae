//! Writing: the channels of a film, computed line by line while the file is made.

use std::io::Cursor;
use std::path::Path;

use ::exr::block::BlockIndex;
use ::exr::block::UncompressedBlock;
use ::exr::image::write::channels::{ChannelsWriter, WritableChannels};
use ::exr::math::RoundingMode;
use ::exr::meta::attribute::{ChannelDescription, ChannelList, Chromaticities, LevelMode, SampleType};
use ::exr::meta::header::Header;
use ::exr::prelude::{
    AttributeValue, Blocks, Compression, Encoding, Image, ImageAttributes, IntegerBounds, Layer, LayerAttributes,
    LineOrder, Text, Vec2, WritableImage,
};

use super::ATTRIBUTE;
use crate::moments::WORDS;
use crate::words::{COVERAGE_WORDS, checksum, coverage_word, word_name};
use crate::{Film, Metadata, WriteError};

/// Primaries and white point of Rec. ITU-R BT.709, table 1.3: the meaning of the channels R, G and
/// B.
const REC_709: Chromaticities = Chromaticities {
    red: Vec2(0.64, 0.33),
    green: Vec2(0.30, 0.60),
    blue: Vec2(0.15, 0.06),
    white: Vec2(0.3127, 0.3290),
};

/// Writes the layers of a film: `R G B A`, `Variance.R .G .B` (of the mean), `Samples.N`,
/// `Certified.V`, `Tail.K` ([`crate::Certificate`]), `Tail.Max` and `Tail.Squares` (largest sample
/// and sum of squared samples, in luminance), and `Albedo.R .G .B`, `N.X .Y .Z`, `Depth.Z` where
/// the film has features.
///
/// All are 32-bit floats, ZIP-compressed, in one part; equal films and metadata give equal bytes.
/// `A` is coverage ([`Film::coverage`]), by which `R G B` and the variance are premultiplied;
/// without coverage it is 1: the environment is part of the picture. The variance layers are left
/// out where no
/// pixel has two batches; a single pixel without a variance holds infinity, which means *unknown*.
/// A crop's data window is its place in the display window, which is the whole image.
///
/// Where the metadata say that it is a [`crate::RenderPart`], the totals of all pixels go with it,
/// bit for bit, as unsigned channels `Moments.00` and so on: [`crate::read_part`] gives back the
/// film.
///
/// # Errors
/// Where the file cannot be written; the target is then as it was.
pub fn write_exr(path: &Path, film: &Film, metadata: &Metadata) -> Result<(), WriteError> {
    let bytes = encode_exr(film, metadata).map_err(|cause| WriteError::new(path, cause))?;
    crate::write_file(path, &bytes)
}

/// The bytes that [`write_exr`] writes.
///
/// # Errors
/// The cause, without a full stop, where the film cannot be encoded (an empty image).
pub fn encode_exr(film: &Film, metadata: &Metadata) -> Result<Vec<u8>, String> {
    let window = film.window();
    if window.area() == 0 {
        return Err("the image has no pixels".into());
    }
    let mut metadata = metadata.clone();
    if let Some(part) = &mut metadata.part {
        part.checksum = checksum(film, metadata.sample_range);
    }
    let json = serde_json::to_string(&metadata).map_err(|error| error.to_string())?;
    let mut attributes = LayerAttributes::default();
    let [x, y] = window.corner.map(|x| x as i32);
    attributes.layer_position = Vec2(x, y);
    // One attribute only: the library writes custom attributes in the random order of a hash map.
    attributes.other.insert(Text::from(ATTRIBUTE), AttributeValue::Text(Text::from(ascii(&json).as_str())));
    let encoding =
        Encoding { compression: Compression::ZIP16, blocks: Blocks::ScanLines, line_order: LineOrder::Increasing };
    let size = |[width, height]: [u32; 2]| Vec2(width as usize, height as usize);
    let findings = PixelFindings::new(film);
    let channels = Channels::of(film, &findings, metadata.part.is_some());
    let layer = Layer::new(size(window.size), attributes, encoding, channels);
    let display = IntegerBounds::from_dimensions(size(window.whole));
    let picture = ImageAttributes { chromaticities: Some(REC_709), ..ImageAttributes::new(display) };
    let image = Image::empty(picture).with_layer(layer);
    let mut bytes = Cursor::new(Vec::new());
    image.write().to_buffered(&mut bytes).map_err(|error| error.to_string())?;
    Ok(bytes.into_inner())
}

/// JSON in ASCII alone: other characters become `\uXXXX`, in pairs of surrogates beyond U+FFFF.
///
/// OpenEXR leaves the encoding of text attributes open, and its readers disagree about it.
/// Valid JSON has other characters within strings alone, where the escapes mean the same.
fn ascii(json: &str) -> String {
    let mut text = String::with_capacity(json.len());
    let mut units = [0; 2];
    for character in json.chars() {
        if character.is_ascii() {
            text.push(character);
        } else {
            text.extend(character.encode_utf16(&mut units).iter().map(|unit| format!("\\u{unit:04x}")));
        }
    }
    text
}

/// Findings about pixels that need all of them.
struct PixelFindings {
    certified: Vec<bool>,
    tail: Vec<f32>,
    /// Whether any pixel has a variance.
    variance: bool,
}

impl PixelFindings {
    fn new(film: &Film) -> Self {
        let certificate = film.certify();
        let variance = film.pixels().iter().any(|pixel| pixel.degrees_of_freedom() > 0.0);
        Self { certified: certificate.certified, tail: certificate.tail, variance }
    }
}

/// A non-negative number to 9 bits, which halves its size in the file. Batches have squares to 5.
fn rounded(x: f32) -> f32 {
    const DROPPED: u32 = 15;
    let bits = (x.to_bits() + (1 << (DROPPED - 1))) >> DROPPED << DROPPED;
    if f32::from_bits(bits).is_finite() { f32::from_bits(bits) } else { x }
}

/// The bits of a channel at each pixel.
type Bits<'a> = Box<dyn Fn(usize) -> u32 + Sync + 'a>;

struct Channel<'a> {
    name: Text,
    kind: SampleType,
    bits: Bits<'a>,
}

/// All channels in the order of their names, as the format requires.
struct Channels<'a> {
    list: Vec<Channel<'a>>,
    width: usize,
}

impl<'a> Channels<'a> {
    fn of(film: &'a Film, findings: &'a PixelFindings, moments: bool) -> Self {
        let mut all = Self { list: Vec::new(), width: film.width() as usize };
        let pixels = film.pixels();
        all.float("A", |i| film.coverage(i) as f32);
        all.triple(["R", "G", "B"], move |i, channel| pixels[i].mean()[channel] as f32);
        if findings.variance {
            all.triple(["Variance.R", "Variance.G", "Variance.B"], move |i, channel| {
                pixels[i].variance_of_mean().map_or(f32::INFINITY, |variance| variance[channel] as f32)
            });
        }
        if let Some(features) = film.features() {
            all.triple(["Albedo.R", "Albedo.G", "Albedo.B"], |i, channel| features.albedo[i][channel]);
            all.triple(["N.X", "N.Y", "N.Z"], |i, axis| features.normal[i][axis]);
            all.float("Depth.Z", |i| features.depth[i]);
        }
        all.float("Certified.V", |i| f32::from(u8::from(findings.certified[i])));
        all.float("Tail.K", |i| findings.tail[i]);
        // The measure of an extended render's tails.
        all.float("Tail.Max", move |i| rounded(pixels[i].largest() as f32));
        all.float("Tail.Squares", move |i| rounded(pixels[i].squares() as f32));
        all.float("Samples.N", move |i| pixels[i].samples() as f32);
        if moments {
            for word in 0..WORDS {
                all.push(word_name(word).as_str().into(), SampleType::U32, Box::new(move |i| pixels[i].word(word)));
            }
            if let Some(sums) = film.coverage_sums() {
                for word in 0..COVERAGE_WORDS {
                    let bits = move |i: usize| coverage_word(sums[i], word);
                    all.push(word_name(WORDS + word).as_str().into(), SampleType::U32, Box::new(bits));
                }
            }
        }
        all.list.sort_by(|a, b| a.name.cmp(&b.name));
        all
    }

    fn push(&mut self, name: Text, kind: SampleType, bits: Bits<'a>) {
        self.list.push(Channel { name, kind, bits });
    }

    fn float(&mut self, name: &str, value: impl Fn(usize) -> f32 + Sync + 'a) {
        self.push(name.into(), SampleType::F32, Box::new(move |i| value(i).to_bits()));
    }

    fn triple(&mut self, names: [&str; 3], value: impl Fn(usize, usize) -> f32 + Sync + Copy + 'a) {
        for (channel, name) in names.into_iter().enumerate() {
            self.float(name, move |i| value(i, channel));
        }
    }
}

impl<'s> WritableChannels<'s> for Channels<'_>
where
    Self: 's,
{
    type Writer = &'s Self;

    fn infer_channel_list(&self) -> ChannelList {
        ChannelList::new(
            self.list.iter().map(|channel| ChannelDescription::new(channel.name.clone(), channel.kind, true)).collect(),
        )
    }

    fn infer_level_modes(&self) -> (LevelMode, RoundingMode) {
        (LevelMode::Singular, RoundingMode::Down)
    }

    fn create_writer(&'s self, _header: &Header) -> Self::Writer {
        self
    }
}

impl ChannelsWriter for &Channels<'_> {
    fn extract_uncompressed_block(&self, header: &Header, block: BlockIndex) -> Vec<u8> {
        UncompressedBlock::collect_block_data_from_lines(&header.channels, block, |line| {
            let place = line.location;
            let first = place.position.y() * self.width + place.position.x();
            let bits = &self.list[place.channel].bits;
            // Floats and unsigned numbers alike are four bytes; a line of the block has room for
            // just its samples.
            let written = line.write_samples(|x| bits(first + x));
            debug_assert!(written.is_ok());
        })
    }
}
