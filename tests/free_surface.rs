//! Free surface of a layer: waves made by hand, whose wavelength and symmetry are known, and messages.

use crate::measurements::{gas, number, of_states};
use crate::support::{case, close, diptych, words};
use diptych::Vector3;
use diptych::domain::Domain;
use diptych::experiment::{Experiment, FreeSurfaceSettings, Model};
use diptych::observe::{FreeSurface, Observation};
use diptych::particles::Particles;
use diptych::schedule::Schedule;
use std::f64::consts::PI;

/// [m] length of each edge of the floor, which is also the number of columns of 1 m along it.
const EDGE: usize = 60;

const FLAT: FreeSurfaceSettings = FreeSurfaceSettings { up: (1, 1.0), spacing: 1.0, smoothing: 0.0 };

fn layer(periodic: bool) -> Experiment {
    let mut layer = gas(EDGE * EDGE, 0.01, 1.0, Model::Hard);
    let edge = EDGE as f64;
    // the map is of the second half of the run
    layer.run.duration = 0.0;
    layer.scene.domain = Domain::new(Vector3::new(edge, 40.0, edge), [periodic, false, periodic]);
    layer
}

/// One sphere of diameter 1 m in each column of the floor. `height` [m] of the middle of the column is the highest
/// point of its sphere.
fn with_heights(height: impl Fn(f64, f64) -> f64) -> Particles {
    let mut state = Particles::default();
    for x in (0..EDGE).map(|k| k as f64 + 0.5) {
        for z in (0..EDGE).map(|k| k as f64 + 0.5) {
            state.push(Vector3::new(x, height(x, z) - 0.5, z), Vector3::zeros(), 0.5, 1.0, 0);
        }
    }
    state
}

fn seen(experiment: &Experiment, settings: FreeSurfaceSettings, state: Particles) -> Observation {
    let measurement = FreeSurface::new(experiment, &Schedule::new(experiment), settings);
    of_states(experiment, measurement, [state])
}

/// Height [m] as a sum of waves of amplitude 0.5 m. Each entry of `numbers` has the numbers of periods of a wave along
/// x and z.
fn waves(numbers: &[[f64; 2]]) -> impl Fn(f64, f64) -> f64 {
    move |x, z| {
        let phase = |[along_x, along_z]: &[f64; 2]| 2.0 * PI * (along_x * x + along_z * z) / EDGE as f64;
        10.0 + numbers.iter().map(|wave| 0.5 * phase(wave).cos()).sum::<f64>()
    }
}

#[test]
fn waves_have_their_wavelength_and_symmetry() {
    // sqrt(3)/2 of 7 and 8 is near 6.06 and 6.93, so that the hexagons nearly fit into the square
    for (name, numbers, wavelength, symmetry) in [
        ("stripes", &[[6.0, 0.0]][..], 10.0, [1.0, 1.0, 1.0]),
        ("oblique stripes", &[[3.0, 4.0]], 12.0, [1.0, 1.0, 1.0]),
        ("squares", &[[5.0, 0.0], [0.0, 5.0]], 12.0, [0.0, 1.0, 0.0]),
        ("hexagons", &[[8.0, 0.0], [4.0, 7.0], [4.0, -7.0]], 7.5, [0.0, 0.0, 1.0]),
    ] {
        let found = seen(&layer(true), FLAT, with_heights(waves(numbers)));
        close(name, number(&found, "wavelength").value, wavelength, 1e-12);
        // waves of the same contrast are orthogonal
        close(name, number(&found, "contrast").value, 0.5 * (0.5 * numbers.len() as f64).sqrt(), 1e-12);
        for (column, exact) in ["Q2", "Q4", "Q6"].iter().zip(symmetry) {
            // the window spreads a wave over neighbours at an angle of 1/(|f| L): for |f| L = 5 the loss of Q_6 is
            // (1 - cos(6/5))/3 = 0.21, and other neighbours within the shell add to it
            close(&format!("{name}, {column}"), number(&found, column).value, exact, 0.25);
        }
        // the Hann window leaves the variance of a wave that fits into the box; the largest wave numbers are left out
        let power = &found.curves[0].values;
        let sum: f64 = power.iter().map(|power| power.unwrap().value).sum();
        close(name, sum, 0.125 * numbers.len() as f64, 1e-5);
    }
}

/// If columns are high and low in turn, the surface has the shortest wave. The Fourier transform contains this wave
/// only once, not as a pair.
#[test]
fn the_shortest_wave_is_counted_once() {
    for along_x in [true, false] {
        let height =
            |x: f64, z: f64| 10.0 + if (if along_x { x } else { z }).floor() % 2.0 == 0.0 { 0.5 } else { -0.5 };
        let found = seen(&layer(true), FLAT, with_heights(height));
        close("contrast", number(&found, "contrast").value, 0.5, 1e-12);
        let sum: f64 = found.curves[0].values.iter().map(|power| power.unwrap().value).sum();
        close("variance", sum, 0.25, 1e-5);
    }
}

#[test]
fn the_highest_sphere_counts_and_empty_columns_have_the_median() {
    let experiment = layer(true);
    let mut state = with_heights(|_, _| 3.0);
    // below another one: not seen
    state.push(Vector3::new(20.5, 1.0, 30.5), Vector3::zeros(), 0.5, 1.0, 0);
    // column 10, 20 becomes empty
    state.position[10 * EDGE + 20].x += 1.0;
    let flat = seen(&experiment, FLAT, state.clone());
    assert_eq!(number(&flat, "contrast").value, 0.0);
    assert!(flat.numbers.iter().skip(1).all(|number| number.value.is_none()), "a flat surface has no pattern");
    // a wide sphere on top, across the periodic side
    state.push(Vector3::new(-9.5, 9.0, 30.5), Vector3::zeros(), 1.0, 1.0, 0);
    let heights = seen(&experiment, FLAT, state).grid.unwrap();
    assert_eq!((heights.cells, heights.spacing), ([EDGE, 1, EDGE], Vector3::repeat(1.0)));
    for (place, height) in heights.fields[0].2.iter().enumerate() {
        let exact = if place == 30 * EDGE + 50 { 10.0 } else { 3.0 };
        assert!((height - exact).abs() < 1e-12, "{place}: {height}");
    }
}

#[test]
fn a_gaussian_damps_waves_and_keeps_the_volume() {
    let settings = FreeSurfaceSettings { smoothing: 2.0, ..FLAT };
    let found = seen(&layer(true), settings, with_heights(waves(&[[6.0, 0.0]])));
    let damped = 0.5 * 0.5_f64.sqrt() * (-0.5 * (2.0 * PI * 6.0 / EDGE as f64 * 2.0).powi(2)).exp();
    // the Gaussian ends at four standard deviations
    close("contrast", number(&found, "contrast").value / damped, 1.0, 1e-3);
    for periodic in [true, false] {
        let spike = |x: f64, z: f64| if x < 1.0 && z < 1.0 { 5.0 } else { 4.0 };
        let heights = seen(&layer(periodic), settings, with_heights(spike)).grid.unwrap().fields[0].2.clone();
        close("volume", heights.iter().sum::<f64>(), 4.0 * (EDGE * EDGE) as f64 + 1.0, 1e-9);
        let beyond = heights[EDGE - 1];
        assert_eq!(beyond > 4.0 + 1e-3, periodic, "{beyond}: only a periodic side is joined to the other");
    }
}

#[test]
fn up_is_against_gravity() {
    let experiment = layer(true);
    let mut state = with_heights(waves(&[[6.0, 0.0]]));
    let level = with_heights(|_, _| 15.0);
    for place in 0..level.len() {
        let position = level.position[place];
        state.push(position, Vector3::zeros(), 0.5, 1.0, 0);
    }
    let from = |sign| seen(&experiment, FreeSurfaceSettings { up: (1, sign), ..FLAT }, state.clone());
    assert_eq!(number(&from(1.0), "contrast").value, 0.0);
    close("from below", number(&from(-1.0), "contrast").value, 0.5 * 0.5_f64.sqrt(), 1e-12);
}

const CASE: &str = r#"
[domain]
size = ["30 mm", "20 mm", "40 mm"]
periodic = ["x", "z"]
[gravity]
acceleration = ["0 m/s^2", "-9.81 m/s^2", "0 m/s^2"]
[[particles]]
diameter = "1 mm"
density = "2500 kg/m^3"
count = 100
velocity_fluctuation = "0.1 m/s"
[contact]
restitution = 0.9
[[walls]]
plane = { point = ["0 mm", "0 mm", "0 mm"], normal = [0, 1, 0] }
restitution = 0.9
[run]
duration = "1 ms"
[observe.free_surface]
"#;

#[test]
fn cases_ask_for_the_surface() {
    let with = |keys: &str, sets: &[&str]| case(&format!("{CASE}{keys}"), Model::Hard, sets);
    let read = with("spacing = \"1 mm\"", &[]).unwrap().observe.free_surface.unwrap();
    assert_eq!(read, FreeSurfaceSettings { up: (1, 1.0), spacing: 1e-3, smoothing: 2e-3 });
    let sets = ["observe.free_surface.smoothing=0 mm", "gravity.acceleration=[\"0 m/s^2\", \"1 m/s^2\", \"0 m/s^2\"]"];
    let read = with("spacing = \"1 mm\"", &sets).unwrap().observe.free_surface.unwrap();
    assert_eq!((read.up, read.smoothing), ((1, -1.0), 0.0));
    let oblique = "gravity.acceleration=[\"1 m/s^2\", \"1 m/s^2\", \"0 m/s^2\"]";
    let none = "gravity.acceleration=[\"0 m/s^2\", \"0 m/s^2\", \"0 m/s^2\"]";
    for (keys, sets, words) in [
        ("", &[][..], "observe.free_surface.spacing"),
        ("spacing = \"3.1 mm\"", &[], "8.0000e-5 to 3.0000e-3 m"),
        ("spacing = \"79 um\"", &[], "10 to 500 columns"),
        ("spacing = \"1 mm\"\nsmoothing = \"3.1 mm\"", &[], "3.0000e-3 m"),
        ("spacing = \"1 mm\"", &[oblique], "needs gravity along x, y or z"),
        ("spacing = \"1 mm\"", &[none], "needs gravity along x, y or z"),
    ] {
        let why = with(keys, sets).unwrap_err();
        assert!(why.contains(words), "{why}");
    }
}

#[test]
fn a_report_has_a_map_with_the_unit_of_its_colours() {
    let out = tempfile::tempdir().unwrap();
    let folder = out.path().join("layer");
    let sets = ["observe.free_surface.spacing=1 mm", "run.duration=20 ms", "run.average_from=0 s"];
    let sets = sets.iter().flat_map(|set| ["--set", set]);
    let arguments = ["run", "cases/driven/leidenfrost.toml", "--quiet", "--out", folder.to_str().unwrap()];
    let done = diptych(&arguments.into_iter().chain(sets).collect::<Vec<_>>()).output().unwrap();
    assert!(done.status.success(), "{}", words(&done.stderr));
    let read = |name: &str| std::fs::read_to_string(folder.join(name)).unwrap();
    assert!(read("report.html").contains("Colours: height above its lowest value [mm]."));
    assert!(read("figures/free-surface-map-hard.svg").contains("z  [mm]") && folder.join("vtk").is_dir());
    let numbers = read("observables.csv");
    for name in ["contrast,m,", "wavelength,m,", "Q2,,", "Q4,,", "Q6,,"] {
        assert!(numbers.contains(&format!("hard,free_surface,{name}")), "{name}: {numbers}");
    }
}
