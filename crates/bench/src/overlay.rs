//! Other renderers' points on the same charts.

use std::path::Path;

use crate::error::BenchError;

/// A render by someone else.
#[derive(Clone, Debug, PartialEq)]
pub struct Peer {
    /// Name of the scene, as the report calls it.
    pub scene: String,
    /// Name of the renderer.
    pub renderer: String,
    /// Seconds it took.
    pub seconds: f64,
    /// Its relative mean square error, measured as the report does.
    pub rel_mse: f64,
    /// Samples a pixel, where known.
    pub spp: Option<u32>,
}

/// Reads points from a CSV file with the columns `scene`, `renderer`, `seconds`, `rel_mse` and, if you like, `spp`, in any order and among others.
///
/// # Errors
/// Where the file cannot be read, lacks a column, or holds something else than numbers above zero.
pub fn read_overlay(path: &Path) -> Result<Vec<Peer>, BenchError> {
    let text = std::fs::read_to_string(path).map_err(|e| BenchError::file(path, format!("cannot be read: {e}")))?;
    parse(&text).map_err(|cause| BenchError::file(path, cause))
}

fn parse(text: &str) -> Result<Vec<Peer>, String> {
    let mut lines = text.lines().enumerate().filter(|(_, line)| !line.trim().is_empty());
    let (_, head) = lines.next().ok_or("is empty")?;
    let head = fields(head.trim_start_matches('\u{feff}'));
    let column = |name: &str| head.iter().position(|field| field == name);
    let needed = |name: &str| column(name).ok_or_else(|| format!("has no column \"{name}\""));
    let (scene, renderer) = (needed("scene")?, needed("renderer")?);
    let (seconds, rel_mse, spp) = (needed("seconds")?, needed("rel_mse")?, column("spp"));
    let mut peers = Vec::new();
    for (number, line) in lines {
        let fields = fields(line);
        let field = |index: usize| fields.get(index).map_or("", String::as_str);
        let positive = |index: usize, name: &str| match field(index).parse::<f64>() {
            Ok(x) if x > 0.0 && x.is_finite() => Ok(x),
            _ => Err(format!(
                "has \"{}\" for {name} in line {}; a number above zero is wanted",
                field(index),
                number + 1
            )),
        };
        peers.push(Peer {
            scene: field(scene).to_owned(),
            renderer: field(renderer).to_owned(),
            seconds: positive(seconds, "seconds")?,
            rel_mse: positive(rel_mse, "rel_mse")?,
            spp: match spp.map(&field) {
                None | Some("") => None,
                Some(text) => Some(text.parse().map_err(|_| format!("has \"{text}\" for spp in line {}", number + 1))?),
            },
        });
    }
    Ok(peers)
}

/// Fields of a line; those with commas stand in quotes.
fn fields(line: &str) -> Vec<String> {
    let (mut fields, mut field, mut quoted) = (Vec::new(), String::new(), false);
    let mut letters = line.chars().peekable();
    while let Some(c) = letters.next() {
        match c {
            '"' if quoted && letters.peek() == Some(&'"') => {
                letters.next();
                field.push('"');
            }
            '"' => quoted = !quoted,
            ',' if !quoted => fields.push(std::mem::take(&mut field).trim().to_owned()),
            _ => field.push(c),
        }
    }
    fields.push(field.trim().to_owned());
    fields
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn columns_are_found_by_name() {
        let peers = parse("renderer,notes,seconds,scene,rel_mse\n\"a, \"\"b\"\"\",x,1.5,box,1e-3\n\n").unwrap();
        let expected =
            Peer { scene: "box".into(), renderer: "a, \"b\"".into(), seconds: 1.5, rel_mse: 1e-3, spp: None };
        assert_eq!(peers, [expected]);
        let with_samples = parse("scene,renderer,seconds,rel_mse,spp\nbox,a,1,0.1,64\nbox,a,2,0.05,\n").unwrap();
        assert_eq!(with_samples.iter().map(|p| p.spp).collect::<Vec<_>>(), [Some(64), None]);
    }

    #[test]
    fn what_is_wrong_is_told() {
        for (text, words) in [
            ("", "is empty"),
            ("scene,renderer,seconds\n", "no column \"rel_mse\""),
            ("scene,renderer,seconds,rel_mse\nbox,a,-1,1\n", "\"-1\" for seconds in line 2"),
            ("scene,renderer,seconds,rel_mse\nbox,a,1\n", "\"\" for rel_mse"),
            ("scene,renderer,seconds,rel_mse,spp\nbox,a,1,1,x\n", "\"x\" for spp"),
        ] {
            assert!(parse(text).unwrap_err().contains(words), "{text}");
        }
    }
}
