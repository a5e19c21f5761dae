//! A partition of the sphere whose cells follow a density: for χ² tests of direction samplers.
//!
//! Cells are rectangles in (φ, v), where v is sqrt(1 − cosθ) above the horizon and 2 − sqrt(1 +
//! cosθ) below: next to both poles and to the horizon, f32 directions keep their precision in it. A
//! cell splits in four until it holds little of the mass and its integral has settled, so a lobe a
//! thousandth of a radian wide gets as many cells as a broad one.

use std::f64::consts::{PI, TAU};

/// Most of the mass that a leaf may hold.
const LARGEST_MASS: f64 = 1.0 / 256.0;
/// By how much a cell's integral may change when it is split, before it has to be.
const TOLERANCE: f64 = 5e-7;
/// Halvings of either side at most: 2⁻²² is about the spacing of f32 directions.
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
    v: [f64; 2],
    mass: f64,
    depth: u32,
    /// First of four children, or 0 for a leaf.
    children: usize,
}

/// The partition and the mass of each of its cells.
pub struct SphereCells {
    cells: Vec<Cell>,
    roots: usize,
}

impl Cell {
    fn quarters(&self) -> [Cell; 4] {
        let middle = |r: [f64; 2]| (r[0] + r[1]) / 2.0;
        let (p, c) = (middle(self.phi), middle(self.v));
        let of = |phi, v| Cell { phi, v, mass: 0.0, depth: self.depth + 1, children: 0 };
        let (low, high) = ([self.v[0], c], [c, self.v[1]]);
        let (left, right) = ([self.phi[0], p], [p, self.phi[1]]);
        [of(left, low), of(right, low), of(left, high), of(right, high)]
    }

    fn points(&self) -> impl Iterator<Item = [f32; 3]> + use<> {
        let Cell { phi, v, .. } = *self;
        let at = |r: [f64; 2], t: f64| r[0] + (r[1] - r[0]) * t;
        NODES.iter().flat_map(move |i| NODES.iter().map(move |j| from_coordinates([at(phi, i.0), at(v, j.0)])))
    }

    fn integral(&self, densities: &[f64]) -> f64 {
        // dω = 2·min(v, 2 − v) dφ dv
        let solid_angle =
            |t: f64| 2.0 * (self.v[0] + (self.v[1] - self.v[0]) * t).min(2.0 - self.v[0] - (self.v[1] - self.v[0]) * t);
        let weights = NODES.iter().flat_map(|i| NODES.iter().map(move |j| i.1 * j.1 * solid_angle(j.0)));
        let mean: f64 = weights.zip(densities).map(|(w, d)| w * d).sum();
        mean * (self.phi[1] - self.phi[0]) * (self.v[1] - self.v[0])
    }

    fn holds(&self, p: [f64; 2]) -> bool {
        (self.phi[0]..=self.phi[1]).contains(&p[0]) && (self.v[0]..=self.v[1]).contains(&p[1])
    }
}

/// v at a cosine.
fn latitude(z: f64) -> f64 {
    if z >= 0.0 { (1.0 - z).sqrt() } else { 2.0 - (1.0 + z).sqrt() }
}

fn coordinates(w: [f32; 3]) -> [f64; 2] {
    let [x, y, z] = w.map(f64::from);
    // 1 − |z|, without its cancellation.
    let w = ((x * x + y * y) / (1.0 + z.abs())).sqrt().min(1.0);
    [y.atan2(x).rem_euclid(TAU), if z >= 0.0 { w } else { 2.0 - w }]
}

fn from_coordinates([phi, v]: [f64; 2]) -> [f32; 3] {
    let w = v.min(2.0 - v);
    let s = w * (2.0 - w * w).sqrt();
    let z = (1.0 - w * w).copysign(1.0 - v);
    [(s * phi.cos()) as f32, (s * phi.sin()) as f32, z as f32]
}

impl SphereCells {
    /// Integrates a density over solid angle, given for many directions at a time.
    ///
    /// Cells around `peaks` are split until their sides are below `width` (radians), so that no
    /// narrow lobe there is missed; no cell straddles the plane z = `edge` or the horizon, where
    /// the density may jump.
    pub fn new(peaks: &[[f32; 3]], width: f64, edge: f64, mut density: impl FnMut(&[[f32; 3]]) -> Vec<f64>) -> Self {
        let peaks: Vec<_> = peaks.iter().map(|&p| coordinates(p)).collect();
        let mut bounds = [0.0, 1.0, latitude(edge), 2.0];
        bounds.sort_by(f64::total_cmp);
        let mut cells: Vec<Cell> = bounds
            .windows(2)
            .filter(|v| v[0] < v[1])
            .flat_map(|v| {
                (0..4).map(|i| {
                    let phi = [f64::from(i) * PI / 2.0, f64::from(i + 1) * PI / 2.0];
                    Cell { phi, v: [v[0], v[1]], mass: 0.0, depth: 0, children: 0 }
                })
            })
            .collect();
        let roots = cells.len();
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
                let side = (cell.phi[1] - cell.phi[0]).max(cell.v[1] - cell.v[0]);
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
        Self { cells, roots }
    }

    fn leaves(&self) -> impl Iterator<Item = (usize, &Cell)> {
        self.cells.iter().enumerate().filter(|(_, c)| c.children == 0)
    }

    /// Integral of the density.
    pub fn mass(&self) -> f64 {
        self.leaves().map(|(_, c)| c.mass).sum()
    }

    /// Observed and expected counts, one cell each, of `samples` draws of which `directions` gave
    /// directions; the last cell holds the draws that did not.
    pub fn counts(&self, directions: impl Iterator<Item = [f32; 3]>, samples: usize) -> (Vec<u64>, Vec<f64>) {
        let mut observed = vec![0_u64; self.cells.len()];
        let mut inside = 0;
        for w in directions {
            let p = coordinates(w);
            let mut i = self.cells[..self.roots].iter().position(|c| c.holds(p)).expect("the roots cover the sphere");
            while self.cells[i].children != 0 {
                let c = &self.cells[i];
                let right = usize::from(p[0] > (c.phi[0] + c.phi[1]) / 2.0);
                let high = usize::from(p[1] > (c.v[0] + c.v[1]) / 2.0);
                i = c.children + right + 2 * high;
            }
            observed[i] += 1;
            inside += 1;
        }
        let n = samples as f64;
        let mut counts: Vec<u64> = self.leaves().map(|(i, _)| observed[i]).collect();
        // No cell is certainly empty: quadrature may have missed a corner of it. Samples there are
        // added to the pool of small cells.
        let mut expected: Vec<f64> = self.leaves().map(|(_, c)| n * c.mass.max(1e-12)).collect();
        counts.push(samples as u64 - inside);
        expected.push(n * (1.0 - self.mass()).max(1e-12));
        (counts, expected)
    }
}
