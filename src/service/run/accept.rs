//! Whether a certified result is what was asked for.

use crate::engine::pipeline::Target;
use crate::engine::run::Stage;
use crate::service::wire::{Accept, Figures, Problem, ProblemKind, ReportBody, ResolvedSpec};

/// Refuses a result that misses what the spec accepts.
///
/// # Errors
/// The problem `not-acceptable` with the figures of the result.
pub(super) fn judge(report: &ReportBody, spec: &ResolvedSpec) -> Result<(), Problem> {
    let wanted = match spec.spec.target {
        Target::Quads(wanted) => Some(wanted),
        Target::EdgeLength(_) => None,
    };
    let quads = report.quads.count as u64;
    let figures = Figures {
        level: report.level,
        quads,
        wanted,
        count_error: wanted.map(|wanted| (quads as f64 / wanted as f64 - 1.0).abs()),
        distance: report.quads.hausdorff.max,
    };
    let missed = misses(&spec.accept, &figures);
    if missed.is_empty() {
        return Ok(());
    }
    let detail = format!("The result was certified, but {}.", missed.join(", and "));
    Err(Problem {
        figures: Some(Box::new(figures)),
        ..Problem::new(ProblemKind::NotAcceptable, detail).at(Stage::Certify)
    })
}

fn misses(accept: &Accept, figures: &Figures) -> Vec<String> {
    let mut missed = Vec::new();
    if let Some(level) = accept.level.filter(|&level| figures.level > level) {
        missed.push(format!("its level is {}, above {}", figures.level.name(), level.name()));
    }
    // A measure that is no number misses every limit.
    let within = |value: f64, limit: f64| value <= limit;
    if let (Some(limit), Some(error), Some(wanted)) = (accept.count, figures.count_error, figures.wanted)
        && !within(error, limit)
    {
        missed.push(format!("it has {} quads instead of {wanted}, further away than {limit} of these", figures.quads));
    }
    if let Some(limit) = accept.distance.filter(|&limit| !within(figures.distance, limit)) {
        missed.push(format!("it is {} of the diagonal away from the surface, above {limit}", figures.distance));
    }
    missed
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::service::wire::LevelName;

    #[test]
    fn each_limit_is_judged_on_its_own_and_met_exactly_is_met() {
        let figures =
            Figures { level: LevelName::L3, quads: 120, wanted: Some(100), count_error: Some(0.25), distance: 0.5 };
        let met = Accept { level: Some(LevelName::L3), count: Some(0.25), distance: Some(0.5) };
        assert!(misses(&met, &figures).is_empty() && misses(&Accept::default(), &figures).is_empty());
        let missed = Accept { level: Some(LevelName::L2), count: Some(0.125), distance: Some(0.25) };
        assert_eq!(misses(&missed, &figures).len(), 3);
        assert_eq!(misses(&missed, &Figures { distance: f64::NAN, ..figures }).len(), 3);
    }
}
