//! Samples of the BSDF follow the pdf that it claims: χ² on the device's own pdf, integrated over the sphere.

use std::sync::LazyLock;

use surelight_estimate::{chi_squared_test, sidak_level};
use surelight_tests::bsdf::{BsdfProbe, Material, uniforms};
use surelight_tests::sphere::SphereCells;

const SAMPLES: usize = 1_000_000;
const ALPHA: f64 = 0.01;
/// Angles of wo from the normal.
const ANGLES: [f64; 4] = [0.0, 30.0, 75.0, 89.9];

static PROBE: LazyLock<BsdfProbe> = LazyLock::new(BsdfProbe::full);

/// Where narrow lobes point: mirrored, straight through, refracted.
fn peaks(m: &Material) -> Vec<[f32; 3]> {
    let [x, y, z] = m.wo;
    let s = (x * x + y * y) / (m.eta * m.eta);
    let mut peaks = vec![[-x, -y, z], [-x, -y, -z]];
    if s < 1.0 {
        peaks.push([-x / m.eta, -y / m.eta, -(1.0 - s).sqrt()]);
    }
    peaks
}

fn cells(m: &Material) -> SphereCells {
    // Below the horizon, facets that refract exist on one side of the plane in which their normal would be horizontal.
    let edge = f64::from(-m.wo[2] / m.eta).max(-1.0);
    SphereCells::new(&peaks(m), f64::from(m.alpha.max(1e-3)), edge, |directions| {
        PROBE.eval(m, directions).iter().map(|e| f64::from(e.pdf)).collect()
    })
}

struct Outcome {
    p: f64,
    /// Integral of the pdf.
    mass: f64,
    /// Cells compared, less one.
    dof: f64,
    cells: usize,
}

/// χ² of samples of `drawn` in cells that hold the pdf of `claimed`. Invalid and delta samples share one more cell.
fn outcome(drawn: &Material, claimed: &Material, seed: u64) -> Outcome {
    let cells = cells(claimed);
    let samples = PROBE.sample(drawn, &uniforms(SAMPLES, seed));
    let counted = samples.iter().filter(|s| s.is_valid() && !s.is_delta()).map(|s| s.wi);
    let (observed, expected) = cells.counts(counted, SAMPLES);
    let test = chi_squared_test(&observed, &expected, 5.0).unwrap_or_else(|e| panic!("{claimed:?}: {e}"));
    if test.p < 1e-4 {
        let mut worst: Vec<_> =
            observed.iter().zip(&expected).map(|(&o, &e)| ((o as f64 - e) / e.max(1.0).sqrt(), o, e)).collect();
        worst.sort_by(|a, b| b.0.abs().total_cmp(&a.0.abs()));
        println!("{claimed:?}\nworst cells (deviation, observed, expected): {:?}", &worst[..5.min(worst.len())]);
    }
    Outcome { p: test.p, mass: cells.mass(), dof: test.dof, cells: observed.len() }
}

/// Tests a kind of material over roughness and angle, each at the level that makes false alarms rare over all of them.
fn check(name: &str, materials: impl Iterator<Item = Material>, seed: u64) {
    let materials: Vec<_> = materials.collect();
    let level = sidak_level(ALPHA, materials.len());
    let mut failures = Vec::new();
    for (m, i) in materials.iter().zip(0..) {
        let Outcome { p, mass, dof, cells } = outcome(m, m, seed + i);
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

fn over(kind: fn(f32, f64) -> Material, alphas: &[f32]) -> impl Iterator<Item = Material> {
    alphas.iter().flat_map(move |&alpha| ANGLES.map(|degrees| kind(alpha, degrees)))
}

#[test]
fn lambert() {
    check("Lambert", std::iter::once(Material::lambert(60.0)), 10);
}

#[test]
fn metal() {
    check("metal", over(Material::metal, &[0.001, 0.1, 1.0]), 100);
}

#[test]
fn dielectric() {
    // α = 0: the base beside a delta.
    check("dielectric", over(Material::dielectric, &[0.0, 0.05, 0.5]), 200);
}

#[test]
fn glass() {
    check("glass", over(Material::glass, &[0.01, 0.2, 1.0]), 300);
}

#[test]
fn glass_within() {
    check("glass from within", over(Material::glass_within, &[0.2, 1.0]), 400);
}

#[test]
fn thin_wall() {
    check("thin wall", over(Material::thin, &[0.1, 0.6]), 500);
}

#[test]
fn medley() {
    check("medley", over(Material::medley, &[0.05, 0.4]), 600);
}

/// What the tests above can see: a roughness or an index that is 1 % off.
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
