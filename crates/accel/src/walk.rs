//! The kernel's walk on the CPU, over the same items and in the same order of operations.

use glam::Vec3;

use crate::{
    Accel, Bounds, Item, Layout,
    item::{TAG_NODE, TAG_TRIANGLE},
    tree::MOST_STACK,
};

/// Factor on the far distance of a slab test, 1 + 2^-20; see the crate's documentation.
pub const SLAB_PADDING: f32 = 1.0 + 1.0 / (1 << 20) as f32;
/// Direction components nearer to 0 are moved out to this before their reciprocal is taken.
pub const LEAST_DIRECTION: f32 = f32::from_bits(67 << 23); // 2^-60
/// What the sum of two barycentric weights and its comparison with 1 may be off by: 2^-22.
pub const SUM_SLACK: f32 = 1.0 / (1 << 22) as f32;

/// Marks on the stack where an instance was entered. No item has this index.
const LEAVE_INSTANCE: u32 = u32::MAX;

/// A ray in camera space.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Ray {
    /// Where it starts.
    pub origin: Vec3,
    /// Where it goes; need not be of unit length.
    pub direction: Vec3,
    /// Hits count from here, in multiples of the direction; at least 0.
    pub t_min: f32,
    /// Hits count up to here; at most 1e30, which stands for no limit.
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
    direction.abs().max(Vec3::splat(LEAST_DIRECTION)).copysign(direction).recip()
}

/// A ray as one level of the tree sees it.
#[derive(Clone, Copy)]
struct Local {
    origin: Vec3,
    direction: Vec3,
    length: f32,
    reciprocal: Vec3,
}

impl Local {
    fn new(origin: Vec3, direction: Vec3) -> Self {
        Self { origin, direction, length: direction.length(), reciprocal: safe_reciprocal(direction) }
    }

    /// Distance at which a box is entered, at least `t_min`; none if it is missed or lies beyond `t_max`.
    fn enter(&self, b: Bounds, t_min: f32, t_max: f32) -> Option<f32> {
        let t0 = (b.lo - self.origin) * self.reciprocal;
        let t1 = (b.hi - self.origin) * self.reciprocal;
        let near = t0.min(t1).max_element().max(t_min);
        let far = (t0.max(t1).min_element() * SLAB_PADDING).min(t_max);
        (near <= far).then_some(near)
    }

    /// Möller and Trumbore, "Fast, minimum storage ray-triangle intersection" (1997), with the edges moved out by the
    /// bound on their own rounding; see [`crate::item`].
    fn hit(&self, item: &Item) -> Option<(f32, f32, f32)> {
        let (v0, e1, e2) = (item.vec3(0), item.vec3(4), item.vec3(8));
        let p = self.direction.cross(e2);
        let det = e1.dot(p);
        if det == 0.0 {
            return None;
        }
        let inverse = 1.0 / det;
        let s = self.origin - v0;
        let b1 = s.dot(p) * inverse;
        let q = s.cross(e1);
        let b2 = self.direction.dot(q) * inverse;
        let t = e2.dot(q) * inverse;
        let unit = self.length * inverse.abs();
        let away = s.abs().max_element() * unit;
        let (slack1, slack2) = (item.float(7) * away, item.float(11) * away);
        let slack = SUM_SLACK + slack1 + slack2 + item.float(12) * unit;
        (b1 >= -slack1 && b2 >= -slack2 && b1 + b2 <= 1.0 + slack).then_some((t, b1, b2))
    }
}

impl Accel {
    /// The nearest hit with `t_min` < t < `t_max`.
    pub fn intersect(&self, ray: &Ray) -> Option<Hit> {
        self.walk(ray, false).0
    }

    /// Whether anything is hit with `t_min` < t < `t_max`.
    pub fn occluded(&self, ray: &Ray) -> bool {
        self.walk(ray, true).0.is_some()
    }

    /// The nearest hit, and how many items were read to find it.
    pub fn intersect_counted(&self, ray: &Ray) -> (Option<Hit>, u32) {
        self.walk(ray, false)
    }

    fn walk(&self, ray: &Ray, any: bool) -> (Option<Hit>, u32) {
        match self.layout {
            Layout::Binary => self.walk_binary(ray, any),
            Layout::Wide => self.walk_wide(ray, any),
        }
    }

    fn walk_binary(&self, ray: &Ray, any: bool) -> (Option<Hit>, u32) {
        let world = Local::new(ray.origin, ray.direction);
        let mut local = world;
        let mut instance = crate::NO_INSTANCE;
        let mut best: Option<Hit> = None;
        let mut t_max = ray.t_max;
        let mut stack = [0u32; MOST_STACK as usize];
        let mut height = 0;
        let mut at = 0u32;
        let mut steps = 0;
        loop {
            steps += 1;
            let item = &self.items[at as usize];
            let mut next = None;
            match item.tag() {
                TAG_NODE => {
                    let enter = |k| local.enter(item.child_bounds(k), ray.t_min, t_max);
                    match (enter(0), enter(1)) {
                        (Some(a), Some(b)) => {
                            let near = usize::from(b < a);
                            stack[height] = item.child(1 - near);
                            height += 1;
                            next = Some(item.child(near));
                        }
                        (Some(_), None) => next = Some(item.child(0)),
                        (None, Some(_)) => next = Some(item.child(1)),
                        (None, None) => {}
                    }
                }
                TAG_TRIANGLE => {
                    if let Some((t, b1, b2)) = local.hit(item)
                        && t > ray.t_min
                        && t < t_max
                    {
                        t_max = t;
                        best = Some(Hit { t, b1, b2, prim: item.0[3], instance, item: at });
                        if any {
                            return (best, steps);
                        }
                    }
                    next = item.more().then_some(at + 1);
                }
                _ => {
                    // An instance stands alone in its leaf, so nothing of this leaf has to wait on the stack.
                    stack[height] = LEAVE_INSTANCE;
                    height += 1;
                    let row = |k: usize| (item.vec3(4 * k), item.float(4 * k + 3));
                    let rows = [row(0), row(1), row(2)];
                    local = Local::new(
                        Vec3::from_array(rows.map(|(r, shift)| r.dot(world.origin) + shift)),
                        Vec3::from_array(rows.map(|(r, _)| r.dot(world.direction))),
                    );
                    instance = item.0[13];
                    next = Some(item.0[12]);
                }
            }
            while next.is_none() && height > 0 {
                height -= 1;
                if stack[height] == LEAVE_INSTANCE {
                    local = world;
                    instance = crate::NO_INSTANCE;
                } else {
                    next = Some(stack[height]);
                }
            }
            match next {
                Some(item) => at = item,
                None => return (best, steps),
            }
        }
    }
}
