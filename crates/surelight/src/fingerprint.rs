//! Hashes of scenes as loaded, texts and bytes, which files hold: they depend on values alone.

mod scene;

pub(crate) use scene::of;

/// Hash of a text, as 16 hexadecimal digits.
pub(crate) fn of_text(text: &str) -> String {
    of_bytes(text.as_bytes())
}

/// Hash of bytes, likewise.
pub(crate) fn of_bytes(bytes: &[u8]) -> String {
    let mut hash = Hash::new();
    hash.bytes(bytes);
    hash.digits()
}

/// Fowler–Noll–Vo's xor and multiply over 64-bit words, with a shift that lets high bits reach low ones.
struct Hash(u64);

impl Hash {
    fn new() -> Self {
        Self(0xcbf2_9ce4_8422_2325)
    }

    fn digits(&self) -> String {
        format!("{:016x}", self.0)
    }

    fn word(&mut self, word: u64) {
        self.0 = (self.0 ^ word).wrapping_mul(0x0000_0100_0000_01b3);
        self.0 ^= self.0 >> 29;
    }

    fn bytes(&mut self, bytes: &[u8]) {
        let (words, rest) = bytes.as_chunks::<8>();
        words.iter().for_each(|&word| self.word(u64::from_le_bytes(word)));
        rest.iter().for_each(|&byte| self.word(byte.into()));
        self.word(bytes.len() as u64);
    }
}
