//! Checks of the task of an agent against the rest of the scene.

use crate::leaf::Positive;
use crate::loading::Loading;
use crate::object::ObjectMotion;
use crate::schema::Scene;
use crate::span::Span;
use base::number::format_number;

/// Returns the first invalid value, as field and message.
pub(super) fn problem(scene: &Scene) -> Option<(String, String)> {
    let task = scene.task.as_ref()?;
    let field = |name: &str, message: &str| Some((format!("task{name}"), message.to_string()));
    let random = &task.randomise;
    let spans = [
        (".force", Some(task.force)),
        (".pushes.force", task.pushes.map(|p| p.force)),
        (".randomise.young", random.young),
        (".randomise.friction", random.friction),
        (".randomise.density", random.density),
    ];
    let falls = |s: &Span| s.0[0].get() > s.0[1].get();
    if let Some((name, _)) = spans.iter().find(|(_, s)| s.as_ref().is_some_and(falls)) {
        return field(name, "the first number is the minimum, the second the maximum: (1, 10)");
    }
    let [least, most] = task.force.0.map(Positive::get);
    if !(least..=most).contains(&task.start.get()) {
        return field(
            ".start",
            &format!("must lie within the allowed force, {} to {} N", format_number(least), format_number(most)),
        );
    }
    if task.observe.is_empty() {
        return field(".observe", "the agent has no observations\nleave `observe` out for the default");
    }
    if (1..task.observe.len()).any(|i| task.observe[..i].iter().any(|o| o.name() == task.observe[i].name())) {
        return field(".observe", "two observations have the same name");
    }
    if scene.gravity.is_some() {
        return field(
            ".gravity",
            "gravity of a task is a field of the task, which removes the support gradually\nmove `gravity` into `task`",
        );
    }
    let free = scene.object.motion == ObjectMotion::Free;
    match &scene.loading {
        Loading::Squeeze(_) if free => None,
        Loading::Squeeze(_) => field("", "a task needs a free object\nuse motion: Free"),
        _ => field("", "a task squeezes by force\nuse loading: Squeeze(force: ...)"),
    }
}
