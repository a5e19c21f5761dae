//! Benches of the whole: what specialisation buys, what triangles cost, how long the start takes, and parts of the work on the device.
//!
//! Each prints its conditions. Run them one at a time on a machine that does nothing else: `cargo bench --bench specialisation`, `size`, `start`, `device`.
