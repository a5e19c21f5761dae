//! OpenEXR, by the crate `exr`: the channels of the picture, and its position.

use std::collections::HashSet;
use std::io::Cursor;

use exr::error::Error;
use exr::image::{Image, Layer, SpecificChannels};
use exr::meta::MetaData;
use exr::meta::attribute::{Chromaticities, EnvironmentMap as Projection};
use exr::prelude::{ReadChannels, ReadLayers, ReadSpecificChannel};

use super::load::check_size;
use crate::EnvironmentMap;

/// Channels that a message lists.
const MAX_LISTED: usize = 12;

/// The channels that are read.
enum Picture {
    Rgb([String; 3]),
    /// Luminance alone.
    Grey(String),
}

type Pixels = (usize, Vec<[f32; 3]>);

pub(super) fn decode(bytes: &[u8], warnings: &mut Vec<String>) -> Result<EnvironmentMap, String> {
    let meta = MetaData::read_from_buffered(Cursor::new(bytes), false).map_err(cause)?;
    for header in &meta.headers {
        check_size(header.layer_size.0 as u64, header.layer_size.1 as u64, bytes.len())?;
    }
    let parts: Vec<Vec<String>> = meta
        .headers
        .iter()
        .map(|header| header.channels.list.iter().map(|channel| channel.name.to_string()).collect())
        .collect();
    let picture = choose(&parts, warnings)?;
    let read = exr::prelude::read().no_deep_data().largest_resolution_level().specific_channels();
    match picture {
        Picture::Rgb([r, g, b]) => {
            let read = read.required(&*r).required(&*g).required(&*b);
            let collect = read.collect_pixels(
                |size, _| black(size.0, size.1),
                |pixels, at, (r, g, b): (f32, f32, f32)| set(pixels, at.0, at.1, [r, g, b]),
            );
            let read = collect.first_valid_layer().all_attributes().non_parallel();
            framed(read.from_buffered(Cursor::new(bytes)).map_err(cause)?, bytes.len(), warnings)
        }
        Picture::Grey(y) => {
            let collect = read.required(&*y).collect_pixels(
                |size, _| black(size.0, size.1),
                |pixels, at, (y,): (f32,)| set(pixels, at.0, at.1, [y; 3]),
            );
            let read = collect.first_valid_layer().all_attributes().non_parallel();
            framed(read.from_buffered(Cursor::new(bytes)).map_err(cause)?, bytes.len(), warnings)
        }
    }
}

fn black(width: usize, height: usize) -> Pixels {
    (width, vec![[0.0; 3]; width * height])
}

fn set((width, texels): &mut Pixels, x: usize, y: usize, texel: [f32; 3]) {
    if let Some(to) = texels.get_mut(y * *width + x) {
        *to = texel;
    }
}

/// Causes that a user can act on, in plain words.
fn cause(error: Error) -> String {
    match error {
        Error::NotSupported(what) if what.contains("subsampling") => {
            "it has channels of less than full resolution (luminance and chroma); save it as R, G and B".into()
        }
        Error::NotSupported(what) if what.contains("deep") => "it holds deep data; flatten it first".into(),
        Error::NotSupported(what) => format!("it uses a part of OpenEXR that is not read ({what})"),
        Error::Invalid(what) if what.contains("missing bytes") => "it is cut short".into(),
        Error::Invalid(_) => "it is damaged".into(), // the rest names parts of the decoder
        other => other.to_string(),
    }
}

/// The channels of the picture, among those of each part: R, G and B, else those of the one layer
/// that has them (`ViewLayer.Combined.R`), else luminance.
fn choose(parts: &[Vec<String>], warnings: &mut Vec<String>) -> Result<Picture, String> {
    let rgb = |layer: &str| ["R", "G", "B"].map(|channel| format!("{layer}{channel}"));
    let coloured = layers(parts, "R", |part, layer| rgb(layer).iter().all(|name| part.contains(name.as_str())));
    let nameless = coloured.iter().find(|layer| layer.is_empty());
    // Blender writes the picture beside passes that are colours too.
    let mut combined = coloured.iter().filter(|layer| layer.ends_with("Combined."));
    let chosen = match (nameless, coloured.as_slice(), combined.next(), combined.next()) {
        (Some(nameless), ..) => Some(nameless),
        (None, [only], ..) => Some(only),
        (None, _, Some(combined), None) => Some(combined),
        _ => None,
    };
    if let Some(layer) = chosen {
        if coloured.len() > 1 && !layer.is_empty() {
            warnings.push(format!("only the layer {} is used", layer.trim_end_matches('.')));
        }
        return Ok(Picture::Rgb(rgb(layer)));
    }
    if !coloured.is_empty() {
        let names = listed(coloured.iter().map(|layer| layer.trim_end_matches('.')));
        return Err(format!("it has several layers with channels R, G and B ({names}); save only one"));
    }
    // With chroma beside it, luminance is not all of the picture.
    let grey = layers(parts, "Y", |part, layer| {
        ["RY", "BY"].iter().all(|chroma| !part.contains(format!("{layer}{chroma}").as_str()))
    });
    match grey.as_slice() {
        [layer] => Ok(Picture::Grey(format!("{layer}Y"))),
        _ => {
            let names = listed(parts.iter().flatten().map(String::as_str));
            Err(format!("it has no layer with channels R, G and B, nor luminance (Y) alone; its channels are {names}"))
        }
    }
}

/// Layers with a channel `last` in a part that `accept` takes, each once. A layer's name ends with
/// the dot before its channel's; the layer without a name has none.
fn layers<'a>(parts: &'a [Vec<String>], last: &str, accept: impl Fn(&HashSet<&str>, &str) -> bool) -> Vec<&'a str> {
    let mut seen = HashSet::new();
    let mut found = Vec::new();
    for part in parts {
        let names: HashSet<&str> = part.iter().map(String::as_str).collect();
        for name in part {
            let (layer, channel) = name.split_at(name.rfind('.').map_or(0, |dot| dot + 1));
            if channel == last && accept(&names, layer) && seen.insert(layer) {
                found.push(layer);
            }
        }
    }
    found
}

/// Names of the file for a message, not too many and none too long.
fn listed<'a>(names: impl Iterator<Item = &'a str>) -> String {
    const MAX_CHARS: usize = 60;
    let mut names = names.map(|name| name.chars().take(MAX_CHARS).collect::<String>());
    let mut text = names.by_ref().take(MAX_LISTED).collect::<Vec<_>>().join(", ");
    let more = names.count();
    if more > 0 {
        text += &format!(" and {more} more");
    }
    text
}

/// The map that the display window shows.
fn framed<C>(
    image: Image<Layer<SpecificChannels<Pixels, C>>>,
    file_bytes: usize,
    warnings: &mut Vec<String>,
) -> Result<EnvironmentMap, String> {
    let attributes = &image.layer_data.attributes;
    if attributes.environment_map == Some(Projection::Cube) {
        return Err("it is a cube map, and only maps of latitude and longitude are read".into());
    }
    let data = Window { at: attributes.layer_position.into(), size: image.layer_data.size.into() };
    let shown = image.attributes.display_window;
    let shown = Window { at: shown.position.into(), size: shown.size.into() };
    check_size(shown.size.0 as u64, shown.size.1 as u64, file_bytes)?;
    if let Some(c) = image.attributes.chromaticities
        && !is_rec709(&c)
    {
        warnings.push("its primaries are not those of Rec. 709, and its colours are read as if they were".into());
    }
    let (_, texels) = image.layer_data.channel_data.pixels;
    Ok(EnvironmentMap { width: shown.size.0 as u32, height: shown.size.1 as u32, texels: shown.show(data, texels) })
}

/// A rectangle of texels in OpenEXR's pixel plane, rows downwards.
#[derive(Clone, Copy, PartialEq, Eq)]
struct Window {
    at: (i32, i32),
    size: (usize, usize),
}

impl Window {
    /// The texels of `data` as seen through this window; black where there are none.
    fn show(self, data: Window, texels: Vec<[f32; 3]>) -> Vec<[f32; 3]> {
        if self == data {
            return texels;
        }
        // In i64 no difference of two corners overflows.
        let shift = |from: i32, to: i32| i64::from(to) - i64::from(from);
        let (dx, dy) = (shift(self.at.0, data.at.0), shift(self.at.1, data.at.1));
        let mut out = vec![[0.0; 3]; self.size.0 * self.size.1];
        for (y, row) in texels.chunks_exact(data.size.0).enumerate() {
            for (x, texel) in row.iter().enumerate() {
                let (x, y) = (usize::try_from(x as i64 + dx), usize::try_from(y as i64 + dy));
                if let (Ok(x), Ok(y)) = (x, y)
                    && x < self.size.0
                    && y < self.size.1
                {
                    out[y * self.size.0 + x] = *texel;
                }
            }
        }
        out
    }
}

fn is_rec709(c: &Chromaticities) -> bool {
    let near = |a: exr::math::Vec2<f32>, x: f32, y: f32| (a.0 - x).abs() < 2e-3 && (a.1 - y).abs() < 2e-3;
    near(c.red, 0.64, 0.33) && near(c.green, 0.30, 0.60) && near(c.blue, 0.15, 0.06) && near(c.white, 0.3127, 0.3290)
}
