// Constants of several modules.

const PI: f32 = 3.14159265358979;
const INV_PI: f32 = 0.31830988618379;
// Means no hit: WGSL rejects infinity literals.
const FAR: f32 = 3.0e38;
const NONE: u32 = 0xffffffffu;
