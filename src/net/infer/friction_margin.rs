//! Friction margin of the pads on the object, from the predicted pressure.

use super::contact_correction::object_pose;
use super::predict::Predictor;
use super::predicted_state::GraspState;
use crate::linear_response::GraspLoad;
use crate::linear_response::first_contact::GeometricContact;
use crate::linear_response::limit_surface::LimitSurface;
use crate::network::slip_interval::{FrictionMargin, SlipIndicators};
use geometry::Wrench;
use glam::DVec3;
use model::Model;

/// Largest value of an indicator.
const MOST: f64 = 3.0;

/// Returns true if weight or a push acts on the object of a grasp with first contact `touch`.
pub fn carries_load(touch: &GeometricContact, load: &GraspLoad) -> bool {
    touch.weight != DVec3::ZERO || load.push != Wrench::ZERO
}

/// Load on an object between pads.
pub(crate) struct SlipLoad {
    /// Fraction of the load that the limit surface of the pressure holds.
    pub used: f64,
    /// Indicators of the load at which the object slips.
    pub indicators: SlipIndicators,
}

impl SlipLoad {
    /// Computes the load in a state of a grasp of `model` with first contact `touch`; None without a load, and for an
    /// object that is fixed or supported.
    pub fn of(model: &Model, touch: &GeometricContact, state: &GraspState, load: &GraspLoad) -> Option<Self> {
        // Until its release, an object is carried by its support.
        if !model.free || state.held || !carries_load(touch, load) {
            return None;
        }
        let closing = model.fingers.first()?.placement.closing;
        let pads: Vec<Vec<(f64, DVec3)>> = (model.fingers.iter().zip(&state.pads).zip(&touch.travel))
            .map(|((finger, pad), first)| {
                let carried = finger.placement.closing * (first + pad.travel);
                let nodes = finger.topology.rest.iter().zip(&pad.displacement).zip(&pad.contact);
                let press = nodes.map(|((x, u), f)| ((-f.z).max(0.0), finger.placement.place(*x + *u) + carried));
                press.filter(|(force, _)| *force > 0.0).collect()
            })
            .collect();
        let surface = LimitSurface::new(closing, pads.iter().flatten().copied());
        let object = object_pose(model, touch, &state.pads);
        let mass = object.position + object.rotation * model.object.mass.center;
        let used = surface.used(model.friction, touch.weight + load.push.force, mass, load.push.torque);
        let centers: Vec<DVec3> =
            pads.iter().map(|pad| LimitSurface::new(closing, pad.iter().copied()).center()).collect();
        let apart = centers.iter().map(|c| (*c - surface.center()).reject_from(closing).length()).fold(0.0, f64::max);
        let t = model.thickness();
        let travel = state.pads.iter().map(|pad| pad.travel).sum::<f64>() / state.pads.len() as f64;
        let ratio = |value: f64, by: f64| (value / by.max(f64::MIN_POSITIVE)).min(MOST);
        let indicators = [
            1.0,
            used.twist,
            ratio(used.tilt, used.whole),
            (travel / t).clamp(1e-3, 1.0).ln(),
            (surface.radius() / t).clamp(1e-2, 1e2).ln(),
            model.friction.min(MOST),
            ratio(load.force, model.material.moduli().young * t * t),
            ratio(apart, surface.radius()),
        ];
        Some(Self { used: used.whole, indicators })
    }

    /// Returns the remaining fraction of the load at which the object slips.
    pub fn margin(&self, predictor: &Predictor) -> FrictionMargin {
        let Self { used, indicators } = self;
        predictor.card.slip.map_or_else(|| FrictionMargin::of_limit(*used), |slip| slip.margin(indicators, *used))
    }
}

impl Predictor {
    /// Returns the remaining fraction of the load at which the object slips, under weight and push, in a state of a
    /// grasp of `model` with first contact `touch`; [`FrictionMargin::WHOLE`] without these loads, and for an object
    /// that is fixed or supported. Without a fit to grasps that slipped it is that of the limit surface.
    pub fn friction_margin(
        &self,
        model: &Model,
        touch: &GeometricContact,
        state: &GraspState,
        load: &GraspLoad,
    ) -> FrictionMargin {
        SlipLoad::of(model, touch, state, load).map_or(FrictionMargin::WHOLE, |load| load.margin(self))
    }
}

/// Returns why a grasp with this margin is dropped; None if it is not.
pub fn slip_reason(margin: &FrictionMargin) -> Option<String> {
    let part = 100.0 * (1.0 - margin.expected);
    (margin.expected < 0.0).then(|| format!("the object slips: weight and push are {part:.0} % of what friction holds"))
}
