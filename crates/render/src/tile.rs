//! Rectangles of pixels that are traced at once, and the order of lanes in them.

use surelight_film::Window;

use crate::pass::GROUP;

/// Maximum number of lanes in a row: their states must fit a binding.
const MAX_LANES_PER_ROW: u32 = 1 << 16;

/// A rectangle of pixels that is traced at once.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Tile {
    pub(crate) corner: [u32; 2],
    pub(crate) size: [u32; 2],
    /// Pixels along a side of the square that a lane works on: 1 or 2.
    pub(crate) side: u32,
}

impl Tile {
    /// Cuts a rectangle into bands of at most about `max_lanes` lanes each, but at least a row of
    /// blocks, unless that is more than [`MAX_LANES_PER_ROW`]. Squares lie on a grid from the
    /// image's corner.
    pub(crate) fn bands(corner: [u32; 2], size: [u32; 2], max_lanes: u32, side: u32) -> Vec<Self> {
        let end = [0, 1].map(|axis| corner[axis] + size[axis]);
        let corner = corner.map(|c| c / side * side);
        let group = 8 * side;
        let width = group * (end[0] - corner[0]).div_ceil(group).min(MAX_LANES_PER_ROW / GROUP);
        let height = group * (max_lanes / GROUP / (width / group)).max(1);
        let steps = |axis: usize, step: u32| (corner[axis]..end[axis]).step_by(step as usize);
        steps(1, height)
            .flat_map(|y| steps(0, width).map(move |x| [x, y]))
            .map(|at| Self { corner: at, size: [width.min(end[0] - at[0]), height.min(end[1] - at[1])], side })
            .collect()
    }

    /// Lanes, with the workgroups rounded up to a multiple of the driver's threads.
    pub(crate) fn lanes(&self, threads: u32) -> u32 {
        let blocks = self.size[0].div_ceil(8 * self.side) * self.size[1].div_ceil(8 * self.side);
        blocks.next_multiple_of(threads) * GROUP
    }

    /// For each lane the pixels it works on, as indices into the film; `u32::MAX` where there is
    /// none. The order is that of `lane_of` in `shaders/kernel/lanes.wesl`, whose states are in
    /// order of blocks.
    pub(crate) fn pixels(&self, lanes: u32, film: &Window) -> Vec<u32> {
        let across = self.size[0].div_ceil(8 * self.side);
        let per_lane = self.side * self.side;
        (0..lanes * per_lane)
            .map(|slot| {
                let (lane, k) = (slot / per_lane, slot % per_lane);
                let (block, local) = (lane / GROUP, lane % GROUP);
                let x = (local & 1) | ((local >> 1) & 2) | ((local >> 2) & 4);
                let y = ((local >> 1) & 1) | ((local >> 2) & 2) | ((local >> 3) & 4);
                let at = [
                    self.side * ((block % across) * 8 + x) + (k & 1),
                    self.side * ((block / across) * 8 + y) + (k >> 1),
                ];
                let whole = [0, 1].map(|axis| self.corner[axis] + at[axis]);
                let inside = (0..2).all(|axis| {
                    at[axis] < self.size[axis]
                        && whole[axis] >= film.corner[axis]
                        && whole[axis] < film.corner[axis] + film.size[axis]
                });
                if inside { (whole[1] - film.corner[1]) * film.size[0] + whole[0] - film.corner[0] } else { u32::MAX }
            })
            .collect()
    }
}
