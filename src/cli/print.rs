//! What goes to standard output and standard error.

use std::fmt::Display;
use std::io::{self, ErrorKind, Write};
use std::path::Path;

use ontile::{Error, Result};
use serde::Serialize;

/// Prints a value for people, or as JSON for programs.
///
/// A reader that went away early (`ontile ... | head -1`) has what it wanted: that is no error.
pub fn value<T: Display + Serialize>(value: &T, json: bool) -> Result<()> {
    let text = if json {
        serde_json::to_string_pretty(value)
            .map_err(|e| Error::io(Path::new("standard output"), "write", e.into()))?
    } else {
        value.to_string()
    };
    self::text(&text)
}

/// Prints a text for people.
///
/// A reader that went away early has what it wanted: that is no error.
pub fn text(text: &dyn Display) -> Result<()> {
    let mut out = io::stdout().lock();
    match writeln!(out, "{text}").and_then(|()| out.flush()) {
        Err(e) if e.kind() != ErrorKind::BrokenPipe => {
            Err(Error::io(Path::new("standard output"), "write", e))
        }
        _ => Ok(()),
    }
}

/// The one message of a run that failed.
pub fn error(error: &Error) {
    // Nobody is left to tell if standard error is closed.
    let _ = writeln!(io::stderr(), "ontile: {}", printable(&error.to_string()));
}

/// Something that the user should know, though the run goes on.
pub fn warning(text: &str) {
    // Nobody is left to tell if standard error is closed.
    let _ = writeln!(io::stderr(), "ontile: warning: {}", printable(text));
}

/// What the user is told while a window is open, as many lines as it has.
#[cfg(feature = "view")]
pub fn note(text: &str) {
    for line in text.lines() {
        // Nobody is left to tell if standard error is closed.
        let _ = writeln!(io::stderr(), "ontile: {}", printable(line));
    }
}

/// One line of bounded length that cannot command the terminal, whatever names a file has in it.
fn printable(text: &str) -> String {
    const MAX_CHARS: usize = 1000;
    let shown = text.chars().take(MAX_CHARS);
    let mut out = String::new();
    for c in shown {
        if c.is_control() { out.extend(c.escape_default()) } else { out.push(c) }
    }
    if text.chars().nth(MAX_CHARS).is_some() {
        out.push_str("...");
    }
    out
}

#[cfg(test)]
mod tests {
    use super::printable;

    #[test]
    fn messages_are_one_short_line_without_commands_to_the_terminal() {
        assert_eq!(printable("grün\n\u{1b}[31m"), "grün\\n\\u{1b}[31m");
        assert_eq!(printable(&"a".repeat(5000)).len(), 1003);
    }
}
