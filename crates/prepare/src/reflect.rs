//! Reflection of composed shaders: record layouts and bindings, so that neither is stated twice.

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
    /// The layout of a struct in a composed shader; `None` when it is not there (stripped because
    /// unused).
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

/// How a shader accesses a resource.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Access {
    /// A uniform buffer.
    Uniform,
    /// A storage buffer that is only read.
    ReadOnlyStorage,
    /// A storage buffer.
    Storage,
    /// A two-dimensional storage image of `rgba32uint` texels that is only read.
    ReadOnlyImage,
}

/// A resource that a shader binds.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Binding {
    /// Name of the variable.
    pub name: String,
    /// Bind group.
    pub group: u32,
    /// Binding in the group.
    pub binding: u32,
    /// How the shader accesses it.
    pub access: Access,
}

/// Every resource that the shader still mentions after stripping, by group and binding.
pub fn bindings(shader: &Composed) -> Vec<Binding> {
    let mut found: Vec<Binding> = shader
        .module
        .global_variables
        .iter()
        .filter_map(|(_, global)| {
            let at = global.binding.as_ref()?;
            let access = access(&shader.module, global)?;
            Some(Binding { name: global.name.clone()?, group: at.group, binding: at.binding, access })
        })
        .collect();
    found.sort_by_key(|b| (b.group, b.binding));
    found
}

fn access(module: &naga::Module, global: &naga::GlobalVariable) -> Option<Access> {
    Some(match global.space {
        naga::AddressSpace::Uniform => Access::Uniform,
        naga::AddressSpace::Storage { access } if access.contains(naga::StorageAccess::STORE) => Access::Storage,
        naga::AddressSpace::Storage { .. } => Access::ReadOnlyStorage,
        naga::AddressSpace::Handle => match module.types[global.ty].inner {
            naga::TypeInner::Image { class: naga::ImageClass::Storage { .. }, .. } => Access::ReadOnlyImage,
            _ => return None,
        },
        _ => return None,
    })
}
