//! Collisions by chance (DSMC): rates against kinetic theory, cooling, walls, vessels, conserved quantities, bits,
//! messages. Mixtures are in `mixtures.rs`, rough spheres in `rotation/gases.rs`, stored states in `snapshots.rs`.

use crate::support::*;
use diptych::engine::dsmc::Dsmc;
use diptych::engine::{Engine, Failure};
use diptych::experiment::{DsmcSettings, Experiment, Model};
use diptych::particles::Particles;
use diptych::placement::initial_state;
use diptych::scene::Scene;
use diptych::simulation::Simulation;
use diptych::walls::{Cavity, Hollow, Obstacle, RoundAxis, Wall, WallGeometry};
use nalgebra::Vector3;
use rand::SeedableRng;
use rand::seq::SliceRandom;
use rand_xoshiro::Xoshiro256PlusPlus;
use rayon::prelude::*;
use std::f64::consts::PI;

fn engine(settings: DsmcSettings, seed: u64) -> Box<dyn Engine> {
    Box::new(Dsmc::new(settings, seed))
}

/// Settings of collisions by chance with one cell that contains all particles.
const ONE_CELL: DsmcSettings = DsmcSettings { enskog: true, cells: Some([1; 3]), step: 0.2 };

/// Unit spheres in a periodic cube with the volume fraction `phi`, at the granular temperature T = 1 m²/s².
fn cube(count: usize, phi: f64, restitution: f64, seed: u64) -> (Scene, Particles) {
    let scene = empty([edge(count, 1.0, phi); 3], [true; 3], unit(), surface(restitution, 0.0));
    let mut particles = random(&scene, count, 1.0, seed);
    let scale = 1.0 / temperature(&particles).sqrt();
    particles.velocity.iter_mut().for_each(|v| *v *= scale);
    (scene, particles)
}

/// Collision rate of a particle at the granular temperature 1 m²/s² with the contact value `g`, by kinetic theory
/// (Chapman and Cowling 1970, 5.21, and 16.2 with g).
fn rate_of(phi: f64, g: f64) -> f64 {
    24.0 * phi * g / PI.sqrt()
}

/// Contact value of Carnahan and Starling 1969.
fn carnahan_starling(phi: f64) -> f64 {
    (1.0 - 0.5 * phi) / (1.0 - phi).powi(3)
}

/// Measured collision rate of a particle in a gas at equilibrium, divided by the rate `rate` of kinetic theory, minus 1.
/// Each particle collides ten times before the measurement. The measurement lasts until there are about `collisions`
/// collisions of all particles. A window (piece of the run) is `window` mean free times long.
fn excess(
    scene: &Scene,
    particles: Particles,
    settings: DsmcSettings,
    (rate, window): (f64, f64),
    collisions: f64,
) -> f64 {
    let count = particles.len() as f64;
    let mut simulation = Simulation::with_engine(scene.clone(), particles, engine(settings, 7));
    let windows = |times: f64| (times / window).ceil() as u64;
    simulation.run(windows(10.0), window / rate).unwrap();
    let (before, began) = (simulation.record.pairs.count, simulation.time);
    simulation.run(windows(2.0 * collisions / count), window / rate).unwrap();
    let found = 2.0 * (simulation.record.pairs.count - before) as f64 / count / (simulation.time - began);
    found / rate - 1.0
}

#[test]
fn rates_are_those_of_enskog() {
    // the number n of collisions has the relative standard error 1/sqrt(n) or less, because collisions are drawn one by
    // one; four of these errors are allowed. The mean of the Enskog factor over blocks of 500 particles adds an error,
    // by the formula at PER_BLOCK
    let collisions = 400_000.0_f64;
    for (phi, of_blocks) in [(0.01, 1e-4), (0.1, 1.2e-3), (0.3, 1e-2)] {
        let (scene, particles) = cube(4000, phi, 1.0, 3);
        let finite = 1.0 - 1.0 / 4000.0;
        let rate = rate_of(phi, carnahan_starling(phi)) * finite;
        // windows of two steps, and steps of ten windows
        for window in [0.3, 0.02] {
            let with = excess(&scene, particles.clone(), DsmcSettings::default(), (rate, window), collisions);
            println!("phi {phi}, windows of {window}: with the Enskog factor {with:+.5}");
            assert!(with.abs() < 4.0 / collisions.sqrt() + of_blocks, "{phi}: {with}");
        }
        let settings = DsmcSettings { enskog: false, ..DsmcSettings::default() };
        let without = excess(&scene, particles.clone(), settings, (rate_of(phi, 1.0) * finite, 0.3), collisions);
        println!("phi {phi}: without {without:+.5}");
        assert!(without.abs() < 4.0 / collisions.sqrt(), "{phi}: {without}");
        // all particles are in one block, whose volume fraction does not vary
        let alone = excess(&scene, particles, ONE_CELL, (rate, 0.3), collisions);
        println!("phi {phi}: in one cell {alone:+.5}");
        assert!(alone.abs() < 4.0 / collisions.sqrt(), "{phi}: {alone}");
    }
}

#[test]
fn impact_speeds_are_those_of_a_maxwellian_gas() {
    let (scene, particles) = cube(4000, 0.01, 1.0, 5);
    let mut simulation = Simulation::with_engine(scene, particles, engine(DsmcSettings::default(), 1));
    simulation.run(300, 2.0).unwrap();
    let speeds = &simulation.record.pairs.normal_speed;
    // the normal speeds of impacts have the density u exp(-u²/4)/2, with the mean sqrt(π), the mean square 4, and the
    // standard deviation sqrt(4 - π)
    let count = simulation.record.pairs.count as f64;
    let error = ((4.0 - PI) / count).sqrt();
    println!("{count} impacts, mean normal speed {:.4} ± {error:.4}", speeds.sum() / count);
    close("mean normal speed", speeds.sum() / count, PI.sqrt(), 4.0 * error);
    // the variance of u² is 16
    close("mean square", speeds.sum_of_squares() / count, 4.0, 4.0 * 4.0 / count.sqrt());
}

#[test]
fn haff_s_law_and_a2() {
    // T(t) = T_0 (1 + (1 - e²) Γ_0 t/6)^-2 (Haff 1983). The cooling rate has the factor 1 + 3/16 a2, with a2 of van
    // Noije and Ernst 1998 (Granular Matter 1, 57). In a single cell, no clusters can form
    for (e, a2) in [(0.9_f64, -0.0146), (0.5, 0.0525)] {
        let (starts, count, phi) = (16_u64, 8000, 0.05);
        let rate = rate_of(phi, carnahan_starling(phi));
        let time = 30.0 / rate;
        let runs: Vec<[f64; 2]> = (0..starts)
            .into_par_iter()
            .map(|seed| {
                let (scene, particles) = cube(count, phi, e, seed);
                let mut simulation = Simulation::with_engine(scene, particles, engine(ONE_CELL, seed));
                let mut kurtosis = 0.0;
                for _ in 0..3 {
                    simulation.run(50, time / 150.0).unwrap();
                    let velocities = &simulation.particles.velocity;
                    let mean = |power: i32| velocities.iter().map(|v| v.norm().powi(power)).sum::<f64>() / count as f64;
                    kurtosis += (0.6 * mean(4) / mean(2).powi(2) - 1.0) / 3.0;
                }
                [temperature(&simulation.particles), kurtosis]
            })
            .collect();
        let [found, kurtosis] = [0, 1].map(|k| runs.iter().map(|run| run[k]).sum::<f64>() / starts as f64);
        let law = (1.0 + (1.0 - e * e) * (1.0 + 3.0 / 16.0 * a2) * rate * time / 6.0).powi(-2);
        let all = (starts * count as u64) as f64;
        println!("e {e}: T {found:.5}, law {law:.5}; a2 {kurtosis:.4}, theory {a2}");
        // four standard errors of T, sqrt(2/(3 N)), and an allowance for the start, where a2 is 0 during the first
        // collisions
        close("T by Haff's law", found / law, 1.0, 4.0 * (2.0 / (3.0 * all)).sqrt() + 2.0 * a2.abs() / 16.0);
        // four standard errors of a2, sqrt(8/(15 N)), at three instants some collisions apart, and a fifth of a2,
        // because the theory is of first order in a2
        close("a2", kurtosis, a2, 4.0 * (8.0 / (15.0 * 3.0 * all)).sqrt() + 0.2 * a2.abs());
    }
}

/// Unit spheres in a slit between two planes, at the granular temperature 1 m²/s².
fn slit(count: usize, size: [f64; 3]) -> (Scene, Particles) {
    let wall = surface(1.0, 0.0);
    let mut scene = empty(size, [true, false, true], unit(), wall);
    scene.walls = vec![plane([0.0; 3], [0.0, 1.0, 0.0], wall), plane([0.0, size[1], 0.0], [0.0, -1.0, 0.0], wall)];
    let mut particles = random(&scene, count, 1.0, 4);
    let scale = (3.0 * count as f64 / (2.0 * particles.kinetic_energy())).sqrt();
    particles.velocity.iter_mut().for_each(|v| *v *= scale);
    (scene, particles)
}

#[test]
fn walls_see_a_uniform_gas_of_centres() {
    // walls have n sqrt(T/2π) impacts and receive the impulse n T per area and time. The density n of centres is that
    // between planes shifted inwards by a radius; pairs collide in the same volume. The tolerance is four standard
    // errors of numbers of events
    let (count, size) = (2000, [20.0, 10.0, 20.0]);
    let (scene, particles) = slit(count, size);
    let time = 600.0;
    let mut simulation = Simulation::with_engine(scene, particles, engine(DsmcSettings::default(), 2));
    simulation.run(3000, time / 3000.0).unwrap();
    let (volume, area) = (20.0 * 9.0 * 20.0, 2.0 * 400.0);
    let density = count as f64 / volume;
    let within = |what: &str, found: f64, want: f64, events: f64| {
        println!("{what}: {:.5} of theory", found / want);
        close(what, found / want, 1.0, 4.0 / events.sqrt());
    };
    let hits = simulation.record.walls.count as f64;
    within("impacts on walls", hits, density * area * time / (2.0 * PI).sqrt(), hits);
    within("pressure", simulation.record.ledger.wall_normal_impulse, density * area * time, hits);
    // the volume fraction is that of the whole box
    let phi = PI / 6.0 * count as f64 / (20.0 * 10.0 * 20.0);
    let pairs = simulation.record.pairs.count as f64;
    let want = 0.5 * (count - 1) as f64 * 4.0 * density * PI.sqrt() * carnahan_starling(phi) * time;
    println!("phi {phi}");
    // 1 % for the variation of the volume fraction among four blocks, by the formula at PER_BLOCK
    close("pairs", simulation.record.pairs.count as f64 / want, 1.0, 4.0 / pairs.sqrt() + 0.01);
}

#[test]
fn cells_that_curved_walls_cut_are_as_full_as_others() {
    // pairs in a pipe and around a ball: ½ N (N - 1) 4 sqrt(π)/V, with the volume V that centres can reach
    let wall = surface(1.0, 0.0);
    let of = |geometry| Wall::new(geometry, wall);
    let pipe =
        Hollow::new(Cavity::Pipe { axle: RoundAxis { center: Vector3::new(10.0, 10.0, 0.0), axis: 2 }, radius: 10.0 });
    let ball = Obstacle::sphere(Vector3::repeat(15.0), 8.0);
    let scenes = [
        ("pipe", [20.0, 20.0, 40.0], [false, false, true], of(WallGeometry::Hollow(pipe)), PI * 9.5_f64.powi(2) * 40.0),
        ("ball", [30.0; 3], [true; 3], of(WallGeometry::Obstacle(ball)), 27_000.0 - 4.0 / 3.0 * PI * 8.5_f64.powi(3)),
    ];
    for (name, size, periodic, wall, volume) in scenes {
        let mut scene = empty(size, periodic, unit(), surface(1.0, 0.0));
        scene.walls = vec![wall];
        let count = 1000;
        let mut particles = random(&scene, count, 1.0, 8);
        let scale = (3.0 * count as f64 / (2.0 * particles.kinetic_energy())).sqrt();
        particles.velocity.iter_mut().for_each(|v| *v *= scale);
        let settings = DsmcSettings { enskog: false, ..DsmcSettings::default() };
        let mut simulation = Simulation::with_engine(scene, particles, engine(settings, 3));
        simulation.run(200, 1.0).unwrap();
        let before = simulation.record.pairs.count;
        simulation.run(3000, 1.0).unwrap();
        let found = (simulation.record.pairs.count - before) as f64;
        let want = 0.5 * (count * (count - 1)) as f64 * 4.0 * PI.sqrt() / volume * 3000.0;
        println!("{name}: {:.5} of theory, {found} pairs", found / want);
        // lattices of six points along an edge find the volume of all cells within 1 %
        close(name, found / want, 1.0, 4.0 / found.sqrt() + 0.01);
    }
}

/// Case of a channel with gas, gravity, friction and rotation.
const CHANNEL: &str = r#"
[domain]
size = ["10 mm", "8 mm", "12 mm"]
periodic = ["x", "z"]

[gravity]
acceleration = ["0 m/s^2", "-20 m/s^2", "-9.81 m/s^2"]

[fluid]
density = "1.2 kg/m^3"
kinematic_viscosity = "1.5e-5 m^2/s"
[fluid.profile.uniform]
velocity = "3 m/s"
[drag.schiller_naumann]

[[particles]]
name = "small"
diameter = "0.4 mm"
density = "1000 kg/m^3"
count = 900
velocity_mean = ["0 m/s", "0 m/s", "1 m/s"]
velocity_fluctuation = "0.5 m/s"

[[particles]]
name = "large"
diameter = "0.8 mm"
density = "1500 kg/m^3"
count = 100
velocity_fluctuation = "0.5 m/s"

[[walls]]
plane = { point = ["0 m", "0 m", "0 m"], normal = [0, 1, 0] }
restitution = 0.8
friction = 0.2

[[walls]]
plane = { point = ["0 m", "8 mm", "0 m"], normal = [0, -1, 0] }
restitution = 0.9
friction = 0.1

[contact]
restitution = 0.9
friction = 0.3

[hard.friction.walton]
tangential_restitution = 0.4

[run]
model = "dsmc"
duration = "40 ms"
average_from = "10 ms"
seed = 5
"#;

fn channel(sets: &[&str]) -> Experiment {
    case(CHANNEL, Model::Dsmc, sets).unwrap()
}

#[test]
fn the_ledger_closes_and_momentum_is_that_of_walls_and_gas() {
    let experiment = channel(&[]);
    let start = initial_state(&experiment).unwrap();
    let mut simulation = Simulation::new(&experiment, start);
    let energy = |s: &Simulation| s.particles.kinetic_energy() + s.particles.rotational_energy();
    let (before, momentum) = (energy(&simulation), simulation.particles.momentum());
    // at 35 ms a sphere comes to rest on a wall
    simulation.run(34, 1e-3).unwrap();
    let ledger = *simulation.record.ledger;
    assert!(simulation.record.pairs.count > 1000 && simulation.record.walls.count > 1000);
    for loss in [
        ledger.pair_restitution_loss,
        ledger.pair_friction_loss,
        ledger.wall_restitution_loss,
        ledger.wall_friction_loss,
    ] {
        assert!(loss > 0.0);
    }
    // rounding errors of some thousand impacts and windows
    let through = ledger.through(before);
    close("energy", ledger.residual(before, energy(&simulation)) / through, 0.0, 1e-12);
    let given = ledger.drag_impulse + ledger.gravity_impulse + ledger.wall_impulse;
    let off = simulation.particles.momentum() - momentum - given;
    close("momentum", off.norm() / given.norm(), 0.0, 1e-12);
    // pairs do not touch, so that no momentum is transferred from centre to centre
    assert_eq!(ledger.pair_virial.norm(), 0.0);
    assert_eq!(simulation.elastic_energy(), 0.0);
    let counters = simulation.counters();
    assert_eq!(counters.events, simulation.record.pairs.count + simulation.record.walls.count);
    assert!(counters.pair_checks > simulation.record.pairs.count);
}

#[test]
fn bits_do_not_depend_on_threads_order_or_restarts() {
    let experiment = channel(&[]);
    let start = initial_state(&experiment).unwrap();
    let run = |start: &Particles, threads: usize, stop: bool| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        pool.install(|| {
            let mut simulation = Simulation::new(&experiment, start.clone());
            simulation.run(7, 1e-3).unwrap();
            if stop {
                simulation = Simulation::restore(&experiment, simulation.snapshot().unwrap()).unwrap();
            }
            simulation.run(13, 1e-3).unwrap();
            (simulation.state().fingerprint(), simulation.record.clone(), simulation.counters())
        })
    };
    let alone = run(&start, 1, false);
    assert!(run(&start, 3, false) == alone, "threads");
    assert!(run(&start, 2, true) == alone, "restart");
    let mut order: Vec<u32> = (0..start.len() as u32).collect();
    order.shuffle(&mut Xoshiro256PlusPlus::seed_from_u64(1));
    let mut shuffled = start.clone();
    shuffled.reorder(&order);
    assert!(run(&shuffled, 3, true) == alone, "order");
    let other =
        Experiment { run: diptych::experiment::RunSettings { seed: 6, ..experiment.run.clone() }, ..experiment };
    let mut simulation = Simulation::new(&other, start);
    simulation.run(20, 1e-3).unwrap();
    assert!(simulation.state().fingerprint() != alone.0, "another seed draws other collisions");
}

#[test]
fn steps_are_a_share_of_the_mean_free_time() {
    let (scene, particles) = cube(2000, 0.05, 1.0, 3);
    let rate = rate_of(0.05, carnahan_starling(0.05));
    // the rate in a cell depends on the temperature in this cell, whose mean square root is 1 % below the root of the
    // mean. The numbers of steps are therefore 24 to 26, one, one for 4 windows, and one for up to 16 windows
    for (step, window, least, most) in [
        (0.2, 5.0, 24.0, 26.0),
        (0.05, 1.0, 19.0, 21.0),
        (0.2, 0.15, 1.0, 1.0),
        (0.2, 0.045, 0.25, 0.25),
        (0.2, 0.001, 0.0625, 0.0625),
    ] {
        let settings = DsmcSettings { step, ..DsmcSettings::default() };
        let mut simulation = Simulation::with_engine(scene.clone(), particles.clone(), engine(settings, 1));
        simulation.run(320, window / rate).unwrap();
        let per_window = simulation.counters().steps as f64 / 320.0;
        assert!((least..=most).contains(&per_window), "{step} {window}: {per_window}");
        // collisions follow the time of flight with a delay of up to half a step of up to 16 windows; four standard
        // errors of their number are added
        let collisions = simulation.record.pairs.count as f64;
        let want = 0.5 * 2000.0 * 320.0 * window * (1.0 - 1.0 / 2000.0);
        close("collisions", collisions / want, 1.0, 4.0 / want.sqrt() + 1e-3 + 0.5 * 16.0 / 320.0);
    }
}

#[test]
fn few_particles_and_equal_velocities() {
    let scene = empty([4.0, 5.0, 6.0], [true, false, true], unit(), surface(0.5, 0.1));
    let go = |list: &[([f64; 3], [f64; 3])]| {
        let particles = placed(&scene, list);
        let mut simulation = Simulation::with_engine(scene.clone(), particles, engine(DsmcSettings::default(), 1));
        simulation.run(50, 0.1).unwrap();
        simulation
    };
    assert_eq!(go(&[]).record.pairs.count, 0);
    let alone = go(&[([1.0, 2.0, 3.0], [2.0, 0.0, -2.0])]);
    close("x after 5 s", alone.particles.position[0].x, 3.0, 1e-12);
    close("z after 5 s", alone.particles.position[0].z, 5.0, 1e-12);
    assert_eq!(alone.record.pairs.count, 0);
    // at rest relative to each other, in one place or in several
    let together = go(&[([1.0, 2.0, 3.0], [1.0, 0.0, 0.0]); 5]);
    assert_eq!(together.record.pairs.count, 0);
    assert_eq!(together.particles.velocity, vec![Vector3::x(); 5]);
    // two spheres in one cell that approach and separate again and again, at first 0.2 times per second; each collision
    // loses energy
    let scene = empty([4.0, 5.0, 6.0], [true; 3], unit(), surface(0.5, 0.1));
    let particles = placed(&scene, &[([1.0, 2.0, 3.0], [4.0, 0.0, 0.0]), ([3.0, 2.0, 3.0], [-4.0, 0.0, 0.0])]);
    let pair = run(&scene, particles, engine(DsmcSettings::default(), 1), 100.0, 100);
    assert!(pair.record.pairs.count > 0 && pair.particles.kinetic_energy() < 16.0);
    close("momentum", pair.particles.momentum().norm(), 0.0, 1e-14);
}

#[test]
fn a_particle_that_comes_to_rest_is_named() {
    let mut scene = empty([0.1; 3], [true, false, true], small(), surface(1.0, 0.0));
    scene.gravity = Vector3::new(0.0, -9.81, 0.0);
    scene.walls = vec![plane([0.0; 3], [0.0, 1.0, 0.0], surface(0.5, 0.0))];
    let (height, radius) = (0.01, 0.5 * small().diameter);
    let particles = placed(&scene, &[([0.05, height + radius, 0.05], [0.0; 3])]);
    let (simulation, result) = try_run(&scene, particles, engine(DsmcSettings::default(), 1), 1.0, 100);
    // the time of rest (1 + e)/(1 - e) sqrt(2 h/g) is found at the end of the half-window that contains it
    let rest = 3.0 * (2.0 * height / 9.81).sqrt();
    let Err(why @ Failure::RestOnWall { time, particle: 0, .. }) = result else { panic!("{result:?}") };
    assert!((rest..rest + 0.0051).contains(&time), "{time}, {rest}");
    assert!(why.to_string().contains("use the hybrid or the soft model"), "{why}");
    assert!(simulation.record.walls.count > 20);
}

#[test]
fn bad_keys_are_named() {
    for (set, words) in [
        ("dsmc.step=0", "`dsmc.step` = 0 is out of range"),
        ("dsmc.step=1.5", "`dsmc.step` = 1.5 is out of range"),
        ("dsmc.cells=[1, 0, 1]", "`dsmc.cells[1]` = 0"),
        ("dsmc.cells=[1, 50, 1]", "makes cells narrower than the largest particle; allowed: 1 ..= 10"),
        ("dsmc.cells=[12, 10, 15]", "makes 1800 cells for 1000 particles; allowed: at most one cell for a particle"),
        ("dsmc.enskog=3", "dsmc.enskog"),
        ("dsmc.factor=true", "dsmc.factor"),
    ] {
        let why = case(CHANNEL, Model::Dsmc, &[set]).err().unwrap_or_else(|| panic!("{set} is taken"));
        assert!(why.contains(words), "{set}: {why}");
    }
    // another model does not use these keys, and only warns of a bad value
    assert!(case(CHANNEL, Model::Hard, &["dsmc.step=0"]).is_ok());
    let cells = channel(&["dsmc.cells=[2, 8, 3]", "dsmc.step=0.1", "dsmc.enskog=false"]).dsmc;
    assert_eq!(cells, DsmcSettings { enskog: false, cells: Some([2, 8, 3]), step: 0.1 });
}

/// Particles that collide by chance may overlap each other at the start, as in their saved states. Hard spheres must
/// not.
#[test]
fn a_start_may_overlap_pairs_but_not_walls() {
    let at = |y: &str| {
        CHANNEL.replace("count = 100\n", &format!("at = [{{ position = [\"5 mm\", \"{y}\", \"5 mm\"] }}, {{ position = [\"5 mm\", \"4.1 mm\", \"5 mm\"] }}]\n"))
    };
    assert!(case(&at("4 mm"), Model::Dsmc, &[]).is_ok());
    assert!(case(&at("4 mm"), Model::Hard, &[]).unwrap_err().contains("overlap"));
    assert!(case(&at("0.3 mm"), Model::Dsmc, &[]).unwrap_err().contains("from walls[0]"));
}

/// A gas without collisions around a ball in a periodic box. A particle flies over hundreds of boxes in the longest
/// window (piece of the run). It meets the images of the ball as often as in short windows; four standard errors of
/// both counts are allowed.
#[test]
fn images_of_a_body_are_met_in_windows_of_any_length() {
    const BALL: &str = r#"
        domain = { size = ["10 mm", "10 mm", "10 mm"], periodic = ["x", "y", "z"] }
        contact = { restitution = 1, friction = 0 }
        run = { model = "dsmc", duration = "4 s", average_from = "0 s" }
        [[particles]]
        name = "p"
        diameter = "0.01 mm"
        density = "1000 kg/m^3"
        count = 50
        velocity_fluctuation = "0.5 m/s"
        [[walls]]
        sphere = { center = ["5 mm", "5 mm", "5 mm"], radius = "3 mm" }
        restitution = 1
        friction = 0
    "#;
    let experiment = case(BALL, Model::Dsmc, &[]).unwrap();
    let impacts = |windows: u64| {
        let mut simulation = Simulation::new(&experiment, initial_state(&experiment).unwrap());
        simulation.run(windows, 4.0 / windows as f64).unwrap();
        simulation.record.walls.count as f64
    };
    let (short, long) = (impacts(1000), impacts(8));
    println!("{short} {long}");
    close("impacts in long windows", long / short, 1.0, 4.0 * (2.0 / short).sqrt());
}

/// The cells that the program chooses for a sheared ring of particles are so thick that the mean flow varies in a cell
/// by more than the agitation. A note says so; with thinner cells there is no note.
#[test]
fn cells_too_thick_for_the_shear_are_told() {
    let folder = tempfile::tempdir().unwrap();
    let out = folder.path().join("out");
    for (set, is_told) in [("dsmc.step=0.2", true), ("dsmc.cells=[1, 40, 1]", false)] {
        let run = ["run", "cases/shear/planetary-ring.toml", "--model", "dsmc", "--overwrite", "--set", set];
        let short = ["--set", "run.duration=95608 s", "--set", "run.average_from=0 s", "--out"];
        let output = diptych(&[&run[..], &short].concat()).arg(&out).output().unwrap();
        assert!(output.status.success(), "{}", words(&output.stderr));
        let summary = std::fs::read_to_string(out.join("summary.json")).unwrap();
        assert_eq!(summary.contains("its cells are 10.0 m thick across the shear, and √T/γ is"), is_told, "{set}");
    }
}
