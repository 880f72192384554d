//! Engine of soft spheres, whose contacts last for some time and are resolved by time steps. An island is a group of
//! particles that may meet within a window, the time between two exchanges with the gas.

mod backoff;
mod block;
mod contact;
mod contact_sums;
mod contacts;
mod crowd;
mod facets;
mod fastest;
mod force_buffer;
mod heun;
mod local;
mod packed_contacts;
mod passing;
mod rates;
mod rolling;
mod rotating;
mod wall_contacts;

pub use contact::overlap_limit;

use super::distributed::{GhostExchange, SharedSteps, SingleProcess};
use super::driver::{Driver, Solver, Trial, Work};
use super::islands::{IslandCounters, SpeedSummary};
use super::motion::{accelerate, drift};
use super::population::PopulationSummary;
use super::{Counters, EngineTimes, Failure, Window};
use crate::clock::Clock;
use crate::contact_law::ContactLaw;
use crate::experiment::{Integrator, SoftStepping};
use crate::neighbours::{NeighbourList, along_walls};
use crate::particles::Particles;
use crate::scene::{Scene, SceneInTime};
use backoff::{Backoff, UniformStepWork, stages};
pub(in crate::engine) use contact::{Alike, Contact, TouchingPair, first_named};
pub(in crate::engine) use contact_sums::ContactSums;
use contacts::Due;
use contacts::{ContactSearch, EvaluationTime};
pub(in crate::engine) use contacts::{Contacts, StepRecord};
pub(in crate::engine) use crowd::{Steps, solve as solve_crowd};
pub(in crate::engine) use fastest::Fastest;
pub(in crate::engine) use force_buffer::{ContactTorque, ForceBuffer, ForceIncrement, kick_all};
use local::NoInstants;
pub(in crate::engine) use local::{Allowance, InstantaneousRule, IslandScratch, ReachedTouch, SoftIslands};
use serde::{Deserialize, Serialize};

/// [ns] estimated computing time per particle of a uniform step (one time step of all particles), without pair tests
/// and contact forces, whose costs are in the file `backoff.rs`.
const UNIFORM_COST: f64 = 5.0;

/// Engine of soft spheres: spring-dashpot contacts, with steps of islands (groups that may meet) or of all particles.
///
/// Uniform stepping is velocity Verlet in its kick-drift-kick form, in which two successive half-kicks are one kick.
/// Within a window (time between two exchanges with the gas), stored velocities are therefore those in the middle of
/// steps, and the dashpot uses them. Gravity is added at the end of the window, so a step changes only the velocities
/// of particles in contact. The scheme is stable for ω_0 Δt < 2(sqrt(1+ζ²) - ζ), with the undamped angular frequency
/// ω_0 and damping ratio ζ of a contact. Heun's method (RK2) serves the comparisons in docs/paper.md.
pub type Soft = Driver<SoftSolver>;

/// Solver of soft spheres: islands (groups that may meet) by local steps, all particles at once by uniform steps.
pub struct SoftSolver {
    stepping: SoftStepping,
    pub(in crate::engine) islands: SoftIslands,
    /// Pause in which islands are not tried, because they cost more than uniform steps; only with stepping `Auto`.
    patience: Backoff,
    /// Number of uniform steps since the start of the run.
    steps: u64,
    pub(in crate::engine) integrator: Integrator,
    /// [s] longest step; steps may be a little shorter, so that a window is a whole number of steps.
    longest_step: f64,
    pub(in crate::engine) list: NeighbourList,
    pub(in crate::engine) contacts: Contacts,
    /// True if the contacts in progress are stored in `contacts` alone, because the last steps were uniform. False if
    /// the driver (the caller of this solver) stores the contacts. If processes share the steps, the value is false
    /// too, and `contacts` contains copies of the contacts.
    keeps_contacts: bool,
    /// Contact forces of the last evaluation. In Verlet's method, a window begins with a half-kick (change of
    /// velocities over half a step) by the forces at the end of the previous window.
    pub(in crate::engine) pushes: Vec<ForceBuffer>,
    /// Working memory: forces of the first stage of Heun's method.
    before: Vec<ForceBuffer>,
    pub(in crate::engine) counters: Counters,
    /// [m/s] upper limits of speeds, relative to the moving frame in which the neighbour list measures motion.
    pub(in crate::engine) speed: Fastest,
    /// [m] smallest radius of any particle, for the check of passages through thin walls; `None` without thin walls.
    smallest: Option<f64>,
    /// True if the scene has rough walls, which turn the velocities of the particles that touch them (`facets`).
    has_rough_walls: bool,
    /// Ids of the particles of a crowd (large island) while the particle store holds numbers instead; otherwise empty.
    ids: Vec<u32>,
    /// True if `pushes` contains the forces at the present positions (Verlet's method).
    pub(in crate::engine) has_forces: bool,
    /// True if the particles were last moved by uniform steps, not in islands (groups of particles that may meet).
    pub(in crate::engine) ran_last: bool,
    /// Mass, species and contact constants of every particle, if they are the same for all; otherwise `None`.
    pub(in crate::engine) alike: Option<Alike>,
    /// Data for steps that several processes share.
    pub(in crate::engine) shared: SharedSteps,
}

/// State of the solver between two windows (times between two exchanges with the gas), stored together with a run.
#[derive(Serialize, Deserialize)]
pub struct SoftState {
    patience: Backoff,
    steps: u64,
    counters: Counters,
    /// Present neighbour list. A list that is built anew for the present positions would contain other pairs, in
    /// another order.
    list: NeighbourList,
    /// Forces of the half-kick (change of velocities over half a step) at the start of the next window (Verlet).
    pending: ForceBuffer,
    due: Due,
    has_forces: bool,
    ran_last: bool,
}

impl Soft {
    /// Makes an engine with the given law, integrator, longest time step [s] and way of stepping.
    pub fn new(law: ContactLaw, integrator: Integrator, longest_step: f64, stepping: SoftStepping) -> Self {
        Self::with(SoftSolver {
            stepping,
            patience: Backoff::default(),
            islands: SoftIslands {
                law,
                integrator,
                step: longest_step,
                allowance: Allowance { each: f64::INFINITY, per_particle: 0.0 },
                instants: NoInstants,
            },
            steps: 0,
            integrator,
            longest_step,
            list: NeighbourList::default(),
            contacts: Contacts::new(law),
            keeps_contacts: false,
            pushes: Vec::new(),
            before: Vec::new(),
            counters: Counters::default(),
            speed: Fastest::default(),
            smallest: None,
            has_rough_walls: false,
            ids: Vec::new(),
            has_forces: false,
            ran_last: false,
            alike: None,
            shared: SharedSteps::default(),
        })
    }
}

impl SoftSolver {
    /// Rebuilds the neighbour list for steps that are `between_uses` [s] apart. The particles are sorted anew, and the
    /// indices of particles in contacts and forces are changed accordingly.
    pub(in crate::engine) fn rebuild(&mut self, particles: &mut Particles, scene: &Scene, between_uses: f64) {
        let couples = self.contacts.shed(&self.list);
        self.shared.slots = None;
        let order = self.list.build(particles, scene, between_uses);
        let mut index_of = vec![0u32; order.len()];
        for (index, &from) in order.iter().enumerate() {
            index_of[from as usize] = index as u32;
        }
        self.contacts.reorder(&index_of, couples, &self.list);
        for pushes in &mut self.pushes {
            pushes.reorder(&index_of);
        }
        self.speed.all = particles.largest_speed_in(self.list.frame(), &scene.domain);
    }

    /// Computes the contact forces at the present positions and velocities, and stores them in `pushes`.
    fn evaluate(
        &mut self,
        particles: &Particles,
        scene: &Scene,
        at: EvaluationTime,
        book: &mut StepRecord,
    ) -> Result<(), Failure> {
        let mine = self.shared.mine();
        let view = ContactSearch { list: &self.list, particles, scene, at, mine, alike: self.alike.as_ref() };
        let done = self.contacts.evaluate(view, &mut self.pushes, book)?;
        if let Some(mine) = mine {
            // each process applies only the forces on its own particles
            self.pushes.iter_mut().for_each(|pushes| pushes.leave(mine));
        }
        self.counters.pair_checks += done.checks;
        self.counters.force_evaluations += done.forces;
        Ok(())
    }

    /// Applies the half-kick (change of velocities over half a step of `dt` [s]) at the start of a window. The forces
    /// are those at the end of the previous window. If there are none, as after islands were moved, computes them.
    fn first_half_kick(
        &mut self,
        particles: &mut Particles,
        scene: &Scene,
        (window, dt): (Window, f64),
        book: &mut StepRecord,
        ghosts: &mut dyn GhostExchange,
    ) -> Result<(), Failure> {
        if !self.has_forces {
            // contacts may already be in progress; their first half-kick is applied like any other
            let at = EvaluationTime {
                to_middle: 0.25 * dt,
                weight: 0.0,
                leaves_half: true,
                shear_time: 0.0,
                ..instant(window, 0.0, dt)
            };
            ghosts.agree(self.evaluate(particles, scene, at, book))?;
            self.contacts.count(at, ghosts);
            self.leave_facets(particles, scene, at);
            self.has_forces = true;
        }
        self.kick(particles, &scene.domain, 0.5 * dt);
        ghosts.after_kick(self, particles, Ok(()))?;
        if ghosts.is_lead() {
            self.contacts.record_half_kick(0.5 * dt, window.duration, scene, book.log);
        } else {
            self.contacts.forget();
        }
        Ok(())
    }

    fn verlet(
        &mut self,
        particles: &mut Particles,
        scene: &Scene,
        (window, steps): (Window, u64),
        book: &mut StepRecord,
        ghosts: &mut dyn GhostExchange,
    ) -> Result<(), Failure> {
        let dt = window.duration / steps as f64;
        let fall = scene.gravity - along_walls(scene, scene.gravity);
        let mut scenes = SceneInTime::of(scene);
        self.first_half_kick(particles, scene, (window, dt), book, ghosts)?;
        for step in 0..steps {
            let elapsed = step as f64 * dt;
            self.list.clock.tell(window.start + elapsed);
            if self.may_pass(scene, elapsed, dt) {
                ghosts.agree(self.refuse_to_pass(particles, scene, window, elapsed, dt))?;
            }
            drift(particles, dt, scene.gravity * (dt * (elapsed + 0.5 * dt)));
            let scene = scenes.at(window.start + (elapsed + dt));
            let closing = self.closing_speed(particles, &scene.domain);
            self.list.travel((closing + fall.norm() * (elapsed + dt)) * dt);
            if !self.list.allows(0.0) {
                // the forces in `pushes` have already been applied
                self.pushes.clear();
                book.cross(particles, &scene.domain);
                ghosts.rebuild(self, particles, scene, [dt, 0.0]);
            }
            let last = step + 1 == steps;
            let at = EvaluationTime {
                // positions have just been moved with the stored velocities, which are those in the middle of the step
                fall: elapsed + 0.5 * dt,
                to_middle: 0.5 * dt,
                weight: if last { 0.5 } else { 1.0 },
                leaves_half: last,
                ..instant(window, elapsed + dt, dt)
            };
            self.meet_facets(particles, scene, at);
            let forces = self.evaluate(particles, scene, at, book);
            ghosts.before_kick(particles);
            if forces.is_ok() {
                self.kick(particles, &scene.domain, at.weight * dt);
                self.leave_facets(particles, scene, at);
            }
            ghosts.after_kick(self, particles, forces)?;
            self.contacts.count(at, ghosts);
        }
        Ok(())
    }

    /// Prepares the steps of a window, each of `dt` [s]: finds the largest speed of all particles, and rebuilds an
    /// outdated list.
    fn prepare(
        &mut self,
        particles: &mut Particles,
        scene: &Scene,
        (window, dt): (Window, f64),
        ghosts: &mut dyn GhostExchange,
    ) -> Result<(), Failure> {
        let has_thin_walls = Self::has_thin_walls(scene);
        let radii: &[f64] = if has_thin_walls { &particles.radius } else { &[] };
        let smallest = radii.iter().fold(f64::INFINITY, |a: f64, &r| a.min(r));
        let mut largest = [particles.largest_speed_in(self.list.frame(), &scene.domain), -smallest];
        ghosts.largest(&mut largest);
        self.speed.all = largest[0];
        self.speed.of_walls = scene.wall_speed();
        self.smallest = has_thin_walls.then_some(-largest[1]);
        self.has_rough_walls = scene.has_rough_walls();
        if !self.speed.all.is_finite() {
            return Err(ghosts.not_a_number(self, particles, window.start));
        }
        if !self.list.allows(2.0 * self.closing_speed(particles, &scene.domain) * dt) {
            let due = if self.has_forces { 0.5 * dt } else { 0.0 };
            ghosts.rebuild(self, particles, scene, [2.0 * dt, due]);
        }
        Ok(())
    }

    /// Moves all particles through the whole window by uniform steps, which are equally long for all particles.
    /// `ghosts` exchanges data with the other processes of the run, if there are any.
    pub(in crate::engine) fn uniform(
        &mut self,
        particles: &mut Particles,
        scene: &Scene,
        window: Window,
        book: &mut StepRecord,
        ghosts: &mut dyn GhostExchange,
    ) -> Result<(), Failure> {
        let steps = (window.duration / self.longest_step - 1e-9).ceil().max(1.0);
        let dt = window.duration / steps;
        self.prepare(particles, scene, (window, dt), ghosts)?;
        self.alike = Alike::of(particles, scene, &self.islands.law);
        let result = match self.integrator {
            Integrator::VelocityVerlet => self.verlet(particles, scene, (window, steps as u64), book, ghosts),
            // Heun's method is only for comparison with the paper of docs/paper.md, whose spheres do not rotate
            Integrator::Rk2 if scene.rotation.is_some() => {
                self.verlet(particles, scene, (window, steps as u64), book, ghosts)
            }
            Integrator::Rk2 => self.heun(particles, scene, window, steps as u64, book),
        };
        self.contacts.book(dt, book, ghosts);
        let reached = result.as_ref().map_or_else(|why| why.time() - window.start, |()| window.duration);
        accelerate(particles, scene.gravity * reached);
        result?;
        self.steps += steps as u64;
        Ok(())
    }

    /// Estimates the work of uniform steps of `particles` particles for `time` [s] of simulated time. In this time,
    /// islands computed `forces` contact forces by local steps, and crowds (large islands) `of_crowds` forces.
    fn uniform_work(&self, particles: usize, time: f64, [forces, of_crowds]: [u64; 2]) -> UniformStepWork {
        let stages = stages(self.integrator);
        let local = self.islands.stages().len() as f64;
        UniformStepWork {
            stages: stages * time / self.longest_step,
            particles,
            slots: self.shared.slots.unwrap_or(self.list.slots()).max(particles),
            forces: stages * forces as f64 / local + of_crowds as f64,
        }
    }
}

/// Time of a force evaluation `elapsed` [s] after the start of the window. Positions and velocities belong to the same
/// instant. The forces act for a whole step of `dt` [s].
fn instant(window: Window, elapsed: f64, dt: f64) -> EvaluationTime {
    let remaining = window.duration - elapsed;
    EvaluationTime {
        start: window.start,
        elapsed,
        remaining,
        dt,
        shear_time: dt,
        fall: elapsed,
        to_middle: 0.0,
        weight: 1.0,
        opens: true,
        travel_is_exact: true,
        leaves_half: false,
    }
}

impl Solver for SoftSolver {
    type Islands = SoftIslands;
    type State = SoftState;

    fn islands(&self) -> &SoftIslands {
        &self.islands
    }

    /// Finds the contacts in progress at the start of a run. Uniform steps find contacts in their first evaluation.
    fn begin(&mut self, work: &mut Work<Contact>, window: Window) {
        if self.stepping != SoftStepping::Uniform {
            self.rebuild(work.particles, work.scene, self.longest_step.min(window.duration));
            self.contacts.find(&self.list, work.particles, work.scene, window.start);
            *work.lasting = self.contacts.take(&self.list);
        }
    }

    fn fallback_cost(
        &mut self,
        population: &PopulationSummary,
        _speeds: &SpeedSummary,
        _scene: &Scene,
        _window: Window,
    ) -> Option<f64> {
        if self.stepping == SoftStepping::Auto {
            // an island is given up when it has cost half as much as uniform steps of all particles would; otherwise a
            // failed trial could cost as much as many windows
            self.islands.allowance.each = 0.5 * self.uniform_work(population.count, 1.0, [0; 2]).cost();
        }
        match self.stepping {
            SoftStepping::Uniform => None,
            SoftStepping::Local => Some(f64::INFINITY),
            SoftStepping::Auto => (!self.patience.waits()).then_some(UNIFORM_COST / self.longest_step),
        }
    }

    fn judge(&mut self, population: &PopulationSummary, _scene: &Scene, &Trial { done, before, after }: &Trial) {
        let of_crowds = after.crowd_forces - before.crowd_forces;
        let forces = after.force_evaluations - before.force_evaluations - of_crowds;
        let uniform = self.uniform_work(population.count, done, [forces, of_crowds]);
        self.patience.judge(&before, &after, &uniform);
    }

    fn disturb(&mut self) {
        self.list.invalidate();
        self.contacts.forget();
        self.has_forces = false;
        self.ran_last = false;
        self.shared.halo = None;
    }

    /// Drops all forces and contacts, because their particle indices are no longer valid after a change of the
    /// population. The forces are evaluated anew at the start of the next window.
    fn repopulate(&mut self) {
        self.disturb();
        self.pushes.clear();
        self.contacts = Contacts::new(self.islands.law);
    }

    fn hand_over(&mut self, lasting: &mut Vec<Contact>) {
        if std::mem::take(&mut self.keeps_contacts) {
            *lasting = self.contacts.take(&self.list);
        }
    }

    fn for_each_kept(&self, visit: &mut dyn FnMut(Contact)) {
        if self.keeps_contacts {
            self.contacts.for_each(&self.list, visit);
        }
    }

    fn advance_all(&mut self, work: &mut Work<Contact>, window: Window) -> Result<(), Failure> {
        if !std::mem::replace(&mut self.keeps_contacts, true) {
            self.contacts.put(std::mem::take(work.lasting));
        }
        self.contacts.look_anew();
        self.ran_last = true;
        // impacts of islands that were solved before these steps are counted first
        work.record.count(&mut work.log.impacts);
        let mut book = StepRecord { log: work.log, record: Some(work.record) };
        self.uniform(work.particles, work.scene, window, &mut book, &mut SingleProcess)
    }

    fn counters(&self, islands: &IslandCounters) -> Counters {
        Counters {
            steps: self.steps + islands.events,
            uniform_steps: self.steps,
            neighbour_builds: self.list.builds() + islands.neighbour_builds,
            pair_checks: self.counters.pair_checks + islands.pair_checks + islands.searched,
            force_evaluations: self.counters.force_evaluations + islands.force_evaluations,
            ..islands.of_all_engines()
        }
    }

    fn elastic_energy(&self) -> Option<f64> {
        // the last evaluation in a step of Heun's method is for a predicted state, which the contacts do not store; the
        // energy was therefore summed in that evaluation
        (self.ran_last && self.integrator == Integrator::Rk2).then(|| self.contacts.elastic_energy())
    }

    fn use_clock(&mut self, clock: Clock) {
        self.list.clock = clock;
    }

    fn spent(&self, spent: EngineTimes) -> EngineTimes {
        spent.with_list(&self.list)
    }

    fn state(&self) -> SoftState {
        SoftState {
            patience: self.patience,
            steps: self.steps,
            counters: self.counters,
            list: self.shared.shown.as_ref().map_or(&self.list, |(list, _)| list).clone(),
            pending: match &self.shared.shown {
                Some((_, due)) => due.clone(),
                None => ForceBuffer::merged(&self.pushes),
            },
            due: self.contacts.due(),
            has_forces: self.has_forces,
            ran_last: self.ran_last,
        }
    }

    fn resume(&mut self, state: SoftState) {
        let SoftState { patience, steps, counters, list, pending, due, has_forces, ran_last } = state;
        (self.patience, self.steps, self.counters) = (patience, steps, counters);
        self.pushes = vec![pending];
        (self.has_forces, self.ran_last) = (has_forces, ran_last);
        let clock = std::mem::replace(&mut self.list, list).clock;
        self.list.clock = clock;
        (self.contacts, self.keeps_contacts) = (Contacts::new(self.islands.law), false);
        self.contacts.resume(due);
    }
}
