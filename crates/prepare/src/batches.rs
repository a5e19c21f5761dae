//! Which batches a render is made of.

/// Batches that an error bar needs: each is an independent scramble of the sequence.
const BATCHES: u32 = 16;

/// Sums on the device are f32: batches stay short.
const MAX_SAMPLES: u32 = 4096;

/// The largest power of two up to `n`, 1 for 0.
fn power_of_two(n: u32) -> u32 {
    if n == 0 { 1 } else { 1 << n.ilog2() }
}

/// The sizes of batches, which follow from the samples planned.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Batches {
    /// Planned samples per pixel: a full batch is 1/16 of them, rounded down to a power of two.
    /// Without a plan, batches grow with the samples done, so that at least 16 carry most of the
    /// weight.
    pub planned: Option<u32>,
}

impl Batches {
    /// Samples of a full batch after `done` samples per pixel.
    pub fn full(self, done: u32) -> u32 {
        power_of_two(self.planned.unwrap_or(done) / BATCHES).min(MAX_SAMPLES)
    }

    /// Samples in the next batch, after `done` samples per pixel of `until`; 0 at the end.
    ///
    /// The first full batch comes in pieces of 1, 1, 2, 4, … samples: there is soon an image to
    /// save when the render is interrupted, however many samples are planned. The remainder at the
    /// end makes a shorter batch.
    pub fn next(self, done: u32, until: Option<u32>) -> u32 {
        let left = until.map_or(u32::MAX, |until| until.saturating_sub(done));
        self.full(done).min(power_of_two(done)).min(left)
    }

    /// The batches that end around a sample: the end of the last one up to it, the number of
    /// batches until there, and the end of the next one, with `planned` samples in all.
    pub fn around(self, sample: u32) -> ([u32; 2], u32) {
        let (mut done, mut count) = (0, 0);
        loop {
            let samples = self.next(done, self.planned);
            if samples == 0 || done + samples > sample {
                return ([done, done + samples], count);
            }
            (done, count) = (done + samples, count + 1);
        }
    }

    /// How many batches of the next one's size follow on each other.
    pub fn run(self, done: u32, until: Option<u32>) -> u32 {
        let samples = self.next(done, until);
        if samples == 0 || samples < self.full(done) {
            return 1;
        }
        let left = until.unwrap_or(u32::MAX) - done;
        match self.planned {
            Some(_) => left / samples,
            // Until the next size is due.
            None if samples < MAX_SAMPLES => (2 * BATCHES * samples - done).min(left) / samples,
            None => (left / samples).min(BATCHES),
        }
        .max(1)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn batches(spp: u32) -> Vec<u32> {
        let plan = Batches { planned: Some(spp) };
        let (mut done, mut all) = (0, Vec::new());
        while plan.next(done, Some(spp)) > 0 {
            all.push(plan.next(done, Some(spp)));
            done += plan.next(done, Some(spp));
        }
        assert_eq!(done, spp);
        all
    }

    #[test]
    fn all_samples_are_done_in_enough_batches_that_begin_small() {
        assert_eq!(batches(1), [1]);
        assert_eq!(batches(20), [1; 20]);
        assert_eq!(batches(64)[..5], [1, 1, 2, 4, 4]);
        for spp in [16, 64, 100, 1000, 4096, 100_000_000] {
            let all = batches(spp);
            let full = Batches { planned: Some(spp) }.full(0);
            assert!(all.iter().filter(|&&n| n == full).count() >= 15, "{spp}: {all:?}");
            assert_eq!(all[0], 1);
        }
    }

    #[test]
    fn samples_lie_between_the_ends_of_batches() {
        let plan = Batches { planned: Some(100) };
        for (sample, ends, count) in [(0, [0, 1], 0), (1, [1, 2], 1), (3, [2, 4], 2), (4, [4, 8], 3), (9, [8, 12], 4)] {
            assert_eq!(plan.around(sample), (ends, count));
        }
        assert_eq!((plan.around(99).0, plan.around(100).0), ([96, 100], [100, 100]));
        assert_eq!(Batches { planned: Some(99) }.around(98).0, [96, 99]);
    }

    #[test]
    fn runs_end_where_the_size_changes() {
        let plan = Batches { planned: Some(100) };
        assert_eq!([0, 2, 4, 92, 96].map(|done| plan.run(done, Some(100))), [1, 1, 24, 2, 1]);
        let growing = Batches { planned: None };
        assert_eq!([0, 20, 32, 48, 1000].map(|done| growing.run(done, None)), [32, 12, 16, 8, 1]);
    }

    #[test]
    fn without_a_plan_batches_grow() {
        let growing = Batches { planned: None };
        assert_eq!([0, 15, 31, 32, 1 << 20].map(|done| growing.next(done, None)), [1, 1, 1, 2, 4096]);
    }
}
