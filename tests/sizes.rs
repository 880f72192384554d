//! The computing time for large inputs must be proportional to their size, not to the square of their size.
//!
//! Times depend on the machine, so that the limits are wide. On the machine of the authors, the tests take about a
//! twentieth of the limit. Work proportional to the square of the size would take about twenty times the limit.

use crate::support::{BASE, diptych, words};
use diptych::case::Case;
use diptych::particles::Particles;
use diptych::statistics::{Accumulator, NUMBER_DENSITY};
use nalgebra::Vector3;
use std::path::Path;
use std::sync::Arc;
use std::time::{Duration, Instant};

fn base() -> String {
    std::fs::read_to_string(Path::new(env!("CARGO_MANIFEST_DIR")).join(BASE)).unwrap()
}

#[track_caller]
fn within(seconds: u64, what: impl FnOnce()) {
    let began = Instant::now();
    what();
    assert!(began.elapsed() < Duration::from_secs(seconds), "it took {:?}", began.elapsed());
}

#[test]
fn many_variants() {
    let variants = (0..8000).map(|k| {
        let model = ["soft", "hard"][k % 2];
        format!(
            "[[compare]]\nname = \"{k}\"\nmodel = \"{model}\"\nset = {{ \"run.duration\" = \"{} s\" }}\n",
            1 + k % 7
        )
    });
    let text = base() + &variants.collect::<String>();
    let case = Case::from_text(Path::new("many.toml"), Arc::from(text), &["run.seed=3".into()]).unwrap();
    // this takes 0.4 s; with the list of variants inside each variant it would take 90 s
    within(10, || {
        let variants = case.variants(None).unwrap();
        assert_eq!(variants.len(), 8000);
        assert!(variants.iter().all(|(one, _)| one.run.seed == 3 && one.name.parse::<f64>().unwrap() < 8000.0));
        assert_eq!(variants[13].0.run.duration, 7.0);
    });
}

#[test]
fn a_change_of_the_list_of_variants_still_counts() {
    let text = base() + "[[compare]]\nname = \"a\"\nmodel = \"soft\"\n[[compare]]\nname = \"b\"\nmodel = \"hard\"\n";
    let sets = ["compare[1].name=c".to_owned(), "run.seed=5".to_owned()];
    let case = Case::from_text(Path::new("two.toml"), Arc::from(text), &sets).unwrap();
    let names: Vec<String> = case.variants(None).unwrap().into_iter().map(|(one, _)| one.name).collect();
    assert_eq!(names, ["a", "c"]);
}

#[test]
fn many_slices() {
    let mut particles = Particles::default();
    for k in 0..100 {
        let x = f64::from(k) / 100.0;
        particles.push(Vector3::new(0.0, x, 0.0), Vector3::new(x, 1.0 - x, x * x), 1e-3, 1.0, 0);
    }
    let table = |slices: usize| {
        let mut accumulator = Accumulator::new(slices, 1.0);
        for time in 0..40 {
            accumulator.sample(f64::from(time), &particles);
        }
        let began = Instant::now();
        let table = accumulator.table(0.0);
        (table, began.elapsed().as_secs_f64())
    };
    let (whole, _) = table(100_000);
    assert_eq!(whole.slices.len(), 100_000);
    assert_eq!(whole.slices.iter().map(|row| row.samples).sum::<u64>(), 4000);
    let density: f64 = whole.slices.iter().map(|row| row.of(NUMBER_DENSITY).unwrap().value).sum();
    assert!((density / 1e5 - 1.0).abs() < 1e-9, "{density}");
    // A hundred times as many slices must take about a hundred times the time. If each row counted all samples again, it
    // would be ten thousand times. The shortest of three times is used, and caches and other programs on the machine may
    // cost a factor of ten.
    let least = |slices: usize| (0..3).map(|_| table(slices).1).fold(f64::INFINITY, f64::min);
    let growth = least(100_000) / least(1_000);
    assert!(growth < 1000.0, "{growth}");
}

#[test]
fn many_particles_in_one_place() {
    let place = tempfile::tempdir().unwrap();
    let rows = "0.002,0.002,0.003,0,0,0\n".repeat(300_000);
    std::fs::write(place.path().join("same.csv"), format!("x,y,z,vx,vy,vz\n{rows}")).unwrap();
    let random =
        "count = 100\nvelocity_mean = [\"0 m/s\", \"0 m/s\", \"12 m/s\"]\nvelocity_fluctuation = \"0.5 m/s\"\n";
    let case = base().replace(random, "file = \"same.csv\"\n").replace("\"12 mm\"", "\"600 mm\"");
    let path = place.path().join("same.toml");
    std::fs::write(&path, case).unwrap();
    // this takes a second; examining all pairs would take half a minute
    within(12, || {
        let output = diptych(&["check"]).arg(&path).output().unwrap();
        let told = words(&output.stderr);
        assert!(output.status.code() == Some(2) && told.contains("overlap") && told.contains("same.csv:"), "{told}");
    });
}
