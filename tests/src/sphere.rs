//! A partition of the sphere whose cells follow a density: for χ² tests of direction samplers.
//!
//! Cells are rectangles in (φ, cosθ), where solid angle is area. A cell splits in four until it holds little of the mass and its
//! integral has settled, so a lobe a thousandth of a radian wide gets as many cells as a broad one.

use std::f64::consts::{PI, TAU};

use crate::bsdf::direction;

/// Most of the mass that a leaf may hold.
const LARGEST_MASS: f64 = 1.0 / 256.0;
/// By how much a cell's integral may change when it is split, before it has to be.
const TOLERANCE: f64 = 5e-7;
/// Halvings of either side at most: 2⁻²² · π is about the spacing of f32 directions.
const DEEPEST: u32 = 22;
/// Nodes and weights of Gauss–Legendre quadrature with four points on [0, 1].
const NODES: [(f64, f64); 4] = [
    (0.069_431_844_202_973_71, 0.173_927_422_568_726_93),
    (0.330_009_478_207_571_87, 0.326_072_577_431_273_07),
    (0.669_990_521_792_428_1, 0.326_072_577_431_273_07),
    (0.930_568_155_797_026_3, 0.173_927_422_568_726_93),
];

#[derive(Clone, Copy)]
struct Cell {
    phi: [f64; 2],
    cosine: [f64; 2],
    mass: f64,
    depth: u32,
    /// First of four children, or 0 for a leaf.
    children: usize,
}

/// The partition and the mass of each of its cells.
pub struct SphereCells {
    cells: Vec<Cell>,
}

impl Cell {
    fn quarters(&self) -> [Cell; 4] {
        let middle = |r: [f64; 2]| (r[0] + r[1]) / 2.0;
        let (p, c) = (middle(self.phi), middle(self.cosine));
        let of = |phi, cosine| Cell { phi, cosine, mass: 0.0, depth: self.depth + 1, children: 0 };
        let (low, high) = ([self.cosine[0], c], [c, self.cosine[1]]);
        let (left, right) = ([self.phi[0], p], [p, self.phi[1]]);
        [of(left, low), of(right, low), of(left, high), of(right, high)]
    }

    fn points(&self) -> impl Iterator<Item = [f32; 3]> + use<> {
        let Cell { phi, cosine, .. } = *self;
        let at = |r: [f64; 2], t: f64| r[0] + (r[1] - r[0]) * t;
        NODES.iter().flat_map(move |i| NODES.iter().map(move |j| direction(at(phi, i.0), at(cosine, j.0))))
    }

    fn integral(&self, densities: &[f64]) -> f64 {
        let weights = NODES.iter().flat_map(|i| NODES.iter().map(move |j| i.1 * j.1));
        let mean: f64 = weights.zip(densities).map(|(w, d)| w * d).sum();
        mean * (self.phi[1] - self.phi[0]) * (self.cosine[1] - self.cosine[0])
    }

    fn holds(&self, p: [f64; 2]) -> bool {
        (self.phi[0]..=self.phi[1]).contains(&p[0]) && (self.cosine[0]..=self.cosine[1]).contains(&p[1])
    }
}

fn coordinates(w: [f32; 3]) -> [f64; 2] {
    [f64::from(w[1]).atan2(f64::from(w[0])).rem_euclid(TAU), f64::from(w[2]).clamp(-1.0, 1.0)]
}

impl SphereCells {
    /// Integrates a density over solid angle, given for many directions at a time.
    ///
    /// Cells around `peaks` are split until their diagonal is below `width` (radians), so that no narrow lobe there is missed.
    pub fn new(peaks: &[[f32; 3]], width: f64, mut density: impl FnMut(&[[f32; 3]]) -> Vec<f64>) -> Self {
        let peaks: Vec<_> = peaks.iter().map(|&p| coordinates(p)).collect();
        let mut cells: Vec<Cell> = [[-1.0, 0.0], [0.0, 1.0]]
            .into_iter()
            .flat_map(|cosine| {
                (0..4).map(move |i| {
                    let phi = [f64::from(i) * PI / 2.0, f64::from(i + 1) * PI / 2.0];
                    Cell { phi, cosine, mass: 0.0, depth: 0, children: 0 }
                })
            })
            .collect();
        let mut integrate = |cells: &mut [Cell]| {
            let points: Vec<_> = cells.iter().flat_map(Cell::points).collect();
            let densities = density(&points);
            for (cell, d) in cells.iter_mut().zip(densities.chunks(16)) {
                cell.mass = cell.integral(d);
            }
        };
        integrate(&mut cells);
        let mut frontier: Vec<usize> = (0..cells.len()).collect();
        while !frontier.is_empty() {
            let mut quarters: Vec<Cell> = frontier.iter().flat_map(|&i| cells[i].quarters()).collect();
            integrate(&mut quarters);
            let mut next = Vec::new();
            for (&i, four) in frontier.iter().zip(quarters.chunks(4)) {
                let mass: f64 = four.iter().map(|c| c.mass).sum();
                let cell = cells[i];
                let side = (cell.phi[1] - cell.phi[0]).max((cell.cosine[1] - cell.cosine[0]).sqrt());
                let narrow = side > width && peaks.iter().any(|&p| cell.holds(p));
                let settled = (mass - cell.mass).abs() < TOLERANCE && mass < LARGEST_MASS && !narrow;
                if settled || cell.depth == DEEPEST {
                    // The finer of the two estimates.
                    cells[i].mass = mass;
                } else {
                    cells[i].children = cells.len();
                    next.extend(cells.len()..cells.len() + 4);
                    cells.extend_from_slice(four);
                }
            }
            frontier = next;
        }
        Self { cells }
    }

    fn leaves(&self) -> impl Iterator<Item = (usize, &Cell)> {
        self.cells.iter().enumerate().filter(|(_, c)| c.children == 0)
    }

    /// Integral of the density.
    pub fn mass(&self) -> f64 {
        self.leaves().map(|(_, c)| c.mass).sum()
    }

    /// Observed and expected counts, a cell each, of `samples` draws of which `directions` came out as directions; the last cell
    /// holds the draws that did not.
    pub fn counts(&self, directions: impl Iterator<Item = [f32; 3]>, samples: usize) -> (Vec<u64>, Vec<f64>) {
        let mut observed = vec![0_u64; self.cells.len()];
        let mut inside = 0;
        for w in directions {
            let p = coordinates(w);
            let mut i = self.cells[..8].iter().position(|c| c.holds(p)).expect("the roots cover the sphere");
            while self.cells[i].children != 0 {
                let c = &self.cells[i];
                let right = usize::from(p[0] > (c.phi[0] + c.phi[1]) / 2.0);
                let high = usize::from(p[1] > (c.cosine[0] + c.cosine[1]) / 2.0);
                i = c.children + right + 2 * high;
            }
            observed[i] += 1;
            inside += 1;
        }
        let n = samples as f64;
        let mut counts: Vec<u64> = self.leaves().map(|(i, _)| observed[i]).collect();
        let mut expected: Vec<f64> = self.leaves().map(|(_, c)| n * c.mass).collect();
        counts.push(samples as u64 - inside);
        expected.push(n * (1.0 - self.mass()).max(0.0));
        (counts, expected)
    }
}
