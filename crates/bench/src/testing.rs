//! Random numbers and a synthetic race for tests.

/// Standard normal numbers from a seed (SplitMix64 and Box & Muller).
pub(crate) fn normals(seed: u64) -> impl FnMut() -> f64 {
    let mix = |state: u64| {
        let z = (state ^ (state >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        let z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        z ^ (z >> 31)
    };
    let mut state = mix(seed + 1);
    let mut uniform = move || {
        state = state.wrapping_add(0x9e37_79b9_7f4a_7c15);
        ((mix(state) >> 12) as f64 + 0.5) / (1u64 << 52) as f64
    };
    move || (-2.0 * uniform().ln()).sqrt() * (std::f64::consts::TAU * uniform()).cos()
}

use crate::data::{MethodData, Row, SceneData};
use crate::method::MethodWords;

/// A synthetic race: a method for each factor on the seconds of a sample, four repeats, errors that
/// fall as N^−½. `noise` is the relative deviation of times and errors, `bias` the relative error
/// of all means.
pub(crate) fn synthetic(seed: u64, slowness: &[f64], noise: f64, bias: f64) -> SceneData {
    let mut normal = normals(seed);
    let checkpoints: Vec<u32> = (0..9).map(|k| 1 << k).collect();
    let (mut methods, mut rows) = (Vec::new(), Vec::new());
    for (index, &slow) in slowness.iter().enumerate() {
        methods.push(MethodData {
            name: format!("method{index}/sobol"),
            words: MethodWords {
                integrator: format!("method{index}"),
                directions: None,
                sampler: "sobol".into(),
                max_bounces: "unlimited".into(),
                max_radiance: "none".into(),
                scrambles: "many".into(),
                shared_paths: "off".into(),
            },
            biased: None,
            checkpoints: checkpoints.clone(),
            prepare_seconds: 0.1,
            compile_seconds: 0.2,
            device_bytes: 1 << 20,
        });
        for repeat in 0..4 {
            let speed = 1.0 + noise * normal();
            for &spp in &checkpoints {
                let n = f64::from(spp);
                let mean_se = 2e-3 / n.sqrt();
                let seconds = 0.01 * slow * n * speed;
                rows.push(Row {
                    method: index,
                    repeat,
                    spp,
                    batches: spp.min(16),
                    paths: 4096 * u64::from(spp),
                    rays: 16_384 * u64::from(spp),
                    device_seconds: 0.9 * seconds,
                    dispatch_seconds: Some(0.95 * seconds),
                    read_seconds: Some(0.02 * seconds),
                    film_seconds: Some(0.03 * seconds),
                    wall_seconds: seconds,
                    mean: 1.0 + bias + mean_se * normal(),
                    mean_se: Some(mean_se),
                    mean_error: bias + mean_se * normal(),
                    mse: 0.25 / n,
                    rel_mse: 0.25 / n * (1.0 + noise * normal()),
                    predicted_rel_mse: (spp > 1).then_some(0.25 / n),
                    coverage: (spp > 1).then_some(0.95),
                    flip: (repeat == 0).then(|| 0.5 / n.sqrt()),
                    ..Row::default()
                });
            }
        }
    }
    SceneData {
        name: "synthetic".into(),
        file: "synthetic.glb".into(),
        hash: "0".into(),
        width: 64,
        height: 64,
        triangles: 12,
        repeats: 4,
        seconds_a_method: Some(4.0),
        clock: crate::data::Clock::Wall,
        load_seconds: 0.1,
        reference: crate::data::ReferenceData {
            source: "mis/sobol".into(),
            reason: String::new(),
            spp: 4096,
            seconds: 9.0,
            mean: 1.0,
            mean_se: Some(1e-4),
            rel_mse: Some(1e-5),
            uncertified: None,
        },
        methods,
        walk: None,
        rows,
        warnings: Vec::new(),
    }
}
