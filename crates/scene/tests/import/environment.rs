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
fn changed_values_are_reported() {
    let folder = tempfile::tempdir().expect("folder");
    let path = folder.path().join("map.exr");
    fs::write(&path, exr(3, 1, &[[-1.0, 0.0, 0.0], [1.0; 3], [f32::NAN; 3]])).expect("file");
    let (_, warnings) = surelight_scene::load_environment_with_warnings(&path).expect("loads");
    assert!(warnings[0].contains("2 of 3 texels") && warnings[1].contains("3 × 1"), "{warnings:?}");
}

/// A Radiance file without run lengths, of this header line and resolution line.
fn radiance(format: &str, resolution: &str, texels: &[[u8; 4]]) -> Vec<u8> {
    let mut bytes = format!("#?RADIANCE\nFORMAT={format}\n\n{resolution}\n").into_bytes();
    bytes.extend(texels.iter().flatten());
    bytes
}

#[test]
fn all_eight_orientations_of_hdr_give_one_picture() {
    // Red is 1 to 6, row by row, in a picture of 3 × 2.
    let texel = |red: u32| [red as u8, 0, 0, 136];
    let expected: Vec<f32> = (1..=6).map(|i| i as f32).collect();
    for (resolution, order) in [
        ("-Y 2 +X 3", [1, 2, 3, 4, 5, 6]),
        ("-Y 2 -X 3", [3, 2, 1, 6, 5, 4]),
        ("+Y 2 +X 3", [4, 5, 6, 1, 2, 3]),
        ("+Y 2 -X 3", [6, 5, 4, 3, 2, 1]),
        ("+X 3 -Y 2", [1, 4, 2, 5, 3, 6]),
        ("+X 3 +Y 2", [4, 1, 5, 2, 6, 3]),
        ("-X 3 -Y 2", [3, 6, 2, 5, 1, 4]),
        ("-X 3 +Y 2", [6, 3, 5, 2, 4, 1]),
    ] {
        let map = load("map.hdr", &radiance("32-bit_rle_rgbe", resolution, &order.map(texel))).expect("loads");
        assert_eq!((map.width, map.height), (3, 2), "{resolution}");
        assert_eq!(map.texels.iter().map(|t| t[0]).collect::<Vec<_>>(), expected, "{resolution}");
    }
}

#[test]
fn xyze_becomes_rec709() {
    // D65 white of luminance 1, and the red primary of Rec. 709; 128 encodes 1.
    let texels = [[122, 128, 139, 129], [211, 109, 10, 127]];
    let map = load("map.hdr", &radiance("32-bit_rle_xyze", "-Y 1 +X 2", &texels)).expect("loads");
    for (texel, expected) in map.texels.iter().zip([[1.0, 1.0, 1.0], [1.0, 0.0, 0.0]]) {
        // Steps of XYZE are 1/128 and 1/512.
        assert!(texel.iter().zip(expected).all(|(a, b): (&f32, f32)| (a - b).abs() < 0.015), "{texel:?} {expected:?}");
    }
    // COLORCORR and EXPOSURE apply to the stored values: to X, Y and Z.
    let mut scaled = b"#?RADIANCE\nCOLORCORR=1 2 4\nEXPOSURE=2\nFORMAT=32-bit_rle_xyze\n\n-Y 1 +X 1\n".to_vec();
    // 0.95 · 2, 1 · 4 and 1.09 · 8.
    scaled.extend([30, 64, 139, 132]);
    let white = load("map.hdr", &scaled).expect("loads").texels[0];
    assert!((white[1] - 1.0).abs() < 0.05 && (white[0] - 1.0).abs() < 0.05, "{white:?}");
}

#[test]
fn radiance_files_are_refused_in_words_of_a_user() {
    let refused = |format: &str, resolution: &str, part: &str| {
        let message = load("map.hdr", &radiance(format, resolution, &[TEXEL; 8])).expect_err("refused").to_string();
        assert!(message.contains(part), "{message}");
    };
    refused("32-bit_rle_luv", "-Y 2 +X 4", "FORMAT is \"32-bit_rle_luv\", and only 32-bit_rle_rgbe and");
    for resolution in ["-Y 2 +Y 4", "-Y 2 +X", "-Y 2 +X 4 5", "Y 2 X 4", "-Y 2 +X many", ""] {
        refused("32-bit_rle_rgbe", resolution, &format!("resolution line is \"{resolution}\", and the form is"));
    }
    // The run of five is longer than the row.
    let mut runs = b"#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n\n-Y 1 +X 8\n".to_vec();
    runs.extend([2, 2, 0, 8, 137, 1, 137, 1]);
    let message = load("map.hdr", &runs).expect_err("refused").to_string();
    assert!(message.contains("run lengths of its pixels do not fit its width"), "{message}");
}

/// A 2 × 1 OpenEXR file of channels with these names; the n-th is n + 1 on the left and
/// 10 (n + 1) on the right.
fn channels(names: &[&str]) -> Vec<u8> {
    use exr::prelude::*;
    let list = names.iter().enumerate().map(|(n, name)| {
        let value = n as f32 + 1.0;
        AnyChannel::new(*name, FlatSamples::F32(vec![value, 10.0 * value]))
    });
    let channels = AnyChannels::sort(list.collect());
    let mut bytes = std::io::Cursor::new(Vec::new());
    Image::from_channels((2, 1), channels).write().to_buffered(&mut bytes).expect("encodes");
    bytes.into_inner()
}

#[test]
fn exr_of_luminance_alone_is_grey() {
    for names in [&["Y"][..], &["A", "Y"], &["sky.Y"]] {
        let y = names.len() as f32;
        let map = load("map.exr", &channels(names)).expect("loads");
        assert_eq!(map.texels, [[y; 3], [10.0 * y; 3]], "{names:?}");
    }
}

#[test]
fn the_one_layer_of_exr_with_colour_is_found() {
    let plain = [[1.0, 2.0, 3.0], [10.0, 20.0, 30.0]];
    for names in [
        &["R", "G", "B", "other.R", "other.G", "other.B"][..],
        &["ViewLayer.Combined.R", "ViewLayer.Combined.G", "ViewLayer.Combined.B", "ViewLayer.Combined.A"],
        &["View Layer.R", "View Layer.G", "View Layer.B", "Depth.Z", "Y", "Other.R", "Other.G"],
        &["V.Combined.R", "V.Combined.G", "V.Combined.B", "V.DiffCol.R", "V.DiffCol.G", "V.DiffCol.B"],
    ] {
        assert_eq!(load("map.exr", &channels(names)).expect("loads").texels, plain, "{names:?}");
    }
}

#[test]
fn exr_without_one_picture_is_refused_by_its_channels() {
    for (names, part) in [
        (&["A", "View.Depth.Z"][..], "its channels are A, View.Depth.Z"),
        (&["R", "G"], "its channels are G, R"),
        (&["a.R", "b.G", "b.B"], "its channels are a.R, b.B, b.G"),
        (&["Y", "RY", "BY"], "its channels are BY, RY, Y"),
        (&["a.R", "a.G", "a.B", "b.R", "b.G", "b.B"], "several layers with channels R, G and B (a, b)"),
    ] {
        let message = load("map.exr", &channels(names)).expect_err("refused").to_string();
        assert!(message.contains(part), "{message}");
    }
    let many: Vec<String> = (0..300).map(|i| format!("{i:03}{}", "x".repeat(100))).collect();
    let message =
        load("map.exr", &channels(&many.iter().map(String::as_str).collect::<Vec<_>>())).expect_err("refused");
    assert!(message.to_string().ends_with("and 288 more.") && message.to_string().len() < 1200, "{message}");
}
