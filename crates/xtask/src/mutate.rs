//! `cargo xtask mutate`: proof that the torture list can fail.
//!
//! Each row of the table plants one mistake in a copy of the tree, runs the one case that must see it, and tells whether it did.
//! The copy lies in `target/mutate`. All mutations share its build folder, so that only what a mistake touches is built again; the
//! checkout's own cannot be shared, since cargo would take crates of the copy for those of the checkout. A
//! mistake is a substitution of text that must apply exactly once: where the code has changed under it, that is an error, and a
//! unit test says so long before anybody runs the mutations.

mod accumulation;
mod bsdf;
mod geometry;
mod light;
mod numeric;
mod sampling;

use std::fs;
use std::path::{Path, PathBuf};
use std::process::Command;
use std::time::{Duration, Instant};

/// A mistake, and the test that must notice it.
pub(crate) struct Mutation {
    /// Number of the case in the torture list.
    case: u32,
    /// The mistake, in a few words.
    mistake: &'static str,
    /// The file that it is made in.
    file: &'static str,
    /// What stands there, exactly once.
    from: &'static str,
    /// What it becomes.
    to: &'static str,
    /// The test's binary, such as `torture_numeric`.
    binary: &'static str,
    /// The test's name within it, modules included.
    test: &'static str,
}

/// What became of a mutation.
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
        let found = text.matches(self.from).count();
        if found != 1 {
            return Err(format!(
                "case {}, {}: {} has its text {found} times, not once",
                self.case, self.mistake, self.file
            ));
        }
        if self.from == self.to {
            return Err(format!("case {}, {}: it changes nothing", self.case, self.mistake));
        }
        Ok(text.replacen(self.from, self.to, 1))
    }

    /// Plants the mistake in the copy, runs the test, and takes it out again.
    fn run(&self, root: &Path, copy: &Path) -> Result<Verdict, String> {
        let mutated = self.apply(&read(&root.join(self.file))?)?;
        let path = copy.join(self.file);
        write(&path, mutated.as_bytes())?;
        let verdict = self.test(copy);
        write(&path, read(&root.join(self.file))?.as_bytes())?;
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
        Ok(if run.status.success() { Verdict::Missed } else { Verdict::Caught })
    }
}

/// Makes the copy hold what the checkout holds: files that git tracks or would, and no others. Files that are alike are left alone, so that
/// they are not built again.
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

/// Removes what is no longer in the checkout.
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

/// Writes a file with a time that no earlier build can have seen: cargo goes by times, and coarse ones would hide a change.
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
    let mut text = String::from("| case | mistake | in | seen by |\n|---:|---|---|---|\n");
    for Mutation { case, mistake, file, binary, test, .. } in table() {
        text.push_str(&format!("| {case} | {mistake} | `{file}` | `{binary}`, `{test}` |\n"));
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
        for mutation in table() {
            let text = read(&repository().join(mutation.file)).expect("the file is there");
            mutation.apply(&text).unwrap_or_else(|e| panic!("{e}"));
            assert!((1..=44).contains(&mutation.case) && mutation.case >= number, "the table is not in order");
            number = mutation.case;
        }
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
        let mutation = Mutation { case: 1, mistake: "", file: "f", from: "a", to: "b", binary: "", test: "" };
        assert_eq!(mutation.apply("cat").as_deref(), Ok("cbt"));
        assert!(mutation.apply("dog").is_err() && mutation.apply("banana").is_err());
    }
}
