//! Default settings of an experiment. They equal the settings of a case that leaves the keys out. A window is the time
//! between two exchanges with the gas.

use super::{
    Amount, AverageFrom, DsmcSettings, Experiment, HardSettings, HardStepping, HybridSettings, Integrator,
    ObserveSettings, Population, RunSettings, SoftSettings, SoftStepping, Spheres, StatisticsSettings, TimeStep,
};
use crate::particles::Particles;
use crate::scene::Scene;
use nalgebra::Vector3;

/// [-] default number of steps per contact N_c (section 3.4 of the paper, see `docs/paper.md`, gives 15 to 50).
const STEPS_PER_CONTACT: f64 = 20.0;

impl Experiment {
    /// Makes the experiment of a scene with the default settings of a case. The run lasts `duration` [s], and its seed
    /// is 1. The time step and the window (time between two exchanges with the gas) are chosen from the scene. The
    /// caller changes other settings in the fields.
    ///
    /// ```
    /// # extern crate diptych_physics as diptych;
    /// use diptych::{ContactLaw, Domain, Experiment, Population, Scene, Simulation, Species, Spheres, Surface, Vector3};
    ///
    /// let domain = Domain::new(Vector3::repeat(2e-3), [true; 3]); // m
    /// let scene = Scene::new(domain, Surface::new(0.9, 0.0), vec![Species::new("glass", 2e-4, 2500.0)]);
    /// let start = vec![Population::random(0, 125, 0.1)]; // 125 spheres, 0.1 m/s along each axis
    /// let mut experiment = Experiment::new(scene, start, Spheres::Soft(ContactLaw::linear(1000.0)), 0.01); // s
    /// experiment.run.seed = 7;
    /// let mut simulation = Simulation::from_start(&experiment)?;
    /// simulation.run_until(0.01)?;
    /// assert!(simulation.record.pairs.count > 0);
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    pub fn new(scene: Scene, start: Vec<Population>, spheres: Spheres, duration: f64) -> Self {
        let mut experiment = Self {
            name: String::new(),
            against: None,
            scene,
            start,
            soft: SoftSettings::default(),
            hard: HardSettings::default(),
            hybrid: HybridSettings::default(),
            dsmc: DsmcSettings::default(),
            run: RunSettings::new(spheres, duration),
            statistics: StatisticsSettings::default(),
            observe: ObserveSettings::default(),
        };
        experiment.name = experiment.model().name().into();
        experiment.soft.law = experiment.law();
        experiment
    }
}

impl Population {
    /// Population of `count` spheres of a species at random positions. Each velocity component has the standard
    /// deviation `fluctuation` [m/s] about 0. `species` is an index into [`Scene::species`].
    pub fn random(species: u16, count: usize, fluctuation: f64) -> Self {
        Self {
            species,
            amount: Amount::Count(count),
            region: None,
            velocity_mean: Vector3::zeros(),
            velocity_fluctuation: Vector3::repeat(fluctuation),
            spin_mean: Vector3::zeros(),
            spin_fluctuation: 0.0,
        }
    }

    /// Population of particles with given positions, all of one species; `species` is an index into [`Scene::species`].
    pub fn placed(species: u16, particles: Particles) -> Self {
        Self { amount: Amount::Placed(particles), ..Self::random(species, 0, 0.0) }
    }
}

impl RunSettings {
    /// Settings of a run of `duration` [s] with seed 1 and averages from the steady state on. The length of the window
    /// (time between two exchanges with the gas) is chosen by the program.
    pub fn new(spheres: Spheres, duration: f64) -> Self {
        Self { instants: None, spheres, duration, average_from: AverageFrom::Steady, window: None, seed: 1 }
    }
}

impl Default for SoftSettings {
    /// Settings without a contact law: velocity Verlet with 20 steps per contact, and uniform or local stepping,
    /// whichever takes less computing time.
    fn default() -> Self {
        Self {
            law: None,
            time_step: TimeStep::PerContact(STEPS_PER_CONTACT),
            stepping: SoftStepping::Auto,
            integrator: Integrator::VelocityVerlet,
            allow_unstable: false,
        }
    }
}

impl Default for HardSettings {
    /// Settings with an event queue and without the TC model, so that no collision is made elastic.
    fn default() -> Self {
        Self { stepping: HardStepping::Events, contact_time: None }
    }
}

impl Default for HybridSettings {
    /// Settings with a clearance of two contact times. A touch is an instantaneous collision if no third body can come
    /// near within this time (docs/design/hybrid.md).
    fn default() -> Self {
        Self { clearance: 2.0 }
    }
}

impl Default for DsmcSettings {
    /// Settings with the Enskog factor, automatic cells, and steps of a fifth of the mean free time
    /// (docs/design/dsmc.md).
    fn default() -> Self {
        Self { enskog: true, cells: None, step: 0.2 }
    }
}

impl Default for StatisticsSettings {
    /// Settings with 40 slices, and a time between samples (instants of measurement) that is chosen from the scene.
    fn default() -> Self {
        Self { slices: 40, sample_interval: None }
    }
}
