//! `mis` = `area` (= `hemisphere`) on real files: one for each kernel that the corpus needs.

use std::collections::HashSet;

use surelight_prepare::{Prepared, Settings};
use surelight_scene::{LoadOptions, load};
use surelight_tests::differential::{Tally, compare_estimators};
use surelight_tests::scenes::map;

use crate::{corpus, files_below};

/// Files of more triangles are left out: their trees take longer than everything else.
const MAX_TRIANGLES: usize = 200_000;

/// Comparisons at most, for Šidák's level.
const MAX_COMPARISONS: usize = 300;

#[test]
fn estimators_agree_on_real_files() {
    let Some(corpus) = corpus() else { return };
    let mut kernels = HashSet::new();
    let mut tally = Tally::default();
    for folder in ["geometry", "materials", "scenes", "textures"] {
        for path in files_below(&corpus.join(folder)) {
            let Ok(mut scene) = load(&path, &LoadOptions::default()) else { continue };
            if scene.triangle_count() > MAX_TRIANGLES {
                continue;
            }
            // A sky with a bright patch, which light sampling and directions find.
            scene.environment = Some(map(16, 8, |x, y| if x < 4 && y < 3 { [4.0, 3.5, 3.0] } else { [0.3, 0.4, 0.5] }));
            let camera = scene.cameras.first().cloned().unwrap_or_else(|| scene.frame_camera(1.0));
            let Ok(prepared) = Prepared::new(&scene, &camera, &Settings::new(16, 16)) else { continue };
            if kernels.insert(prepared.key()) {
                let name = path.strip_prefix(&corpus).unwrap_or(&path).display().to_string();
                compare_estimators(&name, &scene, 16, 16, MAX_COMPARISONS, &mut tally);
            }
        }
    }
    let Tally { reported, open, failures } = &tally;
    println!("{} files: {reported} comparisons agree, {open} cannot tell", kernels.len());
    assert!(kernels.len() > 20 && reported + open <= MAX_COMPARISONS, "{} kernels", kernels.len());
    assert!(failures.is_empty(), "{failures:#?}");
}
