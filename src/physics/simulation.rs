//! Loop over windows, the times between two exchanges of momentum with the gas. In each window, a half-kick of drag
//! acts, the engine moves the particles, and a second half-kick acts. Heat acts together with drag. Lift, an orbit and
//! differences in weight between species act in further half-kicks between drag and engine. Particles come in and leave
//! at the ends of windows.
//!
//! Drag is a slow, smooth force, so it is split from the motion (Strang); the error is of second order in the window. A
//! kick is the change of velocity by drag during a window, at fixed positions; a half-kick is that during half a
//! window. A kick is the exact solution of the drag law for constant gas velocity, so two half-kicks equal one kick.

mod contacts;
mod coupling;
mod engines;
mod inflow;
mod kick;
mod lift;
mod orbit;
mod own_force;
mod servo;
mod share;
mod snapshot;
mod thermostat;
mod through_flow;
mod totals;
mod turbulence;
mod until;
mod weight;

pub use contacts::ContactSummary;

pub use engines::{SimulationEngine, engine, may_touch, soft_step};
pub use kick::kick;
pub use snapshot::Snapshot;
pub use through_flow::{FlowTotals, OpeningFlow, ThroughFlow};

use crate::clock::Clock;
use crate::communicator::Communicator;
use crate::drag::{Kick, Sphere};
use crate::engine::distributed::Distributed;
use crate::engine::{Counters, Engine, Failure, Window};
use crate::experiment::{Experiment, Integrator};
use crate::fluid::LoadedFlow;
use crate::particles::{Particles, Sample};
use crate::placement::FreeRoom;
use crate::predict::energy::{Bound, broken_contract, too_long};
use crate::record::Record;
use crate::scene::Scene;
use crate::schedule::{Schedule, SchedulePosition};
use crate::walls::Repeated;
use lift::LiftKick;
use nalgebra::Vector3;
use serde::{Deserialize, Serialize};
use servo::ServoControl;
use share::{GatheredParticles, Order, SharedSimulation};
use std::borrow::Cow;
use std::time::Duration;
use totals::SimulationTotals;

/// A simulation of one experiment: the particles, the engine that moves them, and the records of the run.
///
/// ```
/// # extern crate diptych_physics as diptych;
/// use diptych::{Domain, Hard, Particles, Scene, Simulation, Species, Surface, Vector3};
/// let domain = Domain::new(Vector3::repeat(10.0), [true; 3]); // m
/// let scene = Scene::new(domain, Surface::new(0.5, 0.0), vec![Species::new("sphere", 1.0, 1.0)]);
/// // two spheres of 1 m and 1 kg, 2 m apart, approach at 1 m/s; the scene's restitution is 0.5
/// let mut particles = Particles::default();
/// particles.push(Vector3::new(4.0, 5.0, 5.0), Vector3::x(), 0.5, 1.0, 0);
/// particles.push(Vector3::new(6.0, 5.0, 5.0), Vector3::zeros(), 0.5, 1.0, 0);
/// let mut simulation = Simulation::with_engine(scene, particles, Box::new(Hard::new()));
/// simulation.run(20, 0.1)?; // 20 windows of 0.1 s
/// assert_eq!(simulation.record.pairs.count, 1);
/// assert!((simulation.particles.velocity[1].x - 0.75).abs() < 1e-12);
/// # Ok::<(), diptych::Failure>(())
/// ```
pub struct Simulation {
    /// Particles stored in this process; all particles of the run if no other process shares it.
    pub particles: Particles,
    /// Impacts, energies and momenta recorded since the start.
    pub record: Record,
    /// [s] simulated time that the run has reached.
    pub time: f64,
    /// Number of completed windows (a window is the time between two exchanges with the gas).
    pub windows: u64,
    /// Wall-clock time spent in the engine, in drag and in observers (measurements during the run).
    pub spent: SimulationTimes,
    clock: Clock,
    scene: Scene,
    engine: SimulationEngine,
    /// Seed of the random numbers of turbulence, heat and inlets, which act between two windows.
    seed: u64,
    spheres: Vec<Sphere>,
    /// Gas flow that the particles change (two-way coupling); `None` if particles do not change the gas.
    loaded_flow: Option<Box<LoadedFlow>>,
    /// Changes of velocity by drag (kicks) for the two durations that were prepared last, such as half a window and a
    /// whole window. They are stored because a table of a kick takes long to compute.
    kicks: Vec<Kick>,
    /// Number, mass, momentum and mean radius of the particles of all processes.
    totals: SimulationTotals,
    /// [kg m/s] momentum that walls have given to the particles of all processes since the start.
    by_walls: Vector3<f64>,
    /// Connection to the other processes that share the run; `None` if there are no others.
    share: Option<SharedSimulation>,
    /// Description of the gathered particles, while the lead process (number 0) stores particles of all processes in
    /// place of its own. `None` at other times.
    shown: Option<GatheredParticles>,
    /// True if velocities and positions belong to one time. False if velocities lack the half-kick (change by drag in
    /// half a window) at the end of the latest window.
    half_kicked: bool,
    /// Failure that [`run`](Self::run) returns before the next window: a contact law that violates a requirement, a
    /// soft time step that is too long, or a gas flow that is not finite. `None` if the simulation may run.
    refused: Option<Failure>,
    /// Upper limit of the growth of the energy by errors of the time integrator in soft contacts. The run fails if its
    /// energy grows by more. `None` if the model has no soft contacts.
    bound: Option<Bound>,
    /// [J] elastic energy of the overlaps at the start. `None` after the first window, when the soft engine has found
    /// its contacts, and for models without soft contacts.
    unseen: Option<f64>,
    /// Numbers and energies of the particles that have come in and left; `None` in a scene without inlets and outlets.
    through_flow: Option<Box<ThroughFlow>>,
    /// For each inlet, the space in which new particles are placed.
    inlet_rooms: Vec<FreeRoom>,
    /// Data for the control of servo walls, which move to keep the pressure on them; `None` without such walls.
    servo: Option<Box<ServoControl>>,
    /// Position in the schedule of windows that [`run_until`](Self::run_until) follows. Windows have the length 0 until
    /// their length is chosen.
    schedule_position: SchedulePosition,
}

/// Wall-clock time spent in each part of a simulation, measured by the clock of the simulation; zero without a clock.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct SimulationTimes {
    /// Wall-clock time spent in the engine.
    pub engine: Duration,
    /// Wall-clock time spent on changes of velocity between the windows, such as those by drag, lift, heat and
    /// buoyancy.
    pub drag: Duration,
    /// Wall-clock time spent in observers (measurements during the run).
    pub observers: Duration,
    /// Wall-clock time from the start to the end of a run, including all parts.
    pub whole: Duration,
}

/// Returns the particles in the order of their ids, with positions wrapped into the box.
fn in_order(mut particles: Particles, scene: &Scene) -> Particles {
    particles.wrap(&scene.domain);
    particles.sort_by_id();
    particles
}

impl Simulation {
    /// Creates a simulation of an experiment at time 0, with the given particles.
    pub fn new(experiment: &Experiment, particles: Particles) -> Self {
        Self::of(experiment, particles, None)
    }

    /// Creates a simulation at time 0. `others` connects this process with the processes that share the run;
    /// `particles` are then the particles that this process stores. With `None` this process has all particles.
    fn of(experiment: &Experiment, particles: Particles, others: Option<&dyn Communicator>) -> Self {
        let sample = Sample::part(&particles, others);
        let totals = SimulationTotals::of(&sample);
        let count = experiment.most_that_touch(totals.count);
        let (engine, step) = (engine(experiment, count), soft_step(experiment, count));
        let soft = experiment.model().has_contacts() && may_touch(experiment, count);
        // contacts that do not end set no limit: the step is then the duration of the run
        let step = step.min(experiment.run.duration);
        let may_run = experiment.soft.allow_unstable || experiment.soft.integrator == Integrator::Rk2;
        let broken = if soft { broken_contract(experiment, count) } else { None };
        let bound = if soft && broken.is_none() { Bound::new(experiment, (&sample, count), step) } else { None };
        let refused = broken.or_else(|| too_long(experiment, count, step).filter(|_| soft && !may_run));
        let unseen = bound.as_ref().map(Bound::elastic_at_start);
        let mut scene = experiment.scene.clone();
        scene.seed_walls(experiment.run.seed);
        let simulation = Self::with_totals(scene, particles, totals, engine);
        let schedule_position = SchedulePosition::new(Schedule::new(experiment));
        let servo = ServoControl::new(experiment);
        Self { refused, bound, unseen, servo, schedule_position, seed: experiment.run.seed, ..simulation }
    }

    /// Creates a simulation at time 0 with an engine that the calling program supplies. If several processes share the
    /// simulation, this engine moves all particles in the lead process (number 0).
    pub fn with_engine(scene: Scene, particles: Particles, engine: Box<dyn Engine>) -> Self {
        let totals = SimulationTotals::of(&Sample::from(&particles));
        Self::with_totals(scene, particles, totals, SimulationEngine::Single(engine))
    }

    /// Creates a simulation at time 0 with an engine that the calling program supplies, and whose run several processes
    /// can share.
    pub fn with_distributed_engine(scene: Scene, particles: Particles, engine: Box<dyn Distributed>) -> Self {
        let totals = SimulationTotals::of(&Sample::from(&particles));
        Self::with_totals(scene, particles, totals, SimulationEngine::Distributed(engine))
    }

    fn with_totals(scene: Scene, particles: Particles, totals: SimulationTotals, engine: SimulationEngine) -> Self {
        let (mut scene, mut particles) = (scene, particles);
        let through_flow = scene.has_openings().then(|| ThroughFlow::new(&scene, &particles));
        let inlet_rooms = inflow::rooms(&scene);
        scene.walls = Repeated::all(&scene.walls, &scene.domain);
        scene.let_rotate(&mut particles);
        let spheres = match &scene.fluid {
            Some(fluid) => scene.species.iter().map(|species| fluid.sphere(species)).collect(),
            None => Vec::new(),
        };
        let loaded_flow = scene.fluid.as_ref().and_then(|fluid| coupling::flow_at_start(fluid, &scene.domain));
        Self {
            totals,
            loaded_flow: loaded_flow.map(Box::new),
            by_walls: Vector3::zeros(),
            share: None,
            shown: None,
            particles,
            record: Record::default(),
            time: 0.0,
            windows: 0,
            spent: SimulationTimes::default(),
            clock: Clock::default(),
            scene,
            engine,
            seed: 0,
            spheres,
            kicks: Vec::new(),
            half_kicked: true,
            refused: None,
            bound: None,
            unseen: None,
            through_flow: through_flow.map(Box::new),
            inlet_rooms,
            servo: None,
            schedule_position: SchedulePosition::default(),
        }
    }

    /// Sets the seed of the random numbers in kicks of turbulence and heat, at inlets, and in rebounds from rough and
    /// thermal walls. Without this call the seed is 0; rebounds then use the seed of the scene ([`Scene::seed_walls`]).
    pub fn with_seed(mut self, seed: u64) -> Self {
        self.seed = seed;
        self.scene.seed_walls(seed);
        self
    }

    /// Sets the clock that measures the time spent in the parts of the simulation.
    pub fn with_clock(mut self, clock: Clock) -> Self {
        self.engine.use_clock(clock.clone());
        self.clock = clock;
        self
    }

    /// Clock that measures the time spent in the parts of the simulation. The simulation reports its progress to it.
    pub fn clock(&self) -> Clock {
        self.clock.clone()
    }

    /// Runs `windows` windows (times between two exchanges with the gas) of `window` [s] each. At the end, velocities
    /// and positions belong to the same time. Several threads are faster within
    /// [`keep_workers_spinning`](crate::work_sharing::keep_workers_spinning), since idle threads then do not sleep.
    ///
    /// # Errors
    /// A failure of the engine, a particle that left the domain, an unstable soft time step, or energy that grew more
    /// than errors of the time integrator explain. The state remains as it was when the failure was detected.
    pub fn run(&mut self, windows: u64, window: f64) -> Result<(), Failure> {
        let result = self.run_while(windows, window, &mut |_, _| true).map(drop);
        self.gather(1);
        result
    }

    /// Runs windows like [`run`](Self::run), but only as long as `go_on` returns true, and returns the number of
    /// windows done. `go_on` is called at the end of every window but the last, with the number of windows done in
    /// this call. A stopped run can be continued for the remaining windows, here or from a
    /// [`snapshot`](Self::snapshot). The results are then, bit by bit, those of a run without a stop.
    ///
    /// If several processes share the run, each may hold only its part of the particles when `go_on` is called and
    /// after the run. [`gather`](Self::gather) gathers the parts, and [`sample`](Self::sample) is used for sums over
    /// all particles.
    ///
    /// At the calls of `go_on`, and after a run that was stopped, velocities lack the change by drag in half a window
    /// (half-kick). [`with_synchronised_velocities`](Self::with_synchronised_velocities) and
    /// [`finish_half_kick`](Self::finish_half_kick) apply this change.
    ///
    /// # Errors
    /// Errors of [`run`](Self::run).
    pub fn run_while(
        &mut self,
        windows: u64,
        window: f64,
        go_on: &mut dyn FnMut(&mut Self, u64) -> bool,
    ) -> Result<u64, Failure> {
        if windows == 0 {
            return Ok(0);
        }
        if let Some(failure) = &self.refused {
            return Err(failure.clone());
        }
        // successive half-kicks are one kick, because the solution for drag alone is exact
        self.scatter();
        if self.half_kicked {
            self.kick(0.5 * window, self.number_of_first_half());
        } else {
            self.kick(window, self.number_of_kick());
        }
        self.half_kicked = true;
        for k in 1..=windows {
            if let Some(failure) = &self.refused {
                return Err(failure.clone());
            }
            self.advance(window)?;
            self.windows += 1;
            self.exchange_particles();
            if k < windows && !go_on(self, k) {
                self.half_kicked = false;
                return Ok(k);
            }
            self.scatter();
            self.kick(if k < windows { window } else { 0.5 * window }, self.number_of_kick());
        }
        self.check()?;
        Ok(windows)
    }

    /// Applies the change by drag in half a window (half-kick) that velocities lack after a run was stopped. `window`
    /// [s] is the length of the windows of that run. Call this method only if the run is not continued.
    pub fn finish_half_kick(&mut self, window: f64) {
        if !self.half_kicked {
            self.scatter();
            self.kick(0.5 * window, self.number_of_kick());
            self.half_kicked = true;
        }
    }

    /// Scene in which the particles move, at the present simulated time.
    pub fn scene(&self) -> &Scene {
        &self.scene
    }

    /// Particles in the order of their ids, with positions wrapped into the box, as in a saved state.
    pub fn state(&self) -> Particles {
        in_order(self.particles.clone(), &self.scene)
    }

    /// Brings the particles into the form that [`state`](Self::state) returns: in the order of their ids, with
    /// positions wrapped into the box. Unlike with `state`, no second store of particles remains. Call this method only
    /// after the last run, because the engine requires its own order of the particles.
    pub fn end(&mut self) {
        // the memory of the engine is freed before the particles are copied
        self.engine.forget();
        self.particles = in_order(std::mem::take(&mut self.particles), &self.scene);
    }

    /// [m/s] momentum of all particles over their mass; 0 without particles. The momentum is not summed anew: all
    /// changes since the start are added to its sum at the start.
    pub fn mean_velocity(&self) -> Vector3<f64> {
        if self.totals.mass > 0.0 { self.totals.momentum / self.totals.mass } else { Vector3::zeros() }
    }

    /// Particles of this process, with velocities relative to the mean flow of a sheared box. Without shear the
    /// velocities are unchanged, and the particles are not copied.
    pub fn relative_to_flow(&self) -> Cow<'_, Particles> {
        self.particles.relative_to_flow(&self.scene.domain)
    }

    /// [kg] mass of all particles in all processes.
    pub fn total_mass(&self) -> f64 {
        self.totals.mass
    }

    /// Number of particles in all processes.
    pub fn count(&self) -> usize {
        self.totals.count
    }

    /// [m] mean radius of all particles in all processes.
    pub fn mean_radius(&self) -> f64 {
        self.totals.mean_radius
    }

    /// Indices of the particles that were moved in islands (groups of particles that may meet within a window) in the
    /// latest window. `None` if all particles were moved at once.
    pub fn in_islands(&self) -> Option<&[u32]> {
        self.engine.in_islands()
    }

    /// Wall-clock time spent in each part of the engine.
    pub fn engine_spent(&self) -> crate::engine::EngineTimes {
        self.engine.work_done().1
    }

    /// Counts of the work that the engine has done since the start, such as time steps.
    pub fn counters(&self) -> Counters {
        self.engine.work_done().0
    }

    fn advance(&mut self, window: f64) -> Result<(), Failure> {
        self.order(&Order::Advance(self.time, window, self.loaded_flow.clone()));
        self.lift(0.5 * window, LiftKick::BeforeWindow);
        self.add_differences_in_gravity(0.5 * window);
        self.kick_of_orbit(0.5 * window);
        let began = self.clock.now();
        let result = self.engine.advance(
            &mut self.particles,
            &self.scene,
            Window { start: self.time, duration: window },
            &mut self.record,
        );
        self.spent.engine += self.clock.now() - began;
        self.unseen = None;
        // after a failure the state is that at the instant of the failure, so the ledger also ends at this instant
        let reached = result.as_ref().map_or_else(|why| (why.time() - self.time).clamp(0.0, window), |()| window);
        let given = self.given_by_walls();
        let by_walls = given - std::mem::replace(&mut self.by_walls, given);
        self.time += reached;
        if !self.is_follower() {
            self.book_gravity(by_walls, [window, reached]);
        }
        self.move_scene();
        self.steer_servo_walls();
        // kicks after the window find the fluctuations as they are after reflections
        turbulence::mirror_at_walls(&mut self.particles, &self.scene, window);
        self.kick_of_orbit(0.5 * window);
        self.add_differences_in_gravity(0.5 * window);
        self.lift(0.5 * window, LiftKick::AfterWindow);
        if !self.is_follower() {
            self.clock.tell(self.time);
        }
        result
    }

    /// Moves the walls, and the periodic images of a sheared box, to their places at the present time. Particles that
    /// have crossed a sheared side are put back into the box at the other side.
    fn move_scene(&mut self) {
        self.scene.move_to(self.time);
        if self.scene.domain.shear.is_none() {
            return;
        }
        self.record.ledger += self.particles.wrap(&self.scene.domain);
        self.totals.momentum = self.particles.momentum();
    }

    /// Calls `show` during a run, at a time when velocities lack the change by drag in half a window (half-kick). This
    /// half-kick of the duration `kick` [s] is applied before the call. Afterwards all velocities are restored, so
    /// that the call changes no bit of the run. If each process has a part of the particles, all processes apply the
    /// half-kick.
    pub fn with_synchronised_velocities<T>(&mut self, kick: f64, show: impl FnOnce(&mut Self) -> T) -> T {
        let kicked = self.is_dragged() || self.scene.thermostat.is_some();
        let kept = kicked.then(|| {
            let mut before = Particles::default();
            self.particles.keep_kicked(&mut before);
            before.eddies.clone_from(&self.particles.eddies);
            let kept = (self.record.ledger.clone(), self.totals.momentum, self.refused.clone());
            (before, self.loaded_flow.clone(), kept)
        });
        let by_all = kicked && self.engine.is_cut();
        if by_all {
            self.order(&Order::Keep);
        }
        self.kick(kick, self.number_of_kick());
        let began = self.clock.now();
        let answer = show(self);
        self.spent.observers += self.clock.now() - began;
        if by_all {
            self.order(&Order::TakeBack);
        }
        if let Some((mut before, gas, kept)) = kept {
            self.particles.take_back(&mut before);
            self.particles.eddies = before.eddies;
            self.take_gas(gas);
            (self.record.ledger, self.totals.momentum, self.refused) = kept;
        }
        answer
    }

    /// Checks that all particles are in the domain and the energy within its limit, and balances the load of processes.
    fn check(&mut self) -> Result<(), Failure> {
        // the other processes check their particles at the same time
        self.order(&Order::Check);
        self.collect_records();
        if let Some(failure) = self.refused.as_ref().filter(|_| !self.is_follower()) {
            return Err(failure.clone());
        }
        if let Some(bound) = &self.bound {
            // the energy is checked first, since too much energy may be the reason why particles left the domain
            let uniform = self.counters().uniform_steps > 0;
            let (energy, elastic) = (self.energy(), self.engine.elastic_energy());
            // only the lead process has the records of all processes
            if !self.is_follower() {
                bound.check(self.time, uniform, energy, elastic, &self.record)?;
            }
        }
        let domain = &self.scene.domain;
        let [outside] = self.sample().sums(|index| [f64::from(!domain.contains(&self.particles.position[index]))]);
        if outside > 0.0 && !self.is_follower() {
            self.gather(1);
            let is_outside = |x: &Vector3<f64>| !self.scene.domain.contains(x);
            let index = self.particles.position.iter().position(is_outside).unwrap_or_default();
            let (x, particle) = (self.particles.position[index], self.particles.id[index]);
            return Err(Failure::Escaped { time: self.time, particle, x: x.x, y: x.y, z: x.z });
        }
        if let Some(engine) = self.engine.distributed_mut() {
            engine.balance(&self.particles, &self.scene);
        }
        Ok(())
    }
}
