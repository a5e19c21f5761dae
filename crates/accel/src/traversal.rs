//! The kernel's traversal on the CPU, over the same items and in the same order of operations; see
//! [`crate::item`].

use glam::Vec3;

use crate::{
    Accel, NO_INSTANCE,
    item::{Item, Kind, SLAB_PADDING},
    tree::MAX_STACK_DEPTH,
};

/// Direction components nearer to 0 are moved out to this before their reciprocal is taken.
pub const MIN_DIRECTION: f32 = f32::from_bits(67 << 23); // 2^-60

/// A child that is not entered, in the list of those that are.
const MISS: u32 = u32::MAX;

/// A ray in camera space.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Ray {
    /// Where it starts.
    pub origin: Vec3,
    /// Where it goes; need not be of unit length.
    pub direction: Vec3,
    /// Minimum distance of hits, in multiples of the direction; at least 0.
    pub t_min: f32,
    /// Maximum distance of hits; at most 1e30, which means no limit.
    pub t_max: f32,
}

impl Ray {
    /// Without a limit.
    pub fn new(origin: Vec3, direction: Vec3) -> Self {
        Self { origin, direction, t_min: 0.0, t_max: 1e30 }
    }
}

/// The nearest hit.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Hit {
    /// Distance in multiples of the direction.
    pub t: f32,
    /// Barycentric weight of the second corner.
    pub b1: f32,
    /// Barycentric weight of the third corner.
    pub b2: f32,
    /// Index into [`Accel::triangles`].
    pub prim: u32,
    /// Index into [`Accel::instances`], or [`crate::NO_INSTANCE`].
    pub instance: u32,
    /// Index into [`Accel::items`].
    pub item: u32,
}

/// Reciprocals of a direction's components, finite and with their signs.
pub fn safe_reciprocal(direction: Vec3) -> Vec3 {
    direction.abs().max(Vec3::splat(MIN_DIRECTION)).copysign(direction).recip()
}

/// A ray in the space of one level of the tree.
#[derive(Clone, Copy)]
struct Local {
    origin: Vec3,
    direction: Vec3,
    reciprocal: Vec3,
    /// Rows of the map that takes the direction to (0, 0, 1).
    x: Vec3,
    y: Vec3,
    z: Vec3,
}

impl Local {
    fn new(origin: Vec3, direction: Vec3) -> Self {
        let reciprocal = safe_reciprocal(direction);
        let a = direction.abs();
        // A shear along the greatest component keeps the other two coordinates.
        let (x, y, z) = if a.z >= a.x && a.z >= a.y {
            let s = -direction * reciprocal.z;
            (Vec3::new(1.0, 0.0, s.x), Vec3::new(0.0, 1.0, s.y), Vec3::new(0.0, 0.0, reciprocal.z))
        } else if a.y >= a.x {
            let s = -direction * reciprocal.y;
            (Vec3::new(0.0, s.z, 1.0), Vec3::new(1.0, s.x, 0.0), Vec3::new(0.0, reciprocal.y, 0.0))
        } else {
            let s = -direction * reciprocal.x;
            (Vec3::new(s.y, 1.0, 0.0), Vec3::new(s.z, 0.0, 1.0), Vec3::new(reciprocal.x, 0.0, 0.0))
        };
        Self { origin, direction, reciprocal, x, y, z }
    }

    /// Distance at which each child is entered.
    fn child_entries(&self, item: &Item, count: u32, t_min: f32, t_max: f32) -> [Option<f32>; 4] {
        let r = self.reciprocal;
        let m = item.step() * r;
        let n = (item.vec3(0) - self.origin) * r;
        // Near and far words by the sign bit, which −0 has too.
        let words = |axis: usize| {
            let (lo, hi) = (item.0[5 + axis], item.0[8 + axis]);
            if r[axis].is_sign_negative() { [hi, lo] } else { [lo, hi] }
        };
        let words = [words(0), words(1), words(2)];
        let mut out = [None; 4];
        for (c, stack_entry) in out.iter_mut().enumerate().take(count as usize) {
            let t = |side: usize, axis: usize| f32::from(words[axis][side].to_le_bytes()[c]) * m[axis] + n[axis];
            let near = t(0, 0).max(t(0, 1)).max(t(0, 2)).max(t_min);
            let far = (t(1, 0).min(t(1, 1)).min(t(1, 2)) * SLAB_PADDING).min(t_max);
            *stack_entry = (near <= far).then_some(near);
        }
        out
    }

    /// Distance to a triangle's plane, in lengths of the direction; no number where they are
    /// parallel.
    fn plane_distance(&self, [a, b, c]: [Vec3; 3]) -> f32 {
        let normal = (b - a).cross(c - a);
        normal.dot(a - self.origin) / normal.dot(self.direction)
    }

    /// Nearest hit of a pair: distance, weights of the second and third corner, and which triangle.
    fn hit(&self, item: &Item, t_min: f32, t_max: f32) -> Option<(f32, f32, f32, usize)> {
        let [v0, v1, v2, v3] = [0, 3, 6, 9].map(|w| item.vec3(w));
        let [p0, p1, p2, p3] = [v0, v1, v2, v3].map(|v| {
            let a = v - self.origin;
            Vec3::new(a.dot(self.x), a.dot(self.y), a.dot(self.z))
        });
        let edge = |p: Vec3, q: Vec3| p.x * q.y - q.x * p.y;
        let common = edge(p1, p2);
        let mut best: Option<(f32, f32, f32, usize)> = None;
        let triangles = [
            ([v0, v1, v2], [common, edge(p2, p0), edge(p0, p1)]),
            ([v3, v2, v1], [-common, edge(p1, p3), edge(p3, p2)]),
        ];
        for (k, (corners, [a, b, c])) in triangles.into_iter().enumerate() {
            let sum = a + b + c;
            let inside = a.min(b).min(c) >= 0.0 || a.max(b).max(c) <= 0.0;
            if inside && sum != 0.0 {
                let inverse = 1.0 / sum;
                let (b1, b2) = (b * inverse, c * inverse);
                let t = self.plane_distance(corners);
                if t > t_min && t < best.map_or(t_max, |h| h.0) {
                    best = Some((t, b1, b2, k));
                }
            }
        }
        best
    }
}

/// The children still to be visited, as a stack entry; `order` is sorted, [`MISS`] last.
fn stack_entry(base: u32, order: [u32; 3]) -> u32 {
    let first = order[0] & 3;
    let second = if order[1] == MISS { first } else { order[1] & 3 };
    let third = if order[2] == MISS { second } else { order[2] & 3 };
    base << 6 | first | second << 2 | third << 4
}

impl Accel {
    /// The nearest hit with `t_min` < t < `t_max`.
    pub fn intersect(&self, ray: &Ray) -> Option<Hit> {
        self.traverse(ray, false).0
    }

    /// Whether anything is hit with `t_min` < t < `t_max`.
    pub fn occluded(&self, ray: &Ray) -> bool {
        self.traverse(ray, true).0.is_some()
    }

    /// The nearest hit, and how many items were read to find it.
    pub fn intersect_counted(&self, ray: &Ray) -> (Option<Hit>, u32) {
        self.traverse(ray, false)
    }

    fn traverse(&self, ray: &Ray, any: bool) -> (Option<Hit>, u32) {
        let world = Local::new(ray.origin, ray.direction);
        let mut local = world;
        let mut instance = NO_INSTANCE;
        let mut best: Option<Hit> = None;
        let mut t_max = ray.t_max;
        let mut stack = [0u32; MAX_STACK_DEPTH as usize];
        let mut height = 0;
        // Of the stack where the instance was entered.
        let mut floor = 0;
        let mut at = 0u32;
        let mut steps = 0;
        loop {
            steps += 1;
            let item = &self.items[at as usize];
            let mut next = None;
            match item.kind() {
                Kind::Node(count) => {
                    // Distances are not negative, so their bits sort like integers; the two lowest
                    // make room for the child.
                    let mut order = [MISS; 4];
                    for (c, t) in local.child_entries(item, count, ray.t_min, t_max).into_iter().enumerate() {
                        if let Some(t) = t {
                            order[c] = t.to_bits() & !3 | c as u32;
                        }
                    }
                    order.sort_unstable();
                    if order[0] != MISS {
                        next = Some(item.0[4] + (order[0] & 3));
                    }
                    if order[1] != MISS {
                        stack[height] = stack_entry(item.0[4], [order[1], order[2], order[3]]);
                        height += 1;
                    }
                }
                Kind::Pair => {
                    if let Some((t, b1, b2, k)) = local.hit(item, ray.t_min, t_max) {
                        t_max = t;
                        best = Some(Hit { t, b1, b2, prim: item.0[12 + k], instance, item: at });
                        if any {
                            return (best, steps);
                        }
                    }
                }
                Kind::Instance => {
                    floor = height;
                    let rows = [(item.vec3(0), 3), (item.vec3(4), 7), (item.vec3(8), 12)];
                    local = Local::new(
                        Vec3::from_array(rows.map(|(row, shift)| row.dot(world.origin) + item.float(shift))),
                        Vec3::from_array(rows.map(|(row, _)| row.dot(world.direction))),
                    );
                    instance = item.0[14];
                    next = Some(item.0[13]);
                }
            }
            if next.is_none() && instance != NO_INSTANCE && height == floor {
                local = world;
                instance = NO_INSTANCE;
            }
            if next.is_none() && height > 0 {
                let top = stack[height - 1];
                let (first, second, third) = (top & 3, top >> 2 & 3, top >> 4 & 3);
                next = Some((top >> 6) + first);
                if first == second {
                    height -= 1;
                } else {
                    stack[height - 1] = top & !63 | second | third << 2 | third << 4;
                }
            }
            match next {
                Some(item) => at = item,
                None => return (best, steps),
            }
        }
    }
}

/// [`Local::child_entries`] for a node on its own.
#[cfg(test)]
pub(crate) fn child_entries_for_tests(item: &Item, origin: Vec3, direction: Vec3) -> [Option<f32>; 4] {
    let Kind::Node(count) = item.kind() else { return [None; 4] };
    Local::new(origin, direction).child_entries(item, count, 0.0, 1e30)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn entries_give_back_every_child_in_order() {
        for list in [&[2][..], &[3, 0], &[0, 3], &[1, 2, 0], &[3, 2, 1], &[0, 1, 2]] {
            let mut order = [MISS; 3];
            for (slot, c) in order.iter_mut().zip(list) {
                *slot = 1000 << 2 | c;
            }
            let mut top = stack_entry(0x3ff_fffe, order);
            let mut given = Vec::new();
            loop {
                assert!(top >> 6 == 0x3ff_fffe);
                let (first, second, third) = (top & 3, top >> 2 & 3, top >> 4 & 3);
                given.push(first);
                if first == second {
                    break;
                }
                top = top & !63 | second | third << 2 | third << 4;
            }
            assert_eq!(given, list);
        }
    }
}
