//! The reference in docs/cli.md is made from the definition of the command line:
//! `SURELIGHT_UPDATE_DOCS=1 cargo test --release --bin surelight reference` writes it.

use std::fmt::Write;
use std::path::Path;

use clap::{Arg, Command};

use crate::args::definition;

/// What follows this line in docs/cli.md is made here.
const MARK: &str = "<!-- Made from the definition of the command line; a test keeps it true. -->\n";
/// Columns of a line of prose.
const MAX_COLUMNS: usize = 100;

/// A list item, or a paragraph of one, wrapped.
fn wrapped(first: &str, rest: &str, text: &str) -> String {
    let mut lines = vec![first.to_owned()];
    for word in text.split_whitespace() {
        let line = lines.last_mut().expect("there is a line");
        if line.chars().count() + word.chars().count() < MAX_COLUMNS {
            if !line.ends_with(' ') && !line.is_empty() {
                line.push(' ');
            }
            *line += word;
        } else {
            lines.push(format!("{rest}{word}"));
        }
    }
    lines.join("\n") + "\n"
}

/// Placeholders in angle brackets would be taken for HTML.
fn escaped(text: &str) -> String {
    text.replace('<', "\\<")
}

fn synopsis(arg: &Arg) -> String {
    let names = arg.get_value_names().unwrap_or_default();
    let values: String = if arg.get_num_args().is_some_and(|n| n.takes_values()) {
        names.iter().map(|name| format!(" <{name}>")).collect()
    } else {
        String::new()
    };
    match (arg.get_short(), arg.get_long()) {
        (Some(short), Some(long)) => format!("`-{short}`, `--{long}{values}`"),
        (None, Some(long)) => format!("`--{long}{values}`"),
        (Some(short), None) => format!("`-{short}{values}`"),
        (None, None) => format!("`{}`", values.trim_start()),
    }
}

fn entry(page: &mut String, arg: &Arg) {
    let help = arg.get_long_help().or(arg.get_help()).map(ToString::to_string).unwrap_or_default();
    let mut paragraphs = help.split("\n\n");
    let mut head = format!("{}: {}", synopsis(arg), escaped(paragraphs.next().unwrap_or_default()));
    let defaults = arg.get_default_values();
    if !defaults.is_empty() && arg.get_action().takes_values() && !arg.is_hide_default_value_set() {
        let defaults: Vec<_> = defaults.iter().map(|value| value.to_string_lossy()).collect();
        write!(head, " [default: {}]", defaults.join(", ")).expect("a string grows");
    }
    *page += &wrapped("- ", "  ", &head);
    for paragraph in paragraphs {
        *page += "\n";
        *page += &wrapped("  ", "  ", &escaped(paragraph));
    }
    if arg.is_hide_possible_values_set() || !arg.get_action().takes_values() {
        return;
    }
    for value in arg.get_possible_values() {
        let help = value.get_help().map(|help| format!(": {help}")).unwrap_or_default();
        *page += &wrapped("  - ", "    ", &format!("`{}`{}", value.get_name(), escaped(&help)));
    }
}

fn section(page: &mut String, command: &mut Command) {
    let name = match command.get_name() {
        "surelight" => "surelight".to_owned(),
        name => format!("surelight {name}"),
    };
    let usage = command.render_usage().to_string();
    let usage = usage.trim_start_matches("Usage:").lines().map(str::trim).collect::<Vec<_>>().join("\n");
    let about = command.get_long_about().or(command.get_about()).map(ToString::to_string).unwrap_or_default();
    write!(page, "\n### {name}\n\n").expect("a string grows");
    for paragraph in about.split("\n\n") {
        *page += &wrapped("", "", &format!("{}.", paragraph.trim_end_matches('.')));
        *page += "\n";
    }
    write!(page, "```text\n{usage}\n```\n").expect("a string grows");
    let mut headings: Vec<Option<&str>> = Vec::new();
    let shown: Vec<&Arg> = command.get_arguments().filter(|arg| !arg.is_hide_set() && arg.get_id() != "help").collect();
    for arg in &shown {
        if !headings.contains(&arg.get_help_heading()) {
            headings.push(arg.get_help_heading());
        }
    }
    for heading in headings {
        write!(page, "\n{}", heading.map(|h| format!("**{h}**\n\n")).unwrap_or_default()).expect("a string grows");
        shown.iter().filter(|arg| arg.get_help_heading() == heading).for_each(|arg| entry(page, arg));
    }
}

fn reference() -> String {
    let mut cli = definition();
    cli.build();
    let mut page = String::from(MARK);
    for command in cli.get_subcommands_mut().filter(|command| command.get_name() != "help") {
        section(&mut page, command);
    }
    page
}

#[test]
fn the_reference_is_the_definition() {
    let path = Path::new(concat!(env!("CARGO_MANIFEST_DIR"), "/../../docs/cli.md"));
    let found = std::fs::read_to_string(path).unwrap_or_default();
    let tasks = found.find(MARK).map_or(found.as_str(), |at| &found[..at]);
    let page = format!("{tasks}{}", reference());
    if std::env::var_os("SURELIGHT_UPDATE_DOCS").is_some() {
        return std::fs::write(path, page).expect("docs/ can be written");
    }
    assert!(found == page, "docs/cli.md is out of date: SURELIGHT_UPDATE_DOCS=1 writes it");
}
