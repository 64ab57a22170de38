//! Excerpts of a text that fit into a message.

use std::borrow::Cow;

/// Longest name in a message, bytes.
const MAX_NAME_LENGTH: usize = 60;

/// Returns at most `most` bytes of a text, followed by dots if it is longer.
pub(super) fn truncate(text: &str, most: usize) -> Cow<'_, str> {
    if text.len() <= most { text.into() } else { format!("{}...", &text[..floor(text, most)]).into() }
}

/// Returns a name from the scene, shortened for a message.
pub(super) fn truncate_name(name: &str) -> Cow<'_, str> {
    truncate(name, MAX_NAME_LENGTH)
}

/// Returns the nearest character boundary at or before a byte.
pub(super) fn floor(text: &str, at: usize) -> usize {
    let mut at = at.min(text.len());
    while !text.is_char_boundary(at) {
        at -= 1;
    }
    at
}
