//! Transfer of results from a finer mesh to the nodes of the pads that a scene describes.
//!
//! Displacement and stress are interpolated by the shape functions of the finer mesh. A contact force is distributed
//! over the corners of the triangle of the coarser face on which it acts, which preserves the resultant force and its
//! moment about the face.

use geometry::face_lookup::FaceLookup;
use glam::DVec3;
use model::Model;
use record::error_norm::fields::Stencils;
use record::{Frame, PadFrame, PadTopology};
use std::sync::Arc;

/// Map from the frames of a finer mesh to those of the pads of a scene.
#[derive(Debug)]
pub struct Sampling {
    coarse: Arc<Model>,
    /// Reference position of the first node of each finer pad, m, hand frame.
    first: Vec<DVec3>,
    /// Map of each pad.
    pads: Vec<Arc<PadMap>>,
}

/// Map from the nodes of a finer mesh of a pad to those of a coarser one.
#[derive(Debug)]
struct PadMap {
    /// Nodes of the finer mesh and values of their shape functions, for each node of the coarser one.
    nodes: Stencils,
    /// Nodes of the coarser face and their weights, for each node of the finer sensing face.
    face: Vec<(u32, [(u32, f64); 3])>,
}

impl PadMap {
    fn new(fine: &PadTopology, coarse: &PadTopology) -> Self {
        let lookup = FaceLookup::new(&coarse.rest, &coarse.sensing);
        let mut pressed: Vec<u32> = fine.sensing.as_flattened().to_vec();
        pressed.sort_unstable();
        pressed.dedup();
        let face = pressed.into_iter().map(|n| (n, lookup.interpolation_at(fine.rest[n as usize]))).collect();
        Self { nodes: Stencils::new(&coarse.rest, fine), face }
    }
}

impl Sampling {
    /// Creates the map between two models of the same pads.
    pub fn new(fine: &Model, coarse: Arc<Model>) -> Self {
        let first = fine.fingers.iter().map(|finger| finger.body.rest[0]).collect();
        let mut pads: Vec<Arc<PadMap>> = Vec::new();
        for (fine, own) in fine.fingers.iter().zip(&coarse.fingers) {
            let known = pads.first().filter(|_| coarse.has_equal_pads()).cloned();
            pads.push(known.unwrap_or_else(|| Arc::new(PadMap::new(&fine.topology, &own.topology))));
        }
        Self { pads, first, coarse }
    }

    /// Returns `frame` at the nodes of the coarser pads. Scalars of the frame remain those of the finer mesh.
    pub fn frame(&self, frame: &Frame) -> Frame {
        let maps = self.first.iter().zip(&self.pads);
        let pads = frame.pads.iter().zip(&self.coarse.fingers).zip(maps).map(|((pad, finger), (first, map))| {
            let stress = &pad.von_mises_node;
            let displacement = map.nodes.of(&pad.displacement);
            let von_mises_node: Vec<f64> = if stress.is_empty() { Vec::new() } else { map.nodes.of(stress) };
            let carried = pad.rigid_translation(std::slice::from_ref(first));
            let elements = &finger.topology.elements;
            let mean = |own: &[u32]| own.iter().map(|n| von_mises_node[*n as usize]).sum::<f64>() / own.len() as f64;
            let tets = elements.nodes().chunks_exact(elements.width());
            let von_mises_element = if stress.is_empty() { Vec::new() } else { tets.map(mean).collect() };
            let mut contact_force = Vec::new();
            if !pad.contact_force.is_empty() {
                contact_force.resize(finger.topology.rest.len(), DVec3::ZERO);
                for (n, parts) in &map.face {
                    let force = pad.contact_force[*n as usize];
                    parts.iter().for_each(|(i, part)| contact_force[*i as usize] += force * *part);
                }
            }
            PadFrame {
                position: finger.body.rest.iter().zip(&displacement).map(|(x, u)| *x + carried + *u).collect(),
                displacement,
                contact_force,
                von_mises_node,
                von_mises_element,
                gap: if pad.gap.is_empty() { Vec::new() } else { map.nodes.of(&pad.gap) },
                // Tactile images of slip are computed on the finer mesh.
                slip: Vec::new(),
                contact_area: pad.contact_area,
                wrench: pad.wrench,
            }
        });
        Frame { pads: pads.collect(), ..frame.clone() }
    }
}
