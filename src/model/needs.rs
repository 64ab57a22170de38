//! Requirements of a scene: nothing is spawned, computed or solved for unless the scene requires it.

use scene::{Expectation, Field, Fingers, Loading, ObjectMotion, Observe, Scene};
use serde::Serialize;

/// Optional parts of the world, present only if the scene requires them.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
pub struct Needs {
    /// Von Mises stress per node and tetrahedron: recorded, or bounded by an expected result.
    pub stress: bool,
    /// Contact force per node: recorded.
    pub contact_force: bool,
    /// Sliding fraction of the contact force per node: observed.
    pub slip: bool,
    /// Contact area of each pad: observed.
    pub contact_area: bool,
    /// Tactile arrays in the frames: recorded.
    pub tactile: bool,
    /// Distance to the object per node: recorded.
    pub gap: bool,
    /// Friction state per contact edge: the friction coefficient is above zero.
    pub friction: bool,
    /// Weight of the gel and of a free object: gravity is set.
    pub gravity: bool,
    /// Smallest det F and gap of a network's prediction: reported by a run.
    pub shape: bool,
    /// Displacement that a network predicts below the sensing faces: recorded by a run.
    pub interior: bool,
    /// Independent audit of every frame: an expected result requires it.
    pub audit: bool,
    /// Velocities, pose of the hand and time: the loading is dynamic.
    pub dynamic: bool,
    /// Contact of the object with the ground: the scene has a ground.
    pub ground: bool,
    /// Check that the pads do not touch each other next to the object: there are two pads.
    pub pads_apart: bool,
    /// External load on the object, set step by step: an agent acts in the world.
    pub task: bool,
    /// Variable pose of the object: the object is free.
    pub free_object: bool,
}

impl Needs {
    /// Returns the requirements of `scene`.
    pub fn from_scene(scene: &Scene) -> Self {
        let expectations = scene.expectations();
        let recorded = |field: Field| scene.record.fields.contains(&field);
        let mut needs = Self {
            stress: recorded(Field::Stress) || expectations.iter().any(|e| matches!(e, Expectation::MaxStress(_))),
            contact_force: recorded(Field::ContactForce),
            gap: recorded(Field::Gap),
            friction: [0, 1].iter().any(|side| scene.gripper.with_equal_fingers(*side).friction.get() > 0.0),
            gravity: scene.gravity.is_some_and(|g| g.dvec3() != glam::DVec3::ZERO),
            tactile: !scene.record.tactile.is_empty(),
            slip: false,
            shape: true,
            interior: true,
            contact_area: false,
            pads_apart: scene.gripper.fingers == Fingers::Both,
            audit: expectations.iter().any(Expectation::needs_audit),
            dynamic: matches!(scene.loading, Loading::Dynamic(_)),
            ground: scene.ground.is_some(),
            task: false,
            free_object: scene.object.motion == ObjectMotion::Free,
        };
        needs.observe(&scene.record.tactile);
        needs
    }

    /// Adds the quantities from which these observations are computed.
    pub fn observe(&mut self, observed: &[Observe]) {
        use Observe::{CenterOfPressure, ContactArea, Pressure, Shear, Slip, TaxelForce};
        let any = |made_of: fn(&Observe) -> bool| observed.iter().any(made_of);
        self.slip |= any(|o| matches!(o, Slip(_)));
        self.contact_area |= any(|o| matches!(o, ContactArea));
        self.contact_force |= self.slip || self.contact_area;
        self.contact_force |= any(|o| matches!(o, TaxelForce(_) | Pressure(_) | Shear(_) | CenterOfPressure));
    }
}
