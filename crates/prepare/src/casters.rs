//! Where light may be mirrored or bent: balls around every surface that may scatter by a delta.
//!
//! Particles from the lights are sent towards these alone, so no such surface may be outside of all
//! balls.

use glam::{DVec3, Vec3};
use surelight_scene::Scene;

/// Maximum number of balls. Each particle tests every ball.
const MAX_BALLS: usize = 16;

/// Halvings of space that balls are fitted to.
const DEPTH: u32 = 7;

/// Relative cost that each additional ball must save.
const EACH: f64 = 0.02;

/// Balls are larger than their contents by this share: rounding must not leave an edge outside.
const MARGIN: f64 = 1e-3;

/// A ball in camera space.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Ball {
    pub(crate) center: DVec3,
    pub(crate) radius: f64,
}

/// Balls, and the sum of their squared radii, which is proportional to the area that particles are
/// spread over.
#[derive(Clone, Debug, Default)]
struct Cover {
    balls: Vec<Ball>,
    cost: f64,
}

impl Cover {
    fn new(ball: Ball) -> Self {
        Self { balls: vec![ball], cost: ball.radius * ball.radius }
    }
}

/// Corners, in camera space, of all triangles whose material is among those that are `wanted`.
pub(crate) fn triangles(scene: &Scene, origin: DVec3, wanted: &[bool]) -> Vec<[Vec3; 3]> {
    let mut found = Vec::new();
    for instance in &scene.instances {
        let mesh = &scene.meshes[instance.mesh];
        if !wanted[mesh.material] {
            continue;
        }
        let place = |p: Vec3| (instance.to_world.transform_point3(p.as_dvec3()) - origin).as_vec3();
        for triangle in &mesh.triangles {
            let corners = triangle.map(|c| place(mesh.positions[c as usize]));
            if corners.iter().all(|c| c.is_finite()) {
                found.push(corners);
            }
        }
    }
    found
}

/// The ball about the middle of a box around some triangles.
fn ball_around(triangles: &[[Vec3; 3]]) -> Ball {
    let points = || triangles.iter().flatten().map(|p| p.as_dvec3());
    let low = points().fold(DVec3::INFINITY, DVec3::min);
    let high = points().fold(DVec3::NEG_INFINITY, DVec3::max);
    let center = (low + high) * 0.5;
    // The kernel gets rounded values.
    let center = center.as_vec3().as_dvec3();
    let reach = points().map(|p| p.distance(center)).fold(0.0, f64::max);
    Ball { center, radius: reach * (1.0 + MARGIN) + 1e-6 * center.abs().max_element() + 1e-30 }
}

/// The cheapest covers of some triangles by 1, 2, … balls.
fn covers(triangles: &mut [[Vec3; 3]], depth: u32) -> Vec<Cover> {
    let mut best = vec![Cover::new(ball_around(triangles))];
    if depth == 0 || triangles.len() < 2 {
        return best;
    }
    // Halved in space, not in number: fine tessellation must not attract balls.
    let middle = |t: &[Vec3; 3]| (t[0] + t[1] + t[2]) / 3.0;
    let low = triangles.iter().map(middle).fold(Vec3::INFINITY, Vec3::min);
    let high = triangles.iter().map(middle).fold(Vec3::NEG_INFINITY, Vec3::max);
    let axis = (high - low).max_position();
    let at = (0.5 * (low + high))[axis];
    let mut split = 0;
    for i in 0..triangles.len() {
        if middle(&triangles[i])[axis] < at {
            triangles.swap(i, split);
            split += 1;
        }
    }
    if split == 0 || split == triangles.len() {
        return best;
    }
    let (left, right) = triangles.split_at_mut(split);
    let (left, right) = (covers(left, depth - 1), covers(right, depth - 1));
    for a in &left {
        for b in &right {
            let (count, cost) = (a.balls.len() + b.balls.len(), a.cost + b.cost);
            if count > MAX_BALLS {
                continue;
            }
            if best.len() < count {
                best.resize(count, Cover { balls: Vec::new(), cost: f64::INFINITY });
            }
            if cost < best[count - 1].cost {
                let balls = a.balls.iter().chain(&b.balls).copied().collect();
                best[count - 1] = Cover { balls, cost };
            }
        }
    }
    best.retain(|cover| !cover.balls.is_empty());
    best
}

/// Few balls around all triangles; none where there are no triangles.
pub(crate) fn cover(mut triangles: Vec<[Vec3; 3]>) -> Vec<Ball> {
    if triangles.is_empty() {
        return Vec::new();
    }
    let total_cost = |cover: &Cover| cover.cost * (1.0 + EACH * cover.balls.len() as f64);
    let all = covers(&mut triangles, DEPTH);
    all.into_iter().min_by(|a, b| total_cost(a).total_cmp(&total_cost(b))).map(|cover| cover.balls).unwrap_or_default()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn specks(places: &[Vec3]) -> Vec<[Vec3; 3]> {
        places.iter().map(|&p| [p, p + 0.01 * Vec3::X, p + 0.01 * Vec3::Y]).collect()
    }

    #[test]
    fn everything_is_in_a_ball() {
        let places: Vec<Vec3> =
            (0..500).map(|i| Vec3::new((i * 37 % 101) as f32, (i * 61 % 97) as f32, (i % 7) as f32)).collect();
        let balls = cover(specks(&places));
        assert!(balls.len() <= MAX_BALLS && balls.len() > 1, "{}", balls.len());
        for corner in specks(&places).iter().flatten() {
            assert!(balls.iter().any(|b| b.center.distance(corner.as_dvec3()) <= b.radius), "{corner}");
        }
    }

    #[test]
    fn separate_casters_have_separate_balls() {
        let balls = cover(specks(&[Vec3::ZERO, Vec3::X * 5.0, Vec3::X * 5.005]));
        assert_eq!(balls.len(), 2);
        assert!(balls.iter().all(|b| b.radius < 0.02), "{balls:?}");
        assert!(cover(Vec::new()).is_empty());
    }
}
