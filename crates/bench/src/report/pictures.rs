//! Pictures and error maps, in the page itself.

use std::path::Path;

use base64::{Engine, engine::general_purpose::STANDARD};
use maud::{Markup, html};

use crate::data::{MethodData, Row, SceneData, slug};

use super::text::{percent, seconds};

/// The reference, then each method's picture beside its error map. Missing pictures, of methods
/// that were not reached, are omitted.
pub(super) fn pictures(folder: &Path, scene: &SceneData) -> Markup {
    let folder = folder.join(&scene.name);
    html! {
        div.pictures {
            @if let Some(image) = image(&folder.join("reference.png"), "The reference") {
                figure { (image) figcaption { "The reference by " (scene.reference.source) } }
            }
            @for (index, method) in scene.methods.iter().enumerate() {
                @if let Some(row) = scene.rows_of(index).filter(|r| r.repeat == 0).last() {
                    (pair(&folder, scene, method, row))
                }
            }
        }
    }
}

/// A method's picture and its error map after `row`, if both exist.
fn pair(folder: &Path, scene: &SceneData, method: &MethodData, row: &Row) -> Markup {
    let file = slug(&method.name);
    let shown = image(&folder.join(format!("{file}.png")), &format!("Picture by {}", method.name));
    let map = image(&folder.join(format!("{file}-error.png")), &format!("Errors of {}", method.name));
    // No line break between numbers and their units.
    let joined = |text: String| text.replace(' ', "\u{a0}");
    let error = match row.rel_rmse() {
        Some(error) => format!("error {}", joined(percent(error))),
        None => "an error below the reference's".into(),
    };
    html! {
        @if let (Some(shown), Some(map)) = (shown, map) {
            figure {
                div.pair { (shown) (map) }
                figcaption {
                    (method.name) @if method.biased.is_some() { " (biased)" } ": " (row.spp)
                    " samples per pixel, " (joined(seconds(row.seconds(scene.clock)))) ", " (error)
                }
            }
        }
    }
}

fn image(path: &Path, what: &str) -> Option<Markup> {
    let bytes = std::fs::read(path).ok()?;
    Some(html! { img alt=(what) src={ "data:image/png;base64," (STANDARD.encode(bytes)) }; })
}
