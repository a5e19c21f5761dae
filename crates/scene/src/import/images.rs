//! Images: found, decoded once each and in parallel, with limits; a broken one costs a warning and
//! not the picture.

use std::collections::{BTreeSet, HashMap};
use std::io::Cursor;

use image::{ImageError, ImageFormat, ImageReader, Limits};
use rayon::prelude::*;

use super::basis;
use super::buffers::Buffers;
use super::document::{Document, Int, get};
use super::error::{Fault, Result};
use super::uri::{self, Folders};
use super::warnings::Warnings;
use crate::kind::kind_of;
use crate::{Image, LoadOptions};

/// All images together may have this many times the pixels of the largest one.
const TOTAL_FACTOR: u64 = 16;

/// The sources of image bytes, and limits on image sizes.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Sources<'a> {
    pub(crate) document: &'a Document,
    pub(crate) buffers: &'a Buffers<'a>,
    pub(crate) folders: &'a Folders<'a>,
    pub(crate) options: &'a LoadOptions,
}

/// Decoded images, and where each glTF image went.
#[derive(Debug, Default)]
pub(crate) struct Decoded {
    pub(crate) images: Vec<Image>,
    /// glTF image index → index into `images`; absent when it could not be read.
    pub(crate) slots: HashMap<usize, usize>,
    /// glTF image index → why it could not be read.
    failed: HashMap<usize, Fault>,
    pub(crate) warnings: Warnings,
}

impl Decoded {
    /// Index into `images` of the first of these glTF images that could be read.
    pub(crate) fn first_of(&self, choices: &[usize]) -> Option<usize> {
        choices.iter().find_map(|index| self.slots.get(index).copied())
    }

    /// Says why a texture is without its image, or shows its fallback.
    fn warn(&mut self, choices: &[usize]) {
        let failed = choices.iter().map_while(|index| self.failed.get(index));
        let causes = failed.map(Fault::reason).collect::<Vec<_>>();
        let text = match (causes.as_slice(), choices.get(causes.len())) {
            ([], _) => return,
            (_, None) => format!("A texture is left out: {}.", causes.join("; ")),
            (_, Some(used)) => {
                format!("Image {used} is used as the fallback of image {}: {}.", choices[0], causes.join("; "))
            }
        };
        self.warnings.push(text);
    }
}

/// Decodes glTF images. Each entry of `wanted` lists images that can serve one texture, best first;
/// a later one is decoded only where all before it cannot be read.
pub(crate) fn decode_all(sources: Sources, wanted: &[Vec<usize>]) -> Decoded {
    let mut out = Decoded::default();
    // Two glTF images may share a URI or a view: the later ones follow the first.
    let mut leaders = HashMap::new();
    loop {
        let open = |choices: &Vec<usize>| {
            let next = choices.iter().copied().find(|index| !out.failed.contains_key(index))?;
            (!out.slots.contains_key(&next)).then_some(next)
        };
        // Every round decodes or fails each of these, so that the rounds end.
        let round: BTreeSet<usize> = wanted.iter().filter_map(open).collect();
        if round.is_empty() {
            break;
        }
        decode_round(sources, &round, &mut leaders, &mut out);
    }
    for choices in wanted {
        out.warn(choices);
    }
    out
}

type Source<'a> = (Option<&'a str>, Option<Int>);

/// Decodes these images; each is in `slots` or `failed` afterwards.
fn decode_round<'a>(
    sources: Sources<'a>,
    wanted: &BTreeSet<usize>,
    leaders: &mut HashMap<Source<'a>, usize>,
    out: &mut Decoded,
) {
    let leader_of: Vec<(usize, usize)> = wanted
        .iter()
        .map(|&index| match sources.document.images.get(index) {
            Some(json) => (index, *leaders.entry((json.uri.as_deref(), json.buffer_view)).or_insert(index)),
            None => (index, index),
        })
        .collect();
    let unique: Vec<usize> =
        leader_of.iter().filter(|(index, leader)| index == leader).map(|&(index, _)| index).collect();
    let sized: Vec<_> = unique.par_iter().map(|&index| sources.open(index)).collect();
    // Sizes first, so that the sum is known before any pixel is in memory.
    let most = sources.options.max_image_pixels.saturating_mul(TOTAL_FACTOR);
    let mut total: u64 = out.images.iter().map(|image| u64::from(image.width) * u64::from(image.height)).sum();
    let admitted: Vec<_> = sized
        .into_iter()
        .map(|encoded| {
            let encoded = encoded?;
            let pixels = encoded.pixels();
            if total + pixels > most {
                let cause = format!("would make more than {most} pixels of all images");
                return Err(Fault::too_large(format!("image {}", encoded.index), cause));
            }
            total += pixels;
            Ok(encoded)
        })
        .collect();
    let decoded: Vec<_> = admitted.into_par_iter().map(|encoded| encoded.and_then(|e| sources.decode(&e))).collect();

    for (&index, result) in unique.iter().zip(decoded) {
        match result {
            Ok(image) => {
                out.slots.insert(index, out.images.len());
                out.images.push(image);
            }
            Err(fault) => {
                out.failed.insert(index, fault);
            }
        }
    }
    for (index, leader) in leader_of {
        if let Some(&slot) = out.slots.get(&leader) {
            out.slots.insert(index, slot);
        } else if let Some(fault) = out.failed.get(&leader).cloned() {
            out.failed.insert(index, fault);
        }
    }
}

/// Who decodes an image.
#[derive(Clone, Copy)]
enum Format {
    /// The crate `image`.
    Common(ImageFormat),
    /// [`basis`].
    Basis,
}

/// An image file whose header has been read and found within the limits.
struct Encoded<'a> {
    index: usize,
    name: String,
    bytes: std::borrow::Cow<'a, [u8]>,
    format: Format,
    size: (u32, u32),
}

impl Encoded<'_> {
    fn pixels(&self) -> u64 {
        u64::from(self.size.0) * u64::from(self.size.1)
    }
}

/// Why an image cannot be decoded, without its decoder's own text.
fn undecodable(format: ImageFormat, error: &ImageError) -> String {
    let name = match format {
        ImageFormat::Png => "PNG",
        ImageFormat::Jpeg => "JPEG",
        _ => "WebP",
    };
    let cause = match error {
        ImageError::Unsupported(_) => "of a kind that is not supported",
        ImageError::Limits(_) => "too large to decode",
        ImageError::IoError(_) => "cut short",
        _ => "damaged or cut short",
    };
    format!("cannot be decoded: the {name} is {cause}")
}

impl<'a> Sources<'a> {
    fn open(&self, index: usize) -> Result<Encoded<'a>> {
        let place = format!("image {index}");
        let json = get(&self.document.images, Int(index as u64), "image", "a texture")?;
        let (bytes, name): (std::borrow::Cow<[u8]>, _) = match (&json.uri, json.buffer_view) {
            (Some(uri), _) => {
                let bytes = uri::read(uri, self.folders, self.options.max_buffer_bytes, &place)?;
                (bytes.into(), uri::file_name(uri, self.folders).unwrap_or_else(|| place.clone()))
            }
            (None, Some(view)) => (self.buffers.view(view, &place)?.bytes.into(), place.clone()),
            (None, None) => return Err(Fault::invalid(place, "has neither a URI nor a bufferView")),
        };
        if bytes.is_empty() {
            return Err(Fault::invalid(place, "has no bytes"));
        }
        // The bytes decide, not the MIME type: files exist that state the wrong one.
        let (format, size) = if bytes.starts_with(basis::MAGIC) {
            (Format::Basis, basis::size(&bytes, &place)?)
        } else {
            let format = match image::guess_format(&bytes) {
                Ok(format @ (ImageFormat::Png | ImageFormat::Jpeg | ImageFormat::WebP)) => format,
                _ => {
                    let kind = kind_of(&bytes).map_or_else(String::new, |kind| format!(" but {kind}"));
                    return Err(Fault::invalid(place, format!("is neither PNG, JPEG, WebP nor KTX2{kind}")));
                }
            };
            let size = ImageReader::with_format(Cursor::new(&bytes), format)
                .into_dimensions()
                .map_err(|e| Fault::invalid(&place, undecodable(format, &e)))?;
            (Format::Common(format), size)
        };
        let encoded = Encoded { index, name, bytes, format, size };
        if encoded.pixels() == 0 {
            return Err(Fault::invalid(place, "has no pixels"));
        }
        if encoded.pixels() > self.options.max_image_pixels {
            let cause =
                format!("has {} × {} pixels, above the limit of {}", size.0, size.1, self.options.max_image_pixels);
            return Err(Fault::too_large(place, cause));
        }
        Ok(encoded)
    }

    fn decode(&self, encoded: &Encoded) -> Result<Image> {
        let place = || format!("image {}", encoded.index);
        let format = match encoded.format {
            Format::Common(format) => format,
            Format::Basis => {
                let rgba = basis::decode(&encoded.bytes, encoded.size, &place())?;
                return Ok(Image { name: encoded.name.clone(), width: encoded.size.0, height: encoded.size.1, rgba });
            }
        };
        let mut limits = Limits::default();
        // 16-bit RGBA is the widest pixel; decoders may hold it twice.
        limits.max_alloc = Some(encoded.pixels().saturating_mul(16) + (16 << 20));
        let mut reader = ImageReader::with_format(Cursor::new(&encoded.bytes), format);
        reader.limits(limits);
        let image = reader.decode().map_err(|e| Fault::invalid(place(), undecodable(format, &e)))?;
        let rgba = image.into_rgba8();
        Ok(Image { name: encoded.name.clone(), width: rgba.width(), height: rgba.height(), rgba: rgba.into_raw() })
    }
}
