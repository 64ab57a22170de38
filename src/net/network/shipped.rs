//! Models within the program, by name: they are there wherever it runs.

use std::path::Path;

/// A model that ships with tactus.
#[derive(Debug)]
pub struct Shipped {
    /// Its name.
    pub name: &'static str,
    /// Its card.
    pub card: &'static str,
    /// Its weights, safetensors.
    pub weights: &'static [u8],
}

macro_rules! shipped {
    ($($name:literal),*) => {
        [$(Shipped {
            name: $name,
            card: include_str!(concat!("../../../models/", $name, "/card.ron")),
            weights: include_bytes!(concat!("../../../models/", $name, "/weights.safetensors")),
        }),*]
    };
}

/// All of them; both are for flat GelSight Mini pads, of the usual and of finer elements.
pub static ALL: [Shipped; 2] = shipped!["gelsight_mini", "gelsight_mini_fine"];

/// The one that is taken where none is named.
pub const SHIPPED: &str = "gelsight_mini";

/// The model that `model` names; None if it is a folder. A name is never a folder: `./NAME` is one.
pub fn named(model: &Path) -> Option<&'static Shipped> {
    ALL.iter().find(|shipped| model.as_os_str() == shipped.name)
}

/// Names for messages.
pub fn names() -> String {
    ALL.iter().map(|shipped| shipped.name).collect::<Vec<_>>().join(", ")
}

#[cfg(test)]
mod tests {
    use super::ALL;
    use crate::scene::stepper::SHIPPED_MODELS;

    /// Scenes know the names, the program has the models.
    #[test]
    fn every_name_has_its_model() {
        assert!(ALL.iter().map(|shipped| shipped.name).eq(SHIPPED_MODELS));
    }
}
