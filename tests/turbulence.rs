//! Turbulence along the paths of particles: tracers stay mixed; response and dispersion in homogeneous turbulence after
//! Tchen, Hinze and Csanady; frozen gas as a limit; ledger, equal bits, messages.

use crate::support::{case, close, empty, experiment, hard, plane, random, shared, soft, surface};
use diptych::drag::{Drag, SchillerNaumann, Stokes};
use diptych::engine::distributed::Distributed;
use diptych::engine::hard::Hard;
use diptych::engine::soft::Soft;
use diptych::experiment::{Integrator, Model, SoftStepping};
use diptych::fluid::{EddyLaw, Fluid, Langevin, Profile, Turbulence, TurbulenceModel, TurbulenceStatistics};
use diptych::particles::Particles;
use diptych::placement::initial_state;
use diptych::scene::{Scene, Species};
use diptych::simulation::Simulation;
use diptych::{ContactLaw, Engine};
use nalgebra::Vector3;

/// [s] response time of the particles of `homogeneous`, divided by their density in kg/m³.
const RESPONSE_PER_DENSITY: f64 = 1e-6 / (18.0 * 1.5e-5);

/// Homogeneous turbulence with fluctuations of σ = 1 m/s and the Lagrangian integral time T_L = 1 s in a gas at rest.
/// The particles have the response time `response` [s], and are too few to collide. `beta` is T_L over the integral
/// time at a fixed point. `gravity` [m/s²] acts along -z.
pub fn homogeneous(response: f64, beta: f64, gravity: f64) -> Scene {
    let species = Species::new("bead", 1e-3, response / RESPONSE_PER_DENSITY);
    let mut scene = empty([1000.0; 3], [true; 3], species, surface(1.0, 0.0));
    scene.gravity = Vector3::new(0.0, 0.0, -gravity);
    let (law, langevin) = (EddyLaw::Langevin, Langevin { time_scale_ratio: beta, ..Langevin::default() });
    // T_L = (k/ε)/(1/2 + 3/4 C_0) with k = 3/2 σ²
    let statistics = TurbulenceStatistics::uniform(1.5, 1.5 / (0.5 + 0.75 * 2.1), 1.5e-5);
    let fluid = Fluid::new(1.0, 1.5e-5, Profile::Uniform(0.0), Some(Drag::Stokes(Stokes)));
    scene.fluid = Some(Fluid { turbulence: Some(Turbulence { statistics, law, langevin }), ..fluid });
    scene
}

/// Runs `count` particles with random initial velocities of the standard deviation `agitation` [m/s], for `windows`
/// windows (times between two exchanges with the gas) of `window` [s].
fn run_homogeneous(scene: &Scene, count: usize, agitation: f64, windows: u64, window: f64) -> Simulation {
    let start = experiment(scene.clone(), count, [0.0; 3], agitation, Model::Hard, 3);
    let mut simulation = Simulation::new(&start, initial_state(&start).unwrap());
    simulation.run(windows, window).unwrap();
    simulation.end();
    simulation
}

/// Mean over all particles and components of the product of two vectors.
fn mean_product(a: &[Vector3<f64>], b: &[Vector3<f64>]) -> f64 {
    a.iter().zip(b).map(|(a, b)| a.dot(b)).sum::<f64>() / (3.0 * a.len() as f64)
}

/// Tchen 1947: the gas velocity u that a particle sees has the correlation exp(-t/T) and the variance σ². Then <v²> =
/// <u v> = σ² T/(T + τ), with velocity v and response time τ of the particle. Estimates from 3 N independent Gaussian
/// numbers have standard errors of at most sqrt(2/(3 N)), relative to the product of the deviations; four of them are
/// allowed. Windows of 2 T are accurate enough for heavy particles, because kicks use the mean of the fluctuation over
/// the window. This mean scatters for given values at both ends. Without the scatter, the variance at τ = 20 T would
/// be too small by a quarter.
#[test]
fn particles_take_the_share_of_tchen_of_the_agitation_of_the_gas() {
    let count = 6000;
    for (stokes, window, windows) in
        [(0.1, 0.02, 150), (1.0, 0.05, 100), (10.0, 0.5, 80), (20.0, 2.0, 40), (1000.0, 1.0, 100)]
    {
        let share: f64 = 1.0 / (1.0 + stokes);
        // at St = 1000 the run is too short to reach the final agitation, so that the start has it
        let end = run_homogeneous(&homogeneous(stokes, 0.0, 0.0), count, share.sqrt(), windows, window).state();
        let eddies = end.eddies.as_ref().unwrap();
        let error = (2.0 / (3.0 * count as f64)).sqrt();
        let [uu, vv, uv] = [
            mean_product(eddies, eddies),
            mean_product(&end.velocity, &end.velocity),
            mean_product(eddies, &end.velocity),
        ];
        println!("St {stokes}: <u²> {uu:.4}, <v²> {vv:.5}, <u v> {uv:.5}, Tchen {share:.5}");
        close("variance of the gas seen", uu, 1.0, 4.0 * error);
        close("agitation", vv, share, 4.0 * error * share);
        if stokes < 1000.0 {
            close("covariance", uv, share, 4.0 * error * share.sqrt());
        }
    }
}

/// [m²] mean square displacement of particles in a time `t` [s] in steady homogeneous turbulence with σ = 1 m/s. The
/// gas velocity has the correlation exp(-t/T) with T = `time`, and the particles have the response time τ = `tau`. By
/// Hinze 1975, section 5.7, it is twice the integral of (t - s) R(s), with R(s) = (T² exp(-s/T) - T τ exp(-s/τ))/(T² -
/// τ²).
fn dispersion(t: f64, time: f64, tau: f64) -> f64 {
    let part = |theta: f64| theta * t - theta * theta * (1.0 - (-t / theta).exp());
    2.0 * (time * time * part(time) - time * tau * part(tau)) / (time * time - tau * tau)
}

/// Mean square displacements [m²] along x, y and z about the mean displacement, between two states in the order of ids.
fn displacements(scene: &Scene, before: &Particles, after: &Particles) -> Vector3<f64> {
    let count = before.len() as f64;
    let moves: Vec<_> =
        before.position.iter().zip(&after.position).map(|(a, b)| scene.domain.separation(b, a)).collect();
    let mean = moves.iter().sum::<Vector3<f64>>() / count;
    moves.iter().map(|x| (x - mean).component_mul(&(x - mean))).sum::<Vector3<f64>>() / count
}

/// Runs until the motion is steady, for `steady` [s], then for `time` [s]. Returns the mean square displacements along
/// x, y and z [m²] in this last time.
fn spread(scene: &Scene, agitation: f64, [steady, time]: [f64; 2], window: f64) -> Vector3<f64> {
    let start = experiment(scene.clone(), 6000, [0.0; 3], agitation, Model::Hard, 4);
    let mut simulation = Simulation::new(&start, initial_state(&start).unwrap());
    simulation.run((steady / window).round() as u64, window).unwrap();
    let before = simulation.state();
    simulation.run((time / window).round() as u64, window).unwrap();
    displacements(scene, &before, &simulation.state())
}

/// Particles of any inertia spread as in theory, for times shorter and longer than the integral time of the gas. The
/// mean square of N Gaussian numbers has the relative standard error sqrt(2/N) per component. Four standard errors of
/// the mean of three components are allowed.
#[test]
fn particles_spread_as_in_homogeneous_turbulence() {
    let error = (2.0_f64 / 18_000.0).sqrt();
    for (stokes, time) in [(0.2, 1.0), (0.2, 6.0), (2.0, 6.0)] {
        let share: f64 = 1.0 / (1.0 + stokes);
        let found = spread(&homogeneous(stokes, 0.0, 0.0), share.sqrt(), [5.0, time], 0.05).mean();
        let wanted = dispersion(time, 1.0, stokes);
        println!("St {stokes}, {time} T: {found:.4} m², theory {wanted:.4} m²");
        close(&format!("St {stokes}, {time} T"), found, wanted, 4.0 * error * wanted);
    }
}

/// Csanady 1963: a fall with the slip w shortens the integral time T of the gas. It becomes T/sqrt(1 + β² w²/σ²) along
/// the fall, and T/sqrt(1 + 4 β² w²/σ²) across it (deviation σ of the gas velocity, ratio β of integral times).
/// Agitation and dispersion fall accordingly. Here w = 8 σ and β = 1. Besides the statistical error, the slip varies
/// between particles, with a variance of at most σ² St/(1 + St)² per component (Stokes number St). This changes the
/// mean of w² by at most 3/4 in 64, and the integral times by 0.6 %.
#[test]
fn falling_particles_cross_eddies_as_csanady_says() {
    let (tau, fall) = (0.25, 8.0);
    let scene = homogeneous(tau, 1.0, fall / tau);
    let [along, across] = [(1.0_f64 + 64.0).sqrt().recip(), (1.0_f64 + 256.0).sqrt().recip()];
    let time = 4.0;
    let found = spread(&scene, 0.4, [2.0, time], 0.01);
    for (axis, eddy) in [across, across, along].into_iter().enumerate() {
        let wanted = dispersion(time, eddy, tau);
        println!("axis {axis}: {:.5} m², Csanady {wanted:.5} m²", found[axis]);
        close("spread", found[axis], wanted, (4.0 * (2.0_f64 / 6000.0).sqrt() + 0.006) * wanted);
    }
    let end = run_homogeneous(&scene, 6000, 0.4, 400, 0.01).state();
    let mean = end.velocity.iter().sum::<Vector3<f64>>() / end.len() as f64;
    close("fall", -mean.z, fall, 4.0 * (2.0 * along / 6000.0_f64).sqrt());
    let eddies = end.eddies.as_ref().unwrap();
    for (axis, eddy) in [across, across, along].into_iter().enumerate() {
        let variance =
            |of: &[Vector3<f64>], mean: f64| of.iter().map(|v| (v[axis] - mean).powi(2)).sum::<f64>() / of.len() as f64;
        let wanted = eddy / (eddy + tau);
        let error = 4.0 * (2.0_f64 / 6000.0).sqrt();
        close("agitation", variance(&end.velocity, mean[axis]), wanted, (error + 0.006) * wanted);
        close("gas seen", variance(eddies, 0.0), 1.0, error);
    }
}

/// Without a mean slip, particles cross eddies by their own agitation. The gas velocity along their paths keeps its
/// variance, although the time scales depend on the state of each particle.
#[test]
fn crossing_by_agitation_keeps_the_variance_of_the_gas() {
    for stokes in [0.3, 1.0, 5.0] {
        let end = run_homogeneous(&homogeneous(stokes, 1.0, 0.0), 6000, 0.7, 200, 0.1).state();
        let eddies = end.eddies.as_ref().unwrap();
        let found = mean_product(eddies, eddies);
        let agitation = mean_product(&end.velocity, &end.velocity);
        println!("St {stokes}: {found:.4}, <v²> {agitation:.4}, Tchen {:.4}", 1.0 / (1.0 + stokes));
        close("variance of the gas seen", found, 1.0, 4.0 * (2.0_f64 / 18_000.0).sqrt());
    }
}

/// Channel of the paper with a gas from a k-ε model, two walls, and tracers of 1 µm with the response time 3 µs.
fn channel(model: TurbulenceModel) -> Scene {
    let (height, nu) = (0.04, 1.515e-5);
    let species = Species::new("tracer", 1e-6, 1000.0);
    let mut scene = empty([0.1, height, 0.1], [true, false, true], species, surface(1.0, 0.0));
    scene.walls = vec![
        plane([0.0; 3], [0.0, 1.0, 0.0], surface(1.0, 0.0)),
        plane([0.0, height, 0.0], [0.0, -1.0, 0.0], surface(1.0, 0.0)),
    ];
    let profile = Profile::k_epsilon_channel(42000.0 * nu / height, height, nu, model).unwrap();
    let statistics = TurbulenceStatistics::of(profile.channel_flow().unwrap()).unwrap();
    let fluid = Fluid::new(1.205, nu, profile, Some(Drag::Stokes(Stokes)));
    scene.fluid = Some(Fluid {
        turbulence: Some(Turbulence { statistics, law: EddyLaw::Langevin, langevin: Langevin::default() }),
        ..fluid
    });
    scene
}

/// Numbers of particles in ten slices of equal thickness between the walls, summed over several states and divided by
/// their mean.
fn slices(states: &[Particles], height: f64) -> [f64; 10] {
    let mut counts = [0.0; 10];
    for y in states.iter().flat_map(|state| &state.position).map(|x| x.y) {
        counts[((10.0 * y / height) as usize).min(9)] += 1.0;
    }
    let all: f64 = counts.iter().sum();
    counts.map(|count| 10.0 * count / all)
}

/// Thomson's condition: uniformly mixed tracers stay mixed, although the turbulent energy k varies across the channel.
/// It varies by a factor of three with wall functions, and falls to zero at the walls with the model of Launder and
/// Sharma. Without the drift term, tracers would gather where the gas is calm, in proportion to 1/σ = sqrt(3/(2k)).
/// States 20 ms apart, two mixing times L²/(π² D), are independent. The numbers from M states of N tracers have
/// relative standard errors of sqrt(10/(N M)). Four of them are allowed, and 1 % more, because the Stokes number is up
/// to 0.02 near the walls. Windows are up to a fifth of the integral time, which changes squares by a twelfth of the
/// square of this ratio.
#[test]
fn tracers_stay_mixed_in_a_channel() {
    let (count, parts) = (2000, 12);
    for model in [TurbulenceModel::WallFunctions, TurbulenceModel::LaunderSharma] {
        let scene = channel(model);
        let start = experiment(scene.clone(), count, [0.0, 0.0, 10.0], 0.0, Model::Hard, 5);
        let mut simulation = Simulation::new(&start, initial_state(&start).unwrap());
        let mut states = Vec::new();
        for _ in 0..parts {
            simulation.run(200, 1e-4).unwrap();
            states.push(simulation.state());
        }
        let found = slices(&states[2..], scene.domain.size.y);
        println!("{model:?}: {found:.3?}");
        let error = (10.0 / (count as f64 * (parts - 2) as f64)).sqrt();
        for number in found {
            close("tracers in a slice", number, 1.0, 4.0 * error + 0.01);
        }
    }
}

/// The scene with a discrete random walk (eddies of random lifetime) in place of the Langevin equation for the gas
/// velocity that particles see.
fn walking(mut scene: Scene) -> Scene {
    scene.fluid.as_mut().unwrap().turbulence.as_mut().unwrap().law = EddyLaw::Eddy;
    scene
}

/// In homogeneous turbulence, eddies of exponentially distributed lifetimes give the correlation exp(-t/T). So
/// agitation and dispersion are those of Tchen and Hinze, as by the Langevin equation. The means of fluctuations are
/// not Gaussian: the kurtosis of a mean of exponential pieces is 6 at most, which doubles the variance of its square.
#[test]
fn eddies_of_random_lifetime_give_the_agitation_and_dispersion_of_theory() {
    let error = (4.0_f64 / 18_000.0).sqrt();
    for (stokes, window) in [(0.2, 0.05), (1.0, 0.05), (10.0, 0.5), (20.0, 2.0)] {
        let share: f64 = 1.0 / (1.0 + stokes);
        let scene = walking(homogeneous(stokes, 0.0, 0.0));
        let end = run_homogeneous(&scene, 6000, share.sqrt(), 100, window).state();
        let eddies = end.eddies.as_ref().unwrap();
        close("variance of the gas seen", mean_product(eddies, eddies), 1.0, 4.0 * error);
        close("agitation", mean_product(&end.velocity, &end.velocity), share, 4.0 * error * share);
        close("covariance", mean_product(eddies, &end.velocity), share, 4.0 * error * share.sqrt());
    }
    for (stokes, time) in [(0.2, 1.0), (2.0, 6.0)] {
        let scene = walking(homogeneous(stokes, 0.0, 0.0));
        let found = spread(&scene, (1.0_f64 / (1.0 + stokes)).sqrt(), [5.0, time], 0.05).mean();
        let wanted = dispersion(time, 1.0, stokes);
        close(&format!("St {stokes}, {time} T"), found, wanted, 4.0 * error * wanted);
    }
}

/// The discrete random walk has no drift term: tracers leave the strongest turbulence and gather next to the walls,
/// where it is weak (MacInnes and Bracco 1992, Phys. Fluids A 4, 2809). The Langevin equation keeps the same tracers
/// mixed (`tracers_stay_mixed_in_a_channel`).
#[test]
fn a_discrete_random_walk_gathers_tracers_where_the_turbulence_is_weak() {
    let scene = walking(channel(TurbulenceModel::LaunderSharma));
    let start = experiment(scene.clone(), 2000, [0.0, 0.0, 10.0], 0.0, Model::Hard, 5);
    let mut simulation = Simulation::new(&start, initial_state(&start).unwrap());
    let mut states = Vec::new();
    for _ in 0..8 {
        simulation.run(200, 1e-4).unwrap();
        states.push(simulation.state());
    }
    let found = slices(&states[2..], scene.domain.size.y);
    println!("{found:.3?}");
    // five standard errors of the number in a slice, sqrt(10/(N M)), are 0.14
    assert!(found[0] > 1.3 && found[9] > 1.3 && found[1] < 0.8 && found[8] < 0.8, "{found:.3?}");
}

/// In a gas without fluctuations, drag with turbulence has the bits of drag in a gas without turbulence.
#[test]
fn a_calm_gas_is_the_frozen_gas() {
    let mut scene = homogeneous(0.5, 1.0, 9.81);
    scene.fluid.as_mut().unwrap().drag = Some(Drag::SchillerNaumann(SchillerNaumann));
    scene.fluid.as_mut().unwrap().turbulence.as_mut().unwrap().statistics = TurbulenceStatistics::Uniform(0.0, 1.0);
    let mut frozen = scene.clone();
    frozen.fluid.as_mut().unwrap().turbulence = None;
    let [calm, frozen] = [scene, frozen].map(|scene| run_homogeneous(&scene, 2000, 0.5, 30, 0.01));
    assert_eq!(calm.state().fingerprint(), frozen.state().fingerprint());
    assert_eq!(calm.record.ledger.to_array(), frozen.record.ledger.to_array());
}

/// Gas of particles in turbulence between walls, dense enough for collisions.
fn crowd() -> (Scene, Particles) {
    let mut scene = channel(TurbulenceModel::WallFunctions);
    scene.species[0] = crate::support::small();
    scene.domain.size = Vector3::new(0.02, 0.04, 0.02);
    scene.gravity = Vector3::new(0.0, 0.0, -9.81);
    let mut start = random(&scene, 3000, 0.5, 6);
    start.velocity.iter_mut().for_each(|v| v.z += 12.0);
    (scene, start)
}

#[test]
fn eddies_give_the_same_bits_on_any_number_of_threads_and_processes() {
    let (scene, start) = crowd();
    for scene in [scene.clone(), walking(scene)] {
        same_bits(&(scene, start.clone()));
    }
}

fn same_bits(of: &(Scene, Particles)) {
    let local = || {
        Box::new(Soft::new(ContactLaw::linear(3000.0), Integrator::VelocityVerlet, 3e-7, SoftStepping::Local))
            as Box<dyn Distributed>
    };
    let uniform = || {
        Box::new(Soft::new(ContactLaw::linear(3000.0), Integrator::VelocityVerlet, 3e-7, SoftStepping::Uniform))
            as Box<dyn Distributed>
    };
    let islands = || Box::new(Hard::with_islands()) as Box<dyn Distributed>;
    let ways: [&(dyn Fn() -> Box<dyn Distributed> + Sync); 3] = [&local, &uniform, &islands];
    for engine in ways {
        let on = |size| shared(size, of, engine, (2e-3, 8), |end| (end.fingerprint(), end.record.ledger.to_array()));
        let alone = on(1);
        for size in [2, 3] {
            assert_eq!(on(size), alone, "{size} processes");
        }
        for threads in [1, 3] {
            let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
            assert_eq!(pool.install(|| on(1)), alone, "{threads} threads");
        }
    }
}

/// Every engine draws the same random numbers for the turbulence. Without collisions, the paths are equal except for
/// rounding of sums.
#[test]
fn every_engine_sees_the_same_eddies() {
    let scene = homogeneous(0.3, 0.7, 0.0);
    let start = random(&scene, 300, 1.0, 8);
    let on = |engine: Box<dyn Engine>| {
        let mut simulation = Simulation::with_engine(scene.clone(), start.clone(), engine).with_seed(4);
        simulation.run(50, 0.02).unwrap();
        simulation.state()
    };
    let [one, other] = [on(hard()), on(soft(3000.0, 1e-3, Integrator::VelocityVerlet))];
    assert_eq!(one.eddies.is_some(), other.eddies.is_some());
    for (a, b) in one.velocity.iter().zip(&other.velocity) {
        // twenty steps of soft spheres per window have one rounding each
        assert!((a - b).norm() < 1e-12, "{a} {b}");
    }
    // another seed gives other random numbers
    let mut simulation = Simulation::with_engine(scene.clone(), start.clone(), hard()).with_seed(5);
    simulation.run(50, 0.02).unwrap();
    assert!((simulation.state().velocity[0] - one.velocity[0]).norm() > 1e-3);
}

/// The fluctuations that particles see do not change by a call of an observer, by completing the velocities at an end,
/// or by reversing the order of the store. A stored and restored run continues with the same bits.
#[test]
fn eddies_last() {
    let (scene, start) = crowd();
    for scene in [scene.clone(), walking(scene)] {
        last(&scene, &start);
    }
}

fn last(scene: &Scene, start: &Particles) {
    let order: Vec<u32> = (0..start.len() as u32).rev().collect();
    let mut turned = Particles::default();
    turned.copy_from(start, &order);
    let run = |particles: &Particles| Simulation::with_engine(scene.clone(), particles.clone(), hard()).with_seed(2);
    let window = 5e-4;
    let mut whole = run(start);
    whole.run(12, window).unwrap();
    let mut other = run(&turned);
    other.run(12, window).unwrap();
    assert_eq!(whole.fingerprint(), other.fingerprint(), "order of the store");
    let mut watched = run(start);
    watched
        .run_while(12, window, &mut |simulation, _| simulation.with_synchronised_velocities(0.5 * window, |_| true))
        .unwrap();
    assert_eq!(whole.fingerprint(), watched.fingerprint(), "looks of an observer");
    let mut stopped = run(start);
    stopped.run_while(12, window, &mut |_, done| done < 5).unwrap();
    let snapshot = diptych::Stored::of(&stopped.snapshot().unwrap()).unwrap();
    let mut resumed = run(start).resume(snapshot.read().unwrap()).unwrap();
    resumed.run(7, window).unwrap();
    assert_eq!(whole.fingerprint(), resumed.fingerprint(), "resumed");
    assert_eq!(whole.state().eddies, resumed.state().eddies);
}

/// The ledger contains the work and the impulse of drag in a turbulent gas. Without other forces, they equal the
/// changes of energy and momentum, up to rounding of 2e4 terms per window.
#[test]
fn the_ledger_is_closed() {
    let scene = homogeneous(0.3, 1.0, 0.0);
    let start = random(&scene, 2000, 1.0, 9);
    let (energy, momentum) = (start.kinetic_energy(), start.momentum());
    let mut simulation = Simulation::with_engine(scene, start, hard());
    simulation.run(50, 0.02).unwrap();
    let ledger = &simulation.record.ledger;
    let end = simulation.state();
    close("energy", end.kinetic_energy() - energy, ledger.drag_work, 1e-12 * energy);
    assert!((end.momentum() - momentum - ledger.drag_impulse).norm() < 1e-12 * energy);
}

/// Case of a bead in homogeneous turbulence.
pub const BEAD: &str = r#"
[domain]
size = ["0.1 m", "0.04 m", "0.1 m"]
periodic = ["x", "z"]
[fluid]
density = "1.2 kg/m^3"
kinematic_viscosity = "1.5e-5 m^2/s"
[fluid.profile.uniform]
velocity = "1 m/s"
[fluid.turbulence]
kinetic_energy = "0.5 m^2/s^2"
dissipation_rate = "5 m^2/s^3"
[fluid.turbulence.langevin]
[drag.stokes]
[[particles]]
diameter = "100 um"
density = "1000 kg/m^3"
count = 1
[run]
duration = "0.1 s"
"#;

#[test]
fn cases_are_read_and_refused_with_a_remedy() {
    let turbulence = |experiment: diptych::Experiment| experiment.scene.fluid.unwrap().turbulence.unwrap();
    let plain = turbulence(case(BEAD, Model::Hard, &[]).unwrap());
    assert_eq!(plain.langevin, Langevin::default());
    let TurbulenceStatistics::Uniform(deviation, turnover) = plain.statistics else { panic!("it is uniform") };
    close("σ", deviation, (1.0_f64 / 3.0).sqrt(), 1e-15);
    close("k/ε", turnover, 0.1, 1e-15);
    let set = ["fluid.turbulence.langevin.kolmogorov_constant=5", "fluid.turbulence.langevin.time_scale_ratio=0"];
    let changed = turbulence(case(BEAD, Model::Hard, &set).unwrap()).langevin;
    assert_eq!(changed, Langevin { kolmogorov_constant: 5.0, time_scale_ratio: 0.0 });
    let walk = case(&BEAD.replace("langevin]", "eddy]"), Model::Hard, &[]).unwrap();
    assert_eq!(turbulence(walk).law, EddyLaw::Eddy);
    let both = BEAD.replace("[drag.stokes]", "[fluid.turbulence.eddy]\n[drag.stokes]");
    let told = case(&both, Model::Hard, &[]).unwrap_err();
    assert!(told.contains("fluid.turbulence") && told.contains("eddy"), "{told}");
    let refused = |profile: &str, drop: &[&str], words: &[&str]| {
        let mut text = BEAD.replace("[fluid.profile.uniform]\nvelocity = \"1 m/s\"", profile);
        drop.iter().for_each(|line| text = text.replace(line, ""));
        let told = case(&text, Model::Hard, &[]).unwrap_err();
        words.iter().for_each(|word| assert!(told.contains(word), "{word} in {told}"));
    };
    let (k, epsilon) = ("kinetic_energy = \"0.5 m^2/s^2\"\n", "dissipation_rate = \"5 m^2/s^3\"\n");
    let uniform = "[fluid.profile.uniform]\nvelocity = \"1 m/s\"";
    refused(uniform, &[k], &["kinetic_energy", "ε = k^(3/2)/L"]);
    refused(uniform, &["[fluid.turbulence.langevin]\n"], &["fluid.turbulence.langevin"]);
    let channel = "[fluid.profile.k_epsilon_channel]\nreynolds_number = 42000";
    refused(channel, &[k], &["dissipation_rate", "uniform gas"]);
    // a table with k and ε, and a table without
    let folder = tempfile::tempdir().unwrap();
    let table = |name: &str, text: &str| {
        let path = folder.path().join(name);
        std::fs::write(&path, text).unwrap();
        let profile = format!("fluid.profile={{ table = {{ file = {path:?} }} }}");
        let text =
            BEAD.replace("[fluid.profile.uniform]\nvelocity = \"1 m/s\"", "").replace(k, "").replace(epsilon, "");
        case(&text, Model::Hard, &[&profile])
    };
    let with =
        table("with.csv", "y_m,U_m_s,k_m2_s2,epsilon_m2_s3\n0,0,0,5\n0.04,1,0.6,5\n").unwrap().scene.fluid.unwrap();
    let local = with.turbulence.as_ref().unwrap().at(&with.profile, &Vector3::new(0.0, 0.02, 0.0));
    // σ is linear between two points, from 0 to sqrt(0.4) m/s; k/ε is 6 sqrt(ν/ε) at the first point and 0.12 s at the
    // second
    close("σ", local.deviation, 0.5 * 0.4_f64.sqrt(), 1e-15);
    assert!((local.gradient - Vector3::new(0.0, 0.4_f64.sqrt() / 0.04, 0.0)).norm() < 1e-12);
    close("T_L", local.time, 0.5 * (6.0 * (1.5e-5_f64 / 5.0).sqrt() + 0.12) / (0.5 + 0.75 * 2.1), 1e-15);
    let told = table("without.csv", "y_m,U_m_s\n0,0\n0.04,1\n").unwrap_err();
    assert!(told.contains("k_m2_s2") && told.contains("add the columns"), "{told}");
    let told = table("zero.csv", "y_m,U_m_s,k_m2_s2,epsilon_m2_s3\n0,0,0,0\n0.04,1,0.6,5\n").unwrap_err();
    assert!(told.contains("zero.csv:2") && told.contains("not possible"), "{told}");
    let log = "[fluid.profile.log_law]\nreynolds_number = 42000";
    refused(log, &[k, epsilon], &["logarithmic law", "k_epsilon_channel"]);
}
