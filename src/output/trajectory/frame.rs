//! Data of one frame (instant) of a trajectory, and the formats of its file. The store of a simulation is the memory
//! with the data of all its particles.

use super::vtp::Vtp;
use crate::domain::Domain;
use crate::simulation::Simulation;
use nalgebra::Vector3;
use std::borrow::Cow;
use std::fmt::Write;

/// Code, in a trajectory file, of a particle that moved along a straight line in the window (time between two exchanges
/// with the gas) before the instant of the file.
const FLEW: u8 = 0;
/// Code, in a trajectory file, of a particle in an island: a group of particles that may touch each other within a part
/// of a window (time between two exchanges with the gas).
const ISLAND: u8 = 1;
/// Code, in a trajectory file, of a particle that was moved together with all other particles, by uniform steps or one
/// event queue.
const EVERYONE: u8 = 2;

/// Particles at one instant, for a trajectory file. The memory is reused from instant to instant.
#[derive(Debug, Default)]
pub(super) struct TrajectoryFrame {
    /// [s] simulated time of the instant.
    pub time: f64,
    position: Vec<Vector3<f64>>,
    velocity: Vec<Vector3<f64>>,
    /// [rad/s] spins of the particles; `None` if spheres do not rotate.
    spin: Option<Vec<Vector3<f64>>>,
    id: Vec<u32>,
    /// One entry for each particle in each contact: index of the particle in the store (memory with all particles), and
    /// overlap [m].
    contacts: Vec<(u32, f64)>,
    /// Indices of the particles in islands (groups of particles that may touch each other); `None` if all particles
    /// were moved together.
    islands: Option<Vec<u32>>,
    /// Further data of each particle, in the order of the ids. They are available after [`sort`](Self::sort).
    own: Vec<Own>,
}

/// Constant data of all particles (id, radius and species), for trajectory files.
#[derive(Debug)]
pub(super) struct Cast {
    domain: Domain,
    id: Vec<u32>,
    /// [m] radii of the particles, which do not change during a run.
    radius: Vec<f64>,
    species: Vec<u16>,
}

impl Cast {
    /// Copies the constant data of the particles, in the order of the particle store. [`sort`](Self::sort) sorts them
    /// by id later.
    pub(super) fn of(simulation: &Simulation) -> Self {
        let particles = &simulation.particles;
        Self {
            domain: simulation.scene().domain.clone(),
            id: particles.id.clone(),
            radius: particles.radius.clone(),
            species: particles.species.clone(),
        }
    }

    /// Sorts the data in the order of the ids of the particles.
    pub(super) fn sort(&mut self) {
        let (id, radius, species) = (self.id.clone(), self.radius.clone(), self.species.clone());
        for (index, rank) in ranks(&id).iter().enumerate() {
            let rank = *rank as usize;
            (self.id[rank], self.radius[rank], self.species[rank]) = (id[index], radius[index], species[index]);
        }
    }
}

/// Rank of each particle, which is its position, from 0, when the particles are sorted by id. The ids must be distinct.
/// If the ids of N particles are 0 to N - 1, each rank is the id.
fn ranks(ids: &[u32]) -> Cow<'_, [u32]> {
    let count = ids.len() as u32;
    if ids.iter().all(|id| *id < count) {
        return Cow::Borrowed(ids);
    }
    let mut order: Vec<u32> = (0..count).collect();
    order.sort_unstable_by_key(|index| ids[*index as usize]);
    let mut ranks = vec![0; ids.len()];
    for (rank, index) in (0..).zip(order) {
        ranks[index as usize] = rank;
    }
    Cow::Owned(ranks)
}

/// Data of one particle at one instant of a trajectory, which can be sorted by id.
#[derive(Clone, Copy, Debug, Default)]
struct Own {
    /// Index of the particle in the store (memory with the data of all particles).
    index: u32,
    /// [m] largest overlap among the contacts of the particle.
    overlap: f64,
    contacts: u16,
    solver: u8,
}

impl TrajectoryFrame {
    /// Copies the data of one instant from the simulation, in the order of the particle store. [`sort`](Self::sort)
    /// sorts the data by id later.
    pub(super) fn take(&mut self, simulation: &Simulation) {
        let particles = &simulation.particles;
        self.time = simulation.time;
        self.position.clone_from(&particles.position);
        self.velocity.clone_from(&particles.velocity);
        self.spin.clone_from(&particles.spin);
        self.id.clone_from(&particles.id);
        self.contacts.clear();
        simulation.for_each_contact(|couple, overlap| {
            self.contacts.extend(couple.indices().into_iter().flatten().map(|index| (index, overlap)));
        });
        self.contacts.extend(simulation.contacts_abroad());
        self.islands = simulation.in_islands().map(<[u32]>::to_vec);
    }

    /// Sorts the particles by id. The functions `vtp` and `xyz` require sorted particles.
    pub(super) fn sort(&mut self) {
        let Self { own, id, islands, contacts, .. } = self;
        let ranks = ranks(id);
        let solver = if islands.is_some() { FLEW } else { EVERYONE };
        own.resize(id.len(), Own::default());
        for (index, rank) in (0..).zip(&*ranks) {
            own[*rank as usize] = Own { index, solver, ..Own::default() };
        }
        for index in islands.iter().flatten() {
            own[ranks[*index as usize] as usize].solver = ISLAND;
        }
        for (index, overlap) in contacts {
            let own = &mut own[ranks[*index as usize] as usize];
            own.overlap = own.overlap.max(*overlap);
            own.contacts += 1;
        }
    }

    /// File of one instant in the format VTK PolyData, as three parts to be written one after the other. The bytes of
    /// `memory` are overwritten, so that no new memory is needed.
    pub(super) fn vtp(&self, cast: &Cast, memory: Vec<u8>) -> [Vec<u8>; 3] {
        self.arrays(cast, memory).finish()
    }

    /// Contents of the file that joins the pieces of one instant. A piece is a file with the particles of one process.
    /// `time` [s] is the simulated time. The pieces contain spins if `rotate` is true. `pieces` has the names of their
    /// files.
    pub(super) fn joined(time: f64, rotate: bool, pieces: impl Iterator<Item = String>) -> Vec<u8> {
        let domain = Domain::new(Vector3::repeat(1.0), [false; 3]);
        let nobody = Cast { domain, id: Vec::new(), radius: Vec::new(), species: Vec::new() };
        Self { spin: rotate.then(Vec::new), ..Self::default() }.arrays(&nobody, Vec::new()).join(time, pieces)
    }

    fn arrays(&self, cast: &Cast, memory: Vec<u8>) -> Vtp {
        let own = &self.own;
        let count = own.len();
        let mut file = Vtp::begin(memory, self.time, [count, usize::from(count > 0), 0]);
        file.part("PointData", |file| {
            file.array::<f64, 3>("velocity", own.iter().map(|own| self.velocity[own.index as usize].into()));
            if let Some(spins) = &self.spin {
                file.array::<f64, 3>("spin", own.iter().map(|own| spins[own.index as usize].into()));
            }
            file.array("radius", cast.radius.iter().map(|radius| [*radius]));
            file.array("id", cast.id.iter().map(|id| [*id]));
            file.array("species", cast.species.iter().map(|species| [*species]));
            file.array("overlap", own.iter().map(|own| [own.overlap]));
            file.array("contacts", own.iter().map(|own| [own.contacts]));
            file.array("solver", own.iter().map(|own| [own.solver]));
        });
        let wrapped = own.iter().map(|own| cast.domain.wrap(&self.position[own.index as usize]).into());
        file.part("Points", |file| file.array::<f64, 3>("Points", wrapped));
        // all points belong to one vertex cell, because viewers draw only cells
        file.part("Verts", |file| {
            file.array("connectivity", (0..count as i32).map(|id| [id]));
            file.array("offsets", (count > 0).then_some([count as i32]).into_iter());
        });
        file
    }

    /// File of one instant in the format extended XYZ, with units m, s and m/s.
    pub(super) fn xyz(&self, cast: &Cast) -> Vec<u8> {
        let own = &self.own;
        let [x, y, z]: [f64; 3] = cast.domain.size.into();
        // in a sheared box, the periodic image above is displaced along z
        let tilt = cast.domain.at(self.time).offset().map_or("0".to_string(), |offset| format!("{offset:?}"));
        let [px, py, pz] = cast.domain.periodic.map(|periodic| if periodic { 'T' } else { 'F' });
        let mut text = String::with_capacity(200 * (own.len() + 1));
        // writing to a string cannot fail
        let _ = writeln!(
            text,
            "{}\nLattice=\"{x:?} 0 0 0 {y:?} {tilt} 0 0 {z:?}\" \
             Properties=pos:R:3:velo:R:3:radius:R:1:id:I:1:type:I:1:overlap:R:1:contacts:I:1:solver:I:1{} \
             Time={:?} pbc=\"{px} {py} {pz}\" units=\"m s\" source=\"diptych {}\"",
            own.len(),
            if self.spin.is_some() { ":omega:R:3" } else { "" },
            self.time,
            env!("CARGO_PKG_VERSION")
        );
        for (rank, own) in own.iter().enumerate() {
            let index = own.index as usize;
            let (position, velocity) = (cast.domain.wrap(&self.position[index]), self.velocity[index]);
            for number in position.iter().chain(&velocity).chain([&cast.radius[rank]]) {
                let _ = write!(text, "{number:?} ");
            }
            // numbers of types (species) in the file begin with 1
            let kind = u32::from(cast.species[rank]) + 1;
            let id = cast.id[rank];
            let _ = write!(text, "{id} {kind} {:?} {} {}", own.overlap, own.contacts, own.solver);
            for number in self.spin.iter().flat_map(|spins| &spins[index]) {
                let _ = write!(text, " {number:?}");
            }
            text.push('\n');
        }
        text.into_bytes()
    }
}
