//! Printing that survives a closed pipe: `println!` would panic in `surelight info scene.glb | head -1`.

use std::io::{self, ErrorKind, IsTerminal, Write};

use crate::error::Error;

/// Writes a result to standard output. A reader that has seen enough is no error.
pub(crate) fn result(text: &str) -> Result<(), Error> {
    let mut out = io::stdout().lock();
    match out.write_all(text.as_bytes()).and_then(|()| out.flush()) {
        Err(error) if error.kind() != ErrorKind::BrokenPipe => Err(Error::Print(error)),
        _ => Ok(()),
    }
}

/// Writes a line to standard error; where nobody listens, nothing is lost.
pub(crate) fn note(line: &str) {
    let _ = writeln!(io::stderr().lock(), "{line}");
}

/// Whether a person watches standard error.
pub(crate) fn watched() -> bool {
    io::stderr().is_terminal()
}
