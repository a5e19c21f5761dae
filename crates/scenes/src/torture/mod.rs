//! Scenes that are built to break a path tracer: the torture list, one generator per case, each
//! with its closed form.
//!
//! The list and the tests that hold it, case by case, are in `docs/testing.md`; tests of the same
//! names are in `tests/torture`. Cases whose file is small are committed as
//! `assets/torture/NAME.glb`.

pub mod accumulation;
pub mod bsdf;
pub mod geometry;
pub mod light;
pub mod numeric;
pub mod sampling;

use glam::DAffine3;
use surelight_scene::{Camera, ClipRange, Projection, Scene};

use crate::Entry;

/// A case of the torture list.
pub struct Case {
    /// Its number in the list, from 1.
    pub number: u32,
    /// Its name, its subject, its closed form, and its generator.
    pub entry: Entry,
    /// Whether it is committed as `assets/torture/NAME.glb`; not so where glTF cannot hold it or
    /// where it is huge.
    pub file: bool,
}

impl Case {
    /// A case whose file is committed.
    const fn new(number: u32, entry: Entry) -> Self {
        Self { number, entry, file: true }
    }

    /// A case that exists as a generator alone.
    const fn generated(number: u32, entry: Entry) -> Self {
        Self { number, entry, file: false }
    }
}

/// All cases in the list's order.
pub fn cases() -> impl Iterator<Item = &'static Case> {
    [numeric::CASES, geometry::CASES, sampling::CASES, bsdf::CASES, light::CASES, accumulation::CASES]
        .into_iter()
        .flatten()
}

/// The scene of a case by its name, for tests; panics where there is none.
pub fn scene(name: &str) -> Scene {
    let case = cases().find(|case| case.entry.name == name);
    (case.unwrap_or_else(|| panic!("no torture case is called {name}")).entry.build)()
}

/// A scene under a case's name.
fn named(name: &str, scene: Scene) -> Scene {
    Scene { name: name.to_owned(), ..scene }
}

/// Parallel rays over a square of half-width `half`.
fn orthographic(to_world: DAffine3, half: f64) -> Camera {
    let projection = Projection::Orthographic { xmag: half, ymag: half };
    Camera { name: "camera".to_owned(), to_world, projection, clip: ClipRange::NONE }
}
