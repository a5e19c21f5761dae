//! Case 1: a furnace whose every single sample is known.

use surelight_prepare::Settings;
use surelight_scenes::torture::numeric;
use surelight_tests::render::{all, render, ulps};

/// A convex Lambertian body under a uniform sky reflects once: each sample that hits it is ρ·L,
/// each other L.
#[test]
fn zero_variance_furnace() {
    let (rho, sky) = (numeric::FURNACE_REFLECTANCE, numeric::FURNACE_SKY);
    let scene = numeric::zero_variance_furnace();
    for seed in 0..4 {
        let film = render(&scene, &Settings { seed, ..Settings::new(64, 64) }, 1, 1);
        let mut reflections = 0;
        for i in all(&film) {
            let value = film.mean(i).map(|v| v as f32);
            let is = |expected: [f32; 3]| (0..3).all(|c| ulps(value[c], expected[c]) <= 4);
            let reflected = is([0, 1, 2].map(|c| rho[c] * sky[c]));
            assert!(reflected || is(sky), "pixel {i} is {value:?}");
            reflections += usize::from(reflected);
        }
        // The ball's outline, an ellipse of about 0.5/(4·tan 20°) of the picture's side in radius.
        let share = reflections as f64 / film.pixels().len() as f64;
        println!("{share:.3} of all samples hit the ball");
        assert!((0.3..0.5).contains(&share), "{share} of all samples hit the ball");
    }
}
