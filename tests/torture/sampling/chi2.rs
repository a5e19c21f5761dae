//! Samples of the BSDF follow the pdf that it claims: χ² on the device's own pdf, integrated over
//! the sphere.

use std::sync::LazyLock;

use surelight_estimate::sidak_level;
use surelight_tests::bsdf::{BsdfProbe, Material};
use surelight_tests::chi2::{self, Outcome};

const SAMPLES: usize = 1_000_000;
const ALPHA: f64 = 0.01;
/// Angles of wo from the normal.
const ANGLES: [f64; 4] = [0.0, 30.0, 75.0, 89.9];

static PROBE: LazyLock<BsdfProbe> = LazyLock::new(BsdfProbe::full);

fn outcome(drawn: &Material, claimed: &Material, seed: u64) -> Outcome {
    chi2::outcome(&PROBE, drawn, claimed, SAMPLES, seed)
}

/// Every kind of material that a base may be, with its roughnesses.
fn kinds() -> Vec<(&'static str, Vec<Material>)> {
    type Kind = fn(f32, f64) -> Material;
    let over = |kind: Kind, alphas: &[f32]| {
        alphas.iter().flat_map(|&alpha| ANGLES.map(|degrees| kind(alpha, degrees))).collect::<Vec<_>>()
    };
    vec![
        ("Lambert", vec![Material::lambert(60.0)]),
        ("metal", over(Material::metal, &[0.001, 0.1, 1.0])),
        // α = 0: the base beside a delta.
        ("dielectric", over(Material::dielectric, &[0.0, 0.05, 0.5])),
        ("glass", over(Material::glass, &[0.01, 0.2, 1.0])),
        ("glass from within", over(Material::glass_within, &[0.2, 1.0])),
        ("thin wall", over(Material::thin, &[0.1, 0.6])),
        ("medley", over(Material::medley, &[0.05, 0.4])),
    ]
}

/// Over kinds, roughness and angle, each at the level that makes a false alarm rare over all of
/// them.
#[test]
fn chi2_all() {
    let kinds = kinds();
    let level = sidak_level(ALPHA, kinds.iter().map(|(_, materials)| materials.len()).sum());
    let mut failures = Vec::new();
    let all = kinds.iter().flat_map(|(name, materials)| materials.iter().map(move |m| (name, m)));
    for ((name, m), seed) in all.zip(100..) {
        let Outcome { p, mass, dof, cells } = outcome(m, m, seed);
        println!(
            "{name} α {} z {:.4}: p {p:.4}, mass {mass:.6}, {dof} degrees of freedom, {cells} cells",
            m.alpha, m.wo[2]
        );
        assert!(mass < 1.0 + 2e-4, "{m:?}: the pdf integrates to {mass}");
        if p < level {
            failures.push(format!("{m:?}: p = {p:.1e}"));
        }
    }
    assert!(failures.is_empty(), "at level {level:.1e}:\n{}", failures.join("\n"));
}

/// The power of the test: a roughness or an index that is 1 % off.
#[test]
fn small_errors_are_found() {
    for degrees in [30.0, 75.0] {
        let (metal, glass) = (Material::metal(0.3, degrees), Material::glass(0.3, degrees));
        let wrong_metal = Material { alpha: metal.alpha * 1.01, ..metal };
        let wrong_glass = Material { eta: glass.eta * 1.01, ..glass };
        let level = sidak_level(ALPHA, 12);
        for (right, wrong) in [(metal, wrong_metal), (glass, wrong_glass)] {
            let p = outcome(&right, &wrong, 700).p;
            assert!(p < level, "1 % passes unseen at {degrees}°: p = {p}");
        }
    }
}
