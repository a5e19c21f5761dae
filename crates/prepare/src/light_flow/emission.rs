//! Photons leave the lights: in all directions, or aimed at the balls around delta lobes.

use std::f64::consts::{PI, TAU};

use glam::{DVec3, Vec3};
use surelight_scene::{Light, LightKind};

use super::FlowInput;
use crate::{caustics::cone_height, luminance, shared::AreaLight, unreachable::direction_around};

/// A kind of light that sends photons.
#[derive(Clone, Copy)]
pub(super) enum Source<'a> {
    Area(&'a AreaLight),
    Light(usize, &'a Light),
    Sky,
    UniformSky,
}

/// A ray that leaves a light.
pub(super) struct Emission {
    pub(super) origin: DVec3,
    pub(super) direction: DVec3,
    /// Flux over the pdf of the direction, and of the place.
    pub(super) flux: f64,
    /// Area of an emitter across the direction, m²; of light from infinity its solid angle; 0 for
    /// lights without extent.
    pub(super) extent: f64,
    pub(super) distant: bool,
}

/// The lights of a scene, as sources of photons.
pub(super) struct Sources<'a> {
    input: &'a FlowInput<'a>,
    all: Vec<Source<'a>>,
    /// The ball around the scene.
    middle: DVec3,
    radius: f64,
    /// Cumulative power of the map's texels that count as sources, and all their solid angle.
    sky_sources: Vec<(f64, usize)>,
    sky_solid_angle: f64,
}

impl<'a> Sources<'a> {
    pub(super) fn new(input: &'a FlowInput<'a>) -> Self {
        let (middle, radius) = input.ball();
        let mut all: Vec<_> = input.area.iter().filter(|l| l.weight > 0.0).map(Source::Area).collect();
        let shines = |light: &&(usize, &Light)| luminance(light.1.intensity) > 0.0;
        all.extend(input.scene.lights.iter().enumerate().filter(|l| shines(&l)).map(|(i, l)| Source::Light(i, l)));
        let mut sources = Self { input, all, middle, radius, sky_sources: Vec::new(), sky_solid_angle: 0.0 };
        if let Some((table, _)) = input.sky {
            sources.all.push(Source::Sky);
            let mut sum = 0.0;
            for (i, texel) in table.texels.iter().enumerate().filter(|(_, t)| t[3] >= table.source_pdf) {
                let solid_angle = sources.texel_solid_angle(i);
                sum += luminance([texel[0], texel[1], texel[2]]) * solid_angle;
                sources.sky_solid_angle += solid_angle;
                sources.sky_sources.push((sum, i));
            }
        }
        if input.uniform_sky > 0.0 {
            sources.all.push(Source::UniformSky);
        }
        sources
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

    /// The kind of a source.
    pub(super) fn kind(&self, source: usize) -> Source<'a> {
        self.all[source]
    }

    /// The cumulative power of the sources.
    pub(super) fn powers(&self) -> Vec<f64> {
        cumulative(self.all.iter().map(|source| self.power(source)))
    }

    /// The cumulative flux, about, from the sources to the balls.
    pub(super) fn aimed_powers(&self) -> Vec<f64> {
        cumulative(self.all.iter().map(|source| self.aimed_power(source)))
    }

    /// A ray from a source into any direction.
    pub(super) fn emit(&self, source: usize, u: [f64; 6]) -> Option<Emission> {
        let source = &self.all[source];
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
                emission(at + normal * self.input.offset(at), direction, power)
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
                // Texels by the sampling density, which covers nearly all of the light; the rest is
                // dim.
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
    pub(super) fn aim(&self, source: usize, u: [f64; 6]) -> Option<Emission> {
        let source = &self.all[source];
        let balls = self.input.balls;
        let distant = |direction: DVec3, radiance: f64, extent: f64| {
            let areas = cumulative(balls.iter().map(|b| PI * b.radius * b.radius));
            let (k, _) = choose(&areas, u[4])?;
            let (x, y) = direction.any_orthonormal_pair();
            let (r, (sin, cos)) = (balls[k].radius * u[2].sqrt(), (TAU * u[3]).sin_cos());
            let at = balls[k].center + (x * cos + y * sin) * r;
            let hit = balls.iter().filter(|b| {
                let to_center = b.center - at;
                (to_center - direction * to_center.dot(direction)).length_squared() <= b.radius * b.radius
            });
            let flux = radiance * areas.last()? / hit.count().max(1) as f64;
            let back = (at - self.middle).dot(direction) + 2.0 * self.radius;
            Some(Emission { origin: at - direction * back, direction, flux, extent, distant: true })
        };
        let from_point = |at: DVec3, value: &dyn Fn(DVec3) -> f64, extent: &dyn Fn(DVec3) -> f64| {
            let heights = cumulative(balls.iter().map(|b| cone_height(b, at)));
            let (k, _) = choose(&heights, u[4])?;
            let height = cone_height(&balls[k], at);
            let axis = (balls[k].center - at).try_normalize().filter(|_| height < 2.0).unwrap_or(DVec3::Y);
            let direction = direction_around(axis, 1.0 - height * u[2], u[3]);
            let hit = balls.iter().filter(|b| {
                let (height, to_center) = (cone_height(b, at), b.center - at);
                height >= 2.0 || direction.dot(to_center) >= to_center.length() * (1.0 - height) * (1.0 - 1e-12)
            });
            let flux = value(direction) * TAU * heights.last()? / hit.count().max(1) as f64;
            (flux > 0.0).then_some(Emission { origin: at, direction, flux, extent: extent(direction), distant: false })
        };
        match source {
            Source::Area(light) => {
                let (at, normal) = self.point_on(light, [u[0], u[1], u[5]])?;
                let area = light.area();
                let radiance = f64::from(self.emission_of(light)) * self.sides(light);
                let value = |direction: DVec3| radiance * direction.dot(normal).max(0.0) * area;
                from_point(at + normal * self.input.offset(at), &value, &|direction| {
                    direction.dot(normal).max(0.0) * area
                })
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
}

fn spot_falloff(inner: f32, outer: f32, cosine: f64) -> f64 {
    let (inner, outer) = (f64::from(inner).cos(), f64::from(outer).cos());
    ((cosine - outer) / (inner - outer).max(1e-3)).clamp(0.0, 1.0).powi(2)
}

/// A source by its share of some powers: its place, and the probability.
pub(super) fn choose(powers: &[f64], u: f64) -> Option<(usize, f64)> {
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
