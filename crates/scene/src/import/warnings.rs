//! Sentences about parts of a file that were not read as written.

/// More than this and the rest is only counted: a hostile file must not fill memory or the
/// terminal.
const MAX_WARNINGS: usize = 50;

/// Warnings in the order in which they arose, each once.
#[derive(Debug, Default)]
pub(crate) struct Warnings {
    texts: Vec<String>,
    more: usize,
}

impl Warnings {
    /// Adds a sentence unless it is there already.
    pub(crate) fn push(&mut self, text: impl Into<String>) {
        let text = text.into();
        if self.texts.contains(&text) {
            return;
        }
        if self.texts.len() < MAX_WARNINGS {
            self.texts.push(text);
        } else {
            self.more += 1;
        }
    }

    /// Adds all of another's.
    pub(crate) fn append(&mut self, other: Warnings) {
        for text in other.texts {
            self.push(text);
        }
        self.more += other.more;
    }

    /// The list for [`crate::Scene::warnings`].
    pub(crate) fn into_texts(mut self) -> Vec<String> {
        if self.more > 0 {
            self.texts.push(format!("There are {} more warnings like these.", self.more));
        }
        self.texts
    }
}

/// `1 triangle`, `2 triangles`, `2 vertices`.
pub(crate) fn count_of(count: usize, noun: &str) -> String {
    match (count, noun) {
        (1, _) => format!("1 {noun}"),
        (_, "vertex") => format!("{count} vertices"),
        _ => format!("{count} {noun}s"),
    }
}
