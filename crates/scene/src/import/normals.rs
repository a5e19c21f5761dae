//! Vertex normals: normalised, and repaired where they cannot be.

use glam::{DVec3, Vec3};

/// The result of [`normalise`].
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Repair {
    /// All could be normalised.
    None,
    /// So many vertices got the mean normal of their triangles instead.
    Some(usize),
    /// No vertex has a usable normal: the mesh is flat.
    All,
}

/// Makes every normal a unit vector. Zero and non-finite ones are replaced by the area-weighted
/// mean of the triangles around the vertex.
pub(crate) fn normalise(normals: &mut [Vec3], positions: &[Vec3], triangles: &[[u32; 3]]) -> Repair {
    let mut bad = 0;
    for normal in normals.iter_mut() {
        match unit(*normal) {
            Some(unit) => *normal = unit,
            None => {
                *normal = Vec3::ZERO;
                bad += 1;
            }
        }
    }
    if bad == 0 {
        return Repair::None;
    }
    if bad == normals.len() {
        return Repair::All;
    }
    let mut sums = vec![DVec3::ZERO; normals.len()];
    for triangle in triangles {
        let [a, b, c] = triangle.map(|i| positions[i as usize].as_dvec3());
        let area = (b - a).cross(c - a);
        if area.is_finite() {
            for &i in triangle {
                sums[i as usize] += area;
            }
        }
    }
    for (normal, sum) in normals.iter_mut().zip(sums) {
        if *normal == Vec3::ZERO {
            *normal = sum.try_normalize().map_or(Vec3::Z, |n| n.as_vec3());
        }
    }
    Repair::Some(bad)
}

/// The unit vector along `v`; `None` for zero and non-finite ones.
pub(crate) fn unit(v: Vec3) -> Option<Vec3> {
    let length_squared = v.length_squared();
    // Already unit to rounding: keep the bits of the file.
    if (length_squared - 1.0).abs() < 1e-6 {
        return Some(v);
    }
    // In f64 neither the squares of tiny nor those of huge components leave the range.
    let v = v.as_dvec3();
    v.is_finite().then(|| v.try_normalize()).flatten().map(|n| n.as_vec3())
}

/// The unit normal of a triangle; `None` when it has no area or is not finite.
pub(crate) fn face(positions: &[Vec3], triangle: [u32; 3]) -> Option<Vec3> {
    let [a, b, c] = triangle.map(|i| positions[i as usize].as_dvec3());
    let normal = (b - a).cross(c - a);
    normal.is_finite().then(|| normal.try_normalize()).flatten().map(|n| n.as_vec3())
}
