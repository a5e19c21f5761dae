//! Turns the scene's read-only arrays into images, for CPU drivers.
//!
//! Such drivers take a lane's word from a storage buffer in a loop over the lanes, some 160 instructions a word; a texel of
//! four words from an image takes 45. Shaders speak of arrays throughout: this pass over a composed kernel replaces each
//! array of bind group 0 by an image of `rgba32uint` texels, 4096 a row, that holds the same bytes, and each access by a
//! call of a function that puts the element together again.

use std::fmt::Write;

use naga::{AddressSpace, Scalar, ScalarKind, TypeInner, VectorSize};

/// Texels in a row of an image that stands in for a buffer; 16 bytes each.
pub const IMAGE_WIDTH: u32 = 4096;

/// The same kernel with images instead of arrays. `module` is what naga makes of `wgsl`.
pub(crate) fn arrays_to_images(wgsl: &str, module: &naga::Module) -> String {
    let mut text = wgsl.to_owned();
    for (_, global) in module.global_variables.iter() {
        let (Some(name), Some(binding)) = (&global.name, &global.binding) else { continue };
        let read_only = matches!(global.space, AddressSpace::Storage { access } if access == naga::StorageAccess::LOAD);
        let TypeInner::Array { base, stride, .. } = module.types[global.ty].inner else { continue };
        if binding.group != 0 || !read_only {
            continue;
        }
        let Some(loader) = loader(name, module, base, stride) else { continue };
        let Some(declared) = declaration(&text, name) else { continue };
        let declaration = format!("var {name}: texture_storage_2d<rgba32uint, read>;\n\n{loader}");
        text.replace_range(declared, &declaration);
        text = with_calls(&text, name);
    }
    text
}

/// Where `var<storage, read> name: array<…>;` stands.
fn declaration(text: &str, name: &str) -> Option<std::ops::Range<usize>> {
    let mut from = 0;
    while let Some(found) = text[from..].find("var<storage") {
        let start = from + found;
        let end = start + text[start..].find(';')? + 1;
        let after = text[start..end].split_once('>')?.1.trim_start();
        if after.strip_prefix(name).is_some_and(|rest| rest.trim_start().starts_with(':')) {
            return Some(start..end);
        }
        from = end;
    }
    None
}

/// The function `load_name(index)`; none for elements that do not lie in texels.
fn loader(name: &str, module: &naga::Module, base: naga::Handle<naga::Type>, stride: u32) -> Option<String> {
    let ty = &module.types[base];
    let texel = |x: &str| {
        let row = IMAGE_WIDTH.trailing_zeros();
        format!("textureLoad({name}, vec2u(({x}) & {}u, ({x}) >> {row}u))", IMAGE_WIDTH - 1)
    };
    let mut body = String::new();
    let result = match &ty.inner {
        TypeInner::Struct { members, .. } if stride.is_multiple_of(16) => {
            let texels = stride / 16;
            for k in 0..texels {
                writeln!(body, "    let t{k} = {};", texel(&format!("index * {texels}u + {k}u"))).ok()?;
            }
            let fields: Option<Vec<String>> = members
                .iter()
                .map(|m| field(&format!("t{}", m.offset / 16), m.offset % 16 / 4, &module.types[m.ty].inner))
                .collect();
            format!("{}({})", ty.name.as_ref()?, fields?.join(", "))
        }
        inner if stride == 16 => {
            writeln!(body, "    let t = {};", texel("index")).ok()?;
            field("t", 0, inner)?
        }
        inner if stride == 8 => {
            writeln!(body, "    let t = {};", texel("index >> 1u")).ok()?;
            writeln!(body, "    let half = select(t.xy, t.zw, (index & 1u) == 1u);").ok()?;
            field("half", 0, inner)?
        }
        inner if stride == 4 => {
            writeln!(body, "    let t = {};", texel("index >> 2u")).ok()?;
            writeln!(body, "    let word = t[index & 3u];").ok()?;
            match inner {
                TypeInner::Scalar(Scalar { kind: ScalarKind::Uint, .. }) => "word".to_owned(),
                TypeInner::Scalar(s) => format!("bitcast<{}>(word)", scalar_name(*s)?),
                _ => return None,
            }
        }
        _ => return None,
    };
    let type_text = match &ty.inner {
        TypeInner::Struct { .. } => ty.name.clone()?,
        inner => type_name(inner)?,
    };
    Some(format!("fn load_{name}(index: u32) -> {type_text} {{\n{body}    return {result};\n}}\n"))
}

/// A value out of the components of `vector`, from component `first` on.
fn field(vector: &str, first: u32, inner: &TypeInner) -> Option<String> {
    let (count, scalar) = match inner {
        TypeInner::Scalar(s) => (1, *s),
        TypeInner::Vector { size, scalar } => (*size as u32, *scalar),
        _ => return None,
    };
    let components = "xyzw".get(first as usize..(first + count) as usize)?;
    Some(match scalar.kind {
        ScalarKind::Uint => format!("{vector}.{components}"),
        _ => format!("bitcast<{}>({vector}.{components})", type_name(inner)?),
    })
}

fn type_name(inner: &TypeInner) -> Option<String> {
    Some(match inner {
        TypeInner::Scalar(s) => scalar_name(*s)?.to_owned(),
        TypeInner::Vector { size, scalar } => {
            let n = match size {
                VectorSize::Bi => 2,
                VectorSize::Tri => 3,
                VectorSize::Quad => 4,
            };
            format!("vec{n}<{}>", scalar_name(*scalar)?)
        }
        _ => return None,
    })
}

fn scalar_name(scalar: Scalar) -> Option<&'static str> {
    match (scalar.kind, scalar.width) {
        (ScalarKind::Uint, 4) => Some("u32"),
        (ScalarKind::Sint, 4) => Some("i32"),
        (ScalarKind::Float, 4) => Some("f32"),
        _ => None,
    }
}

/// `name[index]` becomes `load_name(index)`.
fn with_calls(text: &str, name: &str) -> String {
    let mut out = String::with_capacity(text.len());
    let mut rest = text;
    let pattern = format!("{name}[");
    while let Some(at) = rest.find(&pattern) {
        let whole = !rest[..at].ends_with(|c: char| c.is_alphanumeric() || c == '_' || c == '.');
        let open = at + pattern.len();
        out.push_str(&rest[..at]);
        if !whole {
            out.push_str(&rest[at..open]);
            rest = &rest[open..];
            continue;
        }
        let mut depth = 1;
        let close = rest[open..].find(|c| {
            depth += i32::from(c == '[') - i32::from(c == ']');
            depth == 0
        });
        let close = open + close.unwrap_or(rest.len() - open);
        out.push_str(&format!("load_{name}(u32({}))", with_calls(&rest[open..close], name)));
        rest = rest.get(close + 1..).unwrap_or_default();
    }
    out.push_str(rest);
    out
}

#[cfg(test)]
mod tests {
    use super::*;

    const SHADER: &str = "
        struct Record { a: vec3f, b: u32, c: vec2f, d: f32, e: i32, }
        @group(0) @binding(0) var<storage, read> records: array<Record>;
        @group(0) @binding(1) var<storage, read> words: array<u32>;
        @group(0) @binding(2) var<storage, read> pairs: array<vec2f>;
        @group(0) @binding(3) var<storage, read> quads: array<vec4u>;
        @group(0) @binding(4) var<storage, read_write> mine: array<u32>;
        @group(1) @binding(0) var<storage, read> words_apart: array<u32>;
        @compute @workgroup_size(1) fn main() {
            let r = records[words[words[2] + 1u]];
            mine[0] = words_apart[words[0]] + r.b + u32(pairs[r.b].y) + quads[u32(records[1].d)].w;
        }";

    #[test]
    fn arrays_of_the_first_group_become_images_of_the_same_bytes() {
        let module = naga::front::wgsl::parse_str(SHADER).unwrap();
        let text = arrays_to_images(SHADER, &module);
        let images = naga::front::wgsl::parse_str(&text).unwrap_or_else(|e| panic!("{}", e.emit_to_string(&text)));
        let validated = naga::valid::Validator::new(naga::valid::ValidationFlags::all(), Default::default());
        { validated }.validate(&images).unwrap();
        for (_, global) in images.global_variables.iter() {
            let image = matches!(images.types[global.ty].inner, TypeInner::Image { .. });
            let name = global.name.as_deref().unwrap();
            assert_eq!(image, ["records", "words", "pairs", "quads"].contains(&name), "{name}");
        }
        assert!(text.contains("load_records(u32(load_words(u32(load_words(u32(2)) + 1u))))"), "{text}");
        assert!(text.contains("words_apart[load_words(u32(0))]"), "{text}");
        // 32 bytes a record: its third field opens the second texel.
        assert!(text.contains("bitcast<vec2<f32>>(t1.xy), bitcast<f32>(t1.z), bitcast<i32>(t1.w)"), "{text}");
    }
}
