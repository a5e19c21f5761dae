//! Environment maps from Radiance .hdr and OpenEXR .exr files.

use std::path::Path;

use super::{openexr, radiance};
use crate::EnvironmentMap;
use crate::import::{LoadError, read_file};
use crate::kind::kind_of;

/// Texels that one map may have: 16 k × 8 k.
const MAX_TEXELS: u64 = 128 << 20;
/// A map with more texels than this must have [`MAX_TEXELS_PER_BYTE`] at most, or its header is
/// treated as wrong: memory is allocated before the decoder can detect it.
const TRUSTED_TEXELS: u64 = 16 << 20;
/// Run lengths of Radiance reach 16 texels per byte, ZIP on noise-free halves somewhat more.
const MAX_TEXELS_PER_BYTE: u64 = 24;
/// Bytes that one file may have.
const MAX_BYTES: u64 = 4 << 30;
/// Brighter texels are cut to this: far above the sun's 1.6e9 nit, and its square stays in the
/// range of f32.
const MAX_RADIANCE: f32 = 1e12;
/// The replacement of an infinite texel: the largest half float, since infinities come from halves
/// that overflowed.
const INFINITE: f32 = 65504.0;

/// Loads an equirectangular environment map, .hdr or .exr by its content.
///
/// Texels that are NaN or negative become 0, infinite ones 65504 (the largest half float).
///
/// # Errors
/// When the file cannot be read, is neither format, is damaged, or is larger than 128 Mi texels.
pub fn load_environment(path: &Path) -> Result<EnvironmentMap, LoadError> {
    Ok(load_environment_with_warnings(path)?.0)
}

/// The same, with a sentence for everything that was not taken as written.
///
/// # Errors
/// See [`load_environment`].
pub fn load_environment_with_warnings(path: &Path) -> Result<(EnvironmentMap, Vec<String>), LoadError> {
    let bytes = read_file(path, MAX_BYTES)?;
    let mut warnings = Vec::new();
    let decoded = if bytes.is_empty() {
        Err("it is empty".into())
    } else if bytes.starts_with(b"#?") {
        radiance::decode(&bytes)
    } else if bytes.starts_with(&[0x76, 0x2f, 0x31, 0x01]) {
        openexr::decode(&bytes, &mut warnings)
    } else {
        let kind = kind_of(&bytes).map_or_else(String::new, |kind| format!(" but {kind}"));
        Err(format!("it is neither Radiance HDR nor OpenEXR{kind}"))
    };
    let mut map = decoded.map_err(|cause| LoadError::Environment { path: path.to_path_buf(), cause })?;
    for warning in &mut warnings {
        *warning = format!("Of {}, {warning}.", path.display());
    }
    let changed = sanitise(&mut map.texels);
    if changed > 0 {
        let texels = map.texels.len();
        warnings
            .push(format!("{changed} of {texels} texels of {} were negative, infinite or no number.", path.display()));
    }
    if map.width != 2 * map.height {
        warnings.push(format!(
            "{} is {} × {}, but a map of all directions is twice as wide as high; it is stretched.",
            path.display(),
            map.width,
            map.height
        ));
    }
    Ok((map, warnings))
}

pub(super) fn check_size(width: u64, height: u64, file_bytes: usize) -> Result<(), String> {
    match width.checked_mul(height) {
        Some(0) => Err("it has no texels".into()),
        Some(texels) if texels <= TRUSTED_TEXELS => Ok(()),
        Some(texels) if texels <= MAX_TEXELS => {
            if texels <= (file_bytes as u64).saturating_mul(MAX_TEXELS_PER_BYTE) {
                return Ok(());
            }
            Err(format!("it states {width} × {height} texels in only {file_bytes} bytes"))
        }
        _ => Err(format!("it states {width} × {height} texels, and {MAX_TEXELS} are the most that are read")),
    }
}

/// Makes every texel finite, non-negative and not absurdly bright; returns how many changed.
fn sanitise(texels: &mut [[f32; 3]]) -> usize {
    let mut changed = 0;
    for texel in texels {
        let before = *texel;
        *texel = before.map(|c| match c {
            c if c.is_nan() || c < 0.0 => 0.0,
            f32::INFINITY => INFINITE,
            c => c.min(MAX_RADIANCE),
        });
        // -0.0 equals 0.0 and needs no warning; NaN never equals.
        changed += usize::from(*texel != before);
    }
    changed
}
