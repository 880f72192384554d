//! Trajectories and logs in several formats, with the same numbers.

use super::{judged, put, summary};
use nalgebra::Vector3;
use rand::SeedableRng;
use rand_distr::{Distribution, StandardNormal};
use rand_xoshiro::Xoshiro256PlusPlus;
use std::fmt::Write;
use std::path::Path;
use tempfile::TempDir;

/// Position [m] and velocity [m/s] of each particle at each instant, in a box of 1 m with its lower corner at (1, 2, 3)
/// m.
type Instants = Vec<Vec<[Vector3<f64>; 2]>>;

const CORNER: [f64; 3] = [1.0, 2.0, 3.0];

/// Particles in two halves along y. The upper half has the mean velocity 10 m/s along z.
fn instants(count: usize, seed: u64) -> Instants {
    let mut random = Xoshiro256PlusPlus::seed_from_u64(seed);
    let mut normal = || Vector3::from_fn(|_, _| StandardNormal.sample(&mut random));
    let mut particle = |k: usize| {
        let upper = k % 2;
        let place = Vector3::new(0.5, 0.25 + 0.5 * upper as f64, 0.5) + Vector3::from(CORNER);
        let velocity: Vector3<f64> = normal();
        [place, velocity + Vector3::new(0.0, 0.0, 10.0 * upper as f64)]
    };
    (0..count).map(|_| (0..50).map(&mut particle).collect()).collect()
}

/// Mean over all instants of the temperature along z, relative to the mean velocities of the two halves.
fn temperature_along_z(instants: &Instants) -> f64 {
    let of = |particles: &Vec<[Vector3<f64>; 2]>| {
        let about = |upper: usize| {
            let own: Vec<f64> = particles.iter().skip(upper).step_by(2).map(|particle| particle[1].z).collect();
            let mean = own.iter().sum::<f64>() / own.len() as f64;
            own.iter().map(|v| (v - mean).powi(2)).sum::<f64>()
        };
        (about(0) + about(1)) / (particles.len() - 2) as f64
    };
    instants.iter().map(of).sum::<f64>() / instants.len() as f64
}

fn xyz(folder: &Path, name: &str, instants: &Instants) -> String {
    let mut text = String::new();
    for (k, particles) in instants.iter().enumerate() {
        writeln!(text, "{}", particles.len()).unwrap();
        let columns = "pos:R:3:velo:R:3:radius:R:1:mass:R:1";
        let head = "Lattice=\"1 0 0 0 1 0 0 0 1\" Origin=\"1 2 3\" pbc=\"T F T\" units=\"m s\"";
        writeln!(text, "{head} Time={:?} Properties={columns}", 0.5 * k as f64).unwrap();
        for [x, v] in particles {
            writeln!(text, "{:?} {:?} {:?} {:?} {:?} {:?} 0.01 2", x.x, x.y, x.z, v.x, v.y, v.z).unwrap();
        }
    }
    put(folder, name, &text)
}

/// Writes a dump with the particles in the opposite order, because LAMMPS does not sort the particles.
fn dump(folder: &Path, name: &str, instants: &Instants) -> String {
    let mut text = String::new();
    for (k, particles) in instants.iter().enumerate() {
        let time = 0.5 * k as f64;
        writeln!(text, "ITEM: UNITS\nsi\nITEM: TIME\n{time}\nITEM: TIMESTEP\n{}", 100 * k).unwrap();
        writeln!(text, "ITEM: NUMBER OF ATOMS\n{}", particles.len()).unwrap();
        writeln!(text, "ITEM: BOX BOUNDS pp ff pp\n1 2\n2 3\n3 4\nITEM: ATOMS id x y z vx vy vz mass").unwrap();
        for (id, [x, v]) in particles.iter().enumerate().rev() {
            writeln!(text, "{} {:?} {:?} {:?} {:?} {:?} {:?} 2", id + 1, x.x, x.y, x.z, v.x, v.y, v.z).unwrap();
        }
    }
    put(folder, name, &text)
}

#[test]
fn trajectories_of_two_formats_have_the_averages_of_their_particles() {
    let place = TempDir::new().unwrap();
    let place = place.path();
    let instants = instants(60, 1);
    xyz(place, "a.xyz", &instants);
    dump(place, "b.dump", &instants);
    let settings = put(
        place,
        "judge.toml",
        "margin = '20 %'\n[a]\nfiles = ['a.xyz']\nfrom = 0.0\nslices = 2\n[b]\nfiles = ['b.dump']\nfrom = 0.0\nslices = 2\n",
    );
    let (code, said, folder) = judged(place, &["--settings", &settings]);
    assert!([0, 4].contains(&code), "{code} {said}");
    let quantities = summary(&folder)["quantities"].clone();
    let means = |name: &str| {
        let one = quantities.as_array().unwrap().iter().find(|one| one["name"] == name);
        let sides = &one.unwrap_or_else(|| panic!("{name} in {quantities}"))["sides"];
        [0, 1].map(|side| sides[side]["mean"]["value"].as_f64().unwrap())
    };
    // sums do not depend on the order of the particles
    for name in ["granular_temperature_m2_s2", "Tzz_m2_s2[2]", "kinetic_energy_J", "mean_velocity_x_m_s"] {
        let [a, b] = means(name);
        assert_eq!(a.to_bits(), b.to_bits(), "{name}");
    }
    let [seen, _] = means("Tzz_m2_s2");
    let wanted = temperature_along_z(&instants);
    assert!((seen / wanted - 1.0).abs() < 1e-12, "{seen} {wanted}");
    let [lower, upper] = ["mean_velocity_z_m_s[1]", "mean_velocity_z_m_s[2]"].map(|name| means(name)[0]);
    // standard error of a mean over 25 particles and 60 instants: 0.026 m/s
    assert!(lower.abs() < 0.11 && (upper - 10.0).abs() < 0.11, "{lower} {upper}");
    assert_eq!(means("particles[1]"), [25.0; 2]);
    // a centre of mass exists along a wall-normal axis, but not along periodic axes
    let [height, _] = means("centre_of_mass_y_m");
    assert!((height - 0.5).abs() < 1e-12, "{height}");
    assert!(!quantities.to_string().contains("centre_of_mass_x_m"));
}

#[test]
fn logs_of_other_styles_hold_the_numbers_of_a_table() {
    let place = TempDir::new().unwrap();
    let place = place.path();
    let rows: Vec<[f64; 3]> =
        (0..400).map(|k| [f64::from(10 * k), (f64::from(k) * 0.7).sin() + 3.0, (f64::from(k) * 1.3).cos()]).collect();
    let table: String = rows.iter().map(|[t, a, b]| format!("{t},{a:?},{b:?}\n")).collect();
    let csv = put(place, "table.csv", &format!("Step,Press,c_x\n{table}"));
    let yaml: String = rows.iter().map(|[t, a, b]| format!("  - [{t}, {a:?}, {b:?}, ]\n")).collect();
    let yaml = put(
        place,
        "log.yaml",
        &format!(
            "Per MPI rank memory\n---\nkeywords: ['Step', 'Press', 'c_x', ]\ndata:\n{yaml}...\nLoop time of 1\n9 9 9\n"
        ),
    );
    let words: String = rows.iter().map(|[t, a, b]| format!("  {a:?} {t} {b:?}\nWARNING: 1 2\n")).collect();
    let custom = put(
        place,
        "log.custom",
        &format!("Per MPI rank memory allocation (min/avg/max) = 5\n Press Step c_x\n{words}Loop time of 1\n9 9 9\n"),
    );
    for log in [&yaml, &custom] {
        let (_, said, folder) = judged(place, &[log, &csv]);
        let quantities = summary(&folder)["quantities"].clone();
        for one in quantities.as_array().unwrap_or_else(|| panic!("{said}")) {
            let [a, b] = [0, 1].map(|side| &one["sides"][side]);
            assert_eq!((&a["mean"], &a["samples"]), (&b["mean"], &b["samples"]), "{log}");
        }
        assert_eq!(quantities.as_array().unwrap().len(), 2, "{log}: {said}");
    }
}

#[test]
fn trajectories_that_cannot_be_averaged_are_refused() {
    let place = TempDir::new().unwrap();
    let place = place.path();
    let good = xyz(place, "good.xyz", &instants(3, 2));
    let text = std::fs::read_to_string(&good).unwrap();
    let refused = |name: &str, text: &str, settings: &str, wanted: &[&str]| {
        put(place, name, text);
        let settings =
            put(place, "judge.toml", &format!("[a]\nfiles = ['{name}']\n{settings}[b]\nfiles = ['good.xyz']\n"));
        let (code, said, folder) = judged(place, &["--settings", &settings]);
        assert_eq!(code, 2, "{said}");
        assert!(wanted.iter().all(|part| said.contains(part)), "{wanted:?} in {said}");
        assert!(!folder.exists(), "{name} left a folder");
    };
    let bare = "1\nProperties=pos:R:3\n0 0 0\n";
    refused("still.xyz", bare, "", &["still.xyz:3:", "no velocities", "velo:R:3"]);
    refused("cut.xyz", &text[..text.len() / 2], "", &["cut.xyz:", "help: "]);
    let open = "1\nProperties=pos:R:3:velo:R:3\n0 0 0 1 1 1\n";
    refused("open.xyz", open, "slices = 3\n", &["open.xyz:1:", "no box", "leave out `slices`"]);
    refused("t.csv", "t_s,T\n0,1\n1,2\n", "slices = 3\n", &["judge.toml:3:", "`a.slices`", "no particles"]);
    refused("good.xyz", &text, "slices = 0\n", &["judge.toml:3:", "no number of slices", "1 to 1000"]);
}
