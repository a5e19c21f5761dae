//! Case 44: every available device against a path tracer in f64 on the CPU.

use surelight_film::Film;
use surelight_prepare::Settings;
use surelight_render::{AdapterChoice, Device, Renderer};
use surelight_scenes::torture;
use surelight_tests::path_oracle::PathOracle;
use surelight_tests::render::prepare;
use surelight_tests::welch::Comparison;

const SIZE: [u32; 2] = [24, 24];
const BATCHES: u32 = 16;
/// Parts of a pixel along each side: one sample each.
const CELLS: u32 = 8;

#[test]
fn backend_welch() {
    let scene = torture::scene("backend-welch");
    let oracle = PathOracle::new(&scene, 1.0).render(SIZE, BATCHES, CELLS, 1);
    let adapters = Device::list();
    assert!(!adapters.is_empty(), "there is no device: ./setup.sh installs a software one");
    let comparison = Comparison { power: 0.02, pictures: adapters.len(), pixels: true };
    for (index, adapter) in adapters.iter().enumerate() {
        let device = Device::new(&AdapterChoice::Index(index)).unwrap_or_else(|e| panic!("{}: {e}", adapter.name));
        let prepared = prepare(&scene, &Settings { seed: 44, ..Settings::new(SIZE[0], SIZE[1]) });
        let mut renderer = Renderer::new(&device, &prepared).unwrap_or_else(|e| panic!("{}: {e}", adapter.name));
        let mut film = Film::new(SIZE[0], SIZE[1]);
        renderer.trace(&mut film, 0, BATCHES, CELLS * CELLS, &mut |_| true).unwrap_or_else(|e| panic!("{e}"));
        assert_eq!((renderer.counts.dropped, renderer.counts.truncated), (0, 0), "{} loses samples", adapter.name);
        let name = format!("{} ({}, {}) against f64", adapter.name, adapter.driver, adapter.backend);
        comparison.assert_equal(&name, &film, &oracle);
    }
}
