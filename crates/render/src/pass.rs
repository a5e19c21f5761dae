//! What the host and the kernel tell each other about a pass.

use bytemuck::{Pod, Zeroable};
use surelight_film::Window;

/// Pixels of a workgroup: 8 × 8.
pub(crate) const GROUP: u32 = 64;

/// Twin of `Pass` in `shaders/kernel/lanes.wesl`.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Pod, Zeroable)]
pub(crate) struct Pass {
    pub(crate) corner: [u32; 2],
    pub(crate) size: [u32; 2],
    pub(crate) first_batch: u32,
    pub(crate) batches: u32,
    pub(crate) samples: u32,
    pub(crate) budget: u32,
    pub(crate) lanes: u32,
    pub(crate) threads: u32,
    pub(crate) restart: u32,
    pub(crate) walks: u32,
}

/// Twin of `Control` in `shaders/kernel/lanes.wesl`.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Pod, Zeroable)]
pub(crate) struct Control {
    pub(crate) workgroups: u32,
    pub(crate) unfinished: u32,
    pub(crate) rays: u32,
    pub(crate) paths: u32,
    pub(crate) dropped: u32,
    pub(crate) truncated: u32,
}

/// Twin of `Feature` in `shaders/kernel/features.wesl`.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, PartialEq, Pod, Zeroable)]
pub(crate) struct FeaturePixel {
    pub(crate) albedo: [f32; 3],
    pub(crate) depth: f32,
    pub(crate) normal: [f32; 3],
    pub(crate) unused: f32,
}

/// A rectangle of pixels that is traced at once.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Tile {
    pub(crate) corner: [u32; 2],
    pub(crate) size: [u32; 2],
}

impl Tile {
    /// Cuts a rectangle into bands, each of at most about `most_lanes` lanes.
    pub(crate) fn bands(corner: [u32; 2], size: [u32; 2], most_lanes: u32) -> Vec<Self> {
        let across = size[0].div_ceil(8);
        let rows_of_blocks = (most_lanes / GROUP / across).max(1);
        let step = 8 * rows_of_blocks;
        (0..size[1])
            .step_by(step as usize)
            .map(|y| Self { corner: [corner[0], corner[1] + y], size: [size[0], step.min(size[1] - y)] })
            .collect()
    }

    /// Lanes, with the workgroups rounded up to a multiple of the driver's threads.
    pub(crate) fn lanes(&self, threads: u32) -> u32 {
        let blocks = self.size[0].div_ceil(8) * self.size[1].div_ceil(8);
        blocks.next_multiple_of(threads) * GROUP
    }

    /// For each lane the pixel it works on, as an index into the film; `u32::MAX` where there is none.
    /// Twin of `lane_of` in `shaders/kernel/lanes.wesl`, whose states are in order of blocks.
    pub(crate) fn pixels(&self, lanes: u32, film: &Window) -> Vec<u32> {
        let across = self.size[0].div_ceil(8);
        let corner = [0, 1].map(|axis| self.corner[axis] - film.corner[axis]);
        (0..lanes)
            .map(|lane| {
                let (block, local) = (lane / GROUP, lane % GROUP);
                let x = (local & 1) | ((local >> 1) & 2) | ((local >> 2) & 4);
                let y = ((local >> 1) & 1) | ((local >> 2) & 2) | ((local >> 3) & 4);
                let at = [(block % across) * 8 + x, (block / across) * 8 + y];
                if at[0] < self.size[0] && at[1] < self.size[1] {
                    (corner[1] + at[1]) * film.size[0] + corner[0] + at[0]
                } else {
                    u32::MAX
                }
            })
            .collect()
    }
}
