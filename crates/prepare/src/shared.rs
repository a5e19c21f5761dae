//! Numbers and records that host and shaders share, declared once: shaders import them from
//! `package::generated`.

use bytemuck::{Pod, Zeroable};
use surelight_accel::item;

use crate::reflect::RecordLayout;

/// Declares constants for Rust and WGSL.
macro_rules! shared_constants {
    ($($(#[doc = $doc:literal])* $name:ident: $ty:ident = $value:expr;)*) => {
        $($(#[doc = $doc])* pub const $name: $ty = $value;)*

        fn constants() -> String {
            [$(format!("const {}: {} = {:?};\n", stringify!($name), stringify!($ty), $name)),*].concat()
        }
    };
}

/// Declares `repr(C)` records for Rust and structs for WGSL. The text after `=` is a field's type
/// in WGSL; fields whose names begin with `pad` are those that WGSL inserts by itself.
macro_rules! shared_records {
    ($($(#[doc = $doc:literal])* $record:ident as $wgsl:literal {
        $($(#[doc = $field_doc:literal])* $field:ident: $ty:ty = $field_type:literal,)*
    })*) => {
        $(
            $(#[doc = $doc])*
            #[repr(C)]
            #[derive(Clone, Copy, Debug, Default, PartialEq, Pod, Zeroable)]
            pub struct $record { $($(#[doc = $field_doc])* pub $field: $ty,)* }
        )*

        /// Each record, by its name in WGSL, laid out as Rust lays it out.
        pub fn host_layouts() -> Vec<(&'static str, RecordLayout)> {
            vec![$(($wgsl, {
                let fields = [$((stringify!($field), std::mem::offset_of!($record, $field), size_of::<$ty>())),*];
                RecordLayout {
                    offsets: fields.iter().map(|&(name, offset, _)| (name.to_owned(), offset as u32)).collect(),
                    sizes: fields.iter().map(|&(name, _, size)| (name.to_owned(), size as u32)).collect(),
                    span: size_of::<$record>() as u32,
                }
            })),*]
        }

        fn records() -> String {
            let declaration = |name: &str, fields: &[(&str, &str)]| {
                let fields = fields.iter().filter(|(field, _)| !field.starts_with("pad"));
                let fields: String = fields.map(|(field, ty)| format!("    {field}: {ty},\n")).collect();
                format!("struct {name} {{\n{fields}}}\n")
            };
            [$(declaration($wgsl, &[$((stringify!($field), $field_type)),*])),*].concat()
        }
    };
}

/// The declarations of `package::generated` that do not depend on the scene.
pub(crate) fn declarations() -> String {
    constants() + &records()
}

shared_constants! {
    /// Factor on the far distance of a slab: covers its rounding.
    SLAB_PADDING: f32 = item::SLAB_PADDING;

    /// Lanes of a workgroup: 8 × 8.
    WORKGROUP_LANES: u32 = 64;
    /// Samples of a lane of the integration kernel: few, so that rounding of its f32 sum stays
    /// small.
    INTEGRATION_CHUNK: u32 = 64;
    /// Most dimensions of a formula that is integrated.
    MAX_DIMENSIONS: u32 = 10;
    /// Words of a pixel's sums of particles.
    SPLAT_WORDS: u32 = 9;
    /// Pixels along a side of a block of adaptive sampling.
    ADAPTIVE_BLOCK: u32 = 8;
    /// Samples of the shortest batch in which some pixels have fewer than others.
    MIN_ADAPTIVE_BATCH: u32 = 4;

    /// Of an entry of the light table: the kind is above this bit, the index below.
    LIGHT_KIND_SHIFT: u32 = 30;
    /// Bits of the index.
    LIGHT_INDEX_MASK: u32 = (1 << LIGHT_KIND_SHIFT) - 1;
    /// An emissive triangle or parallelogram.
    LIGHT_KIND_AREA: u32 = 0;
    /// A light of KHR_lights_punctual.
    LIGHT_KIND_PUNCTUAL: u32 = 1;
    /// The environment map.
    LIGHT_KIND_ENVIRONMENT: u32 = 2;

    /// Kinds of punctual lights: a point, …
    PUNCTUAL_POINT: u32 = 0;
    /// … a spot, …
    PUNCTUAL_SPOT: u32 = 1;
    /// … or directional.
    PUNCTUAL_DIRECTIONAL: u32 = 2;

    /// In the shape of an area light, beside its material: it is a parallelogram, else a triangle.
    PARALLELOGRAM: u32 = 1 << 31;
    /// In the shape of an area light: a mirroring instance turned the triangle over, so that `e1`
    /// and `e2` are the edges to its third and second corner.
    MIRRORED: u32 = 1 << 30;
    /// Marks a link of the light tree: it leads to a light.
    LIGHT_LEAF: u32 = 1 << 31;

    /// Material flags: both sides scatter and emit.
    FLAG_DOUBLE_SIDED: u32 = 1;
    /// The base colour is the radiance.
    FLAG_UNLIT: u32 = 2;
    /// It transmits without an inside.
    FLAG_THIN: u32 = 4;
    /// Alpha applies.
    FLAG_NOT_OPAQUE: u32 = 8;
    /// Alpha applies, and there is a medium inside.
    FLAG_BOUNDARY: u32 = 16;

    /// Rows of the table of sheen albedos, by equal sqrt(α) from 0.1 to 1.
    SHEEN_ROWS: u32 = 64;
    /// Columns, by equal sqrt(cosθ) from 0 to 1.
    SHEEN_COLUMNS: u32 = 64;
    /// Smaller cosines are clamped: the fit of the masking is not defined there.
    MIN_SHEEN_COSINE: f32 = 1e-3;
    /// Rows and columns of the table of facet albedos, by equal sqrt(α) and sqrt(cosθ) from 0 to 1.
    FACET_STEPS: u32 = 32;
}

shared_records! {
    /// Constants of a render: camera, environment, limits.
    View as "View" {
        /// Of rays; the world's origin is moved to the camera, so this is near 0.
        origin: [f32; 3] = "vec3f",
        /// Metres.
        lens_radius: f32 = "f32",
        /// From the middle of the image to its right edge, at unit distance (metres when
        /// orthographic).
        right: [f32; 3] = "vec3f",
        /// Distance of the plane in focus, metres.
        focus: f32 = "f32",
        /// From the middle of the image to its upper edge, as `right`.
        up: [f32; 3] = "vec3f",
        /// Of all samples.
        seed: u32 = "u32",
        /// Unit.
        forward: [f32; 3] = "vec3f",
        /// Scattering events of a path.
        max_bounces: u32 = "u32",
        /// Uniform radiance, or the factor on the map.
        environment: [f32; 3] = "vec3f",
        /// About +Y, as a fraction of a turn.
        environment_rotation: f32 = "f32",
        /// Pixels per row, and rows, of the whole image.
        size: [u32; 2] = "vec2u",
        /// Texels per row, and rows, of the environment map.
        environment_size: [u32; 2] = "vec2u",
        /// That light sampling chooses the environment.
        environment_probability: f32 = "f32",
        /// An emissive triangle's weight times this is the pdf of its points by light sampling,
        /// 1/m².
        light_density: f32 = "f32",
        /// Entries of the light table.
        light_count: u32 = "u32",
        /// Clamp of one sample (biased), where the kernel has it.
        max_radiance: f32 = "f32",
    }

    /// An entry of the alias table over all lights (Vose 1991): half by power, half to each emitter
    /// alike.
    LightEntry as "LightEntry" {
        /// Up to here its part of the slot, beyond it the alias's.
        threshold: f32 = "f32",
        /// The other entry of its slot.
        alias_entry: u32 = "u32",
        /// That this light is chosen.
        probability: f32 = "f32",
        /// Kind and index; with a light tree, one entry represents all area lights.
        light: u32 = "u32",
    }

    /// An emissive triangle or parallelogram.
    AreaLight as "AreaLight" {
        /// World, relative to the scene's origin.
        v0: [f32; 3] = "vec3f",
        /// Its triangle; of a parallelogram, whose emission is uniform, one of its two.
        prim: u32 = "u32",
        /// To the second corner.
        e1: [f32; 3] = "vec3f",
        /// Its material, with `PARALLELOGRAM` and `MIRRORED`.
        shape: u32 = "u32",
        /// To the third corner.
        e2: [f32; 3] = "vec3f",
        /// Luminance of the mean emission times its emitter's share: times `View::light_density`,
        /// the mean pdf per area. With a tree, one over its area.
        weight: f32 = "f32",
    }

    /// A light of KHR_lights_punctual.
    PunctualLight as "PunctualLight" {
        /// Of directional lights: unit direction towards the light.
        position: [f32; 3] = "vec3f",
        /// `PUNCTUAL_…`.
        kind: u32 = "u32",
        /// Candela; lux for directional lights.
        intensity: [f32; 3] = "vec3f",
        /// Of the spot's falloff, by the extension's formula.
        angle_scale: f32 = "f32",
        /// Unit axis of the spot, away from the light.
        direction: [f32; 3] = "vec3f",
        /// Of the spot's falloff.
        angle_offset: f32 = "f32",
    }

    /// One of four siblings of the light tree: the lights of a subtree, or a light.
    LightNode as "LightNode" {
        /// Their mean place by power: world, relative to the scene's origin.
        center: [f32; 3] = "vec3f",
        /// Of their places: the mean squared distance from there.
        variance: f32 = "f32",
        /// Mean of their normals by power, x and y as two 16-bit snorms; two-sided lights count as
        /// 0.
        normal_xy: u32 = "u32",
        /// Its z.
        normal_z: f32 = "f32",
        /// Relative to the others'; 0: the slot is empty.
        power: f32 = "f32",
        /// The first of its children, or `LIGHT_LEAF` and the light's number.
        link: u32 = "u32",
    }

    /// The path from the tree's root to a light.
    LightPath as "LightPath" {
        /// Which child, two bits a level, the root's lowest.
        trail: [u32; 2] = "vec2u",
        /// 1/m².
        inverse_area: f32 = "f32",
        /// Fills the record.
        unused: u32 = "u32",
    }

    /// A texture as a material uses it.
    TextureUse as "TextureUse" {
        /// Of its first texel.
        offset: u32 = "u32",
        /// Texels per row.
        width: u32 = "u32",
        /// Rows.
        height: u32 = "u32",
        /// Bits 0–1 wrap s, 2–3 wrap t (0 repeat, 1 mirror, 2 clamp), 4 nearest, 5 sRGB, from 8 the
        /// UV set.
        flags: u32 = "u32",
        /// (u, v) are transformed to (dot(row_u, (u, v, 1)), dot(row_v, (u, v, 1))).
        row_u: [f32; 3] = "vec3f",
        /// As WGSL aligns.
        pad_0: u32 = "u32",
        /// As `row_u`.
        row_v: [f32; 3] = "vec3f",
        /// As WGSL aligns.
        pad_1: u32 = "u32",
    }

    /// An instance of a mesh in a two-level BVH.
    InstanceRows as "Instance" {
        /// Rows of the object-to-world transform.
        world_x: [f32; 4] = "vec4f",
        /// Second row.
        world_y: [f32; 4] = "vec4f",
        /// Third row.
        world_z: [f32; 4] = "vec4f",
        /// Rows of its inverse, directions alone.
        object_x: [f32; 3] = "vec3f",
        /// Number of its first emissive triangle.
        first_light: u32 = "u32",
        /// Second row.
        object_y: [f32; 3] = "vec3f",
        /// As WGSL aligns.
        pad_0: u32 = "u32",
        /// Third row.
        object_z: [f32; 3] = "vec3f",
        /// As WGSL aligns.
        pad_1: u32 = "u32",
    }

    /// A pass over a rectangle of pixels.
    Pass as "Pass" {
        /// Of the rectangle, pixels.
        corner: [u32; 2] = "vec2u",
        /// Of the rectangle, pixels.
        size: [u32; 2] = "vec2u",
        /// Number of the first batch of this pass; with one scramble, of its first sample.
        first_batch: u32 = "u32",
        /// Batches of this pass.
        batches: u32 = "u32",
        /// Samples per batch.
        samples: u32 = "u32",
        /// Loop iterations within which a lane may start another step.
        budget: u32 = "u32",
        /// Of all workgroups.
        lanes: u32 = "u32",
        /// Threads of a CPU driver, each of which has a run of workgroups; 1 elsewhere.
        threads: u32 = "u32",
        /// 1: states begin anew.
        restart: u32 = "u32",
        /// Traversals of each step, where the kernel repeats them to measure them; 1.
        walks: u32 = "u32",
    }

    /// A run of particles of one sequence, and the rectangle of pixels that they contribute to.
    EmissionPass as "EmissionPass" {
        /// Of the rectangle, pixels.
        corner: [u32; 2] = "vec2u",
        /// Of the rectangle, pixels.
        size: [u32; 2] = "vec2u",
        /// Number of the batch; 0 with one scramble.
        replicate: u32 = "u32",
        /// Which of the replicate's sequences.
        sequence: u32 = "u32",
        /// Number of the first particle in it.
        first: u32 = "u32",
        /// Particles.
        count: u32 = "u32",
        /// Of the sequence.
        length: u32 = "u32",
        /// Loop iterations within which a lane may start another step.
        budget: u32 = "u32",
        /// Of all workgroups.
        lanes: u32 = "u32",
        /// 1: states begin anew.
        restart: u32 = "u32",
        /// Weight of a particle in a pixel's sample: 1 / particles emitted per sample of all
        /// pixels.
        particle_weight: f32 = "f32",
        /// 1 / unit of the sums.
        quantum: f32 = "f32",
        /// 1 / the root of the unit of the sums of squares.
        square_quantum: f32 = "f32",
        /// Fills the record.
        unused: u32 = "u32",
    }

    /// Counts of a dispatch, for the host.
    Control as "Control" {
        /// That ran to their end: a canary.
        workgroups: u32 = "atomic<u32>",
        /// Lanes with samples left.
        unfinished: u32 = "atomic<u32>",
        /// Rays traced.
        rays: u32 = "atomic<u32>",
        /// Samples finished.
        paths: u32 = "atomic<u32>",
        /// Samples that were not finite.
        dropped: u32 = "atomic<u32>",
        /// Traversals that reached the limit of steps.
        truncated: u32 = "atomic<u32>",
    }

    /// A batch of a pixel's samples. The film crate's `BatchSum` is the same on the host.
    BatchRecord as "BatchSum" {
        /// Of radiance.
        sum: [f32; 3] = "vec3f",
        /// Upper bits of two f32: 20 of the largest luminance of a sample, never 0, and 12 of the
        /// sum of squared luminances.
        tail: u32 = "u32",
    }

    /// A dispatch of the integration of a formula over a box.
    IntegrationTask as "IntegrationTask" {
        /// Number of the first lane's chunk of samples, or node.
        first: u32 = "u32",
        /// Lanes with work.
        count: u32 = "u32",
        /// Of a replicate; nodes of an axis.
        samples: u32 = "u32",
        /// Of a replicate.
        chunks: u32 = "u32",
        /// Number of the first replicate.
        first_replicate: u32 = "u32",
        /// Keeps the samplers' random numbers apart.
        stream: u32 = "u32",
        /// Of all samples.
        seed: u32 = "u32",
        /// Fills the record.
        unused: u32 = "u32",
        /// Lower bound and width of each dimension, in x and y.
        bounds: [[f32; 4]; MAX_DIMENSIONS as usize] = "array<vec4f, MAX_DIMENSIONS>",
    }

    /// First-hit layers of a pixel, summed over its rays.
    FeaturePixel as "FeaturePixel" {
        /// Sum over the pixel's rays.
        albedo: [f32; 3] = "vec3f",
        /// Metres along the ray through the pixel's centre; 0 where it hits nothing.
        depth: f32 = "f32",
        /// World, sum over the pixel's rays, not normalised.
        normal: [f32; 3] = "vec3f",
        /// Fills the record.
        unused: f32 = "f32",
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_declarations_are_wgsl_of_the_same_layout() {
        let module = naga::front::wgsl::parse_str(&declarations()).unwrap_or_else(|e| panic!("{e}"));
        for (name, host) in host_layouts() {
            let span = module.types.iter().find_map(|(_, ty)| match &ty.inner {
                naga::TypeInner::Struct { span, .. } if ty.name.as_deref() == Some(name) => Some(*span),
                _ => None,
            });
            assert_eq!(span, Some(host.span), "{name}");
        }
    }
}
