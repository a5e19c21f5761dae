//! What the composed shader says about itself: record layouts and bindings, so that neither is stated twice.

use std::collections::{BTreeMap, HashMap};

use bytemuck::NoUninit;

use crate::compose::Composed;

/// Offsets of a WGSL struct's fields.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct RecordLayout {
    /// Field name to byte offset.
    pub offsets: HashMap<String, u32>,
    /// Field name to bytes.
    pub sizes: HashMap<String, u32>,
    /// Bytes from one record to the next.
    pub span: u32,
}

impl RecordLayout {
    /// The layout of a struct in a composed shader; `None` when it is not there (stripped because unused).
    pub fn of(shader: &Composed, name: &str) -> Option<Self> {
        shader.module.types.iter().find_map(|(_, ty)| match &ty.inner {
            naga::TypeInner::Struct { members, span } if ty.name.as_deref() == Some(name) => Some(Self {
                offsets: members.iter().filter_map(|m| Some((m.name.clone()?, m.offset))).collect(),
                sizes: members.iter().filter_map(|m| Some((m.name.clone()?, size_of_type(shader, m.ty)))).collect(),
                span: *span,
            }),
            _ => None,
        })
    }
}

fn size_of_type(shader: &Composed, ty: naga::Handle<naga::Type>) -> u32 {
    shader.module.types[ty].inner.size(shader.module.to_ctx())
}

/// Writes records by field name; fields that the kernel lacks are left out.
pub(crate) struct RecordWriter<'a> {
    layout: &'a RecordLayout,
    pub(crate) bytes: Vec<u8>,
    /// Every field that was to be written, with its size, whether or not the kernel has it.
    pub(crate) fields: BTreeMap<&'static str, u32>,
}

impl<'a> RecordWriter<'a> {
    pub(crate) fn new(layout: &'a RecordLayout) -> Self {
        Self { layout, bytes: Vec::new(), fields: BTreeMap::new() }
    }

    /// Begins a record of zeros.
    pub(crate) fn begin(&mut self) {
        self.bytes.resize(self.bytes.len() + self.layout.span as usize, 0);
    }

    /// Sets a field of the record begun last.
    pub(crate) fn put<T: NoUninit>(&mut self, field: &'static str, value: T) {
        self.fields.insert(field, size_of::<T>() as u32);
        if let Some(&offset) = self.layout.offsets.get(field) {
            let start = self.bytes.len() - self.layout.span as usize + offset as usize;
            let value = bytemuck::bytes_of(&value);
            self.bytes[start..start + value.len()].copy_from_slice(value);
        }
    }
}

/// A resource that a shader binds.
pub(crate) struct Binding {
    pub(crate) name: String,
    pub(crate) group: u32,
    pub(crate) binding: u32,
    pub(crate) ty: wgpu::BindingType,
}

/// Every resource that the shader still mentions after stripping.
pub(crate) fn bindings(shader: &Composed) -> Vec<Binding> {
    let mut found: Vec<Binding> = shader
        .module
        .global_variables
        .iter()
        .filter_map(|(_, global)| {
            let at = global.binding.as_ref()?;
            let ty = binding_type(&shader.module, global)?;
            Some(Binding { name: global.name.clone()?, group: at.group, binding: at.binding, ty })
        })
        .collect();
    found.sort_by_key(|b| (b.group, b.binding));
    found
}

fn binding_type(module: &naga::Module, global: &naga::GlobalVariable) -> Option<wgpu::BindingType> {
    let buffer = |ty| wgpu::BindingType::Buffer { ty, has_dynamic_offset: false, min_binding_size: None };
    Some(match global.space {
        naga::AddressSpace::Uniform => buffer(wgpu::BufferBindingType::Uniform),
        naga::AddressSpace::Storage { access } => {
            let read_only = !access.contains(naga::StorageAccess::STORE);
            buffer(wgpu::BufferBindingType::Storage { read_only })
        }
        naga::AddressSpace::Handle => match module.types[global.ty].inner {
            naga::TypeInner::Image { class: naga::ImageClass::Storage { .. }, .. } => {
                wgpu::BindingType::StorageTexture {
                    access: wgpu::StorageTextureAccess::ReadOnly,
                    format: wgpu::TextureFormat::Rgba32Uint,
                    view_dimension: wgpu::TextureViewDimension::D2,
                }
            }
            _ => return None,
        },
        _ => return None,
    })
}
