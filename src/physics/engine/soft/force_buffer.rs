//! Buffer of contact forces, and their application to the particles. The forces are in the order of slots, the numbers
//! of the candidates (pairs, or particles and walls) in the neighbour list.

use super::block::reserve;
use crate::particles::Particles;
use crate::work_sharing;
use nalgebra::Vector3;
use serde::{Deserialize, Serialize};
use std::num::NonZeroU32;
use std::ops::Range;

/// Force of one contact, to be applied to its particles.
#[derive(Clone, Copy, Debug, Serialize, Deserialize)]
pub struct ForceIncrement {
    /// Index of the particle on which the force acts.
    pub i: u32,
    /// Index of the particle that gets the opposite force; `None` at a wall.
    pub j: Option<StoreIndex>,
    /// [N] contact force on particle i; particle j gets the opposite force.
    pub force: Vector3<f64>,
}

/// Torques of one contact on its two bodies.
#[derive(Clone, Copy, Debug, Default, Serialize, Deserialize)]
pub struct ContactTorque {
    /// [N] torque of the tangential force on each of the two particles, divided by the radius of that particle.
    pub over_radius: Vector3<f64>,
    /// [N m] torque of rolling and twisting resistance on particle i; the other particle gets the opposite torque.
    /// `None` without such resistance.
    pub couple: Option<Vector3<f64>>,
}

impl ContactTorque {
    /// Torques of the same contact with its two bodies in the opposite order.
    pub fn reversed(self) -> Self {
        Self { couple: self.couple.map(|couple| -couple), ..self }
    }
}

/// Index in the particle store. An `Option` of this type takes no more memory than an index.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct StoreIndex(NonZeroU32);

impl StoreIndex {
    /// Makes the index from the number `index`, which must be below 2³² - 1.
    pub fn of(index: u32) -> Self {
        Self(NonZeroU32::MIN.saturating_add(index))
    }

    /// This index as a number.
    pub fn get(self) -> u32 {
        self.0.get() - 1
    }
}

/// Forces of contacts, in the order of the candidates in the neighbour list.
#[derive(Clone, Debug, Default, Serialize, Deserialize)]
pub struct ForceBuffer {
    /// Forces; if a particle occurs more than once, its forces are applied in this order.
    pub list: Vec<ForceIncrement>,
    /// [N] for each force, its torque on each of the two particles, divided by the radius of that particle; empty if
    /// spheres do not rotate.
    torques: Vec<Vector3<f64>>,
    /// [N m] torque of rolling and twisting resistance of each contact on particle i; empty if contacts have no such
    /// resistance.
    couples: Vec<Vector3<f64>>,
    /// Range of indices in the particle store that contains the indices of all particles in `list`.
    span: Range<u32>,
}

/// Empty range: it contains the index of no particle.
const NO_PARTICLES: Range<u32> = Range { start: u32::MAX, end: 0 };

/// Returns the range `span` of indices, extended to contain the particles of one more force.
#[inline]
fn wider(span: &Range<u32>, push: &ForceIncrement) -> Range<u32> {
    let other = push.j.map_or(push.i, StoreIndex::get);
    let (least, most) = (push.i.min(other), push.i.max(other));
    span.start.min(least)..span.end.max(most + 1)
}

impl ForceBuffer {
    /// Buffer with the forces and torques of several buffers, in their order.
    pub fn merged<'a>(buffers: impl IntoIterator<Item = &'a Self>) -> Self {
        let mut pushes = Self::default();
        buffers.into_iter().flat_map(Self::iter).for_each(|(push, torque)| match torque {
            Some(torque) => pushes.add_rotating(push, torque),
            None => pushes.add(push),
        });
        pushes
    }

    /// Forces in the order of the list, each with its torques, or with `None` if spheres do not rotate.
    pub fn iter(&self) -> impl Iterator<Item = (ForceIncrement, Option<ContactTorque>)> {
        let torque = |k: usize| {
            let couple = self.couples.get(k).copied();
            self.torques.get(k).map(|over_radius| ContactTorque { over_radius: *over_radius, couple })
        };
        self.list.iter().enumerate().map(move |(k, push)| (*push, torque(k)))
    }

    /// Adds a contact force at the end of the list, with the torques of this contact.
    #[inline(always)]
    pub fn add_rotating(&mut self, push: ForceIncrement, torque: ContactTorque) {
        self.add(push);
        self.torques.push(torque.over_radius);
        if let Some(couple) = torque.couple {
            self.couples.push(couple);
        }
    }

    /// Adds a contact force at the end of the list.
    pub fn add(&mut self, push: ForceIncrement) {
        self.span = if self.list.is_empty() { wider(&NO_PARTICLES, &push) } else { wider(&self.span, &push) };
        self.list.push(push);
    }

    /// Removes all forces, and reserves memory for `room` new forces.
    pub fn clear(&mut self, room: usize) {
        self.list.clear();
        reserve(&mut self.list, room);
        self.torques.clear();
        self.couples.clear();
    }

    /// Keeps only the forces on chosen particles: those at whose index `chosen` is true. At least one particle of each
    /// contact must be chosen. If only the second particle j is chosen, j becomes the first particle i of the entry,
    /// and the force changes its sign.
    pub fn leave(&mut self, chosen: &[bool]) {
        let is_chosen = |index: u32| chosen[index as usize];
        for (k, push) in self.list.iter_mut().enumerate() {
            match push.j {
                Some(j) if !is_chosen(push.i) => {
                    *push = ForceIncrement { i: j.get(), j: None, force: -push.force };
                    self.couples.get_mut(k).into_iter().for_each(|couple| *couple = -*couple);
                }
                _ => push.j = push.j.filter(|j| is_chosen(j.get())),
            }
        }
    }

    /// Applies a new order of the particle store: the particle that was at index `p` is now at `index_of[p]`.
    pub fn reorder(&mut self, index_of: &[u32]) {
        self.span = NO_PARTICLES;
        for push in &mut self.list {
            push.i = index_of[push.i as usize];
            push.j = push.j.map(|j| StoreIndex::of(index_of[j.get() as usize]));
            self.span = wider(&self.span, push);
        }
    }

    /// Changes the velocities [m/s] of a block of particles by force/mass times `dt` [s], and their spins by the
    /// torques. `mass` returns the mass [kg] of a particle. Returns the square [m²/s²] of the largest speed, relative
    /// to `frame` [m/s], that a particle had after a force was applied.
    pub fn kick(&self, part: &mut VelocityBlock, mass: impl Fn(usize) -> f64, dt: f64, frame: Vector3<f64>) -> f64 {
        let mut most = 0.0f64;
        let indices = part.first..part.first + part.velocities.len();
        if self.list.is_empty() || indices.start >= self.span.end as usize || self.span.start as usize >= indices.end {
            return most;
        }
        let mut push = |index: u32, force: Vector3<f64>| {
            // an index below `first` becomes a huge number, which is beyond the end of the block
            let Some(v) = part.velocities.get_mut((index as usize).wrapping_sub(part.first)) else { return };
            *v += force / mass(index as usize) * dt;
            most = most.max((*v - frame).norm_squared());
        };
        let mut torques = self.torques.iter();
        let Some(Spins { spins, per_torque }) = &mut part.spins else {
            for ForceIncrement { i, j, force } in &self.list {
                push(*i, *force);
                if let Some(j) = j {
                    push(j.get(), -force);
                }
            }
            return most;
        };
        let mut turn = |index: u32, torque: &Vector3<f64>, couple: Option<Vector3<f64>>| {
            let Some(spin) = spins.get_mut((index as usize).wrapping_sub(indices.start)) else { return };
            *spin += torque * (per_torque.of(index as usize) * dt);
            if let Some(couple) = couple {
                *spin += couple * (per_torque.of_couple(index as usize) * dt);
            }
        };
        let mut couples = self.couples.iter().copied();
        for ForceIncrement { i, j, force } in &self.list {
            let torque = torques.next().copied().unwrap_or_default();
            let couple = couples.next();
            push(*i, *force);
            turn(*i, &torque, couple);
            if let Some(j) = j {
                push(j.get(), -force);
                turn(j.get(), &torque, couple.map(|couple| -couple));
            }
        }
        most
    }
}

/// Velocities of particles with successive indices in the store.
pub struct VelocityBlock<'a> {
    /// Index of the first particle in the store.
    pub first: usize,
    /// [m/s] velocities of the particles, in the order of the store.
    pub velocities: &'a mut [Vector3<f64>],
    /// Spins of the particles; `None` if spheres do not rotate.
    pub spins: Option<Spins<'a>>,
}

/// Spins of particles with successive indices in the store.
pub struct Spins<'a> {
    /// [rad/s] spins of the particles, in the order of the store.
    pub spins: &'a mut [Vector3<f64>],
    /// Radius over moment of inertia of the particles, by which torques become angular accelerations.
    pub per_torque: PerTorque<'a>,
}

/// Radius over moment of inertia, r/I [1/(kg m)], of particles. A torque divided by the radius, times r/I, is an
/// angular acceleration.
#[derive(Clone, Copy)]
pub enum PerTorque<'a> {
    /// r/I [1/(kg m)] and 1/I [1/(kg m²)], equal for all particles.
    Common(f64, f64),
    /// Radii [m] and moments of inertia [kg m²] of all particles.
    Each(&'a [f64], &'a [f64]),
}

impl PerTorque<'_> {
    /// r/I [1/(kg m)] of the particle at `index`.
    #[inline(always)]
    fn of(&self, index: usize) -> f64 {
        match self {
            Self::Common(ratio, _) => *ratio,
            Self::Each(radii, inertia) => radii[index] / inertia[index],
        }
    }

    /// 1/I [1/(kg m²)] of the particle at `index`.
    #[inline(always)]
    fn of_couple(&self, index: usize) -> f64 {
        match self {
            Self::Common(_, inverse) => *inverse,
            Self::Each(_, inertia) => 1.0 / inertia[index],
        }
    }
}

/// Number of forces up to which a single thread applies all of them. A force takes about 10 ns, and waking a thread
/// takes a few thousand ns.
const FEW: usize = 1024;

/// Applies the forces to all particles: v += a `dt`, with the acceleration a and the time `dt` [s]. Changes the spins
/// by the torques. `common` [kg] is the mass of each particle if masses, radii and moments of inertia are equal for
/// all, otherwise `None`. Each velocity is changed by one thread only, which applies its forces in the order of the
/// neighbour list. Returns the largest speed [m/s], relative to `frame` [m/s], that a particle had after a force was
/// applied.
pub fn kick_all(
    pushes: &[ForceBuffer],
    (particles, common): (&mut Particles, Option<f64>),
    dt: f64,
    frame: Vector3<f64>,
) -> f64 {
    let Particles { velocity, spin, inertia, mass: masses, radius: radii, .. } = particles;
    let inertia = inertia.as_deref().unwrap_or_default();
    let per_torque = match (common, radii.first(), inertia.first()) {
        (Some(_), Some(radius), Some(inertia)) => PerTorque::Common(radius / inertia, 1.0 / inertia),
        _ => PerTorque::Each(radii, inertia),
    };
    let each = |first: usize, velocities: &mut [Vector3<f64>], spins: Option<&mut [Vector3<f64>]>| {
        let mut part = VelocityBlock { first, velocities, spins: spins.map(|spins| Spins { spins, per_torque }) };
        let largest = |most: f64, block: &ForceBuffer| {
            most.max(match common {
                Some(mass) => block.kick(&mut part, |_| mass, dt, frame),
                None => block.kick(&mut part, |index| masses[index], dt, frame),
            })
        };
        pushes.iter().fold(0.0, largest)
    };
    let count: usize = pushes.iter().map(|block| block.list.len()).sum();
    let threads = rayon::current_num_threads();
    let most = if count <= FEW || threads == 1 {
        each(0, velocity, spin.as_deref_mut())
    } else {
        let part = velocity.len().div_ceil(2 * threads);
        let mut spins = spin.as_deref_mut().map(|spins| spins.chunks_mut(part));
        let mut next = || spins.as_mut().and_then(Iterator::next);
        let parts: Vec<_> = velocity.chunks_mut(part).map(|velocities| (velocities, next())).enumerate().collect();
        let each = |(k, (velocities, spins))| each(k * part, velocities, spins);
        work_sharing::map(parts.into_iter(), each).into_iter().fold(0.0, f64::max)
    };
    most.sqrt()
}
