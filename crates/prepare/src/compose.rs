//! Puts a kernel together from the modules in `shaders/`: WESL in, plain WGSL out.

use std::borrow::Cow;

use wesl::{CompileOptions, Feature, ModulePath, NoMangler, VirtualResolver};

use crate::{
    error::{PrepareError, Source},
    kernel_key::{KernelKey, Part, TABLE},
    lowering::{branches::lower_branches, images::arrays_to_images},
    shared,
};

include!(concat!(env!("OUT_DIR"), "/shaders.rs"));

const PATH_KERNEL: &str = "package::kernel::path";
const PATH_REUSE_KERNEL: &str = "package::kernel::path_reuse";

/// Root module of the path kernel, and the record that it keeps between dispatches.
pub fn path_kernel(key: &KernelKey) -> (&'static str, &'static str) {
    if key.reuses_paths() { (PATH_REUSE_KERNEL, "BlockState") } else { (PATH_KERNEL, "LaneState") }
}

/// A composed and validated shader.
#[derive(Debug)]
pub struct Composed {
    /// Plain WGSL.
    pub wgsl: String,
    /// Its parsed module, for reflection.
    pub module: naga::Module,
    /// What validation found out about it.
    pub info: naga::valid::ModuleInfo,
}

/// A constant that modules import from `package::generated`.
#[derive(Clone, Debug, PartialEq)]
pub struct Constant {
    /// Its name in WGSL.
    pub name: &'static str,
    /// Its value.
    pub value: u32,
}

/// Composes `root` (for example `package::kernel::path`) for a kernel key.
///
/// `constants` become the module `package::generated`. The result is stripped of everything that
/// the entry points do not reach, then validated by naga.
pub fn compose(root: &str, key: &KernelKey, constants: &[Constant]) -> Result<Composed, PrepareError> {
    compose_with(root, key, constants, None)
}

/// Paths and sources of all modules, as they are composed.
pub fn shader_modules() -> &'static [(&'static str, &'static str)] {
    MODULES
}

/// Composes from other modules than this crate's own, given as their paths and sources.
pub fn compose_modules(
    root: &str,
    key: &KernelKey,
    constants: &[Constant],
    modules: &[(&str, String)],
) -> Result<Composed, PrepareError> {
    let modules = modules.iter().map(|(path, source)| (*path, source.as_str()));
    compose_all(root, key, constants, modules)
}

/// Composes with one more module, given as its path and source.
pub fn compose_with(
    root: &str,
    key: &KernelKey,
    constants: &[Constant],
    more: Option<(&str, &str)>,
) -> Result<Composed, PrepareError> {
    compose_all(root, key, constants, MODULES.iter().copied().chain(more))
}

fn compose_all<'a>(
    root: &str,
    key: &KernelKey,
    constants: &[Constant],
    modules: impl Iterator<Item = (&'a str, &'a str)>,
) -> Result<Composed, PrepareError> {
    let constants = constants.iter().map(|c| format!("const {}: u32 = {}u;\n", c.name, c.value));
    let generated = constants.chain([shared::declarations()]).collect::<String>();
    let mut resolver = VirtualResolver::new();
    for (path, source) in modules {
        resolver.add_module(module_path(path)?, Cow::Borrowed(source));
    }
    resolver.add_module(module_path("package::generated")?, Cow::Owned(generated));
    let flags = TABLE.iter().map(|row| (row.name.to_owned(), Feature::from(key.has(row.part)))).collect();
    let options = CompileOptions {
        validate: false, // naga does, below, with better knowledge
        features: wesl::Features { default: Feature::Error, flags },
        ..Default::default()
    };
    let compiled = wesl::compile_sourcemap(&module_path(root)?, &resolver, &NoMangler, &options)
        .map_err(|e| defect(root, e.to_string(), e))?;
    let mut kernel = compiled.syntax;
    let on_cpu = key.has(Part::ItemsImage);
    let unlowered = |message: String| PrepareError::Shader { root: root.into(), message, source: None };
    lower_branches(&mut kernel, on_cpu).map_err(unlowered)?;
    if on_cpu {
        let module = parse(root, &kernel.to_string())?;
        arrays_to_images(&mut kernel, &module).map_err(unlowered)?;
    }
    validate(root, kernel.to_string())
}

fn parse(root: &str, wgsl: &str) -> Result<naga::Module, PrepareError> {
    naga::front::wgsl::parse_str(wgsl).map_err(|e| defect(root, e.emit_to_string(wgsl), e))
}

/// Parses and validates plain WGSL.
fn validate(root: &str, wgsl: String) -> Result<Composed, PrepareError> {
    let module = parse(root, &wgsl)?;
    let capabilities = naga::valid::Capabilities::default();
    let info = naga::valid::Validator::new(naga::valid::ValidationFlags::all(), capabilities)
        .validate(&module)
        .map_err(|e| defect(root, e.emit_to_string(&wgsl), e))?;
    Ok(Composed { wgsl, module, info })
}

fn module_path(text: &str) -> Result<ModulePath, PrepareError> {
    text.parse::<ModulePath>().map_err(|e| defect(text, e.to_string(), e))
}

fn defect(root: &str, message: String, source: impl Into<Source>) -> PrepareError {
    PrepareError::Shader { root: root.into(), message, source: Some(source.into()) }
}
