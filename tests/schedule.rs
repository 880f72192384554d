//! The windows of the schedule must be short enough for the promised accuracy. A window is the time between two drag
//! kicks.

use crate::support::*;
use diptych::case::Case;
use diptych::clock::Clock;
use diptych::domain::Domain;
use diptych::drag::{Drag, SchillerNaumann};
use diptych::engine::{Engine, Failure};
use diptych::experiment::{Amount, Experiment, HardStepping, Integrator, Model, Spheres};
use diptych::fluid::{Coupling, Fluid, HeldFlow, Modulation, Profile};
use diptych::observe::{RunLoop, Series};
use diptych::placement::initial_state;
use diptych::predict::Obstacles;
use diptych::rotation::{ImpactRule, Rotation, TangentialLaw};
use diptych::scene::{Inlet, Outlet, OutletShape, Scene, Species, Thermostat};
use diptych::schedule::{SPLITTING, SPLITTING_ALONE, Schedule, longest_for_coupling, longest_for_thermostat};
use diptych::simulation::Simulation;
use diptych::walls::{Cavity, Hollow, Plane, PrescribedMotion, ThermalWall, Turning, Wall};
use nalgebra::Vector3;
use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicBool, Ordering};

/// Tall box of gas at rest with gravity downwards. The box is not periodic along z.
fn still_air(species: Species) -> Scene {
    let mut scene = empty([2.0, 2.0, 300.0], [true, true, false], species, surface(1.0, 0.0));
    scene.gravity = Vector3::new(0.0, 0.0, -9.81);
    scene.fluid =
        Some(Fluid::new(1.205, 1.515e-5, Profile::Uniform(0.0), Some(Drag::SchillerNaumann(SchillerNaumann))));
    scene
}

/// Experiment of a sphere that starts in the upper part of the box with `velocity` [m/s] and runs for `duration` [s].
fn thrown(species: Species, velocity: [f64; 3], duration: f64) -> Experiment {
    let mut experiment = experiment(still_air(species), 1, [0.0; 3], 0.0, Model::Hard, 1);
    experiment.start[0].amount = Amount::Placed(placed(&experiment.scene, &[([1.0, 1.0, 250.0], velocity)]));
    experiment.run.duration = duration;
    experiment
}

/// [m/s] velocity at the end of a run in which each window of the schedule (time between two drag kicks) is divided
/// into `parts` equal parts.
fn velocity(experiment: &Experiment, parts: u64) -> Vector3<f64> {
    let schedule = Schedule::new(experiment);
    let mut simulation = Simulation::new(experiment, initial_state(experiment).unwrap());
    let windows = parts * schedule.length();
    simulation.run(windows, schedule.window / parts as f64).unwrap();
    simulation.particles.velocity[0]
}

/// Falls of spheres with terminal Reynolds numbers of 45, 297, 551 and 1730, stopped early, halfway and late. The
/// reference has windows (times between two drag kicks) a twentieth as long, with a four-hundredth of the error. The
/// drag coefficient jumps by 0.4 % at Re = 1000, which the largest sphere passes. There, the wrong coefficient acts
/// for half a window at most, and the deceleration is below g.
#[test]
fn windows_for_a_fall_from_rest() {
    let sphere = |diameter: f64| Species { diameter, ..large() };
    for species in [small(), sphere(1.08e-3), large(), sphere(3e-3)] {
        for duration in [0.01, 0.05, 0.2, 0.6, 4.0] {
            let fall = thrown(species.clone(), [0.0; 3], duration);
            let (coarse, fine) = (velocity(&fall, 1), velocity(&fall, 20));
            let error = (coarse - fine).norm() / fine.norm();
            let what = format!("{} m, {duration} s: off by {error:e}", species.diameter);
            let jump = if fine.norm() > 1000.0 * 1.515e-5 / species.diameter { 0.002 } else { 0.0 };
            let crossing = jump * 9.81 * Schedule::new(&fall).window / fine.norm();
            assert!(error < SPLITTING_ALONE + crossing, "{what}");
            // the window must not be too short: the error must be at least a tenth of the limit, or the window a third
            // of the longest one
            assert!(error > 0.1 * SPLITTING_ALONE, "{what}: the window is too short");
        }
    }
}

/// Drag on a sphere thrown across the gas depends on its total speed. The sphere falls at the same time.
#[test]
fn windows_for_a_throw_across() {
    for duration in [0.05, 1.0] {
        let throw = thrown(small(), [20.0, 0.0, 0.0], duration);
        let (coarse, fine) = (velocity(&throw, 1), velocity(&throw, 20));
        let error = (coarse - fine).norm() / fine.norm();
        assert!(error < SPLITTING_ALONE, "{duration} s: off by {error:e}");
    }
}

/// If many spheres start at rest, the windows (times between two drag kicks) are no longer than for one sphere,
/// because collisions require shorter windows.
#[test]
fn windows_for_beads_at_rest() {
    let alone = Schedule::new(&thrown(large(), [0.0; 3], 0.5)).window;
    let mut beads = experiment(still_air(large()), 1000, [0.0; 3], 0.0, Model::Soft, 1);
    beads.run.duration = 0.5;
    assert_eq!(Schedule::new(&beads).window, alone, "collisions are rare in 1200 m³");
    beads.scene.domain.size = Vector3::new(0.02, 0.02, 0.02);
    let crowded = Schedule::new(&beads).window;
    assert!(crowded < 0.7 * alone, "{crowded} s in a crowd, {alone} s alone");
    // a start with very small velocities must not give longer windows
    beads.start[0].velocity_fluctuation = nalgebra::Vector3::repeat(1e-6);
    assert_eq!(Schedule::new(&beads).window, crowded);
}

/// Experiment of many spheres in gas at rest without gravity. Drag slows them down by a factor of a hundred.
fn slowing(model: Model) -> Experiment {
    let mut scene = still_air(small());
    scene.gravity = Vector3::zeros();
    scene.domain = Domain::new(Vector3::repeat(5e-3), [true; 3]);
    scene.contact = surface(0.9, 0.0);
    let mut crowd = experiment(scene, 100, [0.0; 3], 4.0, model, 1);
    crowd.run.duration = 1.0;
    crowd
}

/// Windows (times between two drag kicks) grow while drag slows the particles down, equally for every model. They are
/// at most as long as those of a case that begins with the present state.
#[test]
fn windows_grow_while_a_crowd_slows_down() {
    let crowd = slowing(Model::Hard);
    let schedule = Schedule::new(&crowd);
    assert_eq!(schedule, Schedule::new(&slowing(Model::Soft)));
    assert!(schedule.windows() < schedule.length() / 2 && schedule.longest() <= 1e-3, "{schedule:?}");
    let mut simulation = Simulation::new(&crowd, initial_state(&crowd).unwrap());
    let (mut lengths, mut windows) = (vec![schedule.window], 0);
    for sample in 0..schedule.samples {
        let together = schedule.together(sample * schedule.windows_per_sample);
        let window = together as f64 * schedule.window;
        if window > 1.5 * lengths[lengths.len() - 1] {
            lengths.push(window);
            let mut from_here = crowd.clone();
            from_here.start[0].amount = Amount::Placed(simulation.state());
            let own = Schedule::new(&from_here).window;
            // the number of windows between two samples is whole, so that the windows of a case of its own may be
            // shorter by one in this number
            assert!(window < 1.2 * own, "at sample {sample}: {window} s, from there {own} s");
        }
        let count = schedule.windows_per_sample / together;
        windows += count;
        simulation.run(count, window).unwrap();
    }
    assert!(lengths.len() > 2, "{lengths:?}");
    assert_eq!((windows, simulation.windows), (schedule.windows(), schedule.windows()));
    assert!((simulation.time - 1.0).abs() < 1e-9);
}

/// Windows (times between two drag kicks) all have one length if the particles start with the velocity of the gas, or
/// if the gas keeps driving them.
#[test]
fn windows_stay_where_the_gas_keeps_particles_moving() {
    let mut crowd = slowing(Model::Hard);
    crowd.run.window = Some(1e-4);
    assert_eq!(Schedule::new(&crowd).longest(), Schedule::new(&crowd).window);
    let mut crowd = slowing(Model::Hard);
    if let Some(fluid) = &mut crowd.scene.fluid {
        fluid.profile = Profile::Uniform(10.0);
    }
    assert_eq!(Schedule::new(&crowd).longest(), Schedule::new(&crowd).window);
    // gravity drives the particles too
    let mut crowd = slowing(Model::Hard);
    crowd.scene.gravity = Vector3::new(0.0, 0.0, -9.81);
    crowd.start[0].velocity_fluctuation = Vector3::repeat(0.5);
    assert_eq!(Schedule::new(&crowd).longest(), Schedule::new(&crowd).window);
}

/// Windows (times between two drag kicks) have one length if something gives energy to the particles, because the
/// speed of a sphere slowed by drag alone then says nothing about their speeds.
#[test]
fn windows_stay_where_particles_gain_energy() {
    let smooth = || surface(0.9, 0.0);
    let floor = || plane([0.0; 3], [0.0, 1.0, 0.0], smooth());
    let moving = || floor().moving(PrescribedMotion::Translation { velocity: Vector3::x() }).unwrap();
    let spin = Turning { center: Vector3::zeros(), spin: Vector3::y() };
    let middle = Cavity::Box { center: Vector3::repeat(2.5e-3), half_extents: Vector3::repeat(1e-3) };
    let inlet = Inlet {
        name: "feed".into(),
        species: 0,
        region: Hollow::new(middle),
        rate: 1.0,
        start: 0.0,
        end: f64::INFINITY,
        velocity_mean: Vector3::zeros(),
        velocity_fluctuation: Vector3::repeat(1.0),
        spin_mean: Vector3::zeros(),
        spin_fluctuation: 0.0,
    };
    let walled = |wall: Wall| move |scene: &mut Scene| scene.walls = vec![wall.clone()];
    type Feed = Box<dyn Fn(&mut Scene)>;
    let feeds: [(&str, bool, Feed); 9] = [
        ("nothing", false, Box::new(|_| ())),
        ("wall at rest", false, Box::new(walled(floor()))),
        ("moving wall", true, Box::new(walled(moving()))),
        ("belt", true, Box::new(walled(Wall { velocity: Vector3::x(), ..floor() }))),
        ("turntable", true, Box::new(walled(Wall { turning: Some(spin), ..floor() }))),
        (
            "thermal wall",
            true,
            Box::new(walled(Wall { thermal: Some(ThermalWall { temperature: 1.0, seed: 1 }), ..floor() })),
        ),
        ("thermostat", true, Box::new(|scene| scene.thermostat = Some(Thermostat::Stochastic { heating: 0.1 }))),
        ("inlet", true, Box::new(move |scene| scene.inlets = vec![inlet.clone()])),
        (
            "spins",
            true,
            Box::new(|scene| scene.rotation = Some(Rotation::new(TangentialLaw::Coulomb, ImpactRule::COULOMB))),
        ),
    ];
    for (name, is_fed, feed) in feeds {
        let mut crowd = slowing(Model::Hard);
        feed(&mut crowd.scene);
        let schedule = Schedule::new(&crowd);
        assert_eq!(schedule.longest() == schedule.window, is_fed, "{name}: {schedule:?}");
    }
}

/// A scene that an inlet fills has the windows (times between two drag kicks) of a scene that starts with as many
/// particles. This holds with drag, with two-way coupling and with a thermostat. With an outlet, the particles count
/// that come in during the time in which one particle crosses the box.
#[test]
fn windows_count_what_inlets_bring() {
    let region = Cavity::Box { center: Vector3::repeat(2.5e-3), half_extents: Vector3::repeat(2.5e-3) };
    let inlet = |rate: f64| Inlet {
        name: "feed".into(),
        species: 0,
        region: Hollow::new(region),
        rate,
        start: 0.0,
        end: f64::INFINITY,
        velocity_mean: Vector3::new(0.0, 0.0, 1e-3),
        velocity_fluctuation: Vector3::zeros(),
        spin_mean: Vector3::zeros(),
        spin_fluctuation: 0.0,
    };
    let mut full = slowing(Model::Hard);
    full.scene.thermostat = Some(Thermostat::Stochastic { heating: 0.1 });
    let coupling = Coupling { slices: 7, held: HeldFlow::PressureGradient(0.0), modulation: Modulation::None };
    full.scene.fluid.as_mut().unwrap().coupling = Some(coupling);
    let mut fed = full.clone();
    fed.start[0].amount = Amount::Count(0);
    // 1 particle at the start of the run, and 99 more within its second
    fed.scene.inlets = vec![inlet(99.0)];
    let windows =
        |one: &Experiment| [longest_for_coupling(one), longest_for_thermostat(one), Schedule::new(one).window];
    assert_eq!(windows(&fed), windows(&full));
    assert!(windows(&full).iter().all(|window| *window < 0.1), "{:?}", windows(&full));
    // 5 sqrt(3) mm at 1 mm/s: 8.66 s
    let plane = Plane { point: Vector3::zeros(), normal: Vector3::z() };
    fed.scene.outlets = vec![Outlet { name: "end".into(), shape: OutletShape::Behind(plane) }];
    fed.run.duration = 100.0;
    assert!((fed.expected_count() - (1.0 + 99.0 * 8.660254)).abs() < 1e-3, "{}", fed.expected_count());
}

/// A run that is stopped after every window (time between two drag kicks) and resumed has identical bits. Its
/// observers are called at their times.
#[test]
fn growing_windows_can_be_left_anywhere() {
    let crowd = slowing(Model::Soft);
    let schedule = Schedule::new(&crowd);
    assert!(schedule.longest() > schedule.window);
    let mut whole = Simulation::new(&crowd, initial_state(&crowd).unwrap());
    let mut series = Series::new(&crowd, &schedule);
    diptych::observe::run(&mut whole, &schedule, &mut [&mut series]).unwrap();
    let (mut simulation, mut again) =
        (Simulation::new(&crowd, initial_state(&crowd).unwrap()), Series::new(&crowd, &schedule));
    let mut course = RunLoop::new(&schedule, 1);
    while !course.run(&mut simulation, &mut [&mut again], &mut || true).unwrap() {
        let pause = course.store(&simulation, &[&mut again]).unwrap();
        again = Series::new(&crowd, &schedule);
        (simulation, course) = pause.resume(&crowd, &mut [&mut again]).unwrap();
    }
    assert_eq!(simulation.state().fingerprint(), whole.state().fingerprint());
    assert_eq!(again.rows, series.rows);
    // rows are about as frequent at the end as at the start
    let gaps: Vec<f64> = series.rows.windows(2).map(|rows| rows[1].time - rows[0].time).collect();
    assert!(gaps[..gaps.len() - 1].iter().all(|gap| *gap < 3.0 * gaps[0]), "{gaps:?}");
}

/// Within one long window (piece of the run), every engine reports its progress, so that an observer sees times
/// between the start and the end of the window.
#[test]
fn a_long_window_tells_where_it_is() {
    let scene = empty([edge(600, 1.0, 0.05); 3], [true; 3], unit(), surface(0.9, 0.0));
    let start = random(&scene, 600, 1.0, 3);
    // contacts last π sqrt(m/(2k)) = 0.022 s
    let engines: [(&str, Box<dyn Engine>); 4] = [
        ("uniform", soft(1e4, 1e-3, Integrator::VelocityVerlet)),
        ("local", local(1e4, 1e-3, Integrator::VelocityVerlet)),
        ("hard", hard()),
        ("stepped", stepped(0.02)),
    ];
    for (name, engine) in engines {
        let clock = Clock::wall();
        let reached = clock.reached().unwrap();
        let mut simulation = Simulation::with_engine(scene.clone(), start.clone(), engine).with_clock(clock);
        let over = AtomicBool::new(false);
        let inside = std::thread::scope(|scope| {
            let watching = scope.spawn(|| {
                let (mut last, mut inside) = (0.0, 0);
                while !over.load(Ordering::Relaxed) {
                    let now = reached.time();
                    inside += u32::from(now > last && now < 20.0);
                    last = now;
                }
                inside
            });
            simulation.run(1, 20.0).unwrap();
            over.store(true, Ordering::Relaxed);
            watching.join().unwrap()
        });
        assert_eq!(reached.time(), 20.0, "{name}");
        assert!(inside > 3, "{name}: {inside} times seen within the window");
    }
}

/// Cases of the project with hard spheres, each once. Their experiments have the windows (times between two drag
/// kicks) of the case.
fn shipped() -> Vec<(String, Experiment)> {
    let root = Path::new(env!("CARGO_MANIFEST_DIR"));
    let files = ["cases", "cases/paper"].map(|folder| std::fs::read_dir(root.join(folder)).unwrap());
    let mut paths: Vec<PathBuf> = files.into_iter().flatten().map(|entry| entry.unwrap().path()).collect();
    paths.retain(|path| path.extension().is_some_and(|extension| extension == "toml"));
    paths.sort();
    let hard = |path: PathBuf| {
        let mut experiment = Case::read(&path, &[]).and_then(|case| case.variants(None)).unwrap().remove(0).0;
        experiment.run.spheres = Spheres::Hard;
        experiment.hard.stepping = HardStepping::Events;
        experiment.run.window = None;
        experiment.run.window = Some(Schedule::new(&experiment).window);
        (path.file_stem().unwrap().to_string_lossy().into_owned(), experiment)
    };
    paths.into_iter().map(hard).collect()
}

/// Experiment with `count` particles, from random starts in the whole box.
fn with_particles(experiment: &Experiment, count: usize) -> Experiment {
    let mut fewer = experiment.clone();
    let all = experiment.count();
    for population in &mut fewer.start {
        if let Amount::Count(own) = &mut population.amount {
            *own = (*own * count.min(all)).div_ceil(all);
        }
    }
    fewer
}

/// Case in a box that is shorter along z, with about `count` particles, from another random start.
fn shortened(experiment: &Experiment, count: usize, seed: u64) -> Experiment {
    let mut short = with_particles(experiment, count);
    let mut size = experiment.scene.domain.size;
    size.z *= short.count() as f64 / experiment.count() as f64;
    // a box that would be too short along z is made narrower instead
    let least = 10.0 * experiment.scene.species[0].diameter;
    (size.x, size.z) = (size.x * (size.z / least).min(1.0), size.z.max(least));
    short.scene.domain = Domain::new(size, experiment.scene.domain.periodic);
    short.run.seed = seed;
    short
}

/// Simulation after `windows` windows (times between two drag kicks) of the experiment, each divided into `parts`
/// equal parts.
fn moved(experiment: &Experiment, windows: u64, parts: u64) -> Result<Simulation, Failure> {
    let mut simulation = Simulation::new(experiment, initial_state(experiment).unwrap());
    simulation.run(windows * parts, experiment.run.window.unwrap() / parts as f64)?;
    simulation.particles.sort_by_id();
    Ok(simulation)
}

/// A few particles, which seldom collide, in the whole box of every case. With half the window (time between two drag
/// kicks), the paths of most particles change by no more than promised for a single sphere. Within a window, an impact
/// on a wall has an error of first order in the window for one sphere, and of second order on average.
#[test]
fn half_the_window_changes_no_path() {
    let mut looked_at = 0;
    for (name, experiment) in shipped() {
        let few = with_particles(&experiment, 20);
        // the time in which particles cross a third of a channel, so that few of the twenty particles collide
        let agitation = experiment.start.iter().map(|population| population.mean_fluctuation()).fold(1e-9, f64::max);
        let across = 0.013 / (agitation * experiment.run.window.unwrap());
        let windows = Schedule::new(&experiment).windows().min(64).min(across as u64);
        let Ok([one, half]) = (|| Ok::<_, Failure>([moved(&few, windows, 1)?, moved(&few, windows, 2)?]))() else {
            assert!(
                ["column", "pouring"].contains(&name.as_str()),
                "{name}: only what comes to rest is nothing for hard spheres"
            );
            continue;
        };
        let change: Vec<Vector3<f64>> =
            one.particles.velocity.iter().zip(&half.particles.velocity).map(|(one, half)| one - half).collect();
        let fastest = one.particles.largest_speed(Vector3::zeros());
        let mut sizes: Vec<f64> = change.iter().map(|change| change.norm() / fastest).collect();
        sizes.sort_by(f64::total_cmp);
        let (median, worst) = (sizes[sizes.len() / 2], sizes[sizes.len() - 1]);
        let mean = change.iter().sum::<Vector3<f64>>().norm() / change.len() as f64 / fastest;
        let [alone, together] = match &experiment.scene.fluid {
            Some(_) => [SPLITTING_ALONE, SPLITTING],
            // without drag there is no splitting, and only rounding errors, which an impact may amplify a thousandfold
            None => [1e-12, 1e-12],
        };
        assert!(median < alone && mean < together, "{name}: median {median:.1e}, worst {worst:.1e}, mean {mean:.1e}");
        looked_at += 1;
    }
    assert!(looked_at > 25, "{looked_at} cases");
}

/// Many particles, which collide and have chaotic paths: agitation and mean velocity over an interval of time,
/// averaged over several starts. A change of the agitation by 2 to 4 % would be found. Drag and flight are computed in
/// turn (splitting of second order), so windows eight times as long have 64 times the error. If this error is not
/// found, the error of the present windows is below a thousandth.
#[test]
fn half_the_window_changes_no_average() {
    const STARTS: u64 = 16;
    const LONGER: u64 = 8;
    // the error of the present windows is subtracted from that of the longer windows
    const TIMES: f64 = (LONGER * LONGER - 1) as f64;
    let mut done: Vec<usize> = Vec::new();
    for (name, experiment) in shipped() {
        // one variant of each scene, and no beds at rest, which hard spheres cannot compute
        let start = initial_state(&experiment).unwrap();
        let bed = Obstacles::of(&experiment, &start).rest.is_some();
        if experiment.scene.fluid.is_none() || bed || done.contains(&experiment.count()) {
            continue;
        }
        done.push(experiment.count());
        let of = |seed: u64, longer: u64| {
            let short = shortened(&experiment, 200, seed);
            let mut simulation = Simulation::new(&short, initial_state(&short).unwrap());
            let mut sums = [0.0; 2];
            for stretch in 0..12 {
                simulation.run(5 * LONGER / longer, short.run.window.unwrap() * longer as f64).unwrap();
                if stretch >= 4 {
                    let (mean, count) = (simulation.particles.mean_velocity(), simulation.particles.len() as f64);
                    let square = simulation.particles.velocity.iter().map(|v| (v - mean).norm_squared()).sum::<f64>();
                    sums = [sums[0] + (square / count).sqrt(), sums[1] + mean.z];
                }
            }
            sums
        };
        let changes: Vec<[f64; 2]> = (1..=STARTS)
            .map(|seed| {
                let [longer, one] = [of(seed, LONGER), of(seed, 1)];
                [longer[0] / one[0] - 1.0, longer[1] / one[1] - 1.0]
            })
            .collect();
        for (k, what) in ["agitation", "mean velocity"].into_iter().enumerate() {
            let mean = changes.iter().map(|change| change[k]).sum::<f64>() / STARTS as f64;
            let squares = changes.iter().map(|change| (change[k] - mean).powi(2)).sum::<f64>();
            // Student's t with 15 degrees of freedom exceeds 4.1 in one of a thousand cases
            let allowed = TIMES * SPLITTING + 4.1 * (squares / (STARTS * (STARTS - 1)) as f64).sqrt();
            println!("{name}: {what} {:.1e} of {:.1e}", mean / TIMES, allowed / TIMES);
            assert!(mean.abs() < allowed, "{name}: {what} changes by {mean:.1e}, allowed {allowed:.1e}");
            assert!(allowed < 1e-3 * TIMES, "{name}: {what} is known to {allowed:.1e}: the test sees nothing");
        }
    }
    assert!(done.len() > 4, "{} scenes", done.len());
}
