//! Sets of parts.

use super::table::{Part, TABLE};

/// A set of parts.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub struct Parts(u128);

impl Parts {
    /// Parts that exclude one another, and are kept as choices ([`super::Estimator`],
    /// [`super::CameraModel`], …).
    pub const CHOICES: Self = Self::of(&[
        Part::Caustics,
        Part::PathReuse,
        Part::Hemisphere,
        Part::Area,
        Part::Whitted,
        Part::DirectionsUniform,
        Part::DirectionsCosine,
        Part::SamplerIndependent,
        Part::SamplerStratified,
        Part::OneScramble,
        Part::Orthographic,
        Part::Lens,
        Part::Receiver,
        Part::EnvironmentUniform,
        Part::EnvironmentMap,
    ]);

    /// The set of these.
    pub const fn of(parts: &[Part]) -> Self {
        let (mut bits, mut i) = (0, 0);
        while i < parts.len() {
            bits |= 1 << parts[i] as u32;
            i += 1;
        }
        Self(bits)
    }

    /// Whether it has the part.
    pub const fn has(self, part: Part) -> bool {
        self.0 >> part as u32 & 1 == 1
    }

    /// With a part more.
    pub const fn with(self, part: Part) -> Self {
        Self(self.0 | 1 << part as u32)
    }

    /// With a part more where the condition holds.
    pub fn with_if(self, condition: bool, part: Part) -> Self {
        if condition { self.with(part) } else { self }
    }

    /// Without a part.
    pub const fn without(self, part: Part) -> Self {
        Self(self.0 & !(1 << part as u32))
    }

    /// Without all parts of another set.
    pub const fn without_all(self, other: Self) -> Self {
        Self(self.0 & !other.0)
    }

    /// The parts of either set.
    pub const fn union(self, other: Self) -> Self {
        Self(self.0 | other.0)
    }

    /// Its parts, in the order of the table.
    pub fn iter(self) -> impl Iterator<Item = Part> {
        TABLE.iter().map(|row| row.part).filter(move |&part| self.has(part))
    }
}

impl FromIterator<Part> for Parts {
    fn from_iter<I: IntoIterator<Item = Part>>(parts: I) -> Self {
        parts.into_iter().fold(Self::default(), Self::with)
    }
}
