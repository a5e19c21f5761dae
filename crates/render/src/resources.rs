//! What a kernel reads of the scene: uploaded once, bound by name.

use crate::{
    compose::Composed,
    error::RenderError,
    kernel::{Resource, Resources},
    kernel_key::{KernelKey, Part},
    prepare::{InstanceRows, Prepared, facet_albedos, sheen_albedos},
    reflect::RecordLayout,
    upload::Uploader,
};

/// Uploads the scene, but for the view of it.
pub(crate) fn scene_resources(
    up: &mut Uploader<'_>,
    prepared: &Prepared,
    key: &KernelKey,
    shader: &Composed,
) -> Result<Resources, RenderError> {
    use wgpu::BufferUsages as U;
    let mut resources = Resources::new();
    let mut storage = |name: &'static str, what: &str, wanted: bool, bytes: &[u8]| -> Result<(), RenderError> {
        if wanted {
            let resource = if key.has(Part::ItemsImage) {
                Resource::Image(up.image(what, bytes)?)
            } else {
                Resource::Buffer(up.buffer(what, bytes, U::STORAGE)?)
            };
            resources.insert(name.into(), resource);
        }
        Ok(())
    };
    let cast = bytemuck::cast_slice::<_, u8>;
    storage("items", "the BVH", true, bytemuck::cast_slice(&prepared.items()))?;
    storage("attributes", "triangle attributes", true, bytemuck::cast_slice(&prepared.attributes))?;
    let materials = RecordLayout::of(shader, "Material").map(|l| prepared.material_records(&l)).unwrap_or_default();
    storage("materials", "materials", true, &materials)?;
    let first_light = |k: usize| prepared.lights.instance_lights.get(k).copied().unwrap_or_default();
    let instances = prepared.accel.instances.iter().enumerate();
    let instances: Vec<_> = instances.map(|(k, record)| InstanceRows::new(record, first_light(k))).collect();
    storage("instances", "instances", key.has(Part::Instances), bytemuck::cast_slice(&instances))?;
    storage("texture_uses", "texture uses", key.has(Part::Textures), bytemuck::cast_slice(&prepared.textures.uses))?;
    let lights = &prepared.lights;
    storage("light_table", "the light table", key.has(Part::LightSampling), bytemuck::cast_slice(&lights.table))?;
    storage(
        "area_lights",
        "emissive triangles",
        key.has(Part::AreaLights),
        bytemuck::cast_slice(&lights.area_records()),
    )?;
    if let Some(tree) = &lights.tree {
        storage("light_nodes", "the light tree", key.has(Part::LightTree), bytemuck::cast_slice(&tree.nodes))?;
        storage("light_paths", "the light tree's paths", key.has(Part::LightTree), bytemuck::cast_slice(&tree.paths))?;
    }
    storage(
        "punctual_lights",
        "punctual lights",
        key.has(Part::PunctualLights),
        bytemuck::cast_slice(&lights.punctual),
    )?;
    if key.has(Part::Sheen) {
        storage("sheen_albedos", "the sheen's albedos", true, bytemuck::cast_slice(sheen_albedos()))?;
    }
    if key.has(Part::MultipleScattering) {
        storage("facet_albedos", "the facets' albedos", true, bytemuck::cast_slice(facet_albedos()))?;
    }
    if let Some(environment) = &prepared.environment {
        let alias: Vec<[u32; 2]> = environment.alias.iter().map(|s| [s.threshold.to_bits(), s.alias]).collect();
        storage("environment_texels", "the environment map", true, bytemuck::cast_slice(&environment.texels))?;
        storage("environment_alias", "the environment's alias table", true, cast(&alias))?;
    }
    if let Some(caustics) = &prepared.caustics {
        storage("casters", "the casters of caustics", true, bytemuck::cast_slice(&caustics.casters))?;
        storage("emitter_table", "the emitters of caustics", true, bytemuck::cast_slice(&caustics.table))?;
    }
    storage("texels", "textures", key.has(Part::Textures), bytemuck::cast_slice(&prepared.textures.texels))?;
    Ok(resources)
}
