//! Counts of the methods of the continuation.

use serde::{Deserialize, Serialize};
use std::fmt;
use std::ops::AddAssign;

/// Counts of how often each method of the continuation was used.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(default)]
pub struct MethodCounts {
    /// Accepted increments.
    pub increments: u64,
    /// Increments rejected because of their path error.
    #[serde(rename = "bent")]
    pub rejected: u64,
    /// Increments halved because no equilibrium was found.
    pub halved: u64,
    /// Solves in which friction oscillated and was lagged.
    pub frozen: u64,
    /// Iterations with a projected stiffness.
    pub projected: u64,
    /// Pseudo-transient continuations.
    pub pseudo_transient: u64,
    /// Pads recondensed before a level was reached.
    #[serde(rename = "condensed_anew")]
    pub recondensed: u64,
    /// Grasps that fell back to full pads after condensed ones failed.
    #[serde(rename = "whole")]
    pub full_pads: u64,
}

impl MethodCounts {
    /// Counts, each with its name.
    pub fn counts(&self) -> [(&'static str, u64); 8] {
        [
            ("increments", self.increments),
            ("rejected for their path error", self.rejected),
            ("halved", self.halved),
            ("with frozen friction", self.frozen),
            ("with projected stiffness", self.projected),
            ("with pseudo-transient continuation", self.pseudo_transient),
            ("recondensed", self.recondensed),
            ("fallen back to full pads", self.full_pads),
        ]
    }
}

impl AddAssign for MethodCounts {
    fn add_assign(&mut self, more: Self) {
        self.increments += more.increments;
        self.rejected += more.rejected;
        self.halved += more.halved;
        self.frozen += more.frozen;
        self.projected += more.projected;
        self.pseudo_transient += more.pseudo_transient;
        self.recondensed += more.recondensed;
        self.full_pads += more.full_pads;
    }
}

/// Lists the methods that were used, like `57 increments, 3 halved`.
impl fmt::Display for MethodCounts {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        let used = self.counts().into_iter().filter(|(_, count)| *count > 0);
        let used: Vec<_> = used.map(|(what, count)| format!("{count} {what}")).collect();
        f.write_str(&used.join(", "))
    }
}
