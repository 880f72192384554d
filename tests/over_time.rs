//! Curves over time: theories against engines, and tables and pictures against outcomes.

use crate::made_up::{outcomes, with_study};
use crate::support::{edge, empty, experiment, hard, placed, plane, small, surface, try_run};
use diptych::drag::{Drag, Stokes};
use diptych::experiment::{Experiment, Model, Spheres};
use diptych::fluid::{Fluid, Profile};
use diptych::observe::{Observer, Paths, Series};
use diptych::output::{Folder, write_study};
use diptych::predict::closed_form::{Bouncing, Chain, Cooling, settling_velocity};
use diptych::scene::{Scene, Thermostat};
use diptych::schedule::Schedule;
use diptych::simulation::Simulation;
use diptych::study::execute;
use diptych::walls::ThermalWall;
use nalgebra::Vector3;

/// Hard run of a scene for `duration` [s].
fn lasting(scene: &Scene, duration: f64) -> Experiment {
    let mut run = experiment(scene.clone(), 0, [0.0; 3], 0.0, Model::Hard, 1);
    run.run.duration = duration;
    run
}

/// A sphere between a floor and a ceiling. It is thrown upwards so fast that its first flight reaches the ceiling, then
/// more slowly.
#[test]
fn bounces_are_those_of_the_hard_engine() {
    let mut scene = empty([0.01, 0.03, 0.01], [true, false, true], small(), surface(0.9, 0.0));
    scene.gravity = Vector3::new(0.0, -9.81, 0.0);
    scene.walls = vec![
        plane([0.0; 3], [0.0, 1.0, 0.0], surface(0.8, 0.0)),
        plane([0.0, 0.03, 0.0], [0.0, -1.0, 0.0], surface(0.7, 0.0)),
    ];
    let start = [Vector3::new(5e-3, 0.02, 5e-3), Vector3::new(0.0, 0.9, 0.0)];
    let bouncing = Bouncing::of(&lasting(&scene, 0.3), start).unwrap();
    let mut simulation =
        Simulation::with_engine(scene.clone(), placed(&scene, &[(start[0].into(), start[1].into())]), hard());
    for k in 1..=300 {
        simulation.run(1, 1e-3).unwrap();
        let time = 1e-3 * f64::from(k);
        let Some([x, v]) = bouncing.at(time) else { panic!("{time} s") };
        // rounding errors of about ten bounces
        assert!((x.y - simulation.particles.position[0].y).abs() < 1e-12, "{time} s");
        assert!((v.y - simulation.particles.velocity[0].y).abs() < 1e-9, "{time} s");
    }
    let before = bouncing.bounces().filter(|time| *time <= 0.3).count();
    assert!(before as u64 == simulation.record.walls.count && before >= 3, "{before}");
    // a flight from rest ends in a geometric series of bounces; there is no prediction after the last visible bounce
    let drop = [start[0], Vector3::zeros()];
    let dropped = Bouncing::of(&lasting(&scene, 10.0), drop).unwrap();
    assert!(dropped.at(9.0).is_none() && dropped.at(0.1).is_some());
    // the TC model makes the end of a flight elastic that is shorter than the contact time
    let mut lasting_contacts = lasting(&scene, 10.0);
    lasting_contacts.hard.contact_time = Some(0.05);
    let long: Vec<f64> = Bouncing::of(&lasting_contacts, drop).unwrap().bounces().collect();
    assert!(long.len() < dropped.bounces().count() && long.iter().copied().eq(dropped.bounces().take(long.len())));
    assert!(long.windows(2).all(|two| two[1] - two[0] >= 0.05), "{long:?}");
    scene.walls[0] = plane([0.0; 3], [0.6, 0.8, 0.0], surface(0.8, 0.0));
    assert!(Bouncing::of(&lasting(&scene, 0.3), start).is_none(), "a slope");
}

#[test]
fn rows_of_elastic_spheres_exchange_velocities_as_the_hard_engine_says() {
    let d = small().diameter;
    let scene = empty([0.02, 0.004, 0.004], [false; 3], small(), surface(1.0, 0.0));
    let at = |x: f64, v: f64| ([x, 2e-3, 2e-3], [v, 0.0, 0.0]);
    // positions are not in the order of the row; two spheres touch
    let start = [at(6e-3, 0.0), at(4e-3, 1.0), at(6e-3 + d, 0.0), at(8e-3, -0.5), at(9.5e-3, -0.7)];
    let vectors = start.map(|(x, v)| [Vector3::from(x), Vector3::from(v)]);
    let chain = Chain::of(&scene, &vectors).unwrap();
    let (simulation, result) = try_run(&scene, placed(&scene, &start), hard(), 5e-3, 50);
    result.unwrap();
    assert!(simulation.record.pairs.count >= 6);
    for sphere in 0..start.len() {
        let [x, v] = chain.at(sphere, 5e-3).unwrap();
        assert!((x.x - simulation.particles.position[sphere].x).abs() < 1e-12, "{sphere}");
        assert!((v.x - simulation.particles.velocity[sphere].x).abs() < 1e-9, "{sphere}");
    }
    let mut aside = vectors;
    aside[1][0].y += 1e-6;
    assert!(Chain::of(&scene, &aside).is_none());
    let inelastic = empty([0.02, 0.004, 0.004], [false; 3], small(), surface(0.9, 0.0));
    assert!(Chain::of(&inelastic, &vectors).is_none());
}

/// T/T_0 (granular temperature over that at the start) is 0.206 after 20 ms, with 1897 collisions per second and
/// sphere at first, as the heading of `cases/cooling-gas.toml` says.
#[test]
fn a_gas_cools_as_haff_says() {
    let mut scene = empty([edge(2000, 406e-6, 0.05); 3], [true; 3], small(), surface(0.9, 0.0));
    let gas = Cooling::of(&lasting(&scene, 1.0), 2000, 1.0).unwrap();
    // lower by a factor of 1 - 1/2000, because a particle does not collide with itself
    assert!((gas.temperature(0.02) - 0.206).abs() < 1e-3, "{}", gas.temperature(0.02));
    // the rate of collisions is half of the sum over all particles, because each collision has two partners
    assert!((gas.pair_rate(0.0) / 1897.0 / 1000.0 - 1.0).abs() < 1e-3);
    assert!((gas.pair_rate(0.02) / gas.pair_rate(0.0) - gas.temperature(0.02).sqrt()).abs() < 1e-12);
    let mut run = experiment(scene.clone(), 2000, [0.0; 3], 1.0, Model::Hard, 1);
    run.run.duration = 0.02;
    let start = diptych::placement::initial_state(&run).unwrap();
    let (outcome, _) = execute(&run, start, &mut []);
    for row in &outcome.series.rows {
        let found = row.granular_temperature().unwrap();
        // the energy of 2000 spheres has the relative standard deviation sqrt(2/(3 N)) = 1.8 %, and its loss has the
        // same
        assert!((found / gas.temperature(row.time) - 1.0).abs() < 0.06, "{} s: {found}", row.time);
    }
    scene.contact = surface(0.9, 0.1);
    assert!(Cooling::of(&lasting(&scene, 1.0), 2000, 1.0).is_none(), "friction takes energy as well");
}

/// Haff's law and the parabolas of a bouncing sphere leave out all other sources of motion. They are not offered as
/// theory of scenes that have such a source.
#[test]
fn driven_scenes_have_no_closed_form() {
    let gas = empty([edge(2000, 406e-6, 0.05); 3], [true; 3], small(), surface(0.9, 0.0));
    assert!(Cooling::of(&lasting(&gas, 1.0), 2000, 1.0).is_some());
    let heated = Scene { thermostat: Some(Thermostat::Stochastic { heating: 1.0 }), ..gas.clone() };
    let sheared = Scene { domain: gas.domain.clone().sheared(10.0, 0.0), ..gas.clone() };
    for (scene, name) in [(heated, "heated"), (sheared, "sheared")] {
        assert!(Cooling::of(&lasting(&scene, 1.0), 2000, 1.0).is_none(), "{name}");
    }
    let mut box_of_one = empty([0.02; 3], [true, false, true], small(), surface(0.9, 0.0));
    box_of_one.gravity = Vector3::new(0.0, -9.81, 0.0);
    box_of_one.walls = vec![plane([0.0; 3], [0.0, 1.0, 0.0], surface(0.9, 0.0))];
    let start = [Vector3::new(0.01, 0.01, 0.01), Vector3::zeros()];
    assert!(Bouncing::of(&lasting(&box_of_one, 1.0), start).is_some());
    let mut belt = box_of_one.clone();
    belt.walls[0].velocity = Vector3::new(0.0, 0.0, 1.0);
    assert!(Bouncing::of(&lasting(&belt, 1.0), start).is_none(), "a wall that moves");
    box_of_one.walls[0].thermal = Some(ThermalWall { temperature: 1.0, seed: 1 });
    assert!(Bouncing::of(&lasting(&box_of_one, 1.0), start).is_none(), "a thermal wall gives another speed");
}

/// Enskog's factor (contact value) is 1.303 at a volume fraction of 0.1. Without this factor, collisions by chance are
/// fewer. With the TC model (elastic collisions in quick succession), a gas does not follow Haff's law.
#[test]
fn the_law_of_cooling_is_that_of_the_variant() {
    let scene = empty([edge(2000, 406e-6, 0.1); 3], [true; 3], small(), surface(0.9, 0.0));
    let mut run = lasting(&scene, 1.0);
    let hard = Cooling::of(&run, 2000, 1.0).unwrap();
    run.run.spheres = Spheres::Dsmc;
    assert_eq!(Cooling::of(&run, 2000, 1.0), Some(hard));
    run.dsmc.enskog = false;
    let dilute = Cooling::of(&run, 2000, 1.0).unwrap();
    assert!((hard.pair_rate(0.0) / dilute.pair_rate(0.0) - 1.303).abs() < 1e-3);
    run.hard.contact_time = Some(1e-5);
    assert_eq!(Cooling::of(&run, 2000, 1.0), Some(dilute), "only hard spheres have the contact time");
    run.run.spheres = Spheres::Hard;
    assert_eq!(Cooling::of(&run, 2000, 1.0), None);
}

/// A theory that only one variant has is drawn with the name of this variant. A theory that all variants have is drawn
/// without names.
#[test]
fn theories_name_their_variants_if_they_differ() {
    let scene = |e: f64| empty([edge(120, 406e-6, 0.05); 3], [true; 3], small(), surface(e, 0.0));
    let legend = |second: f64| {
        let run = |(name, e): (&str, f64)| {
            let mut run = experiment(scene(e), 120, [0.0; 3], 1.0, Model::Hard, 1);
            (run.name, run.run.duration) = (name.into(), 2e-3);
            let start = diptych::placement::initial_state(&run).unwrap();
            execute(&run, start, &mut []).0
        };
        let folder = tempfile::tempdir().unwrap();
        let folder = Folder::create(folder.path().join("out"), false).unwrap();
        let outcomes = [("one", 0.9), ("two", second)].map(run);
        with_study(&outcomes, |study| drop(write_study(&folder, study).unwrap()));
        let picture = std::fs::read_to_string(folder.path().join("figures/over-time.svg")).unwrap();
        ["theory", "theory, one", "theory, two"].map(|label| picture.contains(&format!(">{label}<")))
    };
    assert_eq!(legend(0.9), [true, false, false]);
    assert_eq!(legend(0.7), [false, true, true]);
    assert_eq!(legend(1.0), [false, true, false]);
}

#[test]
fn a_sphere_settles_at_the_velocity_said() {
    let mut scene = empty([0.1, 0.1, 1000.0], [true; 3], small(), surface(0.9, 0.0));
    scene.gravity = Vector3::new(0.0, 0.0, -9.81);
    let fluid = |profile| Fluid::new(1.2, 1.5e-5, profile, Some(Drag::Stokes(Stokes)));
    scene.fluid = Some(fluid(Profile::Uniform(2.0)));
    // Stokes' response time, d² ρ_p/(18 ρ ν)
    let stokes = 406e-6_f64.powi(2) * 1038.0 / (18.0 * 1.2 * 1.5e-5);
    let expected = 2.0 - 9.81 * stokes;
    assert!((settling_velocity(&scene).unwrap().z - expected).abs() < 1e-9 * expected.abs());
    scene.fluid = Some(fluid(Profile::table(&[(0.0, 0.0), (0.1, 1.0)]).unwrap()));
    assert!(settling_velocity(&scene).is_none());
}

/// Outcomes of a short run of three spheres, soft and hard.
fn three() -> Vec<diptych::Outcome> {
    let mut scene = empty([0.01, 0.01, 0.01], [true, false, true], small(), surface(0.9, 0.0));
    scene.gravity = Vector3::new(0.0, -9.81, 0.0);
    scene.walls = vec![plane([0.0; 3], [0.0, 1.0, 0.0], surface(0.9, 0.0))];
    let run = |model: Model| {
        let mut run = experiment(scene.clone(), 0, [0.0; 3], 0.0, model, 1);
        run.name = format!("{model:?}");
        let places = [1e-3, 3e-3, 6e-3].map(|x| ([x, 5e-4 + 0.1 * x, 5e-3], [0.1, 0.0, 0.0]));
        run.start[0].amount = diptych::experiment::Amount::Placed(placed(&scene, &places));
        run.run.duration = 0.02;
        let start = diptych::placement::initial_state(&run).unwrap();
        execute(&run, start, &mut []).0
    };
    vec![run(Model::Soft), run(Model::Hard)]
}

#[test]
fn tables_over_time_hold_the_rows_of_the_outcome() {
    let outcomes = three();
    let folder = tempfile::tempdir().unwrap();
    let folder = Folder::create(folder.path().join("out"), false).unwrap();
    with_study(&outcomes, |study| drop(write_study(&folder, study).unwrap()));
    let text = |name: &str| std::fs::read_to_string(folder.path().join(name)).unwrap();
    let (series, paths, page) = (text("series.csv"), text("paths.csv"), text("report.html"));
    let rows: Vec<Vec<&str>> = series.lines().map(|line| line.split(',').collect()).collect();
    let column = |name: &str| rows[0].iter().position(|cell| *cell == name).unwrap_or_else(|| panic!("{name}"));
    assert_eq!(rows.len(), 1 + outcomes.iter().map(|outcome| outcome.series.rows.len()).sum::<usize>());
    for (cells, row) in rows[1..].iter().zip(outcomes.iter().flat_map(|outcome| &outcome.series.rows)) {
        let number = |name: &str| cells[column(name)].parse::<f64>().ok();
        assert_eq!(number("t_s"), Some(row.time));
        assert_eq!(number("mean_velocity_y_m_s"), Some(row.velocity.y));
        assert_eq!(number("kinetic_energy_J"), Some(row.kinetic_energy));
        assert_eq!(number("Tyy_m2_s2"), row.temperature.map(|parts| parts.y));
        assert_eq!(number("wall_impacts"), Some(row.wall_impacts as f64));
        assert_eq!(number("centre_of_mass_y_m"), row.centre[1]);
        // the cell of an unknown value is empty
        assert_eq!((cells[column("centre_of_mass_x_m")], row.centre[0]), ("", None));
    }
    let points = outcomes.iter().flat_map(|outcome| &outcome.paths.points);
    assert_eq!(
        paths.lines().next(),
        Some("variant,t_s,id,x_m,y_m,z_m,vx_m_s,vy_m_s,vz_m_s,overlap_m,wx_rad_s,wy_rad_s,wz_rad_s")
    );
    assert_eq!(paths.lines().count(), 1 + points.clone().count());
    for (line, point) in paths.lines().skip(1).zip(points) {
        let numbers: Vec<f64> =
            line.split(',').skip(1).filter(|cell| !cell.is_empty()).map(|cell| cell.parse().unwrap()).collect();
        assert_eq!((numbers[0], numbers[1] as u32, numbers[3]), (point.time, point.id, point.position.y));
        assert_eq!((numbers[6], numbers[8]), (point.velocity.y, point.overlap));
    }
    // a fall is not steady: its curves are at the beginning of the page, before the averages
    let place = |words: &str| page.find(words).unwrap_or_else(|| panic!("{words}"));
    assert!(place("<h2 id=\"over-time\">Over time</h2>") < place("<h2>Cost and counts</h2>"));
    assert!(place("<h2>Profiles</h2>") < place("Number density"));
    assert!(folder.path().join("figures/over-time.svg").exists() && folder.path().join("figures/paths.svg").exists());
}

#[test]
fn pictures_over_time_of_steady_runs_follow_the_averages() {
    let mut made = outcomes();
    let mut rows = three().remove(0).series;
    rows.rows.truncate(40);
    made.iter_mut().for_each(|outcome| outcome.series = rows.clone());
    let folder = tempfile::tempdir().unwrap();
    let folder = Folder::create(folder.path().join("out"), false).unwrap();
    with_study(&made, |study| drop(write_study(&folder, study).unwrap()));
    let page = std::fs::read_to_string(folder.path().join("report.html")).unwrap();
    let place = |words: &str| page.find(words).unwrap_or_else(|| panic!("{words}"));
    assert!(place("<h2>Differences</h2>") < place("<h2>Over time</h2>"), "folded, after the answers");
    assert!(!folder.path().join("paths.csv").exists());
}

/// Observers record a run of zero duration as one row, although they see its only instant twice.
#[test]
fn nothing_simulated_is_one_row() {
    let mut still =
        experiment(empty([0.01; 3], [true; 3], small(), surface(0.9, 0.0)), 3, [0.0; 3], 0.1, Model::Hard, 1);
    still.run.duration = 0.0;
    let schedule = Schedule::new(&still);
    let simulation = Simulation::new(&still, diptych::placement::initial_state(&still).unwrap());
    let (mut series, mut paths) = (Series::new(&still, &schedule), Paths::new(&schedule));
    for observer in [&mut series as &mut dyn Observer, &mut paths] {
        observer.see(&simulation);
        observer.end(&simulation);
    }
    assert_eq!((series.rows.len(), paths.points.len()), (1, 3));
}
