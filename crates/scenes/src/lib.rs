//! Procedural scenes and a GLB encoder, for `assets/`, tests and benchmarks.
//!
//! [`GALLERY`] lists the scenes of `assets/`, [`extensions`] those of `assets/gltf/`, [`torture`]
//! the cases of `docs/testing.md`; [`probes`] and [`shapes`] are for tests that build their own
//! scenes. [`glb::encode`] turns any [`Scene`] into the bytes of a file.
//!
//! ```
//! use std::path::Path;
//! use surelight_scene::{LoadOptions, load_bytes};
//! use surelight_scenes::{cornell_box, glb};
//!
//! let scene = cornell_box::cornell_box();
//! let file = glb::encode(&scene, "The lamp's power is known.")?;
//! let loaded = load_bytes(&file, Path::new("cornell-box.glb"), &LoadOptions::default())?;
//! assert_eq!(loaded.triangle_count(), scene.triangle_count());
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```
//!
//! Each module states the closed form of its scene and its source; the file holds the same
//! sentence. Positions are computed in f64 and rounded once, so that the files are the same
//! everywhere.
//!
//! Conventions: metres, +Y up, fronts counter-clockwise. Pure emitters are black and one-sided;
//! other opaque surfaces are two-sided. Pure Lambert is a dielectric with `specular` 0.

mod builder;
pub mod cornell_box;
pub mod extensions;
pub mod furnace;
pub mod glass;
pub mod glb;
pub mod many_lights;
mod paint;
pub mod probes;
pub mod quad_light;
mod random;
pub mod shapes;
pub mod spheres;
pub mod still_life;
pub mod textured;
pub mod torture;
pub mod veach_mis;
pub mod window;

use glam::DVec3;
use surelight_scene::Scene;

/// A scene of the gallery.
pub struct Entry {
    /// Stem of the file in `assets/`.
    pub name: &'static str,
    /// Its subject, one sentence.
    pub shows: &'static str,
    /// Its closed form.
    pub known: &'static str,
    /// Makes it.
    pub build: fn() -> Scene,
}

/// The scenes of `assets/`, in the order in which they are shown.
pub const GALLERY: &[Entry] = &[
    Entry {
        name: "cornell-box",
        shows: "The Cornell box with its two blocks, by the published measurements.",
        known: "The lamp's power π·L·A is (0.729, 0.515, 0.172). Direct light on floor points that see the whole lamp \
                follows Lambert's polygon formula: (0.527, 0.372, 0.124) of irradiance at (-0.172, 0, -0.1). The \
                picture as a whole has no closed form.",
        build: cornell_box::cornell_box,
    },
    Entry {
        name: "furnace",
        shows: "A closed room, a ball and a block of different reflectance in which nothing may be seen.",
        known: "Every surface emits Le = L·(1 − ρ), so every pixel is L = Le/(1 − ρ) = (0.5, 0.25, 0.125) exactly.",
        build: furnace::furnace,
    },
    Entry {
        name: "quad-light",
        shows: "A tilted lamp over a floor.",
        known: "Every pixel is exact: a floor point before the lamp shows ρ/π·L·E with E by Lambert's polygon formula, \
                one behind it 0, the lamp L.",
        build: quad_light::quad_light,
    },
    Entry {
        name: "veach-mis",
        shows: "Four metal plates (GGX α 0.005, 0.02, 0.05, 0.1) under four spherical lights of equal power.",
        known: "Each light's power Φ = π·L·A has the luminance 36. A sphere of power Φ at distance d lights a diffuse \
                surface with Φ·cosθ/(4π·d²), whatever its radius; these polyhedra do so to within 1 %. The picture has \
                no closed form.",
        build: veach_mis::veach_mis,
    },
    Entry {
        name: "glass",
        shows: "A glass ball, a lens and a tinted slab under a small lamp: caustics on a diffuse floor.",
        known: "n = 1.5: the ball's paraxial focus lies half a radius behind it; a face reflects r = 0.04 at normal \
                incidence; a slab with one-way absorption τ transmits (1 − r)²τ/(1 − r²τ²). The picture has no closed \
                form.",
        build: glass::glass,
    },
    Entry {
        name: "window",
        shows: "A sunlit room behind a window pane.",
        known: "Direct sunlight in the room is that of the open window times the pane's transmittance, 1 − F by Fresnel's \
                formula at the sun's angle; at normal incidence 0.96.",
        build: window::window,
    },
    Entry {
        name: "textured",
        shows: "Checker, patina, tiles and a lattice: base colour, metallic-roughness, normal map and alpha mask.",
        known: "Texel counts: the checker's mean base colour is (0.3525, 0.3350, 0.3025) to within 8-bit rounding, the \
                lattice lets through 43.14 % at right angles. The picture has no closed form.",
        build: textured::textured,
    },
    Entry {
        name: "many-lights",
        shows: "A valley at night under 2,000 glowing triangles, a dozen lanterns dominating.",
        known: "Each lantern's power is π·L·A, all together (562.8, 314.7, 156.1). Light adds: the picture is the sum \
                of those with one lantern lit. The picture itself has no closed form.",
        build: many_lights::many_lights,
    },
    Entry {
        name: "spheres",
        shows: "Metalness (upwards) against roughness (to the right); meant for `--env assets/sky.exr`, with soft boxes \
                of its own when rendered alone.",
        known: "The ball of metalness 1, roughness 0 shows the mirrored radiance times Schlick's F; a metal in a \
                uniform environment shows the directional albedo of GGX.",
        build: spheres::spheres,
    },
];

/// Irradiance at `point` with unit normal `normal` from a polygon of uniform radiance 1, wholly
/// above the horizon and facing the point; W/m² for a radiance in W/(m²·sr).
///
/// Lambert's formula (Photometria, 1760; Arvo, "Analytic Methods for Simulated Light Transport",
/// 1995, section 3): E = ½·|Σ Θᵢ Γᵢ·n| over the edges, Θᵢ the angle that an edge subtends and Γᵢ
/// the unit normal of its plane through the point.
pub fn polygon_irradiance(point: DVec3, normal: DVec3, polygon: &[DVec3]) -> f64 {
    let sum: f64 = (0..polygon.len())
        .map(|i| {
            let a = polygon[i] - point;
            let b = polygon[(i + 1) % polygon.len()] - point;
            let cross = a.cross(b);
            let sine = cross.length();
            if sine == 0.0 { 0.0 } else { sine.atan2(a.dot(b)) * cross.dot(normal) / sine }
        })
        .sum();
    0.5 * sum.abs()
}

#[cfg(test)]
mod tests;
