//! An environment map as an OpenEXR file: half floats, ZIP, nothing but the required attributes in
//! the header.

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
    // One thread: several write their blocks as they finish, in another order each time.
    Image::from_layer(layer).write().non_parallel().to_buffered(&mut bytes).map_err(|e| format!("sky.exr: {e}"))?;
    Ok(bytes.into_inner())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn sky_is_read_back_to_half_precision() {
        let sky = surelight_scenes::spheres::sky();
        let folder = tempfile::tempdir().expect("a temporary folder");
        let path = folder.path().join("sky.exr");
        std::fs::write(&path, exr(&sky).expect("it can be encoded")).expect("it can be written");
        let read = surelight_scene::load_environment(&path).expect("it can be read");
        assert_eq!((read.width, read.height), (sky.width, sky.height));
        for (a, b) in read.texels.iter().flatten().zip(sky.texels.iter().flatten()) {
            assert!((a - b).abs() <= b * 2f32.powi(-11), "{a} instead of {b}");
        }
    }
}
