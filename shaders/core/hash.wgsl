// Integer hashes.

// PCG output permutation over a linear congruential step (Jarzynski & Olano 2020, JCGT 9(3),
// "pcg").
fn hash_u32(v: u32) -> u32 {
    let s = v * 747796405u + 2891336453u;
    let w = ((s >> ((s >> 28u) + 4u)) ^ s) * 277803737u;
    return (w >> 22u) ^ w;
}

fn hash_combine(a: u32, b: u32) -> u32 {
    return hash_u32(a ^ (b * 0x9e3779b9u + 0x7f4a7c15u));
}

// Uniform in [0, 1): the top 24 bits, so that 1 is never returned.
fn unit_from_bits(bits: u32) -> f32 {
    return f32(bits >> 8u) * 5.9604644775390625e-8;
}

// The upper 32 bits of a product: `mul_high(bits, n)` is a whole number below n, even to 2^-32,
// when bits are uniform.
fn mul_high(a: u32, b: u32) -> u32 {
    let low = (a & 0xffffu) * (b & 0xffffu);
    let middle = (a >> 16u) * (b & 0xffffu) + (low >> 16u);
    let other = (a & 0xffffu) * (b >> 16u) + (middle & 0xffffu);
    return (a >> 16u) * (b >> 16u) + (middle >> 16u) + (other >> 16u);
}
