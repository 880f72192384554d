//! The list of keys must be complete and up to date on its page. Its ranges and required keys must be right. Numbers
//! without units give warnings.

use crate::support::{diptych, words};
use diptych::case::file::CaseFile;
use diptych::case::keys::{Key, KeyTable, schema, tables};
use diptych::case::{Case, Sources, built_in, de, tree};
use diptych::experiment::Model;
use std::collections::BTreeSet;
use std::path::Path;
use std::sync::Arc;

/// Command that writes the page.
const MAKE: &str = "cargo run -- keys --markdown > docs/keys.md";

/// Case with every table that contains other tables: a species with random positions, a species with given positions,
/// and walls of all shapes.
const FULL: &str = r#"
[domain]
size = ["40 mm", "40 mm", "40 mm"]
[fluid]
use = "fluids/air"
[fluid.profile.uniform]
velocity = "0 m/s"
[drag.stokes]
[[particles]]
diameter = "1 mm"
density = "1000 kg/m^3"
count = 2
in = { box = { center = ["5 mm", "5 mm", "5 mm"], half_extents = ["4 mm", "4 mm", "4 mm"] } }
elasticity = { youngs_modulus = "70 GPa" }
[[particles]]
diameter = "1 mm"
density = "1000 kg/m^3"
at = [{ position = ["30 mm", "30 mm", "3 mm"] }]
[[particles]]
diameter = "1 mm"
density = "1000 kg/m^3"
count = 1
in = { cylinder = { center = ["20 mm", "20 mm", "35 mm"], axis = "z", radius = "4 mm", half_height = "4 mm" } }
[[walls]]
plane = { point = ["0 m", "0 m", "0 m"], normal = [0, 1, 0] }
restitution = 0.9
elasticity = { youngs_modulus = "70 GPa" }
[[walls]]
sphere = { center = ["20 mm", "20 mm", "20 mm"], radius = "1 mm" }
restitution = 0.9
[[walls]]
cuboid = { center = ["30 mm", "30 mm", "30 mm"], half_extents = ["1 mm", "1 mm", "1 mm"] }
restitution = 0.9
[[walls]]
cylinder = { center = ["30 mm", "10 mm", "10 mm"], axis = "x", radius = "1 mm", half_height = "1 mm" }
restitution = 0.9
[[walls]]
box = { center = ["10 mm", "30 mm", "10 mm"], half_extents = ["1 mm", "1 mm", "1 mm"] }
restitution = 0.9
[[walls]]
cone = { center = ["10 mm", "10 mm", "30 mm"], axis = "z", lower_radius = "1 mm", upper_radius = "2 mm", half_height = "1 mm" }
restitution = 0.9
[[walls]]
mesh = { file = "tests/inputs/block.stl", unit = "1 mm", position = ["10 mm", "30 mm", "30 mm"], axis = [0, 0, 1] }
restitution = 0.9
[[inlets]]
particles = "particles 0"
rate = "10 1/s"
box = { center = ["20 mm", "35 mm", "10 mm"], half_extents = ["2 mm", "2 mm", "2 mm"] }
[[inlets]]
particles = "particles 0"
rate = "10 1/s"
cylinder = { center = ["35 mm", "35 mm", "10 mm"], axis = "x", radius = "2 mm", half_height = "2 mm" }
[[outlets]]
box = { center = ["5 mm", "35 mm", "20 mm"], half_extents = ["2 mm", "2 mm", "2 mm"] }
[[outlets]]
cylinder = { center = ["5 mm", "20 mm", "20 mm"], axis = "x", radius = "2 mm", half_height = "2 mm" }
[[outlets]]
mesh = { file = "tests/inputs/block.stl", unit = "1 mm", position = ["35 mm", "20 mm", "35 mm"], axis = [0, 0, 1] }
[contact]
restitution = 0.9
[[contact.pairs]]
between = ["particles 0", "particles 1"]
[run]
duration = "1 ms"
"#;

const SPRING: &str = "[soft.linear_spring_dashpot]\nstiffness = \"3000 N/m\"\n";
const HERTZ: &str = "[soft.hertz]\nyoungs_modulus = \"1 GPa\"\n";

/// Path of the entry of [`FULL`] that contains the keys of a table, such as `walls[0].plane`.
fn place(table: &str) -> String {
    let shapes = ["plane", "sphere", "cuboid", "cylinder", "box", "cone", "mesh"];
    let at = shapes.iter().position(|shape| table == format!("walls.{shape}"));
    match (table, at) {
        ("particles.at", _) => "particles[1].at[0]".into(),
        ("inlets.cylinder", _) => "inlets[1].cylinder".into(),
        ("outlets.cylinder", _) => "outlets[1].cylinder".into(),
        ("outlets.mesh", _) => "outlets[2].mesh".into(),
        ("particles.in.cylinder", _) => "particles[2].in.cylinder".into(),
        (_, Some(index)) => table.replace("walls", &format!("walls[{index}]")),
        _ => indexed(table),
    }
}

/// Path of a table in which every list has the index 0, such as `walls[0].motion`.
fn indexed(table: &str) -> String {
    let is_list = |name: &str| tables().iter().any(|other| other.is_list && other.name == name);
    let (mut name, mut path) = (String::new(), String::new());
    for part in table.split('.') {
        name = tree::child_place(&name, part);
        path = tree::child_place(&path, part);
        if is_list(&name) {
            path += "[0]";
        }
    }
    path
}

/// Text of a case with the headings of the lists around a table, the heading of the table, and `line` below it.
fn with_line(table: &str, line: &str) -> String {
    let outer = tables()
        .iter()
        .filter(|other| other.is_list && table.strip_prefix(&other.name).is_some_and(|rest| rest.starts_with('.')));
    let own = tables().iter().filter(|other| other.name == table);
    outer.chain(own).map(|table| table.heading() + "\n").collect::<String>() + line + "\n"
}

/// Reads a text as a case file, without resolving references.
fn read(text: &str) -> Result<CaseFile, String> {
    let mut sources = Sources::default();
    let source = sources.add_file(Path::new("case.toml"), Arc::from(text));
    let tree = tree::parse(text, source, &sources).map_err(|why| why.to_string())?;
    de::read(&tree).map_err(|why| why.diagnostic(&sources).to_string())
}

/// Message of the error when a case is resolved (all its values filled in) with a model; empty without an error.
fn told(text: &str, sets: &[String], model: Option<Model>) -> String {
    let case = Case::from_text(Path::new("case.toml"), Arc::from(text), sets);
    case.and_then(|case| case.experiment(model, None)).err().map_or(String::new(), |why| why.to_string())
}

fn names(table: &KeyTable) -> BTreeSet<String> {
    let inner = tables().iter().filter_map(|other| {
        let rest = other.name.strip_prefix(&table.name)?.strip_prefix('.')?;
        (!rest.contains('.')).then(|| rest.to_owned())
    });
    table.keys.iter().map(|key| key.name.clone()).chain(inner).collect()
}

/// A list in place of a table is refused. Its elements are not read as the values of the keys, in their order.
#[test]
fn a_list_is_no_table() {
    for set in ["domain=[1, 2, 3]", "contact=[]", "drag.schiller_naumann=[]", "walls[1].sphere=[1, 2]"] {
        let said = told(FULL, &[set.to_owned()], None);
        assert!(said.contains("a list where a table belongs"), "{set}: {said}");
    }
}

#[test]
fn the_page_of_keys_is_up_to_date() {
    let page = std::fs::read_to_string(Path::new(env!("CARGO_MANIFEST_DIR")).join("docs/keys.md")).unwrap();
    assert!(
        page == diptych::study::markdown(),
        "docs/keys.md does not tell of the keys as they are; make it by\n{MAKE}"
    );
}

/// The message of serde about an unknown key lists all keys of the table.
#[test]
fn every_key_that_is_read_is_listed() {
    let known = |told: &str| -> BTreeSet<String> {
        let list = told.split_once("known keys: ").or(told.split_once("known names: ")).expect(told).1;
        list.split('`').skip(1).step_by(2).map(str::to_owned).collect()
    };
    let root = read("no_such_key = 1").unwrap_err();
    let roots = tables().iter().filter(|table| !table.name.contains('.')).map(|table| table.name.clone());
    assert_eq!(known(&root), roots.collect());
    for table in tables() {
        let told = read(&with_line(&table.name, "no_such_key = 1")).unwrap_err();
        assert_eq!(known(&told), names(table), "{}: {told}", table.name);
    }
    assert!(tables().len() > 20);
}

#[test]
fn every_example_is_read_and_every_key_explained() {
    for table in tables() {
        assert!(table.about.ends_with('.'), "{} has no sentence", table.name);
        for key in &table.keys {
            let Key { name, example, about, .. } = key;
            let example = example.as_ref().unwrap_or_else(|| panic!("{}.{name} has no example", table.name));
            let line = format!("{name} = {example}");
            read(&with_line(&table.name, &line)).unwrap_or_else(|why| panic!("{}: {line}: {why}", table.name));
            assert!(about.ends_with('.'), "{}.{name} has no sentence", table.name);
            assert!(!key.kind.contains('['), "{}.{name} is {}", table.name, key.kind);
        }
    }
}

/// True if [`FULL`] does not contain the table, so that all required keys of the table must be set.
fn is_new(table: &str) -> bool {
    let outer = ["domain.shear", "particles.sizes", "fluid.profile", "soft.kuwabara_kono", "soft.tangential"];
    let inner = ["soft.rolling", "hard.friction", "observe", "walls.motion"];
    outer.iter().chain(&inner).any(|outer| table.starts_with(outer)) || table.contains(".restitution.")
}

/// A number outside of a range that is given in words, such as "0 ..= 1". `whole` is true for a whole number.
fn outside(range: &str, whole: bool) -> f64 {
    let number = |text: &str| text.trim().split(' ').next().unwrap().parse::<f64>().unwrap();
    match (range.split_once("..="), range.strip_prefix("up to ")) {
        (Some((low, _)), _) if whole => number(low) - 1.0,
        (Some((_, high)), _) => 2.0 * number(high),
        (None, Some(high)) => 2.0 * number(high),
        (None, None) => -2.0,
    }
}

#[test]
fn ranges_are_those_that_messages_name() {
    let mut seen = 0;
    for table in tables() {
        for key in &table.keys {
            let Some(range) = &key.range else { continue };
            let number = outside(range, key.kind == "whole number");
            let value = match key.kind.as_str() {
                kind if kind.starts_with("list of 3") => format!("[{number}, 0, 0]"),
                kind if kind.starts_with("list") => format!("[{number}, {number}]"),
                _ => number.to_string(),
            };
            let path = tree::child_place(&place(&table.name), &key.name);
            let hertzian = table.name.ends_with("hertz") || table.name.ends_with("mindlin");
            let law = if hertzian { HERTZ } else { SPRING };
            let model = match table.name.as_str() {
                "hard" => Model::Hard,
                "hybrid" => Model::Hybrid,
                "dsmc" => Model::Dsmc,
                _ => Model::Soft,
            };
            // the other required keys of the table; the tested key replaces the keys that it excludes
            let others = table.keys.iter().filter(|other| {
                other.name != key.name
                    && other.required.as_ref().is_some_and(|when| when == "always" || when.starts_with("or "))
            });
            let outer = place(&table.name);
            let set = |other: &Key| {
                other.example.as_ref().map(|example| format!("{}={example}", tree::child_place(&outer, &other.name)))
            };
            let others = others.filter_map(set).filter(|_| is_new(&table.name));
            // twisting uses the stiffness of a tangential spring
            let spring =
                (table.name == "soft.twisting").then(|| "soft.tangential.linear.stiffness_ratio=0.3".to_owned());
            // turbulence of a uniform gas needs both keys, and a law
            let eddies = (table.name == "fluid.turbulence")
                .then(|| "fluid.turbulence={ kinetic_energy = 1, dissipation_rate = 1, langevin = {} }".to_owned());
            // an orbit needs a shear
            let shear = (table.name == "domain.shear.orbit").then(|| "domain.shear.rate=-1".to_owned());
            // a list needs an entry before a key of it can be set
            let knots = (table.name == "walls.motion.path")
                .then(|| "walls[0].motion.path=[{ time = 0, displacement = [0, 0, 0] }]".to_owned());
            let others = knots.into_iter().chain(shear).chain(others);
            let sets: Vec<String> = others.chain(spring).chain(eddies).chain([format!("{path}={value}")]).collect();
            let told = told(&format!("{FULL}{law}"), &sets, Some(model));
            assert!(told.contains(&format!("allowed: {range}\n")), "{path} = {value}, {range}: {told}");
            seen += 1;
        }
    }
    assert!(seen > 30);
}

/// The message about a table without keys names exactly the keys that are listed as required.
#[test]
fn required_keys_are_those_that_are_missed() {
    for table in tables().iter().filter(|table| !table.name.ends_with("elasticity") && table.name != "particles.at") {
        let two = if table.name.starts_with("particles") { "" } else { "[[particles]]\ncount = 2\n" };
        let text = with_line(&table.name, "") + two;
        let told: String = [None, Some(Model::Soft), Some(Model::Hard)].map(|model| told(&text, &[], model)).concat();
        for key in &table.keys {
            let path = tree::child_place(&indexed(&table.name), &key.name);
            assert_eq!(told.contains(&format!("`{path}`")), key.required.is_some(), "{path}: {told}");
        }
    }
}

#[test]
fn the_schema_knows_the_keys_of_all_cases() {
    fn look(value: &toml::Value, schema: &serde_json::Value, path: &str, seen: &mut usize) {
        let branches = schema["oneOf"].as_array().map_or(vec![schema], |branches| branches.iter().collect());
        match value {
            toml::Value::Table(_) if path.ends_with(".set") => {}
            toml::Value::Table(table) => {
                let required = schema["required"].as_array().into_iter().flatten().map(|key| key.as_str().unwrap());
                required.for_each(|key| assert!(table.contains_key(key), "{path}: the schema asks for {key}"));
                for (key, value) in table {
                    let inner = branches.iter().find_map(|branch| branch["properties"].get(key));
                    look(value, inner.unwrap_or_else(|| panic!("{path}.{key}")), &format!("{path}.{key}"), seen);
                }
            }
            toml::Value::Array(items) => items.iter().for_each(|item| look(item, &schema["items"], path, seen)),
            _ => *seen += 1,
        }
    }
    let (schema, mut seen) = (schema(), 0);
    for case in built_in::cases() {
        look(&toml::Value::Table(case.text.parse().unwrap()), &schema, &case.name, &mut seen);
    }
    assert!(seen > 1000, "{seen}");
    let printed = words(&diptych(&["keys", "--schema"]).output().unwrap().stdout);
    assert_eq!(serde_json::from_str::<serde_json::Value>(&printed).unwrap(), schema);
    assert!(!printed.contains("\"null\""));
}

/// A law without keys may also be given by its name alone, in the schema and in the reader.
#[test]
fn laws_without_keys_are_names_too() {
    let schema = schema();
    let names = |choice: &serde_json::Value| -> Vec<String> {
        let constants = choice["oneOf"].as_array().unwrap().iter().filter_map(|branch| branch["const"].as_str());
        constants.map(str::to_owned).collect()
    };
    let laws = names(&schema["properties"]["drag"]);
    assert_eq!(laws, ["schiller_naumann", "stokes"]);
    let text = format!("{FULL}{SPRING}");
    for law in laws {
        let text = format!("drag = \"{law}\"\n{}", text.replace("[drag.stokes]\n", ""));
        assert_eq!(told(&text, &[], Some(Model::Hard)), "", "{law}");
    }
    let profile = &schema["properties"]["fluid"]["properties"]["profile"];
    assert_eq!(names(profile), Vec::<String>::new());
    let told = told(&text, &["fluid.profile=uniform".into()], Some(Model::Hard));
    assert!(told.contains("`fluid.profile.uniform.velocity`"), "{told}");
}

/// Warnings about units in the full case with one change.
fn unit_warnings(set: &str) -> Vec<String> {
    let case =
        Case::from_text(Path::new("case.toml"), Arc::from(format!("{FULL}{SPRING}")), &[set.to_owned()]).unwrap();
    let (_, warnings) = case.experiment(Some(Model::Soft), None).unwrap();
    warnings.iter().map(ToString::to_string).filter(|warning| warning.contains("has no unit")).collect()
}

#[test]
fn numbers_without_a_unit_are_told() {
    for (set, parts) in [
        ("run.duration=0.002", ["taken as 0.002 s", "write duration = \"0.002 s\""]),
        ("run.average_from=1e-4", ["taken as 1e-4 s", "average_from = \"1e-4 s\""]),
        ("particles[0].diameter=0.001", ["`particles[0].diameter`", "diameter = \"0.001 m\""]),
        ("soft.linear_spring_dashpot.stiffness=500", ["taken as 500 N/m", "stiffness = \"500 N/m\""]),
        ("gravity.acceleration=[0, -9.81, '0 m/s^2']", ["as -9.81 m/s^2", "[\"0 m/s^2\", \"-9.81 m/s^2\", '0 m/s^2']"]),
        (
            "walls[1].sphere.center=[0.02, 0.02, 0.02]",
            ["`walls[1].sphere.center`", "\"0.02 m\", \"0.02 m\", \"0.02 m\""],
        ),
        ("particles[1].at[0].position=[0.003, 0.003, 0.003]", ["`particles[1].at[0].position`", "\"0.003 m\""]),
    ] {
        let told = unit_warnings(set);
        assert_eq!(told.len(), 1, "{set}: {told:?}");
        assert!(parts.iter().all(|part| told[0].contains(part)), "{set}: {}", told[0]);
    }
    // values that are equal in all units, or have no unit
    for set in
        ["run.average_from=0", "gravity.acceleration=[0, 0, 0.0]", "contact.restitution=0.5", "run.duration=1 ms"]
    {
        assert_eq!(unit_warnings(set), Vec::<String>::new(), "{set}");
    }
}

#[test]
fn cases_of_the_project_give_every_unit() {
    for case in built_in::cases() {
        let case = Case::built_in(&case, &[]).unwrap();
        let variants = case.variants(None).into_iter().flatten().chain(case.experiment(None, None));
        for warning in variants.flat_map(|(_, warnings)| warnings) {
            assert!(!warning.message.contains("has no unit"), "{warning}");
        }
    }
}
