//! Recordings of the motion of particles, and pages that play them.

use crate::support::{diptych, empty, experiment, small, surface, words};
use diptych::engine::Failure;
use diptych::experiment::Model;
use diptych::observe::{Frames, Observer};
use diptych::placement::initial_state;
use diptych::study::execute;
use std::path::Path;

/// Part of `text` between the first occurrence of `from` and the next occurrence of `to`.
fn between<'a>(text: &'a str, from: &str, to: &str) -> &'a str {
    text.split(from).nth(1).unwrap_or_else(|| panic!("no {from}")).split(to).next().unwrap()
}

fn gas(model: Model, count: usize) -> diptych::Experiment {
    let mut gas =
        experiment(empty([0.01; 3], [true; 3], small(), surface(0.9, 0.0)), count, [5.0, 0.0, 0.0], 0.5, model, 3);
    gas.run.duration = 0.02;
    gas
}

#[test]
fn a_recording_changes_nothing_and_is_bounded() {
    for (model, count) in [(Model::Soft, 600), (Model::Hard, 600), (Model::Soft, 20)] {
        let experiment = gas(model, count);
        let start = || initial_state(&experiment).unwrap();
        let mut frames = Frames::new(&experiment, 3);
        let (seen, _) = execute(&experiment, start(), &mut [&mut frames as &mut dyn Observer]);
        let (alone, _) = execute(&experiment, start(), &mut []);
        assert_eq!(seen.final_state_hash, alone.final_state_hash, "{model:?}");
        // of 600 particles every second one is recorded, because at most 500 are
        assert_eq!(frames.radius.len(), if count == 600 { 300 } else { 20 });
        let recorded = &frames.frames;
        assert!((40..=241).contains(&recorded.len()), "{}", recorded.len());
        assert!(recorded.windows(2).all(|pair| pair[0].time < pair[1].time) && recorded[0].time == 0.0);
        // few particles are recorded up to the end; with many particles in a long run, frames are so close in time that
        // particles fly about a radius between them
        let last = recorded.last().unwrap().time;
        assert!(count == 600 || (last - 0.02).abs() < 1e-9, "{last}");
        for frame in recorded {
            assert_eq!(
                [frame.position.len(), frame.velocity.len(), frame.overlap.len(), frame.solver.len()],
                [frames.radius.len(); 4]
            );
            assert!(frame.position.iter().flatten().all(|x| (0.0..=0.0100001).contains(x)));
        }
        let touching = recorded.iter().flat_map(|frame| &frame.overlap).any(|overlap| *overlap > 0.0);
        assert!(touching == (model == Model::Soft) || count == 20, "{model:?}");
    }
}

#[test]
fn a_recording_goes_on_as_it_was_stored() {
    let experiment = gas(Model::Soft, 30);
    let mut frames = Frames::new(&experiment, 1);
    execute(&experiment, initial_state(&experiment).unwrap(), &mut [&mut frames as &mut dyn Observer]);
    let mut again = Frames::new(&experiment, 1);
    again.restore(&frames.stored().unwrap()).unwrap();
    assert_eq!(again, frames);
}

/// Data of the recording in the page of a report, as JSON.
fn recording(folder: &Path) -> serde_json::Value {
    let page = std::fs::read_to_string(folder.join("report.html")).unwrap();
    assert!(page.len() < 3_000_000, "{} bytes", page.len());
    let data = between(&page, "<script type=\"application/json\">", "</script>");
    assert!(page.contains("diptych.drawScene") && !data.contains('<'));
    serde_json::from_str(data).unwrap()
}

fn assert_complete(data: &serde_json::Value, count: usize, variants: &[&str]) {
    assert_eq!(data["variants"].as_array().map(Vec::len), Some(variants.len()));
    for (variant, name) in data["variants"].as_array().unwrap().iter().zip(variants) {
        let frames = variant["times"].as_array().unwrap().len();
        let overlaps = if variant["deepest"].as_f64() > Some(0.0) { 2 } else { 0 };
        let bytes = frames * count * (6 + 6 + overlaps + 1);
        assert_eq!(variant["data"].as_str().map(str::len), Some(bytes.div_ceil(3) * 4), "{name}");
        assert_eq!(variant["name"], *name);
        assert_eq!(variant["radius"].as_array().map(Vec::len), Some(count));
    }
}

#[test]
fn a_comparison_plays_its_variants_side_by_side() {
    let place = tempfile::tempdir().unwrap();
    let output = diptych(&["compare", "cases/cradle.toml", "--quiet", "--out"]).arg(place.path()).output().unwrap();
    assert_eq!(output.status.code(), Some(0), "{}", words(&output.stderr));
    let data = recording(place.path());
    assert_complete(&data, 5, &["soft", "hard"]);
    let deepest = |place: usize| data["variants"][place]["deepest"].as_f64().unwrap();
    // at first, two springs share half of the relative speed: the overlap is about v sqrt(M/k) of a pair
    assert!(deepest(0) > 1e-6 && deepest(0) < 1e-5 && deepest(1) < 1e-12, "{} {}", deepest(0), deepest(1));
    let page = std::fs::read_to_string(place.path().join("report.html")).unwrap();
    assert_eq!(page.matches("<figure class=\"panel\">").count(), 2, "a still picture each");
}

#[test]
fn an_impact_plays_in_slow_motion() {
    let place = tempfile::tempdir().unwrap();
    let output = diptych(&["impact", "--quiet", "--out"]).arg(place.path()).output().unwrap();
    assert_eq!(output.status.code(), Some(0), "{}", words(&output.stderr));
    let data = recording(place.path());
    assert_complete(&data, 2, &["hard", "soft, k = 3000 N/m", "soft, k = 300 N/m"]);
    // the overlaps in the heading of the case, for a diameter of 406 um
    for (place, share) in [(1, 0.0058), (2, 0.018)] {
        let deepest = data["variants"][place]["deepest"].as_f64().unwrap();
        assert!((deepest / 406e-6 / share - 1.0).abs() < 0.05, "{deepest}");
    }
}

/// A variant that stopped is reported as stopped, and is not called cheaper because of its short run.
#[test]
fn what_stopped_is_not_ranked() {
    let mut outcomes = crate::made_up::outcomes();
    for outcome in &mut outcomes {
        outcome.timing.wall_seconds = 10.0;
    }
    outcomes[2].failure = Some(Failure::Escaped { time: 0.1, particle: 7, x: 0.1, y: -0.2, z: 0.3 });
    outcomes[2].timing.wall_seconds = 0.5;
    let folder = tempfile::tempdir().unwrap();
    let folder = diptych::output::Folder::create(folder.path().join("out"), false).unwrap();
    crate::made_up::write(&folder, &outcomes);
    let cost = std::fs::read_to_string(folder.path().join("figures/cost.svg")).unwrap();
    assert!(cost.contains("not ranked") && cost.matches(" ×").count() == 2 && cost.contains(">1.0 ×"), "{cost}");
}

/// The recorded spin of a ball that slides until it rolls approaches u/R, the value of rolling (speed u, radius R).
#[test]
fn spins_are_recorded_where_spheres_rotate() {
    let folder = tempfile::tempdir().unwrap();
    let out = folder.path().join("out");
    let case = ["compare", "cases/rotation/slide-to-roll.toml", "--out", out.to_str().unwrap()];
    let output = diptych(&case).output().unwrap();
    let page = std::fs::read_to_string(out.join("report.html")).unwrap_or_else(|_| panic!("{}", words(&output.stderr)));
    let data: serde_json::Value =
        serde_json::from_str(between(&page, "<script type=\"application/json\">", "</script>")).unwrap();
    let variants = data["variants"].as_array().unwrap();
    let spin = |place: usize| variants[place]["swiftest"].as_f64().unwrap();
    // the final spin is 5/7 of 0.1 m/s over the radius of 0.5 mm; spring and weight cause oscillations of a few per
    // cent
    assert!((spin(0) / 142.86 - 1.0).abs() < 0.05 && (spin(1) / 142.86 - 1.0).abs() < 0.05, "{} {}", spin(0), spin(1));
    assert_eq!((variants[2]["name"].as_str(), spin(2)), (Some("soft, no rotation"), 0.0));
    for variant in variants {
        let frames = variant["times"].as_array().unwrap().len();
        let parts = ["deepest", "swiftest"].map(|most| usize::from(variant[most].as_f64() > Some(0.0)));
        let bytes = frames * (6 + 6 + 2 * parts[0] + 2 * parts[1] + 1);
        let text = variant["data"].as_str().unwrap();
        assert_eq!(text.len(), bytes.div_ceil(3) * 4, "{}", variant["name"]);
    }
}
