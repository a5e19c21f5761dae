//! docs/kernels.md is the table of `surelight_prepare::TABLE`: `SURELIGHT_UPDATE_DOCS=1 cargo test
//! --test kernel_docs` writes it.

use std::fmt::Write;
use std::path::Path;

use surelight_prepare::{Origin, Part, Row, TABLE};

fn names(parts: &[Part]) -> String {
    parts.iter().map(|&part| format!("`{}`", TABLE[part as usize].name)).collect::<Vec<_>>().join(", ")
}

fn line(row: &Row) -> String {
    let origin = match row.origin {
        Origin::Scene(_) => "a named thing in the scene",
        Origin::Derived => "the scene as a whole",
        Origin::Settings => "settings",
        Origin::Device => "device",
    };
    let one_of = match row.needs_one_of {
        [] => String::new(),
        [.., last] if row.needs_one_of.len() > 4 => {
            format!("one of {}, …, {}", names(&row.needs_one_of[..1]), names(&[*last]))
        }
        parts => format!("one of {}", names(parts)),
    };
    let needs: Vec<_> = [names(row.needs), one_of].into_iter().filter(|text| !text.is_empty()).collect();
    let excludes: Vec<_> =
        row.excludes.iter().map(|(part, why)| format!("`{}` ({why})", TABLE[*part as usize].name)).collect();
    format!("| `{}` | {} | {origin} | {} | {} |", row.name, row.meaning, needs.join("; "), excludes.join("; "))
}

fn page() -> String {
    let mut page = String::from(
        "# Parts of a kernel\n\n\
         A kernel contains the parts that its scene, its settings and its device need, and nothing else.\n\
         After this page you know all of them: the condition that shader modules test with `@if(…)`, the\n\
         reason for which a kernel has a part, its needs and its exclusions. `surelight info SCENE` shows\n\
         the parts of one kernel.\n\n\
         This page is made from the table in\n\
         [`crates/prepare/src/kernel_key/table.rs`](../crates/prepare/src/kernel_key/table.rs), which the\n\
         composer and the tests use as well; a test keeps it true.\n\n\
         | part | meaning | origin | needs | excludes |\n|---|---|---|---|---|\n",
    );
    TABLE.iter().for_each(|row| writeln!(page, "{}", line(row)).expect("a string grows"));
    page
}

#[test]
fn the_page_is_the_table() {
    let path = Path::new(concat!(env!("CARGO_MANIFEST_DIR"), "/../docs/kernels.md"));
    if std::env::var_os("SURELIGHT_UPDATE_DOCS").is_some() {
        std::fs::write(path, page()).expect("docs/ can be written");
    }
    let found = std::fs::read_to_string(path).unwrap_or_default();
    assert!(found == page(), "docs/kernels.md is out of date: SURELIGHT_UPDATE_DOCS=1 writes it");
}
