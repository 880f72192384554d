//! Starts of a case: saved states of runs, and tables of the user.

use diptych::case::{Case, saved};
use diptych::experiment::{Experiment, Model};
use std::path::Path;

const HEADER: &str = "x,y,z,vx,vy,vz,diameter,species\n";

/// Reads the small channel of the test inputs without gas, with two species of spheres from the table `text`. Returns
/// the experiment and its warnings.
fn read(text: &str, sets: &[&str], model: Model) -> Result<(Experiment, String), String> {
    read_named("start.csv", text, sets, model)
}

/// Reads the small channel of the test inputs with the text of a file that has another name than the table
/// `start.csv`.
fn read_named(name: &str, text: &str, sets: &[&str], model: Model) -> Result<(Experiment, String), String> {
    let folder = tempfile::tempdir().unwrap();
    std::fs::write(folder.path().join(name), text).unwrap();
    let case = "
        domain = { size = [0.012, 0.004, 0.006], periodic = [\"x\", \"z\"] }
        particles = [
            { name = \"a\", diameter = 4e-4, density = 1000, file = \"start.csv\" },
            { name = \"b\", diameter = 2e-4, density = 1000, file = \"start.csv\" },
        ]
        walls = [{ plane = { point = [0, 0, 0], normal = [0, 1, 0] }, restitution = 0.9, friction = 0 }]
        contact = { restitution = 0.9, friction = 0 }
        soft = { linear_spring_dashpot = { stiffness = 3000 } }
        run = { model = \"hard\", duration = 0.1 }";
    let case = case.replace("start.csv", name);
    let case: String = case.lines().map(|line| line.trim().to_owned() + "\n").collect();
    let sets: Vec<String> = sets.iter().map(|set| (*set).to_owned()).collect();
    let path = folder.path().join("case.toml");
    std::fs::write(&path, case).unwrap();
    let read = Case::read(&path, &sets).and_then(|case| case.experiment(Some(model), None));
    let told = |warnings: Vec<diptych::case::Diagnostic>| warnings.iter().map(|w| w.to_string() + "\n").collect();
    read.map(|(experiment, warnings)| (experiment, told(warnings))).map_err(|error| error.to_string())
}

/// Rock salt: large spheres on a face-centred cubic lattice, small ones in the holes between them. The spheres fill
/// 0.793 of the volume, more than equal spheres can.
#[test]
fn only_equal_spheres_are_held_to_the_densest_packing_of_equal_spheres() {
    let large = 1e-3 * 0.5_f64.sqrt() * (1.0 - 1e-6);
    let salt = |small: f64| {
        let (mut of_large, mut of_small) = (Vec::new(), Vec::new());
        for [x, y, z] in (0..64).map(|k| [k / 16, k / 4 % 4, k % 4]) {
            let place = format!("{{ position = [{}, {}, {}] }}", 5e-4 * x as f64, 5e-4 * y as f64, 5e-4 * z as f64);
            if (x + y + z) % 2 == 0 { of_large.push(place) } else { of_small.push(place) }
        }
        let kind = |name: &str, diameter: f64, places: &[String]| {
            let places = places.join(", ");
            format!("{{ name = \"{name}\", diameter = {diameter:?}, density = 1000, at = [{places}] }}")
        };
        format!(
            "domain = {{ size = [2e-3, 2e-3, 2e-3], periodic = [\"x\", \"y\", \"z\"] }}\n\
             particles = [{}, {}]\ncontact = {{ restitution = 1 }}\nrun = {{ model = \"hard\", duration = 1e-3 }}\n",
            kind("large", large, &of_large),
            kind("small", small, &of_small)
        )
    };
    let read = |small: f64| crate::support::case(&salt(small), Model::Hard, &[]).map(|experiment| experiment.count());
    assert_eq!(read(1e-3 - large - 1e-9), Ok(64));
    let why = read(large).unwrap_err();
    assert!(why.contains("spheres of one size pack no denser than 0.7405"), "{why}");
}

#[track_caller]
fn refused(text: &str, sets: &[&str], model: Model, parts: &[&str]) {
    let Err(message) = read(text, sets, model) else { panic!("{sets:?} was accepted under {model:?}:\n{text}") };
    for part in parts {
        assert!(message.contains(part), "no {part:?} in\n{message}");
    }
}

#[track_caller]
fn refused_named(name: &str, text: &str, parts: &[&str]) {
    let Err(message) = read_named(name, text, &[], Model::Hard) else { panic!("was accepted:\n{text}") };
    for part in parts {
        assert!(message.contains(part), "no {part:?} in\n{message}");
    }
}

/// Table of two spheres of 0.4 mm with an overlap of a tenth of a diameter, and a sphere that overlaps the floor by
/// half of this.
fn deep() -> String {
    let rows = "2e-3,1e-3,1e-3,0,0,0,4e-4,a\n2.36e-3,1e-3,1e-3,0,0,0,4e-4,a\n5e-3,1.8e-4,3e-3,0,0,0,4e-4,a\n";
    format!("{HEADER}{rows}")
}

#[test]
fn a_saved_state_starts_with_its_overlaps() {
    let state = saved::sign(&deep(), 3);
    let steps = "hard.stepping=\"steps\"";
    for (sets, model) in [(&[][..], Model::Soft), (&[steps], Model::Hard)] {
        let (experiment, told) = read(&state, sets, model).unwrap_or_else(|error| panic!("{error}"));
        assert_eq!(experiment.start[0].amount.count(), 3);
        assert!(told.contains("1.000e-1 of a diameter") && told.contains("worst of 2"), "{told}");
    }
    refused(&state, &[], Model::Hard, &["particle 0", "particle 1", "1.000e-1 of a diameter", "worst of 2 overlaps"]);
    // overlaps in a table of the user count as a mistake
    refused(&deep(), &[], Model::Soft, &["up to 0.01 of a diameter"]);
    refused(&deep(), &[steps], Model::Hard, &["1.000e-1 of a diameter"]);
    // an overlap at which a run would stop is refused at the start
    let deeper = deep().replace("2.36e-3", "2.1e-3");
    refused(&saved::sign(&deeper, 3), &[], Model::Soft, &["7.500e-1 of a diameter"]);
}

#[test]
fn a_damaged_state_is_refused() {
    let state = saved::sign(&deep(), 3);
    let cut = state.trim_end().rfind('\n').unwrap();
    refused(&state[..=cut], &[], Model::Soft, &["start.csv:1", "holds 2 particles", "says 3", "save the state again"]);
    refused(&state.replace("2.36e-3", "2.37e-3"), &[], Model::Soft, &["start.csv:1", "checksum"]);
    refused(&state.replace(" particles, ", " "), &[], Model::Soft, &["start.csv:1", "damaged"]);
    refused(&state[..=state.find('\n').unwrap()], &[], Model::Soft, &["holds 0 particles"]);
    // the line ends of another system are not damage
    read(&state.replace('\n', "\r\n"), &[], Model::Soft).unwrap_or_else(|error| panic!("{error}"));
}

#[test]
fn a_table_without_lines_or_with_a_column_twice_does_not_pass() {
    let (experiment, told) = read(HEADER, &[], Model::Hard).unwrap();
    assert_eq!(experiment.start[0].amount.count(), 0);
    assert!(told.contains("no line of numbers"), "{told}");
    let twice = "x,y,z,vx,vy,vz,vx\n1e-3,1e-3,1e-3,0,0,0,1\n";
    refused(twice, &[], Model::Hard, &["start.csv:1", "`vx` twice"]);
}

#[test]
fn velocities_are_limited_however_they_are_given() {
    let fast = format!("{HEADER}1e-3,1e-3,1e-3,0,1e100,0,4e-4,a\n");
    refused(&fast, &[], Model::Hard, &["start.csv:2", "`vy` = 1e100 m/s", "1e5"]);
    let base = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/inputs/good/base.toml");
    let text = std::fs::read_to_string(base).unwrap();
    let (begin, rest) = text.split_once("count = 100").unwrap();
    let (_, end) = rest.split_once("velocity_fluctuation = \"0.5 m/s\"").unwrap();
    let case = format!("{begin}at = [{{ position = [1e-3, 1e-3, 1e-3], velocity = [0, -1e100, 0] }}]{end}");
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("case.toml");
    std::fs::write(&path, case).unwrap();
    let error = Case::read(&path, &[]).and_then(|case| case.experiment(None, None)).unwrap_err().to_string();
    assert!(error.contains("velocity[1]") && error.contains("1e5 m/s") && error.contains("case.toml:21"), "{error}");
}

#[test]
fn overlaps_of_unequal_pairs_name_their_diameter() {
    // radii of 0.2 and 0.1 mm at a distance of 0.29 mm: an overlap of a twentieth of 0.2 mm
    let table = format!("{HEADER}2e-3,1e-3,1e-3,0,0,0,4e-4,a\n2.29e-3,1e-3,1e-3,0,0,0,2e-4,b\n");
    refused(&table, &[], Model::Hard, &["5.000e-2 of the smaller diameter"]);
    let failure = diptych::engine::Failure::OverlapTooLarge {
        time: 0.0,
        particle: 0,
        partner: diptych::engine::Partner::Particle(1),
        ratio: 0.6,
        limit: 0.5,
        way: None,
    };
    assert!(failure.to_string().contains("0.600 of the smaller diameter"), "{failure}");
}

#[test]
fn a_state_says_of_what_run_it_is_and_starts_another_case() {
    let (experiment, _) = read(HEADER, &[], Model::Soft).unwrap();
    let mut particles = diptych::Particles::default();
    let third = 1.0 / 3.0;
    particles.push(
        diptych::Vector3::new(2e-3, 1e-3, third * 1e-2),
        diptych::Vector3::new(third, 0.0, -0.1),
        2e-4,
        1e-9,
        0,
    );
    particles.push(diptych::Vector3::new(5e-3, 1e-3, 1e-3), diptych::Vector3::new(0.0, 0.0, 0.1), 1e-4, 1e-9, 1);
    let about = [("time_s", "0.25".to_owned()), ("case", "0123".to_owned())];
    let text = String::from_utf8(diptych::output::csv::state(&particles, &experiment.scene, &about).unwrap()).unwrap();
    let lines: Vec<&str> = text.lines().collect();
    assert!(lines[0].starts_with("# diptych state: 2 particles, checksum "), "{text}");
    assert_eq!(&lines[1..5], ["# time_s: 0.25", "# case: 0123", "# box_m: 0.012 0.004 0.006", "# periodic: x z"]);
    assert_eq!(lines[5], "id,x,y,z,vx,vy,vz,diameter,species");
    let (again, told) = read(&text, &[], Model::Soft).unwrap();
    let diptych::experiment::Amount::Placed(read_back) = &again.start[0].amount else { panic!() };
    assert_eq!((read_back.position[0], read_back.velocity[0]), (particles.position[0], particles.velocity[0]));
    assert!(!told.contains("was saved with"), "{told}");
    // another box gives a warning; a changed line above the table means a changed state
    let (_, told) = read(&text, &["domain.size[0]=\"13 mm\""], Model::Soft).unwrap();
    assert!(told.contains("was saved with box_m 0.012 0.004 0.006, the case has 0.013 0.004 0.006"), "{told}");
    let (_, told) = read(&text, &["domain.periodic=[\"x\"]"], Model::Soft).unwrap();
    assert!(told.contains("periodic x z, the case has x"), "{told}");
    refused(&text.replace("# time_s: 0.25", "# time_s: 0.26"), &[], Model::Soft, &["start.csv:1", "checksum"]);
}

/// Particles of the first species, and the warnings.
fn first(text: &str, name: &str) -> (diptych::Particles, String) {
    let (experiment, told) = read_named(name, text, &[], Model::Hard).unwrap_or_else(|error| panic!("{error}"));
    let diptych::experiment::Amount::Placed(particles) = &experiment.start[0].amount else { panic!("{told}") };
    (particles.clone(), told)
}

#[test]
fn plain_tables_need_no_velocities_and_may_name_their_units() {
    let (particles, _) = first("x,y,z,species\n1e-3,1e-3,1e-3,a\n", "start.csv");
    assert_eq!((particles.position[0].x, particles.velocity[0].norm()), (1e-3, 0.0));
    let (particles, _) = first("x_mm,y_um,z,vx_mm_s,vy,vz,species\n1.1,1300,1e-3,2.3,0,0,a\n", "start.csv");
    // numbers are rounded as in the case
    assert_eq!((particles.position[0].x, particles.position[0].y, particles.velocity[0].x), (1.1e-3, 1.3e-3, 2.3e-3));
    refused("x_kg,y,z\n1,1,1\n", &[], Model::Hard, &["start.csv:1", "unknown column `x_kg`", "x"]);
    refused("x,x_mm,y,z\n1,1,1,1\n", &[], Model::Hard, &["start.csv:1", "`x` twice"]);
    refused("x_mm,y,z\nnan,1,1\n", &[], Model::Hard, &["start.csv:2", "`x`", "not a finite number"]);
    refused("x,y\n1,1\n", &[], Model::Hard, &["start.csv:1", "lacks z"]);
    refused("x,y,z,vy\n1,1,1,1\n", &[], Model::Hard, &["start.csv:1", "lacks vx, vz", "or none"]);
    refused(
        "id,x,y,z,species\n3,1e-3,1e-3,1e-3,a\n3,3e-3,1e-3,1e-3,a\n",
        &[],
        Model::Hard,
        &["start.csv:3", "`id` = 3"],
    );
}

const XYZ: &str = "2\nLattice=\"0.012 0 0 0 0.004 0 0 0 0.006\" Properties=type:I:1:pos:R:3:velo:R:3:radius:R:1:id:I:1 units=\"m s\"\n\
    1 1e-3 1e-3 2e-3 0.1 0.2 0.3 2e-4 7\n2 5e-3 1e-3 2e-3 0 0 0 1e-4 8\n";

#[test]
fn extended_xyz_is_a_start() {
    let (particles, told) = first(XYZ, "start.xyz");
    assert_eq!((particles.len(), particles.position[0].z, particles.velocity[0].y), (1, 2e-3, 0.2));
    // the warnings are about the case itself, whose numbers have no units
    assert!(
        told.lines()
            .filter(|line| line.starts_with("warning: "))
            .all(|line| line.contains("has no unit") || line.contains("counted anew")),
        "{told}"
    );
    // a file of ASE: chemical symbols and positions only, two instants, no units, and an origin
    let ase = "1\nProperties=species:S:1:pos:R:3\na 9 9 9\n1\nOrigin=\"1.0 0 0\" Properties=species:S:1:pos:R:3 Lattice=\"0.012 0 0 0 0.005 0 0 0 0.006\"\na 1.001 1e-3 2e-3\n";
    let (particles, told) = first(ase, "start.xyz");
    assert!((particles.position[0].x - 1e-3).abs() < 1e-15 && particles.velocity[0].norm() == 0.0);
    assert!(
        told.contains("2 instants, the last") && told.contains("units") && told.contains("box_m 0.012 0.005 0.006"),
        "{told}"
    );
    for (change, parts) in [
        (("2\n", "3\n"), ["start.xyz:1", "3 particles are announced, 2 lines follow"]),
        (("2\nL", "two\nL"), ["start.xyz:1", "the number of particles"]),
        (("pos:R:3", "pos:R:2"), ["start.xyz:2", "`Properties`"]),
        (("0.012 0 0", "0.012 0.1 0"), ["start.xyz:2", "not rectangular"]),
        (("2e-4 7", "2e-4"), ["start.xyz:3", "8 values where"]),
        (("2 5e-3", "0 5e-3"), ["start.xyz:4", "type is 0"]),
        (("2 5e-3", "9 5e-3"), ["start.xyz:4", "the type is 9, the case has 2 kinds"]),
        (("1 1e-3 1e-3", "1 1e-3 one"), ["start.xyz:3", "`y` = \"one\""]),
        (("2e-4 7", "3e-4 7"), ["start.xyz:3", "diameter"]),
    ] {
        refused_named("start.xyz", &XYZ.replacen(change.0, change.1, 1), &parts);
    }
}

const LAMMPS: &str = "LAMMPS data file via write_data, version 29 Sep 2021, timestep = 10, units = si\n\n2 atoms\n2 atom types\n\n\
    -0.001 0.011 xlo xhi\n0 0.004 ylo yhi\n0 0.006 zlo zhi\n\nAtoms # sphere\n\n\
    4 1 4e-4 1000 0 1e-3 2e-3 0 0 0\n9 2 2e-4 1000 5e-3 1e-3 2e-3 0 0 0\n\nVelocities\n\n9 0 0 0 0 0 0\n4 0.1 0.2 0.3 0 0 0\n";

#[test]
fn a_lammps_data_file_is_a_start() {
    let (particles, told) = first(LAMMPS, "start.data");
    assert_eq!((particles.len(), particles.position[0].x, particles.velocity[0].z), (1, 1e-3, 0.3));
    // the warnings are about the case itself, whose numbers have no units
    assert!(
        told.lines()
            .filter(|line| line.starts_with("warning: "))
            .all(|line| line.contains("has no unit") || line.contains("counted anew")),
        "{told}"
    );
    let atomic = "in meters\n1 atoms\n0 0.012 xlo xhi\nAtoms # atomic\n\n1 1 1e-3 1e-3 2e-3\n";
    let (particles, told) = first(atomic, "start.lmp");
    assert_eq!((particles.position[0].x, particles.velocity[0].norm()), (1e-3, 0.0));
    assert!(told.contains("does not say its units"), "{told}");
    for (change, parts) in [
        (("units = si", "units = lj"), ["start.data:1", "\"lj\""]),
        (("# sphere", "# full"), ["start.data:10", "\"full\""]),
        ((" # sphere", ""), ["start.data:10", "does not name its style"]),
        (("Atoms", "Bonds"), ["start.data:1", "no section `Atoms`"]),
        (("0 0.004 ylo", "0 high ylo"), ["start.data:7", "\"high\""]),
        (("9 2 2e-4 1000 5e-3 1e-3 2e-3 0 0 0", "9 2 2e-4"), ["start.data:13", "3 values"]),
        (("0 0.006 zlo zhi", "0 1e-3 0 xy xz yz"), ["start.data:8", "tilted"]),
    ] {
        refused_named("start.data", &LAMMPS.replacen(change.0, change.1, 1), &parts);
    }
}

#[test]
fn a_gas_is_placed_about_a_bed_whose_spheres_all_but_touch() {
    // two layers on the floor with a distance of 1 nm: too near for random positions, but allowed for positions of the
    // user
    let at: Vec<String> = (0..72)
        .map(|k| {
            let (x, y, z) = (k % 6, k / 36, k / 6 % 6);
            let place = |k: i32| f64::from(k) * (1e-3 + 1e-9) + 5e-4 + 1e-9;
            format!("{{ position = [{:e}, {:e}, {:e}] }}", place(x), place(y), place(z))
        })
        .collect();
    for count in [200, 480] {
        let case = format!(
            "domain = {{ size = [0.01, 0.01, 0.01], periodic = [\"x\", \"z\"] }}
            particles = [
                {{ name = \"bed\", diameter = 1e-3, density = 2500, at = [{}] }},
                {{ name = \"gas\", diameter = 1e-3, density = 2500, count = {count} }},
            ]
            walls = [{{ plane = {{ point = [0, 0, 0], normal = [0, 1, 0] }}, restitution = 0.9, friction = 0 }}]
            contact = {{ restitution = 0.9, friction = 0 }}
            run = {{ model = \"hard\", duration = 0.1 }}",
            at.join(", ")
        );
        let case: String = case.lines().map(|line| line.trim().to_owned() + "\n").collect();
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("bed.toml");
        std::fs::write(&path, case).unwrap();
        let experiment = Case::read(&path, &[]).and_then(|case| case.experiment(None, None)).unwrap().0;
        let particles = diptych::placement::initial_state(&experiment).unwrap();
        let apart = |i: usize, j: usize| {
            experiment.scene.domain.separation(&particles.position[i], &particles.position[j]).norm()
        };
        let nearest = (72..72 + count).flat_map(|i| (0..i).map(move |j| (i, j))).map(|(i, j)| apart(i, j));
        assert!(nearest.fold(f64::INFINITY, f64::min) > 1e-3, "{count}");
    }
}
