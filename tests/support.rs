//! Small scenes and common functions of the tests. The paper is the channel study of docs/paper.md.

use diptych::case::Case;
use diptych::communicator::Communicator;
use diptych::contact_law::ContactLaw;
use diptych::domain::Domain;
use diptych::engine::distributed::Distributed;
use diptych::engine::hard::{Hard, SteppedHard};
use diptych::engine::soft::Soft;
use diptych::engine::{Engine, Failure};
use diptych::experiment::{
    Amount, AverageFrom, DsmcSettings, Experiment, HardSettings, HardStepping, HybridSettings, Integrator, Model,
    Population, RunSettings, SoftSettings, SoftStepping, Spheres, StatisticsSettings, TimeStep,
};
use diptych::particles::Particles;
use diptych::placement::initial_state;
use diptych::scene::{Scene, Species, Surface};
use diptych::simulation::Simulation;
use diptych::walls::{Plane, Wall, WallGeometry};
use nalgebra::Vector3;
use std::path::Path;
use std::sync::Arc;

/// Small particle of the paper: 406 um, 1038 kg/m3.
pub fn small() -> Species {
    Species::new("S", 406e-6, 1038.0)
}

/// Large particle of the paper: 1.5 mm, 1032 kg/m3.
pub fn large() -> Species {
    Species::new("L", 1.5e-3, 1032.0)
}

/// Surface with the given restitution and friction.
pub fn surface(restitution: f64, friction: f64) -> Surface {
    Surface::new(restitution, friction)
}

/// Box of the given size [m] without gas, gravity or walls.
pub fn empty(size: [f64; 3], periodic: [bool; 3], species: Species, contact: Surface) -> Scene {
    Scene::new(Domain::new(Vector3::from(size), periodic), contact, vec![species])
}

/// Wall that is a plane through `point` [m]. The whole space behind it, opposite to `normal`, is solid.
pub fn plane(point: [f64; 3], normal: [f64; 3], surface: Surface) -> Wall {
    Wall::new(WallGeometry::Plane(Plane { point: point.into(), normal: normal.into() }), surface)
}

/// Spheres of species 0 at given positions and velocities.
pub fn placed(scene: &Scene, list: &[([f64; 3], [f64; 3])]) -> Particles {
    let mut particles = Particles::default();
    for (x, v) in list {
        let species = &scene.species[0];
        particles.push((*x).into(), (*v).into(), 0.5 * species.diameter, species.mass(), 0);
    }
    particles
}

/// Experiment with a random start of `count` particles of species 0. `mean` [m/s] is their mean velocity, and
/// `fluctuation` [m/s] the standard deviation of each velocity component.
pub fn experiment(scene: Scene, count: usize, mean: [f64; 3], fluctuation: f64, model: Model, seed: u64) -> Experiment {
    let law = ContactLaw::linear(3000.0);
    let spheres = match model {
        Model::Soft => Spheres::Soft(law),
        Model::Hard => Spheres::Hard,
        Model::Hybrid => Spheres::Hybrid(law),
        Model::Dsmc => Spheres::Dsmc,
    };
    Experiment {
        against: None,
        name: "test".into(),
        scene,
        start: vec![Population {
            species: 0,
            amount: Amount::Count(count),
            region: None,
            velocity_mean: mean.into(),
            velocity_fluctuation: Vector3::repeat(fluctuation),
            spin_mean: Vector3::zeros(),
            spin_fluctuation: 0.0,
        }],
        soft: SoftSettings {
            law: Some(law),
            time_step: TimeStep::PerContact(20.0),
            stepping: SoftStepping::Uniform,
            integrator: Integrator::VelocityVerlet,
            allow_unstable: false,
        },
        hard: HardSettings { stepping: HardStepping::Events, contact_time: None },
        hybrid: HybridSettings { clearance: 2.0 },
        dsmc: DsmcSettings::default(),
        run: RunSettings {
            instants: None,
            spheres,
            duration: 1.0,
            average_from: AverageFrom::Time(0.0),
            window: None,
            seed,
        },
        statistics: StatisticsSettings { slices: 10, sample_interval: None },
        observe: Default::default(),
    }
}

/// Experiment of a case in the text of a test, with changes; otherwise the reason why the case is refused.
pub fn case(text: &str, model: Model, sets: &[&str]) -> Result<Experiment, String> {
    let sets: Vec<String> = sets.iter().map(|set| (*set).to_string()).collect();
    let case = Case::from_text(Path::new("tests/case.toml"), text.into(), &sets).map_err(|why| why.to_string())?;
    case.experiment(Some(model), None).map(|(experiment, _)| experiment).map_err(|why| why.to_string())
}

/// Particles of species 0 at random positions without overlap. `fluctuation` [m/s] is the standard deviation of each
/// velocity component.
pub fn random(scene: &Scene, count: usize, fluctuation: f64, seed: u64) -> Particles {
    initial_state(&experiment(scene.clone(), count, [0.0; 3], fluctuation, Model::Hard, seed)).unwrap()
}

/// Soft engine with stiffness k [N/m] and time step dt [s], in which uniform time steps move all particles together.
pub fn soft(k: f64, dt: f64, integrator: Integrator) -> Box<dyn Engine> {
    Box::new(Soft::new(ContactLaw::linear(k), integrator, dt, SoftStepping::Uniform))
}

/// Soft engine with stiffness k [N/m] and time step dt [s], in which only particles that may touch move in time steps.
pub fn local(k: f64, dt: f64, integrator: Integrator) -> Box<dyn Engine> {
    Box::new(Soft::new(ContactLaw::linear(k), integrator, dt, SoftStepping::Local))
}

/// Event-driven engine of hard spheres with its default settings.
pub fn hard() -> Box<dyn Engine> {
    Box::new(Hard::new())
}

/// Event-driven engine of hard spheres, with islands (groups of particles that may meet) wherever possible.
pub fn islands() -> Box<dyn Engine> {
    Box::new(Hard::with_islands())
}

/// Engine of hard spheres in time steps, with the step criterion θ [-]. It is the distance by which a typical pair
/// approaches in one step, divided by the diameter.
pub fn stepped(theta: f64) -> Box<dyn Engine> {
    Box::new(SteppedHard::new(theta))
}

/// Runs for `duration` [s] in `windows` windows (equal pieces of the run). Returns the simulation with its particles in
/// the order of ids.
pub fn run(scene: &Scene, particles: Particles, engine: Box<dyn Engine>, duration: f64, windows: u64) -> Simulation {
    let (simulation, result) = try_run(scene, particles, engine, duration, windows);
    result.unwrap();
    simulation
}

/// Runs in the way of [`run`], and also returns the failure if there is one.
pub fn try_run(
    scene: &Scene,
    particles: Particles,
    engine: Box<dyn Engine>,
    duration: f64,
    windows: u64,
) -> (Simulation, Result<(), Failure>) {
    let mut simulation = Simulation::with_engine(scene.clone(), particles, engine);
    let result = simulation.run(windows, duration / windows as f64);
    simulation.particles.sort_by_id();
    (simulation, result)
}

/// Species with diameter 1 m and mass 1 kg, so that these are the units of length and mass.
pub fn unit() -> Species {
    Species::new("unit", 1.0, 6.0 / std::f64::consts::PI)
}

/// Edge [m] of the cube in which `count` spheres of diameter `d` [m] have the volume fraction `phi`.
pub fn edge(count: usize, d: f64, phi: f64) -> f64 {
    (count as f64 * std::f64::consts::PI / (6.0 * phi)).cbrt() * d
}

/// Asserts that two numbers agree within an absolute tolerance.
#[track_caller]
pub fn close(what: &str, got: f64, want: f64, tolerance: f64) {
    assert!((got - want).abs() <= tolerance, "{what}: {got}, should be {want} +- {tolerance}");
}

/// Smallest gap between any two spheres [m], found by testing all pairs.
pub fn smallest_gap(scene: &Scene, particles: &Particles) -> f64 {
    let n = particles.len();
    let mut least = f64::INFINITY;
    for i in 0..n {
        for j in 0..i {
            let apart = scene
                .domain
                .separation(&scene.domain.wrap(&particles.position[i]), &scene.domain.wrap(&particles.position[j]));
            least = least.min(apart.norm() - particles.radius[i] - particles.radius[j]);
        }
    }
    least
}

/// [m²/s²] granular temperature 2E/(3(N-1)m) of N spheres of equal mass m without mean motion. E is their kinetic
/// energy.
pub fn temperature(particles: &Particles) -> f64 {
    2.0 * particles.kinetic_energy() / (3.0 * (particles.len() as f64 - 1.0) * particles.mass[0])
}

/// Both integrators that uniform stepping of soft spheres can use.
pub const BOTH: [Integrator; 2] = [Integrator::VelocityVerlet, Integrator::Rk2];

/// Linear spring and dashpot in closed form, computed independently of the library.
#[derive(Clone, Copy)]
pub struct LinearSpring {
    /// [N/m] stiffness k_n.
    pub stiffness: f64,
}

impl LinearSpring {
    /// [-] damping ratio ζ with which an impact has this restitution.
    pub fn damping_ratio(restitution: f64) -> f64 {
        let ln = restitution.ln();
        -ln / std::f64::consts::PI.hypot(ln)
    }

    /// [1/s] undamped angular frequency ω_0 for an effective mass [kg].
    pub fn angular_frequency(&self, effective_mass: f64) -> f64 {
        (self.stiffness / effective_mass).sqrt()
    }

    /// [1/s] damping γ_n = ζ ω_0 with which an impact has this restitution.
    pub fn damping(&self, effective_mass: f64, restitution: f64) -> f64 {
        Self::damping_ratio(restitution) * self.angular_frequency(effective_mass)
    }

    /// [s] contact time T_c of an impact with this restitution, for an effective mass [kg].
    pub fn contact_time(&self, effective_mass: f64, restitution: f64) -> f64 {
        let ratio = Self::damping_ratio(restitution);
        std::f64::consts::PI / (self.angular_frequency(effective_mass) * (1.0 - ratio * ratio).sqrt())
    }
}

/// [-] fraction of the energy M u²/2 that the integrator adds in an elastic impact on a linear spring. The result is
/// the mean and the standard deviation over the phases (instants within a time step) of the first touch. It is computed
/// independently of the library.
pub fn gain_of_an_impact(integrator: Integrator, steps_per_contact: f64) -> (f64, f64) {
    const PHASES: usize = 2000;
    // with unit mass and stiffness, the contact lasts π
    let dt = std::f64::consts::PI / steps_per_contact;
    let force = |gap: f64| (-gap).max(0.0);
    let step = |(x, v): (f64, f64)| match integrator {
        Integrator::VelocityVerlet => {
            let half = v + 0.5 * dt * force(x);
            let x = x + dt * half;
            (x, half + 0.5 * dt * force(x))
        }
        Integrator::Rk2 => {
            let (first, second) = (force(x), force(x + dt * v));
            (x + dt * v + 0.5 * dt * dt * first, v + 0.5 * dt * (first + second))
        }
    };
    let gain = |phase: usize| {
        let mut state = (dt * (phase as f64 + 0.5) / PHASES as f64, -1.0);
        while state.1 <= 0.0 || state.0 < 0.0 {
            state = step(state);
        }
        state.1 * state.1 - 1.0
    };
    let gains: Vec<f64> = (0..PHASES).map(gain).collect();
    let mean = gains.iter().sum::<f64>() / PHASES as f64;
    let variance = gains.iter().map(|gain| (gain - mean).powi(2)).sum::<f64>() / PHASES as f64;
    (mean, variance.sqrt())
}

/// Energy [J] that the integrator has added to an elastic gas of equal spheres in its impacts so far, and the
/// uncertainty of this energy [J]. It is computed from the gain in head-on impacts.
///
/// The speeds are those of the recorded impacts, which have random phases (instants of the first touch within a time
/// step). The standard error is therefore the deviation of one impact times the root of the sum of (M u²/2)². This sum
/// is at most the largest value times the sum of values; four standard errors are allowed. The normal of an oblique
/// impact turns by about the overlap over the diameter. The gain in head-on impacts neglects this, for which 3 % of the
/// gain are allowed. The energy error of a contact in progress may be as large as that of a finished one.
pub fn gain_of_a_gas(simulation: &Simulation, integrator: Integrator, steps_per_contact: f64) -> (f64, f64) {
    let (mean, deviation) = gain_of_an_impact(integrator, steps_per_contact);
    let (pairs, half) = (&simulation.record.pairs, 0.25 * simulation.particles.mass[0]);
    let through = half * pairs.normal_speed.sum_of_squares();
    let error = deviation * (through * half * pairs.normal_speed.maximum.powi(2)).sqrt();
    let in_progress = simulation.energy() - simulation.particles.kinetic_energy();
    (mean * through, 4.0 * error + 0.03 * (mean * through).abs() + (mean.abs() + deviation) * in_progress)
}

/// Path of a small case, for tests that start the program.
pub const BASE: &str = "tests/inputs/good/base.toml";

/// Command that runs the program with these arguments in the root folder of the crate.
pub fn diptych(arguments: &[&str]) -> std::process::Command {
    let mut command = std::process::Command::new(env!("CARGO_BIN_EXE_diptych"));
    command.current_dir(env!("CARGO_MANIFEST_DIR")).args(arguments);
    command
}

/// Text that a program has printed, from its bytes.
pub fn words(bytes: &[u8]) -> String {
    String::from_utf8(bytes.to_vec()).unwrap()
}

/// Communicator of one of several threads. These threads take the place of the processes that share a run.
pub struct Crew {
    rank: usize,
    room: Arc<Room>,
}

/// Memory through which the threads exchange messages.
struct Room {
    barrier: std::sync::Barrier,
    /// Messages that have been sent, by index of the sender and index of the receiver.
    post: std::sync::Mutex<Vec<Vec<Vec<u8>>>>,
}

impl Crew {
    /// Makes one communicator for each of `size` threads.
    pub fn of(size: usize) -> Vec<Arc<dyn Communicator>> {
        let post = std::sync::Mutex::new(vec![Vec::new(); size]);
        let room = Arc::new(Room { barrier: std::sync::Barrier::new(size), post });
        (0..size).map(|rank| Arc::new(Self { rank, room: room.clone() }) as _).collect()
    }
}

impl Communicator for Crew {
    fn rank(&self) -> usize {
        self.rank
    }

    fn size(&self) -> usize {
        self.room.post.lock().unwrap().len()
    }

    fn exchange(&self, outgoing: Vec<Vec<u8>>) -> Vec<Vec<u8>> {
        self.room.post.lock().unwrap()[self.rank] = outgoing;
        self.room.barrier.wait();
        let got = self.room.post.lock().unwrap().iter().map(|of| of[self.rank].clone()).collect();
        self.room.barrier.wait();
        got
    }

    fn broadcast(&self, bytes: Vec<u8>) -> Vec<u8> {
        self.exchange(vec![bytes; self.size()]).swap_remove(0)
    }

    fn sum(&self, numbers: &mut [i64]) {
        let bytes = |numbers: &[i64]| numbers.iter().flat_map(|n| n.to_le_bytes()).collect();
        let all = self.exchange(vec![bytes(numbers); self.size()]);
        for (k, number) in numbers.iter_mut().enumerate() {
            let of = |bytes: &Vec<u8>| i64::from_le_bytes(bytes[8 * k..8 * k + 8].try_into().unwrap());
            *number = all.iter().map(of).sum();
        }
    }

    fn largest(&self, values: &mut [f64]) {
        let all = self.exchange(vec![values.iter().flat_map(|v| v.to_le_bytes()).collect(); self.size()]);
        for (k, value) in values.iter_mut().enumerate() {
            let of = |bytes: &Vec<u8>| f64::from_le_bytes(bytes[8 * k..8 * k + 8].try_into().unwrap());
            *value = all.iter().map(of).fold(f64::NEG_INFINITY, f64::max);
        }
    }
}

/// Runs a simulation that `size` threads share in place of processes. Returns the value that the function `see`
/// computes from the simulation at its end.
pub fn shared<T>(
    size: usize,
    (scene, start): &(Scene, Particles),
    engine: &(dyn Fn() -> Box<dyn Distributed> + Sync),
    (duration, windows): (f64, u64),
    see: impl FnOnce(&mut Simulation) -> T,
) -> T {
    let simulation = |communicator: Arc<dyn Communicator>| {
        Simulation::with_distributed_engine(scene.clone(), start.clone(), engine()).shared(communicator, 0)
    };
    let mut crew = Crew::of(size);
    let lead = crew.remove(0);
    std::thread::scope(|scope| {
        for communicator in crew {
            scope.spawn(|| simulation(communicator).follow(&mut |_, _, _| {}));
        }
        let mut simulation = simulation(lead);
        simulation.run(windows, duration / windows as f64).unwrap();
        see(&mut simulation)
    })
}
