//! Transfer of results from a finer mesh to the nodes of the pads that a scene describes.
//!
//! [`FieldTransfer`] interpolates fields and distributes contact forces.

use glam::DVec3;
use model::Model;
use record::{FieldTransfer, Frame, PadFrame};
use std::sync::Arc;

/// Map from the frames of a finer mesh to those of the pads of a scene.
#[derive(Debug)]
pub struct Sampling {
    coarse: Arc<Model>,
    /// Reference position of the first node of each finer pad, m, hand frame.
    first: Vec<DVec3>,
    /// Map of each pad.
    pads: Vec<Arc<FieldTransfer>>,
}

impl Sampling {
    /// Creates the map between two models of the same pads.
    pub fn new(fine: &Model, coarse: Arc<Model>) -> Self {
        let first = fine.fingers.iter().map(|finger| finger.body.rest[0]).collect();
        let mut pads: Vec<Arc<FieldTransfer>> = Vec::new();
        for (fine, own) in fine.fingers.iter().zip(&coarse.fingers) {
            let known = pads.first().filter(|_| coarse.has_equal_pads()).cloned();
            pads.push(known.unwrap_or_else(|| Arc::new(FieldTransfer::new(&fine.topology, &own.topology))));
        }
        Self { pads, first, coarse }
    }

    /// Returns `frame` at the nodes of the coarser pads. Scalars of the frame remain those of the finer mesh.
    pub fn frame(&self, frame: &Frame) -> Frame {
        let maps = self.first.iter().zip(&self.pads);
        let pads = frame.pads.iter().zip(&self.coarse.fingers).zip(maps).map(|((pad, finger), (first, map))| {
            let stress = &pad.von_mises_node;
            let displacement = map.displacement(&pad.displacement);
            let von_mises_node: Vec<f64> = if stress.is_empty() { Vec::new() } else { map.values(stress) };
            let carried = pad.rigid_translation(std::slice::from_ref(first));
            let elements = &finger.topology.elements;
            let mean = |own: &[u32]| own.iter().map(|n| von_mises_node[*n as usize]).sum::<f64>() / own.len() as f64;
            let tets = elements.nodes().chunks_exact(elements.width());
            let von_mises_element = if stress.is_empty() { Vec::new() } else { tets.map(mean).collect() };
            let contact_force = if pad.contact_force.is_empty() { Vec::new() } else { map.force(&pad.contact_force) };
            PadFrame {
                position: finger.body.rest.iter().zip(&displacement).map(|(x, u)| *x + carried + *u).collect(),
                displacement,
                contact_force,
                von_mises_node,
                von_mises_element,
                gap: if pad.gap.is_empty() { Vec::new() } else { map.values(&pad.gap) },
                // Tactile images of slip are computed on the finer mesh.
                slip: Vec::new(),
                contact_area: pad.contact_area,
                wrench: pad.wrench,
            }
        });
        Frame { pads: pads.collect(), ..frame.clone() }
    }
}
