//! Checks of the text of a scene for errors that the RON parser accepts.

use super::diagnose::Diagnosis;
use super::outline::{Outline, OutlineEntry};

/// Returns the first problem as an error.
pub(super) fn lint(text: &str, outline: &Outline) -> Result<(), Diagnosis> {
    let entries = outline.entries();
    entries.iter().enumerate().try_for_each(|(i, entry)| match outline.field(entry) {
        // entries are in order of their end, so the entry that ends just before is the last inner value
        Some("rotation") => rotation(text, outline, entry, entries[..i].last()),
        Some("select") => select(text, outline, entry),
        _ => Ok(()),
    })
}

/// Checks the name of a rotation: RON drops the name in `RpyDeg((r, p, y))`, so `RpyRad((r, p, y))` would be read as
/// degrees.
fn rotation(
    text: &str,
    outline: &Outline,
    entry: &OutlineEntry,
    inner: Option<&OutlineEntry>,
) -> Result<(), Diagnosis> {
    let inside = |e: &&OutlineEntry| entry.value.start < e.value.start;
    let angles = inner.filter(inside).is_some_and(|e| text[e.value.clone()].starts_with(['(', '[']));
    let (what, at) = match &entry.name {
        None if angles => ("a rotation by angles needs a name".to_string(), entry.value.clone()),
        None => return Ok(()),
        Some(name) if &text[name.clone()] != "RpyDeg" => {
            (format!("unknown form of rotation `{}`", &text[name.clone()]), name.clone())
        }
        Some(name) if !angles => ("RpyDeg takes three angles in double parentheses".to_string(), name.clone()),
        Some(_) => return Ok(()),
    };
    let help = "allowed: (w, x, y, z) or RpyDeg((roll, pitch, yaw))";
    Err(Diagnosis::new(&format!("{}: {what}\n{help}", outline.path(entry)), at))
}

/// Checks the range of a selection: RON reads `0..=9` and `0..9` as the same pair of numbers.
fn select(text: &str, outline: &Outline, entry: &OutlineEntry) -> Result<(), Diagnosis> {
    if text[entry.value.clone()].contains("..=") {
        let message = format!(
            "{}: an inclusive range (`=`) is not supported here\nwrite 0..10 for rows 0 to 9",
            outline.path(entry)
        );
        return Err(Diagnosis::new(&message, entry.value.clone()));
    }
    Ok(())
}
