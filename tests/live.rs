//! A run that a page shows while it goes on, and pages with recorded runs.

use crate::lab::page::{PATIENCE, Page, Sent, get};
use crate::support::{diptych, words};
use base64::Engine;
use base64::prelude::BASE64_STANDARD;
use diptych::lab::scenes::SCENES;
use serde_json::{Value, json};
use std::io::{BufRead, BufReader};
use std::net::SocketAddr;
use std::path::Path;
use std::process::{Child, Command, Stdio};

/// A gas that runs for about a second.
const RUN: [&str; 9] = [
    "run",
    "cases/cooling-gas.toml",
    "--model",
    "hard",
    "--save-state",
    "--set",
    "run.duration=20 ms",
    "--set",
    "run.window=20 us",
];

fn state(folder: &Path) -> String {
    let text = std::fs::read_to_string(folder.join("state.csv")).unwrap();
    // the first lines name the version and the command
    text.lines().filter(|line| !line.starts_with('#')).collect::<Vec<_>>().join("\n")
}

/// Starts a run that a page shows. Returns it with the address and the path of its page.
fn watched(out: &Path) -> (Child, SocketAddr, String) {
    let arguments = [&RUN[..], &["--live", "--out", out.to_str().unwrap()]].concat();
    let mut child = diptych(&arguments).stdout(Stdio::null()).stderr(Stdio::piped()).spawn().unwrap();
    let mut lines = BufReader::new(child.stderr.take().unwrap()).lines();
    let line = lines.find(|line| line.as_ref().unwrap().contains("http://")).unwrap().unwrap();
    // the rest must be read, or the program waits
    std::thread::spawn(move || lines.for_each(drop));
    let url = line.split_whitespace().find_map(|word| word.strip_prefix("http://")).unwrap();
    let (address, path) = url.split_once('/').unwrap();
    (child, address.parse().unwrap(), format!("/{path}"))
}

#[test]
fn a_run_on_a_page_has_the_bits_of_any_other() {
    let folder = tempfile::tempdir().unwrap();
    let (alone, shown) = (folder.path().join("alone"), folder.path().join("shown"));
    let done = diptych(&[&RUN[..], &["--quiet", "--out", alone.to_str().unwrap()]].concat()).output().unwrap();
    assert!(done.status.success(), "{}", words(&done.stderr));
    let (mut child, address, path) = watched(&shown);
    let host = format!("Host: {address}\r\n");
    assert_eq!(get(address, &path, &host).0, 200);
    assert_eq!(get(address, &format!("/{}/", "0".repeat(32)), &host).0, 404);
    assert_eq!(get(address, &path, "Host: evil.example\r\n").0, 403);
    assert_eq!(Page::open(address, &path, Some("http://evil.example")).err(), Some(403));
    let mut page =
        Page::open(address, &path, Some(&format!("http://{address}"))).unwrap_or_else(|code| panic!("{code}"));
    let Sent::Told(opened) = page.next(PATIENCE) else { panic!("no description came") };
    assert_eq!((opened["tell"].as_str(), opened["until"].as_f64()), (Some("opened"), Some(20.0)));
    let mut heads = Vec::new();
    while let Sent::Framed(head, values) = page.next(PATIENCE) {
        assert_eq!(values.len() as u64, 6 * head["counts"][0].as_u64().unwrap());
        assert!(values.iter().all(|value| value.is_finite()));
        page.ask(json!({"ask": "drawn"}));
        heads.push(head);
    }
    assert!(child.wait().unwrap().success());
    let times: Vec<f64> = heads.iter().map(|head| head["sides"][0]["time"].as_f64().unwrap()).collect();
    assert!(times.len() > 3 && times.is_sorted(), "{times:?}");
    let last = &heads.last().unwrap()["sides"][0];
    assert_eq!(last["state"], "over");
    // the time is a sum of a thousand windows
    assert!((last["time"].as_f64().unwrap() - 0.02).abs() < 1e-12, "{last}");
    // a row has time [ms], velocity, temperature and impacts, which only grow in a cooling gas
    let rows = last["rows"].as_array().unwrap();
    let impacts: Vec<f64> = rows.iter().map(|row| row[3].as_f64().unwrap()).collect();
    assert!(rows.len() > 3 && impacts.is_sorted() && impacts[impacts.len() - 1] > 1000.0);
    assert!(rows[rows.len() - 1][2].as_f64().unwrap() < 0.5 * rows[0][2].as_f64().unwrap());
    assert_eq!(state(&alone), state(&shown));
}

#[cfg(target_os = "linux")]
#[test]
fn a_run_on_a_page_that_was_stopped_is_resumed_without_the_page() {
    let folder = tempfile::tempdir().unwrap();
    let (alone, shown) = (folder.path().join("alone"), folder.path().join("shown"));
    let done = diptych(&[&RUN[..], &["--quiet", "--out", alone.to_str().unwrap()]].concat()).output().unwrap();
    assert!(done.status.success(), "{}", words(&done.stderr));
    let (mut child, address, path) = watched(&shown);
    let mut page =
        Page::open(address, &path, Some(&format!("http://{address}"))).unwrap_or_else(|code| panic!("{code}"));
    page.next(PATIENCE);
    page.next(PATIENCE);
    assert!(Command::new("kill").args(["-INT", &child.id().to_string()]).status().unwrap().success());
    assert_eq!(child.wait().unwrap().code(), Some(130));
    let done = diptych(&["resume", "--quiet", shown.to_str().unwrap()]).output().unwrap();
    assert!(done.status.success(), "{}", words(&done.stderr));
    assert_eq!(state(&alone), state(&shown));
}

/// Part of a page between two texts.
fn between<'a>(page: &'a str, begin: &str, end: &str) -> &'a str {
    page.split_once(begin).unwrap().1.split_once(end).unwrap().0
}

#[test]
fn a_page_with_recorded_runs_holds_all_that_it_shows() {
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("cradle.html");
    let export =
        |scene: &str| diptych(&["lab", "--export", file.to_str().unwrap(), "--scene", scene]).output().unwrap();
    let wrong = export("cradel");
    assert_eq!(wrong.status.code(), Some(2));
    assert!(words(&wrong.stderr).contains("did you mean `cradle`?") && !file.exists());
    let done = export("cradle");
    assert!(done.status.success(), "{}", words(&done.stderr));
    let page = std::fs::read_to_string(&file).unwrap();
    // nothing is loaded from elsewhere
    let addresses: Vec<&str> =
        page.split("http").skip(1).filter(|rest| rest.starts_with("s://") || rest.starts_with("://")).collect();
    assert!(addresses.iter().all(|rest| rest.starts_with("://www.w3.org/2000/svg")), "{addresses:.60?}");
    assert!(!page.contains(" src=\"") && !page.contains("rel=\"stylesheet\""));
    let imports: Value = serde_json::from_str(between(&page, "<script type=\"importmap\">", "</script>")).unwrap();
    for (name, address) in imports["imports"].as_object().unwrap() {
        let module = address.as_str().unwrap().strip_prefix("data:text/javascript;base64,").unwrap();
        let module = words(&BASE64_STANDARD.decode(module).unwrap());
        for other in module.split(" from \"").skip(1).map(|rest| rest.split('"').next().unwrap()) {
            assert!(imports["imports"].get(other).is_some(), "{name} imports {other}");
        }
    }
    let data = between(&page, "<script type=\"application/json\" id=\"recording\">", "</script>");
    let data: Value = serde_json::from_str(data).unwrap();
    let recordings = data["recordings"].as_array().unwrap();
    // the case, the other setups of the right panel, and at least three further values of each parameter
    let scene = SCENES.iter().find(|scene| scene.name == "cradle").unwrap();
    for range in scene.knobs {
        let name = range.knob.name();
        let values = recordings.iter().filter(|one| one["settings"].get(name).is_some()).count();
        assert!(values >= 3, "{name}: {values}");
    }
    assert_eq!(recordings.iter().filter(|one| one["settings"] == json!({})).count(), scene.rights.len());
    // the numbers of all particles at all times are there
    for one in recordings {
        let particles: usize =
            one["radii"].as_array().unwrap().iter().map(|panel| panel.as_array().unwrap().len()).sum();
        let bytes = BASE64_STANDARD.decode(one["particles"].as_str().unwrap()).unwrap();
        let frames = one["frames"].as_array().unwrap().len();
        assert_eq!(frames as u64, data["frames"].as_u64().unwrap() + 1);
        assert_eq!(bytes.len(), 2 * 5 * particles * frames);
    }
    // the first column is the position along the row, in which all five beads but the first touch at the start
    let one = &recordings[0];
    let [least, range] = [0, 1].map(|k| one["scales"][0][k].as_f64().unwrap());
    let bytes = BASE64_STANDARD.decode(one["particles"].as_str().unwrap()).unwrap();
    let at = |bead: usize| {
        let share = f64::from(u16::from_le_bytes([bytes[10 * bead], bytes[10 * bead + 1]])) / f64::from(u16::MAX);
        least + range * share
    };
    let diameter = 2.0 * one["radii"][0][0].as_f64().unwrap();
    for bead in 1..4 {
        let gap = at(bead + 1) - at(bead) - diameter;
        assert!(gap.abs() < 2.0 * range / f64::from(u16::MAX), "{bead}: {gap}");
    }
    // velocities at the end of the first run are those in the heading of the case
    let sides = &recordings[0]["frames"].as_array().unwrap().last().unwrap()["sides"];
    for (side, expected) in [[-0.1323, -0.0753, -0.0310, 0.2962, 0.9424], [0.0, 0.0, 0.0, 0.0, 1.0]].iter().enumerate()
    {
        let row = sides[side]["rows"].as_array().unwrap().last().unwrap();
        for (k, velocity) in expected.iter().enumerate() {
            assert!((row[k + 1].as_f64().unwrap() - velocity).abs() < 1e-4, "{row}");
        }
    }
    let again = export("cradle");
    assert_eq!(again.status.code(), Some(2));
    assert!(words(&again.stderr).contains("there is such a file"));
}
