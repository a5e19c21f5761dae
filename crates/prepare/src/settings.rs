//! Settings of a render, beside the scene and the camera.

use surelight_accel::BuildOptions;

/// Estimators of the rendering equation.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub enum Integrator {
    /// Directions are sampled; emitters are found by chance.
    Hemisphere(Directions),
    /// Points on emitters are sampled.
    Area,
    /// Both, combined by multiple importance sampling.
    #[default]
    Mis,
    /// [`Self::Mis`], with light that mirrors and smooth glass send to scattering surfaces traced
    /// from the lights.
    Caustics,
    /// [`Self::Caustics`] where mirrors and smooth glass send so much light to surfaces that this
    /// pays, or where it would be missing otherwise; else [`Self::Mis`]. Decided by the scene,
    /// before the first sample: see [`crate::Prepared::choice`].
    Auto,
    /// One shadow ray to the middle of a light, mirrors and clear glass, nothing between diffuse
    /// surfaces: biased.
    Whitted,
}

impl Integrator {
    /// The hemisphere form with its usual directions.
    pub fn default_hemisphere() -> Self {
        Self::Hemisphere(Directions::default())
    }

    /// Whether the expected value is not the radiance.
    pub fn is_biased(self) -> bool {
        self == Self::Whitted
    }
}

/// How the hemisphere form samples directions.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub enum Directions {
    /// Uniform in solid angle.
    Uniform,
    /// By the cosine.
    Cosine,
    /// By the BSDF.
    #[default]
    Bsdf,
}

/// Sources of random numbers.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub enum Sampler {
    /// A hash for each number.
    Independent,
    /// Jittered strata of a batch's samples.
    Stratified,
    /// Owen-scrambled Sobol points.
    #[default]
    Sobol,
}

/// Whether neighbouring pixels use each other's paths.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub enum PathReuse {
    /// They do not.
    #[default]
    Off,
    /// Pixels reuse paths where most of the light of the picture may be interreflection.
    Auto,
    /// They do.
    On,
}

/// Settings of a render, beside the scene and the camera.
#[derive(Clone, Debug, PartialEq)]
pub struct Settings {
    /// Pixels.
    pub width: u32,
    /// Pixels.
    pub height: u32,
    /// Scattering events that a path may have: 0 emission only, 1 direct light; `None`: Russian
    /// roulette alone ends paths.
    pub max_bounces: Option<u32>,
    /// How paths are sampled.
    pub integrator: Integrator,
    /// The source of random numbers.
    pub sampler: Sampler,
    /// Sobol points: all batches are pieces of one scrambled sequence instead of a scramble each.
    /// The picture's error is smaller (on the Cornell box by a fifth at 64 samples per pixel), but
    /// batches then compensate one another, and their spread overestimates the error.
    pub one_scramble: bool,
    /// Neighbouring pixels use each other's second vertices, where paths are sampled by
    /// [`Integrator::Mis`]: light that surfaces send one another has a third of the variance for
    /// not twice the time. The errors of the four pixels of each 2×2 square then are not
    /// independent.
    pub path_reuse: PathReuse,
    /// Whether some pixels get more samples than others, as `surelight_render::Renderer::adapt`
    /// decides. Particles from lights are not per pixel: their number is unchanged.
    pub adaptive: bool,
    /// Whether the environment lights the scene without showing to the camera. The film then has
    /// coverage (`surelight_film::Film::coverage`), and its radiance is premultiplied by it.
    pub transparent: bool,
    /// Renders with different seeds are independent.
    pub seed: u32,
    /// Diameter of a thin lens, metres; `None`: a pinhole.
    pub aperture: Option<f32>,
    /// Distance of the plane in focus, metres.
    pub focus: Option<f32>,
    /// Reflections of rough surfaces regain the energy that single scattering loses; glTF defines
    /// single scattering.
    pub multiple_scattering: bool,
    /// Clamp of a sample's components: biased.
    pub max_radiance: Option<f32>,
    /// Instead of a picture, each pixel estimates the radiance that a white Lambertian point at the
    /// camera's place, facing along its −Z, would send out: times π, the irradiance there.
    pub receiver: bool,
    /// How much time the BVH may take.
    pub build: BuildOptions,
}

impl Settings {
    /// Unlimited bounces, seed 0, a pinhole, unbiased.
    pub fn new(width: u32, height: u32) -> Self {
        Self {
            width,
            height,
            max_bounces: None,
            integrator: Integrator::default(),
            sampler: Sampler::default(),
            one_scramble: false,
            path_reuse: PathReuse::default(),
            adaptive: false,
            transparent: false,
            seed: 0,
            aperture: None,
            focus: None,
            max_radiance: None,
            multiple_scattering: false,
            receiver: false,
            build: BuildOptions::default(),
        }
    }
}
