//! Particles that leave through outlets and come in through inlets, at the ends of windows (times between two exchanges
//! with the gas). The ledger is the sum of all work and losses since the start.

use super::Simulation;
use super::totals::SimulationTotals;
use crate::communicator::Communicator;
use crate::exact::{ExactSum, none, values};
use crate::particles::{Particles, Sample};
use crate::record::Ledger;
use crate::scene::Scene;
use nalgebra::Vector3;
use serde::{Deserialize, Serialize};

/// Number of sums over the particles that have passed through an opening (inlet or outlet): mass, momentum along x, y
/// and z, kinetic, rotational and potential energy, and speed.
const SUMS: usize = 8;

/// Sums over the particles that have passed through an inlet or outlet since the start.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct FlowTotals {
    /// Number of particles that have passed through the inlet or outlet.
    pub count: u64,
    /// [kg] total mass of the particles that have passed through the inlet or outlet.
    pub mass: f64,
    /// [kg m/s] total momentum of the particles at the times when they came in or left.
    pub momentum: Vector3<f64>,
    /// [J] total kinetic energy of translation of the particles at the times when they came in or left.
    pub kinetic_energy: f64,
    /// [J] total rotational energy of the particles at the times when they came in or left.
    pub rotational_energy: f64,
    /// [J] sum of the potential energies -m g·x of the particles at the times when they came in or left. Here m is the
    /// mass, g the acceleration by gravity, and x the position inside the box. This energy is not part of the energy
    /// balance, where the work of gravity takes its place.
    pub potential_energy: f64,
    /// [m/s] sum of the speeds of the particles at the times when they came in or left.
    pub speed: f64,
}

/// Flow through one inlet or outlet since the start, with exact sums, which do not depend on the order of the
/// particles.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub struct OpeningFlow {
    count: u64,
    sums: [ExactSum; SUMS],
    /// Number of particles that are due at an inlet and have not found a place; 0 at an outlet.
    waiting: u64,
    /// Largest number of particles that waited at an inlet at one time.
    most_waiting: u64,
}

impl Default for OpeningFlow {
    fn default() -> Self {
        Self { count: 0, sums: none(), waiting: 0, most_waiting: 0 }
    }
}

impl OpeningFlow {
    /// Sums over the particles that have passed through this inlet or outlet since the start, each rounded once.
    pub fn totals(&self) -> FlowTotals {
        let [mass, x, y, z, kinetic_energy, rotational_energy, potential_energy, speed] = values(&self.sums);
        let (count, momentum) = (self.count, Vector3::new(x, y, z));
        FlowTotals { count, mass, momentum, kinetic_energy, rotational_energy, potential_energy, speed }
    }

    /// Number of particles that wait at an inlet for a place, and the largest number that waited at one time.
    pub fn waiting(&self) -> [u64; 2] {
        [self.waiting, self.most_waiting]
    }

    /// Sets the number of particles that now wait at an inlet for a place. Also raises the largest number that waited
    /// at one time, if the new number exceeds it.
    pub(super) fn set_waiting(&mut self, waiting: u64) {
        self.waiting = waiting;
        self.most_waiting = self.most_waiting.max(waiting);
    }

    /// Number of particles that have passed through this inlet or outlet since the start.
    pub(super) fn count(&self) -> u64 {
        self.count
    }

    /// Adds the particle at `index` to the sums. Returns the entry in the ledger (sums of energies and momenta) for a
    /// particle that comes into the scene. For a particle that leaves, the entry must get the opposite sign.
    pub(super) fn add(&mut self, particles: &Particles, index: usize, scene: &Scene) -> Ledger {
        let (mass, velocity) = (particles.mass[index], particles.velocity[index]);
        let momentum = velocity * mass;
        let moment = particles.inertia.as_ref().map_or(0.0, |inertia| inertia[index]);
        let kinetic = 0.5 * mass * velocity.norm_squared();
        let rotational = 0.5 * moment * particles.spin_of(index).norm_squared();
        // the store may hold an image beyond a periodic side, by which gravity along that axis must not count
        let potential = -mass * scene.gravity.dot(&scene.domain.wrap(&particles.position[index]));
        let [x, y, z] = momentum.into();
        let amounts = [mass, x, y, z, kinetic, rotational, potential, velocity.norm()];
        self.sums.iter_mut().zip(amounts).for_each(|(sum, amount)| sum.add(amount));
        self.count += 1;
        Ledger { flow_energy: kinetic + rotational, flow_impulse: momentum, ..Ledger::default() }
    }
}

/// Particles that have come in and left since the start of a run, and the id of the next particle that comes in.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub struct ThroughFlow {
    /// Id of the next particle that comes in: the largest id so far plus one. `None` if 32 bits cannot hold this
    /// number; no particle comes in then.
    next_id: Option<u32>,
    /// Flow through each outlet of the scene.
    pub outlets: Vec<OpeningFlow>,
    /// Flow through each inlet of the scene.
    pub inlets: Vec<OpeningFlow>,
    /// [J] exact sum of the elastic energies of contacts that ended because one of the particles left the scene.
    cut: ExactSum,
}

impl ThroughFlow {
    /// Creates the state before the first window (time between two exchanges with the gas). Ids above the largest id
    /// in `particles` are free.
    pub(super) fn new(scene: &Scene, particles: &Particles) -> Self {
        let next_id = particles.id.iter().max().map_or(Some(0), |largest| largest.checked_add(1));
        let closed = |count: usize| vec![OpeningFlow::default(); count];
        Self {
            next_id,
            outlets: closed(scene.outlets.len()),
            inlets: closed(scene.inlets.len()),
            cut: ExactSum::default(),
        }
    }

    /// [J] elastic energy of the contacts that ended because one of the particles left the scene, since the start.
    pub fn cut_energy(&self) -> f64 {
        self.cut.value()
    }

    /// Id of the next particle that comes in: the largest id so far plus one. `None` if 32 bits cannot hold this
    /// number.
    pub(super) fn next_id(&self) -> Option<u32> {
        self.next_id
    }

    /// Takes the largest of the next ids of all processes that share the run, each of which has a part of the particles.
    /// All processes must call this function.
    pub(super) fn agree(&mut self, communicator: &dyn Communicator) {
        /// Larger than any id; stands for the case that all ids are used.
        const USED_UP: f64 = 4_294_967_296.0; // 2³²
        let mut next = [self.next_id.map_or(USED_UP, f64::from)];
        communicator.largest(&mut next);
        self.next_id = (next[0] < USED_UP).then_some(next[0] as u32);
    }

    /// Marks the smallest free id as taken, so that the next particle gets the id after it.
    pub(super) fn take_id(&mut self) {
        self.next_id = self.next_id.and_then(|id| id.checked_add(1));
    }
}

impl Simulation {
    /// Particles that have come in and left; `None` in a scene without inlets and outlets.
    pub fn through_flow(&self) -> Option<&ThroughFlow> {
        self.through_flow.as_deref()
    }

    /// Lets particles leave through outlets and come in through inlets at the end of a window, and updates engine,
    /// ledger and totals. A window is the time between two exchanges with the gas. Velocities may lack the change by
    /// drag in half a window when this method is called.
    pub(super) fn exchange_particles(&mut self) {
        let Some(mut flow) = self.through_flow.take() else { return };
        // all particles are in the lead process
        if !self.is_follower() {
            let leaving = self.leaving(&flow);
            let coming = self.incoming(&mut flow, &leaving);
            if !leaving.is_empty() || !coming.0.is_empty() {
                self.replace(&mut flow, &leaving, coming);
            }
        }
        self.through_flow = Some(flow);
    }

    /// Particles that leave now: the index of each in [`particles`](Simulation::particles), and the index of its
    /// outlet, in ascending order of the particles. A particle that is in several outlets leaves through the first
    /// one.
    fn leaving(&self, flow: &ThroughFlow) -> Vec<(u32, usize)> {
        if flow.outlets.is_empty() {
            return Vec::new();
        }
        let domain = &self.scene.domain;
        let outlet_of = |position: &Vector3<f64>| {
            let inside = domain.wrap(position);
            self.scene.outlets.iter().position(|outlet| outlet.takes(&inside))
        };
        let positions = (0u32..).zip(&self.particles.position);
        positions.filter_map(|(index, position)| Some((index, outlet_of(position)?))).collect()
    }

    /// Removes the particles that leave and appends the particles that come in, which are already counted at their
    /// inlets.
    fn replace(
        &mut self,
        flow: &mut ThroughFlow,
        leaving: &[(u32, usize)],
        (fresh, mut entries): (Particles, Vec<Ledger>),
    ) {
        for &(index, outlet) in leaving {
            entries.push(-flow.outlets[outlet].add(&self.particles, index as usize, &self.scene));
        }
        let mut index_of = vec![None; self.particles.len()];
        let mut gone = leaving.iter().map(|(index, _)| *index).peekable();
        let stays = |index: &u32| gone.next_if_eq(index).is_none();
        let order: Vec<u32> = (0..self.particles.len() as u32).filter(stays).collect();
        (0u32..).zip(&order).for_each(|(new, old)| index_of[*old as usize] = Some(new));
        self.particles.reorder(&order);
        self.particles.copy_from(&fresh, &(0..fresh.len() as u32).collect::<Vec<_>>());
        let cut = self.engine.repopulate(&index_of);
        flow.cut.add(cut);
        entries.push(Ledger { flow_energy: -cut, ..Ledger::default() });
        self.record.ledger.add(&entries.iter().map(Ledger::to_array).collect::<Vec<_>>());
        self.totals = SimulationTotals::of(&Sample::from(&self.particles));
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::domain::Domain;
    use crate::scene::{Species, Surface};

    /// Checks the potential energy of a particle that leaves, in a box of 1 m with periodic sides. The store may hold
    /// the particle at 1.25 m or at 0.25 m; both are the same place.
    #[test]
    fn potential_energy_is_that_inside_the_box() {
        let mut scene = Scene::new(
            Domain::new(Vector3::repeat(1.0), [true; 3]),
            Surface::new(1.0, 0.0),
            vec![Species::new("S", 0.01, 1000.0)],
        );
        scene.gravity = Vector3::new(0.0, -10.0, 0.0);
        for height in [0.25, 1.25, -0.75] {
            let (mut flow, mut particles) = (OpeningFlow::default(), Particles::default());
            particles.push(Vector3::new(0.5, height, 0.5), Vector3::zeros(), 0.005, 2.0, 0);
            flow.add(&particles, 0, &scene);
            assert_eq!(flow.totals().potential_energy, 5.0, "{height}");
        }
    }
}
