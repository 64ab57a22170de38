//! Checks of the shape of the object.

use super::problem::{Problem, problem_at};
use crate::object::{ObjectShape, Revolve};
use base::number::format_number;

/// Checks the dimensions of a shape against each other.
pub(super) fn shape(shape: &ObjectShape) -> Result<(), Problem> {
    let rounding = |edge: f64, most: f64| {
        if edge <= most {
            return Ok(());
        }
        problem_at(
            "object.shape.edge_radius",
            format!(
                "edge radius {} m is too large\nallowed here: at most {}",
                format_number(edge),
                format_number(most)
            ),
        )
    };
    match shape {
        ObjectShape::Cuboid(c) => rounding(c.edge_radius.get(), c.size.size().min_element() / 2.0),
        ObjectShape::Annulus(a) if a.inner.get() >= a.outer.get() => problem_at(
            "object.shape.inner",
            format!(
                "the hole ({} m) must be narrower than outer ({} m)",
                format_number(a.inner.get()),
                format_number(a.outer.get())
            ),
        ),
        ObjectShape::Cup(c) if c.wall.get() >= c.radius.get().min(c.height.get()) => problem_at(
            "object.shape.wall",
            format!("wall {} m leaves no cavity\nallowed: below radius and height", format_number(c.wall.get())),
        ),
        ObjectShape::Banana(b) if !(1.0..=170.0).contains(&b.bend_deg.get()) => problem_at(
            "object.shape.bend_deg",
            format!("a banana bends by 1 to 170 degrees, found {}", format_number(b.bend_deg.get())),
        ),
        ObjectShape::Potato(p) if p.roughness.get() > 0.3 => problem_at(
            "object.shape.roughness",
            format!("roughness must be at most 0.3, found {}", format_number(p.roughness.get())),
        ),
        ObjectShape::Revolve(r) => profile(r),
        ObjectShape::Sweep(s) => {
            if s.path.len() < 2 {
                return problem_at("object.shape.path", "a sweep needs at least two points");
            }
            if s.radii.len() != 1 && s.radii.len() != s.path.len() {
                let message = format!(
                    "{} radii for {} points\nallowed: one radius for all, or one per point",
                    s.radii.len(),
                    s.path.len()
                );
                return problem_at("object.shape.radii", message);
            }
            Ok(())
        }
        _ => Ok(()),
    }
}

fn profile(r: &Revolve) -> Result<(), Problem> {
    let (last, fewest) = (r.profile.len().saturating_sub(1), if r.closed { 3 } else { 2 });
    if r.profile.len() < fewest {
        return problem_at(
            "object.shape.profile",
            format!("a profile of points (r, z) needs at least {fewest} of them"),
        );
    }
    for (i, p) in r.profile.iter().enumerate() {
        let (radius, end) = (p.pair()[0], !r.closed && (i == 0 || i == last));
        let wanted = match () {
            () if end && radius != 0.0 => "a profile starts and ends on the axis: r = 0",
            () if !end && radius <= 0.0 => "a profile stays off the axis between its ends: r > 0",
            () => continue,
        };
        let message = format!(
            "{wanted}, found ({}, {})\na ring is a loop of points off the axis with closed: true",
            format_number(radius),
            format_number(p.pair()[1])
        );
        return problem_at(format!("object.shape.profile[{i}]"), message);
    }
    Ok(())
}
