//! The lab as a page uses it: which requests are admitted, which settings are allowed, the state of every scene in both
//! panels, and threads after the end of the lab.

pub mod page;

use clap::Parser;
use diptych::case::{Case, fingerprint};
use diptych::cli::{Cli, Command as Said, ModelChoice};
use diptych::lab::protocol::SceneChoice;
use diptych::lab::scenes::{LabScene, SCENES};
use diptych::lab::{LabServer, ParameterKind, ParameterValue, SceneState};
use page::{PATIENCE, Page, SILENCE, Sent, get, path_of};
use serde_json::{Value, json};
use std::io::{BufRead, BufReader, Read, Write};
use std::net::{SocketAddr, TcpStream};
use std::path::Path;
use std::process::{Command, Stdio};
use std::time::{Duration, Instant};
use tungstenite::Message;

fn served() -> LabServer {
    LabServer::start(0).unwrap()
}

#[test]
fn only_who_knows_the_token_and_asks_for_this_machine_is_let_in() {
    let lab = served();
    let (address, path) = (lab.address(), path_of(&lab));
    assert!(address.ip().is_loopback());
    let host = format!("Host: {address}\r\n");
    let (status, text) = get(address, &path, &host);
    assert_eq!(status, 200);
    assert!(
        text.contains("<title>Diptych lab")
            && text.to_lowercase().contains("content-security-policy: default-src 'none'")
    );
    assert!(!text.to_lowercase().contains("access-control"));
    let wrong = format!("/{}/", "0".repeat(path.len() - 2));
    for path in ["/", "/favicon.ico", "/socket", wrong.as_str(), &path[..path.len() - 2]] {
        assert_eq!(get(address, path, &host).0, 404, "{path}");
    }
    for headers in [
        "Host: evil.example\r\n".to_owned(),
        format!("Host: evil.example:{}\r\n", address.port()),
        String::new(),
        format!("{host}Origin: http://evil.example\r\n"),
        format!("{host}Origin: null\r\n"),
        format!("{host}Host: evil.example\r\n"),
        format!("{host}{host}"),
        format!("{host}Origin: http://{address}\r\nOrigin: http://evil.example\r\n"),
    ] {
        assert_ne!(get(address, &path, &headers).0, 200, "{headers}");
    }
    assert_eq!(get(address, &path, &format!("Host: localhost:{}\r\n", address.port())).0, 200);
    for origin in [None, Some("http://evil.example"), Some("null")] {
        assert_eq!(Page::open(address, &path, origin).err(), Some(403), "{origin:?}");
    }
    assert_eq!(Page::open(address, "/0123/", Some(&format!("http://{address}"))).err(), Some(404));
    lab.stop();
}

/// Requests whose head is never completed do not keep connections and files open for long. The page is served after 60
/// such requests.
#[test]
fn requests_that_never_end_are_closed() {
    let lab = served();
    let (address, path) = (lab.address(), path_of(&lab));
    let begun = |_| {
        let mut stream = TcpStream::connect(address).unwrap();
        stream.set_read_timeout(Some(PATIENCE)).unwrap();
        stream.write_all(b"GET / HTTP/1.1\r\nHost: ").unwrap();
        stream
    };
    let mut half_open: Vec<TcpStream> = (0..60).map(begun).collect();
    assert_eq!(get(address, &path, &format!("Host: {address}\r\n")).0, 200);
    // the server has closed the connection: reading ends without further bytes, and without a timeout
    for stream in &mut half_open {
        let mut rest = Vec::new();
        let end = stream.read_to_end(&mut rest);
        assert!(end.is_ok() && !rest.starts_with(b"HTTP/1.1 200"));
    }
    lab.stop();
}

#[test]
fn no_file_but_those_of_the_page_can_be_had() {
    let lab = served();
    let (address, path) = (lab.address(), path_of(&lab));
    let host = format!("Host: {address}\r\n");
    assert_eq!(get(address, &format!("{path}main.js"), &host).0, 200);
    for file in [
        "Cargo.toml",
        "../Cargo.toml",
        "%2e%2e%2fCargo.toml",
        "..%2f..%2fetc%2fpasswd",
        "//etc/passwd",
        "lab.css%00",
        "main.js/",
    ] {
        assert_eq!(get(address, &format!("{path}{file}"), &host).0, 404, "{file}");
    }
    // all files that the page loads exist, and none is on another server
    let (_, page) = get(address, &path, &host);
    for name in page.split(['"', '\'']).filter(|word| word.ends_with(".js") || word.ends_with(".css")) {
        let (status, text) = get(address, &format!("{path}{name}"), &host);
        assert_eq!(status, 200, "{name}");
        for import in text.split("from \"./").skip(1) {
            let import = import.split('"').next().unwrap();
            assert_eq!(get(address, &format!("{path}{import}"), &host).0, 200, "{import}");
        }
        let addresses: Vec<&str> =
            text.split("http").skip(1).filter(|rest| rest.starts_with("s://") || rest.starts_with("://")).collect();
        assert!(addresses.iter().all(|rest| rest.starts_with("://www.w3.org/2000/svg")), "{name}: {addresses:?}");
    }
    lab.stop();
}

#[test]
fn every_scene_starts_in_both_panels_and_goes_on() {
    let lab = served();
    let mut page = Page::of(&lab);
    let scenes = page.told();
    assert_eq!(scenes["tell"], "scenes");
    let listed: Vec<&str> =
        scenes["scenes"].as_array().unwrap().iter().map(|scene| scene["name"].as_str().unwrap()).collect();
    assert_eq!(listed, SCENES.iter().map(|scene| scene.name).collect::<Vec<_>>());
    for (scene, right) in SCENES.iter().flat_map(|scene| (0..scene.rights.len()).map(move |right| (scene, right))) {
        page.choose(scene.name, json!({}), right);
        let opened = page.told();
        assert_eq!((&opened["tell"], &opened["scene"]), (&json!("opened"), &json!(scene.name)), "{opened}");
        let (start, values) = page.frame();
        let counts = [0, 1].map(|side| start["counts"][side].as_u64().unwrap() as usize);
        assert!(counts[0] > 0 && counts[0] == counts[1], "{}", scene.name);
        assert_eq!(values.len(), 6 * (counts[0] + counts[1]));
        assert_eq!(start["sides"][0]["time"], 0.0);
        // positions and speeds are equal on both sides; overlaps may differ by rounding, because bodies touch at the
        // start
        let (left, right) = values.split_at(6 * counts[0]);
        let same =
            left.chunks(6).zip(right.chunks(6)).all(|(left, right)| left[..4] == right[..4] && left[5] == right[5]);
        assert!(same, "{}", scene.name);
        let begun = Instant::now();
        loop {
            let (head, values) = page.frame();
            let sides = head["sides"].as_array().unwrap();
            assert!(values.iter().all(|value| value.is_finite()), "{}", scene.name);
            if sides.iter().all(|side| side["time"].as_f64().unwrap() > 0.0 || side["state"] == "failed") {
                // the scene `unstable` is meant to fail, and the scene `column` stops at once
                let may_fail = ["unstable", "column"].contains(&scene.name);
                assert!(may_fail || sides.iter().all(|side| side["failure"].is_null()), "{}: {head}", scene.name);
                break;
            }
            assert!(begun.elapsed() < PATIENCE, "{} stands still", scene.name);
        }
    }
    lab.stop();
}

/// Fingerprints of the settings that determine the results of a scene, one for each of the two panels.
fn prints(experiments: &[diptych::Experiment; 2]) -> [String; 2] {
    [0, 1].map(|side| fingerprint(&experiments[side]).unwrap())
}

/// Settings different from those of the case: the middle of every slider, and the other value of every choice.
fn moved(scene: &LabScene) -> diptych::lab::protocol::Settings {
    let halfway = |range: &diptych::lab::ParameterRange| match range.kind() {
        ParameterKind::Number { least, most, .. } => ParameterValue::Number(0.5 * (least + most)),
        ParameterKind::Words(words) => ParameterValue::Word(words[0].0.to_owned()),
    };
    scene.knobs.iter().map(|range| (range.knob.name().to_owned(), halfway(range))).collect()
}

/// Words of a command line that is quoted for a shell.
fn words(command: &str) -> Vec<String> {
    let (mut words, mut word, mut quoted) = (Vec::new(), String::new(), false);
    for letter in command.chars() {
        match letter {
            '\'' => quoted = !quoted,
            ' ' if !quoted => words.push(std::mem::take(&mut word)),
            letter => word.push(letter),
        }
    }
    words.push(word);
    words
}

#[test]
fn commands_and_saved_cases_run_what_the_panels_show() {
    for scene in SCENES {
        for settings in [Default::default(), moved(scene)] {
            for right in 0..scene.rights.len() {
                let choice = SceneChoice { scene: scene.name.into(), settings: settings.clone(), right, serial: 0 };
                let stage = SceneState::open(&choice).unwrap_or_else(|why| panic!("{}: {why}", scene.name));
                let (opened, prints) = (stage.opened(), prints(&stage.experiments));
                for (side, print) in opened.sides.iter().zip(&prints) {
                    let Said::Run(run) = Cli::try_parse_from(words(&side.command)).unwrap().command else { panic!() };
                    let case = Case::read(&run.case, &run.input.set).unwrap();
                    let model = run.model.and_then(ModelChoice::model);
                    let (experiment, _) =
                        case.experiment(model, None).unwrap_or_else(|why| panic!("{}: {why}", side.command));
                    assert_eq!(fingerprint(&experiment).unwrap(), *print, "{}", side.command);
                }
                let saved = Case::from_text(Path::new("elsewhere/lab.toml"), opened.case.as_str().into(), &[]).unwrap();
                let variants = saved.variants(None).unwrap_or_else(|why| panic!("{why}\n{}", opened.case));
                let of_file: Vec<String> = variants.iter().map(|(variant, _)| fingerprint(variant).unwrap()).collect();
                assert_eq!(of_file, prints, "{}", opened.case);
            }
        }
    }
}

#[test]
fn a_saved_case_is_accepted_by_run() {
    let folder = tempfile::tempdir().unwrap();
    let choice = SceneChoice {
        scene: "cradle".into(),
        settings: moved(diptych::lab::scenes::scene("cradle").unwrap()),
        right: 1,
        serial: 0,
    };
    let opened = SceneState::open(&choice).unwrap().opened();
    std::fs::write(folder.path().join("saved.toml"), &opened.case).unwrap();
    for command in ["check", "run", "compare"] {
        let mut diptych = Command::new(env!("CARGO_BIN_EXE_diptych"));
        let output = diptych.current_dir(folder.path()).args([command, "saved.toml"]).output().unwrap();
        assert!(output.status.success(), "{command}: {}", String::from_utf8_lossy(&output.stderr));
    }
}

#[test]
fn the_ends_of_every_slider_can_be_run() {
    for scene in SCENES {
        for range in scene.knobs {
            let ends = match range.kind() {
                ParameterKind::Number { least, most, .. } => {
                    vec![ParameterValue::Number(least), ParameterValue::Number(most)]
                }
                ParameterKind::Words(words) => {
                    words.iter().map(|(word, _)| ParameterValue::Word((*word).into())).collect()
                }
            };
            for end in ends {
                let settings = [(range.knob.name().to_owned(), end.clone())].into();
                let choice = SceneChoice { scene: scene.name.into(), settings, ..SceneChoice::default() };
                let stage = SceneState::open(&choice).unwrap_or_else(|why| panic!("{} {end:?}: {why}", scene.name));
                // the run uses the settings, and the page shows them
                let shown = stage.opened().knobs.into_iter().find(|knob| knob.name == range.knob.name()).unwrap();
                assert_eq!(shown.value, end, "{}", scene.name);
                let (ParameterValue::Number(asked), Some(ParameterValue::Number(runs))) =
                    (&end, range.knob.value(&stage.experiments[0]))
                else {
                    assert_eq!(range.knob.value(&stage.experiments[0]), Some(end));
                    continue;
                };
                // a whole number of windows must fit between two samples; a window may therefore be shorter than
                // requested, by less than half
                let least = if range.knob.name() == "window" { 0.5 * *asked } else { *asked };
                assert!(
                    (least * (1.0 - 1e-9)..=*asked * (1.0 + 1e-9)).contains(&runs),
                    "{}: {} = {runs} for {asked}",
                    scene.name,
                    range.knob.name()
                );
            }
        }
    }
}

/// Windows and samples follow the slider of the step criterion θ, so that the time steps are nearly as long as this θ
/// requires.
#[test]
fn stepped_spheres_run_at_the_theta_of_the_slider() {
    for theta in [0.03, 0.3, 1.0] {
        let settings = [("theta".to_owned(), ParameterValue::Number(theta))].into();
        let choice = SceneChoice { scene: "stepped".into(), settings, ..SceneChoice::default() };
        let method = SceneState::open(&choice).unwrap().opened().sides[0].method.clone();
        let real: f64 = method.split("θ = ").nth(1).unwrap().split(' ').next().unwrap().parse().unwrap();
        assert!((0.85 * theta..=theta).contains(&real), "{theta}: {method}");
    }
}

#[test]
fn what_is_beyond_the_limits_is_refused_and_the_scene_goes_on() {
    let lab = served();
    let mut page = Page::of(&lab);
    page.told();
    page.choose("cooling", json!({}), 0);
    page.told();
    for (settings, right, words) in [
        (json!({"number": 1e9}), 0, "the lab takes 100 to 2000"),
        (json!({"e": -1}), 0, "restitution"),
        (json!({"e": "glass"}), 0, "does not know"),
        (json!({"k": null}), 0, ""),
        (json!({"run.duration": 1e9}), 0, "no setting"),
        (json!({}), 9, "right panel"),
    ] {
        let running = page.serial;
        if words.is_empty() {
            // a message that does not belong to the protocol disconnects the page, and another page can be opened
            let mut other = Page::of(&lab);
            other.told();
            other.choose("cooling", settings, right);
            assert!(matches!(other.next(PATIENCE), Sent::Nothing));
            continue;
        }
        page.choose("cooling", settings.clone(), right);
        let told = page.told();
        assert_eq!(told["tell"], "refused", "{settings}");
        assert!(told["why"].as_str().unwrap().contains(words), "{told}");
        page.serial = running;
        page.frame();
    }
    page.choose("../../etc/passwd", json!({}), 0);
    assert_eq!(page.told()["tell"], "refused");
    lab.stop();
}

#[test]
fn messages_that_are_none_end_the_page_and_not_the_lab() {
    let lab = served();
    for message in [
        Message::Text("{".into()),
        Message::Text("{\"ask\": \"read\", \"path\": \"/etc/passwd\"}".into()),
        Message::Text(format!("{{\"ask\": \"open\", \"scene\": \"{}\"}}", "x".repeat(20_000)).into()),
        Message::Binary(vec![0; 100].into()),
    ] {
        let mut page = Page::of(&lab);
        page.told();
        let _ = page.socket.send(message);
        assert!(matches!(page.next(PATIENCE), Sent::Nothing));
    }
    wait_for(|| lab.sessions() == 0);
    let mut page = Page::of(&lab);
    page.told();
    lab.stop();
}

/// Waits until a condition is true.
fn wait_for(so: impl Fn() -> bool) {
    let end = Instant::now() + PATIENCE;
    while !so() {
        assert!(Instant::now() < end);
        std::thread::sleep(Duration::from_millis(10));
    }
}

#[test]
fn nothing_is_computed_for_a_page_that_does_not_draw_or_is_not_looked_at() {
    let lab = served();
    let mut page = Page::of(&lab);
    page.told();
    page.choose("cooling", json!({}), 0);
    page.told();
    // two frames arrive, and no further frame before the page draws one
    let mut frames = Vec::new();
    while let Sent::Framed(head, _) = page.next(SILENCE) {
        frames.push(head["sides"][0]["time"].as_f64().unwrap());
    }
    assert_eq!(frames.len(), 2, "{frames:?}");
    page.ask(json!({"ask": "drawn"}));
    let Sent::Framed(head, _) = page.next(PATIENCE) else { panic!() };
    // one frame later, but not by the wall time: frames that the page did not draw were not computed
    let (next, step) = (head["sides"][0]["time"].as_f64().unwrap(), frames[1] - frames[0]);
    assert!(next > frames[1] && next - frames[1] < 10.0 * step.max(1e-4), "{frames:?} {next}");
    page.ask(json!({"ask": "look", "on": false}));
    for _ in 0..2 {
        page.ask(json!({"ask": "drawn"}));
    }
    while let Sent::Framed(..) = page.next(SILENCE) {
        page.ask(json!({"ask": "drawn"}));
    }
    page.ask(json!({"ask": "drawn"}));
    assert!(matches!(page.next(SILENCE), Sent::Nothing));
    page.ask(json!({"ask": "look", "on": true}));
    assert!(matches!(page.next(PATIENCE), Sent::Framed(..)));
    // while the motion is paused, each request gives one frame
    page.ask(json!({"ask": "play", "on": false}));
    page.ask(json!({"ask": "drawn"}));
    while let Sent::Framed(..) = page.next(SILENCE) {
        page.ask(json!({"ask": "drawn"}));
    }
    page.ask(json!({"ask": "step"}));
    assert!(matches!(page.next(PATIENCE), Sent::Framed(..)));
    assert!(matches!(page.next(SILENCE), Sent::Nothing));
    lab.stop();
}

/// The lab uses the engines of all commands: the velocities after an impact at 1 m/s are those in the heading of
/// `cases/cradle.toml`.
#[test]
fn the_cradle_ends_as_its_case_says() {
    let lab = served();
    let mut page = Page::of(&lab);
    page.told();
    page.choose("cradle", json!({}), 0);
    page.told();
    page.ask(json!({"ask": "pace", "factor": 10}));
    let (mut rows, mut over) = ([Value::Null, Value::Null], false);
    while !over {
        let (head, _) = page.frame();
        for (side, kept) in rows.iter_mut().enumerate() {
            if let Some(row) = head["sides"][side]["rows"].as_array().unwrap().last() {
                *kept = row.clone();
            }
        }
        over = head["sides"].as_array().unwrap().iter().all(|side| side["state"] == "over");
    }
    let expected = [[-0.1323, -0.0753, -0.0310, 0.2962, 0.9424], [0.0, 0.0, 0.0, 0.0, 1.0]];
    for (row, expected) in rows.iter().zip(expected) {
        assert!((row[0].as_f64().unwrap() - 300.0).abs() < 1e-6, "{row}");
        for (k, velocity) in expected.into_iter().enumerate() {
            assert!((row[k + 1].as_f64().unwrap() - velocity).abs() < 1e-4, "{row}");
        }
    }
    lab.stop();
}

#[test]
fn four_pages_may_be_open_and_all_threads_end() {
    let lab = served();
    let mut pages: Vec<Page> = (0..4).map(|_| Page::of(&lab)).collect();
    for page in &mut pages {
        page.told();
        page.choose("cooling", json!({}), 0);
        page.told();
    }
    let (address, path) = (lab.address(), path_of(&lab));
    assert_eq!(Page::open(address, &path, Some(&format!("http://{address}"))).err(), Some(503));
    pages.truncate(1);
    wait_for(|| lab.sessions() == 1);
    pages[0].frame();
    // one page is still open, and its session must end
    let begun = Instant::now();
    lab.stop();
    assert!(begun.elapsed() < Duration::from_secs(10));
    while !matches!(pages[0].next(PATIENCE), Sent::Nothing) {}
}

/// The command prints its address, serves the page there, keeps no thread for a closed page, and ends at the first
/// Ctrl-C.
#[cfg(target_os = "linux")]
#[test]
fn the_command_ends_cleanly_and_keeps_no_thread_of_a_page() {
    let mut child = Command::new(env!("CARGO_BIN_EXE_diptych"))
        .arg("lab")
        .stdout(Stdio::piped())
        .stderr(Stdio::piped())
        .spawn()
        .unwrap();
    let mut line = String::new();
    BufReader::new(child.stdout.as_mut().unwrap()).read_line(&mut line).unwrap();
    let url = line.split_whitespace().find(|word| word.starts_with("http://127.0.0.1:")).unwrap().to_owned();
    let (address, path) = url.trim_start_matches("http://").split_once('/').unwrap();
    let (address, path) = (address.parse::<SocketAddr>().unwrap(), format!("/{path}"));
    let threads = || std::fs::read_dir(format!("/proc/{}/task", child.id())).unwrap().count();
    let before = threads();
    for _ in 0..3 {
        let mut page = Page::open(address, &path, Some(&format!("http://{address}"))).ok().unwrap();
        page.told();
        page.choose("cooling", json!({}), 0);
        page.told();
        page.frame();
        assert!(threads() > before);
    }
    wait_for(|| threads() == before);
    let status = Command::new("kill").args(["-INT", &child.id().to_string()]).status().unwrap();
    assert!(status.success());
    let end = Instant::now() + PATIENCE;
    while child.try_wait().unwrap().is_none() {
        assert!(Instant::now() < end, "Ctrl-C did not end it");
        std::thread::sleep(Duration::from_millis(10));
    }
    let output = child.wait_with_output().unwrap();
    assert!(output.status.success() && output.stderr.is_empty(), "{output:?}");
}
