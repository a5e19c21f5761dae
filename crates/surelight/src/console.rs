//! Printing that survives a closed pipe: `println!` would panic in `surelight info scene.glb | head
//! -1`.

use std::borrow::Cow;
use std::io::{self, ErrorKind, IsTerminal, Write};

use crate::error::Error;

/// Writes a result to standard output. A closed pipe is no error.
pub(crate) fn result(text: &str) -> Result<(), Error> {
    let mut out = io::stdout().lock();
    match out.write_all(printable(text).as_bytes()).and_then(|()| out.flush()) {
        Err(error) if error.kind() != ErrorKind::BrokenPipe => Err(Error::Print(error)),
        _ => Ok(()),
    }
}

/// Writes a line to standard error; a closed stream is no error.
pub(crate) fn note(line: &str) {
    let _ = writeln!(io::stderr().lock(), "{}", printable(line));
}

/// A text without control characters but ends of lines: names in files and of files may hold escape
/// sequences, which a terminal would obey.
pub(crate) fn printable(text: &str) -> Cow<'_, str> {
    let harmful = |c: char| c.is_control() && c != '\n';
    if !text.contains(harmful) {
        return text.into();
    }
    let shown = |c: char| if harmful(c) { c.escape_default().to_string() } else { c.to_string() };
    text.chars().map(shown).collect()
}

/// Whether a person watches standard error.
pub(crate) fn watched() -> bool {
    io::stderr().is_terminal()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn terminals_get_no_control_characters() {
        assert_eq!(printable("a\u{1b}[31mb\r\u{9b}"), "a\\u{1b}[31mb\\r\\u{9b}");
        assert_eq!(printable("ümläut 日本\nnext"), "ümläut 日本\nnext");
    }
}
