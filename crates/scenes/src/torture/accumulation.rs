//! Accumulation, random numbers and drivers: cases 40 to 44.

use glam::{DAffine3, DVec3};
use surelight_scene::Scene;

use super::{Case, named, orthographic};
use crate::builder::{Builder, emitter};
use crate::shapes::Shape;
use crate::{Entry, cornell_box, quad_light};

/// The group's cases.
pub const CASES: &[Case] = &[
    Case::new(
        40,
        Entry {
            name: "stagnation",
            shows: "A wall that shines evenly: each sample is the same.",
            known: "Every pixel is (0.9, 0.7, 1/3) within 10⁻⁵ after 2^26 samples. A sum in f32 alone stands still at 2^24.",
            build: stagnation,
        },
    ),
    Case::new(
        41,
        Entry {
            name: "split-whole",
            shows: "The Cornell box, however its render is cut.",
            known: "Tiles, slices, passes, dispatches, interruptions and crops change no bit. No closed form.",
            build: || named("split-whole", cornell_box::cornell_box()),
        },
    ),
    Case::new(
        42,
        Entry {
            name: "index-wrap",
            shows: "A lamp over a floor, to be sampled beyond 2^24 and up to 2^32 times a pixel.",
            known: "No two samples of a pixel have the same random numbers, more often than chance has it. The picture is \
                    that of quad-light.glb.",
            build: || named("index-wrap", quad_light::quad_light()),
        },
    ),
    Case::new(
        43,
        Entry {
            name: "correlation",
            shows: "The same lamp: neighbouring pixels, and the dimensions of one, must not move together.",
            known: "Correlations of random numbers between pixels, batches, seeds and dimensions are 0. The picture is that \
                    of quad-light.glb.",
            build: || named("correlation", quad_light::quad_light()),
        },
    ),
    Case::new(
        44,
        Entry {
            name: "backend-welch",
            shows: "The Cornell box, as every device and a path tracer in f64 on the CPU see it.",
            known: "They have one mean, and p-values of their pixels are uniform. No closed form.",
            build: || named("backend-welch", cornell_box::cornell_box()),
        },
    ),
];

/// Radiance of the wall of [`stagnation`]: no power of two, so that every addition rounds.
pub const WALL: [f32; 3] = [0.9, 0.7, 1.0 / 3.0];

/// A wall that fills the view.
pub fn stagnation() -> Scene {
    let mut b = Builder::new("stagnation");
    let wall = b.material(emitter("wall", WALL));
    b.add("wall", Shape::parallelogram(DVec3::NEG_Z, DVec3::X * 2.0, DVec3::Y * 2.0), wall);
    let mut scene = b.finish();
    scene.cameras.push(orthographic(DAffine3::from_translation(DVec3::Z), 1.0));
    scene
}
