//! `cargo xtask words`: the vocabulary of the sources, help texts and documents.
//!
//! A table names the words of no standard meaning and what to write instead. Lines of prose keep
//! to 100 columns.

use std::fs;
use std::path::{Path, PathBuf};
use std::process::Command;

use clap::Args;
use regex::{Regex, RegexBuilder};

/// The most columns that a line of prose may have.
const MAX_COLUMNS: usize = 100;

/// Files that are generated, record history or hold the table below.
const EXEMPT: &[&str] = &[
    "CHANGELOG.md",
    "crates/xtask/src/words.rs",
    "docs/benchmarks/README.md",
    // Generated, with the notes that are bytes of the scenes' files.
    "assets/README.md",
    "assets/gltf/README.md",
    "assets/torture/README.md",
];

/// Names of files and formats that rules leave alone, and a quotation.
const NAMES: &[&str] = &[
    "coplanar-twins",
    "coplanar_twins",
    "asked_samples",
    "seconds_a_method",
    "probe_light_met",
    "variance: what is it?",
];

/// Crates whose strings become files that do not change.
const FROZEN_STRINGS: &str = "crates/scenes/src/";

/// A pattern, and what to write instead. Letters match either case. In patterns, `<` and `>` are
/// the ends of a word, also of one within an identifier.
const RULES: &[(&str, &str)] = &[
    ("<told>", "reported, stated, passed"),
    ("<tells>", "states, reports, shows"),
    ("<stands?>", "is, applies, remains, lies"),
    ("<stood>", "was, applied, lay"),
    ("<asked>", "requested, queried, given"),
    ("<asks>", "requests, queries"),
    (r"\bwhat (is|it|was|they|a|the)\b", "a noun"),
    (r"\b(most|least)_[a-z_]+\b|(?-i:_(MOST|LEAST)\b)", "max_, min_"),
    ("<(brings|brought)>", "contributes, transforms, contribution"),
    ("<twins?>", "counterpart, copy"),
    ("<squeeze[sd]?>", "Jacobian"),
    ("<fibrous>", "sheen"),
    ("<sends_through>", "has_diffuse_transmission"),
    ("<goes on>|<went on>|<gone on>", "continues"),
    ("<(comes|came) to (a|an|the|one|no|some|about|[0-9]+)>", "amounts to, converges to, reaches"),
    ("<(met|meets)>|<meet (a|an|any|each|it|no|the|them)>", "hits, intersects, reaches"),
    ("<save for>", "except"),
    ("<likewise>", "in the same way, also"),
    ("<shares? out>|<shared out>", "distributes"),
    ("<for ever>", "always, without end"),
    (r"\blooks (along|at|down|like|straight)\b|\b(all|each|first) looks?\b", "primary rays, faces, interim tests"),
    ("<pixels apart>", "without path reuse"),
    ("(bytes|lanes|rays|samples|seconds|texels|units|elements)_a_[a-z]+>", "_per_"),
    (r"\b(arrive|depart)\(", "shade_emission, sample_continuation"),
];

/// Checks the words of sources, help texts and documents
#[derive(Args)]
pub(crate) struct Arguments {
    /// Files and folders to check; without any, all tracked ones
    paths: Vec<PathBuf>,
}

/// Prints the findings, and fails where there are any.
pub(crate) fn run(repository: &Path, arguments: &Arguments) -> Result<(), String> {
    let rules = rules();
    let mut findings = 0_usize;
    for name in tracked(repository, &arguments.paths)? {
        let text = fs::read_to_string(repository.join(&name)).map_err(|e| format!("{name}: {e}"))?;
        for (line, finding) in check(&name, &text, &rules) {
            println!("{name}:{line}: {finding}");
            findings += 1;
        }
    }
    if findings == 0 { Ok(()) } else { Err(format!("{findings} words or lines to change")) }
}

/// The tracked files that have prose, below `paths`.
fn tracked(repository: &Path, paths: &[PathBuf]) -> Result<Vec<String>, String> {
    let mut git = Command::new("git");
    git.current_dir(repository).args(["ls-files", "-z", "--error-unmatch", "--"]);
    if paths.is_empty() {
        git.arg(".");
    }
    let output = git.args(paths).output().map_err(|e| format!("git: {e}"))?;
    if !output.status.success() {
        return Err(String::from_utf8_lossy(&output.stderr).trim().to_owned());
    }
    let names = String::from_utf8(output.stdout).map_err(|e| format!("git: {e}"))?;
    let has_prose = |name: &&str| {
        let extension = Path::new(name).extension().and_then(|e| e.to_str());
        matches!(extension, Some("rs" | "wesl" | "wgsl" | "md")) && !EXEMPT.contains(name)
    };
    Ok(names.split_terminator('\0').filter(has_prose).map(str::to_owned).collect())
}

/// The table, compiled.
fn rules() -> Vec<(Regex, &'static str)> {
    let compile = |&(pattern, instead): &(&str, &'static str)| {
        let pattern = pattern.replace(['<', '>'], r"(?:\b|_)");
        let regex = RegexBuilder::new(&pattern).case_insensitive(true).build();
        (regex.expect("the table has valid patterns"), instead)
    };
    RULES.iter().map(compile).collect()
}

/// The findings in one file, with their lines.
fn check(name: &str, text: &str, rules: &[(Regex, &str)]) -> Vec<(usize, String)> {
    let is_document = name.ends_with(".md");
    let mut is_code = false;
    let mut findings = Vec::new();
    for (line, number) in text.lines().zip(1..) {
        let prose = if is_document { Some(line) } else { comment(line) };
        if prose.is_some_and(|p| p.trim_start().starts_with("```")) {
            is_code = !is_code;
            continue;
        }
        if is_document && is_code {
            continue;
        }
        let mut words = match prose {
            Some(prose) if is_document => without_code(prose),
            prose if name.starts_with(FROZEN_STRINGS) => prose.unwrap_or_default().to_owned(),
            _ => line.to_owned(),
        };
        for name in NAMES {
            words = words.replace(name, "");
        }
        for (rule, instead) in rules {
            if let Some(found) = rule.find(&words) {
                findings.push((number, format!("{} -> {instead}", found.as_str().trim_matches('_'))));
            }
        }
        let columns = line.chars().count();
        let may_be_long = |p: &str| p.trim_start().starts_with(['|', '<']) || p.contains("](") || p.contains("://");
        if columns > MAX_COLUMNS && !is_code && prose.is_some_and(|p| !may_be_long(p)) {
            findings.push((number, format!("{columns} columns -> at most {MAX_COLUMNS}")));
        }
    }
    findings
}

/// The text of a line that is a comment and nothing else.
fn comment(line: &str) -> Option<&str> {
    let text = line.trim_start().strip_prefix("//")?;
    Some(text.trim_start_matches(['/', '!']))
}

/// A line of Markdown without its code spans and the targets of its links.
fn without_code(line: &str) -> String {
    let outside = line.split('`').step_by(2).collect::<Vec<_>>().join("`");
    let mut parts = outside.split("](");
    let mut text = parts.next().unwrap_or_default().to_owned();
    for part in parts {
        text += "]";
        text += part.split_once(')').map_or("", |(_, rest)| rest);
    }
    text
}

#[cfg(test)]
mod tests {
    use super::*;

    fn findings(name: &str, text: &str) -> Vec<(usize, String)> {
        check(name, text, &rules())
    }

    #[test]
    fn words_are_found_in_prose_identifiers_and_messages() {
        let text = "/// What is left.\nconst LEAST_SHARE: f32 = 0.1;\nfn a_full_disk_is_told() {}\n\"asked for\"\n";
        let lines: Vec<_> = findings("a.rs", text).into_iter().map(|(line, _)| line).collect();
        assert_eq!(lines, [1, 2, 3, 4]);
        let [(1, finding)] = &findings("a.rs", "// He is told so.")[..] else { panic!("one finding") };
        assert!(finding.starts_with("told -> reported"), "{finding}");
    }

    #[test]
    fn standard_words_pass() {
        assert_eq!(findings("a.rs", "// At least one standard method, almost_all, masked, metal.\n"), []);
        assert_eq!(findings("a.rs", "let at_least_one = a_pixel.metric;\n"), []);
    }

    #[test]
    fn code_tables_and_links_of_documents_are_left_alone() {
        let long = "x".repeat(120);
        assert_eq!(findings("a.md", &format!("```\ntold {long}\n```\n| {long} |\n[page]({long})\n`--told` it\n")), []);
        assert_eq!(findings("a.md", &format!("{long}\n")).len(), 1);
        assert_eq!(findings("a.rs", &format!("// {long}\nlet x = \"{long}\";\n")).len(), 1);
    }
}
