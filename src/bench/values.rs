//! Scalar values of a frame that are independent of its mesh, for the table of references.

use super::quantity::QuantityName;
use glam::DVec3;
use model::Model;
use model::part::FingerModel;
use record::error_norm::{FieldInterpolation, Points};
use record::{Frame, PadFrame};
use std::collections::BTreeMap;

/// Values by name; the name ends with the unit.
pub type FrameValues = BTreeMap<QuantityName, f64>;

/// Returns the values of a frame over all pads; those of fields that are not recorded are omitted.
pub fn values(model: &Model, frame: &Frame) -> FrameValues {
    let mut values = FrameValues::new();
    let mut put = |name: &'static str, value: f64| {
        values.insert(QuantityName::from(name), value);
    };
    let pads = || model.fingers.iter().zip(&frame.pads);
    let mean = |sum: f64| sum / frame.pads.len().max(1) as f64;
    put("force_n", pads().map(|(finger, pad)| pad.wrench.force.dot(finger.placement.closing).abs()).sum());
    put("travel_m", mean(frame.travel.iter().sum()));
    let lengths = frame.pads.iter().flat_map(|p| &p.displacement).map(|u| u.length());
    put("displacement_max_m", lengths.fold(0.0, f64::max));
    if let Some(finger) = model.fingers.first() {
        let points = Points::of(&finger.topology);
        let fields = FieldInterpolation::new(&points, &finger.topology).fields(frame);
        let volume: f64 = points.volume.iter().sum::<f64>() * frame.pads.len() as f64;
        let over = |values: &mut dyn Iterator<Item = f64>| {
            values.zip(points.volume.iter().cycle()).map(|(v, w)| v * w).sum::<f64>() / volume
        };
        put("displacement_rms_m", over(&mut fields.displacement.iter().map(|u| u.length_squared())).sqrt());
        if !fields.stress.is_empty() {
            put("stress_mean_pa", over(&mut fields.stress.iter().copied()));
        }
    }
    let radii: Option<Vec<f64>> = pads().map(|(finger, pad)| patch_radius(finger, pad)).collect();
    if let Some(radii) = radii.filter(|r| !r.is_empty()) {
        put("patch_radius_m", mean(radii.iter().sum()));
    }
    values
}

/// Returns the root-mean-square distance of the normal contact force of a pad from its centre, m; None if forces are
/// not recorded or zero. For Hertz contact with a sphere it is 0.63 of the patch radius; unlike that radius it is an
/// integral, and therefore hardly depends on the mesh.
fn patch_radius(finger: &FingerModel, pad: &PadFrame) -> Option<f64> {
    let closing = finger.placement.closing;
    let pressing: Vec<(f64, DVec3)> =
        pad.contact_force.iter().zip(&pad.position).map(|(f, x)| ((-f.dot(closing)).max(0.0), *x)).collect();
    let whole: f64 = pressing.iter().map(|(f, _)| f).sum();
    let centre = pressing.iter().map(|(f, x)| *x * *f).sum::<DVec3>() / whole;
    let square = |x: DVec3| (x - centre).reject_from_normalized(closing).length_squared();
    (whole > 0.0).then(|| (pressing.iter().map(|(f, x)| f * square(*x)).sum::<f64>() / whole).sqrt())
}
