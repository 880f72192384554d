//! Hybrid spheres: the touch of two bodies is an instantaneous impulse (change of momentum) if no other body comes
//! near, and a lasting contact otherwise.
//!
//! This rule is applied at the exact time of every touch. T_c is the time for which an isolated contact of the two
//! bodies would last with the contact law, at their speed of approach u_n. The touch is an impulse, as of hard spheres,
//! if two conditions hold during the clear time θ T_c after it:
//!
//! * No third body can reach either of the two, whatever the impulse does to their velocities. Neither of the two is in
//!   contact now.
//! * Gravity does not bring the sphere back to the wall that it leaves: 2 e u_n/g_n > θ T_c, with the restitution e and
//!   the component g_n of gravity towards the wall.
//!
//! All other touches, and those at servo walls (which move to keep the pressure on them), begin soft contacts, which
//! are resolved by time steps. θ is the argument `clearance` of `Hybrid::new`. An impulse thus replaces only a contact
//! that would end before another body could take part in it. Only soft contacts continue from one window (time between
//! two exchanges with the gas) to the next. An impulse conserves momentum exactly, and the energy that it dissipates is
//! recorded.
//!
//! An island is a group of particles that may meet. A crowd is an island that is too large for local stepping, such as
//! a bed of particles. It is moved by uniform time steps, while all other particles fly and collide.

use super::distributed::DistributedSolver;
use super::driver::{Driver, Solver, Trial, Work};
use super::hard::Collision;
use super::islands::{BoundedIslands, GivenUp, Island, IslandCounters, Solve, SpeedSummary};
use super::population::PopulationSummary;
use super::soft::{
    Allowance, Contact, InstantaneousRule, IslandScratch, ReachedTouch, Soft, SoftIslands, SoftSolver, SoftState,
    Steps, solve_crowd,
};
use super::{Counters, EngineTimes, Failure, Window};
use crate::clock::Clock;
use crate::contact_law::ContactLaw;
use crate::encounter::{Couple, Other};
use crate::experiment::{Integrator, SoftStepping};
use crate::particles::Particles;
use crate::record::{LeftOut, Log};
use crate::scene::Scene;

/// Engine of hybrid spheres: a touch of two bodies is an instantaneous impulse if no other body is near, and a soft
/// contact otherwise.
pub type Hybrid = Driver<HybridSolver>;

/// Solver of hybrid spheres. Islands (groups of particles that may meet) are solved with impulses and local time steps,
/// crowds (large islands) with uniform steps. If all particles are moved at once, the soft engine moves them.
pub struct HybridSolver {
    soft: SoftSolver,
    islands: HybridIslands,
}

/// Solver of islands (groups of particles that may meet) of hybrid spheres. Small islands are solved with impulses and
/// local time steps, crowds (large islands) with uniform steps.
pub struct HybridIslands {
    few: SoftIslands<Impulses>,
    many: Steps,
}

/// Rule that decides which touches of two bodies are instantaneous impulses, and which begin soft contacts.
pub struct Impulses {
    law: ContactLaw,
    /// [-] clearance θ: time for which no other body may come near the two bodies, divided by the duration of their
    /// contact.
    clearance: f64,
}

impl Hybrid {
    /// Makes an engine with the given law, integrator and longest time step [s] of contacts that last. A touch is
    /// instantaneous if no other body can come near within θ contact times; `clearance` is θ [-].
    pub fn new(law: ContactLaw, integrator: Integrator, longest_step: f64, clearance: f64) -> Self {
        let many = Steps { law, integrator, longest: longest_step };
        Self::with(HybridSolver {
            soft: Soft::new(law, integrator, longest_step, SoftStepping::Auto).solver,
            islands: HybridIslands {
                few: SoftIslands {
                    law,
                    integrator,
                    step: longest_step,
                    // an island that has cost as much as a crowd of its size becomes a crowd, so the total cost is at
                    // most twice that of the cheaper method
                    allowance: Allowance { each: 0.0, per_particle: many.cost_in_a_bed() },
                    instants: Impulses { law, clearance },
                },
                many,
            },
        })
    }
}

impl InstantaneousRule for Impulses {
    fn clear_for(&self, meeting: &ReachedTouch, particles: &Particles) -> Option<f64> {
        let ReachedTouch { touch, met, scene, moment, .. } = meeting;
        let approach = -met.normal_velocity;
        let clear = self.clearance * self.law.contact_time(&touch.spring, approach);
        // a sphere that leaves a wall too slowly returns to the wall before the clear time ends
        let weight = match touch.couple.other {
            // a servo wall measures the forces of contacts that last
            Other::Wall(at) if scene.walls[at.wall as usize].servo().is_some() => return None,
            Other::Wall(_) => {
                let wall = touch.couple.wall_motion(met, (particles, scene), *moment).unwrap_or_default();
                wall.pressing(&scene.gravity, &met.normal)
            }
            Other::Particle(_) => 0.0,
        };
        let leaves = 2.0 * touch.spring.restitution * approach > weight * clear;
        (approach > 0.0 && leaves).then_some(clear)
    }

    fn strike(&self, meeting: &ReachedTouch, particles: &mut Particles, log: &mut Log) {
        let ReachedTouch { touch, met, scene, moment, remaining } = meeting;
        let (couple, kinds) = (touch.couple, touch.couple.kinds(particles));
        let wall = couple.wall_motion(met, (particles, scene), *moment);
        let image = couple.image_velocity(particles, scene, &met.velocity);
        let collision = Collision { couple, met: *met, elastic: false, kinds, wall, image };
        collision.resolve(particles, scene, *remaining, log);
        if let Some((_, impact)) = log.impacts.last_mut() {
            // at a rough wall this is the speed along the normal of the facet
            let approach = impact.normal_speed;
            let duration = self.law.contact_time(&touch.spring, approach);
            let overlap = self.law.greatest_overlap(&touch.spring, approach) / touch.diameter;
            impact.left_out = Some(LeftOut { duration, overlap });
        }
    }
}

impl Solve for HybridIslands {
    type Finder<'a> = BoundedIslands<'a>;
    type Carried = Contact;
    type Scratch = IslandScratch;

    fn indices(contact: &Contact) -> [Option<u32>; 2] {
        SoftIslands::<Impulses>::indices(contact)
    }

    fn moved(contact: &Contact, index_of: &dyn Fn(u32) -> u32) -> Contact {
        SoftIslands::<Impulses>::moved(contact, index_of)
    }

    fn energy(&self, contact: &Contact) -> f64 {
        self.few.energy(contact)
    }

    fn available_energy(&self, contact: &Contact) -> f64 {
        self.few.available_energy(contact)
    }

    fn spring_energies(&self, contact: &Contact) -> [f64; 3] {
        self.few.spring_energies(contact)
    }

    fn touching(&self, contact: &Contact) -> Option<Couple> {
        self.few.touching(contact)
    }

    fn takes_crowds(&self) -> bool {
        true
    }

    fn solve(
        &self,
        island: &mut Island<Contact>,
        scratch: &mut IslandScratch,
        scene: &Scene,
        window: Window,
        end: f64,
    ) -> Result<Option<usize>, GivenUp> {
        if island.crowd {
            Ok(solve_crowd(island, self.many, scene, window, end)?)
        } else {
            self.few.solve(island, scratch, scene, window, end)
        }
    }
}

impl Solver for HybridSolver {
    type Islands = HybridIslands;
    type State = SoftState;

    fn islands(&self) -> &HybridIslands {
        &self.islands
    }

    fn begin(&mut self, work: &mut Work<Contact>, window: Window) {
        self.soft.begin(work, window);
    }

    fn fallback_cost(
        &mut self,
        population: &PopulationSummary,
        speeds: &SpeedSummary,
        scene: &Scene,
        window: Window,
    ) -> Option<f64> {
        // islands and the classical algorithm both move crowds by uniform steps, so only the cost of the steps of all
        // other particles is compared; the factor 2 includes the test of about one listed pair per particle
        self.soft.fallback_cost(population, speeds, scene, window).map(|of_all| 2.0 * of_all)
    }

    fn judge(&mut self, population: &PopulationSummary, scene: &Scene, trial: &Trial) {
        self.soft.judge(population, scene, trial);
    }

    fn disturb(&mut self) {
        self.soft.disturb();
    }

    fn repopulate(&mut self) {
        self.soft.repopulate();
    }

    fn hand_over(&mut self, lasting: &mut Vec<Contact>) {
        self.soft.hand_over(lasting);
    }

    fn for_each_kept(&self, visit: &mut dyn FnMut(Contact)) {
        self.soft.for_each_kept(visit);
    }

    fn advance_all(&mut self, work: &mut Work<Contact>, window: Window) -> Result<(), Failure> {
        self.soft.advance_all(work, window)
    }

    fn counters(&self, islands: &IslandCounters) -> Counters {
        let soft = self.soft.counters(islands);
        Counters {
            steps: soft.steps + islands.crowd_steps,
            uniform_steps: soft.uniform_steps + islands.crowd_steps,
            events: islands.impulses,
            ..soft
        }
    }

    fn elastic_energy(&self) -> Option<f64> {
        self.soft.elastic_energy()
    }

    fn use_clock(&mut self, clock: Clock) {
        self.soft.use_clock(clock);
    }

    fn spent(&self, spent: EngineTimes) -> EngineTimes {
        self.soft.spent(spent)
    }

    fn state(&self) -> SoftState {
        self.soft.state()
    }

    fn resume(&mut self, state: SoftState) {
        self.soft.resume(state);
    }
}

impl DistributedSolver for HybridSolver {}
