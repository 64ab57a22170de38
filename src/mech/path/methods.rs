//! Counts of the methods of the continuation.

use serde::{Deserialize, Serialize};
use std::fmt;
use std::ops::AddAssign;

/// Counts of how often each method of the continuation was used.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(default)]
pub struct Methods {
    /// Accepted increments.
    pub increments: u64,
    /// Increments rejected because of their path error.
    pub bent: u64,
    /// Increments halved because no equilibrium was found.
    pub halved: u64,
    /// Solves in which friction oscillated and was lagged.
    pub frozen: u64,
    /// Iterations with a projected stiffness.
    pub projected: u64,
    /// Pseudo-transient continuations.
    pub pseudo_transient: u64,
    /// Pads recondensed before a level was reached.
    pub condensed_anew: u64,
    /// Grasps that fell back to full pads after condensed ones failed.
    pub whole: u64,
}

impl Methods {
    /// Counts, each with its name.
    pub fn counts(&self) -> [(&'static str, u64); 8] {
        [
            ("increments", self.increments),
            ("rejected for their path error", self.bent),
            ("halved", self.halved),
            ("with frozen friction", self.frozen),
            ("with projected stiffness", self.projected),
            ("with pseudo-transient continuation", self.pseudo_transient),
            ("recondensed", self.condensed_anew),
            ("fallen back to full pads", self.whole),
        ]
    }
}

impl AddAssign for Methods {
    fn add_assign(&mut self, more: Self) {
        self.increments += more.increments;
        self.bent += more.bent;
        self.halved += more.halved;
        self.frozen += more.frozen;
        self.projected += more.projected;
        self.pseudo_transient += more.pseudo_transient;
        self.condensed_anew += more.condensed_anew;
        self.whole += more.whole;
    }
}

/// Lists the methods that were used, like `57 increments, 3 halved`.
impl fmt::Display for Methods {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        let used = self.counts().into_iter().filter(|(_, count)| *count > 0);
        let used: Vec<_> = used.map(|(what, count)| format!("{count} {what}")).collect();
        f.write_str(&used.join(", "))
    }
}
