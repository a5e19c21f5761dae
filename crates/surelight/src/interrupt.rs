//! Ctrl-C (and a polite kill): the first asks the render to finish and write, the second ends the program at once.

use std::sync::atomic::{AtomicBool, Ordering};

use crate::console;

static STOP: AtomicBool = AtomicBool::new(false);

/// What shells report for a program ended by Ctrl-C.
const KILLED_BY_INTERRUPT: i32 = 130;

/// Begins to listen. Where the system refuses, Ctrl-C ends the program as usual.
pub(crate) fn listen() {
    listen_and_keep("the image so far");
}

/// Likewise, where what is written in the end is something else.
pub(crate) fn listen_and_keep(what: &'static str) {
    let heard = ctrlc::set_handler(move || {
        if STOP.swap(true, Ordering::SeqCst) {
            // Without running what is registered for the end: drivers take their memory down there while their threads still work.
            signal_hook::low_level::exit(KILLED_BY_INTERRUPT);
        }
        let bar = if console::watched() { "\n" } else { "" }; // one may stand on this line
        console::note(&format!("{bar}stopping: {what} will be written; once more ends at once"));
    });
    if let Err(error) = heard {
        console::note(&format!("warning: Ctrl-C will not save {what}: {error}"));
    }
}

/// Whether Ctrl-C was pressed.
pub(crate) fn requested() -> bool {
    STOP.load(Ordering::SeqCst)
}
