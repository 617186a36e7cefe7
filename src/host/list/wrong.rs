//! What is wrong with a specification.

use thiserror::Error;

/// What is wrong with a specification, and at which key.
#[derive(Clone, Debug, PartialEq, Eq, Error)]
#[error("{words}")]
pub(crate) struct Wrong {
    /// The keys from the outside in, `values` and `v-Pos`, or the place in a list; empty: the whole specification.
    pub(crate) path: Vec<String>,
    /// Whether the key itself is wrong, not its value.
    pub(crate) is_key: bool,
    /// What is wrong, and what to do.
    pub(crate) words: String,
}

impl Wrong {
    pub(super) fn at(key: &str, words: impl ToString) -> Self {
        Self { path: vec![key.to_owned()], is_key: false, words: words.to_string() }
    }

    pub(super) fn within(key: &str, inner: &str, words: impl ToString) -> Self {
        Self { path: vec![key.to_owned(), inner.to_owned()], is_key: false, words: words.to_string() }
    }

    /// The same, deeper in.
    pub(super) fn under(self, outer: &[&str]) -> Self {
        let path = outer.iter().map(|key| (*key).to_owned()).chain(self.path).collect();
        Self { path, ..self }
    }

    pub(super) fn key(key: &str, words: impl ToString) -> Self {
        Self { is_key: true, ..Self::at(key, words) }
    }

    pub(super) fn whole(words: impl ToString) -> Self {
        Self { path: Vec::new(), is_key: false, words: words.to_string() }
    }
}
