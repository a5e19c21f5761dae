//! `cargo xtask …`: what keeps the repository's generated files true.

mod assets;
mod benchmarks;
mod contact_sheet;
mod gpu;
mod mutate;
mod pixels;
mod references;
mod sky;

use std::path::PathBuf;
use std::process::ExitCode;

const USAGE: &str = "\
Usage: cargo xtask <COMMAND>

Commands:
  assets          write the generated scenes, the sky and the table in assets/
  assets --check  fail when a file in assets/ differs from what the code makes
  contact-sheet DIR -o FOLDER
                  a small picture of every glTF file below a folder, beside the published ones
  benchmarks [--surelight BINARY] [--time TIME]
                  race the methods on five scenes, charts to docs/benchmarks: ten quiet minutes
  gpu -o FOLDER [SCENE]...
                  pack benches, tests and scenes for a machine with a GPU; there: FOLDER/gpu.sh OUT
  pixels BINARY   hashes of the pixels and kernels of all scenes in assets/, to compare before and after
  references DIR --surelight BINARY
                  render the scenes of a folder and test them against its references
  mutate [CASE]...
                  plant mistakes, one after the other, and see whether the torture list catches them
  mutate --list   print the table of mistakes
";

fn main() -> ExitCode {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let words: Vec<&str> = arguments.iter().map(String::as_str).collect();
    let result = match words[..] {
        ["assets"] => assets::write(&repository().join("assets")),
        ["assets", "--check"] => assets::check(&repository().join("assets")),
        ["contact-sheet", ref rest @ ..] => contact_sheet::run(rest),
        ["benchmarks", ref rest @ ..] => benchmarks::run(&repository(), rest),
        ["gpu", ref rest @ ..] => gpu::run(&repository(), rest),
        ["pixels", ref rest @ ..] => pixels::run(&repository(), rest),
        ["references", ref rest @ ..] => references::run(rest),
        ["mutate", ref rest @ ..] => mutate::run(&repository(), rest),
        ["help" | "--help" | "-h"] => {
            print!("{USAGE}");
            Ok(())
        }
        _ => {
            eprint!("{USAGE}");
            return ExitCode::from(2);
        }
    };
    match result {
        Ok(()) => ExitCode::SUCCESS,
        Err(message) => {
            eprintln!("error: {message}");
            ExitCode::FAILURE
        }
    }
}

/// The root of the checkout that this binary was built from.
fn repository() -> PathBuf {
    PathBuf::from(concat!(env!("CARGO_MANIFEST_DIR"), "/../.."))
}
