//! Where a feature of the object meets a pad.

use super::flanks::{Flank, Last};
use super::surface::ContactSurface;
use crate::mech::potential::state::View;
use crate::mech::potential::term::Stencil;
use glam::DVec3;

/// Where a feature is on the object, and what it presses on.
#[derive(Debug, Clone)]
pub(crate) struct Site {
    /// Position of the feature in the object frame, m.
    pub position: DVec3,
    /// How often it has moved along its edge since the last accepted state.
    pub moves: u32,
    /// Few features are near a pad: the others are copied with every state at no cost.
    pub touch: Option<Box<Touch>>,
}

/// Where a feature meets the pad now, and where it sticks.
#[derive(Debug, Clone)]
pub(crate) struct Touch {
    /// The faces it presses on, the nearest first.
    pub flanks: Vec<Flank>,
    /// Where the nearest is touched.
    pub now: Stencil,
    /// Where it sticks.
    pub stick: Stencil,
    /// Nodes that share the force for reporting.
    pub report: Stencil,
}

impl Site {
    /// Of a feature at `position` (object frame, m) that is nowhere near.
    pub fn new(position: DVec3) -> Self {
        Self { position, moves: 0, touch: None }
    }

    /// The faces it presses on, the nearest first.
    pub fn flanks(&self) -> &[Flank] {
        self.touch.as_ref().map_or(&[], |touch| &touch.flanks)
    }

    /// What it pressed on at the last assembly.
    pub fn last(&self, stays: bool) -> Option<Last> {
        let folded = self.flanks().len() > 1;
        self.flanks().first().map(|(foot, ..)| Last { face: foot.face, carried: foot.carried, folded, stays })
    }

    /// It presses on `flanks` of `surface` now.
    pub fn press(&mut self, flanks: Vec<Flank>, surface: &ContactSurface) {
        let Some((foot, ..)) = flanks.first() else {
            self.touch.iter_mut().for_each(|touch| touch.flanks.clear());
            return;
        };
        let face = &surface.faces[foot.face];
        let (now, report) = (face.stencil(foot.l), face.report_stencil(foot.l));
        let fresh = || Box::new(Touch { flanks: Vec::new(), now, stick: now, report });
        let touch = self.touch.get_or_insert_with(fresh);
        (touch.flanks, touch.now, touch.report) = (flanks, now, report);
    }

    /// Where the feature is under `view`, m, relative to the finger.
    pub fn place(&self, view: &View) -> DVec3 {
        view.position + view.rotation * self.position - view.offset
    }
}
