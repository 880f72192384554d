//! Inputs of users. Every bad input is refused with one message that contains the place, the value and the remedy.
//! Every good input, every case and every set of values loads. No input causes a panic.
//!
//! The heading of an input states the expected result. `# expect: line N` and `# expect: text` are about the error
//! message, `# warns: text` about a warning. `# model: soft` restricts the test to that model; by default both models
//! are tested.

use diptych::case::{Case, Diagnostic, parameters};
use diptych::contact_law::ContactLaw;
use diptych::experiment::{Amount, Experiment, Model, Reference, TimeStep};
use nalgebra::Vector3;
use proptest::prelude::*;
use std::path::{Path, PathBuf};
use std::sync::Arc;

fn files(folder: &str, extension: &str) -> Vec<PathBuf> {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join(folder);
    let mut found = Vec::new();
    let mut folders = vec![folder.clone()];
    while let Some(folder) = folders.pop() {
        for entry in std::fs::read_dir(&folder).unwrap_or_else(|error| panic!("{}: {error}", folder.display())) {
            let path = entry.unwrap().path();
            if path.is_dir() {
                folders.push(path);
            } else if path.extension().is_some_and(|known| known == extension) {
                found.push(path);
            }
        }
    }
    found.sort();
    assert!(!found.is_empty(), "no inputs in {}", folder.display());
    found
}

fn notes<'a>(text: &'a str, key: &str) -> Vec<&'a str> {
    let prefix = format!("# {key}: ");
    text.lines().filter_map(|line| line.strip_prefix(&prefix)).collect()
}

fn models(text: &str) -> Vec<Model> {
    match notes(text, "model").first() {
        Some(&"soft") => vec![Model::Soft],
        Some(&"hard") => vec![Model::Hard],
        _ => vec![Model::Soft, Model::Hard],
    }
}

fn experiment(path: &Path, sets: &[&str], model: Option<Model>) -> Result<(Experiment, Vec<Diagnostic>), Diagnostic> {
    let sets: Vec<String> = sets.iter().map(|set| (*set).to_string()).collect();
    Case::read(path, &sets)?.experiment(model, None)
}

fn base() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/inputs/good/base.toml")
}

fn refused(sets: &[&str], model: Model) -> String {
    match experiment(&base(), sets, Some(model)) {
        Ok(_) => panic!("{sets:?} was accepted"),
        Err(error) => error.to_string(),
    }
}

#[test]
fn bad_inputs_are_refused() {
    for path in files("tests/inputs/bad", "toml") {
        let text = std::fs::read_to_string(&path).unwrap();
        let expected = notes(&text, "expect");
        assert!(!expected.is_empty(), "{} says nothing of what it expects", path.display());
        let unknown_model = path.to_string_lossy().contains("27-unknown-model");
        for model in models(&text) {
            let error = match experiment(&path, &[], (!unknown_model).then_some(model)) {
                Ok(_) => panic!("{} was accepted under {model:?}", path.display()),
                Err(error) => error,
            };
            let message = error.to_string();
            for part in &expected {
                let found = match part.strip_prefix("line ") {
                    Some(line) => message.contains(&format!(".toml:{line}:")),
                    None => message.contains(part),
                };
                assert!(found, "{}, {model:?}: no {part:?} in\n{message}", path.display());
            }
            assert!(error.help.is_some(), "no remedy in\n{message}");
            assert!(message.starts_with("error: ") && message.contains("\n --> "), "{message}");
        }
    }
}

#[test]
fn good_inputs_are_accepted() {
    for path in files("tests/inputs/good", "toml") {
        let text = std::fs::read_to_string(&path).unwrap();
        for model in models(&text) {
            let (experiment, warnings) = experiment(&path, &[], Some(model)).unwrap_or_else(|error| panic!("{error}"));
            let told: Vec<String> = warnings.iter().map(ToString::to_string).collect();
            let told = told.join("\n");
            let expected = notes(&text, "warns");
            for part in &expected {
                assert!(told.contains(part), "{}, {model:?}: no {part:?} in\n{told}", path.display());
            }
            assert!(!expected.is_empty() || told.is_empty(), "{}, {model:?}: unexpected\n{told}", path.display());
            assert!(!parameters(&experiment).to_string().contains("null,null"));
        }
    }
}

#[test]
fn every_case_loads_with_no_warning_but_its_own() {
    // scenes of maps have other headings, which tests/maps.rs checks
    for path in files("cases", "toml").into_iter().filter(|path| !path.parent().unwrap().ends_with("limits")) {
        let case = Case::read(&path, &[]).unwrap_or_else(|error| panic!("{error}"));
        let mut all = case.variants(None).unwrap_or_else(|error| panic!("{error}"));
        all.push(case.experiment(None, None).unwrap_or_else(|error| panic!("{error}")));
        all.push(case.experiment(Some(Model::Soft), Some(7)).unwrap_or_else(|error| panic!("{error}")));
        // a case that shows the effect of a bad setting contains the expected warning
        let text = std::fs::read_to_string(&path).unwrap();
        let expected = notes(&text, "warns");
        let told: Vec<String> = all.iter().flat_map(|(_, warnings)| warnings.iter().map(ToString::to_string)).collect();
        for warning in &told {
            assert!(expected.iter().any(|part| warning.contains(part)), "{}: {warning}", path.display());
        }
        for part in expected {
            assert!(told.iter().any(|warning| warning.contains(part)), "{}: no {part:?}", path.display());
        }
        assert!(!case.title.is_empty() && case.heading.contains("Question:"), "{}", path.display());
        assert!(case.heading.contains("Source:") && case.heading.contains("come out:"), "{}", path.display());
        diptych::study::check_text(&case).unwrap_or_else(|error| panic!("{error}"));
    }
}

/// Sets are tables of values that a case may use. Each set is TOML and cites a source.
#[test]
fn every_set_is_cited() {
    for path in files("models", "toml") {
        let text = std::fs::read_to_string(&path).unwrap();
        let table: toml::Table = text.parse().unwrap_or_else(|error| panic!("{}: {error}", path.display()));
        assert!(table.get("source").is_some_and(|source| source.is_str()), "{} cites nothing", path.display());
    }
}

/// N_p in Table 1 of the paper: floor(φ V/V_p), with volume fraction φ, volume V of the box and V_p of a particle.
#[test]
fn numbers_of_particles_of_table_1() {
    for (name, wanted) in
        [("b", 10520), ("c", 35067), ("d", 87668), ("d-friction", 87668), ("e", 712), ("f", 2433), ("g", 7127)]
    {
        let path = Path::new(env!("CARGO_MANIFEST_DIR")).join(format!("cases/channel-{name}.toml"));
        let (experiment, _) = experiment(&path, &[], None).unwrap_or_else(|error| panic!("{error}"));
        match experiment.start[0].amount {
            Amount::Count(count) => assert_eq!(count, wanted, "case {name}"),
            Amount::Placed(_) => panic!("case {name} is not random"),
        }
    }
}

#[test]
fn files_that_are_no_case() {
    let folder = tempfile::tempdir().unwrap();
    let case = |name: &str, bytes: &[u8]| {
        let path = folder.path().join(name);
        std::fs::write(&path, bytes).unwrap();
        experiment(&path, &[], Some(Model::Hard)).map(|_| ()).map_err(|error| error.to_string())
    };
    assert!(case("empty.toml", b"").unwrap_err().contains("is empty"));
    assert!(case("comment.toml", b"# nothing\n").unwrap_err().contains("is empty"));
    let latin = case("latin.toml", b"[domain]\n# caf\xe9\n").unwrap_err();
    assert!(latin.contains("not UTF-8") && latin.contains("line 2") && latin.contains("latin.toml"), "{latin}");
    let binary = case("binary.toml", b"\x7fELF\x02\x01\x01\x00\x00\x00\xff\xfe").unwrap_err();
    assert!(binary.contains("binary.toml"), "{binary}");
    let nul = case("nul.toml", b"\x00\x00\x00\x00").unwrap_err();
    assert!(nul.contains("not TOML"), "{nul}");
    let mut marked = b"\xef\xbb\xbf".to_vec();
    marked.extend(std::fs::read(base()).unwrap());
    case("marked.toml", &marked).unwrap();
    let windows = std::fs::read_to_string(base()).unwrap().replace('\n', "\r\n");
    case("windows.toml", windows.as_bytes()).unwrap();
    let deep = "a = ".to_string() + &"[".repeat(100_000);
    assert!(case("deep.toml", deep.as_bytes()).unwrap_err().contains("not TOML"));
    let folder_as_case = experiment(folder.path(), &[], None).map(|_| ()).unwrap_err().to_string();
    assert!(folder_as_case.contains("it is a folder"), "{folder_as_case}");
    let nowhere = experiment(&folder.path().join("nowhere.toml"), &[], None).map(|_| ()).unwrap_err().to_string();
    assert!(nowhere.contains("no such file"), "{nowhere}");
}

#[test]
fn set_arguments_change_the_case() {
    let with = |sets: &[&str]| experiment(&base(), sets, Some(Model::Soft)).unwrap_or_else(|error| panic!("{error}")).0;
    assert_eq!(with(&["soft.linear_spring_dashpot.stiffness=300N/m"]).soft.law, Some(ContactLaw::linear(300.0)));
    assert_eq!(with(&["domain.size[0]=13 mm"]).scene.domain.size.x, 13e-3);
    assert_eq!(with(&["domain.size.0 = \"13 mm\""]).scene.domain.size.x, 13e-3);
    assert_eq!(with(&["run.duration=1", "run.duration=2"]).run.duration, 2.0);
    assert_eq!(with(&["walls.1.friction=0.3"]).scene.walls[1].surface.friction, 0.3);
    // an alternative key is removed by the `--set` argument
    assert_eq!(with(&["particles.0.volume_fraction=0.01"]).start[0].amount.count(), 82);
    assert_eq!(with(&["soft.time_step=1e-7 s"]).soft.time_step, TimeStep::Fixed(1e-7));
    assert_eq!(
        with(&["drag.stokes={}"]).scene.fluid.unwrap().drag.unwrap(),
        diptych::drag::Drag::Stokes(diptych::drag::Stokes)
    );
    assert!(with(&["fluid.profile.k_epsilon_channel.reynolds_number=42000"]).scene.fluid.is_some());
    let gas = with(&["fluid.profile.log_law.reynolds_number=42000", "fluid.profile.log_law.friction_velocity=8 m/s"]);
    assert_eq!(gas.scene.fluid.unwrap().profile.wall_scale().unwrap().friction_velocity, 8.0);
    assert_eq!(with(&["particles[0].velocity_fluctuation=1"]).start[0].velocity_fluctuation, Vector3::repeat(1.0));
    let each = with(&["particles[0].velocity_fluctuation=[1, \"20 cm/s\", 0]"]).start[0].velocity_fluctuation;
    assert_eq!(each, Vector3::new(1.0, 0.2, 0.0));
    let placed = with(&["particles[0].at=[{position=[1e-3,1e-3,1e-3],velocity=[0,0,1]}]"]);
    assert!(matches!(&placed.start[0].amount, Amount::Placed(list) if list.len() == 1));
}

#[test]
fn set_arguments_that_are_wrong() {
    for (set, parts) in [
        (
            "contact.restitution=1.2",
            vec!["`contact.restitution` = 1.2", "0 ..= 1", "--> --set contact.restitution=1.2"],
        ),
        ("contact.restituion=0.9", vec!["unknown key `restituion`", "did you mean", "--> --set"]),
        ("run.duration=1,5 s", vec!["decimal comma", "1.5 s"]),
        ("run.duration", vec!["not key=value"]),
        ("=1", vec!["a name is missing"]),
        ("walls[7].friction=0", vec!["`walls` has 2 elements"]),
        ("walls[x].friction=0", vec!["an index is a whole number"]),
        ("run.duration.x=0", vec!["`run.duration` is a string"]),
        ("obstacles[0].x=0", vec!["no list `obstacles`"]),
        ("run.duration=1979-05-27", vec!["is a date"]),
        ("run=3", vec!["`run` = 3", "a table"]),
        ("contact.restitution=1e400", vec!["finite"]),
        ("particles[0].count=1e2", vec!["a whole number"]),
        ("particles[0].count=99999999999999999999", vec!["a whole number"]),
        ("walls[1].velocity=[0 m/s, 0, 1 m/s]", vec!["--set 'walls[1].velocity=[\"0 m/s\", 0, \"1 m/s\"]'"]),
        ("particles[0].count=-1", vec!["`particles[0].count` = -1", "0 ..="]),
    ] {
        let message = refused(&[set], Model::Soft);
        for part in parts {
            assert!(message.contains(part), "{set}: no {part:?} in\n{message}");
        }
    }
}

#[test]
fn variants_of_a_comparison() {
    let text = std::fs::read_to_string(base()).unwrap()
        + "\n[[compare]]\nname = \"a\"\nmodel = \"hard\"\n\n[[compare]]\nname = \"b\"\nmodel = \"soft\"\nset = { \"soft.time_step\" = \"1e-7 s\", \"contact.restitution\" = 0.5 }\n";
    let case = |text: &str, sets: &[&str]| {
        let sets: Vec<String> = sets.iter().map(|set| (*set).to_string()).collect();
        Case::from_text(&base(), Arc::from(text), &sets).unwrap_or_else(|error| panic!("{error}"))
    };
    let variants = case(&text, &[]).variants(Some(5)).unwrap_or_else(|error| panic!("{error}"));
    let names: Vec<&str> = variants.iter().map(|(experiment, _)| experiment.name.as_str()).collect();
    assert_eq!(names, ["a", "b"]);
    assert_eq!(variants[1].0.soft.time_step, TimeStep::Fixed(1e-7));
    assert_eq!(variants[0].0.scene.contact.restitution, 0.9);
    assert_eq!(variants[1].0.scene.contact.restitution, 0.5);
    assert_eq!(variants[1].0.run.seed, 5);
    // the command line has priority over the variant
    let variants = case(&text, &["contact.restitution=0.7"]).variants(None).unwrap_or_else(|error| panic!("{error}"));
    assert_eq!(variants[1].0.scene.contact.restitution, 0.7);
    // the message about a set of a variant contains the line of the set
    let line = text.lines().count();
    let bad = text.replace("\"contact.restitution\" = 0.5", "\"contact.restitution\" = 1.5");
    let error = case(&bad, &[]).variants(None).map(|_| ()).unwrap_err().to_string();
    assert!(error.contains(&format!("base.toml:{line}:")) && error.contains("= 1.5"), "{error}");
    // reference of a variant
    let against = |of_a: &str, of_b: &str| {
        let text = text.replace("name = \"a\"", &format!("name = \"a\"\n{of_a}"));
        let text = text.replace("name = \"b\"", &format!("name = \"b\"\n{of_b}"));
        let found = case(&text, &[]).variants(None);
        found.map(|all| all.into_iter().map(|(one, _)| one.against).collect::<Vec<_>>()).map_err(|e| e.to_string())
    };
    assert_eq!(against("", "against = \"a\"").unwrap(), [None, Some(Reference::Variant("a".into()))]);
    let error = against("", "against = \"c\"").unwrap_err();
    assert!(error.contains("no variant is called \"c\"") && error.contains("\"a\", \"b\""), "{error}");
    let error = against("against = \"b\"", "against = \"a\"").unwrap_err();
    assert!(error.contains("itself compared with another"), "{error}");
    assert!(against("against = \"a\"", "").is_err(), "not with itself");
    let twice = text.replace("name = \"b\"", "name = \"a\"");
    assert!(case(&twice, &[]).variants(None).is_err());
    // without a list, the variants are soft and hard
    let plain = std::fs::read_to_string(base()).unwrap();
    let variants = case(&plain, &[]).variants(None).unwrap_or_else(|error| panic!("{error}"));
    assert_eq!(
        variants.iter().map(|(experiment, _)| experiment.model()).collect::<Vec<_>>(),
        [Model::Soft, Model::Hard]
    );
}

#[test]
fn a_table_serves_two_kinds() {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/inputs/good/file-of-two-species.toml");
    let (experiment, _) = experiment(&path, &[], Some(Model::Hard)).unwrap_or_else(|error| panic!("{error}"));
    let counts: Vec<usize> = experiment.start.iter().map(|population| population.amount.count()).collect();
    assert_eq!(counts, [2, 1]);
}

/// Reads a case with any part removed, inserted or repeated: there is a result or a message, but no panic.
fn answers(text: &str) {
    if let Ok(case) = Case::from_text(&base(), Arc::from(text), &[]) {
        for model in [Model::Soft, Model::Hard] {
            if let Err(error) = case.experiment(Some(model), None) {
                assert!(!error.to_string().is_empty());
            }
        }
        let _ = case.variants(None);
    }
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 300, failure_persistence: None, ..ProptestConfig::default() })]

    #[test]
    fn mutated_cases_never_panic(
        edits in prop::collection::vec((any::<prop::sample::Index>(), 0usize..6, "\\PC{0,6}|[-0-9.eEinfa\"'\\[\\]{}=,#\n]{0,6}"), 1..6)
    ) {
        let mut text: Vec<char> = std::fs::read_to_string(base()).unwrap().chars().collect();
        for (at, cut, put) in edits {
            let at = at.index(text.len().max(1)).min(text.len());
            let end = (at + cut).min(text.len());
            text.splice(at..end, put.chars());
        }
        answers(&text.into_iter().collect::<String>());
    }

    #[test]
    fn replaced_values_never_panic(
        line in any::<prop::sample::Index>(),
        value in prop_oneof![
            Just("1e308".to_string()), Just("-1e-308".into()), Just("5e-324".into()), Just("[]".into()), Just("{}".into()), Just("\"\"".into()),
            Just("9223372036854775807".into()), Just("-9223372036854775808".into()), Just("nan".into()), Just("true".into()),
            Just("[1e308, 1e308, 1e308]".into()), Just("[0, 1e-300, 0]".into()), Just("[[[]]]".into()), Just("\"1e300 m\"".into()),
            any::<f64>().prop_map(|number| format!("{number:e}").replace("NaN", "nan")),
            any::<i64>().prop_map(|number| number.to_string()),
            "\"[0-9]{1,3}(.[0-9]{1,3})?(e-?[0-9]{1,3})? ?(m|s|um|m/s|kg/m\\^3|N/m|%)\"",
        ]
    ) {
        let text = std::fs::read_to_string(base()).unwrap();
        let keys: Vec<usize> = text.lines().enumerate().filter(|(_, l)| l.contains('=')).map(|(i, _)| i).collect();
        let chosen = keys[line.index(keys.len())];
        let lines: Vec<String> = text.lines().enumerate().map(|(i, l)| match l.split_once('=') {
            Some((key, _)) if i == chosen => format!("{key}= {value}"),
            _ => l.to_string(),
        }).collect();
        answers(&lines.join("\n"));
    }

    #[test]
    fn set_arguments_never_panic(set in "[a-z_.0-9\\[\\]]{0,20}=?\\PC{0,12}") {
        if let Ok(case) = Case::read(&base(), &[set]) {
            let _ = case.experiment(Some(Model::Soft), None);
        }
    }

    #[test]
    fn quantities_never_panic(text in "\\PC{0,24}") {
        let _ = diptych::case::quantity::parse(&text, [1, 0, 0]);
    }
}

/// The command `check` accepts every case that `run` accepts.
#[test]
fn what_runs_passes_the_check() {
    let mut one_model = 0;
    for path in files("tests/inputs/good", "toml").into_iter().chain(files("cases", "toml")) {
        let case = Case::read(&path, &[]).unwrap();
        if case.experiment(None, None).is_err() {
            continue; // this case is for the other model
        }
        let text = diptych::study::check_text(&case).unwrap_or_else(|why| panic!("{}: {why}", path.display()));
        if case.variants(None).is_err() {
            assert!(text.contains("`compare` cannot run soft and hard") && text.contains("error: "), "{text}");
            one_model += 1;
        }
    }
    assert!(one_model >= 2);
    // variants in the case file belong to the case, and are checked too
    let text = std::fs::read_to_string(base()).unwrap()
        + "[[compare]]\nname = \"a\"\nmodel = \"soft\"\n\
        set = { \"contact.restitution\" = 2.0 }\n";
    let case = Case::from_text(&base(), Arc::from(text), &[]).unwrap();
    assert!(case.experiment(None, None).is_ok() && diptych::study::check_text(&case).is_err());
}

/// Warnings or message of the small case in a gas whose velocity is a table with the given rows.
fn in_tabulated_gas(rows: &str, sets: &[String]) -> Result<Vec<String>, String> {
    let place = tempfile::tempdir().unwrap();
    std::fs::write(place.path().join("gas.csv"), format!("y_m,U_m_s\n{rows}")).unwrap();
    let uniform = "[fluid.profile.uniform]\nvelocity = \"12 m/s\"\n";
    let text = std::fs::read_to_string(base()).unwrap();
    let text = text.replace(uniform, "[fluid.profile.table]\nfile = \"gas.csv\"\n");
    let case = Case::from_text(&place.path().join("case.toml"), Arc::from(text), sets);
    let checked = case.and_then(|case| case.experiment(Some(Model::Hard), None));
    let told = checked.map(|(_, warnings)| warnings.iter().map(ToString::to_string).collect());
    told.map_err(|why| why.to_string())
}

/// The distance between the walls of the small case is 4 mm, and its particles have a radius of 203 um.
#[test]
fn a_gas_table_covers_the_gap() {
    for good in ["0,0\n0.002,12\n0.004,0\n", "-1,5\n0,5\n0.004,5\n9,5\n", "0.0002,1\n0.001,9\n0.0038,1\n"] {
        assert_eq!(in_tabulated_gas(good, &[]), Ok(Vec::new()), "{good}");
    }
    for partly in ["0.001,9\n0.002,12\n0.004,0\n", "0,0\n0.002,12\n", "0.0003,1\n0.004,0\n"] {
        let told = in_tabulated_gas(partly, &[]).unwrap().join("\n");
        assert!(
            told.contains("uncovered") && told.contains("from y = ") && told.contains("0.004 m"),
            "{partly}: {told}"
        );
    }
    // tables in millimetres, or for another channel
    for wrong in ["0,0\n1,11\n2,12\n3,11\n4,0\n", "0.01,5\n0.02,5\n"] {
        let told = in_tabulated_gas(wrong, &[]).unwrap_err();
        assert!(told.contains("in metres") && told.contains("gas.csv") && told.contains("0.004 m"), "{wrong}: {told}");
    }
}

#[test]
fn a_drag_law_far_from_its_range_is_told() {
    let warned = |sets: &[&str]| {
        let (_, warnings) = experiment(&base(), sets, Some(Model::Hard)).unwrap();
        warnings.iter().any(|warning| warning.to_string().contains("Reynolds numbers up to"))
    };
    // at the start, the Reynolds number per slip speed of these spheres is 27 per m/s
    assert!(!warned(&["particles[0].velocity_mean=[0, 0, 300]"]));
    assert!(warned(&["particles[0].velocity_mean=[0, 0, 500]"]));
    // the Reynolds number of the fall is 9.81 m/s² τ(w) d/ν: heavy spheres of the size of a marble in water
    let marble = ["particles[0].diameter=1.5 mm", "particles[0].count=2", "particles[0].density=19000"];
    let water = ["fluid.kinematic_viscosity=1e-7", "fluid.density=1", "fluid.profile.uniform.velocity=0"];
    assert!(warned(&[&marble[..], &water[..], &["particles[0].velocity_mean=[0, 0, 0]"]].concat()));
}

#[test]
fn endless_runs_are_refused_with_their_length() {
    for (sets, model, parts) in [
        (&["run.window=1e-300"][..], Model::Hard, &["windows of 1.000e-300 s", "up to 1e9", "run.allow_long"][..]),
        (&["run.window=5e-11"], Model::Soft, &["2.000e9 windows", "run.allow_long"]),
        (&["soft.time_step=1e-300"], Model::Soft, &["time steps of 1.000e-300 s", "run.allow_long"]),
        (&["soft.time_step=5e-11", "soft.stepping=uniform"], Model::Soft, &["2.000e9 time steps", "up to 1e9"]),
        (&["run.duration=1e300"], Model::Hard, &["run.duration", "0 ..= 1e9 s"]),
        (&["gravity.acceleration=[0, -1e15, 0]"], Model::Hard, &["gravity.acceleration", "1e9 m/s^2"]),
        (&["soft.linear_spring_dashpot.stiffness=1e26"], Model::Soft, &["stiffness", "1e20 N/m"]),
        (&["soft.linear_spring_dashpot.stiffness=1e-30"], Model::Soft, &["stiffness", "1e-9 "]),
    ] {
        let told = refused(sets, model);
        assert!(parts.iter().all(|part| told.contains(part)) && told.contains("help: "), "{sets:?}: {told}");
    }
    // the run is accepted if the window is short enough, or if long windows are allowed
    for sets in [&["run.window=2e-10"][..], &["run.window=1e-11", "run.allow_long=true"], &["soft.time_step=1e-12"]] {
        assert!(experiment(&base(), sets, Some(Model::Soft)).is_ok(), "{sets:?}");
    }
    let case = Case::read(&base(), &["run.window=1 ms".to_owned()]).unwrap();
    let text = diptych::study::check_text(&case).unwrap();
    assert!(text.contains("100 windows of 1.0000e-3 s"), "{text}");
}

#[test]
fn a_logarithmic_law_is_refused_with_its_reason() {
    let law = |settings: &str| {
        let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("cases/channel-d.toml");
        let set = format!("fluid.profile={{ log_law = {{ {settings} }} }}");
        experiment(&path, &[&set], Some(Model::Hard)).unwrap_err().to_string()
    };
    assert!(law("").contains("`fluid.profile.log_law.friction_velocity` (or `reynolds_number`"), "{}", law(""));
    let both = law("friction_velocity = 0.8, reynolds_number = 42000");
    assert!(both.contains("`friction_velocity` and `reynolds_number`, which exclude each other"), "{both}");
    assert!(law("reynolds_number = 5000").contains("allowed: 6000 ..= 1e8"));
    assert!(law("friction_velocity = 0.05").contains("gives no turbulent channel"));
    assert!(law("friction_velocity = 0.8, von_karman = 4").contains("allowed: 0.2 ..= 0.8"));
    assert!(law("friction_velocity = 0.8, intercept = \"5 m\"").contains("intercept"));
    let three = refused(&["particles[0].velocity_fluctuation=[1, 2]"], Model::Hard);
    assert!(three.contains("list of length"), "{three}");
    let negative = refused(&["particles[0].velocity_fluctuation=[1, -2, 0]"], Model::Hard);
    assert!(negative.contains("velocity_fluctuation[1]"), "{negative}");
}

#[test]
fn messages_of_extreme_numbers_stay_short_and_true() {
    let channel = |sets: &[&str]| {
        let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("cases/channel-d.toml");
        experiment(&path, sets, Some(Model::Hard)).unwrap_err().to_string()
    };
    // the message contains one range, that of the requested model
    let reynolds = "fluid.profile.k_epsilon_channel.reynolds_number=5000";
    let told = channel(&[reynolds]);
    assert!(told.contains("allowed: 10000 ..= 1e8"), "{told}");
    let told = channel(&[reynolds, "fluid.profile.k_epsilon_channel.model=launder_sharma"]);
    assert!(told.contains("allowed: 6000 ..= 1e8"), "{told}");
    for sets in [
        "fluid.kinematic_viscosity=1e300",
        "particles[0].density=1e300",
        "particles[0].diameter=1e300",
        "run.seed=9223372036854775808",
        "particles[0].count=9000000000",
    ] {
        let told = refused(&[sets], Model::Hard);
        assert!(told.lines().all(|line| line.chars().count() < 200), "{told}");
    }
    assert!(refused(&["run.seed=9223372036854775808"], Model::Hard).contains("9223372036854775807"));
    let told = refused(&["particles[0].count=9000000000"], Model::Hard);
    assert!(told.contains("2.700e3 GB") && told.contains("50000000"), "{told}");
}
