//! Layouts of the records that host code declares, for comparison with those of composed shaders.

use surelight_film::BatchSum;
use surelight_prepare::{RecordLayout, host_layout};

use crate::pass::{Control, EmissionPass, FeaturePixel, Pass};

/// Each record of fixed layout that the host shares with shaders, by its name in WGSL: those of
/// passes, and those of the scene ([`surelight_prepare::host_layouts`]).
///
/// Fields called `pad…` are what WGSL inserts by itself.
pub fn host_layouts() -> Vec<(&'static str, RecordLayout)> {
    let mut all = surelight_prepare::host_layouts();
    all.extend([
        (
            "Pass",
            host_layout!(Pass { corner, size, first_batch, batches, samples, budget, lanes, threads, restart, walks }),
        ),
        (
            "EmissionPass",
            host_layout!(EmissionPass {
                corner,
                size,
                replicate,
                sequence,
                first,
                count,
                length,
                budget,
                lanes,
                restart,
                worth,
                quantum,
                square_quantum,
                unused
            }),
        ),
        ("Control", host_layout!(Control { workgroups, unfinished, rays, paths, dropped, truncated })),
        ("BatchSum", host_layout!(BatchSum { sum, tail })),
        ("Feature", host_layout!(FeaturePixel { albedo, depth, normal, unused })),
    ]);
    all
}
