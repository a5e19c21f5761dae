//! Hashes of scenes as loaded, texts and bytes, which files hold: they depend on values alone.

mod scene;

use xxhash_rust::xxh3::Xxh3;

pub(crate) use scene::of;

/// Hash of a text, as 16 hexadecimal digits.
pub(crate) fn of_text(text: &str) -> String {
    of_bytes(text.as_bytes())
}

/// Hash of bytes.
pub(crate) fn of_bytes(bytes: &[u8]) -> String {
    let mut hash = Hash::new();
    hash.bytes(bytes);
    hash.digits()
}

/// XXH3 over little-endian words and bytes.
struct Hash(Xxh3);

impl Hash {
    fn new() -> Self {
        Self(Xxh3::new())
    }

    fn digits(&self) -> String {
        format!("{:016x}", self.0.digest())
    }

    fn word(&mut self, word: u64) {
        self.0.update(&word.to_le_bytes());
    }

    fn bytes(&mut self, bytes: &[u8]) {
        self.0.update(bytes);
        self.word(bytes.len() as u64);
    }
}
