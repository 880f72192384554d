//! `diptych lab --export`: one file with a scene of the lab and recorded runs, which needs neither the program nor a
//! network.
//!
//! The page has two panels, which show simulations side by side. One run is recorded for the unchanged case. A further
//! run is recorded for each other setup of the right panel (collision model and changes to the case). Each parameter is
//! also recorded with several values. The page of the lab plays these runs with the script `recorded.js`, which takes
//! the place of the connection to the program.

use super::frame::{DrawnParticle, Now, PanelComparison};
use super::page::{ASSETS, RECORDED};
use super::panel::LabPanel;
use super::parameter::{ParameterKind, ParameterRange, ParameterValue};
use super::protocol::{Opened, SceneChoice, Settings};
use super::scene_state::SceneState;
use super::scenes::LabScene;
use super::stage_run::StageRun;
use crate::case::nearest;
use base64::Engine;
use base64::prelude::BASE64_STANDARD;
use serde::Serialize;
use serde_json::json;
use std::time::Duration;

/// Number of frames (recorded instants) of a run after its start. A scene that lasts 12 s on the page thus has ten
/// frames per second.
const FRAMES: usize = 120;

/// Number of values of a parameter that are recorded, from its lower to its upper limit, in addition to its value in
/// the case.
const VALUES: usize = 5;

/// Number of times at which the two panels of the page are compared in a recorded run.
const VERDICTS: usize = 12;

/// Largest number of rows of measured quantities in a recorded frame (state at one instant). With this number, a curve
/// has up to 2400 points.
const ROWS: usize = 20;

/// Wall time that a panel may take from one frame (recorded instant) to the next. This limit is so long that no scene
/// reaches it.
const LONGEST: Duration = Duration::from_secs(86_400);

/// Number of significant digits of the measured numbers in a file. A picture needs only three, but a curve may change
/// by a small fraction of its values, such as the height of a heap.
const DIGITS: usize = 8;

/// Largest unsigned 16-bit number [-]. Recorded fractions from 0 to 1 are multiplied by this number.
const FULL: f32 = u16::MAX as f32;

/// Number of columns of a particle that change during a run: x, y, z [m], speed [m/s] and overlap [m].
const MOVING: usize = 5;

/// Run of a scene with chosen settings, as it is recorded in the exported page.
#[derive(Serialize)]
struct Recording {
    /// Values of the parameters that differ from those of the case, by the names of the parameters.
    settings: Settings,
    /// Index of the setup of the right panel (its collision model and changes to the case) in the list that the scene
    /// offers.
    right: usize,
    opened: Opened,
    frames: Vec<RecordedFrame>,
    /// For each column of `particles`: its smallest value in the run, and its largest value minus the smallest. A
    /// recorded fraction f means the smallest value plus f times this difference.
    scales: [[f32; 2]; MOVING],
    /// [m] radii of the particles of each panel, one list per panel.
    radii: Vec<Vec<f32>>,
    /// Columns x, y, z, speed and overlap of all particles, as text in base 64. A value is a fraction between 0 and 1
    /// (see `scales`), stored as a 16-bit number. All panels of one frame precede the next frame.
    particles: String,
}

/// State of both panels at one recorded instant (frame), without the particles.
#[derive(Serialize)]
struct RecordedFrame {
    sides: Vec<Now>,
    #[serde(skip_serializing_if = "Option::is_none")]
    judged: Option<PanelComparison>,
}

/// Page with recorded runs of a scene, as the text of one file. `tell` is called with a line about the progress before
/// each run.
///
/// # Errors
/// Returns the reason as text if a run of the scene cannot start.
pub fn page(scene: &'static LabScene, mut tell: impl FnMut(String)) -> Result<String, String> {
    let choices = choices(scene)?;
    let mut recordings = Vec::new();
    for (number, choice) in choices.iter().enumerate() {
        tell(format!("recording run {} of {}", number + 1, choices.len()));
        recordings.push(record(choice)?);
    }
    let data = json!({
        "version": env!("CARGO_PKG_VERSION"),
        "scenes": [{"name": scene.name, "title": scene.title}],
        "frames": FRAMES,
        "recordings": recordings,
    });
    Ok(html(&data.to_string()))
}

/// Scene of the lab with the given name.
///
/// # Errors
/// Returns an error text, with the names of all scenes, if there is no such scene.
pub fn scene_named(name: &str) -> Result<&'static LabScene, String> {
    super::scenes::scene(name).ok_or_else(|| {
        let names: Vec<&str> = super::scenes::SCENES.iter().map(|scene| scene.name).collect();
        let meant = nearest(name, &names).map_or(String::new(), |known| format!("did you mean `{known}`? "));
        format!("error: --scene {name}: the lab has no such scene\nhelp: {meant}the scenes are {}", names.join(", "))
    })
}

/// Scene and settings of each recorded run. The first run is that of the unchanged case.
fn choices(scene: &LabScene) -> Result<Vec<SceneChoice>, String> {
    let choice = |right, settings| SceneChoice { scene: scene.name.to_owned(), settings, right, serial: 0 };
    let mut choices: Vec<SceneChoice> = (0..scene.rights.len()).map(|right| choice(right, Settings::new())).collect();
    let of_case = SceneState::open(&choices[0])?.opened();
    for range in scene.knobs {
        let name = range.knob.name();
        let Some(own) = of_case.knobs.iter().find(|shown| shown.name == name).map(|shown| &shown.default) else {
            continue;
        };
        let others = values(range).into_iter().filter(|value| value != own);
        choices.extend(others.map(|value| choice(0, Settings::from([(name.to_owned(), value)]))));
    }
    Ok(choices)
}

/// Values of a parameter that are recorded, from its lower to its upper limit, without repetitions.
fn values(range: &ParameterRange) -> Vec<ParameterValue> {
    let mut values = match range.kind() {
        ParameterKind::Words(words) => {
            words.into_iter().map(|(word, _)| ParameterValue::Word(word.to_owned())).collect::<Vec<_>>()
        }
        ParameterKind::Number { least, most, logarithmic, .. } => {
            let share = |k: usize| k as f64 / (VALUES - 1) as f64;
            let at =
                |k| if logarithmic { least * (most / least).powf(share(k)) } else { least + (most - least) * share(k) };
            (0..VALUES).map(|k| ParameterValue::Number(at(k).clamp(least, most))).collect()
        }
    };
    values = values.iter().filter_map(|value| range.accept(value).ok()).collect();
    values.dedup();
    values
}

fn record(choice: &SceneChoice) -> Result<Recording, String> {
    let stage = SceneState::open(choice)?;
    let opened = stage.opened();
    let mut run = StageRun::new(&stage);
    let (mut frames, mut particles): (Vec<RecordedFrame>, Vec<Vec<DrawnParticle>>) = (Vec::new(), Vec::new());
    for frame in 0..=FRAMES {
        let until = opened.duration * frame as f64 / FRAMES as f64;
        run.panels.iter_mut().for_each(|panel| panel.run(until, LONGEST));
        if frame > 0 && frame % (FRAMES / VERDICTS) == 0 {
            run.judge();
        }
        let sides = run.panels.iter_mut().map(|panel| short(panel.now())).collect();
        frames.push(RecordedFrame { sides, judged: run.judged.take() });
        particles.extend(run.panels.iter().map(LabPanel::particles));
        if run.panels.iter().all(|panel| panel.running().is_none()) {
            break;
        }
    }
    let radii =
        particles.iter().take(run.panels.len()).map(|panel| panel.iter().map(|one| one[MOVING]).collect::<Vec<f32>>());
    let radii = radii.collect();
    let scales: [[f32; 2]; MOVING] =
        std::array::from_fn(|column| scale(particles.iter().flatten().map(|one| one[column])));
    let mut bytes = Vec::new();
    for one in particles.iter().flatten() {
        for (value, [least, range]) in one.iter().zip(scales) {
            let share = if range > 0.0 { (value - least) / range } else { 0.0 };
            bytes.extend_from_slice(&((share * FULL).round() as u16).to_le_bytes());
        }
    }
    let particles = BASE64_STANDARD.encode(bytes);
    Ok(Recording { settings: choice.settings.clone(), right: choice.right, opened, frames, scales, radii, particles })
}

/// Smallest of several values, and the largest minus the smallest; both are 0 if there are no values.
fn scale(values: impl Iterator<Item = f32>) -> [f32; 2] {
    let (least, most) =
        values.fold((f32::INFINITY, f32::NEG_INFINITY), |(least, most), value| (least.min(value), most.max(value)));
    if least <= most { [least, most - least] } else { [0.0, 0.0] }
}

/// State of a panel in a shorter form: with at most [`ROWS`] rows of measured quantities, and with numbers rounded to
/// [`DIGITS`] digits.
fn short(mut now: Now) -> Now {
    let (mut place, every) = (now.rows.len(), now.rows.len().div_ceil(ROWS).max(1));
    // the last row is always kept
    now.rows.retain(|_| {
        place -= 1;
        place.is_multiple_of(every)
    });
    for value in now.rows.iter_mut().flatten() {
        *value = format!("{value:.*e}", DIGITS - 1).parse().unwrap_or(*value);
    }
    now
}

/// Page of the lab with all its files in one text. `data` is the JSON of the recorded runs.
fn html(data: &str) -> String {
    let text = |path: &str| ASSETS.iter().find(|asset| asset.path == path).map_or("", |asset| asset.text);
    // a script in a `data:` address cannot import other scripts by a relative path, so the import map gives their
    // addresses
    let renamed = |text: &str| text.replace("from \"./", "from \"lab/");
    let mut imports = serde_json::Map::new();
    for asset in
        ASSETS.iter().filter(|asset| asset.path.ends_with(".js") && !["scene.js", "live.js"].contains(&asset.path))
    {
        let module = if asset.path == "link.js" { RECORDED } else { asset.text };
        let address = format!("data:text/javascript;base64,{}", BASE64_STANDARD.encode(renamed(module)));
        imports.insert(format!("lab/{}", asset.path), address.into());
    }
    // `</` would end the element, and within a string of JSON `<\/` means the same
    let data = data.replace("</", "<\\/");
    // scripts and styles are in this one file, and the browser may load nothing from elsewhere
    let policy = "default-src 'none'; script-src 'unsafe-inline' data:; style-src 'unsafe-inline'; img-src data:";
    let head = format!(
        "<meta http-equiv=\"Content-Security-Policy\" content=\"{policy}\">\n<style>{}{}</style>\n<script>{}</script>\n\
         <script type=\"importmap\">{}</script>\n<script type=\"application/json\" id=\"recording\">{data}</script>\n\
         <script type=\"module\">import \"lab/main.js\";</script>\n</head>",
        text("shared.css"),
        text("lab.css"),
        text("scene.js"),
        json!({"imports": imports}),
    );
    let kept =
        text("").lines().filter(|line| !line.starts_with("<link rel=\"stylesheet\"") && !line.starts_with("<script"));
    kept.collect::<Vec<&str>>().join("\n").replace("</head>", &head)
}
