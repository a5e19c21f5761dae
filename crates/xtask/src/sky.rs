//! An environment map as an OpenEXR file: half floats, ZIP, nothing but what the format demands in the header.

use exr::prelude::{Compression, Encoding, Image, Layer, LayerAttributes, SpecificChannels, WritableImage, f16};
use surelight_scene::EnvironmentMap;

/// The bytes of the file.
pub(crate) fn exr(map: &EnvironmentMap) -> Result<Vec<u8>, String> {
    let (width, height) = (map.width as usize, map.height as usize);
    let channels = SpecificChannels::rgb(|at: exr::prelude::Vec2<usize>| {
        let [r, g, b] = map.texels[at.y() * width + at.x()].map(f16::from_f32);
        (r, g, b)
    });
    let encoding = Encoding { compression: Compression::ZIP16, ..Encoding::FAST_LOSSLESS };
    let layer = Layer::new((width, height), LayerAttributes::default(), encoding, channels);
    let mut bytes = std::io::Cursor::new(Vec::new());
    Image::from_layer(layer).write().to_buffered(&mut bytes).map_err(|e| format!("sky.exr: {e}"))?;
    Ok(bytes.into_inner())
}
