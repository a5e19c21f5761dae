//! `cargo xtask mutate`: proof that the torture tests can fail.
//!
//! Each row of the table plants one mistake in a copy of the tree, runs the one test that must
//! notice it, and reports whether it did. The copy is in `target/mutate`. All mutations share its
//! build folder, so that only the parts that a mistake touches are built again; the checkout's own
//! cannot be shared, since cargo would take crates of the copy for those of the checkout.
//!
//! A mistake in a shader names a declaration and an operation on its syntax ([`Operation`]), one in
//! Rust a text. Either must apply exactly once: where the code has changed under it, that is an
//! error, and a unit test reports it long before anybody runs the mutations.

mod accumulation;
mod bsdf;
mod geometry;
mod light;
mod numeric;
mod operation;
mod sampling;

use std::fs;
use std::path::{Path, PathBuf};
use std::process::Command;
use std::time::{Duration, Instant};

use self::operation::Operation;

/// A mistake, and the test that must notice it.
pub(crate) struct Mutation {
    /// Number of the case in the torture list.
    case: u32,
    /// The mistake, in a few words.
    mistake: &'static str,
    /// The place that it is made at, and the change.
    place: Place,
    /// The test's binary, such as `torture_numeric`.
    binary: &'static str,
    /// The test's name within it, modules included.
    test: &'static str,
}

/// Where a mistake is planted, and how.
enum Place {
    /// In a shader module, such as `bsdf/ggx`: in a function, or a constant.
    Shader { module: &'static str, declaration: &'static str, operation: Operation },
    /// In a Rust file: a text that it has exactly once becomes another.
    Source { file: &'static str, from: &'static str, to: &'static str },
}

impl Place {
    /// The file, relative to the repository.
    fn file(&self) -> PathBuf {
        match self {
            Self::Shader { module, .. } => {
                let wesl = PathBuf::from(format!("shaders/{module}.wesl"));
                if crate::repository().join(&wesl).exists() { wesl } else { wesl.with_extension("wgsl") }
            }
            Self::Source { file, .. } => file.into(),
        }
    }

    /// The mutated text of the file.
    fn apply(&self, text: &str) -> Result<String, String> {
        match self {
            Self::Shader { module, declaration, operation } => {
                operation.apply(text, declaration).map_err(|e| format!("{module}: {e}"))
            }
            Self::Source { file, from, to } => match text.matches(from).count() {
                1 if from != to => Ok(text.replacen(from, to, 1)),
                n => Err(format!("{file} has the text {n} times, not once, or it does not change")),
            },
        }
    }
}

impl std::fmt::Display for Place {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match self {
            Self::Shader { module, declaration, .. } => write!(f, "`{module}`, `{declaration}`"),
            Self::Source { file, .. } => write!(f, "`{file}`"),
        }
    }
}

/// The result of a mutation.
enum Verdict {
    /// The test failed.
    Caught,
    /// The test passed.
    Missed,
    /// The code with the mistake does not build, so that nothing was tested.
    Broken,
}

/// The table, group by group.
fn table() -> impl Iterator<Item = &'static Mutation> {
    [numeric::ROWS, geometry::ROWS, sampling::ROWS, bsdf::ROWS, light::ROWS, accumulation::ROWS].into_iter().flatten()
}

/// Arguments of `cargo xtask mutate`.
#[derive(clap::Args)]
pub(crate) struct Arguments {
    /// Numbers of the cases [default: all]
    #[arg(value_name = "CASE")]
    cases: Vec<u32>,
    /// Print the table of mistakes instead
    #[arg(long, conflicts_with = "cases")]
    list: bool,
}

/// Plants the chosen mistakes, or lists all.
pub(crate) fn run(root: &Path, Arguments { cases, list }: &Arguments) -> Result<(), String> {
    if *list {
        print!("{}", markdown());
        return Ok(());
    }
    let mut chosen: Vec<&Mutation> = table().collect();
    if !cases.is_empty() {
        chosen.retain(|m| cases.contains(&m.case));
        if let Some(missing) = cases.iter().find(|n| !chosen.iter().any(|m| m.case == **n)) {
            return Err(format!("case {missing} has no mutation"));
        }
    }
    let copy = root.join("target/mutate");
    synchronise(root, &copy)?;
    let mut misses = Vec::new();
    for mutation in &chosen {
        let started = Instant::now();
        let verdict = mutation.run(root, &copy)?;
        let word = match verdict {
            Verdict::Caught => "caught",
            Verdict::Missed => "MISSED",
            Verdict::Broken => "DOES NOT BUILD",
        };
        println!("{:>2} {word:<8} {:>4.0} s  {}", mutation.case, started.elapsed().as_secs_f64(), mutation.mistake);
        if !matches!(verdict, Verdict::Caught) {
            misses.push(format!("{} ({})", mutation.case, mutation.mistake));
        }
    }
    println!("{} of {} caught", chosen.len() - misses.len(), chosen.len());
    if misses.is_empty() { Ok(()) } else { Err(format!("not caught: {}", misses.join(", "))) }
}

impl Mutation {
    /// The mutated text of its file.
    fn apply(&self, text: &str) -> Result<String, String> {
        self.place.apply(text).map_err(|e| format!("case {}, {}: {e}", self.case, self.mistake))
    }

    /// Plants the mistake in the copy, runs the test, and takes it out again.
    fn run(&self, root: &Path, copy: &Path) -> Result<Verdict, String> {
        let file = self.place.file();
        let original = read(&root.join(&file))?;
        let path = copy.join(&file);
        write(&path, self.apply(&original)?.as_bytes())?;
        let verdict = self.test(copy);
        write(&path, original.as_bytes())?;
        verdict
    }

    fn test(&self, copy: &Path) -> Result<Verdict, String> {
        let cargo = |more: &[&str]| {
            let mut command = Command::new(env!("CARGO"));
            command.args(["test", "--quiet", "--release", "-p", "surelight-tests", "--test", self.binary]).args(more);
            command.current_dir(copy).env("CARGO_TARGET_DIR", copy.join("target")).env("CARGO_INCREMENTAL", "1");
            command.output().map_err(|e| format!("cargo cannot be run: {e}"))
        };
        let built = cargo(&["--no-run"])?;
        if !built.status.success() {
            eprintln!("{}", String::from_utf8_lossy(&built.stderr));
            return Ok(Verdict::Broken);
        }
        let run = cargo(&["--", "--exact", self.test])?;
        let text = String::from_utf8_lossy(&run.stdout);
        if !text.contains("1 passed") && !text.contains("1 failed") {
            return Err(format!("{} has no test {}: {text}", self.binary, self.test));
        }
        // Shaders are composed when the test runs: one that does not compose fails every test.
        let composes = !format!("{text}{}", String::from_utf8_lossy(&run.stderr)).contains("does not compile");
        Ok(match run.status.success() {
            true => Verdict::Missed,
            false if composes => Verdict::Caught,
            false => Verdict::Broken,
        })
    }
}

/// Makes the copy equal to the checkout: files that git tracks or would, and no others. Equal files
/// are left alone, so that they are not built again.
fn synchronise(root: &Path, copy: &Path) -> Result<(), String> {
    let listed = Command::new("git")
        .args(["ls-files", "--cached", "--others", "--exclude-standard", "-z"])
        .current_dir(root)
        .output()
        .map_err(|e| format!("git cannot be run: {e}"))?;
    let names: Vec<PathBuf> =
        String::from_utf8_lossy(&listed.stdout).split('\0').filter(|n| !n.is_empty()).map(PathBuf::from).collect();
    if names.is_empty() {
        return Err(format!("git knows no files in {}", root.display()));
    }
    for name in &names {
        // A file that is tracked and deleted is not there.
        let Ok(bytes) = fs::read(root.join(name)) else { continue };
        let path = copy.join(name);
        if fs::read(&path).is_ok_and(|old| old == bytes) {
            continue;
        }
        write(&path, &bytes)?;
    }
    remove_others(copy, copy, &names)
}

/// Removes files that are no longer in the checkout.
fn remove_others(root: &Path, folder: &Path, names: &[PathBuf]) -> Result<(), String> {
    let entries = fs::read_dir(folder).map_err(|e| format!("{} cannot be listed: {e}", folder.display()))?;
    for entry in entries.flatten() {
        let path = entry.path();
        let relative = path.strip_prefix(root).unwrap_or(&path);
        if relative == Path::new("target") {
            continue;
        }
        if path.is_dir() {
            remove_others(root, &path, names)?;
        } else if !names.iter().any(|n| n == relative) {
            fs::remove_file(&path).map_err(|e| format!("{} cannot be removed: {e}", path.display()))?;
        }
    }
    Ok(())
}

fn read(path: &Path) -> Result<String, String> {
    fs::read_to_string(path).map_err(|e| format!("{} cannot be read: {e}", path.display()))
}

/// Writes a file with a time that no earlier build can have seen: cargo compares times, and coarse
/// ones would hide a change.
fn write(path: &Path, bytes: &[u8]) -> Result<(), String> {
    let fail = |e| format!("{} cannot be written: {e}", path.display());
    if let Some(folder) = path.parent() {
        fs::create_dir_all(folder).map_err(fail)?;
    }
    fs::write(path, bytes).map_err(fail)?;
    std::thread::sleep(Duration::from_millis(5));
    Ok(())
}

/// The table of docs/testing.md.
fn markdown() -> String {
    let mut text = String::from("| case | mistake | in | noticed by |\n|---:|---|---|---|\n");
    for Mutation { case, mistake, place, binary, test } in table() {
        text.push_str(&format!("| {case} | {mistake} | {place} | `{binary}`, `{test}` |\n"));
    }
    text
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::repository;

    /// Quick, and run with all tests: the mutations themselves take minutes.
    #[test]
    fn every_mutation_still_applies_exactly_once() {
        let mut number = 0;
        let mut errors = Vec::new();
        for mutation in table() {
            let text = read(&repository().join(mutation.place.file())).expect("the file is there");
            match mutation.apply(&text) {
                Err(e) => errors.push(e),
                Ok(mutated) if matches!(mutation.place, Place::Shader { .. }) => {
                    if let Err(e) = mutated.parse::<wesl::syntax::TranslationUnit>() {
                        errors.push(format!("{}: {e}", mutation.mistake));
                    }
                }
                Ok(_) => {}
            }
            assert!((1..=44).contains(&mutation.case) && mutation.case >= number, "the table is not in order");
            number = mutation.case;
        }
        assert!(errors.is_empty(), "{}", errors.join("\n"));
    }

    #[test]
    fn every_mutation_names_a_test_that_is_there() {
        for mutation in table() {
            let group = mutation.binary.strip_prefix("torture_").expect("a group of the torture list");
            let mut parts: Vec<&str> = mutation.test.split("::").collect();
            let name = parts.pop().expect("a name");
            let module = if parts.is_empty() { "main".to_owned() } else { parts.join("/") };
            let path = repository().join(format!("tests/torture/{group}/{module}.rs"));
            let source = read(&path).unwrap_or_else(|e| panic!("{e}"));
            assert!(source.contains(&format!("fn {name}()")), "{} has no {name}", path.display());
        }
    }

    #[test]
    fn the_table_in_the_documentation_is_this_one() {
        let text = read(&repository().join("docs/testing.md")).expect("it is there");
        assert!(text.contains(&markdown()), "docs/testing.md: put in what `cargo xtask mutate --list` prints");
    }

    #[test]
    fn text_that_is_not_there_once_is_an_error() {
        let place = Place::Source { file: "f", from: "a", to: "b" };
        assert_eq!(place.apply("cat").as_deref(), Ok("cbt"));
        assert!(place.apply("dog").is_err() && place.apply("banana").is_err());
    }

    /// The printed syntax of a declaration composes to the same kernel as its text.
    #[test]
    fn declarations_survive_being_printed() {
        use surelight_prepare::{KernelKey, compose_modules, path_kernel, shader_modules};
        let key = KernelKey::default();
        let constants = ["STACK_SIZE", "LIGHT_TREE_DEPTH", "ATTRIBUTE_STRIDE"]
            .map(|name| surelight_prepare::Constant { name, value: 8 });
        let texts: Vec<_> = shader_modules().iter().map(|&(path, source)| (path, source.to_owned())).collect();
        let print = |source: &str| {
            let unit: wesl::syntax::TranslationUnit = source.parse().unwrap_or_else(|e| panic!("{e}"));
            let mut text = source.to_owned();
            for node in unit.global_declarations.iter().rev() {
                text.replace_range(node.span().range(), &node.to_string());
            }
            text
        };
        let printed: Vec<_> = texts.iter().map(|(path, source)| (*path, print(source))).collect();
        let kernel = |modules: &[(&str, String)]| {
            compose_modules(path_kernel(&key).0, &key, &constants, modules).unwrap_or_else(|e| panic!("{e}")).wgsl
        };
        assert_eq!(kernel(&texts), kernel(&printed));
    }
}
