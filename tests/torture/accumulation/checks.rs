//! The kernel with all bounds checks and the one without give the same picture of every case.

use surelight_film::Film;
use surelight_prepare::Settings;
use surelight_render::{Checks, instrument};
use surelight_scenes::torture;
use surelight_tests::render::{all, bits, device, prepare};

#[test]
fn checked_and_trusted_kernels_agree_on_all_cases() {
    let mut compared = 0;
    for case in torture::cases().filter(|case| case.file) {
        let scene = (case.entry.build)();
        let prepared = prepare(&scene, &Settings { max_bounces: Some(16), ..Settings::new(16, 16) });
        let [checked, trusted] = [Checks::Full, Checks::Trusted].map(|checks| {
            let mut renderer = instrument::with_checks(device(), &prepared, checks).unwrap_or_else(|e| panic!("{e}"));
            let mut film = Film::new(16, 16);
            renderer.trace(&mut film, 0, 1, 2, &mut |_| true).unwrap_or_else(|e| panic!("{e}"));
            film
        });
        let differ = bits(&checked).iter().zip(bits(&trusted)).filter(|(a, b)| **a != *b).count();
        assert_eq!(differ, 0, "{}: pixels differ", case.entry.name);
        compared += usize::from(all(&checked).any(|i| checked.mean(i) != [0.0; 3]));
    }
    println!("{compared} cases that show some light");
    assert!(compared > 10);
}
