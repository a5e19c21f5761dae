//! χ² of the BSDF's samples against the pdf that it claims, integrated over the sphere.

use glam::Vec3;
use surelight_estimate::chi_squared_test;

use crate::bsdf::{BsdfProbe, Material, uniforms};
use crate::sphere::SphereCells;

/// The smallest α of any lobe.
fn narrowest(m: &Material) -> f32 {
    if m.coat > 0.0 { m.alpha.min(m.coat_alpha) } else { m.alpha }
}

/// Where narrow lobes point: mirrored, straight through, refracted.
fn peaks(m: &Material) -> Vec<[f32; 3]> {
    let [x, y, z] = m.wo;
    let s = (x * x + y * y) / (m.eta * m.eta);
    let mut peaks = vec![[-x, -y, z], [-x, -y, -z]];
    if s < 1.0 {
        peaks.push([-x / m.eta, -y / m.eta, -(1.0 - s).sqrt()]);
    }
    if m.coat > 0.0 {
        let (wo, n) = (Vec3::from(m.wo), Vec3::from(m.coat_normal));
        peaks.push((2.0 * wo.dot(n) * n - wo).into());
    }
    peaks
}

fn cells(probe: &BsdfProbe, m: &Material) -> SphereCells {
    // Below the horizon, facets that refract exist on one side of the plane in which their normal
    // would be horizontal.
    let edge = f64::from(-m.wo[2] / m.eta).max(-1.0);
    SphereCells::new(&peaks(m), f64::from(narrowest(m).max(1e-3)), edge, |directions| {
        probe.eval(m, directions).iter().map(|e| f64::from(e.pdf)).collect()
    })
}

/// The result of [`outcome`].
pub struct Outcome {
    /// p-value.
    pub p: f64,
    /// Integral of the pdf.
    pub mass: f64,
    /// Cells compared, less one.
    pub dof: f64,
    /// Cells compared.
    pub cells: usize,
}

/// χ² of samples of `drawn` in cells that hold the pdf of `claimed`. Invalid and delta samples
/// share one more cell.
pub fn outcome(probe: &BsdfProbe, drawn: &Material, claimed: &Material, samples: usize, seed: u64) -> Outcome {
    let cells = cells(probe, claimed);
    let drawn = probe.sample(drawn, &uniforms(samples, seed));
    let counted = drawn.iter().filter(|s| s.is_valid() && !s.is_delta()).map(|s| s.wi);
    let (observed, expected) = cells.counts(counted, samples);
    let test = chi_squared_test(&observed, &expected, 5.0).unwrap_or_else(|e| panic!("{claimed:?}: {e}"));
    if test.p < 1e-4 {
        let mut worst: Vec<_> =
            observed.iter().zip(&expected).map(|(&o, &e)| ((o as f64 - e) / e.max(1.0).sqrt(), o, e)).collect();
        worst.sort_by(|a, b| b.0.abs().total_cmp(&a.0.abs()));
        println!("{claimed:?}\nworst cells (deviation, observed, expected): {:?}", &worst[..5.min(worst.len())]);
    }
    Outcome { p: test.p, mass: cells.mass(), dof: test.dof, cells: observed.len() }
}
