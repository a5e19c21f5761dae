//! Parts of a small film, cut in several ways.

use std::path::Path;

use super::*;
use crate::{BatchSum, Features, encode_exr, write_exr};

const WHOLE: [u32; 2] = [7, 5];
const SPP: u64 = 24;

/// Batches of 2 samples; each pixel and batch has different numbers.
fn render(edges: [u32; 4], [first, end]: [u64; 2]) -> (Film, Metadata) {
    let window = Window::crop(WHOLE, edges).unwrap();
    let mut film = Film::of_window(window);
    let numbers: Vec<u32> =
        (edges[1]..edges[3]).flat_map(|y| (edges[0]..edges[2]).map(move |x| y * WHOLE[0] + x)).collect();
    let lanes: Vec<u32> = (0..numbers.len() as u32).collect();
    for batch in first as u32 / 2..end as u32 / 2 {
        let value = |pixel: u32, c: u32| {
            let hash =
                (pixel * 31 + batch * 17 + c).wrapping_mul(0x9e37_79b9).rotate_left(13).wrapping_mul(0x85eb_ca6b);
            (hash >> 8) as f32 * 2f32.powi((hash % 40) as i32 - 44)
        };
        let sums: Vec<_> =
            numbers.iter().map(|&p| BatchSum::new([0, 1, 2].map(|c| value(p, c)), value(p, 3), value(p, 4))).collect();
        film.add_batch(2, &lanes, &sums).unwrap();
    }
    let feature = |scale: f32| numbers.iter().map(|&p| [p as f32 * scale, 0.5, -0.0]).collect();
    let depth = numbers.iter().map(|&p| p as f32).collect();
    film.set_features(Features { albedo: feature(0.01), normal: feature(1.0), depth }).unwrap();
    let part = RenderPart {
        size: WHOLE,
        planned_samples: Some(SPP),
        asked_samples: Some([first, end]),
        ..RenderPart::default()
    };
    let metadata = Metadata {
        sample_range: [first, end],
        crop: (!window.is_all()).then_some(edges),
        batches: film.degrees_of_freedom(0).round() as u32 + 1,
        part: Some(part),
        ..Metadata::default()
    };
    (film, metadata)
}

/// Writes parts and joins them.
fn merge(parts: &[([u32; 4], [u64; 2])]) -> Result<(Film, Metadata), MergeError> {
    let folder = tempfile::tempdir().unwrap();
    let files = parts.iter().enumerate().map(|(i, &(edges, samples))| {
        let path = folder.path().join(format!("{i}.exr"));
        let (film, metadata) = render(edges, samples);
        write_exr(&path, &film, &metadata).unwrap();
        PartFile::open(&path).unwrap()
    });
    MergePlan::new(files.collect(), Compatibility::Bits)?.join()
}

const ALL: [u32; 4] = [0, 0, 7, 5];

#[test]
fn however_a_render_is_cut_its_bytes_are_the_same() {
    let (film, metadata) = render(ALL, [0, SPP]);
    let whole = encode_exr(&film, &Metadata { part: None, ..metadata }).unwrap();
    let cuts: [&[([u32; 4], [u64; 2])]; 5] = [
        &[(ALL, [0, SPP])],
        &[(ALL, [0, 2]), (ALL, [2, 10]), (ALL, [10, SPP])],
        &[(ALL, [10, SPP]), (ALL, [0, 2]), (ALL, [2, 10])],
        &[([0, 0, 3, 5], [0, SPP]), ([3, 0, 7, 2], [0, SPP]), ([3, 2, 7, 5], [0, SPP])],
        &[(ALL, [0, 8]), ([0, 0, 7, 1], [8, SPP]), ([0, 1, 7, 5], [8, 12]), ([0, 1, 7, 5], [12, SPP])],
    ];
    for parts in cuts {
        let (film, metadata) = merge(parts).unwrap();
        assert!(encode_exr(&film, &metadata).unwrap() == whole, "{parts:?}");
    }
}

#[test]
fn parts_of_parts_can_be_joined_later() {
    let folder = tempfile::tempdir().unwrap();
    let path = |name: &str| folder.path().join(name);
    for (name, parts) in [("a.exr", [[0, 4], [4, 10]]), ("b.exr", [[16, SPP], [10, 16]])] {
        let (film, metadata) = merge(&parts.map(|samples| (ALL, samples))).unwrap();
        assert!(metadata.part.is_some());
        write_exr(&path(name), &film, &metadata).unwrap();
    }
    let files = ["a.exr", "b.exr"].map(|name| PartFile::open(&path(name)).unwrap());
    let (film, metadata) = MergePlan::new(files.to_vec(), Compatibility::Bits).unwrap().join().unwrap();
    let (whole, of_whole) = render(ALL, [0, SPP]);
    let of_whole = Metadata { part: None, ..of_whole };
    assert!(encode_exr(&film, &metadata).unwrap() == encode_exr(&whole, &of_whole).unwrap());
}

#[test]
fn parts_that_do_not_fit_are_reported() {
    let text = |parts: &[([u32; 4], [u64; 2])]| merge(parts).unwrap_err().to_string();
    assert!(text(&[]).contains("nothing"));
    let twice = text(&[(ALL, [0, 8]), ([2, 2, 3, 3], [6, 12])]);
    assert!(
        twice.contains("0.exr") && twice.contains("1.exr") && twice.contains("6..8 of the pixels 2,2,3,3"),
        "{twice}"
    );
    let hole = text(&[(ALL, [0, 8]), (ALL, [16, SPP])]);
    assert!(hole.contains("samples 8..16 of all pixels are missing (33.333 %"), "{hole}");
    let hole = text(&[([0, 0, 3, 5], [0, SPP]), ([3, 0, 7, 4], [0, SPP])]);
    assert!(hole.contains("samples 0..24 of the pixels 3,4,7,5 are missing"), "{hole}");
}

#[test]
fn missing_parts_of_the_whole_are_reported() {
    let plan = |edges, samples| {
        let (_, metadata) = render(edges, samples);
        let window = Window::crop(WHOLE, edges).unwrap();
        MergePlan::new(vec![PartFile { path: "a.exr".into(), metadata, window }], Compatibility::Bits).unwrap()
    };
    assert_eq!(plan(ALL, [0, SPP]).missing, None);
    let end = plan(ALL, [0, 18]).missing.unwrap();
    assert_eq!(end.to_string(), "samples 18..24 of all pixels are missing (25.000 % of the render is)");
    let side = plan([0, 0, 6, 5], [0, SPP]).missing.unwrap();
    assert_eq!((side.edges, side.samples, side.all_pixels), ([6, 0, 7, 5], [0, SPP], false));
}

#[test]
fn parts_of_two_renders_are_refused_by_name() {
    let file = |path: &str, seed| {
        let (_, metadata) = render(ALL, [0, 8]);
        let window = Window::all(WHOLE[0], WHOLE[1]);
        PartFile { path: Path::new(path).into(), metadata: Metadata { seed, ..metadata }, window }
    };
    let text = MergePlan::new(vec![file("a.exr", 1), file("b.exr", 2)], Compatibility::Bits).unwrap_err().to_string();
    for word in ["a.exr", "b.exr", "--seed is 1 in the first and 2 in the second"] {
        assert!(text.contains(word), "{text}");
    }
    // Two renders that time ended may have cut their samples into other batches.
    let open = |path: &str, samples| {
        let mut file = file(path, 1);
        file.metadata.part.as_mut().unwrap().planned_samples = None;
        file.metadata.sample_range = samples;
        file
    };
    let text = MergePlan::new(vec![open("a.exr", [0, 8]), open("b.exr", [8, 16])], Compatibility::Bits)
        .unwrap_err()
        .to_string();
    assert!(text.contains("--spp"), "{text}");
    assert!(MergePlan::new(vec![open("a.exr", [0, 8])], Compatibility::Bits).is_ok());
}
