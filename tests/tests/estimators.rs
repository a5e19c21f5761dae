//! Every way of estimating the same integral agrees: directions (hemisphere form), points on lights (area form) and both; whatever
//! the directions are drawn from and wherever the random numbers come from. Welch's test against the default.

use surelight_film::Film;
use surelight_render::{Directions, Integrator, Sampler, Settings};
use surelight_scene::{Scene, procedural};
use surelight_tests::render::{Judge, render};
use surelight_tests::scenes::map;
use surelight_tests::welch::Comparison;

const HEMISPHERES: [Integrator; 3] = [
    Integrator::Hemisphere(Directions::Bsdf),
    Integrator::Hemisphere(Directions::Cosine),
    Integrator::Hemisphere(Directions::Uniform),
];

fn picture(scene: &Scene, seed: u32, integrator: Integrator, sampler: Sampler, samples: u32) -> Film {
    render(scene, &Settings { seed, integrator, sampler, ..Settings::new(24, 24) }, 32, samples)
}

/// A lamp large enough to be found by chance.
#[test]
fn integrators_agree() {
    let mut room = procedural::cornell_box::cornell_box();
    room.name = "Cornell box in a sky".into();
    room.environment = Some(map(8, 4, |x, y| [0.3 + (x % 3) as f32, 0.5, 0.2 + (y % 2) as f32]));
    let scenes = [(procedural::quad_light::quad_light(), 0.05), (procedural::furnace::furnace(), 0.02), (room, 0.05)];
    let mut seed = 0;
    for (scene, power) in &scenes {
        let both = picture(scene, 100 + seed, Integrator::Mis, Sampler::Sobol, 16);
        for integrator in HEMISPHERES.into_iter().chain([Integrator::Area]) {
            seed += 1;
            let other = picture(scene, seed, integrator, Sampler::Sobol, 32);
            let comparison = Comparison { power: *power, pictures: 12, pixels: false };
            comparison.assert_equal(&format!("{}, {integrator:?}", scene.name), &other, &both);
        }
    }
}

/// Samplers have the same mean; the closed form is known.
#[test]
fn samplers_agree() {
    let truth = procedural::furnace::RADIANCE.map(f64::from);
    for (seed, sampler) in [(1, Sampler::Independent), (2, Sampler::Stratified), (3, Sampler::Sobol)] {
        let film = picture(&procedural::furnace::furnace(), seed, Integrator::Mis, sampler, 32);
        Judge::of(3, 0.005).mean(&format!("furnace, {sampler:?}"), &film, truth);
    }
}
