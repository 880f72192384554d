//! Extended XYZ, LAMMPS data files and dumps.

use super::Expected::{self, Read, Refused};
use super::{combinations, judge, read};
use diptych::experiment::{Amount, Experiment, Model};

/// Case of a box of 20 mm, with one or two species of beads from the file. All of its warnings are about the file.
const ONE: &str = "domain = { size = [\"20 mm\", \"20 mm\", \"20 mm\"], periodic = [\"x\", \"y\", \"z\"] }\n\
    particles = [{ name = \"glass\", diameter = \"2 mm\", density = \"2500 kg/m^3\", file = \"FILE\" }]\n\
    contact = { restitution = 0.9 }\nsoft = { linear_spring_dashpot = { stiffness = \"10 kN/m\" } }\nrun = { duration = \"1 ms\" }\n";

fn two() -> String {
    let steel = "{ name = \"steel\", diameter = \"1 mm\", density = \"7800 kg/m^3\", file = \"FILE\" }]";
    ONE.replace("file = \"FILE\" }]", &format!("file = \"FILE\" }}, {steel}"))
}

/// Particles after reading: position [mm] and velocity [m/s] of each particle, by species and in the order of the
/// store.
fn states(experiment: &Experiment) -> Vec<[f64; 6]> {
    let placed = experiment.start.iter().flat_map(|population| match &population.amount {
        Amount::Placed(particles) => {
            (0..particles.len()).map(|k| (particles.position[k], particles.velocity[k])).collect()
        }
        Amount::Count(_) => Vec::new(),
    });
    let rounded = |value: f64, unit: f64| (value / unit * 1e4).round() / 1e4 + 0.0;
    placed
        .map(|(x, v)| std::array::from_fn(|k| if k < 3 { rounded(x[k], 1e-3) } else { rounded(v[k - 3], 1.0) }))
        .collect()
}

fn found(name: &str, text: &str, case: &str) -> Result<(Vec<[f64; 6]>, Vec<String>), String> {
    read(name, text.as_bytes(), case, Model::Hard).map(|(experiment, told)| (states(&experiment), told))
}

/// Rows of a table: name of the oddity, changes to the file, and expected result.
type Rows<'a> = Vec<(&'a str, &'a [(&'a str, &'a str)], Expected)>;

fn judge_rows(name: &str, whole: &str, case: &str, rows: &Rows) {
    for (what, changes, expected) in rows {
        let mut text = whole.to_owned();
        for (from, to) in *changes {
            assert!(text.contains(from), "{what}: {from}");
            text = text.replacen(from, to, 1);
        }
        let found = found(name, &text, case).map(|(states, told)| (states.len(), told));
        judge(&format!("{name}, {what}"), &found, expected);
    }
}

/// Positions [mm] and velocities [m/s] that are expected for the two beads in the files of these tests.
const BEADS: [[f64; 6]; 2] = [[5.0, 5.0, 5.0, 1.0, 0.25, 0.0], [15.0, 5.0, 5.0, -1.0, 0.0, 0.5]];

const XYZ: &str = "2\nLattice=\"0.02 0 0 0 0.02 0 0 0 0.02\" Properties=species:S:1:pos:R:3:velo:R:3 pbc=\"T T T\" units=\"m s\"\n\
    X 0.005 0.005 0.005 1 0.25 0\nX 0.015 0.005 0.005 -1 0 0.5\n";

#[test]
fn xyz_is_read_whatever_its_columns_are_called() {
    let (states, told) = found("start.xyz", XYZ, ONE).unwrap();
    assert_eq!((&states[..], told), (&BEADS[..], vec![]));
    // mass of a bead of 2 mm: 2500 pi/6 8e-9 kg
    let momenta = "momenta:R:3:masses:R:1";
    let (p, m) = (2500.0 * std::f64::consts::PI / 6.0 * 8e-9, "1.0471975511965977e-5");
    let with_momenta = XYZ.replace("velo:R:3", momenta).replace("1 0.25 0\n", &format!("{p} {} 0 {m}\n", 0.25 * p));
    let with_momenta = with_momenta.replace("-1 0 0.5", &format!("-{p} 0 {} {m}", 0.5 * p));
    assert_eq!(found("start.xyz", &with_momenta, ONE).unwrap(), (BEADS.to_vec(), vec![]));
    for names in [
        "vel:R:3",
        "Velocity:R:3",
        "vx:R:1:vy:R:1:vz:R:1",
        "v_x:R:1:v_y:R:1:v_z:R:1",
        "v_vx:R:1:v_vy:R:1:v_vz:R:1",
        "Velocity.X:R:1:Velocity.Y:R:1:Velocity.Z:R:1",
    ] {
        let text = XYZ.replace("velo:R:3", names);
        assert_eq!(found("start.xyz", &text, ONE).unwrap(), (BEADS.to_vec(), vec![]), "{names}");
        // the format is found from the contents, for any name of the file
        assert_eq!(found("bed.txt", &text, ONE).unwrap(), (BEADS.to_vec(), vec![]), "{names}");
    }
}

#[test]
fn xyz_is_right_or_refused() {
    let none: &[&str] = &[];
    let rows: Rows = vec![
        (
            "one of three velocities",
            &[("velo:R:3", "vx:R:1:a:R:1:b:R:1")],
            Refused(&["start.xyz:2", "lack vy, vz, of the velocity"]),
        ),
        ("velocities twice", &[("velo:R:3", "velo:R:3:vel:R:3")], Refused(&["start.xyz:2", "`vel` says again"])),
        ("columns left aside", &[("velo:R:3", "force:R:3")], Read(2, &["left aside: force"])),
        (
            "momenta without masses",
            &[("velo:R:3", "momenta:R:3"), ("1 0.25 0", "1e-6 0 0"), ("-1 0 0.5", "0 0 0")],
            Read(2, &["over the masses of the case"]),
        ),
        (
            "another diameter",
            &[("velo:R:3", "diameter:R:1"), ("1 0.25 0", "0.004"), ("-1 0 0.5", "0.002")],
            Refused(&["start.xyz:3", "`diameter` = 4e-3 m, but \"glass\" has 2e-3 m"]),
        ),
        ("diameters", &[("velo:R:3", "diameter:R:1"), ("1 0.25 0", "0.002"), ("-1 0 0.5", "2e-3")], Read(2, none)),
        (
            "single precision",
            &[("velo:R:3", "diameter:R:1"), ("1 0.25 0", "2.000000095e-3"), ("-1 0 0.5", "0.0020000000949949026")],
            Read(2, none),
        ),
        ("radii", &[("velo:R:3", "radius:R:1"), ("1 0.25 0", "0.001"), ("-1 0 0.5", "1.00000005e-3")], Read(2, none)),
        (
            "another radius",
            &[("velo:R:3", "radius:R:1"), ("1 0.25 0", "0.002"), ("-1 0 0.5", "1e-3")],
            Refused(&["start.xyz:3", "`diameter` = 4e-3 m"]),
        ),
        (
            "diameter and radius that differ",
            &[("velo:R:3", "radius:R:1:diameter:R:1"), ("1 0.25 0", "0.002 0.002"), ("-1 0 0.5", "1e-3 2e-3")],
            Refused(&["start.xyz:3", "but `radius` = 2e-3 m"]),
        ),
        (
            "another density",
            &[("velo:R:3", "density:R:1"), ("1 0.25 0", "2500"), ("-1 0 0.5", "1000")],
            Refused(&["start.xyz:4", "`density` = 1e3 kg/m^3"]),
        ),
        (
            "another mass",
            &[("velo:R:3", "mass:R:1"), ("1 0.25 0", "1.04719755e-5"), ("-1 0 0.5", "1.1e-5")],
            Refused(&["start.xyz:4", "`mass` = 1.1e-5 kg"]),
        ),
        ("one bead fewer", &[("2\n", "3\n")], Refused(&["start.xyz:1", "3 particles are announced, 2 lines follow"])),
        ("one value fewer", &[("-1 0 0.5", "-1 0")], Refused(&["start.xyz:4", "has 6 values where"])),
        ("one value more", &[("-1 0 0.5", "-1 0 0.5 7")], Refused(&["start.xyz:4", "has 8 values where"])),
        ("no number", &[("-1 0 0.5", "-1 0 0,5")], Refused(&["start.xyz:4", "\"0,5\""])),
        (
            "two species for one kind",
            &[("X 0.015", "Y 0.015")],
            Refused(&["start.xyz:4", "species Y beside species X"]),
        ),
        (
            "two types for one kind",
            &[("species:S:1", "type:I:1"), ("X", "1"), ("X", "2")],
            Refused(&["start.xyz:4", "type 2 beside type 1"]),
        ),
        ("one type", &[("species:S:1", "type:I:1"), ("X", "3"), ("X", "3")], Read(2, none)),
        ("ids from 1", &[("species:S:1", "id:I:1"), ("X", "1"), ("X", "2")], Read(2, &["1 to 2, are counted anew"])),
        ("ids from 0", &[("species:S:1", "id:I:1"), ("X", "1"), ("X", "0")], Read(2, none)),
        (
            "an id twice",
            &[("species:S:1", "id:I:1"), ("X", "1"), ("X", "1")],
            Refused(&["start.xyz:4", "`id` = 1 stands in two lines"]),
        ),
        (
            "an id that is none",
            &[("species:S:1", "id:I:1"), ("X", "1"), ("X", "b")],
            Refused(&["start.xyz:4", "\"b\" is not a whole number"]),
        ),
        ("another box", &[("0.02 0 0 0", "0.03 0 0 0")], Read(2, &["box_m 0.03 0.02 0.02"])),
        ("a box in single precision", &[("0.02 0 0 0", "0.0199999996 0 0 0")], Read(2, none)),
        ("walls there", &[("T T T", "T F T")], Read(2, &["periodic x z, the case has x y z"])),
        ("a tilted box", &[("0.02 0 0 0", "0.02 0.01 0 0")], Refused(&["start.xyz:2", "not rectangular"])),
    ];
    judge_rows("start.xyz", XYZ, ONE, &rows);
    // the store has the order of the ids
    let turned = XYZ.replace("species:S:1", "id:I:1").replacen('X', "1", 1).replacen('X', "0", 1);
    assert_eq!(found("start.xyz", &turned, ONE).unwrap().0, [BEADS[1], BEADS[0]]);
}

/// The box of a sheared case may be tilted along z, as in the frames that this program writes. If the tilt differs
/// from the displacement of the images in the case, a warning says so.
#[test]
fn the_box_of_a_sheared_case_may_be_tilted() {
    let sheared = ONE.replace("\"z\"] }", "\"z\"], shear = { rate = \"50 1/s\", offset = \"4 mm\" } }");
    let tilted = |tilt: &str| XYZ.replace("0 0.02 0 0 0 0.02\"", &format!("0 0.02 {tilt} 0 0 0.02\""));
    for (tilt, another) in [("0.004", false), ("-0.016", false), ("0.005", true)] {
        let (states, told) = found("start.xyz", &tilted(tilt), &sheared).unwrap();
        assert_eq!(states, BEADS);
        assert_eq!(told.iter().any(|line| line.contains("image_offset_m 0.005")), another, "{told:?}");
    }
    let why = found("start.xyz", &tilted("0.004"), ONE).unwrap_err();
    assert!(why.contains("start.xyz:2") && why.contains("has no [domain.shear]"), "{why}");
    let why = found("start.xyz", &tilted("0.004").replace("\"0.02", "\"0.03"), &sheared).unwrap_err();
    assert!(why.contains("is not the sheared box"), "{why}");
}

/// Images across the sheared sides are displaced along z. A bead below the upper side overlaps the image of a bead
/// above the lower side only at its displaced place.
#[test]
fn overlaps_across_sheared_sides_are_found() {
    for offset in [4.0, -4.0, 9.0] {
        let shear = format!("\"z\"], shear = {{ rate = \"50 1/s\", offset = \"{offset} mm\" }} }}");
        let sheared = ONE.replace("\"z\"] }", &shear);
        let at = |z: f64| {
            let upper = format!("X 0.005 0.0195 {}", 1e-3 * (5.0 + z));
            XYZ.replace("X 0.005 0.005 0.005", "X 0.005 0.0005 0.005").replace("X 0.015 0.005 0.005", &upper)
        };
        assert_eq!(found("start.xyz", &at(offset - 3.0), &sheared).unwrap().0.len(), 2);
        let why = found("start.xyz", &at(offset), &sheared).unwrap_err();
        assert!(why.contains("overlap"), "{offset}: {why}");
    }
}

const DATA: &str = "LAMMPS data file via write_data, version 2 Aug 2023, timestep = 1000, units = si\n\n3 atoms\n2 atom types\n\n\
    0 0.02 xlo xhi\n0 0.02 ylo yhi\n0 0.02 zlo zhi\n\nAtoms # sphere\n\n2 1 0.002 2500 0.005 0.005 0.005 0 0 0\n\
    0 1 0.002 2500 0.015 0.005 0.005 1 0 0\n1 2 0.001 7800 0.010 0.015 0.010 0 -1 0\n\n\
    Velocities\n\n0 -1 0 0.5 0 0 0\n2 1 0.25 0 0 0 0\n1 0 0.5 0 0 0 0\n";

#[test]
fn lammps_data_is_right_or_refused() {
    let wanted = vec![BEADS[1], BEADS[0], [10.0, 15.0, 10.0, 0.0, 0.5, 0.0]];
    for name in ["start.data", "data.bed", "bed.txt", "start.lmp"] {
        assert_eq!(found(name, DATA, &two()).unwrap(), (wanted.clone(), vec![]), "{name}");
    }
    let none: &[&str] = &[];
    let rows: Rows = vec![
        (
            "one atom fewer",
            &[("3 atoms", "4 atoms")],
            Refused(&["data.bed:10", "4 atoms are announced in line 3, 3 follow"]),
        ),
        (
            "one atom more",
            &[("3 atoms", "2 atoms")],
            Refused(&["data.bed:10", "2 atoms are announced in line 3, 3 follow"]),
        ),
        (
            "a velocity fewer",
            &[("1 0 0.5 0 0 0 0\n", "")],
            Refused(&["data.bed:14", "atom 1 has no velocity in the section in line 16"]),
        ),
        (
            "a velocity of no atom",
            &[("3 atoms", "2 atoms"), ("1 2 0.001 7800 0.010 0.015 0.010 0 -1 0\n", "")],
            Refused(&["data.bed:19", "a velocity of atom 1"]),
        ),
        ("a velocity twice", &[("2 1 0.25", "0 1 0.25")], Refused(&["data.bed:19", "a second velocity of atom 0"])),
        ("a velocity cut short", &[("1 0 0.5 0 0 0 0\n", "1 0")], Refused(&["data.bed:20", "2 values"])),
        (
            "no velocities",
            &[("Velocities\n\n0 -1 0 0.5 0 0 0\n2 1 0.25 0 0 0 0\n1 0 0.5 0 0 0 0\n", "")],
            Read(3, none),
        ),
        ("a spin", &[("0 -1 0 0.5 0 0 0", "0 -1 0 0.5 0 0 9")], Read(3, &["spins in `data.bed` are left out"])),
        (
            "another density",
            &[("2500", "1000")],
            Refused(&["data.bed:12", "`density` = 1e3 kg/m^3, but \"glass\" has 2.5e3"]),
        ),
        ("another diameter", &[("0.002", "0.003")], Refused(&["data.bed:12", "`diameter` = 3e-3 m"])),
        ("single precision", &[("0.001 7800", "1.000000047e-3 7800")], Read(3, none)),
        (
            "an end of the box fewer",
            &[("0 0.02 ylo", "0.02 ylo")],
            Refused(&["data.bed:7", "\"0.02 ylo yhi\" is no line of the box"]),
        ),
        ("ends of other sides", &[("ylo yhi", "ylo xhi")], Refused(&["data.bed:7", "is no line of the box"])),
        ("an end that is a letter", &[("0 0.02 ylo", "O 0.02 ylo")], Refused(&["data.bed:7", "the box = \"O\""])),
        ("an end at infinity", &[("0 0.02 ylo", "0 inf ylo")], Refused(&["data.bed:7", "not finite"])),
        ("two of three tilts", &[("zlo zhi\n", "zlo zhi\n0 0 xy xz\n")], Refused(&["data.bed:9", "leave tilts"])),
        ("no tilt", &[("zlo zhi\n", "zlo zhi\n0 0 0.0 xy xz yz\n")], Read(3, none)),
        ("a tilt", &[("zlo zhi\n", "zlo zhi\n0 1e-3 0 xy xz yz\n")], Refused(&["data.bed:9", "tilted"])),
        ("a tilt in vectors", &[("zlo zhi\n", "zlo zhi\n1 0 0 avec\n")], Refused(&["data.bed:9", "tilted"])),
        (
            "a type of no kind",
            &[("1 2 0.001", "1 3 0.001")],
            Refused(&["data.bed:14", "the type is 3, the case has 2 kinds"]),
        ),
        ("a type 0", &[("1 2 0.001", "1 0 0.001")], Refused(&["data.bed:14", "the type is 0"])),
        (
            "an id twice",
            &[("3 atoms", "4 atoms"), ("0 1 0.002", "2 1 0.002 2500 0.01 0.01 0.01\n0 1 0.002")],
            Refused(&["data.bed:13"]),
        ),
        ("another section", &[("Atoms", "Bonds\n\n1 1 0 1\n\nAtoms")], Read(3, &["left aside: Bonds"])),
        ("masses of spheres", &[("Atoms", "Masses\n\n1 1.0\n2 1.0\n\nAtoms")], Read(3, none)),
        ("other units", &[("= si", "= lj")], Refused(&["data.bed:1", "\"lj\""])),
    ];
    judge_rows("data.bed", DATA, &two(), &rows);
    let atomic = "by hand, units = si\n\n1 atoms\n1 atom types\n\n0 0.02 xlo xhi\n0 0.02 ylo yhi\n0 0.02 zlo zhi\n\nMasses\n\n1 1.0471975e-5\n\nAtoms # atomic\n\n0 1 0.01 0.01 0.01\n";
    judge_rows(
        "data.bed",
        atomic,
        ONE,
        &vec![
            ("its mass", &[], Read(1, &[])),
            ("another mass", &[("1 1.0471975e-5", "1 1.0")], Refused(&["data.bed:16", "`mass` = 1e0 kg"])),
            (
                "one atom, two types",
                &[("1 atoms", "2 atoms"), ("0.01 0.01 0.01\n", "0.01 0.01 0.01\n1 2 0.015 0.01 0.01\n")],
                Refused(&["data.bed:17", "type 2 beside type 1"]),
            ),
        ],
    );
}

const DUMP: &str = "ITEM: UNITS\nsi\nITEM: TIMESTEP\n100\nITEM: NUMBER OF ATOMS\n2\nITEM: BOX BOUNDS pp pp pp\n0.0 0.02\n0.0 0.02\n0.0 0.02\n\
    ITEM: ATOMS id type x y z vx vy vz radius\n1 1 0.015 0.005 0.005 -1 0 0.5 0.001\n0 1 0.005 0.005 0.005 1 0.25 0 0.001\n";

/// Text of a dump, and name of its file.
type Named = (String, &'static str);

#[test]
fn dumps_are_read_however_they_are_written() {
    let oddities: [(&str, fn(Named) -> Named); 10] = [
        ("another name", |(text, _)| (text, "dump.bed")),
        ("a name of a table", |(text, _)| (text, "bed.csv")),
        ("unwrapped places", |(text, name)| (text.replace("x y z", "xu yu zu"), name)),
        ("images", |(text, name)| {
            (text.replace("radius", "radius ix iy iz").replace("0.001\n", "0.001 0 -1 2\n"), name)
        }),
        ("densities", |(text, name)| (text.replace("radius", "radius density").replace("0.001", "0.001 2500"), name)),
        ("two instants", |(text, name)| (text.clone().replace("-1 0 0.5", "9 9 9") + &text, name)),
        ("an origin", |(text, name)| {
            let text = text.replace("0.0 0.02", "-0.01 0.01").replace("0.015 0.005 0.005", "0.005 -0.005 -0.005");
            (text.replace("0.005 0.005 0.005", "-0.005 -0.005 -0.005"), name)
        }),
        ("no tilt", |(text, name)| {
            (
                text.replace("BOUNDS", "BOUNDS xy xz yz")
                    .replace("0.02\n", "0.02 0.0\n")
                    .replace(" 0.01\n", " 0.01 0\n"),
                name,
            )
        }),
        ("CR LF", |(text, name)| (text.replace('\n', "\r\n"), name)),
        ("byte order mark", |(text, name)| (format!("\u{feff}{text}"), name)),
    ];
    for (what, (text, name)) in combinations(&(DUMP.to_owned(), "bed.dump"), &oddities) {
        let (states, told) = found(name, &text, ONE).unwrap_or_else(|error| panic!("{what}: {error}\n{text}"));
        assert_eq!(states, BEADS, "{what}");
        assert_eq!(told.len(), usize::from(what.contains("two instants")), "{what}: {told:#?}");
        assert!(told.iter().all(|told| told.contains("2 instants, the last is taken")), "{what}: {told:#?}");
    }
    let scaled = DUMP
        .replace("x y z", "xs ys zs")
        .replace("0.015 0.005 0.005", "0.75 0.25 0.25")
        .replace("0.005 0.005 0.005", "0.25 0.25 0.25");
    assert_eq!(found("bed.dump", &scaled, ONE).unwrap(), (BEADS.to_vec(), vec![]));
    let shifted =
        scaled.replace("0.0 0.02", "5 5.02").replace(" pp pp pp", " xy xz yz pp pp pp").replace("5.02", "5.02 0");
    assert_eq!(found("bed.dump", &shifted, ONE).unwrap(), (BEADS.to_vec(), vec![]));
    let also_unwrapped = DUMP.replace("radius", "radius xu yu zu").replace("0.001\n", "0.001 9 9 9\n");
    assert_eq!(found("bed.dump", &also_unwrapped, ONE).unwrap(), (BEADS.to_vec(), vec![]));
}

#[test]
fn dumps_are_right_or_refused() {
    let rows: Rows = vec![
        ("one atom fewer", &[("\n2\n", "\n3\n")], Refused(&["bed.dump:6", "3 atoms are announced, 2 lines follow"])),
        ("one atom more", &[("\n2\n", "\n1\n")], Refused(&["bed.dump:13", "belongs to no item"])),
        ("broken off in a line", &[("1 0.25 0 0.001\n", "1 0")], Refused(&["bed.dump:13", "has 7 values"])),
        (
            "broken off in the head",
            &[(
                "ITEM: ATOMS id type x y z vx vy vz radius\n1 1 0.015 0.005 0.005 -1 0 0.5 0.001\n0 1 0.005 0.005 0.005 1 0.25 0 0.001\n",
                "",
            )],
            Refused(&["bed.dump:3", "has no atoms"]),
        ),
        (
            "a second instant broken off",
            &[("0.25 0 0.001\n", "0.25 0 0.001\nITEM: TIMESTEP\n200\n")],
            Refused(&["bed.dump:14", "has no atoms"]),
        ),
        ("no units", &[("ITEM: UNITS\nsi\n", "")], Read(2, &["does not say its units"])),
        ("other units", &[("\nsi\n", "\nlj\n")], Refused(&["bed.dump:2", "\"lj\""])),
        (
            "a tilt",
            &[("BOUNDS", "BOUNDS xy xz yz"), ("0.02\n", "0.02 0\n"), ("0.02\n", "0.02 0.01\n")],
            Refused(&["bed.dump:9", "tilted"]),
        ),
        ("one of three places", &[("x y z", "x y fz")], Refused(&["bed.dump:11", "lack z, of the position"])),
        ("a place twice", &[("x y z", "x x z")], Refused(&["bed.dump:11", "the column `x` says again"])),
        (
            "a share of no box",
            &[("ITEM: BOX BOUNDS pp pp pp\n0.0 0.02\n0.0 0.02\n0.0 0.02\n", ""), ("x y z", "xs ys zs")],
            Refused(&["bed.dump:7", "shares of a box"]),
        ),
        ("contacts in place of atoms", &[("ITEM: ATOMS", "ITEM: ENTRIES")], Refused(&["bed.dump:11", "ENTRIES"])),
        ("forces", &[("vx vy vz", "fx fy fz")], Read(2, &["left aside: fx, fy, fz"])),
        ("another radius", &[("0.5 0.001", "0.5 0.0015")], Refused(&["bed.dump:12", "`diameter` = 3e-3 m"])),
        ("walls there", &[("pp pp pp", "pp ff pp")], Read(2, &["periodic x z"])),
        (
            "a box turned round",
            &[("0.0 0.02\n0.0 0.02", "0.02 0.0\n0.0 0.02")],
            Refused(&["bed.dump:8", "ends at 0.0 and begins at 0.02"]),
        ),
        ("ids from 7", &[("\n1 1 0.015", "\n7 1 0.015")], Read(2, &["0 to 7, are counted anew"])),
    ];
    judge_rows("bed.dump", DUMP, ONE, &rows);
}

/// Row of five beads. Each bead overlaps the next one by `share` times d, such as 0.03 in beds of soft spheres.
fn bed(share: f64) -> String {
    let line = |k: u32| format!("X {} 0.01 0.01\n", 0.005 + f64::from(k) * 0.002 * (1.0 - share));
    let head = "5\nLattice=\"0.02 0 0 0 0.02 0 0 0 0.02\" Properties=species:S:1:pos:R:3 units=\"m s\"\n";
    head.to_owned() + &(0..5).map(line).collect::<String>()
}

#[test]
fn a_bed_of_another_program_starts_with_its_overlaps() {
    for model in [Model::Soft, Model::Hybrid] {
        let (experiment, told) =
            read("bed.xyz", bed(0.03).as_bytes(), ONE, model).unwrap_or_else(|error| panic!("{error}"));
        assert_eq!(experiment.count(), 5);
        assert!(told.len() == 1 && told[0].contains("3.000e-2 of a diameter; the worst of 4 overlaps"), "{told:#?}");
        assert!(told[0].contains("of \"glass\" and particle"), "{told:#?}");
        let deep = read("bed.xyz", bed(0.55).as_bytes(), ONE, model).err().unwrap();
        assert!(deep.contains("of a diameter") && !deep.contains("--relax"), "{deep}");
    }
    let hard = read("bed.xyz", bed(0.03).as_bytes(), ONE, Model::Hard).err().unwrap();
    assert!(hard.contains("3.000e-2 of a diameter") && hard.contains("--relax"), "{hard}");
}

#[test]
fn overlapping_beads_are_pushed_apart_on_demand() {
    let case = ONE.replace("run = {", "run = { relax = true,");
    for model in [Model::Hard, Model::Soft] {
        let (experiment, told) =
            read("bed.xyz", bed(0.03).as_bytes(), &case, model).unwrap_or_else(|error| panic!("{error}"));
        assert!(
            told[0].contains("worst of 4 overlaps") && told[0].contains("pushed apart before the start"),
            "{told:#?}"
        );
        assert!(
            told[1].contains("pushed apart: particle") && told[1].contains("moved the farthest, by 1."),
            "{told:#?}"
        );
        let particles = diptych::placement::initial_state(&experiment).unwrap();
        for k in 1..5 {
            let apart = (particles.position[k] - particles.position[k - 1]).norm();
            assert!((2e-3..2.05e-3).contains(&apart), "{apart}");
        }
    }
    // without overlaps no bead is moved
    let (_, told) = read("bed.xyz", bed(0.0).as_bytes(), &case, Model::Hard).unwrap();
    assert!(told.is_empty(), "{told:#?}");
    let nonsense = read("bed.xyz", bed(0.55).as_bytes(), &case, Model::Hard).err().unwrap();
    assert!(nonsense.contains("of a diameter"), "{nonsense}");
}

/// A warning names the rows of a file that belong to a species for which the case does not name the file. Columns come
/// in threes, ids order the rows of a table, and spins have their unit.
#[test]
fn no_part_of_a_file_is_left_out_in_silence() {
    let table = "x,y,z,species\n0.005,0.005,0.005,glass\n0.010,0.005,0.005,steel\n0.015,0.005,0.005,steel\n";
    let steel = "{ name = \"steel\", diameter = \"1 mm\", density = \"7800 kg/m^3\", count = 0 }]";
    let without = ONE.replace("file = \"FILE\" }]", &format!("file = \"FILE\" }}, {steel}"));
    let (states, told) = found("start.csv", table, &without).unwrap();
    assert_eq!(states.len(), 1);
    assert!(told.iter().any(|line| line.contains("2 particles of \"steel\"")), "{told:?}");
    let (states, told) = found("start.csv", table, &two()).unwrap();
    assert_eq!((states.len(), told), (3, vec![]));
    let swapped = "x,y,z,id\n0.015,0.005,0.005,1\n0.005,0.005,0.005,0\n";
    let places: Vec<f64> = found("start.csv", swapped, ONE).unwrap().0.iter().map(|state| state[0]).collect();
    assert_eq!(places, [5.0, 15.0]);
    // cells of tables and names of the case are compared without blanks at their ends
    let blanks = "x,y,z,species\n0.005,0.005,0.005,  glass \n";
    assert_eq!(found("start.csv", blanks, ONE).unwrap().0.len(), 1);
    let why = found("start.csv", blanks, &ONE.replace("glass", "  glass ")).unwrap_err();
    assert!(why.contains("blank") && why.contains("write name = \"glass\""), "{why}");
    let rotating = ONE.replace("restitution = 0.9", "restitution = 0.9, rotation = true");
    let refused = |name: &str, text: &str, words: &str| {
        let why = found(name, text, &rotating).unwrap_err();
        assert!(why.contains(words), "{text}: {why}");
    };
    refused("start.csv", "x,y,z,id\n0.005,0.005,0.005,first\n", "is no whole number");
    refused("start.csv", "x,y,z,wx,wy\n0.005,0.005,0.005,1,2\n", "lacks wz");
    refused("start.csv", "x,y,z,wx,wy,wz\n0.005,0.005,0.005,1e10,0,0\n", "out of range");
    refused("start.xyz", &XYZ.replace("units=\"m s\"", "units=\"mm s\""), "in the units");
    refused("start.xyz", &XYZ.replace("pbc=", "Origin=\"0.001 0\" pbc="), "`Origin` has 2 numbers");
    refused("start.xyz", &XYZ.replace("velo:R:3", "wx:R:1:wy:R:1:id:I:1").replace(" 0\nX", " 7\nX"), "of the spin");
    let (with_unit, _) =
        read("start.csv", b"x,y,z,wx_rad_s,wy,wz\n0.005,0.005,0.005,2,0,0\n", &rotating, Model::Hard).unwrap();
    let Amount::Placed(particles) = &with_unit.start[0].amount else { panic!("not placed") };
    assert_eq!(particles.spin.as_ref().unwrap()[0].x, 2.0);
}
