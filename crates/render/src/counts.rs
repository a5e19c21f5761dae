//! Counts of a renderer.

/// Work done so far.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Counts {
    /// Rays traversed: camera, continuation and shadow rays.
    pub rays: u64,
    /// Samples finished: each is one path from the camera.
    pub paths: u64,
    /// Particles from lights whose paths have ended.
    pub particles: u64,
    /// Samples that were not finite and are excluded from the sums.
    pub dropped: u64,
    /// Rays whose traversal ended at the limit of 32,768 steps; their samples are incomplete.
    pub truncated: u64,
    /// Seconds of dispatches, including the wait for them.
    pub trace_seconds: f64,
    /// Seconds of dispatches by the device's timestamps; the host's wait for them where the device
    /// has none ([`crate::AdapterInfo::timestamps`]).
    pub device_seconds: f64,
    /// Seconds of reading sums back from the device.
    pub read_seconds: f64,
    /// Seconds of adding these sums to the film.
    pub film_seconds: f64,
    /// Dispatches.
    pub dispatches: u64,
}

impl Counts {
    /// The counts since `earlier`.
    #[must_use]
    pub fn since(&self, earlier: &Self) -> Self {
        Self {
            rays: self.rays - earlier.rays,
            paths: self.paths - earlier.paths,
            particles: self.particles - earlier.particles,
            dropped: self.dropped - earlier.dropped,
            truncated: self.truncated - earlier.truncated,
            trace_seconds: self.trace_seconds - earlier.trace_seconds,
            device_seconds: self.device_seconds - earlier.device_seconds,
            read_seconds: self.read_seconds - earlier.read_seconds,
            film_seconds: self.film_seconds - earlier.film_seconds,
            dispatches: self.dispatches - earlier.dispatches,
        }
    }

    /// The work of `finished`, with the time and the dispatches of `self`: the counts after an
    /// interrupted pass.
    pub(crate) fn without_unfinished(&self, finished: &Self) -> Self {
        Self {
            trace_seconds: self.trace_seconds,
            device_seconds: self.device_seconds,
            read_seconds: self.read_seconds,
            film_seconds: self.film_seconds,
            dispatches: self.dispatches,
            ..*finished
        }
    }
}

/// Called between dispatches; returns whether to continue.
pub type Observer<'a> = dyn FnMut(&Counts) -> bool + 'a;

/// Counts work in progress, and lets the observer stop it.
pub(crate) struct Monitor<'m, 'o> {
    pub(crate) counts: &'m mut Counts,
    pub(crate) observer: &'m mut Observer<'o>,
}
