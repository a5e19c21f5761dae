//! Two renders of the same picture, compared without knowing the truth (Jung, Hanika & Dachsbacher,
//! JCGT 9(2) 2020).

use surelight_estimate::{Estimate, detectable_bias, sidak_level, uniformity_test, welch_test};
use surelight_film::Film;

use crate::render::{ALPHA, all, pooled};

/// Requirements of a comparison.
#[derive(Clone, Copy, Debug)]
pub struct Comparison {
    /// The largest relative difference of the means that may go unseen 1 time in 10.
    pub power: f64,
    /// Comparisons in all; levels are Šidák's.
    pub pictures: usize,
    /// Whether pixels' p-values must be uniform too: where pixels are too heavy-tailed for
    /// Student's t, they are not.
    pub pixels: bool,
}

impl Comparison {
    /// Welch's test of the means of all pixels, channel by channel, then of the distribution of
    /// pixels' p-values (green).
    pub fn assert_equal(&self, name: &str, a: &Film, b: &Film) {
        let level = sidak_level(ALPHA, 4 * self.pictures);
        for c in 0..3 {
            let test = welch_test(&pooled(a, c, all(a)), &pooled(b, c, all(b)));
            let mean = pooled(a, c, all(a)).mean;
            let detectable = detectable_bias(test.standard_error, level, 0.9) / mean;
            println!(
                "{name}, channel {c}: differ by {:+.3} % ± {:.3} %, p {:.3}; {:.2} % would be detected",
                100.0 * test.difference / mean,
                100.0 * test.standard_error / mean,
                test.p,
                100.0 * detectable
            );
            assert!(detectable <= self.power, "{name}: only a difference of {detectable:.1e} could be detected");
            assert!(
                test.p > level,
                "{name}: means differ by {:+.1e} of themselves, p = {:.1e}",
                test.difference / mean,
                test.p
            );
        }
        if self.pixels {
            let p: Vec<_> = all(a).filter_map(|i| Some(welch_test(&pixel(a, i)?, &pixel(b, i)?).p)).collect();
            let test = uniformity_test(&p);
            println!("{name}: p-values of {} pixels are uniform with p {:.3}", p.len(), test.p);
            assert!(p.len() > 200, "{name}: few pixels vary");
            assert!(test.p > level, "{name}: p-values of pixels are not uniform, p = {:.1e}", test.p);
        }
    }
}

/// Green of a pixel; none where it does not vary.
fn pixel(film: &Film, i: usize) -> Option<Estimate> {
    let variance = film.variance_of_mean(i)?[1];
    (variance > 0.0).then(|| Estimate { mean: film.mean(i)[1], variance, dof: film.degrees_of_freedom(i) })
}
