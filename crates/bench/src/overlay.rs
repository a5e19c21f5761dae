//! Other renderers' points on the same charts: a CSV file, or the JSON of a race between renderers.

use std::path::Path;

use crate::{data::SceneData, error::BenchError};

/// A render by another renderer.
#[derive(Clone, Debug, PartialEq)]
pub struct Peer {
    /// Name of the scene in the report.
    pub scene: String,
    /// Name of the renderer.
    pub renderer: String,
    /// Seconds it took.
    pub seconds: f64,
    /// Its relative mean square error, as defined in the report.
    pub rel_mse: f64,
    /// Samples per pixel, where known.
    pub spp: Option<u32>,
    /// Pixels of its picture, where known: seconds at another size are not comparable.
    pub pixels: Option<u64>,
}

/// Reads points from a CSV file with the columns `scene`, `renderer`, `seconds`, `rel_mse` and,
/// optionally, `spp` and `pixels`, in any order and among others; or from a JSON array of races
/// between renderers, whose objects have `scene`, `renderer`, `spp`, `relmse`, `efficiency` =
/// 1/(relmse · seconds) and `mpaths`, million paths per second.
///
/// # Errors
/// Where the file cannot be read, lacks a column, or has values other than numbers above zero.
pub fn read_overlay(path: &Path) -> Result<Vec<Peer>, BenchError> {
    let text = std::fs::read_to_string(path)
        .map_err(|e| BenchError::file(path, format!("cannot be read: {}", surelight_film::io_cause(&e))))?;
    let points = if text.trim_start().starts_with(['[', '{']) { parse_races(&text) } else { parse(&text) };
    points.map_err(|cause| BenchError::file(path, cause))
}

/// A row of a race between renderers.
#[derive(serde::Deserialize)]
struct Race {
    scene: String,
    renderer: String,
    spp: u32,
    relmse: f64,
    efficiency: f64,
    mpaths: f64,
}

fn parse_races(text: &str) -> Result<Vec<Peer>, String> {
    let races: Vec<Race> =
        serde_json::from_str(text).map_err(|e| format!("is not a JSON array of races between renderers: {e}"))?;
    // The relative mean square error is negative where it is below the reference's noise.
    let known = races.into_iter().filter(|race| race.relmse > 0.0);
    known
        .map(|race| {
            let seconds = 1.0 / (race.relmse * race.efficiency);
            let paths = race.mpaths * 1e6 * seconds;
            if !(seconds > 0.0 && seconds.is_finite() && paths > 0.0 && paths.is_finite() && race.spp > 0) {
                return Err(format!("has no valid time for {} on {}", race.renderer, race.scene));
            }
            Ok(Peer {
                scene: race.scene,
                renderer: race.renderer,
                seconds,
                rel_mse: race.relmse,
                spp: Some(race.spp),
                pixels: Some((paths / f64::from(race.spp)).round() as u64),
            })
        })
        .collect()
}

/// Warnings about the points on the charts of a scene.
pub(crate) fn doubts(peers: &[Peer], scene: &SceneData) -> Vec<String> {
    let mut doubts = Vec::new();
    let pixels = u64::from(scene.width) * u64::from(scene.height);
    if !peers.is_empty() && !peers.iter().any(|p| p.scene == scene.name) {
        let mut names: Vec<&str> = peers.iter().map(|p| p.scene.as_str()).collect();
        names.dedup();
        doubts.push(format!("no point of the overlay is of {}, but of {}", scene.name, names.join(", ")));
    }
    let other = |p: &&Peer| p.scene == scene.name && p.pixels.is_some_and(|n| n.abs_diff(pixels) > pixels / 100);
    if let Some(Peer { pixels: Some(n), .. }) = peers.iter().find(other) {
        doubts.push(format!(
            "other renderers' points are of pictures of {n} pixels, these have {pixels}: their seconds are not comparable (--size sets the size)"
        ));
    }
    doubts
}

fn parse(text: &str) -> Result<Vec<Peer>, String> {
    let mut table = csv::ReaderBuilder::new().trim(csv::Trim::All).flexible(true).from_reader(text.as_bytes());
    let head = table.headers().map_err(|e| e.to_string())?.clone();
    if head.is_empty() {
        return Err("is empty".into());
    }
    let column = |name: &str| head.iter().position(|field| field == name);
    let needed = |name: &str| column(name).ok_or_else(|| format!("has no column \"{name}\""));
    let (scene, renderer) = (needed("scene")?, needed("renderer")?);
    let (seconds, rel_mse) = (needed("seconds")?, needed("rel_mse")?);
    let (spp, pixels) = (column("spp"), column("pixels"));
    let mut peers = Vec::new();
    let mut record = csv::StringRecord::new();
    while table.read_record(&mut record).map_err(|e| e.to_string())? {
        if record.len() == 1 && record[0].is_empty() {
            continue;
        }
        // `record.position()` lies before blank lines and the "\n" of a "\r\n" that precede the
        // record.
        let read = &text.as_bytes()[..table.position().byte() as usize];
        let line = 1 + read.trim_ascii_end().iter().filter(|&&byte| byte == b'\n').count();
        let field = |index: usize| record.get(index).unwrap_or_default();
        let positive = |index: usize, name: &str| match field(index).parse::<f64>() {
            Ok(x) if x > 0.0 && x.is_finite() => Ok(x),
            _ => Err(format!("has \"{}\" for {name} in line {line}; it must be a number above zero", field(index))),
        };
        peers.push(Peer {
            scene: field(scene).to_owned(),
            renderer: field(renderer).to_owned(),
            seconds: positive(seconds, "seconds")?,
            rel_mse: positive(rel_mse, "rel_mse")?,
            spp: whole(spp.map(field), "spp", line)?,
            pixels: whole(pixels.map(field), "pixels", line)?,
        });
    }
    Ok(peers)
}

/// A whole number, if there is one.
fn whole<T: std::str::FromStr>(text: Option<&str>, name: &str, line: usize) -> Result<Option<T>, String> {
    match text {
        None | Some("") => Ok(None),
        Some(text) => text.parse().map(Some).map_err(|_| format!("has \"{text}\" for {name} in line {line}")),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn columns_are_found_by_name() {
        let peers = parse("renderer,notes,seconds,scene,rel_mse\n\"a, \"\"b\"\"\",x,1.5,box,1e-3\n\n").unwrap();
        let expected = Peer {
            scene: "box".into(),
            renderer: "a, \"b\"".into(),
            seconds: 1.5,
            rel_mse: 1e-3,
            spp: None,
            pixels: None,
        };
        assert_eq!(peers, [expected]);
        let with_samples =
            parse("scene,renderer,seconds,rel_mse,spp,pixels\nbox,a,1,0.1,64,100\nbox,a,2,0.05,,\n").unwrap();
        let known: Vec<_> = with_samples.iter().map(|p| (p.spp, p.pixels)).collect();
        assert_eq!(known, [(Some(64), Some(100)), (None, None)]);
    }

    #[test]
    fn races_between_renderers_are_read() {
        // 64 samples of 256×256 pixels at 4 Mpaths/s take 1.048576 s.
        let race = r#"[{"scene": "box", "renderer": "elsewhere", "spp": 64, "mpaths": 4.0, "relmse": 0.005,
            "efficiency": 190.73486328125, "fixed": 0.3, "mean_ratio": 1.0, "of_best_peer": 1.0},
            {"scene": "box", "renderer": "too good", "spp": 64, "mpaths": 4.0, "relmse": -1e-9, "efficiency": -1.0}]"#;
        let peers = parse_races(race).unwrap();
        assert_eq!(peers.len(), 1);
        assert!((peers[0].seconds - 1.048_576).abs() < 1e-9 && peers[0].rel_mse == 0.005);
        assert_eq!((peers[0].spp, peers[0].pixels), (Some(64), Some(65_536)));
        let scene = |name: &str, side| SceneData {
            name: name.into(),
            width: side,
            height: side,
            ..crate::testing::synthetic(1, &[1.0], 0.0, 0.0)
        };
        assert!(doubts(&peers, &scene("box", 256)).is_empty() && doubts(&[], &scene("box", 9)).is_empty());
        assert!(doubts(&peers, &scene("box", 160))[0].contains("65536 pixels, these have 25600"));
        assert!(doubts(&peers, &scene("other", 256))[0].contains("no point of the overlay is of other, but of box"));
        for (text, words) in [
            ("[{\"scene\": 1}]", "is not a JSON array of races"),
            ("{\"scenes\": []}", "is not a JSON array of races"),
            (&race.replace("190.73486328125", "0"), "no valid time for elsewhere on box"),
        ] {
            assert!(parse_races(text).unwrap_err().contains(words), "{text}");
        }
    }

    #[test]
    fn faults_are_reported() {
        for (text, words) in [
            ("", "is empty"),
            ("scene,renderer,seconds\n", "no column \"rel_mse\""),
            ("scene,renderer,seconds,rel_mse\nbox,a,-1,1\n", "\"-1\" for seconds in line 2"),
            ("scene,renderer,seconds,rel_mse\nbox,a,1\n", "\"\" for rel_mse"),
            ("\u{feff} scene,renderer,seconds,rel_mse\r\n\r\nbox,a,1,-\r\n", "\"-\" for rel_mse in line 3"),
            ("\nscene,renderer,seconds,rel_mse\nbox,a,1,1\n  \n\nbox,a,1,x", "\"x\" for rel_mse in line 6"),
            ("scene,renderer,seconds,rel_mse,spp\nbox,a,1,1,x\n", "\"x\" for spp"),
        ] {
            assert!(parse(text).unwrap_err().contains(words), "{text}");
        }
    }
}
