//! The kind of a file, by its first bytes: for messages about files of the wrong kind.

/// First bytes and kind of files that are taken for scenes and environments.
const KINDS: &[(&[u8], &str)] = &[
    (b"glTF", "a glTF scene"),
    (b"\x89PNG", "a PNG image"),
    (b"\xff\xd8\xff", "a JPEG image"),
    (b"II*\0", "a TIFF image"),
    (b"MM\0*", "a TIFF image"),
    (b"#?", "a Radiance HDR image"),
    (b"\x76\x2f\x31\x01", "an OpenEXR image"),
    (b"\xabKTX", "a KTX image"),
    (b"PK\x03\x04", "a ZIP archive: unpack it first"),
    (b"\x1f\x8b", "compressed with gzip: unpack it first"),
    (b"\x28\xb5\x2f\xfd", "compressed with Zstandard: unpack it first"),
    (b"BLENDER", "a Blender file: export it as glTF 2.0"),
    (b"Kaydara FBX", "an FBX file: convert it to glTF 2.0"),
    (b"PXR-USDC", "a USD file: convert it to glTF 2.0"),
    (b"#usda", "a USD file: convert it to glTF 2.0"),
    (b"\xff\xfe", "UTF-16 text: save it as UTF-8"),
    (b"\xfe\xff", "UTF-16 text: save it as UTF-8"),
    (b"<", "an HTML or XML document"),
    (b"version https://git-lfs", "a Git LFS pointer: run `git lfs pull`"),
];

/// The kind of a file with these bytes as half a sentence, where it is known: `it is …`.
pub(crate) fn kind_of(bytes: &[u8]) -> Option<&'static str> {
    match bytes {
        [] => Some("empty"),
        _ => KINDS.iter().find(|(magic, _)| bytes.starts_with(magic)).map(|(_, kind)| *kind),
    }
}
