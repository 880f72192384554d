//! Comparisons between more than two variants, panels of pictures with several variants, and counts of impacts.

use crate::made_up::outcome;
use crate::support::{empty, experiment, small, surface};
use diptych::experiment::{AverageFrom, Model, Reference};
use diptych::outcome::Outcome;
use diptych::output::{figures, references};
use diptych::placement::initial_state;
use diptych::study::execute;

fn named(name: &str, model: Model, against: Option<&str>) -> Outcome {
    let mut outcome = outcome(name, model, 3);
    outcome.experiment.against = against.map(|name| Reference::Variant(name.into()));
    outcome
}

#[test]
fn a_variant_is_compared_with_the_one_it_names_or_with_the_first_hard_one() {
    let (soft, hard) = (Model::Soft, Model::Hard);
    let outcomes = [
        named("a", soft, None),
        named("b", hard, None),
        named("c", soft, Some("d")),
        named("d", soft, None),
        named("e", hard, None),
    ];
    assert_eq!(references(&outcomes), [1, 1, 3, 3, 1]);
    assert_eq!(references(&outcomes[..1]), [0]);
    assert_eq!(references(&outcomes[..3]), [1, 1, 2], "its reference is yet to be run");
    assert!(references(&[]).is_empty());
}

#[test]
fn more_variants_than_a_panel_can_tell_apart_are_drawn_by_their_references() {
    let cases = ["case A", "case B", "rough: walls"];
    let pair = |case: &&str| {
        let hard = format!("{case}, hard");
        [named(&hard, Model::Hard, None), named(&format!("{case}, soft"), Model::Soft, Some(&hard))]
    };
    let mut outcomes: Vec<Outcome> = cases.iter().flat_map(pair).collect();
    let names = |outcomes: &[Outcome]| figures::study(outcomes).into_iter().map(|f| f.name).collect::<Vec<_>>();
    assert!(names(&outcomes).contains(&"second-moments".to_owned()), "six fit one panel");
    outcomes.push(named("case B, 300 N/m", Model::Soft, Some("case B, hard")));
    let together = names(&outcomes);
    for moments in ["second-moments-case-a", "second-moments-case-b", "second-moments-rough-walls"] {
        assert!(together.contains(&moments.to_owned()), "{moments} is not among {together:?}");
    }
    let density = figures::study(&outcomes).into_iter().find(|f| f.name == "number-density").unwrap().svg;
    for (text, times) in [("case B", 1), (">300 N/m<", 1), (">soft<", 1), ("case A, hard", 0)] {
        assert_eq!(density.matches(text).count(), times, "{text}");
    }
}

#[test]
fn a_variant_keeps_its_colour_in_the_picture_of_differences() {
    let outcomes = [named("a", Model::Soft, None), named("b", Model::Hard, None), named("c", Model::Soft, None)];
    let svg = figures::differences(&outcomes);
    // first three colours of Okabe and Ito, in the order of their use in pictures
    let used = ["#0072b2", "#d55e00", "#009e73"].map(|colour| svg.to_lowercase().contains(colour));
    assert_eq!(used, [true, false, true], "the reference is not drawn");
}

#[test]
fn impacts_are_those_of_the_averaging_period() {
    let species = small();
    let edge = (200.0 * species.volume() / 0.05).cbrt();
    let scene = empty([edge; 3], [true; 3], species, surface(1.0, 0.0));
    for from in [AverageFrom::Time(0.0), AverageFrom::Time(0.0063), AverageFrom::Steady] {
        let mut experiment = experiment(scene.clone(), 200, [0.0; 3], 0.5, Model::Hard, 4);
        experiment.run.duration = 0.02;
        experiment.run.average_from = from;
        let start = initial_state(&experiment).unwrap();
        let (outcome, _) = execute(&experiment, start, &mut []);
        let averaged = outcome.simulated_seconds - outcome.steadiness.from;
        let expected = outcome.pair_rate.unwrap().value * averaged;
        let counted = outcome.pairs.count as f64;
        assert!(counted > 100.0);
        match from {
            // averages begin at the first sample after the given time
            AverageFrom::Time(_) => {
                let late = outcome.sample_interval * outcome.pair_rate.unwrap().value;
                assert!(counted <= expected + 1e-6 && counted >= expected - late, "{counted} {expected}");
            }
            // the possible starts of averaging are a fortieth of the run apart
            AverageFrom::Steady => {
                let fortieth = 0.02 / 40.0 * outcome.pair_rate.unwrap().value;
                assert!((counted - expected).abs() <= 2.0 * fortieth, "{counted} {expected}");
            }
        }
        let all = outcome.record.pairs.count;
        assert_eq!(
            all == outcome.pairs.count,
            matches!(from, AverageFrom::Time(0.0)) || outcome.steadiness.from == 0.0
        );
    }
}
