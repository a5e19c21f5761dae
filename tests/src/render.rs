//! Renders small pictures of scenes, and judges their means.

use std::sync::OnceLock;

use surelight_estimate::{Estimate, sidak_level, z_test};
use surelight_film::Film;
use surelight_prepare::{Prepared, Settings};
use surelight_render::{AdapterChoice, Device, Position, Renderer, sample_batches};
use surelight_scene::Scene;

/// Level of every statistical test.
pub const ALPHA: f64 = 0.01;

/// The device that all tests of a binary share.
pub fn device() -> &'static Device {
    static DEVICE: OnceLock<Device> = OnceLock::new();
    DEVICE.get_or_init(|| {
        let device = Device::new(&AdapterChoice::Best).unwrap_or_else(|e| panic!("{e}"));
        println!("rendered by {}", device.info.name);
        device
    })
}

/// The scene with its first camera.
pub fn prepare(scene: &Scene, settings: &Settings) -> Prepared {
    Prepared::new(scene, &scene.cameras[0], settings).unwrap_or_else(|e| panic!("{}: {e}", scene.name))
}

/// A film with `batches` batches of `samples` samples. Samples lost or cut short are failures.
pub fn trace(prepared: &Prepared, size: [u32; 2], batches: u32, samples: u32) -> Film {
    let mut renderer = Renderer::new(device(), prepared).unwrap_or_else(|e| panic!("{e}"));
    let mut film = Film::new(size[0], size[1]);
    sample_batches(&mut renderer, &mut film, Position::default(), batches, samples).unwrap_or_else(|e| panic!("{e}"));
    assert_eq!((renderer.counts.dropped, renderer.counts.truncated), (0, 0), "samples were lost");
    film
}

/// A scene's picture with the settings given, through its first camera.
pub fn render(scene: &Scene, settings: &Settings, batches: u32, samples: u32) -> Film {
    trace(&prepare(scene, settings), [settings.width, settings.height], batches, samples)
}

/// Mean over some pixels, in one channel.
///
/// Pixels have independent samples, so that their variances add up. Their many degrees of freedom
/// make it a known variance.
pub fn pooled(film: &Film, channel: usize, pixels: impl Iterator<Item = usize>) -> Estimate {
    let (mut n, mut sum, mut variance, mut dof) = (0.0, 0.0, 0.0, 0.0);
    for i in pixels {
        n += 1.0;
        sum += film.mean(i)[channel];
        variance += film.variance_of_mean(i).expect("several batches")[channel];
        dof += film.degrees_of_freedom(i);
    }
    Estimate { mean: sum / n, variance: variance / (n * n), dof }
}

/// All pixels of a film.
pub fn all(film: &Film) -> std::ops::Range<usize> {
    0..film.pixels().len()
}

/// Tests means of pictures against known values: z tests at level [`ALPHA`] over all pictures and
/// channels.
#[derive(Clone, Copy, Debug)]
pub struct Judge {
    /// The largest relative bias that may go unseen 1 time in 10; a test that is blinder than this
    /// fails.
    pub power: f64,
    /// Pictures that are judged in all; levels are Šidák's.
    pub pictures: usize,
    /// Relative error of the truth and of sums in f32, below which values are equal.
    pub resolution: f64,
}

impl Judge {
    /// Of a single picture whose truth is exact.
    pub fn new(power: f64) -> Self {
        Self { power, pictures: 1, resolution: 1e-7 }
    }

    /// Of several.
    pub fn of(pictures: usize, power: f64) -> Self {
        Self { pictures, ..Self::new(power) }
    }

    /// Holds the mean over all pixels against the truth in each channel.
    ///
    /// Prints the smallest relative bias that it would have detected 9 times in 10.
    pub fn mean(&self, name: &str, film: &Film, truth: [f64; 3]) {
        let level = sidak_level(ALPHA, 3 * self.pictures);
        for (c, truth) in truth.into_iter().enumerate() {
            let mean = pooled(film, c, all(film));
            let error = mean.variance.sqrt().hypot(self.resolution * truth);
            let test = z_test(mean.mean, error, truth, level);
            let detectable = test.detectable / truth;
            println!(
                "{name}, channel {c}: {:.6} ± {error:.1e}, truth {truth:.6}, z {:+.2}; a bias of {:.3} % would be detected",
                mean.mean,
                test.z,
                100.0 * detectable
            );
            let power = self.power;
            assert!(detectable <= power, "{name}: only a bias of {detectable:.1e} could be detected, not {power:.1e}");
            assert!(test.p > level, "{name}: {} ± {error:.1e} instead of {truth}, z = {:.2}", mean.mean, test.z);
        }
    }
}

/// Bits of every pixel's mean, for comparison.
pub fn bits(film: &Film) -> Vec<[u64; 3]> {
    all(film).map(|i| film.mean(i).map(f64::to_bits)).collect()
}

/// Units in the last place between two numbers of the same sign.
pub fn ulps(a: f32, b: f32) -> u32 {
    a.to_bits().abs_diff(b.to_bits())
}
