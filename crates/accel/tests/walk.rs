//! The walk over the items against brute force in f64.

mod common;

use common::{Rng, build, hold_against, lone, rays, soup};
use surelight_accel::{BuildOptions, Quality, oracle::Oracle};

#[test]
fn random_soups_agree_with_brute_force() {
    for (seed, n, size) in [(1, 1, 1.0), (2, 2, 1.0), (3, 3, 0.5), (4, 40, 0.5), (5, 1000, 0.1), (6, 5000, 0.3)] {
        let mut rng = Rng::new(seed);
        let scene = lone(soup(&mut rng, n, size));
        let oracle = Oracle::new(&scene, glam::DVec3::ZERO);
        for quality in [Quality::Fast, Quality::Medium, Quality::Slow] {
            let accel = build(&scene, &BuildOptions { quality, ..BuildOptions::default() });
            let tally = hold_against(&oracle, &accel, &rays(&mut rng, 1000, glam::Vec3::ZERO, 2.0));
            println!("{n} triangles, {quality:?}: {tally:?}, depth {}", accel.stack_depth);
            assert!(tally.hits > 10, "{tally:?}");
            // Ties are rare, or the comparison says nothing.
            assert!(tally.ties <= 10, "{tally:?}");
        }
    }
}
