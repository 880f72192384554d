//! The first answer in the README, its picture, the pages that cite its runs, and the stored runs must agree.

use crate::support::{diptych, words};
use serde_json::Value;
use std::path::PathBuf;

fn root() -> PathBuf {
    PathBuf::from(env!("CARGO_MANIFEST_DIR"))
}

fn text(path: &str) -> String {
    std::fs::read_to_string(root().join(path)).unwrap_or_else(|error| panic!("{path}: {error}"))
}

/// Summary of a stored run, `docs/results/NAME`.
fn stored(name: &str) -> Value {
    serde_json::from_str(&text(&format!("docs/results/{name}/summary.json"))).unwrap()
}

/// Sentences of the comparisons in a summary, in their order.
fn sentences(summary: &Value) -> Vec<String> {
    summary["comparisons"].as_array().unwrap().iter().map(|one| one["sentence"].as_str().unwrap().to_owned()).collect()
}

/// Lines of the first code block of a language in the README.
fn block(language: &str) -> Vec<String> {
    let readme = text("README.md");
    let (_, rest) = readme.split_once(&format!("```{language}\n")).unwrap();
    rest.split("\n```").next().unwrap().lines().map(str::to_owned).collect()
}

/// First command of the README, without the name of the program.
fn command() -> Vec<String> {
    let line = block("sh").remove(0);
    let line = line.split('#').next().unwrap().trim().to_owned();
    line.strip_prefix("cargo run --release -- ").unwrap().split_whitespace().map(str::to_owned).collect()
}

#[test]
fn the_readme_is_short() {
    let count = text("README.md").split_whitespace().count();
    assert!(count <= 700, "{count} words");
}

#[test]
fn the_readme_says_what_the_stored_run_said() {
    let summary = stored("first-answer");
    assert_eq!(block("text"), sentences(&summary), "README.md, and docs/results/keep.py");
    let ran = summary["command"].as_str().unwrap().replace('\'', "");
    assert!(ran.starts_with(&format!("diptych {}", command().join(" "))), "{ran}");
    let verdicts: Vec<&str> =
        summary["comparisons"].as_array().unwrap().iter().map(|one| one["verdict"].as_str().unwrap()).collect();
    assert_eq!(verdicts, ["equivalent", "different"], "the first answer decides");
}

/// Values of an attribute in all elements of one kind in a picture.
fn attributes(picture: &str, element: &str, name: &str) -> Vec<f64> {
    let start = format!("<{element} ");
    let tags = picture.split(start.as_str()).skip(1);
    let value = |tag: &str| {
        let rest = tag.split('>').next()?.split_once(&format!("{name}=\""))?.1;
        rest.split('"').next()?.parse().ok()
    };
    tags.filter_map(value).collect()
}

/// Scale below the picture: each number, and its position along x.
fn ticks(picture: &str) -> Vec<(f64, f64)> {
    let texts = picture.split("<text ").skip(1).filter(|text| text.contains("y=\"327\""));
    let tick = |text: &str| {
        let place = text.split_once("x=\"")?.1.split('"').next()?.parse().ok()?;
        let number = text.split_once('>')?.1.split('<').next()?.replace('−', "-").parse().ok()?;
        Some((number, place))
    };
    texts.filter_map(tick).collect()
}

/// Each dot of the picture is a difference of the stored run, in per cent of its scale. The tolerance is the width of a
/// line.
#[test]
fn the_picture_draws_the_stored_run() {
    let picture = text("docs/results/first-answer/differences-in-per-cent.svg");
    let ticks = ticks(&picture);
    let (zero, margin) =
        (ticks.iter().find(|tick| tick.0 == 0.0).unwrap(), ticks.iter().find(|tick| tick.0 == 3.0).unwrap());
    let per_cent = |x: f64| 3.0 * (x - zero.1) / (margin.1 - zero.1);
    // the first dots are those of the legend
    let rows = attributes(&picture, "circle", "cy").iter().filter(|y| **y < 20.0).count();
    let dots: Vec<f64> = attributes(&picture, "circle", "cx")[rows..].iter().map(|x| per_cent(*x)).collect();
    let summary = stored("first-answer");
    let judged = |one: &Value| one["comparison"]["judged"].as_array().unwrap().clone();
    let found: Vec<Vec<Value>> = summary["comparisons"].as_array().unwrap().iter().map(judged).collect();
    assert_eq!(dots.len(), 2 * found[0].len());
    for (place, dot) in dots.iter().enumerate() {
        let quantity = &found[place % 2][place / 2];
        let scale = quantity["scale"].as_f64().unwrap();
        let shares: Vec<f64> = ["mean", "largest"]
            .iter()
            .filter_map(|kind| Some(100.0 * quantity[kind]["difference"].as_f64()? / scale))
            .collect();
        assert!(shares.iter().any(|share| (share - dot).abs() < 0.02), "{}: {dot} of {shares:?}", quantity["name"]);
    }
}

/// All pages and cases give the same number for the fraction of collisions that stepped hard spheres miss.
#[test]
fn missed_collisions_are_one_number() {
    let summary = stored("quick");
    let judged = summary["comparisons"][1]["comparison"]["judged"].as_array().unwrap();
    let rate = judged.iter().find(|one| one["name"] == "pair impacts per time").unwrap();
    let share = |key: &str| 100.0 * rate["mean"][key].as_f64().unwrap() / rate["scale"].as_f64().unwrap();
    let told = format!("{:.2} % ± {:.2} %", share("difference").abs(), share("error"));
    for page in ["docs/limits.md", "cases/quick.toml"] {
        assert!(text(page).contains(&told), "{page} should say {told}");
    }
}

/// The page docs/plan.md shows a plan unchanged, except for measured times.
#[test]
fn the_page_of_the_plan_shows_the_plan() {
    let page = text("docs/plan.md");
    let (_, block) = page.split_once("```text\ncases/glass-beads.toml").unwrap();
    let output = diptych(&["plan", "cases/glass-beads.toml"]).current_dir(root()).output().unwrap();
    assert!(output.status.success(), "{}", words(&output.stderr));
    let plan = words(&output.stdout);
    let shown: Vec<&str> = block.split("\nCost of").next().unwrap().lines().skip(1).collect();
    assert!(shown.len() > 30);
    for line in shown {
        assert!(plan.lines().any(|told| told == line), "the plan does not say: {line}\nbut {plan}");
    }
}

/// The test takes half a minute on two cores with a release build, and some minutes with a test build.
#[test]
#[ignore = "runs the README's first command in full"]
fn a_fresh_run_says_the_same() {
    let folder = tempfile::tempdir().unwrap();
    let mut arguments: Vec<String> = command();
    arguments.extend(["--quiet", "--out"].map(str::to_owned));
    arguments.push(folder.path().join("results").to_str().unwrap().to_owned());
    let arguments: Vec<&str> = arguments.iter().map(String::as_str).collect();
    let output = diptych(&arguments).current_dir(root()).output().unwrap();
    assert!(output.status.success(), "{}", words(&output.stderr));
    let summary = std::fs::read_to_string(folder.path().join("results/summary.json")).unwrap();
    assert_eq!(sentences(&serde_json::from_str(&summary).unwrap()), sentences(&stored("first-answer")));
}
