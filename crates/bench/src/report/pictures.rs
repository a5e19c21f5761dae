//! Pictures and error maps, in the page itself.

use std::fmt::Write as _;
use std::path::Path;

use base64::{Engine, engine::general_purpose::STANDARD};

use crate::{
    chart::escape,
    data::{SceneData, slug},
};

use super::text::{percent, seconds};

/// The reference, then each method's picture beside its map. Pictures that are not there, of methods that were not reached, are left out.
pub(super) fn pictures(html: &mut String, folder: &Path, scene: &SceneData) {
    let folder = folder.join(&scene.name);
    *html += "<div class=\"pictures\">\n";
    if let Some(image) = image(&folder.join("reference.png"), "The reference") {
        let _ = writeln!(
            html,
            "<figure>{image}<figcaption>The reference by {}</figcaption></figure>",
            escape(&scene.reference.source)
        );
    }
    for (index, method) in scene.methods.iter().enumerate() {
        let file = slug(&method.name);
        let shown = image(&folder.join(format!("{file}.png")), &format!("Picture by {}", method.name));
        let map = image(&folder.join(format!("{file}-error.png")), &format!("Errors of {}", method.name));
        let last = scene.rows_of(index).filter(|r| r.repeat == 0).last();
        let (Some(shown), Some(map), Some(row)) = (shown, map, last) else { continue };
        let error = row.rel_rmse().map_or("an error below the reference's".into(), |e| {
            // Numbers stay with their units.
            format!("error {}", percent(e).replace(' ', "\u{a0}"))
        });
        let _ = writeln!(
            html,
            "<figure><div class=\"pair\">{shown}{map}</div><figcaption>{}{}: {} samples a pixel, {}, {error}</figcaption></figure>",
            escape(&method.name),
            if method.biased.is_some() { " (biased)" } else { "" },
            row.spp,
            seconds(row.seconds(scene.clock)).replace(' ', "\u{a0}")
        );
    }
    *html += "</div>\n";
}

fn image(path: &Path, what: &str) -> Option<String> {
    let bytes = std::fs::read(path).ok()?;
    Some(format!("<img alt=\"{}\" src=\"data:image/png;base64,{}\"/>", escape(what), STANDARD.encode(bytes)))
}
