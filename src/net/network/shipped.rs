//! Models embedded in the program, by name, so that they are available in any folder.

use std::path::Path;

/// Model that ships with tactus.
#[derive(Debug)]
pub struct ShippedModel {
    /// Name of the model.
    pub name: &'static str,
    /// Card of the model.
    pub card: &'static str,
    /// Weights of the model, safetensors.
    pub weights: &'static [u8],
}

macro_rules! shipped {
    ($($name:literal),*) => {
        [$(ShippedModel {
            name: $name,
            card: include_str!(concat!("../../../models/", $name, "/card.ron")),
            weights: include_bytes!(concat!("../../../models/", $name, "/weights.safetensors")),
        }),*]
    };
}

/// List of all shipped models.
pub static ALL: [ShippedModel; 1] = shipped!["universe"];

/// Name of the default model.
pub const DEFAULT_MODEL: &str = "universe";

/// Returns the shipped model with the name `model`; None if it is a folder. A bare name is never a folder, `./NAME` is.
pub fn by_name(model: &Path) -> Option<&'static ShippedModel> {
    ALL.iter().find(|shipped| model.as_os_str() == shipped.name)
}

/// Returns the names of all shipped models, for messages.
pub fn names() -> String {
    ALL.iter().map(|shipped| shipped.name).collect::<Vec<_>>().join(", ")
}

#[cfg(test)]
mod tests {
    use super::ALL;
    use scene::stepper::SHIPPED_MODELS;

    /// Checks that the model names listed for scenes are those of the embedded models.
    #[test]
    fn every_name_has_its_model() {
        assert!(ALL.iter().map(|shipped| shipped.name).eq(SHIPPED_MODELS));
    }
}
