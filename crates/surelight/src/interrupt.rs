//! Ctrl-C (and a polite kill): the first makes the render finish and write, the second ends the
//! program at once.

#[cfg(unix)]
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};

use crate::console;
use crate::error::Error;

static STOP: AtomicBool = AtomicBool::new(false);

/// Whether there is anything to finish and write.
static BEGUN: AtomicBool = AtomicBool::new(false);

/// Exit code where there is nothing to write yet.
const FAILED: i32 = crate::ERROR as i32;

/// The exit code that shells report for a program ended by Ctrl-C.
const KILLED_BY_INTERRUPT: i32 = 130;

/// Begins to listen; until [`begin`], Ctrl-C ends the program at once. Where the system refuses,
/// Ctrl-C ends it as usual.
pub(crate) fn listen() {
    listen_for("the image so far");
}

/// There is something to write from now on.
pub(crate) fn begin() {
    BEGUN.store(true, Ordering::SeqCst);
}

/// Begins to listen where there is something else to write from the beginning.
pub(crate) fn listen_and_keep(what: &'static str) {
    begin();
    listen_for(what);
}

fn listen_for(what: &'static str) {
    let heard = ctrlc::set_handler(move || {
        if STOP.swap(true, Ordering::SeqCst) {
            // Without running exit handlers: drivers free their memory there while their threads
            // still work.
            signal_hook::low_level::exit(KILLED_BY_INTERRUPT);
        }
        let bar = if console::watched() { "\n" } else { "" }; // one may be on this line
        if !BEGUN.load(Ordering::SeqCst) {
            // Reading may wait without end, as for the writer of a pipe.
            console::note(&format!("{bar}error: {}", Error::Interrupted));
            signal_hook::low_level::exit(FAILED);
        }
        console::note(&format!("{bar}stopping: {what} will be written; once more ends at once"));
    });
    if let Err(error) = heard {
        console::note(&format!("warning: Ctrl-C will not save {what}: {error}"));
    }
}

/// Lets a write beyond the limit on file sizes (`ulimit -f`) fail, so that it can be reported; by
/// default it kills the program, with half a file written.
pub(crate) fn survive_file_size_limit() {
    #[cfg(unix)]
    {
        // A failure to install it is no worse than the default.
        let _ = signal_hook::flag::register(signal_hook::consts::SIGXFSZ, Arc::default());
    }
}

/// Whether Ctrl-C was pressed.
pub(crate) fn requested() -> bool {
    STOP.load(Ordering::SeqCst)
}
