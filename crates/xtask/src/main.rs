//! `cargo xtask …`: generates and checks files of the repository.

mod assets;
mod benchmarks;
mod contact_sheet;
mod gallery;
mod gpu;
mod lettering;
mod mutate;
mod pixels;
mod references;
mod sky;
mod words;

use std::path::PathBuf;
use std::process::ExitCode;

use clap::{Parser, Subcommand};

/// Generates, packs and checks the files of the repository beside its code
#[derive(Parser)]
#[command(bin_name = "cargo xtask")]
struct Cli {
    #[command(subcommand)]
    command: Command,
}

#[derive(Subcommand)]
enum Command {
    /// Write the generated scenes, the sky and the table in assets/
    Assets(assets::Arguments),
    /// Make a small picture of every glTF file below a folder, beside the published ones
    ContactSheet(contact_sheet::Arguments),
    /// Race the methods on five scenes, charts to docs/benchmarks: ten quiet minutes
    Benchmarks(benchmarks::Arguments),
    /// Render the four pictures of README.md
    Gallery(gallery::Arguments),
    /// Pack benches, tests and scenes for a machine with a GPU; there: FOLDER/gpu.sh OUT
    Gpu(gpu::Arguments),
    /// Print hashes of the pixels and kernels of all scenes in assets/, to compare before and after
    Pixels(pixels::Arguments),
    /// Render the scenes of a folder and test them against its references
    References(references::Arguments),
    /// Plant mistakes, one after the other, and see whether the torture list catches them
    Mutate(mutate::Arguments),
    /// Report words of no standard meaning, and lines of prose beyond 100 columns
    Words(words::Arguments),
}

fn main() -> ExitCode {
    let result = match Cli::parse().command {
        Command::Assets(arguments) => assets::run(&repository().join("assets"), &arguments),
        Command::ContactSheet(arguments) => contact_sheet::run(&arguments),
        Command::Benchmarks(arguments) => benchmarks::run(&repository(), &arguments),
        Command::Gallery(arguments) => gallery::run(&repository(), &arguments),
        Command::Gpu(arguments) => gpu::run(&repository(), &arguments),
        Command::Pixels(arguments) => pixels::run(&repository(), &arguments),
        Command::References(arguments) => references::run(&arguments),
        Command::Mutate(arguments) => mutate::run(&repository(), &arguments),
        Command::Words(arguments) => words::run(&repository(), &arguments),
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

/// The program beside this tool's own.
fn surelight_beside() -> PathBuf {
    let beside = std::env::current_exe().ok().and_then(|own| Some(own.parent()?.join("surelight")));
    beside.unwrap_or_else(|| PathBuf::from("surelight")).with_extension(std::env::consts::EXE_EXTENSION)
}

#[cfg(test)]
mod tests {
    use clap::CommandFactory;

    use super::*;

    #[test]
    fn arguments_are_consistent() {
        Cli::command().debug_assert();
    }
}
