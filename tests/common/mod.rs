//! Shared by the tests of the mechanics: random numbers, reference files, norms, presses on one pad.
#![allow(dead_code, reason = "every test binary uses its own part")]

use glam::{DMat3, DQuat, DVec3};
use std::path::PathBuf;
use std::sync::{Arc, Mutex};
use tactus::contact::{Contact, ContactSurface, law::Law};
use tactus::error::Result;
use tactus::fem::body::{Body, Elements};
use tactus::fem::continuation::Whole;
use tactus::fem::newton::{Newton, Tolerance};
use tactus::fem::path::{Load, Path};
use tactus::fem::state::{Border, State};
use tactus::fem::term::{BodyTerm, Elastic};
use tactus::mesh::{TetMesh, quadratic};
use tactus::pad::Pad;
use tactus::record::Frame;
use tactus::runner::Observer;
use tactus::shape::SignedDistance;

/// A reproducible stream of numbers (splitmix64).
pub struct Random(pub u64);

impl Random {
    /// Uniform in [-1, 1).
    pub fn number(&mut self) -> f64 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mut z = self.0;
        z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        ((z ^ (z >> 31)) >> 11) as f64 / (1u64 << 52) as f64 - 1.0
    }

    /// Uniform in the cube [-1, 1)^3.
    pub fn vector(&mut self) -> DVec3 {
        DVec3::new(self.number(), self.number(), self.number())
    }

    /// Entries uniform in [-1, 1).
    pub fn matrix(&mut self) -> DMat3 {
        DMat3::from_cols(self.vector(), self.vector(), self.vector())
    }

    /// Uniformly scattered axis, any angle.
    pub fn rotation(&mut self) -> DQuat {
        DQuat::from_scaled_axis(self.vector() * 2.0)
    }
}

/// Keeps all frames of a run.
#[derive(Default)]
pub struct Keep(pub Mutex<Vec<Frame>>);

impl Observer for Keep {
    fn frame(&self, _: usize, frame: &Frame) -> Result<()> {
        self.0.lock().unwrap().push(frame.clone());
        Ok(())
    }
}

/// Path of a reference file; None, and a word about it, where the reference data are not there.
pub fn reference(name: &str) -> Option<PathBuf> {
    let path = PathBuf::from(concat!(env!("CARGO_MANIFEST_DIR"), "/../shared/reference")).join(name);
    if path.exists() {
        return Some(path);
    }
    eprintln!("skipped: {} is not there", path.display());
    None
}

/// Rows of numbers of a reference file, comments left out.
pub fn rows(name: &str) -> Option<Vec<Vec<f64>>> {
    let text = std::fs::read_to_string(reference(name)?).expect("reference file");
    let number = |w: &str| w.parse::<f64>().expect("number");
    let split = |l: &str| l.split([' ', ',']).filter(|w| !w.is_empty()).map(number).collect();
    Some(text.lines().filter(|l| !l.starts_with('#')).map(split).collect())
}

/// Rows of a reference file as vectors, scaled.
pub fn vectors(name: &str, scale: f64) -> Option<Vec<DVec3>> {
    Some(rows(name)?.iter().map(|r| DVec3::new(r[0], r[1], r[2]) * scale).collect())
}

/// A reference mesh in the units of its files, mm.
pub fn reference_mesh(name: &str) -> Option<TetMesh> {
    let nodes = vectors(&format!("{name}.nodes.txt"), 1.0)?;
    let tets = rows(&format!("{name}.tets.txt"))?;
    Some(TetMesh { nodes, tets: tets.iter().map(|r| std::array::from_fn(|k| r[k] as u32)).collect() })
}

/// Norm of the difference over the norm of `truth`, and the largest difference over the largest vector of `truth`.
pub fn errors(ours: &[DVec3], truth: &[DVec3]) -> (f64, f64) {
    assert_eq!(ours.len(), truth.len());
    let norm = |v: &mut dyn Iterator<Item = DVec3>| v.map(|d| d.length_squared()).sum::<f64>().sqrt();
    let largest = |v: &mut dyn Iterator<Item = DVec3>| v.map(|d| d.length()).fold(0.0, f64::max);
    let difference = || ours.iter().zip(truth).map(|(a, b)| *a - *b);
    (
        norm(&mut difference()) / norm(&mut truth.iter().copied()),
        largest(&mut difference()) / largest(&mut truth.iter().copied()),
    )
}

/// `|a - b| <= tolerance |b|`, or a panic that says what was measured.
#[track_caller]
pub fn close(what: &str, measured: f64, expected: f64, relative: f64) {
    let error = (measured - expected) / expected;
    assert!(error.abs() <= relative, "{what}: {measured} against {expected}, {:.3e} off, allowed {relative:e}", error);
}

/// Nodes and elements of the given order.
pub fn elements(mesh: &TetMesh, quadratic: bool) -> (Vec<DVec3>, Elements) {
    if quadratic {
        let m = quadratic::promote(mesh);
        (m.nodes, Elements::Quadratic(m.tets))
    } else {
        (mesh.nodes.clone(), Elements::Linear(mesh.tets.clone()))
    }
}

/// A pad with its back face fixed (the middles of bonded edges too, as they lie on it), and a rigid object above it
/// that is pressed down along the pad's axis by a prescribed depth, counted from where the contact offset touches.
pub struct Press {
    pub path: Path,
}

/// How a press is set up.
pub struct Setup {
    /// Discretised pad, m, outward normal +z.
    pub body: Arc<Body>,
    pub object: Arc<dyn SignedDistance>,
    /// Where the object's origin is when its surface just touches the pad, m.
    pub start: DVec3,
    /// Coulomb coefficient.
    pub friction: f64,
}

/// A body of a generated pad with its bonded face fixed.
pub fn pad_body(pad: &Pad, quadratic: bool, material: Arc<dyn tactus::material::Material>) -> Arc<Body> {
    let (nodes, elements) = elements(&pad.mesh, quadratic);
    let back = pad.mesh.nodes.iter().map(|p| p.z).fold(f64::INFINITY, f64::min);
    let fixed = nodes.iter().map(|p| p.z < back + 1e-9).collect();
    Arc::new(Body::new(nodes, elements, fixed, material, true))
}

/// Gap at which surfaces meet in tests, m: that of pads 4 mm thick.
pub const OFFSET: f64 = 1e-5;

impl Press {
    /// With the contact law of the solver.
    pub fn new(setup: Setup) -> Self {
        let surface = Arc::new(ContactSurface::new(&setup.body));
        let law = Law::new(setup.body.material.moduli().young, surface.spacing, setup.friction, OFFSET);
        Self::with_law(setup, law, surface)
    }

    pub fn with_law(setup: Setup, law: Law, surface: Arc<ContactSurface>) -> Self {
        let contact = Contact::new(law, surface, setup.object);
        let terms: Vec<Box<dyn BodyTerm>> = vec![Box::new(Elastic), Box::new(contact)];
        let x = setup.body.rest.clone();
        let newton =
            Newton::new(vec![setup.body], vec![terms], Border::new(vec![DVec3::Z], false, false, 1.0)).expect("solver");
        let position = setup.start + DVec3::Z * law.offset;
        let state = State { x: vec![x], travel: vec![0.0], position, rotation: DQuat::IDENTITY };
        let tolerance = Tolerance {
            relative: 1e-5,
            force: 1e-7,
            length: 1e-6,
            iterations: 60,
            motion: 1e-3,
            passing: false,
            offset: law.offset,
        };
        Self { path: Path::new(newton, state, tolerance) }
    }

    /// Presses on to a depth, m, in `steps` equal increments (more where one does not converge); the normal force, N.
    pub fn to(&mut self, depth: f64, steps: u32) -> f64 {
        let from = self.path.level;
        for k in 1..=steps {
            let next = from + (depth - from) * f64::from(k) / f64::from(steps);
            self.path.advance(Load::Travel, next, &mut Whole).expect("the press converges");
        }
        let contact = self.contact();
        -contact.edges().map(|(i, _)| contact.force(i).z).sum::<f64>()
    }

    pub fn contact(&self) -> &Contact {
        self.path.newton.terms[0][1].as_any().downcast_ref().expect("contact term")
    }

    pub fn body(&self) -> &Body {
        self.path.newton.body(0)
    }

    /// Displacements of all nodes, m.
    pub fn displacement(&self) -> Vec<DVec3> {
        self.path.state.x[0].iter().zip(&self.body().rest).map(|(x, r)| *x - *r).collect()
    }
}
