//! Time that competing configurations (rivals) take for a given error, interpolated along their Pareto front, because
//! intermediate meshes are possible.

/// Competing configuration with its time and error.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Competitor<'a> {
    /// Name of the rival.
    pub label: &'a str,
    /// Time of a grasp, s.
    pub time: f64,
    /// Error, relative.
    pub error: f64,
}

/// Point of the Pareto front with the requested error.
#[derive(Debug, Clone, PartialEq)]
pub struct FrontPoint {
    /// Time of a grasp, s.
    pub time: f64,
    /// Name of the rival, or of the two between which the point is interpolated.
    pub label: String,
    /// True if even the fastest rival is more accurate than requested; `time` is then an upper bound.
    pub bound: bool,
}

/// Returns the time that `rivals` take for `error`: interpolated linearly in the logarithms of time and error along
/// their Pareto front. None if no rival reaches it.
pub fn time_at(rivals: &[Competitor], error: f64) -> Option<FrontPoint> {
    let mut front: Vec<Competitor> = rivals.iter().copied().filter(|r| r.time > 0.0 && r.error >= 0.0).collect();
    front.sort_by(|a, b| a.time.total_cmp(&b.time).then(a.error.total_cmp(&b.error)));
    let mut least = f64::INFINITY;
    front.retain(|r| {
        let better = r.error < least;
        least = least.min(r.error);
        better
    });
    let next = front.iter().position(|r| r.error <= error)?;
    let (to, from) = (front[next], next.checked_sub(1).map(|k| front[k]));
    match from.filter(|_| to.error < error) {
        None => Some(FrontPoint { time: to.time, label: to.label.into(), bound: to.error < error }),
        Some(from) => {
            let log = |e: f64| e.max(f64::MIN_POSITIVE).ln();
            let part = (log(from.error) - log(error)) / (log(from.error) - log(to.error));
            let time = from.time * (to.time / from.time).powf(part);
            Some(FrontPoint { time, label: format!("between {} and {}", from.label, to.label), bound: false })
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const RIVALS: [Competitor; 4] = [
        Competitor { label: "coarse", time: 1.0, error: 0.16 },
        Competitor { label: "medium", time: 4.0, error: 0.04 },
        // Slower and no better.
        Competitor { label: "dominated", time: 9.0, error: 0.05 },
        Competitor { label: "fine", time: 64.0, error: 0.01 },
    ];

    #[test]
    fn a_rival_in_between_is_in_between() {
        let at = |error| time_at(&RIVALS, error);
        let exact = |label: &str, time| Some(FrontPoint { time, label: label.into(), bound: false });
        assert_eq!(at(0.04), exact("medium", 4.0));
        assert_eq!(at(0.01), exact("fine", 64.0));
        let between = at(0.08).unwrap();
        assert!((between.time - 2.0).abs() < 1e-12, "halfway in both logarithms: {between:?}");
        assert_eq!(between.label, "between coarse and medium");
        let finer = at(0.02).unwrap();
        assert!((finer.time - 16.0).abs() < 1e-12, "halfway from 4 s to 64 s: {finer:?}");
        // A slightly smaller error than that of a mesh does not cost the time of the next finer mesh.
        let hardly = at(0.039).unwrap();
        assert!(hardly.time < 4.3, "{hardly:?}");
    }

    #[test]
    fn beyond_the_front_there_is_a_bound_or_nothing() {
        assert_eq!(time_at(&RIVALS, 0.2), Some(FrontPoint { time: 1.0, label: "coarse".into(), bound: true }));
        assert_eq!(time_at(&RIVALS, 0.009), None);
        assert_eq!(time_at(&[], 0.1), None);
    }
}
