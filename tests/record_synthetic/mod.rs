//! A made-up grasp for the record and render tests: two box pads, pressed by a sphere into a Gaussian bump.
#![allow(dead_code)]

use glam::{DMat3, DQuat, DVec3};
use std::collections::HashMap;
use tactus::mesh::TriMesh;
use tactus::record::{Elements, Frame, PadFrame, PadTopology, Wrench};

/// Half width (x), half length (y), thickness, m.
pub const SIZE: (f64, f64, f64) = (10.375e-3, 12.625e-3, 4.0e-3);
pub const RADIUS: f64 = 18e-3;
pub const PEAK_STRESS: f64 = 82e3;

/// The six tetrahedra of a cube with corners numbered x + 2 y + 4 z.
const KUHN: [[usize; 4]; 6] = [[0, 1, 3, 7], [0, 3, 2, 7], [0, 2, 6, 7], [0, 6, 4, 7], [0, 4, 5, 7], [0, 5, 1, 7]];
const EDGES: [(usize, usize); 6] = [(0, 1), (1, 2), (2, 0), (0, 3), (1, 3), (2, 3)];

/// A box of `cells` (x, y, z), sensing face at z = 0.
pub fn pad(cells: [usize; 3], quadratic: bool) -> PadTopology {
    let [nx, ny, nz] = cells;
    let id = |i: usize, j: usize, k: usize| (i + (nx + 1) * (j + (ny + 1) * k)) as u32;
    let mut rest = Vec::new();
    for k in 0..=nz {
        for j in 0..=ny {
            for i in 0..=nx {
                let part = |i: usize, n: usize| i as f64 / n as f64;
                let (x, y) = (SIZE.0 * (2.0 * part(i, nx) - 1.0), SIZE.1 * (2.0 * part(j, ny) - 1.0));
                rest.push(DVec3::new(x, y, SIZE.2 * (part(k, nz) - 1.0)));
            }
        }
    }
    let mut tets = Vec::new();
    for (i, j, k) in (0..nx).flat_map(|i| (0..ny).flat_map(move |j| (0..nz).map(move |k| (i, j, k)))) {
        let corner = |c: usize| id(i + (c & 1), j + (c >> 1 & 1), k + (c >> 2 & 1));
        tets.extend(KUHN.map(|tet| tet.map(corner)));
    }
    let mut faces: HashMap<[u32; 3], ([u32; 3], usize)> = HashMap::new();
    for t in &tets {
        for f in [[0, 2, 1], [0, 1, 3], [1, 2, 3], [0, 3, 2]] {
            let face: [u32; 3] = f.map(|i: usize| t[i]);
            let mut key = face;
            key.sort_unstable();
            faces.entry(key).or_insert((face, 0)).1 += 1;
        }
    }
    let mut surface: Vec<[u32; 3]> = faces.into_values().filter(|(_, n)| *n == 1).map(|(f, _)| f).collect();
    surface.sort_unstable();
    let corner_count = rest.len();
    let mut middles: HashMap<(u32, u32), u32> = HashMap::new();
    let mut middle = |a: u32, b: u32, rest: &mut Vec<DVec3>| {
        *middles.entry((a.min(b), a.max(b))).or_insert_with(|| {
            rest.push((rest[a as usize] + rest[b as usize]) / 2.0);
            rest.len() as u32 - 1
        })
    };
    let top = |t: &&[u32; 3], rest: &[DVec3]| t.iter().all(|&n| rest[n as usize].z > -1e-9);
    let flat: Vec<[u32; 3]> = surface.iter().filter(|t| top(t, &rest)).copied().collect();
    let (elements, sensing) = if quadratic {
        let promoted = tets
            .iter()
            .map(|t| {
                let mids = EDGES.map(|(a, b)| middle(t[a], t[b], &mut rest));
                [t[0], t[1], t[2], t[3], mids[0], mids[1], mids[2], mids[3], mids[4], mids[5]]
            })
            .collect();
        let mut fine = Vec::new();
        for [a, b, c] in flat {
            let [ab, bc, ca] = [(a, b), (b, c), (c, a)].map(|(a, b)| middle(a, b, &mut rest));
            fine.extend([[a, ab, ca], [ab, b, bc], [ca, bc, c], [ab, bc, ca]]);
        }
        (Elements::Quadratic(promoted), fine)
    } else {
        (Elements::Linear(tets), flat)
    };
    let bonded = rest.iter().map(|p| p.z < -SIZE.2 + 1e-9).collect();
    PadTopology { rest, corner_count, elements, surface, sensing, bonded }
}

/// Rotation from the pad frame to the hand frame: 0 looks along +x, 1 along -x.
pub fn rotation(side: usize) -> DMat3 {
    let z = if side == 0 { DVec3::X } else { -DVec3::X };
    DMat3::from_cols(DVec3::Y.cross(z), DVec3::Y, z)
}

/// Frame `index` of a ramp that has the sphere `depth` (m) deep in pads that started 20 mm from the middle.
pub fn frame(pads: &[PadTopology], index: usize, depth: f64) -> Frame {
    let travel = 20e-3 - (RADIUS - depth);
    let states = pads.iter().enumerate().map(|(side, pad)| pad_state(pad, side, depth)).collect();
    Frame {
        index,
        applied_force: 15.0 * depth / 1e-3,
        time: 0.0,
        travel: vec![travel; pads.len()],
        object_position: DVec3::new(0.0, 0.0, 0.1),
        object_rotation: DQuat::from_rotation_y(0.1),
        pads: states,
        moving: None,
        energy: -1e-3,
        newton_iterations: 3,
        held: false,
        min_det_f: 0.7,
        min_gap: 2e-5,
        force_balance: 1e-6,
        torque_balance: 1e-7,
        residual: 1e-8,
    }
}

fn pad_state(pad: &PadTopology, side: usize, depth: f64) -> PadFrame {
    let turn = rotation(side);
    let origin = turn.z_axis * -(RADIUS - depth) + DVec3::Z * 0.1;
    let width = (2.0 * RADIUS * depth).max(1e-12);
    let mut state = PadFrame::default();
    for (node, &p) in pad.rest.iter().enumerate() {
        let (bump, height) = ((-(p.x * p.x + p.y * p.y) / width).exp(), 1.0 + p.z / SIZE.2);
        let side_ways = 0.35 * bump * height * (depth / 1e-3) * 1e-1;
        let shift = DVec3::new(side_ways * p.x, side_ways * p.y - 4e-5 * height, -depth * bump * height);
        let on_face = if p.z > -1e-9 { bump } else { 0.0 };
        state.displacement.push(turn * shift);
        state.position.push(origin + turn * (p + shift));
        state.contact_force.push(turn * DVec3::new(0.0, 0.0, -0.05 * on_face));
        state
            .von_mises_node
            .push(PEAK_STRESS * depth / 1e-3 * bump * (0.25 + 0.75 * height) + 10.0 * node as f64 * 1e-3);
    }
    let width = pad.elements.width();
    let mean = |tet: &[u32]| tet.iter().map(|&n| state.von_mises_node[n as usize]).sum::<f64>() / tet.len() as f64;
    state.von_mises_element = pad.elements.nodes().chunks(width).map(mean).collect();
    state.wrench = Wrench { force: state.contact_force.iter().sum(), torque: DVec3::new(0.0, 1e-4, -2e-4) };
    state
}

/// A sphere about the origin.
pub fn sphere(rings: usize, radius: f64) -> TriMesh {
    let (segments, mut mesh) = (2 * rings, TriMesh::default());
    let angle = |i: usize, n: usize| std::f64::consts::PI * i as f64 / n as f64;
    for i in 0..=rings {
        for j in 0..segments {
            let (t, f) = (angle(i, rings), 2.0 * angle(j, segments));
            mesh.vertices.push(radius * DVec3::new(t.sin() * f.cos(), t.sin() * f.sin(), t.cos()));
        }
    }
    for i in 0..rings {
        for j in 0..segments {
            let at = |i: usize, j: usize| (i * segments + j % segments) as u32;
            let (a, b, c, d) = (at(i, j), at(i + 1, j), at(i + 1, j + 1), at(i, j + 1));
            mesh.triangles.extend([[a, b, c], [a, c, d]]);
        }
    }
    mesh
}

/// Two equal pads.
pub fn pads(quadratic: bool) -> Vec<PadTopology> {
    vec![pad([4, 5, 2], quadratic); 2]
}
