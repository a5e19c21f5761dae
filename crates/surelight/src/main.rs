//! The command line of Surelight: arguments, progress, messages, exit codes.
//!
//! All rendering is in the libraries; this crate reads the command line, and reports results.

// They panic when a pipe is closed; see `console`.
#![warn(clippy::print_stdout, clippy::print_stderr)]

mod args;
mod bench;
mod camera;
mod compare;
mod console;
mod devices;
mod error;
mod exposure;
mod fingerprint;
mod headless;
mod info;
mod input;
mod integrate;
mod interrupt;
mod light;
mod measure;
mod merge;
mod method;
mod options;
mod output;
mod parse;
mod parts;
mod progress;
#[cfg(test)]
mod reference;
mod render;
mod saved;
mod stopping;
mod summary;

use std::panic;
use std::process::ExitCode;

use crate::args::Command;
use crate::error::{Error, sentence};

/// Bad input, a device or a disk that fails.
const ERROR: u8 = 1;
/// The time was up or Ctrl-C came before the target was reached; the image is written.
const STOPPED_EARLY: u8 = 3;
/// `compare` found a difference, or `bench --compare` a loss.
const DIFFER: u8 = 4;
/// `compare --strict` cannot tell whether the images differ.
const CANNOT_TELL: u8 = 5;

fn main() -> ExitCode {
    // Help and wrong usage end here, with the exit codes 0 and 2.
    let command = args::parse(std::env::args_os()).unwrap_or_else(|error| error.exit());
    headless::silence_layers();
    interrupt::survive_file_size_limit();
    panic::set_hook(Box::new(|info| {
        let (cause, saved) = (sentence(&info.to_string()), saved::clause());
        console::note(&format!("error: Surelight has a defect, please report it: {cause}{saved}"));
    }));
    let done = panic::catch_unwind(|| match command {
        Command::Render(args) => render(&args),
        Command::Info(args) => info::run(&args).map(|()| ExitCode::SUCCESS),
        Command::Measure(args) => measure::run(&args).map(target_exit_code),
        Command::Integrate(args) => integrate::run(&args).map(|()| ExitCode::SUCCESS),
        Command::Compare(args) => compare::run(&args).map(|finding| match finding {
            compare::CompareResult::Same => ExitCode::SUCCESS,
            compare::CompareResult::Differ => ExitCode::from(DIFFER),
            compare::CompareResult::CannotTell => ExitCode::from(CANNOT_TELL),
        }),
        Command::Bench(args) => bench::run(&args),
        Command::Merge(args) => merge::run(&args).map(target_exit_code),
        Command::Devices(args) => devices::run(&args).map(|()| ExitCode::SUCCESS),
    });
    match done {
        Ok(Ok(code)) => code,
        Ok(Err(error)) => {
            console::note(&format!("error: {}", sentence(&error.to_string())));
            ExitCode::from(ERROR)
        }
        Err(_) => ExitCode::from(ERROR), // reported by the hook
    }
}

/// The exit code of a command with a target.
fn target_exit_code(target: bool) -> ExitCode {
    if target { ExitCode::SUCCESS } else { ExitCode::from(STOPPED_EARLY) }
}

fn render(args: &options::RenderArgs) -> Result<ExitCode, Error> {
    let summary = render::run(args)?;
    let text = if args.json {
        summary.json().map_err(|e| Error::Print(e.into()))?
    } else if args.quiet {
        summary.short()
    } else {
        summary.to_string()
    };
    // Where an image goes to standard output, nothing else may.
    if args.writes_to_stdout() {
        console::note(text.trim_end())
    } else {
        console::result(&text)?
    }
    Ok(match summary.stopped {
        summary::Stop::Done => ExitCode::SUCCESS,
        summary::Stop::Time | summary::Stop::Samples | summary::Stop::Interrupt => ExitCode::from(STOPPED_EARLY),
    })
}
