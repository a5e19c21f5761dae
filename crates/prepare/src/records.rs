//! The arrays of a prepared scene: plain bytes by the names of the shaders' bindings.

use std::borrow::Cow;

use crate::{
    caustics::Caustics,
    compose::Composed,
    kernel_key::Part,
    microfacets::facet_albedos,
    prepared::Prepared,
    reflect::RecordLayout,
    shared::{InstanceRows, View},
    sheen::sheen_albedos,
};

/// An array of the scene, as the kernel reads it.
#[derive(Clone, Debug)]
pub struct SceneArray<'a> {
    /// Name of the binding in the shaders.
    pub name: &'static str,
    /// Its contents, for messages.
    pub what: &'static str,
    /// Its records, one after the other.
    pub bytes: Cow<'a, [u8]>,
}

/// Inputs of the light tracing kernel beside the scene.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LightTracing {
    /// Contribution of a particle of the usual flux to a pixel's sample, at the distance of the
    /// casters.
    pub usual: f64,
    /// Samples of all pixels for which one particle per pixel is emitted.
    pub samples_per_particle: u32,
}

impl Prepared {
    /// The arrays that a kernel of this scene binds; `shader` says how its material records are
    /// laid out.
    pub fn arrays<'a>(&'a self, shader: &Composed) -> Vec<SceneArray<'a>> {
        let key = self.key();
        let lights = &self.lights;
        let mut arrays = Vec::new();
        let mut add = |present: bool, name, what, bytes: Cow<'a, [u8]>| {
            if present {
                arrays.push(SceneArray { name, what, bytes });
            }
        };
        add(true, "items", "the BVH", cast(self.items()));
        add(true, "attributes", "triangle attributes", cast(Cow::Borrowed(self.attributes.as_slice())));
        let materials = RecordLayout::of(shader, "Material").map(|layout| self.material_records(&layout));
        add(true, "materials", "materials", Cow::Owned(materials.unwrap_or_default()));
        let first_light = |k: usize| lights.instance_lights.get(k).copied().unwrap_or_default();
        let instances = self.accel.instances.iter().enumerate();
        let instances: Vec<_> = instances.map(|(k, record)| InstanceRows::new(record, first_light(k))).collect();
        add(key.has(Part::Instances), "instances", "instances", cast(Cow::Owned(instances)));
        let textured = key.has(Part::Textures);
        add(textured, "texture_uses", "texture uses", cast(Cow::Borrowed(self.textures.uses.as_slice())));
        let table = cast(Cow::Borrowed(lights.table.as_slice()));
        add(key.has(Part::LightSampling), "light_table", "the light table", table);
        let area = cast(Cow::Owned(lights.area_records().to_vec()));
        add(key.has(Part::AreaLights), "area_lights", "emissive triangles", area);
        if let Some(tree) = &lights.tree {
            let present = key.has(Part::LightTree);
            add(present, "light_nodes", "the light tree", cast(Cow::Borrowed(tree.nodes.as_slice())));
            add(present, "light_paths", "the light tree's paths", cast(Cow::Borrowed(tree.paths.as_slice())));
        }
        let punctual = cast(Cow::Borrowed(lights.punctual.as_slice()));
        add(key.has(Part::PunctualLights), "punctual_lights", "punctual lights", punctual);
        if key.has(Part::Sheen) {
            add(true, "sheen_albedos", "the sheen's albedos", Cow::Borrowed(bytemuck::cast_slice(sheen_albedos())));
        }
        if key.has(Part::MultipleScattering) {
            add(true, "facet_albedos", "the facets' albedos", Cow::Borrowed(bytemuck::cast_slice(facet_albedos())));
        }
        if let Some(environment) = &self.environment {
            let alias: Vec<[u32; 2]> = environment.alias.iter().map(|s| [s.threshold.to_bits(), s.alias]).collect();
            let texels = cast(Cow::Borrowed(environment.texels.as_slice()));
            add(true, "environment_texels", "the environment map", texels);
            add(true, "environment_alias", "the environment's alias table", cast(Cow::Owned(alias)));
        }
        if let Some(Caustics { casters, table, .. }) = &self.caustics {
            add(true, "casters", "the casters of caustics", cast(Cow::Borrowed(casters.as_slice())));
            add(true, "emitter_table", "the emitters of caustics", cast(Cow::Borrowed(table.as_slice())));
        }
        add(textured, "texels", "textures", cast(Cow::Borrowed(self.textures.texels.as_slice())));
        arrays
    }

    /// Inputs of the light tracing kernel; `None` where no light is traced from the lights.
    pub fn light_tracing(&self) -> Option<LightTracing> {
        let Caustics { usual, samples_per_particle, .. } = self.caustics.as_ref()?;
        Some(LightTracing { usual: *usual, samples_per_particle: *samples_per_particle })
    }

    /// The view: camera, limits and other constants of a render.
    pub fn view(&self) -> View {
        self.view
    }
}

/// Records as bytes.
fn cast<T: bytemuck::NoUninit>(records: Cow<'_, [T]>) -> Cow<'_, [u8]> {
    match records {
        Cow::Borrowed(records) => Cow::Borrowed(bytemuck::cast_slice(records)),
        Cow::Owned(records) => Cow::Owned(bytemuck::cast_slice(&records).to_vec()),
    }
}
