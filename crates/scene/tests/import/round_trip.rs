//! The gallery, encoded by `surelight_scenes::glb` and read back: everything must be as it was.

use std::path::PathBuf;

use surelight_scene::{LightKind, LoadOptions, Projection, load_bytes};
use surelight_scenes::{GALLERY, glb};

#[test]
fn written_scenes_are_read_back() {
    for entry in GALLERY {
        let made = (entry.build)();
        let bytes = glb::encode(&made, entry.known).expect("writes");
        let path = PathBuf::from(format!("{}.glb", entry.name));
        let read = load_bytes(&bytes, &path, &LoadOptions::default()).unwrap_or_else(|e| panic!("{e}"));
        assert_eq!(read.warnings, Vec::<String>::new(), "{}", entry.name);
        assert_eq!(read.materials, made.materials, "{}", entry.name);
        assert_eq!(read.textures, made.textures, "{}", entry.name);
        assert!(read.images.iter().map(|i| &i.rgba).eq(made.images.iter().map(|i| &i.rgba)), "{}", entry.name);
        assert_eq!(read.cameras.len(), made.cameras.len(), "{}", entry.name);
        for (a, b) in read.cameras.iter().zip(&made.cameras) {
            // The writer states lengths and angles of cameras as f32.
            assert!(a.to_world.abs_diff_eq(b.to_world, 1e-6) && a.name == b.name, "{a:?} {b:?}");
            let close = |a: f64, b: f64| (a - b).abs() < 1e-6 * b.abs();
            match (a.projection, b.projection) {
                (Projection::Perspective { yfov: a, .. }, Projection::Perspective { yfov: b, .. }) => {
                    assert!(close(a, b))
                }
                (Projection::Orthographic { ymag: a, .. }, Projection::Orthographic { ymag: b, .. }) => {
                    assert!(close(a, b))
                }
                (a, b) => panic!("{a:?} {b:?}"),
            }
        }
        assert_eq!(read.lights.len(), made.lights.len(), "{}", entry.name);
        for (a, b) in read.lights.iter().zip(&made.lights) {
            // The same holds for the rotation that a light's direction is written as.
            let turned = match (a.kind, b.kind) {
                (LightKind::Directional { direction: a }, LightKind::Directional { direction: b }) => {
                    a.abs_diff_eq(b, 1e-6)
                }
                (a, b) => a == b,
            };
            assert!(turned && (&a.name, a.intensity) == (&b.name, b.intensity), "{a:?} {b:?}");
        }
        assert_eq!(read.instances.len(), made.instances.len(), "{}", entry.name);
        for (a, b) in read.instances.iter().zip(&made.instances) {
            assert!(a.to_world.abs_diff_eq(b.to_world, 1e-12), "{}", entry.name);
            let (a, b) = (&read.meshes[a.mesh], &made.meshes[b.mesh]);
            assert_eq!(
                (&a.positions, &a.triangles, a.material),
                (&b.positions, &b.triangles, b.material),
                "{}",
                a.name
            );
            assert_eq!(a.normals, b.normals, "{}", a.name);
            assert_eq!(a.uvs, b.uvs, "{}", a.name);
            assert_eq!(a.colors, b.colors, "{}", a.name);
            assert_eq!(a.tangents, b.tangents, "{}", a.name);
        }
    }
}
