//! The commands of docs/tutorial.md, run unchanged in a separate folder, but with few replicas.

use crate::support::words;
use serde_json::Value;
use std::io::Write;
use std::path::Path;
use std::process::Command;

/// Number of replicas (seeds) of each variant in this test. The larger number in docs/tutorial.md takes half a minute
/// with a release build.
const FEW: &str = "4";

/// Code blocks of the page in order: language and text.
fn blocks(page: &str) -> Vec<(String, String)> {
    let parts = page.split("```").skip(1).step_by(2);
    let block = |part: &str| part.split_once('\n').map(|(language, text)| (language.to_owned(), text.to_owned()));
    parts.filter_map(block).collect()
}

fn text(path: &str) -> String {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join(path);
    std::fs::read_to_string(&path).unwrap_or_else(|error| panic!("{}: {error}", path.display()))
}

/// Sentences on the comparisons in the stored run of the tutorial's last command.
fn stored() -> Vec<String> {
    let summary: Value = serde_json::from_str(&text("docs/results/tutorial/summary.json")).unwrap();
    summary["comparisons"].as_array().unwrap().iter().map(|one| one["sentence"].as_str().unwrap().to_owned()).collect()
}

#[test]
fn every_command_of_the_tutorial_runs() {
    let folder = tempfile::tempdir().unwrap();
    // output of the last command; `None` if the command was shortened
    let mut said = None;
    let (mut commands, mut compared) = (0, 0);
    for (language, block) in blocks(&text("docs/tutorial.md")) {
        match language.as_str() {
            "sh" => {
                for line in block.lines().filter(|line| line.starts_with("diptych ")) {
                    let mut arguments: Vec<&str> = line.split_whitespace().skip(1).collect();
                    let replicas = arguments.iter().position(|argument| *argument == "--replicas");
                    if let Some(place) = replicas {
                        arguments[place + 1] = FEW;
                    }
                    let output = Command::new(env!("CARGO_BIN_EXE_diptych"))
                        .current_dir(folder.path())
                        .args(&arguments)
                        .output()
                        .unwrap();
                    assert_eq!(output.status.code(), Some(0), "{line}: {}", words(&output.stderr));
                    said = replicas.is_none().then(|| words(&output.stdout));
                    commands += 1;
                }
            }
            "toml" => {
                let path = folder.path().join("beads-in-air.toml");
                let mut file = std::fs::OpenOptions::new().append(true).open(path).unwrap();
                write!(file, "\n{block}").unwrap();
            }
            "text" => {
                if let Some(said) = &said {
                    for line in block.lines() {
                        assert!(said.lines().any(|told| told == line), "the program does not say: {line}\nbut {said}");
                        compared += 1;
                    }
                }
            }
            other => panic!("a block of the language {other}"),
        }
    }
    assert!(commands == 6 && compared == 6, "{commands} commands, {compared} lines");
    for report in ["first", "second", "third"] {
        assert!(folder.path().join(report).join("report.html").exists(), "{report}");
    }
}

#[test]
fn the_decision_is_that_of_the_stored_run() {
    let page = text("docs/tutorial.md");
    let decision = page.split_once("## 6. Decide").unwrap().1;
    let (_, block) = blocks(decision).remove(0);
    assert_eq!(block.lines().map(str::to_owned).collect::<Vec<_>>(), stored());
}
