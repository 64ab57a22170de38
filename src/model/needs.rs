//! Needs of a scene in its world: nothing is spawned, computed or solved for without a request.

use crate::scene::{Expectation, Field, Fingers, Loading, ObjectMotion, Observe, Scene};
use serde::Serialize;

/// Parts of the world that are there only if the scene asks for them.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
pub struct Needs {
    /// Von Mises stress per node and tetrahedron: recorded, or a bound on it is expected.
    pub stress: bool,
    /// Contact force per node: recorded.
    pub contact_force: bool,
    /// Part of the contact force per node that slides: observed.
    pub slip: bool,
    /// Area of each pad that touches: observed.
    pub contact_area: bool,
    /// Arrays of tactile sensors in the frames: recorded.
    pub tactile: bool,
    /// Distance to the object per node: recorded.
    pub gap: bool,
    /// Friction state per contact edge: Coulomb's coefficient is above zero.
    pub friction: bool,
    /// Weight of the gel and of a free object: gravity is set.
    pub gravity: bool,
    /// Smallest det F and gap of a prediction: reported by a run.
    pub shape: bool,
    /// An independent judge of every frame: the scene promises something that it judges.
    pub audit: bool,
    /// Velocities, the pose of the hand and time: the loading is dynamic.
    pub dynamic: bool,
    /// Contact of the object with its support: there is a ground.
    pub ground: bool,
    /// Refusal of pads that meet beside the object: there are two pads.
    pub pads_apart: bool,
    /// A load on the object that is given from outside, step by step: an agent acts in the world.
    pub task: bool,
    /// A pose that changes: the object is free.
    pub free_object: bool,
}

impl Needs {
    /// Returns the needs of `scene`.
    pub fn of(scene: &Scene) -> Self {
        let promises = scene.promises();
        let recorded = |field: Field| scene.record.fields.contains(&field);
        let mut needs = Self {
            stress: recorded(Field::Stress) || promises.iter().any(|e| matches!(e, Expectation::MaxStress(_))),
            contact_force: recorded(Field::ContactForce),
            gap: recorded(Field::Gap),
            friction: [0, 1].iter().any(|side| scene.gripper.like(*side).friction.get() > 0.0),
            gravity: scene.gravity.is_some_and(|g| g.dvec3() != glam::DVec3::ZERO),
            tactile: !scene.record.tactile.is_empty(),
            slip: false,
            shape: true,
            contact_area: false,
            pads_apart: scene.gripper.fingers == Fingers::Both,
            audit: promises.iter().any(Expectation::audited),
            dynamic: matches!(scene.loading, Loading::Dynamic(_)),
            ground: scene.ground.is_some(),
            task: false,
            free_object: scene.object.motion == ObjectMotion::Free,
        };
        needs.observe(&scene.record.tactile);
        needs
    }

    /// Adds what these observations are made of.
    pub fn observe(&mut self, observed: &[Observe]) {
        use Observe::{CenterOfPressure, ContactArea, Pressure, Shear, Slip, TaxelForce};
        let any = |made_of: fn(&Observe) -> bool| observed.iter().any(made_of);
        self.slip |= any(|o| matches!(o, Slip(_)));
        self.contact_area |= any(|o| matches!(o, ContactArea));
        self.contact_force |= self.slip || self.contact_area;
        self.contact_force |= any(|o| matches!(o, TaxelForce(_) | Pressure(_) | Shear(_) | CenterOfPressure));
    }
}
