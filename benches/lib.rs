//! Benches of the whole: the gain of specialisation, the cost of triangles, the time to start, and
//! parts of the work on the device.
//!
//! Each prints its conditions. Run them one at a time on a machine that does nothing else: `cargo
//! bench --bench specialisation`, `size`, `start`, `device`.
