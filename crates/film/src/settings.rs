//! The settings of a render, as its files record them.
//!
//! The record is versioned and independent of the command line. In JSON, an absent field has its
//! default value. A change of meaning, or a new field, takes a new [`RenderSettings::VERSION`].

use serde::de::Error as _;
use serde::{Deserialize, Deserializer, Serialize};
use serde_json::value::RawValue;
use serde_json::{Map, Value};

use crate::Precision;

/// All settings that shape a picture, except the seed and the number of samples
/// ([`crate::Metadata`]) and the contents of the scene hash.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct RenderSettings {
    /// Format of the record: [`Self::VERSION`], or the number that an unreadable file states;
    /// 0 in files without one.
    pub version: u32,
    /// Name of the scene file, for display.
    pub scene: String,
    /// Width and height of the whole image, in pixels.
    pub size: [u32; 2],
    /// The camera.
    pub camera: Camera,
    /// Whether camera rays ignore the clipping planes of the camera.
    #[serde(skip_serializing_if = "is_default")]
    pub unclipped: bool,
    /// The thin lens; `None`: a pinhole.
    #[serde(skip_serializing_if = "is_default")]
    pub lens: Option<Lens>,
    /// Light from infinitely far away.
    #[serde(skip_serializing_if = "is_default")]
    pub environment: Environment,
    /// Limit on the scattering events of a path; `None`: unlimited.
    #[serde(skip_serializing_if = "is_default")]
    pub max_bounces: Option<u32>,
    /// The integrator.
    pub integrator: Integrator,
    /// How the integrator samples directions, where that is a choice.
    #[serde(skip_serializing_if = "is_default")]
    pub directions: Option<Directions>,
    /// The sampler.
    pub sampler: Sampler,
    /// Whether all batches of a pixel are pieces of one sequence: the estimated variance is then
    /// an upper bound.
    #[serde(skip_serializing_if = "is_default")]
    pub one_sequence: bool,
    /// Whether the pixels of each 2×2 square share paths: their errors are then correlated.
    #[serde(skip_serializing_if = "is_default")]
    pub path_reuse: bool,
    /// Whether samples are distributed by noise.
    #[serde(skip_serializing_if = "is_default")]
    pub adaptive: bool,
    /// Whether the environment is hidden from the camera, and alpha is coverage.
    #[serde(skip_serializing_if = "is_default")]
    pub transparent: bool,
    /// Whether rough reflections are compensated for multiple scattering.
    #[serde(skip_serializing_if = "is_default")]
    pub multiple_scattering: bool,
    /// Clamp of each sample; `None`: no clamp.
    #[serde(skip_serializing_if = "is_default")]
    pub max_radiance: Option<f32>,
    /// The precision at which the render stops.
    #[serde(skip_serializing_if = "is_default")]
    pub precision: Option<Precision>,
}

/// A camera.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Camera {
    /// Name in the scene file; empty for a camera of the command line.
    pub name: String,
    /// Camera-to-world matrix: three columns, then the translation.
    pub to_world: [f64; 12],
    /// The projection.
    pub projection: Projection,
}

/// How a camera maps the image plane to rays.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case", deny_unknown_fields)]
pub enum Projection {
    /// Rays through one point.
    Perspective {
        /// Full vertical field of view, radians.
        yfov: f64,
        /// Width over height that the scene file states.
        #[serde(default, skip_serializing_if = "is_default")]
        aspect: Option<f64>,
    },
    /// Parallel rays.
    Orthographic {
        /// Half the width of the view, metres.
        xmag: f64,
        /// Half the height of the view, metres.
        ymag: f64,
    },
}

/// A thin lens.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Lens {
    /// Diameter, metres.
    pub aperture: f32,
    /// Focus distance, metres.
    pub focus: f32,
}

/// Light from infinitely far away.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case", deny_unknown_fields)]
pub enum Environment {
    /// That of the scene file, if any.
    #[default]
    Scene,
    /// The same radiance from every direction.
    Uniform {
        /// Linear Rec. 709.
        radiance: [f32; 3],
    },
    /// An environment map.
    Map {
        /// Name of the file, for display.
        file: String,
        /// Rotation about the vertical axis, degrees.
        rotation: f32,
        /// Factor on the radiance.
        scale: f32,
    },
}

/// An estimator of the rendering equation.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Integrator {
    /// Sampling of directions.
    Hemisphere,
    /// Sampling of points on lights.
    Area,
    /// Both, by multiple importance sampling.
    #[default]
    Mis,
    /// Multiple importance sampling, with light tracing for caustics.
    Caustics,
    /// Whitted's ray tracing.
    Whitted,
}

/// A sampling of directions.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Directions {
    /// Uniform over the hemisphere.
    Uniform,
    /// Proportional to the cosine.
    Cosine,
    /// Proportional to the BSDF.
    Bsdf,
}

/// A point set.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Sampler {
    /// Independent random numbers.
    Independent,
    /// Jittered samples.
    Stratified,
    /// Owen-scrambled Sobol points.
    #[default]
    Sobol,
}

impl Default for Projection {
    fn default() -> Self {
        Self::Perspective { yfov: std::f64::consts::FRAC_PI_4, aspect: None }
    }
}

impl Default for RenderSettings {
    fn default() -> Self {
        Self {
            version: Self::VERSION,
            scene: String::new(),
            size: [0; 2],
            camera: Camera::default(),
            unclipped: false,
            lens: None,
            environment: Environment::default(),
            max_bounces: None,
            integrator: Integrator::default(),
            directions: None,
            sampler: Sampler::default(),
            one_sequence: false,
            path_reuse: false,
            adaptive: false,
            transparent: false,
            multiple_scattering: false,
            max_radiance: None,
            precision: None,
        }
    }
}

impl RenderSettings {
    /// The format of the record that this version of Surelight writes and reads.
    pub const VERSION: u32 = 1;

    /// Whether all fields were read. Of a record in another format, only [`Self::path_reuse`] and
    /// [`Self::transparent`] are: they determine how to read the pixels.
    pub fn is_current(&self) -> bool {
        self.version == Self::VERSION
    }

    /// Refuses a record in another format.
    pub(crate) fn check(&self) -> Result<(), String> {
        match self.version {
            Self::VERSION => Ok(()),
            0 => Err("its settings have no version: an older version of Surelight wrote it".into()),
            version => {
                let reads = Self::VERSION;
                Err(format!("its settings have version {version}, and this version of Surelight reads version {reads}"))
            }
        }
    }

    /// Reads the record of a file; of a record in another format, only the fields that
    /// [`Self::is_current`] names. An empty record is none.
    pub(crate) fn read<'de, D: Deserializer<'de>>(deserializer: D) -> Result<Option<Self>, D::Error> {
        // Read twice from the text: a `Value` holds f64, which may round an f32 twice.
        let raw = Box::<RawValue>::deserialize(deserializer)?;
        let fields: Map<String, Value> = serde_json::from_str(raw.get()).map_err(D::Error::custom)?;
        if fields.is_empty() {
            return Ok(None);
        }
        let version = fields.get("version").and_then(Value::as_u64).unwrap_or(0);
        let version = u32::try_from(version).unwrap_or(u32::MAX);
        if version == Self::VERSION {
            return serde_json::from_str(raw.get()).map(Some).map_err(D::Error::custom);
        }
        let flag = |name: &str| fields.get(name) == Some(&Value::Bool(true));
        Ok(Some(Self {
            version,
            // Records without a version name it by the command line's option.
            path_reuse: flag("path_reuse") || flag("shared-paths"),
            transparent: flag("transparent"),
            ..Self::default()
        }))
    }
}

fn is_default<T: Default + PartialEq>(value: &T) -> bool {
    *value == T::default()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{Bound, Metadata};

    fn read(settings: &str) -> Result<Metadata, serde_json::Error> {
        serde_json::from_str(&format!("{{\"batches\":4,\"settings\":{settings}}}"))
    }

    #[test]
    fn records_come_back_bit_for_bit() {
        let all = RenderSettings {
            scene: "日本.glb".into(),
            size: [5, 4],
            camera: Camera {
                name: "\"a\"".into(),
                to_world: std::array::from_fn(|i| 1.0 / (i as f64 - 3.7)),
                projection: Projection::Perspective { yfov: 0.1 + 0.2, aspect: Some(4.0 / 3.0) },
            },
            unclipped: true,
            lens: Some(Lens { aperture: 0.1, focus: f32::MIN_POSITIVE }),
            environment: Environment::Map { file: "sky.hdr".into(), rotation: -0.3, scale: f32::MAX },
            max_bounces: Some(0),
            integrator: Integrator::Hemisphere,
            directions: Some(Directions::Cosine),
            sampler: Sampler::Stratified,
            one_sequence: true,
            path_reuse: true,
            adaptive: true,
            transparent: true,
            multiple_scattering: true,
            max_radiance: Some(1e-45),
            precision: Some(Precision { error: 0.02, confidence: 0.99, bound: Bound::Chebyshev }),
            ..RenderSettings::default()
        };
        let camera = Camera { projection: Projection::Orthographic { xmag: 0.1, ymag: 1e-300 }, ..all.camera.clone() };
        let environment = Environment::Uniform { radiance: [0.1, 1e-45, 3.0] };
        let other = RenderSettings { camera, environment, ..RenderSettings::default() };
        for settings in [all, other, RenderSettings::default()] {
            let metadata = Metadata { settings: Some(settings), ..Metadata::default() };
            let json = serde_json::to_string(&metadata).unwrap();
            assert_eq!(serde_json::from_str::<Metadata>(&json).unwrap(), metadata, "{json}");
        }
    }

    #[test]
    fn absent_fields_have_their_defaults() {
        assert_eq!(read("{\"version\":1}").unwrap().settings, Some(RenderSettings::default()));
        let json = serde_json::to_value(RenderSettings::default()).unwrap();
        let names: Vec<_> = json.as_object().unwrap().keys().cloned().collect();
        assert_eq!(names, ["camera", "integrator", "sampler", "scene", "size", "version"]);
        assert_eq!(read("{}").unwrap().settings, None);
        assert_eq!(serde_json::to_value(Metadata::default()).unwrap().get("settings"), None);
    }

    /// The rest of the metadata, and the fields that determine how to read the pixels, are read
    /// whatever the format.
    #[test]
    fn other_formats_are_refused_in_words() {
        let old = "{\"camera\":{\"name\":\"\",\"projection\":\"Perspective { yfov: 0.5, aspect: None }\"},\
            \"integrator\":\"mis\",\"shared-paths\":true,\"transparent\":true,\"width\":8,\"height\":8}";
        let new = "{\"version\":7,\"path_reuse\":true,\"transparent\":true,\"camera\":3}";
        for (json, version, words) in [(old, 0, "an older version of Surelight"), (new, 7, "version 7")] {
            let metadata = read(json).unwrap();
            let settings = metadata.settings.clone().unwrap();
            assert_eq!((metadata.batches, settings.version, settings.is_current()), (4, version, false));
            assert!(metadata.reuses_paths() && metadata.is_transparent());
            assert!(settings.check().unwrap_err().contains(words));
        }
        assert_eq!(RenderSettings::default().check(), Ok(()));
        let huge = read("{\"version\":99999999999}").unwrap().settings.unwrap();
        assert!(huge.check().is_err());
    }

    #[test]
    fn fields_and_words_of_no_meaning_are_errors() {
        for json in ["{\"version\":1,\"x\":0}", "{\"version\":1,\"sampler\":\"x\"}", "{\"version\":1,\"size\":0}", "3"]
        {
            assert!(read(json).is_err(), "{json}");
        }
    }
}
