//! The parts of a kernel: decided by scene, settings and device before compilation.
//!
//! A part that a scene lacks is absent from its kernel, its bindings and its records.

mod parts;
mod reasons;
mod table;

use std::fmt;

pub use self::parts::Parts;
pub use self::table::{Origin, Part, Row, TABLE};

use crate::settings::{Directions, Sampler};

/// How paths are sampled.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub enum Estimator {
    /// Light sampling and BSDF sampling by multiple importance sampling.
    #[default]
    Mis,
    /// [`Self::Mis`], where the four pixels of a square reuse one another's paths.
    PathReuse,
    /// [`Self::Mis`], with light that mirrors and smooth glass send to scattering surfaces traced
    /// from the lights.
    LightTracing,
    /// Directions alone.
    Hemisphere(Directions),
    /// Points on lights alone.
    Area,
    /// Whitted's ray tracing (biased).
    Whitted,
}

impl Estimator {
    /// All of them.
    pub const ALL: [Self; 8] = [
        Self::Mis,
        Self::PathReuse,
        Self::LightTracing,
        Self::Hemisphere(Directions::Uniform),
        Self::Hemisphere(Directions::Cosine),
        Self::Hemisphere(Directions::Bsdf),
        Self::Area,
        Self::Whitted,
    ];
}

/// The camera model.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub enum CameraModel {
    /// A pinhole.
    #[default]
    Pinhole,
    /// A thin lens.
    ThinLens,
    /// Parallel rays.
    Orthographic,
    /// A white receiver: irradiance is measured.
    Receiver,
}

impl CameraModel {
    /// All of them.
    pub const ALL: [Self; 4] = [Self::Pinhole, Self::ThinLens, Self::Orthographic, Self::Receiver];
}

/// Light from far away.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub enum EnvironmentKind {
    /// None.
    #[default]
    Black,
    /// The same radiance from all directions.
    Uniform,
    /// An environment map.
    Map,
}

impl EnvironmentKind {
    /// All of them.
    pub const ALL: [Self; 3] = [Self::Black, Self::Uniform, Self::Map];
}

/// The source of random numbers.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub enum PointSet {
    /// Sobol points, each batch with a separate scramble.
    #[default]
    Sobol,
    /// All batches of a pixel are pieces of one Sobol sequence.
    OneSobolSequence,
    /// Jittered strata.
    Stratified,
    /// Independent numbers.
    Independent,
}

impl PointSet {
    /// All of them.
    pub const ALL: [Self; 4] = [Self::Sobol, Self::OneSobolSequence, Self::Stratified, Self::Independent];

    /// Those of a sampler.
    pub fn new(sampler: Sampler, one_scramble: bool) -> Self {
        match sampler {
            Sampler::Independent => Self::Independent,
            Sampler::Stratified => Self::Stratified,
            Sampler::Sobol if one_scramble => Self::OneSobolSequence,
            Sampler::Sobol => Self::Sobol,
        }
    }
}

/// The parts of a kernel. Two kernels of one key and the same constants are the same program.
///
/// A key is consistent by construction: it has everything that its parts need ([`Row::needs`]) and
/// nothing that they exclude. Kernels without bounds checks depend on it, so it cannot be changed
/// from outside.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub struct KernelKey {
    estimator: Estimator,
    points: PointSet,
    camera: CameraModel,
    surroundings: EnvironmentKind,
    /// Everything else.
    parts: Parts,
}

/// Parts that cannot be together.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum KeyError {
    /// One excludes the other.
    Excluded {
        /// The part that excludes.
        part: &'static str,
        /// The part that is excluded.
        other: &'static str,
        /// Why.
        why: &'static str,
    },
    /// It needs one of several, and has none.
    Lacks {
        /// The part.
        part: &'static str,
    },
    /// Two alternatives: a kernel has one estimator, one camera, one environment and one sampler.
    Alternatives {
        /// The part that comes second.
        part: &'static str,
    },
    /// No part has this name.
    Unknown {
        /// The name.
        name: String,
    },
}

impl fmt::Display for KeyError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Excluded { part, other, why } => write!(f, "{part} excludes {other}: {why}"),
            Self::Lacks { part } => write!(f, "{part} needs one of several parts, and the kernel has none of them"),
            Self::Alternatives { part } => write!(f, "{part} is an alternative to another part of the kernel"),
            Self::Unknown { name } => write!(f, "no part of a kernel is called {name}"),
        }
    }
}

impl std::error::Error for KeyError {}

impl KernelKey {
    /// A kernel of these choices and parts, and of all that the parts need.
    ///
    /// # Errors
    /// Where parts exclude one another, or lack all alternatives of a requirement.
    pub fn new(
        estimator: Estimator,
        points: PointSet,
        camera: CameraModel,
        surroundings: EnvironmentKind,
        parts: Parts,
    ) -> Result<Self, KeyError> {
        let mut key = Self { estimator, points, camera, surroundings, parts };
        loop {
            let needed = key.rows().flat_map(|row| row.needs).fold(key.parts, |all, &part| all.with(part));
            // Alternatives are no parts to be added.
            let needed = needed.without_all(Parts::CHOICES);
            if needed == key.parts {
                break;
            }
            key.parts = needed;
        }
        key.check()?;
        Ok(key)
    }

    /// A kernel that samples points and nothing else.
    pub fn of_points(points: PointSet) -> Self {
        Self { points, ..Self::default() }
    }

    /// A kernel of the parts with these names, and of all that they need.
    ///
    /// # Errors
    /// Where a name is unknown, or as [`Self::new`].
    pub fn from_names(names: &[&str]) -> Result<Self, KeyError> {
        let mut key = Self::default();
        let mut parts = Parts::default();
        for name in names {
            let row = TABLE.iter().find(|row| row.name == *name);
            let part = row.ok_or_else(|| KeyError::Unknown { name: (*name).to_owned() })?.part;
            parts = parts.with(part);
            // A requirement of a choice may be another choice.
            parts = row.into_iter().flat_map(|row| row.needs).fold(parts, |all, &part| all.with(part));
        }
        let taken = |part: Part| KeyError::Alternatives { part: TABLE[part as usize].name };
        for part in parts.iter() {
            let free = match part {
                Part::Caustics => set(&mut key.estimator, Estimator::LightTracing),
                Part::PathReuse => set(&mut key.estimator, Estimator::PathReuse),
                Part::Area => set(&mut key.estimator, Estimator::Area),
                Part::Whitted => set(&mut key.estimator, Estimator::Whitted),
                Part::Hemisphere => {
                    let directions = match (parts.has(Part::DirectionsUniform), parts.has(Part::DirectionsCosine)) {
                        (true, true) => return Err(taken(Part::DirectionsCosine)),
                        (true, false) => Directions::Uniform,
                        (false, true) => Directions::Cosine,
                        (false, false) => Directions::Bsdf,
                    };
                    set(&mut key.estimator, Estimator::Hemisphere(directions))
                }
                Part::SamplerIndependent => set(&mut key.points, PointSet::Independent),
                Part::SamplerStratified => set(&mut key.points, PointSet::Stratified),
                Part::OneScramble => set(&mut key.points, PointSet::OneSobolSequence),
                Part::Orthographic => set(&mut key.camera, CameraModel::Orthographic),
                Part::Lens => set(&mut key.camera, CameraModel::ThinLens),
                Part::Receiver => set(&mut key.camera, CameraModel::Receiver),
                Part::EnvironmentUniform => set(&mut key.surroundings, EnvironmentKind::Uniform),
                Part::EnvironmentMap => set(&mut key.surroundings, EnvironmentKind::Map),
                _ => true,
            };
            if !free {
                return Err(taken(part));
            }
        }
        Self::new(key.estimator, key.points, key.camera, key.surroundings, parts.without_all(Parts::CHOICES))
    }

    /// Whether a kernel has the part.
    pub fn has(&self, part: Part) -> bool {
        self.parts.has(part) || self.chosen().has(part)
    }

    /// The rows of the parts that the kernel has.
    pub fn rows(&self) -> impl Iterator<Item = &'static Row> + use<> {
        let all = self.parts.union(self.chosen());
        TABLE.iter().filter(move |row| all.has(row.part))
    }

    /// How paths are sampled.
    pub fn estimator(&self) -> Estimator {
        self.estimator
    }

    /// Whether neighbouring pixels reuse one another's paths.
    pub fn reuses_paths(&self) -> bool {
        self.estimator == Estimator::PathReuse
    }

    /// Whether all batches of a pixel are pieces of one sequence.
    pub fn is_one_sequence(&self) -> bool {
        self.points == PointSet::OneSobolSequence
    }

    /// The source of random numbers.
    pub fn points(&self) -> PointSet {
        self.points
    }

    /// The same by another estimator.
    ///
    /// # Errors
    /// Where a part excludes it.
    pub fn with_estimator(self, estimator: Estimator) -> Result<Self, KeyError> {
        Self::new(estimator, self.points, self.camera, self.surroundings, self.parts)
    }

    /// Why a part of the kernel excludes a estimator; `None`: nothing does.
    pub fn objection(&self, estimator: Estimator) -> Option<&'static str> {
        match (Self { estimator, ..*self }).check() {
            Err(KeyError::Excluded { why, .. }) => Some(why),
            _ => None,
        }
    }

    /// The key of the kernel that records first hits of the same scene: it traces no paths.
    pub fn first_hits(self) -> Self {
        let estimator = if self.estimator == Estimator::PathReuse { Estimator::Mis } else { self.estimator };
        Self { estimator, ..self }
    }

    /// The same, reading the scene from storage images or from buffers.
    pub fn on_images(self, images: bool) -> Self {
        let parts = if images { self.parts.with(Part::ItemsImage) } else { self.parts.without(Part::ItemsImage) };
        Self { parts, ..self }
    }

    /// The same with a part that measurements and tests need, and that excludes nothing.
    pub(crate) fn instrumented(self, part: Part) -> Self {
        debug_assert!(matches!(part, Part::NoRoulette | Part::RepeatWalk));
        Self { parts: self.parts.with(part), ..self }
    }

    /// The choices as parts.
    fn chosen(&self) -> Parts {
        let estimator: &[Part] = match self.estimator {
            Estimator::Mis => &[],
            Estimator::PathReuse => &[Part::PathReuse],
            Estimator::LightTracing => &[Part::Caustics],
            Estimator::Hemisphere(Directions::Bsdf) => &[Part::Hemisphere],
            Estimator::Hemisphere(Directions::Uniform) => &[Part::Hemisphere, Part::DirectionsUniform],
            Estimator::Hemisphere(Directions::Cosine) => &[Part::Hemisphere, Part::DirectionsCosine],
            Estimator::Area => &[Part::Area],
            Estimator::Whitted => &[Part::Whitted],
        };
        let points = match self.points {
            PointSet::Sobol => None,
            PointSet::OneSobolSequence => Some(Part::OneScramble),
            PointSet::Stratified => Some(Part::SamplerStratified),
            PointSet::Independent => Some(Part::SamplerIndependent),
        };
        let camera = match self.camera {
            CameraModel::Pinhole => None,
            CameraModel::ThinLens => Some(Part::Lens),
            CameraModel::Orthographic => Some(Part::Orthographic),
            CameraModel::Receiver => Some(Part::Receiver),
        };
        let surroundings = match self.surroundings {
            EnvironmentKind::Black => None,
            EnvironmentKind::Uniform => Some(Part::EnvironmentUniform),
            EnvironmentKind::Map => Some(Part::EnvironmentMap),
        };
        let others = [points, camera, surroundings].into_iter().flatten();
        estimator.iter().copied().chain(others).collect()
    }

    fn check(&self) -> Result<(), KeyError> {
        for row in self.rows() {
            if let Some((other, why)) = row.excludes.iter().find(|(other, _)| self.has(*other)) {
                return Err(KeyError::Excluded { part: row.name, other: TABLE[*other as usize].name, why });
            }
            if !row.needs_one_of.is_empty() && !row.needs_one_of.iter().any(|&part| self.has(part)) {
                return Err(KeyError::Lacks { part: row.name });
            }
        }
        Ok(())
    }
}

/// Sets a choice that is still the default.
fn set<T: Default + PartialEq>(choice: &mut T, value: T) -> bool {
    let free = *choice == T::default();
    *choice = value;
    free
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn rows_are_in_the_order_of_parts_and_have_names_of_their_own() {
        for (i, row) in TABLE.iter().enumerate() {
            assert_eq!(row.part as usize, i);
            assert!(TABLE[..i].iter().all(|other| other.name != row.name), "{}", row.name);
            assert!(row.meaning.ends_with('.') && row.meaning.len() < 100, "{}", row.name);
        }
    }

    #[test]
    fn a_key_has_what_its_parts_need() {
        let key = KernelKey::from_names(&["clearcoat_normal_texture"]).unwrap();
        for name in ["clearcoat_normal_texture", "textures", "tangents", "clearcoat", "ggx"] {
            assert!(key.rows().any(|row| row.name == name), "{name}");
        }
        assert_eq!(key.rows().count(), 5);
        let key = KernelKey::from_names(&["directions_cosine"]).unwrap();
        assert_eq!(key.estimator(), Estimator::Hemisphere(Directions::Cosine));
        assert!(key.has(Part::Hemisphere));
    }

    #[test]
    fn what_cannot_be_together_is_refused_with_the_reason() {
        for (names, words) in [
            (&["hemisphere", "area"][..], "alternative"),
            (&["directions_uniform", "directions_cosine"], "alternative"),
            (&["lens", "receiver"], "alternative"),
            (&["hemisphere", "punctual_lights"], "directions alone"),
            (&["caustics", "punctual_lights", "nested"], "volumes overlap"),
            (&["path_reuse", "dispersion"], "colour"),
            (&["light_sampling"], "needs one of"),
            (&["no_such_part"], "called no_such_part"),
        ] {
            let error = KernelKey::from_names(names).unwrap_err().to_string();
            assert!(error.contains(words), "{names:?}: {error}");
        }
    }

    #[test]
    fn first_hits_reuse_no_paths() {
        let key = KernelKey::from_names(&["path_reuse", "punctual_lights"]).unwrap();
        assert_eq!((key.estimator(), key.first_hits().estimator()), (Estimator::PathReuse, Estimator::Mis));
        assert!(
            key.on_images(true).has(Part::ItemsImage) && !key.on_images(true).on_images(false).has(Part::ItemsImage)
        );
    }
}
