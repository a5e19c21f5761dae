//! What a kernel contains: decided by the scene before compilation.
//!
//! A feature that a scene lacks is absent from its kernel, its bindings and its records.

/// Declares the flags once: name, meaning.
macro_rules! features {
    ($($(#[doc = $doc:literal])+ $name:ident,)+) => {
        /// The conditions that shader modules may test with `@if(name)`.
        #[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
        pub struct Features {
            $($(#[doc = $doc])+ pub $name: bool,)+
        }

        impl Features {
            /// Every flag with its name and its meaning, in declaration order.
            pub fn list(&self) -> Vec<(&'static str, bool, &'static str)> {
                vec![$((stringify!($name), self.$name, concat!($($doc),+).trim_ascii())),+]
            }

            /// Sets a flag by name; false when there is none of that name.
            pub fn set(&mut self, name: &str, value: bool) -> bool {
                match name {
                    $(stringify!($name) => self.$name = value,)+
                    _ => return false,
                }
                true
            }
        }
    };
}

features! {
    /// The scene is read from storage images instead of buffers (faster on CPU drivers); see `images`.
    items_image,
    /// Two-level BVH: some mesh is placed more than once.
    instances,
    /// Smooth vertex normals.
    vertex_normals,
    /// Vertex colours.
    vertex_colors,
    /// Vertex tangents, for normal maps.
    tangents,
    /// Some texture is looked up.
    textures,
    /// Base colour textures.
    base_color_texture,
    /// Metallic-roughness textures.
    metallic_roughness_texture,
    /// Normal maps.
    normal_texture,
    /// Emissive textures.
    emissive_texture,
    /// Specular strength textures.
    specular_texture,
    /// Specular colour textures.
    specular_color_texture,
    /// Transmission textures.
    transmission_texture,
    /// Clear coat strength textures.
    clearcoat_texture,
    /// Clear coat roughness textures.
    clearcoat_roughness_texture,
    /// Clear coat normal maps.
    clearcoat_normal_texture,
    /// Sheen colour textures.
    sheen_color_texture,
    /// Sheen roughness textures.
    sheen_roughness_texture,
    /// Anisotropy textures.
    anisotropy_texture,
    /// Thin film strength textures.
    iridescence_texture,
    /// Thin film thickness textures.
    iridescence_thickness_texture,
    /// Diffuse transmission strength textures.
    diffuse_transmission_texture,
    /// Diffuse transmission colour textures.
    diffuse_transmission_color_texture,
    /// Alpha masks or blending: coverage is tested while walking the BVH.
    alpha,
    /// Microfacet reflection; without it every surface is Lambert's.
    ggx,
    /// Some surface may be (partly) metal.
    metal,
    /// Some surface may be so smooth that its lobes are deltas.
    delta_lobes,
    /// Some surface may transmit light.
    transmission,
    /// Refraction that differs by colour.
    dispersion,
    /// Some Lambertian base sends light to its other side.
    diffuse_transmission,
    /// Facets that are rougher along one direction.
    anisotropy,
    /// Thin films that colour the reflection.
    iridescence,
    /// A layer of fibres over some surface.
    sheen,
    /// A clear coat over some surface.
    clearcoat,
    /// Absorbing media inside closed meshes.
    volume,
    /// Volumes within one another, or overlapping.
    nested,
    /// Some volume has alpha: coverage is decided where a ray enters, and holds where it leaves.
    volume_alpha,
    /// Smooth thin panes: light goes straight through them, and light sampling sees through them.
    panes,
    /// Unlit materials.
    unlit,
    /// Some surface emits light.
    emission,
    /// Next-event estimation: there is a light that can be sampled.
    light_sampling,
    /// Emissive triangles can be sampled.
    area_lights,
    /// There are several area lights: a tree chooses among them.
    light_tree,
    /// Point, spot or directional lights.
    punctual_lights,
    /// What comes to scattering surfaces by mirrors and smooth glass is traced from the lights.
    caustics,
    /// Light from far away, uniform.
    environment_uniform,
    /// Light from far away, a map.
    environment_map,
    /// Orthographic camera.
    orthographic,
    /// Thin lens with an aperture.
    lens,
    /// The camera's near or far plane cuts something off the picture.
    camera_clip,
    /// A virtual white receiver stands in for the camera: irradiance is measured.
    receiver,
    /// Rough reflections get back what their facets lose by scattering once.
    multiple_scattering,
    /// Samples are clamped (biased).
    clamp_radiance,
    /// Directions alone are sampled: the hemisphere form.
    hemisphere,
    /// Points on lights alone are sampled: the area form.
    area,
    /// Whitted's ray tracing (biased).
    whitted,
    /// Directions uniform over the hemisphere.
    directions_uniform,
    /// Directions by the cosine.
    directions_cosine,
    /// Independent random numbers.
    sampler_independent,
    /// Jittered strata.
    sampler_stratified,
    /// All batches of a pixel are pieces of one Sobol sequence.
    one_scramble,
    /// Neighbouring pixels use each other's second vertices.
    shared_paths,
    /// Where noise is strong, a sample is the mean of several paths.
    adaptive,
    /// The environment does not show to the camera; coverage is counted.
    transparent,
    /// Paths end at the bounce limit alone: for tests of roulette.
    no_roulette,
    /// Rays are walked several times, to measure what a walk costs.
    repeat_walk,
}
