//! Output files with made-up results. The tests check the form of the files, not the physics.

use crate::made_up::{outcome, outcomes, provenance, with_study, write};
use crate::support::{diptych, words};
use diptych::drag::{Drag, Stokes};
use diptych::engine::Failure;
use diptych::experiment::*;
use diptych::fluid::Profile;
use diptych::outcome::{Outcome, Timing};
use diptych::output::numbers::{count, quantity, significant, with_error};
use diptych::output::*;
use diptych::record::Record;
use diptych::statistics::{Estimate, ProfileTable, SLICE_COLUMNS, SLICE_QUANTITIES};
use diptych::walls::{Obstacle, WallGeometry};
use std::path::Path;

const HEADER: &str = "variant,slice,y_m,number_density_ratio,U,V,W,uu,vv,ww,uv,uw,vw,uuu,uuv,uuw,uvv,uvw,uww,vvv,vvw,vww,www,\
    number_density_ratio_se,U_se,V_se,W_se,uu_se,vv_se,ww_se,uv_se,uw_se,vw_se,\
    uuu_se,uuv_se,uuw_se,uvv_se,uvw_se,uww_se,vvv_se,vvw_se,vww_se,www_se,samples";

/// Folder under target/ that remains after the test, so that the pages can be viewed.
fn lasting(name: &str) -> Folder {
    Folder::create(Path::new(env!("CARGO_TARGET_TMPDIR")).join(name), true).unwrap()
}

fn read(folder: &Folder, name: &str) -> String {
    std::fs::read_to_string(folder.path().join(name)).unwrap()
}

/// Checks that tags open and close in order, and that there is no bare ampersand.
fn assert_well_formed(xml: &str) {
    let mut open: Vec<&str> = Vec::new();
    let mut rest = xml;
    while let Some(start) = rest.find('<') {
        for piece in rest[..start].split('&').skip(1) {
            assert!(
                piece.split(';').next().is_some_and(|name| name.len() < 8) && piece.contains(';'),
                "bare & in {piece}"
            );
        }
        rest = &rest[start..];
        if rest.starts_with("<!--") {
            rest = &rest[rest.find("-->").unwrap() + 3..];
            continue;
        }
        let end = rest.find('>').unwrap();
        let tag = &rest[1..end];
        assert!(!tag.contains('<'), "< inside a tag: {tag}");
        if let Some(name) = tag.strip_prefix('/') {
            assert_eq!(open.pop(), Some(name.trim()));
        } else if !tag.ends_with('/') && !tag.starts_with(['?', '!']) {
            open.push(tag.split_whitespace().next().unwrap());
        }
        rest = &rest[end + 1..];
    }
    assert!(open.is_empty(), "left open: {open:?}");
}

fn assert_no_network(html: &str) {
    for load in ["src=", "<link", "@import", "url(http", "fetch(", "XMLHttpRequest", "import("] {
        assert!(!html.contains(load), "{load} in a page that must open offline");
    }
    // links lead to parts of the page, and to the tables in the same folder
    for link in html.split("href=\"").skip(1).map(|rest| rest.split('"').next().unwrap()) {
        assert!(link.starts_with('#') || link.ends_with(".csv") && !link.contains("//"), "{link}");
        assert!(!link.starts_with('#') || html.contains(&format!("id=\"{}\"", &link[1..])), "{link} leads nowhere");
    }
}

fn svgs(folder: &Folder) -> Vec<String> {
    let entries = std::fs::read_dir(folder.path().join(FIGURES)).unwrap();
    entries.map(|entry| std::fs::read_to_string(entry.unwrap().path()).unwrap()).collect()
}

#[test]
fn a_comparison_leaves_tables_summary_pictures_and_page() {
    let folder = lasting("output-compare");
    write(&folder, &outcomes());

    let profiles = read(&folder, "profiles.csv");
    assert_eq!(profiles.lines().next(), Some(HEADER));
    assert_eq!(profiles.lines().count(), 1 + 3 * 40);
    let mut reader = ::csv::Reader::from_reader(profiles.as_bytes());
    let rows: Vec<::csv::StringRecord> = reader.records().map(Result::unwrap).collect();
    assert_eq!((&rows[3][13], &rows[3][33]), ("", ""), "not a number is an empty cell");
    assert!(!profiles.contains("NaN"));

    let impacts = read(&folder, "impacts.csv");
    assert!(impacts.starts_with("variant,kind,quantity,unit,bin_lower,bin_upper,count,probability_density\n"));
    assert!(impacts.contains("hard,pair,maximum_overlap,1,0,0,20000,\n"));
    let mut reader = ::csv::Reader::from_reader(impacts.as_bytes());
    let speeds =
        reader.records().map(Result::unwrap).filter(|r| &r[0] == "hard" && &r[1] == "wall" && &r[2] == "normal_speed");
    let f = |text: &str| text.parse::<f64>().unwrap();
    let area: f64 = speeds.map(|r| f(&r[7]) * (f(&r[5]) - f(&r[4]))).sum();
    assert!((area - 1.0).abs() < 1e-12, "a density has area one: {area}");

    let overlaps = read(&folder, "overlaps.csv");
    let mut reader = ::csv::Reader::from_reader(overlaps.as_bytes());
    for row in reader.records().map(Result::unwrap) {
        // here, depths are proportional to speeds, and the integral over time is 0.64 times depth and duration
        let kappa = f(&row[5]);
        assert!((f(&row[7]) / kappa - f(&row[9])).abs() < 1e-9 * f(&row[9]));
        assert!((f(&row[10]) / f(&row[7]) - if &row[1] == "pair" { 0.64 } else { 0.51 / 0.8 }).abs() < 1e-9);
    }
    assert_eq!(overlaps.lines().count(), 1 + 2 * 2, "two soft variants, pairs and walls");

    let summary: serde_json::Value = serde_json::from_str(&read(&folder, "summary.json")).unwrap();
    assert_eq!(summary["status"], "failed");
    assert_eq!(summary["variants"][0]["status"], "complete");
    assert_eq!(summary["variants"][0]["failure"], serde_json::Value::Null);
    assert_eq!(summary["variants"][2]["failure"]["overlap_too_large"]["particle"], 17);
    assert_eq!(summary["variants"][1]["parameters"]["soft"]["stiffness"], 3000.0);
    assert_eq!(summary["variants"][0]["pair_impacts"], 20_000);
    let residual = summary["variants"][1]["energy"]["residual"].as_f64().unwrap();
    assert!((residual - 1e-5).abs() < 1e-12, "{residual}");

    let html = read(&folder, "report.html");
    assert_no_network(&html);
    assert!(html.contains("stopped early") && html.contains("raise soft stiffness"));
    assert!(!html.contains("# <b>"), "the case text is escaped");
    let pictures = svgs(&folder);
    assert_eq!(pictures.len(), 11);
    for svg in &pictures {
        assert_well_formed(svg);
        assert!(!svg.contains("NaN") && !svg.contains("inf"), "a coordinate is not a number");
        assert!(html.contains(svg.as_str()));
    }
}

#[test]
fn state_is_ordered_by_id_and_reads_back_to_the_same_bits() {
    let folder = tempfile::tempdir().unwrap();
    let folder = Folder::create(folder.path().join("new/deep"), false).unwrap();
    write(&folder, &outcomes()[..1]);
    let text = read(&folder, "state.csv");
    assert!(text.starts_with("# diptych state: ") && text.contains("\n# time_s: 5.0\n# box_m: "), "{text}");
    let mut reader = ::csv::ReaderBuilder::new().comment(Some(b'#')).from_reader(text.as_bytes());
    assert_eq!(reader.headers().unwrap(), vec!["id", "x", "y", "z", "vx", "vy", "vz", "diameter", "species"]);
    let first = reader.records().next().unwrap().unwrap();
    assert_eq!(first[4].parse::<f64>().unwrap().to_bits(), (1.0f64 / 3.0).to_bits());
    assert_eq!(first[3].parse::<f64>().unwrap(), 0.064 - 0.001, "inside the box along a periodic axis");
    assert_eq!(&first[8], "polystyrene, 406 um");
}

#[test]
fn results_are_never_replaced_unasked_and_leave_nothing_behind() {
    let place = tempfile::tempdir().unwrap();
    write(&Folder::create(place.path(), false).unwrap(), &outcomes());
    let refused = Folder::create(place.path(), false).unwrap_err().to_string();
    assert!(refused.contains("--overwrite") && refused.contains(&place.path().display().to_string()), "{refused}");

    let folder = Folder::create(place.path(), true).unwrap();
    assert!(place.path().join(SUMMARY).exists(), "old results stay until new ones are there");
    folder.write("profiles.csv", b"new").unwrap();
    let names = |path: &Path| -> Vec<String> {
        let names = std::fs::read_dir(path).unwrap().map(|e| e.unwrap().file_name().into_string().unwrap());
        // the lock file is removed with the folder value that owns it
        names.filter(|name| name != ".diptych-lock").collect()
    };
    let mut left = names(place.path());
    left.sort();
    assert_eq!(left, ["figures", "profiles.csv"], "no old and no temporary file");
    assert!(names(&place.path().join(FIGURES)).is_empty());

    // a comparison that stops between two variants writes all files except the summary, and removes pictures of fewer
    // variants
    folder.write("figures/of-two-variants.svg", b"old").unwrap();
    with_study(&outcomes(), |study| drop(write_part(&folder, study).unwrap()));
    let mut left = names(place.path());
    left.sort();
    let tables = ["figures", "impacts.csv", "overlaps.csv", "profiles.csv", "report.html", "series.csv", "stress.csv"];
    assert_eq!(left, tables);
    assert!(!names(&place.path().join(FIGURES)).contains(&"of-two-variants.svg".to_owned()));
    // the folder is in use until the value is dropped; then its results are protected
    drop(folder);
    assert!(matches!(Folder::create(place.path(), false), Err(OutputError::Occupied { .. })), "it is worth keeping");

    let file = place.path().join("profiles.csv");
    assert!(matches!(Folder::create(&file, false), Err(OutputError::Io { .. })), "a file is no folder");
}

#[test]
fn nothing_at_all_can_be_written() {
    let empty = Outcome {
        particles: 0,
        simulated_seconds: 0.0,
        windows: 0,
        window: f64::NAN,
        profiles: ProfileTable::default(),
        record: Record::default(),
        pair_rate: None,
        energy_at_start: f64::NAN,
        timing: Timing::default(),
        ..outcome("empty", Model::Hard, 1)
    };
    let mut unknown = outcome("not a number", Model::Soft, 2);
    let nan = Some(Estimate::new(f64::NAN, f64::NAN));
    for row in &mut unknown.profiles.slices {
        (row.y, row.estimates) = (f64::NAN, [nan; SLICE_QUANTITIES]);
    }
    let mut single = outcome("one slice", Model::Soft, 3);
    single.profiles.slices.truncate(1);
    single.profiles.slices[0].estimates[1].as_mut().unwrap().error = None;
    let sets = [vec![], vec![empty.clone()], vec![unknown.clone()], vec![single.clone()], vec![single, empty, unknown]];
    for (k, outcomes) in sets.iter().enumerate() {
        let folder = lasting(&format!("output-empty-{k}"));
        write(&folder, outcomes);
        assert!(serde_json::from_str::<serde_json::Value>(&read(&folder, SUMMARY)).is_ok());
        for svg in svgs(&folder) {
            assert_well_formed(&svg);
            assert!(!svg.contains("NaN"), "{svg}");
        }
    }
}

fn bounce(name: &str, model: Model, duration: f64, error: f64) -> Bounce {
    let speed = 0.5;
    let depth = speed * duration / std::f64::consts::PI;
    let path = |scale: f64| -> Vec<PathPoint> {
        let mut path = vec![PathPoint { time: -3e-5, gap: speed * 3e-5, normal_velocity: -speed }];
        let steps = if duration > 0.0 { 20 } else { 1 };
        for k in 0..=steps {
            let phase = std::f64::consts::PI * f64::from(k) / f64::from(steps);
            let (time, gap) = (duration * f64::from(k) / f64::from(steps), -depth * phase.sin() * scale);
            path.push(PathPoint { time, gap, normal_velocity: -speed * phase.cos() * scale });
        }
        path.push(PathPoint { time: duration + 3e-5, gap: speed * 3e-5, normal_velocity: speed });
        path
    };
    let values =
        BounceValues { restitution: Some(1.0 + error), contact_time: Some(duration), maximum_overlap: Some(depth) };
    let exact = Analytic { path: path(1.0), values: BounceValues { restitution: Some(1.0), ..values } };
    Bounce {
        name: name.into(),
        model,
        path: path(1.0 + error),
        values,
        analytic: (duration > 0.0).then_some(exact),
        time_step: (duration > 0.0).then_some(duration / 20.0),
        work: if duration > 0.0 { 20 } else { 1 },
        wall_seconds: 2e-6,
        parameters: serde_json::json!({}),
        failure: None,
    }
}

#[test]
fn an_impact_study_leaves_paths_summary_pictures_and_page() {
    let bounces = [
        bounce("hard", Model::Hard, 0.0, 0.0),
        bounce("soft, k = 3000 N/m", Model::Soft, 2.4e-5, 0.004),
        bounce("soft, k = 300 N/m", Model::Soft, 7.6e-5, 0.02),
    ];
    let provenance = provenance();
    for (name, bounces) in
        [("output-impact", &bounces[..]), ("output-impact-hard", &bounces[..1]), ("output-impact-none", &[])]
    {
        let study = ImpactStudy {
            oblique: None,
            provenance: &provenance,
            bounces,
            requested_restitution: 1.0,
            diameter: 406e-6,
            impact_speed: 0.5,
            verdicts: &["All variants give the restitution asked for within 2 %.".to_string()],
            notes: &[],
        };
        let folder = lasting(name);
        write_impact(&folder, &study).unwrap();
        assert!(read(&folder, "impact.csv").starts_with("variant,t_s,gap_m,normal_velocity_m_s\n"));
        let summary: serde_json::Value = serde_json::from_str(&read(&folder, SUMMARY)).unwrap();
        assert_eq!(summary["variants"].as_array().map(Vec::len), Some(bounces.len()));
        assert_no_network(&read(&folder, "report.html"));
        for svg in svgs(&folder) {
            assert_well_formed(&svg);
            assert!(!svg.contains("NaN"));
        }
    }
    let folder = lasting("output-impact");
    let summary: serde_json::Value = serde_json::from_str(&read(&folder, SUMMARY)).unwrap();
    assert_eq!(summary["variants"][1]["restitution"], 1.004);
}

#[test]
fn numbers_show_the_digits_that_mean_something() {
    assert_eq!(significant(0.0012345, 3), "0.00123");
    assert_eq!(significant(-1.5e-7, 2), "−1.5 × 10⁻⁷");
    assert_eq!(significant(99_999.0, 3), "1.00 × 10⁵");
    assert_eq!(significant(1234.5, 2), "1200");
    // numbers below ten to any negative power that a float can represent
    assert_eq!(significant(3e-324, 2), "4.9 × 10⁻³²⁴");
    assert_eq!(significant(-1.3e-310, 2), "−1.3 × 10⁻³¹⁰");
    assert_eq!(significant(f64::NAN, 3), "–");
    assert_eq!(with_error(Estimate::new(12.3456, 0.0312)), "12.35 ± 0.03");
    assert_eq!(with_error(Estimate::new(12.3456, 0.0142)), "12.346 ± 0.014");
    assert_eq!(with_error(Estimate::new(1.234e6, 2.1e3)), "(1.2340 ± 0.0021) × 10⁶");
    assert_eq!(with_error(Estimate::new(-0.0004, 0.05)), "0.00 ± 0.05");
    assert_eq!(with_error(Estimate::without_error(1.0)), "1.000 ± ?");
    assert_eq!(with_error(None), "–");
    assert_eq!(quantity(4.06e-4, "m", 3), "406 µm");
    assert_eq!(quantity(0.9999e-3, "s", 3), "1.00 ms");
    assert_eq!(quantity(0.0, "s", 3), "0 s");
    assert_eq!(count(512_000_000_123), "512\u{202f}000\u{202f}000\u{202f}123");
}

#[test]
fn an_outcome_is_data_for_other_programs() {
    let mut outcome = outcome("soft", Model::Soft, 3);
    let center = nalgebra::Vector3::new(0.06, 0.02, 0.03);
    let points = [(0.0, 0.0), (0.02, 15.9), (0.04, 0.0)];
    let scene = &mut outcome.experiment.scene;
    scene.walls[1].geometry = WallGeometry::Obstacle(Obstacle::cylinder(center, 2, 0.001, 0.002));
    let fluid = scene.fluid.as_mut().unwrap();
    fluid.profile = Profile::table(&points).unwrap();
    fluid.drag = Some(Drag::Stokes(Stokes));
    let value = serde_json::to_value(&outcome).unwrap();
    assert_eq!(value["experiment"]["run"]["spheres"]["soft"]["linear_spring_dashpot"]["stiffness"], 3000.0);
    assert_eq!(value["experiment"]["scene"]["domain"]["size"][1], 0.04);
    let bodies = &value["experiment"]["scene"]["walls"];
    assert_eq!(bodies[0]["geometry"]["plane"]["point"][1], 0.0);
    assert_eq!(bodies[1]["geometry"]["obstacle"]["shape"]["cylinder"]["half_height"], 0.002);
    assert_eq!(value["profiles"]["slices"][7]["samples"], 2007);
    assert_eq!(value["record"]["pairs"]["count"], 20_000);
    assert_eq!(value["record"]["ledger"]["drag_work"], 0.0123);
    assert_eq!(value["balance"]["weight"], outcome.balance.weight);
    // a failure is an entry under the name of its kind
    outcome.failure = Some(Failure::Escaped { time: 1.5, particle: 7, x: 0.1, y: -0.2, z: 0.3 });
    let failed = serde_json::to_value(&outcome).unwrap();
    assert_eq!(failed["failure"]["escaped"]["time"], 1.5);
}

/// The Python package gives the columns the same units as the table of columns of the program.
#[test]
fn units_of_columns_are_those_of_the_python_package() {
    let root = Path::new(env!("CARGO_MANIFEST_DIR"));
    let text = std::fs::read_to_string(root.join("python/diptych/results.py")).unwrap();
    for column in SLICE_COLUMNS.iter().filter(|column| !column.unit.is_empty()) {
        let key = column.unit.replace('/', "_").replace('²', "2").replace('³', "3");
        let line = text.lines().find(|line| line.trim_start().starts_with(&format!("\"{key}\": ["))).unwrap();
        assert!(line.contains(&format!("\"{}\"", column.name)), "{}: {line}", column.name);
    }
}

/// A report links to the table of every measurement, also of a run with many measurements.
#[test]
fn a_run_with_many_measurements_links_to_all_tables() {
    let out = tempfile::tempdir().unwrap();
    let folder = out.path().join("gas");
    let arguments = ["run", "observables", "--quiet", "--set", "run.duration=10 ms", "--set", "run.average_from=0 s"];
    let done = diptych(&[&arguments[..], &["--out", folder.to_str().unwrap()]].concat()).output().unwrap();
    assert!(done.status.success(), "{}", words(&done.stderr));
    let html = std::fs::read_to_string(folder.join("report.html")).unwrap();
    let files = std::fs::read_dir(&folder).unwrap().map(|file| file.unwrap().file_name().into_string().unwrap());
    let tables: Vec<String> = files.filter(|name| name.ends_with(".csv")).collect();
    assert!(tables.len() > 8, "{tables:?}");
    for table in tables {
        assert!(html.contains(&format!("href=\"{table}\"")), "{table}");
    }
}
