// Nested uniform (Owen) scrambling by hashing.

// Of bit-reversed integers: Laine & Karras 2011, "Stratified sampling for stochastic transparency",
// section 3.1, with the constants that N. Vegdahl found in 2021 ("Owen scrambling based hashing").
fn owen_reversed(v: u32, seed: u32) -> u32 {
    var x = v;
    x ^= x * 0x3d20adeau;
    x += seed;
    x *= (seed >> 16u) | 1u;
    x ^= x * 0x05526c56u;
    x ^= x * 0x53a22864u;
    return x;
}

// An index shuffled so that aligned blocks of any power of two stay together, each a permutation of
// itself.
fn owen_shuffle(index: u32, seed: u32) -> u32 {
    return reverseBits(owen_reversed(reverseBits(index), seed));
}
