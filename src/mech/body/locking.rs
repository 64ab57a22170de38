//! Notice about elements that lock in nearly incompressible gels.

use super::{Body, Elements};

/// Poisson's ratio from which a notice is given.
pub const LOCKING_POISSON_RATIO: f64 = 0.4;

/// Returns a notice for the user if the elements of `body` lock: 4-node tetrahedra, or 10-node ones with an independent
/// pressure at every quadrature point, at nu of [`LOCKING_POISSON_RATIO`] or more.
///
/// Measured with a sphere of radius 6 mm pressed 1 mm into a 20 x 25 x 4.5 mm pad: with 600 nodes per quarter pad the
/// force is 31 % too high at nu = 0.45 and 77 % at 0.49, with 5250 nodes still 7 % and 24 %; 495 nodes of 10-node
/// tetrahedra with mean dilatation are within 2 % at both.
pub fn locking_notice(body: &Body) -> Option<String> {
    let nu = body.material.moduli().poisson;
    let what = match body.elements {
        _ if nu < LOCKING_POISSON_RATIO => return None,
        Elements::Linear(_) => {
            "linear tetrahedra: forces can be tens of percent too high (a sphere pressed 1 mm into a pad of 600 nodes per \
             quarter: 31 % at nu = 0.45, 77 % at 0.49; of 5250 nodes: 7 % and 24 %)"
        }
        Elements::Quadratic(_) if !body.mean_dilatation => {
            "10-node tetrahedra without mean dilatation: forces are too high"
        }
        Elements::Quadratic(_) => return None,
    };
    Some(format!("volumetric locking at nu = {nu}: {what}; use element: Quadratic with mean_dilatation: true"))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::material::NeoHookean;
    use geometry::mesh::{grid, quadratic};
    use std::sync::Arc;

    #[test]
    fn only_linear_tetrahedra_of_nearly_incompressible_gels_are_warned_about() {
        let mesh = grid::structured([&[0.0, 1.0], &[0.0, 1.0], &[0.0, 1.0]]).expect("grid");
        let ten = quadratic::to_quadratic(&mesh);
        let notice = |quadratic: bool, nu: f64| {
            let (nodes, elements) = match quadratic {
                false => (mesh.nodes.clone(), Elements::Linear(mesh.tets.clone())),
                true => (ten.nodes.clone(), Elements::Quadratic(ten.tets.clone())),
            };
            let fixed = nodes.iter().map(|p| p.z == 0.0).collect();
            locking_notice(&Body::new(nodes, elements, fixed, Arc::new(NeoHookean::new(1.0, nu)), true))
        };
        let text = notice(false, 0.49).expect("a notice");
        assert!(text.starts_with("volumetric locking at nu = 0.49: linear tetrahedra: forces can be tens"), "{text}");
        assert!(text.ends_with("use element: Quadratic with mean_dilatation: true"), "{text}");
        assert!(notice(false, 0.4).is_some());
        assert_eq!([notice(false, 0.39), notice(true, 0.49), notice(true, 0.4)], [None, None, None]);
    }
}
