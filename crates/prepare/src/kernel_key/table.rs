//! The table of everything that a kernel may contain: name, meaning, origin, needs, exclusions.
//!
//! These are stated here alone. The composer's conditions, `surelight info`, docs/kernels.md and
//! the sets that the tests compose are made from the table.

use surelight_scene::{AlphaMode, Material, Scene};

use super::reasons::{clipping_cameras, instances, materials, meshes, punctual_lights, textures};

/// Why a kernel has a part.
#[derive(Clone, Copy, Debug)]
pub enum Origin {
    /// Something in the scene needs it; the function names it.
    Scene(fn(&Scene) -> Option<String>),
    /// It follows from the scene as a whole.
    Derived,
    /// The settings select it.
    Settings,
    /// The device selects it.
    Device,
}

/// A row of the table.
#[derive(Debug)]
pub struct Row {
    /// The part.
    pub part: Part,
    /// The condition that shader modules test with `@if(name)`.
    pub name: &'static str,
    /// Its effect on a kernel.
    pub meaning: &'static str,
    /// Why a kernel has it.
    pub origin: Origin,
    /// It cannot be without these.
    pub needs: &'static [Part],
    /// It cannot be without one of these at least.
    pub needs_one_of: &'static [Part],
    /// It cannot be with these, each with the reason.
    pub excludes: &'static [(Part, &'static str)],
}

macro_rules! table {
    ($($part:ident = $name:literal, $meaning:literal, $origin:expr
        $(, needs [$($need:ident)*])?
        $(, one of [$($one:ident)*])?
        $(, excludes [$($excluded:ident: $why:literal),*])?;)*) => {
        /// Something that a kernel contains or lacks.
        #[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
        pub enum Part {
            $(#[doc = $meaning] $part,)*
        }

        /// All rows, in the order of [`Part`].
        pub static TABLE: &[Row] = &[$(Row {
            part: Part::$part,
            name: $name,
            meaning: $meaning,
            origin: $origin,
            needs: &[$($(Part::$need),*)?],
            needs_one_of: &[$($(Part::$one),*)?],
            excludes: &[$($((Part::$excluded, $why)),*)?],
        }),*];
    };
}

use Origin::{Derived, Device, Settings};

table! {
    ItemsImage = "items_image", "The scene is read from storage images instead of buffers, which CPU drivers read faster.", Device;
    Instances = "instances", "Two-level BVH: some mesh is placed more than once.", Origin::Scene(instances);
    VertexNormals = "vertex_normals", "Smooth vertex normals.", Origin::Scene(|s| meshes(s, |m| m.normals.is_some()));
    VertexColors = "vertex_colors", "Vertex colours.", Origin::Scene(|s| meshes(s, |m| m.colors.is_some()));
    Tangents = "tangents", "Vertex tangents, for normal maps and anisotropy.", Origin::Scene(|s| meshes(s, |m| m.tangents.is_some()));
    Textures = "textures", "Some texture is looked up.", Origin::Scene(textures),
        one of [BaseColorTexture MetallicRoughnessTexture NormalTexture EmissiveTexture SpecularTexture SpecularColorTexture TransmissionTexture ClearcoatTexture ClearcoatRoughnessTexture ClearcoatNormalTexture SheenColorTexture SheenRoughnessTexture AnisotropyTexture IridescenceTexture IridescenceThicknessTexture DiffuseTransmissionTexture DiffuseTransmissionColorTexture];
    BaseColorTexture = "base_color_texture", "Base colour textures.", Origin::Scene(|s| materials(s, |m| m.base_color_texture.is_some())),
        needs [Textures];
    MetallicRoughnessTexture = "metallic_roughness_texture", "Metallic-roughness textures.", Origin::Scene(|s| materials(s, |m| m.metallic_roughness_texture.is_some())),
        needs [Textures Ggx];
    NormalTexture = "normal_texture", "Normal maps.", Origin::Scene(|s| materials(s, |m| m.normal_texture.is_some())),
        needs [Textures Tangents];
    EmissiveTexture = "emissive_texture", "Emissive textures.", Origin::Scene(|s| materials(s, |m| m.emissive_texture.is_some())),
        needs [Textures Emission];
    SpecularTexture = "specular_texture", "Specular strength textures.", Origin::Scene(|s| materials(s, |m| m.specular_texture.is_some())),
        needs [Textures Ggx];
    SpecularColorTexture = "specular_color_texture", "Specular colour textures.", Origin::Scene(|s| materials(s, |m| m.specular_color_texture.is_some())),
        needs [Textures Ggx];
    TransmissionTexture = "transmission_texture", "Transmission textures.", Origin::Scene(|s| materials(s, |m| m.transmission_texture.is_some())),
        needs [Textures Transmission];
    ClearcoatTexture = "clearcoat_texture", "Clear coat strength textures.", Origin::Scene(|s| materials(s, |m| m.clearcoat.texture.is_some())),
        needs [Textures Clearcoat];
    ClearcoatRoughnessTexture = "clearcoat_roughness_texture", "Clear coat roughness textures.", Origin::Scene(|s| materials(s, |m| m.clearcoat.roughness_texture.is_some())),
        needs [Textures Clearcoat];
    ClearcoatNormalTexture = "clearcoat_normal_texture", "Clear coat normal maps.", Origin::Scene(|s| materials(s, |m| m.clearcoat.normal_texture.is_some())),
        needs [Textures Tangents Clearcoat];
    SheenColorTexture = "sheen_color_texture", "Sheen colour textures.", Origin::Scene(|s| materials(s, |m| m.sheen.color_texture.is_some())),
        needs [Textures Sheen];
    SheenRoughnessTexture = "sheen_roughness_texture", "Sheen roughness textures.", Origin::Scene(|s| materials(s, |m| m.sheen.roughness_texture.is_some())),
        needs [Textures Sheen];
    AnisotropyTexture = "anisotropy_texture", "Anisotropy textures.", Origin::Scene(|s| materials(s, |m| m.anisotropy.texture.is_some())),
        needs [Textures Anisotropy];
    IridescenceTexture = "iridescence_texture", "Thin film strength textures.", Origin::Scene(|s| materials(s, |m| m.iridescence.texture.is_some())),
        needs [Textures Iridescence];
    IridescenceThicknessTexture = "iridescence_thickness_texture", "Thin film thickness textures.", Origin::Scene(|s| materials(s, |m| m.iridescence.thickness_texture.is_some())),
        needs [Textures Iridescence];
    DiffuseTransmissionTexture = "diffuse_transmission_texture", "Diffuse transmission strength textures.", Origin::Scene(|s| materials(s, |m| m.diffuse_transmission.texture.is_some())),
        needs [Textures DiffuseTransmission];
    DiffuseTransmissionColorTexture = "diffuse_transmission_color_texture", "Diffuse transmission colour textures.", Origin::Scene(|s| materials(s, |m| m.diffuse_transmission.color_texture.is_some())),
        needs [Textures DiffuseTransmission];
    Alpha = "alpha", "Alpha masks or blending: coverage is tested during traversal.", Origin::Scene(|s| materials(s, |m| m.alpha_mode != AlphaMode::Opaque));
    Ggx = "ggx", "Microfacet reflection; without it every surface is Lambert's.", Derived;
    Metal = "metal", "Some surface may be (partly) metal.", Origin::Scene(|s| materials(s, |m| m.metallic > 0.0)),
        needs [Ggx];
    DeltaLobes = "delta_lobes", "Some surface may be so smooth that its lobes are deltas.", Derived,
        needs [Ggx];
    Transmission = "transmission", "Some surface may transmit light.", Origin::Scene(|s| materials(s, |m| m.transmission > 0.0 || m.diffuse_transmission.factor > 0.0)),
        needs [Ggx];
    Dispersion = "dispersion", "Refraction that differs by colour.", Origin::Scene(|s| materials(s, |m| m.dispersion > 0.0 && m.volume.is_some())),
        needs [Transmission];
    DiffuseTransmission = "diffuse_transmission", "Some Lambertian base sends light to its other side.", Origin::Scene(|s| materials(s, |m| m.diffuse_transmission.factor > 0.0)),
        needs [Transmission];
    Anisotropy = "anisotropy", "Facets that are rougher along one direction.", Origin::Scene(|s| materials(s, |m| m.anisotropy.strength > 0.0)),
        needs [Ggx Tangents];
    Iridescence = "iridescence", "Thin films that colour the reflection.", Origin::Scene(|s| materials(s, |m| m.iridescence.factor > 0.0)),
        needs [Ggx];
    Sheen = "sheen", "A layer of fibres over some surface.", Origin::Scene(|s| materials(s, |m| m.sheen.color.iter().any(|&c| c > 0.0))),
        needs [Ggx];
    Clearcoat = "clearcoat", "A clear coat over some surface.", Origin::Scene(|s| materials(s, |m| m.clearcoat.factor > 0.0)),
        needs [Ggx];
    Volume = "volume", "Absorbing media inside closed meshes.", Origin::Scene(|s| materials(s, |m| m.volume.is_some())),
        needs [Transmission];
    Nested = "nested", "Volumes within one another, or overlapping.", Origin::Scene(|s| materials(s, |m| m.volume.is_some() && (m.transmission > 0.0 || m.diffuse_transmission.factor > 0.0))),
        needs [Volume];
    VolumeAlpha = "volume_alpha", "Some volume has alpha: coverage is decided where a ray enters, and holds where it leaves.", Origin::Scene(|s| materials(s, |m| m.volume.is_some() && m.alpha_mode != AlphaMode::Opaque)),
        needs [Alpha Transmission];
    Panes = "panes", "Smooth thin panes: light goes straight through them, and light sampling sees through them.", Origin::Scene(|s| materials(s, |m| m.transmission > 0.0 && m.volume.is_none())),
        needs [DeltaLobes Transmission],
        excludes [Whitted: "shadow rays end at glass"];
    Unlit = "unlit", "Unlit materials.", Origin::Scene(|s| materials(s, |m| m.unlit));
    Emission = "emission", "Some surface emits light.", Origin::Scene(|s| materials(s, Material::is_emissive));
    LightSampling = "light_sampling", "Next-event estimation: there is a light that can be sampled.", Derived,
        one of [PunctualLights AreaLights EnvironmentMap],
        excludes [Hemisphere: "directions alone are sampled"];
    AreaLights = "area_lights", "Emissive triangles can be sampled.", Origin::Scene(|s| materials(s, Material::is_emissive)),
        needs [Emission LightSampling];
    LightTree = "light_tree", "There are several area lights: a tree chooses among them.", Derived,
        needs [AreaLights],
        excludes [Whitted: "its few shadow rays need no tree"];
    PunctualLights = "punctual_lights", "Point, spot or directional lights.", Origin::Scene(punctual_lights),
        needs [LightSampling];
    Caustics = "caustics", "Light that mirrors and smooth glass send to scattering surfaces is traced from the lights.", Settings,
        needs [LightSampling DeltaLobes],
        excludes [Receiver: "a receiver is measured, which is no camera", Nested: "volumes overlap", VolumeAlpha: "a volume has alpha"];
    EnvironmentUniform = "environment_uniform", "Light from far away, uniform.", Derived;
    EnvironmentMap = "environment_map", "Light from far away, a map.", Derived;
    Orthographic = "orthographic", "Orthographic camera.", Derived;
    Lens = "lens", "Thin lens with an aperture.", Settings;
    CameraClip = "camera_clip", "The camera's near or far plane cuts something off the picture.", Origin::Scene(clipping_cameras);
    Receiver = "receiver", "A virtual white receiver in place of the camera: irradiance is measured.", Settings;
    MultipleScattering = "multiple_scattering", "Rough reflections get back what their facets lose by scattering once.", Settings,
        needs [Ggx];
    ClampRadiance = "clamp_radiance", "Samples are clamped (biased).", Settings;
    Hemisphere = "hemisphere", "Directions alone are sampled: the hemisphere form.", Settings;
    Area = "area", "Points on lights alone are sampled: the area form.", Settings;
    Whitted = "whitted", "Whitted's ray tracing (biased).", Settings;
    DirectionsUniform = "directions_uniform", "Directions uniform over the hemisphere.", Settings,
        needs [Hemisphere];
    DirectionsCosine = "directions_cosine", "Directions by the cosine.", Settings,
        needs [Hemisphere];
    SamplerIndependent = "sampler_independent", "Independent random numbers.", Settings;
    SamplerStratified = "sampler_stratified", "Jittered strata.", Settings;
    OneScramble = "one_scramble", "All batches of a pixel are pieces of one Sobol sequence.", Settings;
    PathReuse = "path_reuse", "Neighbouring pixels use each other's second vertices.", Settings,
        excludes [Receiver: "a receiver is measured, which has no neighbours", Dispersion: "the choice of a colour depends on the path so far", Nested: "the medium depends on the path so far", VolumeAlpha: "the medium depends on the path so far"];
    Adaptive = "adaptive", "Where noise is strong, a sample is the mean of several paths.", Settings;
    Transparent = "transparent", "The environment does not show to the camera; coverage is counted.", Settings;
    NoRoulette = "no_roulette", "Paths end at the bounce limit alone: for tests of Russian roulette.", Settings;
    RepeatWalk = "repeat_walk", "Rays are traversed several times, to measure what traversal costs.", Settings;
}
