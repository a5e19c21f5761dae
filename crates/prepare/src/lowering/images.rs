//! Read-only arrays of the scene as images.
//!
//! CPU drivers take a lane's word from a storage buffer in a loop over the lanes, some 160
//! instructions a word; a texel of four words from an image takes 45. This pass replaces each array
//! of bind group 0 by an image of `rgba32uint` texels, 4096 a row, that holds the same bytes, and
//! each access by a call of a function that assembles the element.

use std::fmt::Write;

use naga::{AddressSpace, Scalar, ScalarKind, TypeInner, VectorSize};
use wesl::syntax::{Declaration, Expression, GlobalDeclaration, Statement, TranslationUnit};

use crate::syntax::{each_expression, each_statement};

/// Texels in a row of an image in place of a buffer; 16 bytes each.
pub const IMAGE_WIDTH: u32 = 4096;

/// Replaces the arrays. `module` is what naga makes of the kernel.
///
/// The error names an array whose elements are not made of whole words, or whose name a local
/// variable hides.
pub(crate) fn arrays_to_images(kernel: &mut TranslationUnit, module: &naga::Module) -> Result<(), String> {
    for (_, global) in module.global_variables.iter() {
        let (Some(name), Some(binding)) = (&global.name, &global.binding) else { continue };
        let read_only = matches!(global.space, AddressSpace::Storage { access } if access == naga::StorageAccess::LOAD);
        let TypeInner::Array { base, stride, .. } = module.types[global.ty].inner else { continue };
        if binding.group == 0 && read_only {
            replace(
                kernel,
                name,
                &loader(name, module, base, stride).ok_or_else(|| format!("no texel holds an element of {name}"))?,
            )?;
        }
    }
    Ok(())
}

/// Replaces the array `name`, and each `name[index]` by a call of `load_name`, which `loader`
/// declares.
fn replace(kernel: &mut TranslationUnit, name: &str, loader: &str) -> Result<(), String> {
    let parsed = |text: &str| text.parse::<TranslationUnit>().map_err(|e| format!("{text}: {e}"));
    let image = parsed(&format!("var {name}: texture_storage_2d<rgba32uint, read>;"))?;
    let Some(GlobalDeclaration::Declaration(Declaration { kind, ty, .. })) =
        image.global_declarations.into_iter().next().map(|d| d.into_inner())
    else {
        return Err(format!("no image can be declared for {name}"));
    };
    for declaration in &mut kernel.global_declarations {
        match declaration.node_mut() {
            GlobalDeclaration::Declaration(array) if *array.ident.name() == name => {
                array.kind = kind;
                array.ty = ty.clone();
            }
            GlobalDeclaration::Function(function) => {
                if function.parameters.iter().any(|p| *p.ident.name() == name) {
                    return Err(format!("a parameter of {} hides the array {name}", function.ident));
                }
                let mut error = None;
                each_statement(&mut function.body, &mut |statement| {
                    if matches!(statement, Statement::Declaration(local) if *local.ident.name() == name) {
                        error = Some(format!("a variable of a function hides the array {name}"));
                    }
                });
                each_expression(&mut function.body, &mut |expression| {
                    let Expression::Indexing(access) = expression else { return };
                    if !matches!(access.base.node(), Expression::TypeOrIdentifier(base) if *base.ident.name() == name) {
                        return;
                    }
                    match format!("load_{name}(u32({}))", access.index).parse::<Expression>() {
                        Ok(call) => *expression = call,
                        Err(e) => error = Some(format!("{name}[{}]: {e}", access.index)),
                    }
                });
                error.map_or(Ok(()), Err)?;
            }
            _ => {}
        }
    }
    kernel.global_declarations.extend(parsed(loader)?.global_declarations);
    Ok(())
}

/// The function `load_name(index)`; `None` for elements that are not made of whole words.
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
        let mut kernel: TranslationUnit = SHADER.parse().unwrap();
        arrays_to_images(&mut kernel, &module).unwrap();
        let text = kernel.to_string();
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
        let hidden = "@group(0) @binding(0) var<storage, read> words: array<u32>; fn f() { let words = 1u; }";
        let mut kernel: TranslationUnit = hidden.parse().unwrap();
        let module = naga::front::wgsl::parse_str(hidden).unwrap();
        assert!(arrays_to_images(&mut kernel, &module).unwrap_err().contains("hides the array words"));
        // 32 bytes a record: its third field opens the second texel.
        assert!(text.contains("bitcast<vec2<f32>>(t1.xy), bitcast<f32>(t1.z), bitcast<i32>(t1.w)"), "{text}");
    }
}
