//! How light reaches the surfaces of a scene: directly, or first by mirrors and smooth glass.
//!
//! Next-event estimation connects a path to a light at a vertex that scatters. Light whose first event is a delta (a mirror, smooth
//! glass) is connected by no vertex: directions must happen to find its source, and a light without extent is never found. This
//! module measures how much light that is, and how noisy finding it by chance would be, with some ten thousand rays from the
//! lights, on the host. [`Integrator::Auto`](super::Integrator::Auto) decides by it, and the summary reports what stays missing.
//!
//! Rays from the lights are photons: some go anywhere and land on the first surface that scatters; others are aimed at the surfaces
//! with deltas and follow these until they land. From the photons around a point follow the irradiance there that comes directly,
//! D, and by deltas, C (Jensen 1996, "Global illumination using photon maps": k nearest neighbours). A path tracer that finds the
//! latter with probability p per sample has the relative variance (C / (C + D))² / p from it; the mean of that over the picture is
//! [`LightFlow::chance_noise`].
//!
//! Straight passage through panes is no event: light sampling sees through them. Materials are judged by their factors, and surfaces
//! with alpha as if they were not there.

use std::f64::consts::{PI, TAU};

use glam::{DMat3, DVec3, Vec3};
use surelight_accel::{Accel, NO_INSTANCE, Ray};
use surelight_scene::{AlphaMode, Camera, Light, LightKind, Material, Projection, Scene};

use super::{
    casters::Ball,
    caustics::cone_height,
    clip::Planes,
    environment::EnvironmentTable,
    lobes::{has_facets, is_coated, is_pane},
    luminance,
    shared::AreaLight,
    shared::View,
    unreachable::direction_around,
};

/// Rays that go anywhere, and rays that are aimed at surfaces with deltas.
const DIRECT_RAYS: u32 = 4096;
const AIMED_RAYS: u32 = 8192;
/// Events that a ray may have before it is given up.
const MAX_EVENTS: u32 = 32;
/// Surfaces without cover, and panes, that a ray may pass.
const MAX_PASSED: u32 = 64;
/// After so many surfaces half of the rays end at each further one (Russian roulette).
const SURE_SURFACES: u32 = 4;
/// Photons at whose places irradiance is estimated.
const MAX_PLACES: usize = 512;
/// Photons that an estimate of irradiance is made from.
const NEIGHBOURS: usize = 12;
/// Roughness below which lobes are deltas: α < 1e-4.
const SMOOTH: f32 = 0.01;
/// Relative variances per sample are capped here; lights without extent reach it.
const MAX_NOISE: f64 = 1e6;
/// Of the light that a typical pixel sends on, the share that came from other surfaces.
const INDIRECT_SHARE: f64 = 0.3;

/// How light reaches the surfaces of a scene.
#[derive(Clone, Debug, Default, PartialEq)]
pub(crate) struct LightFlow {
    /// Of the light that surfaces scatter, the share that comes by mirrors and smooth glass first: 0 to 1.
    pub(crate) delta_share: f64,
    /// Of the same, the share that comes so from lights without extent, which no direction finds.
    pub(crate) missing_share: f64,
    /// Of what emitters send, the share that comes so; 0 without emitters.
    pub(crate) emitter_delta_share: f64,
    /// Scene lights without extent of which at least a hundredth comes so.
    pub(crate) missing_lights: Vec<usize>,
    /// Mean over the picture's pixels of the relative variance per sample that light has which is found by chance.
    pub(crate) chance_noise: f64,
}

/// What the analysis looks at.
pub(super) struct FlowInput<'a> {
    pub(super) scene: &'a Scene,
    pub(super) accel: &'a Accel,
    pub(super) camera: &'a Camera,
    pub(super) view: &'a View,
    pub(super) planes: &'a Planes,
    /// Emissive triangles and parallelograms, camera space.
    pub(super) area: &'a [AreaLight],
    /// The environment map and the factor on it.
    pub(super) sky: Option<(&'a EnvironmentTable, f64)>,
    /// Radiance of a uniform environment, luminance.
    pub(super) uniform_sky: f64,
    /// Balls around every surface that may have a delta lobe, camera space.
    pub(super) balls: &'a [Ball],
}

/// A photon where it lands.
#[derive(Clone, Copy)]
struct Photon {
    position: DVec3,
    /// Unit, on the side of arrival.
    normal: DVec3,
    /// Luminous flux that is scattered here.
    flux: f64,
    /// Probability that a direction sampled here, by the cosine, finds the light along the photon's way.
    chance: f64,
}

/// A kind of light that sends photons.
#[derive(Clone, Copy)]
enum Source<'a> {
    Area(&'a AreaLight),
    Light(usize, &'a Light),
    Sky,
    UniformSky,
}

/// A ray that leaves a light.
struct Emission {
    origin: DVec3,
    direction: DVec3,
    /// Flux over the pdf of the direction, and of the place.
    flux: f64,
    /// Area of an emitter across the direction, m²; of light from infinity its solid angle; 0 for lights without extent.
    extent: f64,
    distant: bool,
}

/// Numbers in [0, 1) that fill the cube evenly: a Kronecker sequence by powers of the root of x⁷ = x + 1 (Roberts 2018).
fn point(i: u32) -> [f64; 6] {
    const STEPS: [f64; 6] = [
        0.889_733_744_947_8,
        0.791_626_136_877_0,
        0.704_336_487_395_9,
        0.626_671_938_640_6,
        0.557_571_179_849_4,
        0.496_089_894_085_9,
    ];
    STEPS.map(|step| (0.5 + f64::from(i + 1) * step).fract())
}

impl LightFlow {
    /// Sends the photons. Without balls there are no deltas, and nothing is sent.
    pub(super) fn new(input: &FlowInput) -> Self {
        if input.balls.is_empty() || !input.accel.bounds.lo.is_finite() || !input.accel.bounds.hi.is_finite() {
            return Self::default();
        }
        Flow::new(input).measure()
    }
}

/// A photon's fate.
enum Fate {
    Lost,
    Landed(Photon),
}

/// Chooses an event by its share: its index, and the probability. Events of weak shares have a fifth at least, so that they are met.
/// `u` is uniform in [0, 1), and is again afterwards.
fn choose_event<const N: usize>(shares: [f64; N], u: &mut f64) -> Option<(usize, f64)> {
    let total: f64 = shares.iter().sum();
    let chances = shares.map(|share| if share > 0.0 { (share / total).max(0.2) } else { 0.0 });
    let sum: f64 = chances.iter().sum();
    let mut below = 0.0;
    for (event, chance) in chances.into_iter().enumerate() {
        let p = chance / sum;
        if p > 0.0 && *u < below + p {
            *u = ((*u - below) / p).clamp(0.0, 1.0 - 1e-12);
            return Some((event, p));
        }
        below += p;
    }
    None
}

struct Flow<'a> {
    input: &'a FlowInput<'a>,
    sources: Vec<Source<'a>>,
    middle: DVec3,
    radius: f64,
    /// Cumulative power of the map's texels that count as sources, and all their solid angle.
    sky_sources: Vec<(f64, usize)>,
    sky_solid_angle: f64,
}

impl<'a> Flow<'a> {
    fn new(input: &'a FlowInput<'a>) -> Self {
        let (low, high) = (input.accel.bounds.lo.as_dvec3(), input.accel.bounds.hi.as_dvec3());
        let mut sources: Vec<_> = input.area.iter().filter(|l| l.weight > 0.0).map(Source::Area).collect();
        let shines = |light: &&(usize, &Light)| luminance(light.1.intensity) > 0.0;
        sources.extend(input.scene.lights.iter().enumerate().filter(|l| shines(&l)).map(|(i, l)| Source::Light(i, l)));
        let mut flow = Self {
            input,
            sources,
            middle: (low + high) * 0.5,
            radius: 0.5 * (high - low).length(),
            sky_sources: Vec::new(),
            sky_solid_angle: 0.0,
        };
        if let Some((table, _)) = input.sky {
            flow.sources.push(Source::Sky);
            let mut sum = 0.0;
            for (i, texel) in table.texels.iter().enumerate().filter(|(_, t)| t[3] >= table.source_pdf) {
                let solid_angle = flow.texel_solid_angle(i);
                sum += luminance([texel[0], texel[1], texel[2]]) * solid_angle;
                flow.sky_solid_angle += solid_angle;
                flow.sky_sources.push((sum, i));
            }
        }
        if input.uniform_sky > 0.0 {
            flow.sources.push(Source::UniformSky);
        }
        flow
    }

    fn texel_solid_angle(&self, i: usize) -> f64 {
        let [width, height] = self.input.view.environment_size.map(f64::from);
        let row = (i / self.input.view.environment_size[0] as usize) as f64;
        let edge = |r: f64| (PI * r / height).cos();
        TAU / width * (edge(row) - edge(row + 1.0))
    }

    /// Direction towards the middle of a texel.
    fn texel_direction(&self, i: usize) -> DVec3 {
        let [width, height] = self.input.view.environment_size;
        let (column, row) = (i as u32 % width, i as u32 / width);
        let turn = (f64::from(column) + 0.5) / f64::from(width) - 0.5;
        let turn = TAU * (turn - f64::from(self.input.view.environment_rotation));
        let polar = PI * (f64::from(row) + 0.5) / f64::from(height);
        DVec3::new(polar.sin() * turn.cos(), polar.cos(), polar.sin() * turn.sin())
    }

    fn disc(&self) -> f64 {
        PI * self.radius * self.radius
    }

    /// Flux of a source in all directions.
    fn power(&self, source: &Source) -> f64 {
        match source {
            Source::Area(light) => PI * f64::from(self.emission_of(light)) * light.area() * self.sides(light),
            Source::Light(_, light) => {
                let intensity = luminance(light.intensity);
                match light.kind {
                    LightKind::Point { .. } => 4.0 * PI * intensity,
                    LightKind::Spot { outer, .. } => TAU * (1.0 - f64::from(outer).cos()) * intensity,
                    LightKind::Directional { .. } => intensity * self.disc(),
                }
            }
            Source::Sky => self.input.sky.map_or(0.0, |(table, factor)| table.total * factor * self.disc()),
            Source::UniformSky => 4.0 * PI * self.input.uniform_sky * self.disc(),
        }
    }

    /// Luminance of an emitter's factor, per side; textures and coverage are not looked up.
    fn emission_of(&self, light: &AreaLight) -> f32 {
        luminance(self.input.scene.materials[light.material()].emissive) as f32
    }

    fn sides(&self, light: &AreaLight) -> f64 {
        if self.input.scene.materials[light.material()].double_sided { 2.0 } else { 1.0 }
    }

    /// A source by its share of some powers: its place, and the probability.
    fn choose(powers: &[f64], u: f64) -> Option<(usize, f64)> {
        let total = powers.last().copied().filter(|t| *t > 0.0 && t.is_finite())?;
        let i = powers.partition_point(|&sum| sum <= u * total).min(powers.len() - 1);
        let own = powers[i] - if i > 0 { powers[i - 1] } else { 0.0 };
        (own > 0.0).then_some((i, own / total))
    }

    fn cumulative(powers: impl Iterator<Item = f64>) -> Vec<f64> {
        powers
            .scan(0.0, |sum, power| {
                *sum += if power.is_finite() { power } else { 0.0 };
                Some(*sum)
            })
            .collect()
    }

    /// A point on an area light and the normal of the side that shines.
    fn point_on(&self, light: &AreaLight, u: [f64; 3]) -> Option<(DVec3, DVec3)> {
        let [v0, e1, e2] = [light.v0, light.e1, light.e2].map(|v| Vec3::from(v).as_dvec3());
        let (mut a, mut b) = (u[0], u[1]);
        if !light.is_parallelogram() && a + b > 1.0 {
            (a, b) = (1.0 - a, 1.0 - b);
        }
        let normal = e1.cross(e2).try_normalize()?;
        let back = self.sides(light) == 2.0 && u[2] < 0.5;
        Some((v0 + e1 * a + e2 * b, if back { -normal } else { normal }))
    }

    /// A ray from a source into any direction.
    fn emit(&self, source: &Source, u: [f64; 6]) -> Option<Emission> {
        let power = self.power(source);
        let from_disc = |direction: DVec3| {
            let (x, y) = direction.any_orthonormal_pair();
            let (r, (sin, cos)) = (self.radius * u[2].sqrt(), (TAU * u[3]).sin_cos());
            self.middle + (x * cos + y * sin) * r - direction * (2.0 * self.radius)
        };
        let emission = |origin, direction, flux| Emission { origin, direction, flux, extent: 0.0, distant: false };
        Some(match source {
            Source::Area(light) => {
                let (at, normal) = self.point_on(light, [u[0], u[1], u[4]])?;
                let direction = direction_around(normal, u[2].sqrt(), u[3]);
                emission(at + normal * self.step(at), direction, power)
            }
            Source::Light(_, light) => match light.kind {
                LightKind::Point { position } => emission(
                    position - self.input.accel.origin,
                    direction_around(DVec3::Y, 1.0 - 2.0 * u[0], u[1]),
                    power,
                ),
                LightKind::Spot { position, direction, inner, outer } => {
                    let cosine = 1.0 - u[0] * (1.0 - f64::from(outer).cos());
                    let fade = spot_falloff(inner, outer, cosine);
                    emission(
                        position - self.input.accel.origin,
                        direction_around(direction, cosine, u[1]),
                        power * fade,
                    )
                }
                LightKind::Directional { direction } => emission(from_disc(direction), direction, power),
            },
            Source::Sky => {
                let (table, _) = self.input.sky?;
                // Texels by the sampling density, which covers nearly all of the light; the rest is dim.
                let slot = ((u[0] * table.alias.len() as f64) as usize).min(table.alias.len() - 1);
                let own = u[1] < f64::from(table.alias[slot].threshold);
                let texel = if own { slot } else { table.alias[slot].alias as usize };
                let direction = -self.texel_direction(texel);
                emission(from_disc(direction), direction, power)
            }
            Source::UniformSky => {
                let direction = direction_around(DVec3::Y, 1.0 - 2.0 * u[0], u[1]);
                emission(from_disc(direction), direction, power)
            }
        })
    }

    /// A ray from a source towards the balls.
    fn aim(&self, source: &Source, u: [f64; 6]) -> Option<Emission> {
        let balls = self.input.balls;
        let distant = |direction: DVec3, radiance: f64, extent: f64| {
            let areas = Self::cumulative(balls.iter().map(|b| PI * b.radius * b.radius));
            let (k, _) = Self::choose(&areas, u[4])?;
            let (x, y) = direction.any_orthonormal_pair();
            let (r, (sin, cos)) = (balls[k].radius * u[2].sqrt(), (TAU * u[3]).sin_cos());
            let at = balls[k].center + (x * cos + y * sin) * r;
            let seen = balls.iter().filter(|b| {
                let to_center = b.center - at;
                (to_center - direction * to_center.dot(direction)).length_squared() <= b.radius * b.radius
            });
            let flux = radiance * areas.last()? / seen.count().max(1) as f64;
            let back = (at - self.middle).dot(direction) + 2.0 * self.radius;
            Some(Emission { origin: at - direction * back, direction, flux, extent, distant: true })
        };
        let from_point = |at: DVec3, value: &dyn Fn(DVec3) -> f64, extent: &dyn Fn(DVec3) -> f64| {
            let heights = Self::cumulative(balls.iter().map(|b| cone_height(b, at)));
            let (k, _) = Self::choose(&heights, u[4])?;
            let height = cone_height(&balls[k], at);
            let axis = (balls[k].center - at).try_normalize().filter(|_| height < 2.0).unwrap_or(DVec3::Y);
            let direction = direction_around(axis, 1.0 - height * u[2], u[3]);
            let seen = balls.iter().filter(|b| {
                let (height, to_center) = (cone_height(b, at), b.center - at);
                height >= 2.0 || direction.dot(to_center) >= to_center.length() * (1.0 - height) * (1.0 - 1e-12)
            });
            let flux = value(direction) * TAU * heights.last()? / seen.count().max(1) as f64;
            (flux > 0.0).then_some(Emission { origin: at, direction, flux, extent: extent(direction), distant: false })
        };
        match source {
            Source::Area(light) => {
                let (at, normal) = self.point_on(light, [u[0], u[1], u[5]])?;
                let area = light.area();
                let radiance = f64::from(self.emission_of(light)) * self.sides(light);
                let value = |direction: DVec3| radiance * direction.dot(normal).max(0.0) * area;
                from_point(at + normal * self.step(at), &value, &|direction| direction.dot(normal).max(0.0) * area)
            }
            Source::Light(_, light) => {
                let intensity = luminance(light.intensity);
                match light.kind {
                    LightKind::Point { position } => {
                        from_point(position - self.input.accel.origin, &|_| intensity, &|_| 0.0)
                    }
                    LightKind::Spot { position, direction: axis, inner, outer } => {
                        let value = |direction: DVec3| intensity * spot_falloff(inner, outer, direction.dot(axis));
                        from_point(position - self.input.accel.origin, &value, &|_| 0.0)
                    }
                    LightKind::Directional { direction } => distant(direction, intensity, 0.0),
                }
            }
            Source::Sky => {
                let (_, factor) = self.input.sky?;
                let total = self.sky_sources.last()?.0;
                let i = self.sky_sources.partition_point(|(sum, _)| *sum <= u[0] * total);
                let texel = self.sky_sources[i.min(self.sky_sources.len() - 1)].1;
                distant(-self.texel_direction(texel), total * factor, self.sky_solid_angle)
            }
            // Directions find a uniform sky easily.
            Source::UniformSky => None,
        }
    }

    /// Flux from a source to the balls, about.
    fn aimed_power(&self, source: &Source) -> f64 {
        let balls = self.input.balls;
        let heights = |at: DVec3| TAU * balls.iter().map(|b| cone_height(b, at)).sum::<f64>().min(2.0);
        let discs = || balls.iter().map(|b| PI * b.radius * b.radius).sum::<f64>();
        match source {
            Source::Area(light) => {
                let [v0, e1, e2] = [light.v0, light.e1, light.e2].map(|v| Vec3::from(v).as_dvec3());
                let middle = v0 + (e1 + e2) * if light.is_parallelogram() { 0.5 } else { 1.0 / 3.0 };
                f64::from(self.emission_of(light)) * self.sides(light) * light.area() * heights(middle).min(PI)
            }
            Source::Light(_, light) => {
                let intensity = luminance(light.intensity);
                match light.kind {
                    LightKind::Point { position } | LightKind::Spot { position, .. } => {
                        intensity * heights(position - self.input.accel.origin)
                    }
                    LightKind::Directional { .. } => intensity * discs(),
                }
            }
            Source::Sky => {
                let factor = self.input.sky.map_or(0.0, |(_, factor)| factor);
                self.sky_sources.last().map_or(0.0, |(total, _)| total * factor * discs())
            }
            Source::UniformSky => 0.0,
        }
    }

    /// How far a ray's origin is moved off a surface.
    fn step(&self, at: DVec3) -> f64 {
        1e-5 * (at.abs().max_element() + 1e-3 * self.radius)
    }

    /// Follows a ray until it lands on a surface that scatters. `aimed`: it counts if a delta is its first event; otherwise if it has
    /// no event at all.
    fn follow(&self, emission: &Emission, aimed: bool, u: f64) -> Fate {
        let Emission { mut origin, mut direction, mut flux, extent, distant } = *emission;
        let (mut u, mut length, mut lobes) = (u, 0.0, 1.0);
        let (mut events, mut passed) = (0, 0);
        while events <= MAX_EVENTS && passed <= MAX_PASSED {
            if events + passed >= SURE_SURFACES {
                if u < 0.5 {
                    return Fate::Lost;
                }
                u = 2.0 * u - 1.0;
                flux *= 2.0;
            }
            let Some(hit) = self.input.accel.intersect(&Ray::new(origin.as_vec3(), direction.as_vec3())) else {
                return Fate::Lost;
            };
            let t = f64::from(hit.t);
            length += t;
            let at = origin + direction * t;
            let surface = self.surface(&hit, direction);
            let material = surface.material;
            if material.alpha_mode != AlphaMode::Opaque {
                passed += 1;
                origin = at + direction * self.step(at);
                continue;
            }
            let cosine = surface.normal.dot(-direction).clamp(0.0, 1.0);
            let delta = Delta::of(material, cosine, surface.front);
            let is_pane = is_pane(material, material.roughness < SMOOTH);
            let scattered = (1.0 - delta.total()).max(0.0) * delta.rest * albedo(material);
            let through = if is_pane { delta.transmitted } else { 0.0 };
            // What ends here, what passes straight through, and what a delta sends on; aimed rays land after a delta alone, and others
            // have none.
            let land = if aimed == (events > 0) { scattered } else { 0.0 };
            let bounce = if aimed && events < MAX_EVENTS { delta.reflected + delta.transmitted - through } else { 0.0 };
            let Some((event, probability)) = choose_event([land, through, bounce], &mut u) else { return Fate::Lost };
            flux /= probability;
            if event == 0 {
                let solid_angle = if distant { extent } else { extent / (length * length) };
                let chance = (surface.geometric.dot(-direction).abs() / PI * solid_angle * lobes).min(1.0);
                let flux = flux * scattered;
                return Fate::Landed(Photon { position: at, normal: surface.geometric, flux, chance });
            }
            if event == 1 {
                flux *= through;
                passed += 1;
            } else {
                let shares = [delta.reflected, delta.transmitted - through];
                let Some((lobe, probability)) = choose_event(shares, &mut u) else { return Fate::Lost };
                flux *= shares[lobe] / probability;
                lobes *= shares[lobe] / delta.total();
                events += 1;
                direction = if lobe == 0 {
                    direction - surface.normal * (2.0 * direction.dot(surface.normal))
                } else {
                    match refract(direction, surface.normal, delta.eta) {
                        Some(bent) => bent,
                        None => return Fate::Lost,
                    }
                };
            }
            // To the side that it leaves for.
            let side = if direction.dot(surface.geometric) > 0.0 { 1.0 } else { -1.0 };
            origin = at + surface.geometric * (side * self.step(at));
        }
        Fate::Lost
    }

    fn surface(&self, hit: &surelight_accel::Hit, direction: DVec3) -> Surface<'a> {
        let (scene, accel) = (self.input.scene, self.input.accel);
        let source = &accel.triangles[hit.prim as usize];
        let placed = if hit.instance == NO_INSTANCE {
            source.instance
        } else {
            accel.instances[hit.instance as usize].scene_instance
        };
        let to_world = scene.instances[placed as usize].to_world;
        let mesh = &scene.meshes[source.mesh as usize];
        let [a, b, c] = source.corners.map(|i| to_world.transform_point3(mesh.positions[i as usize].as_dvec3()));
        // Corners of copies are in the order of the world already.
        let mirrored = source.instance == NO_INSTANCE && to_world.matrix3.determinant() < 0.0;
        let front = (b - a).cross(c - a).normalize_or_zero() * if mirrored { -1.0 } else { 1.0 };
        let is_front = front.dot(direction) < 0.0;
        let side = if is_front { 1.0 } else { -1.0 };
        let geometric = front * side;
        let shading = mesh.normals.as_ref().and_then(|normals| {
            let normal_matrix: DMat3 = to_world.matrix3.inverse().transpose();
            let [b1, b2] = [f64::from(hit.b1), f64::from(hit.b2)];
            let [na, nb, nc] = source.corners.map(|i| normals[i as usize].as_dvec3());
            let normal = (normal_matrix * (na * (1.0 - b1 - b2) + nb * b1 + nc * b2)).try_normalize()? * side;
            // Facing away from the viewer or from its surface, it is of no use.
            (normal.dot(geometric) > 0.0 && normal.dot(direction) < 0.0).then_some(normal)
        });
        Surface {
            material: &scene.materials[mesh.material],
            normal: shading.unwrap_or(geometric),
            geometric,
            front: is_front,
        }
    }

    /// Sends everything and adds it up.
    fn measure(&self) -> LightFlow {
        let direct_powers = Self::cumulative(self.sources.iter().map(|s| self.power(s)));
        let aimed_powers = Self::cumulative(self.sources.iter().map(|s| self.aimed_power(s)));
        let is_emitter = |i: usize| matches!(self.sources[i], Source::Area(_));
        let scattered = |photon: &Photon| photon.flux;
        let lights = self.input.scene.lights.len();
        let (mut by_light, mut of_light) = (vec![0.0; lights], vec![0.0; lights]);
        let (mut direct, mut emitters) = (Vec::new(), [0.0; 2]);
        for i in 0..DIRECT_RAYS {
            let mut u = point(i);
            let Some((k, p)) = Self::choose(&direct_powers, f64::from(i) / f64::from(DIRECT_RAYS)) else { break };
            let Some(mut emission) = self.emit(&self.sources[k], u) else { continue };
            emission.flux /= p * f64::from(DIRECT_RAYS);
            u[5] = (u[5] + u[0]).fract();
            if let Fate::Landed(photon) = self.follow(&emission, false, u[5]) {
                if is_emitter(k) {
                    emitters[0] += scattered(&photon);
                }
                if let Source::Light(light, _) = self.sources[k] {
                    of_light[light] += scattered(&photon);
                }
                direct.push(photon);
            }
        }
        let (mut by_deltas, mut missing) = (Vec::new(), 0.0);
        for i in 0..AIMED_RAYS {
            let u = point(i);
            let Some((k, p)) = Self::choose(&aimed_powers, f64::from(i) / f64::from(AIMED_RAYS)) else { break };
            let Some(mut emission) = self.aim(&self.sources[k], u) else { continue };
            emission.flux /= p * f64::from(AIMED_RAYS);
            if let Fate::Landed(photon) = self.follow(&emission, true, (u[5] + u[0]).fract()) {
                match self.sources[k] {
                    Source::Area(_) => emitters[1] += scattered(&photon),
                    Source::Light(light, _) => {
                        missing += scattered(&photon);
                        by_light[light] += scattered(&photon);
                    }
                    Source::Sky | Source::UniformSky => {}
                }
                by_deltas.push(photon);
            }
        }
        let total = |photons: &[Photon]| photons.iter().map(scattered).sum::<f64>();
        let (direct_total, delta_total) = (total(&direct), total(&by_deltas));
        let share = |part: f64, all: f64| if part > 0.0 { part / all } else { 0.0 };
        let delta_share = share(delta_total, direct_total + delta_total);
        LightFlow {
            delta_share,
            missing_share: share(missing, direct_total + delta_total),
            emitter_delta_share: share(emitters[1], emitters[0] + emitters[1]),
            missing_lights: (0..lights).filter(|&i| share(by_light[i], by_light[i] + of_light[i]) >= 0.01).collect(),
            chance_noise: self.chance_noise(&direct, &by_deltas, delta_share),
        }
    }

    /// Mean over the picture of the relative variance that light by deltas has when it is found by chance.
    fn chance_noise(&self, direct: &[Photon], by_deltas: &[Photon], delta_share: f64) -> f64 {
        if by_deltas.is_empty() {
            return 0.0;
        }
        let stride = by_deltas.len().div_ceil(MAX_PLACES);
        let mut noise = 0.0;
        let (mut inverse_chance, mut flux) = (0.0, 0.0);
        for photon in by_deltas.iter().step_by(stride) {
            flux += photon.flux;
            inverse_chance += photon.flux * (1.0 / photon.chance.max(1.0 / MAX_NOISE));
            let importance = self.importance(photon);
            if importance <= 0.0 {
                continue;
            }
            let [c, d] = [by_deltas, direct].map(|photons| irradiance(photons, photon));
            if c > 0.0 {
                let share = c / (c + d);
                let variance = (share * share / photon.chance.max(1e-12)).min(MAX_NOISE);
                noise += stride as f64 * photon.flux / c * importance * variance;
            }
        }
        // Light that surfaces send on to all others carries the noise with it.
        let mean_inverse = if flux > 0.0 { inverse_chance / flux } else { 0.0 };
        noise + (INDIRECT_SHARE * delta_share).powi(2) * mean_inverse
    }

    /// Share of the picture per area of the surface where a photon landed, 1/m²; 0 where the camera does not see it.
    fn importance(&self, photon: &Photon) -> f64 {
        let view = self.input.view;
        let [origin, forward, right, up] =
            [view.origin, view.forward, view.right, view.up].map(|v| Vec3::from(v).as_dvec3());
        let to_point = photon.position - origin;
        let depth = to_point.dot(forward);
        let orthographic = matches!(self.input.camera.projection, Projection::Orthographic { .. });
        let across = if orthographic { to_point } else { to_point / depth.max(1e-30) };
        let ndc = [across.dot(right) / right.length_squared(), across.dot(up) / up.length_squared()];
        if depth <= 0.0 || ndc.iter().any(|c| c.abs() > 1.0) {
            return 0.0;
        }
        let picture = 4.0 * right.length() * up.length();
        let distance = if orthographic { depth } else { to_point.length() };
        let direction = if orthographic { forward } else { to_point / distance };
        // What the near plane cuts hides nothing.
        let start = self.input.planes.start(photon.position - direction * distance, direction);
        let left = (photon.position - start).dot(direction);
        let seen = self.input.accel.intersect(&Ray::new(start.as_vec3(), direction.as_vec3()));
        if left <= 0.0 || seen.is_some_and(|hit| f64::from(hit.t) < left * (1.0 - 1e-4)) {
            return 0.0;
        }
        let cosine = photon.normal.dot(direction).abs();
        if orthographic {
            cosine / picture
        } else {
            let forward_cosine = depth / distance;
            cosine / (picture * forward_cosine.powi(3) * distance * distance)
        }
    }
}

/// Irradiance by the photons around one of them that landed on the same side.
fn irradiance(photons: &[Photon], at: &Photon) -> f64 {
    let mut nearest: Vec<(f64, f64)> = photons
        .iter()
        .filter(|p| p.normal.dot(at.normal) > 0.7)
        .map(|p| (p.position.distance_squared(at.position), p.flux))
        .collect();
    let k = NEIGHBOURS.min(nearest.len());
    if k == 0 {
        return 0.0;
    }
    nearest.select_nth_unstable_by(k - 1, |a, b| a.0.total_cmp(&b.0));
    let squared = nearest[k - 1].0;
    let flux: f64 = nearest[..k].iter().map(|(_, flux)| flux).sum();
    if squared > 0.0 { flux / (PI * squared) } else { 0.0 }
}

fn spot_falloff(inner: f32, outer: f32, cosine: f64) -> f64 {
    let (inner, outer) = (f64::from(inner).cos(), f64::from(outer).cos());
    ((cosine - outer) / (inner - outer).max(1e-3)).clamp(0.0, 1.0).powi(2)
}

/// Where a ray lands.
struct Surface<'a> {
    material: &'a Material,
    /// For shading, on the ray's side.
    normal: DVec3,
    geometric: DVec3,
    front: bool,
}

/// Shares of a surface's delta lobes, by its factors.
struct Delta {
    reflected: f64,
    transmitted: f64,
    /// Index beyond over that on the ray's side; 1 for thin walls.
    eta: f64,
    /// Of what no delta takes, the share that is scattered: smooth metal and glass absorb it.
    rest: f64,
}

impl Delta {
    fn of(m: &Material, cosine: f64, front: bool) -> Self {
        let brightest = |c: &[f32]| f64::from(c.iter().copied().fold(0.0, f32::max));
        let mut delta = Self { reflected: 0.0, transmitted: 0.0, eta: 1.0, rest: 1.0 };
        if has_facets(m) && m.roughness < SMOOTH {
            let ior = if m.ior == 0.0 { 1e6 } else { f64::from(m.ior) };
            let (metallic, transmission) = (f64::from(m.metallic), f64::from(m.transmission));
            // What transmits has the exact reflectance, everything else Schlick's.
            let bends = m.volume.is_some() && transmission > 0.0;
            if bends {
                delta.eta = if front { ior } else { 1.0 / ior };
            }
            let fresnel = if transmission > 0.0 {
                fresnel(cosine, if bends { delta.eta } else { ior })
            } else {
                let f0 = ((ior - 1.0) / (ior + 1.0)).powi(2);
                f0 + (1.0 - f0) * (1.0 - cosine).powi(5)
            };
            let strength = if fresnel < 1.0 { f64::from(m.specular) } else { 1.0 };
            let dielectric = fresnel * strength;
            let colour = brightest(&m.base_color[..3]);
            delta.reflected = metallic * colour + (1.0 - metallic) * dielectric;
            delta.rest = (1.0 - metallic) * (1.0 - transmission);
            delta.transmitted = (1.0 - metallic) * (1.0 - dielectric) * transmission * colour;
        }
        if is_coated(m) && m.clearcoat.roughness < SMOOTH {
            let coat = f64::from(m.clearcoat.factor) * (0.04 + 0.96 * (1.0 - cosine).powi(5));
            delta.reflected = coat + (1.0 - coat) * delta.reflected;
            delta.transmitted *= 1.0 - coat;
        }
        delta
    }

    fn total(&self) -> f64 {
        self.reflected + self.transmitted
    }
}

/// Reflectance of a dielectric interface.
fn fresnel(cosine: f64, eta: f64) -> f64 {
    let g2 = eta * eta - 1.0 + cosine * cosine;
    if g2 <= 0.0 {
        return 1.0;
    }
    let g = g2.sqrt();
    let a = (g - cosine) / (g + cosine);
    let b = (cosine * (g + cosine) - 1.0) / (cosine * (g - cosine) + 1.0);
    0.5 * a * a * (1.0 + b * b)
}

/// A direction bent at an interface; `None` for total reflection.
fn refract(direction: DVec3, normal: DVec3, eta: f64) -> Option<DVec3> {
    let cosine = -direction.dot(normal);
    let g2 = eta * eta - 1.0 + cosine * cosine;
    (g2 > 0.0).then(|| ((direction + normal * (cosine - g2.sqrt())) / eta).normalize())
}

/// What a surface scatters, by its factors; a texture counts as a half of its factor.
fn albedo(m: &Material) -> f64 {
    if m.unlit {
        return 0.0;
    }
    let factor = m.base_color[..3].iter().map(|&c| f64::from(c)).sum::<f64>() / 3.0;
    if m.base_color_texture.is_some() { 0.5 * factor } else { factor }
}
