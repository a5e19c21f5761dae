//! Axis-aligned boxes in f32, rounded outward wherever they are computed rather than copied.

use glam::{DAffine3, DVec3, Vec3, Vec3A};
use obvhs::{aabb::Aabb, bvh2::node::Bvh2Node};

/// A closed axis-aligned box. Empty when `lo > hi` on some axis.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Bounds {
    /// Least coordinates.
    pub lo: Vec3,
    /// Greatest coordinates.
    pub hi: Vec3,
}

impl Bounds {
    /// Holds nothing; the neutral element of [`Bounds::union`].
    pub const EMPTY: Self = Self { lo: Vec3::splat(f32::MAX), hi: Vec3::splat(f32::MIN) };

    /// The least box around both.
    pub fn union(self, other: Self) -> Self {
        Self { lo: self.lo.min(other.lo), hi: self.hi.max(other.hi) }
    }

    /// Whether nothing is inside.
    pub fn is_empty(self) -> bool {
        self.lo.cmpgt(self.hi).any()
    }

    /// Half the surface area, as the surface area heuristic compares it; 0 when empty.
    pub fn half_area(self) -> f32 {
        let d = (self.hi - self.lo).max(Vec3::ZERO);
        (d.x + d.y) * d.z + d.x * d.y
    }

    /// The greatest absolute coordinate.
    pub(crate) fn reach(self) -> f32 {
        self.lo.abs().max(self.hi.abs()).max_element()
    }

    /// Grown by `margin` on every side of each axis, and outward by the rounding of that.
    pub(crate) fn padded(self, margin: Vec3) -> Self {
        Self { lo: next_down(self.lo - margin), hi: next_up(self.hi + margin) }
    }

    /// The box around this box after `affine`, in f64, grown by `margin` and rounded outward to
    /// f32.
    pub(crate) fn transformed(self, affine: &DAffine3, margin: DVec3) -> Self {
        let (lo, hi) = (self.lo.as_dvec3(), self.hi.as_dvec3());
        let center = affine.transform_point3((lo + hi) * 0.5);
        let half = (hi - lo) * 0.5;
        let m = affine.matrix3;
        // The f64 rounding itself is some 2^-50 of the coordinates: far below one step of f32.
        let reach = m.x_axis.abs() * half.x + m.y_axis.abs() * half.y + m.z_axis.abs() * half.z + margin;
        Self { lo: next_down((center - reach).as_vec3()), hi: next_up((center + reach).as_vec3()) }
    }

    pub(crate) fn to_aabb(self) -> Aabb {
        Aabb::new(Vec3A::from(self.lo), Vec3A::from(self.hi))
    }
}

fn next_down(v: Vec3) -> Vec3 {
    Vec3::new(v.x.next_down(), v.y.next_down(), v.z.next_down())
}

fn next_up(v: Vec3) -> Vec3 {
    Vec3::new(v.x.next_up(), v.y.next_up(), v.z.next_up())
}

/// Bounds of a node of the tree that obvhs builds.
pub(crate) fn bounds_of(node: &Bvh2Node) -> Bounds {
    Bounds { lo: node.min, hi: node.max }
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::{DMat3, DQuat};

    #[test]
    fn transformed_box_holds_every_transformed_corner() {
        let b = Bounds { lo: Vec3::new(-1.0, 2.0, 0.5), hi: Vec3::new(0.25, 2.0, 7.0) };
        for k in 0..50 {
            let turn = DMat3::from_quat(DQuat::from_euler(glam::EulerRot::XYZ, k as f64, 0.7 * k as f64, 0.3));
            let m = DAffine3 { matrix3: turn * 1e3, translation: DVec3::new(1e5, -3.0, k as f64) };
            let out = b.transformed(&m, DVec3::ZERO);
            for corner in 0..8 {
                let pick = |bit: usize, axis: usize| if corner >> bit & 1 == 0 { b.lo[axis] } else { b.hi[axis] };
                let p = m.transform_point3(Vec3::new(pick(0, 0), pick(1, 1), pick(2, 2)).as_dvec3());
                assert!(p.cmpge(out.lo.as_dvec3()).all() && p.cmple(out.hi.as_dvec3()).all(), "{p} outside {out:?}");
            }
        }
    }
}
