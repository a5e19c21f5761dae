//! Checked triangles, the primitives of the trees.

use glam::Vec3;

use crate::Bounds;

/// Coordinates beyond this are treated as not finite: areas and determinants of such triangles
/// overflow f32.
pub const COORDINATE_LIMIT: f32 = 1e18;

/// A sound triangle in f32.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Triangle(pub(crate) [Vec3; 3]);

/// Why a triangle is left out.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Defect {
    NonFinite,
    ZeroArea,
}

impl Triangle {
    pub(crate) fn new([v0, v1, v2]: [Vec3; 3]) -> Result<Self, Defect> {
        // NaN fails the comparison, so this is one test for NaN, ∞ and coordinates that are too
        // large.
        if [v0, v1, v2].iter().any(|v| !v.abs().cmple(Vec3::splat(COORDINATE_LIMIT)).all()) {
            return Err(Defect::NonFinite);
        }
        let triangle = Self([v0, v1, v2]);
        let [e1, e2] = triangle.edges();
        // Products of f32 are exact in f64, so this is zero only when the rounded edges really are
        // parallel.
        if e1.as_dvec3().cross(e2.as_dvec3()) == glam::DVec3::ZERO {
            return Err(Defect::ZeroArea);
        }
        Ok(triangle)
    }

    /// v1 − v0 and v2 − v0, rounded as in the kernel.
    fn edges(&self) -> [Vec3; 2] {
        let [v0, v1, v2] = self.0;
        [v1 - v0, v2 - v0]
    }

    /// The distance of a box from the corners, per axis: a few 2^-24 of the edges, and of the
    /// distance of a ray that starts about the origin, for which the slab test rounds by as much.
    /// `reach` is that distance. Larger than 0 on every axis, so that no face of a box touches its
    /// contents.
    fn margin(&self, reach: f32) -> Vec3 {
        let [e1, e2] = self.edges();
        (e1.abs() + e2.abs()) / (1 << 22) as f32 + reach / (1 << 22) as f32
    }

    /// The box without any margin.
    pub(crate) fn tight(&self) -> Bounds {
        let [a, b, c] = self.0;
        Bounds { lo: a.min(b).min(c), hi: a.max(b).max(c) }
    }

    /// The box that the tree stores; `mesh_reach` is the greatest coordinate of a mesh that is
    /// placed as instances (its rays come from anywhere around it) and 0 for triangles in camera
    /// space.
    pub(crate) fn bounds(&self, mesh_reach: f32) -> Bounds {
        let tight = self.tight();
        tight.padded(self.margin(tight.reach().max(mesh_reach)))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn defects_are_distinguished() {
        let (a, b, c) = (Vec3::ZERO, Vec3::X, Vec3::Y);
        assert!(Triangle::new([a, b, c]).is_ok());
        for bad in [f32::NAN, f32::INFINITY, f32::NEG_INFINITY, 2e18] {
            for slot in 0..9 {
                let mut v = [a, b, c];
                v[slot / 3][slot % 3] = bad;
                assert_eq!(Triangle::new(v), Err(Defect::NonFinite), "{bad} in slot {slot}");
            }
        }
        for v in [[a, a, a], [a, b, b], [a, a, b], [a, b, b * 3.0], [b * 1e-30, b * 3e-30, b * 2e-30]] {
            assert_eq!(Triangle::new(v), Err(Defect::ZeroArea), "{v:?}");
        }
        // A needle of aspect 1e6 and a triangle of 1e-12 are no defects.
        assert!(Triangle::new([a, b, Vec3::new(0.5, 1e-6, 0.0)]).is_ok());
        assert!(Triangle::new([a, b * 1e-12, c * 1e-12]).is_ok());
    }

    #[test]
    fn boxes_hold_the_given_corners_and_a_margin_on_every_axis() {
        let v = [Vec3::new(-1000.0, 5.0, 0.001), Vec3::new(0.001, 5.0, 3.0), Vec3::new(7.0, 5.0, -2.0)];
        let b = Triangle::new(v).unwrap().bounds(0.0);
        for p in v {
            assert!(p.cmpgt(b.lo).all() && p.cmplt(b.hi).all());
        }
        assert!(b.hi.y - b.lo.y < 1e-3);
    }
}
