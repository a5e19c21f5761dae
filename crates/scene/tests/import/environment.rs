//! Environment maps: .hdr and .exr.

use std::fs;
use std::path::PathBuf;

use surelight_scene::{EnvironmentMap, LoadError, load_environment};

/// Writes bytes to a new file with this name and loads it.
fn load(name: &str, bytes: &[u8]) -> Result<EnvironmentMap, LoadError> {
    let folder = tempfile::tempdir().expect("folder");
    let path: PathBuf = folder.path().join(name);
    fs::write(&path, bytes).expect("file");
    load_environment(&path)
}

/// A 4 × 2 Radiance file, uncompressed (it is too narrow for run lengths), of these RGBE texels.
fn hdr(header: &str, texels: &[[u8; 4]; 8]) -> Vec<u8> {
    let mut bytes = format!("#?RADIANCE\n{header}FORMAT=32-bit_rle_rgbe\n\n-Y 2 +X 4\n").into_bytes();
    bytes.extend(texels.iter().flatten());
    bytes
}

/// (1, 0.5, 0.25): exponent 129 makes 128 / 256 · 2 = 1.
const TEXEL: [u8; 4] = [128, 64, 32, 129];

#[test]
fn hdr_loads_row_by_row() {
    let mut texels = [[0, 0, 0, 0]; 8];
    texels[5] = TEXEL;
    let map = load("map.hdr", &hdr("", &texels)).expect("loads");
    assert_eq!((map.width, map.height), (4, 2));
    let [r, g, b] = map.texels[5];
    // The format stores the lower end of each step; decoders may add half of one.
    assert!((r - 1.0).abs() < 0.01 && (g - 0.5).abs() < 0.01 && (b - 0.25).abs() < 0.01, "{r} {g} {b}");
    assert!(map.texels[0].iter().all(|&c| c < 1e-6));
}

#[test]
fn exposure_of_hdr_is_taken_out() {
    let plain = load("map.hdr", &hdr("", &[TEXEL; 8])).expect("loads");
    let exposed = load("map.hdr", &hdr("EXPOSURE=2.0\nEXPOSURE=2.0\n", &[TEXEL; 8])).expect("loads");
    assert_eq!(exposed.texels[0], plain.texels[0].map(|c| c / 4.0));
    assert!(load("map.hdr", &hdr("EXPOSURE=0\n", &[TEXEL; 8])).is_err());
}

/// An OpenEXR file of these texels.
fn exr(width: usize, height: usize, texels: &[[f32; 3]]) -> Vec<u8> {
    use exr::prelude::*;
    let channels = SpecificChannels::rgb(|at: Vec2<usize>| {
        let [r, g, b] = texels[at.1 * width + at.0];
        (r, g, b)
    });
    let mut bytes = std::io::Cursor::new(Vec::new());
    Image::from_channels((width, height), channels).write().to_buffered(&mut bytes).expect("encodes");
    bytes.into_inner()
}

#[test]
fn exr_loads_row_by_row() {
    let texels: Vec<[f32; 3]> = (0..8).map(|i| [i as f32, 100.0 + i as f32, 1e-3]).collect();
    let map = load("map.exr", &exr(4, 2, &texels)).expect("loads");
    assert_eq!((map.width, map.height, map.texels), (4, 2, texels));
}

#[test]
fn texels_are_made_finite_and_positive() {
    let bad = [[f32::NAN, -1.0, 2.0], [f32::INFINITY, f32::NEG_INFINITY, 1e38]];
    let map = load("map.exr", &exr(2, 1, &bad)).expect("loads");
    assert_eq!(map.texels, [[0.0, 0.0, 2.0], [65504.0, 0.0, 1e12]]);
}

#[test]
fn the_content_decides_and_not_the_name() {
    assert!(load("map.hdr", &exr(2, 1, &[[1.0; 3]; 2])).is_ok());
    assert!(load("map.exr", &hdr("", &[TEXEL; 8])).is_ok());
}

#[test]
fn other_files_are_refused_in_one_sentence() {
    for (name, bytes) in [("map.hdr", &b""[..]), ("map.png", b"\x89PNG\r\n\x1a\n"), ("map.exr", b"\x76\x2f\x31\x01")] {
        let error = load(name, bytes).expect_err("refused");
        let message = error.to_string();
        assert!(matches!(error, LoadError::Environment { .. }), "{message}");
        assert!(message.contains(name) && message.ends_with('.'), "{message}");
    }
    let gone = load_environment("/nowhere/map.hdr".as_ref()).expect_err("refused");
    assert!(matches!(gone, LoadError::Read { .. }), "{gone}");
}

#[test]
fn every_cut_is_refused() {
    let whole = hdr("", &[TEXEL; 8]);
    for length in 0..whole.len() {
        assert!(load("map.hdr", &whole[..length]).is_err(), "{length}");
    }
    let whole = exr(4, 2, &[[1.0, 2.0, 3.0]; 8]);
    for length in 0..whole.len() {
        assert!(load("map.exr", &whole[..length]).is_err(), "{length}");
    }
}

#[test]
fn headers_that_lie_about_the_size_are_refused() {
    for size in ["-Y 2000000000 +X 2000000000", "-Y 8000 +X 16000", "-Y 0 +X 4", "-Y 4294967295 +X 4294967295"] {
        let bytes = format!("#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n\n{size}\n").into_bytes();
        let message = load("map.hdr", &bytes).expect_err("refused").to_string();
        assert!(message.contains("map.hdr"), "{message}");
    }
}

#[test]
fn the_display_window_of_exr_frames_the_map() {
    use exr::prelude::*;
    // Two texels of data at (1, 1) of a 4 × 2 picture.
    let channels = SpecificChannels::rgb(|at: Vec2<usize>| (1.0_f32 + at.0 as f32, 0.0_f32, 0.0_f32));
    let attributes = LayerAttributes { layer_position: Vec2(1, 1), ..LayerAttributes::named("sky") };
    let layer = Layer::new((2, 1), attributes, Encoding::UNCOMPRESSED, channels);
    let window = IntegerBounds::new((0, 0), (4, 2));
    let mut bytes = std::io::Cursor::new(Vec::new());
    Image::new(ImageAttributes::new(window), layer).write().to_buffered(&mut bytes).expect("encodes");
    let map = load("map.exr", bytes.get_ref()).expect("loads");
    assert_eq!((map.width, map.height), (4, 2));
    assert_eq!(map.texels.iter().map(|t| t[0]).collect::<Vec<_>>(), [0., 0., 0., 0., 0., 1., 2., 0.]);
}

#[test]
fn what_was_not_taken_as_written_is_told() {
    let folder = tempfile::tempdir().expect("folder");
    let path = folder.path().join("map.exr");
    fs::write(&path, exr(3, 1, &[[-1.0, 0.0, 0.0], [1.0; 3], [f32::NAN; 3]])).expect("file");
    let (_, warnings) = surelight_scene::load_environment_with_warnings(&path).expect("loads");
    assert!(warnings[0].contains("2 of 3 texels") && warnings[1].contains("3 × 1"), "{warnings:?}");
}
