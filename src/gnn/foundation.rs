//! The pad as a bed of springs (Winkler 1867): what imposed geometry alone says about travel and contact.
//!
//! Every face node is a spring of stiffness `MODULUS E area / thickness` that the object compresses by `depth - gap`. The
//! depth that carries a force is the network's unit of travel and displacement: it learns what the gel does differently.

/// Stiffness of the springs over Young's modulus: a layer bonded on one side is stiffer than a bar, softer than confined.
pub const MODULUS: f64 = 2.0;

/// A bed of springs.
#[derive(Debug, Clone, PartialEq)]
pub struct Foundation {
    /// Gap of each spring at first contact, over the thickness, ascending; with its area over the thickness squared.
    springs: Vec<(f64, f64)>,
}

impl Foundation {
    /// From gap and area of each node; dimensionless.
    pub fn new(gap: &[f64], area: &[f64]) -> Self {
        let mut springs: Vec<_> = gap.iter().copied().zip(area.iter().copied()).collect();
        springs.sort_by(|a, b| a.0.total_cmp(&b.0).then(a.1.total_cmp(&b.1)));
        Self { springs }
    }

    /// The depth (over the thickness) that carries `force` (over `E thickness^2`): exact, spring after spring.
    pub fn depth(&self, force: f64) -> f64 {
        let (mut area, mut moment) = (0.0, 0.0);
        for (k, (gap, a)) in self.springs.iter().enumerate() {
            area += a;
            moment += a * gap;
            // With the first k + 1 springs: MODULUS (depth area - moment) = force.
            let depth = (force / MODULUS + moment) / area;
            if self.springs.get(k + 1).is_none_or(|next| depth <= next.0) {
                return depth;
            }
        }
        0.0
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_springs_carry_the_force() {
        let (gap, area) = ([0.0, 0.3, 0.1, 2.0], [0.5, 0.2, 1.0, 4.0]);
        let bed = Foundation::new(&gap, &area);
        for force in [1e-6, 0.01, 0.1, 1.0, 30.0] {
            let depth = bed.depth(force);
            let carried: f64 = gap.iter().zip(&area).map(|(g, a)| MODULUS * a * (depth - g).max(0.0)).sum();
            assert!((carried - force).abs() < 1e-12 * force.max(1.0), "force {force}: carried {carried}");
        }
    }
}
