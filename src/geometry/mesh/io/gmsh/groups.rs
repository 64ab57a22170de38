//! Physical groups of a gmsh file: their names, and the volumes that belong to them.

use std::collections::BTreeMap;

use super::version::Version;
use base::error::{Error, Result};
use base::number::format_count;
use std::path::Path;

/// Largest number of groups listed in a message.
const MAX_LISTED: usize = 20;

/// Type of a number in the entities section, which determines its width in the binary form.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum NumberWidth {
    Int,
    Size,
    Real,
}

/// Groups of the volumes of a file.
#[derive(Debug, Default)]
pub(crate) struct Groups {
    /// Names of groups of volumes by their tags.
    names: BTreeMap<u64, String>,
    /// Tags of the groups of a volume, by its tag; empty for version 2, whose elements store their group.
    of_volume: BTreeMap<u64, Vec<u64>>,
    /// Volume of each tetrahedron; in version 2 its group, 0 for none.
    volume: Vec<u64>,
}

impl Groups {
    /// Stores the name in a line `dimension tag "name"` of dimension 3; ignores any other line.
    pub fn name(&mut self, line: &str) {
        let mut words = line.trim().splitn(3, char::is_whitespace);
        if let (Some("3"), Some(tag), Some(name)) = (words.next(), words.next(), words.next())
            && let Ok(tag) = tag.parse()
        {
            self.names.insert(tag, name.trim().trim_matches('"').into());
        }
    }

    /// Reads the entities section of version 4 number by number; `next` returns the next number, zero for a real. A
    /// truncated section gives no groups.
    pub fn entities(&mut self, version: Version, mut next: impl FnMut(NumberWidth) -> Option<i64>) -> Option<()> {
        let mut counts = [0; 4];
        for count in &mut counts {
            *count = next(NumberWidth::Size)?;
        }
        let mut of_volume = BTreeMap::new();
        for (dimension, count) in counts.into_iter().enumerate() {
            for _ in 0..count {
                let tag = next(NumberWidth::Int)?;
                // Since version 4.1 a point has coordinates; all other entities have a bounding box.
                let reals = if dimension == 0 && version == Version::V41 { 3 } else { 6 };
                (0..reals).try_for_each(|_| next(NumberWidth::Real).map(|_| ()))?;
                let mut list = || {
                    let count = next(NumberWidth::Size)?;
                    (0..count).map(|_| next(NumberWidth::Int).map(i64::unsigned_abs)).collect::<Option<Vec<u64>>>()
                };
                let groups = list()?;
                if dimension > 0 {
                    list()?;
                }
                if dimension == 3 {
                    of_volume.insert(tag.unsigned_abs(), groups);
                }
            }
        }
        self.of_volume = of_volume;
        Some(())
    }

    /// Stores the volume of the next kept tetrahedron; in version 2 its group.
    pub fn tetrahedron(&mut self, volume: u64) {
        self.volume.push(volume);
    }

    /// Returns the tags of the groups of a volume.
    fn tags(&self, volume: u64) -> &[u64] {
        self.of_volume.get(&volume).map_or(&[], Vec::as_slice)
    }

    /// Keeps those of `tets` that belong to the group `wanted`; None keeps all, with a notice where they belong to
    /// several.
    ///
    /// # Errors
    /// Fails if no tetrahedron belongs to the group.
    pub fn select(mut self, path: &Path, tets: &mut Vec<[u32; 4]>, wanted: Option<&str>) -> Result<Option<String>> {
        if self.of_volume.is_empty() {
            self.of_volume =
                self.volume.iter().filter(|group| **group > 0).map(|group| (*group, vec![*group])).collect();
        }
        let mut found: BTreeMap<u64, usize> = BTreeMap::new();
        let mut without = 0;
        for volume in &self.volume {
            self.tags(*volume).iter().for_each(|tag| *found.entry(*tag).or_default() += 1);
            without += usize::from(self.tags(*volume).is_empty());
        }
        let called = |tag: &u64| self.names.get(tag).cloned().unwrap_or_else(|| tag.to_string());
        let mut list: Vec<String> = found
            .iter()
            .take(MAX_LISTED)
            .map(|(tag, n)| format!("{:?} of {}", called(tag), format_count(*n, "tetrahedron")))
            .collect();
        if found.len() > MAX_LISTED {
            list.push("...".into());
        }
        if without > 0 && !found.is_empty() {
            list.push(format!("{} without a group", format_count(without, "tetrahedron")));
        }
        let list = list.join(", ");
        let Some(wanted) = wanted else {
            let first = found.keys().next().map(called).unwrap_or_default();
            return Ok((found.len() + usize::from(without > 0 && !found.is_empty()) > 1)
                .then(|| format!("the volumes {list} are combined; choose one by its group: `group: {first:?}`")));
        };
        let tags: Vec<u64> = found.keys().copied().filter(|tag| called(tag) == wanted).collect();
        if tags.is_empty() {
            let has = if found.is_empty() { "no physical volumes".into() } else { format!("the volumes {list}") };
            return Err(Error::file(path, format!("has no physical volume {wanted:?}; it has {has}")));
        }
        let kept: Vec<bool> = self.volume.iter().map(|v| self.tags(*v).iter().any(|tag| tags.contains(tag))).collect();
        let mut keep = kept.into_iter();
        tets.retain(|_| keep.next().unwrap_or(true));
        Ok(None)
    }
}
