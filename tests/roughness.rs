//! Rough walls: inclinations of the facets against an independent quadrature of their density, energy, bits, messages.

use crate::support::*;
use diptych::engine::Engine;
use diptych::engine::distributed::Distributed;
use diptych::engine::dsmc::Dsmc;
use diptych::engine::hard::Hard;
use diptych::experiment::{DsmcSettings, HardStepping, Model, Spheres};
use diptych::particles::Particles;
use diptych::placement::initial_state;
use diptych::scene::{Scene, Surface};
use diptych::simulation::{Simulation, Snapshot};
use diptych::walls::WallRoughness;
use nalgebra::Vector3;

/// Spheres that fly onto a floor at the angle `angle` [rad] to it along x, far from each other.
const COUNT: usize = 20_000;

fn rough(deviation: f64) -> Option<WallRoughness> {
    Some(WallRoughness { deviation, seed: 11 })
}

/// The spheres, at a place from which they touch the floor after 1 µm of fall.
fn rain(deviation: f64, surface: Surface, angle: f64) -> (Scene, Particles) {
    let mut scene = empty([0.2, 0.2, 0.2], [true, false, true], small(), surface);
    scene.walls = vec![plane([0.0; 3], [0.0, 1.0, 0.0], surface)];
    scene.walls[0].roughness = rough(deviation);
    let side = (COUNT as f64).sqrt().ceil() as usize;
    let velocity = [angle.cos(), -angle.sin(), 0.0];
    let place = |k: usize| (k as f64 + 0.5) * 0.2 / side as f64;
    let all: Vec<_> = (0..COUNT).map(|k| ([place(k % side), 203e-6 + 1e-6, place(k / side)], velocity)).collect();
    let start = placed(&scene, &all);
    (scene, start)
}

/// Tilts (along the flight, across it) [rad] of the facets that impacts met, from the change of velocity, which is along
/// the normal of the facet where there is no friction.
fn tilts(scene: &Scene, start: &Particles, engine: Box<dyn Engine>, angle: f64) -> Vec<[f64; 2]> {
    // so long that every sphere has touched, and none comes back
    let end = run(scene, start.clone(), engine, 2.2e-6 / angle.sin(), 1);
    assert!(end.particles.velocity.iter().all(|v| v.y > 0.0), "a sphere moves into the wall");
    let tilt = |(v, u): (&Vector3<f64>, &Vector3<f64>)| {
        let facet = (v - u).normalize();
        let sine = facet.x.hypot(facet.z);
        let tilt = sine.atan2(facet.y);
        [facet.x, facet.z].map(|along| if sine > 0.0 { tilt * along / sine } else { 0.0 })
    };
    end.particles.velocity.iter().zip(&start.velocity).map(tilt).collect()
}

/// Moments <γ_1>, <γ_1²>, <γ_2²> and <γ_1⁴> of the tilts by a midpoint rule over both, whose weight is the Gaussian times
/// the share that the facet shows, where the rebound leaves the wall.
fn quadrature(deviation: f64, e: f64, angle: f64) -> [f64; 4] {
    const CELLS: i32 = 400;
    let reach = 6.0 * deviation;
    let cell = |k: i32| reach * ((f64::from(k) + 0.5) / f64::from(CELLS) * 2.0 - 1.0);
    let (mut whole, mut sums) = (0.0, [0.0; 4]);
    for i in 0..CELLS {
        for j in 0..CELLS {
            let (a, b) = (cell(i), cell(j));
            let tilt = f64::hypot(a, b);
            let normal = [tilt.sin() * a / tilt, tilt.cos(), tilt.sin() * b / tilt];
            let flight = [angle.cos(), -angle.sin(), 0.0];
            let shown = -(flight[0] * normal[0] + flight[1] * normal[1]);
            let up = flight[1] + (1.0 + e) * shown * normal[1];
            if shown > 0.0 && up > 0.0 {
                let weight = shown * (-0.5 * (tilt / deviation).powi(2)).exp();
                whole += weight;
                let values = [a, a * a, b * b, a.powi(4)];
                sums.iter_mut().zip(values).for_each(|(sum, value)| *sum += weight * value);
            }
        }
    }
    sums.map(|sum| sum / whole)
}

/// Means over 20,000 independent facets lie within five standard errors of the quadrature, which errs by less. At grazing
/// angles facets lean towards the flight, so that spheres rebound more steeply than they come.
#[test]
fn facets_have_the_density_of_sommerfeld_and_huber() {
    for deviation in [0.05, 0.3] {
        for degrees in [3.0_f64, 20.0, 90.0] {
            for e in [1.0, 0.6] {
                let angle = degrees.to_radians();
                let expected = quadrature(deviation, e, angle);
                let (scene, start) = rain(deviation, surface(e, 0.0), angle);
                let dsmc = Dsmc::new(DsmcSettings::default(), 3);
                for (name, engine) in
                    [("hard", hard()), ("islands", islands()), ("stepped", stepped(0.01)), ("dsmc", Box::new(dsmc))]
                {
                    let found = tilts(&scene, &start, engine, angle);
                    let values = |k: usize| {
                        found.iter().map(move |[a, b]| [*a, a * a, b * b, a.powi(4)][k]).collect::<Vec<f64>>()
                    };
                    for (k, expected) in expected.iter().enumerate() {
                        let all = values(k);
                        let mean = all.iter().sum::<f64>() / COUNT as f64;
                        let square = all.iter().map(|x| (x - mean).powi(2)).sum::<f64>() / COUNT as f64;
                        let error = (square / COUNT as f64).sqrt();
                        close(
                            &format!("{name} Δγ={deviation} {degrees} e={e} moment {k}"),
                            mean,
                            *expected,
                            5.0 * error,
                        );
                    }
                    let steeper = found.iter().map(|[a, _]| -a).sum::<f64>() / COUNT as f64;
                    assert!(degrees > 45.0 || steeper > 0.01 * deviation, "{name} {degrees}: {steeper}");
                }
            }
        }
    }
}

/// A gas between a rough floor and a rough lid.
fn gas(count: usize, of: Surface, deviation: f64) -> (Scene, Particles) {
    let size = edge(count, small().diameter, 0.03);
    let mut scene = empty([size; 3], [true, false, true], small(), of);
    scene.walls = vec![plane([0.0; 3], [0.0, 1.0, 0.0], of), plane([0.0, size, 0.0], [0.0, -1.0, 0.0], of)];
    scene.walls.iter_mut().for_each(|wall| wall.roughness = rough(deviation));
    scene.gravity = Vector3::new(0.0, -9.81, 1.0);
    let start = random(&scene, count, 0.5, 3);
    (scene, start)
}

/// A facet is at rest: an elastic impact keeps the energy to rounding, and every ledger closes.
#[test]
fn facets_do_no_work() {
    for (e, friction) in [(1.0, 0.0), (0.9, 0.0), (0.9, 0.3)] {
        for stepping in ["events", "steps", "chance"] {
            let (mut scene, start) = gas(400, surface(e, friction), 0.2);
            if e == 1.0 {
                scene.gravity = Vector3::zeros();
            }
            let before = start.kinetic_energy();
            let engine: Box<dyn Engine> = match stepping {
                "events" => hard(),
                "steps" => stepped(0.02),
                _ => Box::new(Dsmc::new(DsmcSettings::default(), 3)),
            };
            let end = run(&scene, start, engine, 5e-3, 10);
            assert!(end.record.walls.count > 50, "{}", end.record.walls.count);
            let residual = end.record.ledger.residual(before, end.energy());
            // rounding of some thousand impacts
            close(&format!("{stepping} {e} {friction}"), residual, 0.0, 1e-11 * before);
            if e == 1.0 {
                close("energy", end.energy(), before, 1e-11 * before);
            }
        }
    }
}

/// The impulse of a wall along its smooth normal is what counts as pressure; along the wall the facets take no mean momentum
/// at normal incidence.
#[test]
fn the_pressure_is_that_along_the_smooth_normal() {
    let (scene, start) = rain(0.1, surface(1.0, 0.0), 90f64.to_radians());
    let end = run(&scene, start.clone(), hard(), 3e-6, 1);
    let gained: f64 = end.particles.velocity.iter().zip(&start.velocity).map(|(v, u)| (v - u).y * start.mass[0]).sum();
    close("normal", end.record.ledger.wall_normal_impulse, gained, 1e-12 * gained);
    close("whole", end.record.ledger.wall_impulse.y, gained, 1e-12 * gained);
}

#[test]
fn the_same_bits_on_any_number_of_threads_and_processes_and_after_a_snapshot() {
    let of = gas(1500, surface(0.9, 0.2), 0.15);
    let islands = || Box::new(Hard::with_islands()) as Box<dyn Distributed>;
    let queue = || Box::new(Hard::new()) as Box<dyn Distributed>;
    let engines: [&(dyn Fn() -> Box<dyn Distributed> + Sync); 2] = [&islands, &queue];
    for engine in engines {
        let on = |size| shared(size, &of, engine, (2e-3, 10), |end| (end.fingerprint(), end.record.ledger.to_array()));
        let alone = on(1);
        for size in [2, 3] {
            assert_eq!(on(size), alone, "{size}");
        }
        let pool = |threads| rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        for threads in [1, 3] {
            assert_eq!(pool(threads).install(|| on(1)), alone, "{threads} threads");
        }
    }
    let ways = [
        (Spheres::Hard, HardStepping::Events),
        (Spheres::Hard, HardStepping::Steps { theta: 0.05 }),
        (Spheres::Dsmc, HardStepping::Events),
    ];
    for (spheres, stepping) in ways {
        let mut way = experiment(gas(300, surface(0.9, 0.2), 0.15).0, 300, [0.0; 3], 0.5, Model::Hard, 3);
        (way.run.spheres, way.hard.stepping) = (spheres, stepping);
        let mut straight = Simulation::new(&way, initial_state(&way).unwrap());
        straight.run(5, 2e-4).unwrap();
        let half = diptych::Stored::of(&straight.snapshot().unwrap()).unwrap();
        straight.run(10, 2e-4).unwrap();
        let mut resumed = Simulation::restore(&way, half.read::<Snapshot>().unwrap()).unwrap();
        resumed.run(10, 2e-4).unwrap();
        assert_eq!(resumed.fingerprint(), straight.fingerprint(), "{spheres:?}");
        // another seed has other facets, from the same start
        way.run.seed += 1;
        let start = resumed.particles.clone();
        let [one, other] = [3, 4].map(|seed| {
            way.run.seed = seed;
            let mut run = Simulation::new(&way, start.clone());
            run.run(10, 2e-4).unwrap();
            run.fingerprint()
        });
        assert!(spheres == Spheres::Dsmc || one != other, "{spheres:?}");
    }
}

/// Case of twenty beads between two planes, the lower one of which is rough.
const CASE: &str = r#"
[domain]
size = ["20 mm", "20 mm", "20 mm"]
periodic = ["x", "z"]
[[particles]]
name = "bead"
diameter = "1 mm"
density = "1000 kg/m^3"
count = 20
velocity_fluctuation = "0.4 m/s"
[[walls]]
plane = { point = ["0 m", "0 m", "0 m"], normal = [0, 1, 0] }
restitution = 0.9
roughness = { deviation = "5 deg" }
[[walls]]
plane = { point = ["0 m", "20 mm", "0 m"], normal = [0, -1, 0] }
restitution = 0.9
[contact]
restitution = 0.9
[soft.linear_spring_dashpot]
stiffness = "1000 N/m"
[run]
duration = "0.1 s"
"#;

#[test]
fn a_case_tells_what_rough_walls_need() {
    let of = case(CASE, Model::Hard, &[]).unwrap();
    let roughness = of.scene.walls[0].roughness.unwrap();
    close("deviation", roughness.deviation, 5f64.to_radians(), 1e-15);
    assert!(of.scene.walls[1].roughness.is_none());
    assert!(case(CASE, Model::Dsmc, &[]).is_ok());
    for (model, set, says) in [
        (Model::Soft, "run.seed=1", "`walls[0].roughness` is for impacts without duration"),
        (Model::Hybrid, "run.seed=1", "use the hard or the dsmc model"),
        (Model::Hard, "walls[0].velocity=[\"1 m/s\", 0, 0]", "needs a surface that does not move"),
        (Model::Hard, "walls[0].restitution=0", "needs a rebound"),
        (Model::Hard, "walls[0].roughness.deviation=40 deg", "allowed: 0 ..= 0.6"),
        (Model::Hard, "walls[1].roughness={}", "walls[1].roughness.deviation"),
    ] {
        let why = case(CASE, model, &[set]).expect_err(set);
        assert!(why.contains(says), "{set}: {why}");
    }
    // without inclination the wall is smooth, in every model and to the last bit
    let smooth = case(CASE, Model::Soft, &["walls[0].roughness.deviation=0"]).unwrap();
    assert!(smooth.scene.walls[0].roughness.is_none());
}
