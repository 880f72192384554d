//! Contact network of soft spheres: contacts per particle, fabric tensor, and the contacts with their forces.
//!
//! * Coordination number Z = (2 C + W)/N, with C contacts between N particles and W contacts with walls.
//! * Mechanical coordination number Z_m = (2 C + W - N₁)/(N - N₀ - N₁) (Thornton 2000, Géotechnique 50, 43). It leaves
//!   out the N₀ particles without contacts and the N₁ particles with one contact, which carry no force at rest.
//! * Fabric tensor Σ n n/C over the contacts between particles, with the unit normals n (Satake 1982). Its trace is 1.

use super::measurements::{Measurement, Observation, ObservedCurve, ObservedNumber, ObservedQuantity};
use super::{Needs, Observer};
use crate::contact_law::ContactLaw;
use crate::domain::Domain;
use crate::encounter::FrameTime;
use crate::exact::ExactSum;
use crate::experiment::Experiment;
use crate::schedule::Schedule;
use crate::simulation::Simulation;
use crate::statistics::estimate;
use crate::stored::{StoreError, Stored};
use nalgebra::Vector3;
use rustc_hash::FxHashMap;
use serde::{Deserialize, Serialize};

/// Largest number of samples (instants of measurement) that are used. In a run with more samples, only every n-th
/// sample is used.
const MOST_SAMPLES: u64 = 1000;
/// Length of a list whose entry k is the number of particles with k contacts. The last entry also counts particles with
/// more contacts.
const MOST_CONTACTS: usize = 25;
/// Names of the six components of the fabric tensor Σ n n/C over C contacts with unit normals n, each with the indices
/// of its two axes (0: x, 1: y, 2: z).
const COMPONENTS: [(&str, [usize; 2]); 6] =
    [("xx", [0, 0]), ("yy", [1, 1]), ("zz", [2, 2]), ("xy", [0, 1]), ("xz", [0, 2]), ("yz", [1, 2])];

/// Contact between two particles, or between a particle and a wall. It is drawn as a line between the two centres, or
/// from the centre to the wall.
#[derive(Clone, Debug, PartialEq)]
pub struct ContactLine {
    /// Id of the particle; of two particles the smaller id.
    pub id: u32,
    /// Id of the other particle; `None` at a wall.
    pub other: Option<u32>,
    /// [m] centre of the particle `id`, moved into the box along periodic axes.
    pub from: Vector3<f64>,
    /// [m] centre of the other particle (of its nearest image), or point of contact with a wall.
    pub to: Vector3<f64>,
    /// [-] unit normal, from the other body or the wall to the particle `id`.
    pub normal: Vector3<f64>,
    /// [N] elastic part of the normal force between the two bodies.
    pub force: f64,
}

impl ContactLine {
    /// Returns the contact with the particle of the smaller id as the first one. If the particles are exchanged, the
    /// normal is reversed.
    fn ordered(self, domain: &Domain) -> Self {
        let Some(other) = self.other.filter(|other| *other < self.id) else { return self };
        let (from, normal) = (domain.wrap(&self.to), -self.normal);
        let to = from + (self.from - self.to);
        Self { id: other, other: Some(self.id), from, to, normal, ..self }
    }

    /// Key by which contacts are sorted: ids of the bodies, and the point `to`. The order then does not depend on the
    /// order of the particles in memory. The point is needed because a particle may touch several walls.
    fn key(&self) -> (u32, u32, [u64; 3]) {
        (self.id, self.other.unwrap_or(u32::MAX), [self.to.x, self.to.y, self.to.z].map(f64::to_bits))
    }
}

/// Number of contacts of the particles, and means over all contacts, at one instant.
#[derive(Clone, Debug, Serialize, Deserialize)]
struct NetworkSample {
    /// [s] simulated time at which the contacts are counted.
    time: f64,
    /// Number of particles with k contacts, in the entry k; the last entry also counts particles with more contacts.
    by_contacts: Vec<u64>,
    /// Sum over all particles of the number of their contacts. A contact between two particles counts twice.
    ends: u64,
    /// [-] fabric tensor: mean of the products of two components of the unit normal over all contacts between
    /// particles, in the order of [`COMPONENTS`]; `None` without such a contact.
    fabric: Option<[f64; 6]>,
    /// [N] elastic part of the normal force, averaged over all contacts; `None` without a contact.
    force: Option<f64>,
}

/// Measurement of the contact network of soft spheres at several instants. A run of hard spheres, or of collisions by
/// chance (DSMC), has no lasting contacts, and nothing is measured.
#[derive(Clone, Debug)]
pub struct ContactNetwork {
    /// [s] time between two instants at which contacts are measured.
    interval: f64,
    law: Option<ContactLaw>,
    samples: Vec<NetworkSample>,
    /// Contacts between particles and with walls at the end of the run.
    lines: Vec<ContactLine>,
}

impl ContactNetwork {
    /// Creates the measurement for a run of `experiment`. `schedule` contains the instants of measurement.
    pub fn new(experiment: &Experiment, schedule: &Schedule) -> Self {
        let (interval, law) = (schedule.spacing(MOST_SAMPLES), experiment.law());
        Self { interval, law, samples: Vec::new(), lines: Vec::new() }
    }

    fn lines(&self, simulation: &Simulation) -> Vec<ContactLine> {
        self.law.map_or_else(Vec::new, |law| contact_lines(simulation, &law))
    }
}

/// Returns all present contacts of soft spheres, sorted by the ids of the particles. `law` is the contact law, which
/// gives the forces.
pub fn contact_lines(simulation: &Simulation, law: &ContactLaw) -> Vec<ContactLine> {
    let (particles, scene) = (&simulation.particles, simulation.scene());
    let mut lines = Vec::new();
    simulation.for_each_contact(|couple, overlap| {
        let met = couple.meet(particles, scene, FrameTime::default());
        let place = couple.i as usize;
        let radii = particles.radius[place] + couple.j().map_or(0.0, |j| particles.radius[j as usize]);
        let from = scene.domain.wrap(&particles.position[place]);
        let (force, _) = law.force(&law.between(&couple.bodies(particles, scene)), overlap, 0.0);
        let (id, other) = (particles.id[place], couple.j().map(|j| particles.id[j as usize]));
        let to = from - met.normal * (radii - overlap);
        lines.push(ContactLine { id, other, from, to, normal: met.normal, force }.ordered(&scene.domain));
    });
    lines.sort_by_key(ContactLine::key);
    lines
}

impl NetworkSample {
    fn of(simulation: &Simulation, lines: &[ContactLine]) -> Self {
        let mut contacts: FxHashMap<u32, usize> = FxHashMap::default();
        let (mut fabric, mut force) = (<[ExactSum; 6]>::default(), ExactSum::default());
        let mut pairs = 0.0;
        for line in lines {
            [Some(line.id), line.other].into_iter().flatten().for_each(|id| *contacts.entry(id).or_default() += 1);
            force.add(line.force);
            if line.other.is_some() {
                pairs += 1.0;
                for (sum, (_, [i, j])) in fabric.iter_mut().zip(COMPONENTS) {
                    sum.add(line.normal[i] * line.normal[j]);
                }
            }
        }
        let mut by_contacts = vec![0; MOST_CONTACTS];
        contacts.values().for_each(|count| by_contacts[(*count).min(MOST_CONTACTS - 1)] += 1);
        by_contacts[0] = simulation.count().saturating_sub(contacts.len()) as u64;
        Self {
            time: simulation.time,
            by_contacts,
            ends: contacts.values().map(|count| *count as u64).sum(),
            fabric: (pairs > 0.0).then(|| fabric.map(|sum| sum.value() / pairs)),
            force: (!lines.is_empty()).then(|| force.value() / lines.len() as f64),
        }
    }

    /// Number of all particles, with and without contacts.
    fn count(&self) -> f64 {
        self.by_contacts.iter().sum::<u64>() as f64
    }

    /// [-] mechanical coordination number: mean number of contacts of the particles that have two contacts or more.
    /// `None` if there is no such particle.
    fn mechanical(&self) -> Option<f64> {
        let (none, one) = (self.by_contacts[0] as f64, self.by_contacts[1] as f64);
        let carrying = self.count() - none - one;
        (carrying > 0.0).then(|| (self.ends as f64 - one) / carrying)
    }
}

impl Measurement for ContactNetwork {
    fn result(&self, _experiment: &Experiment, from: f64) -> Observation {
        // means over the particles need particles
        let has_any = |sample: &&NetworkSample| sample.time >= from && sample.count() > 0.0;
        let samples: Vec<&NetworkSample> = self.samples.iter().filter(has_any).collect();
        let clock = [samples.first().map_or(from, |sample| sample.time), self.interval];
        let number = |column: &str, symbol: &str, unit: &'static str, of: &dyn Fn(&NetworkSample) -> Option<f64>| {
            // samples without a contact have no force and no fabric
            let series: Vec<f64> = samples.iter().filter_map(|sample| of(sample)).collect();
            ObservedNumber::of_series(ObservedQuantity::new(column, symbol, unit), &series, clock, None)
        };
        let share = |k: usize| {
            let series = samples.iter().map(|sample| sample.by_contacts[k] as f64 / sample.count());
            estimate(&series.collect::<Vec<_>>())
        };
        let mut numbers = vec![
            number("coordination", "contacts per particle, Z", "", &|sample| Some(sample.ends as f64 / sample.count())),
            number(
                "mechanical_coordination",
                "Z of particles with two contacts or more",
                "",
                &NetworkSample::mechanical,
            ),
            number("rattlers", "share of particles with no contact or one", "", &|sample| {
                Some((sample.by_contacts[0] + sample.by_contacts[1]) as f64 / sample.count())
            }),
            number("mean_force_N", "mean normal force", "N", &|sample| sample.force),
        ];
        numbers.extend(COMPONENTS.iter().enumerate().map(|(k, (name, _))| {
            number(&format!("fabric_{name}"), &format!("fabric {name}"), "", &|sample| sample.fabric.map(|six| six[k]))
        }));
        let has_contacts = self.law.is_some();
        Observation {
            name: "contact_network",
            title: "Contact network",
            axis: ObservedQuantity::new("contacts", "contacts of a particle", ""),
            places: (0..MOST_CONTACTS).map(|k| k as f64).collect(),
            curves: vec![ObservedCurve {
                quantity: ObservedQuantity::new("share", "share of the particles", ""),
                values: (0..MOST_CONTACTS).map(share).collect(),
                theory: None,
                is_logarithmic: false,
            }],
            numbers,
            lines: self.lines.clone(),
            remark: (!has_contacts).then_some("Collisions of this model are instantaneous, and so it has no contacts."),
            ..Observation::default()
        }
    }
}

impl Observer for ContactNetwork {
    fn next(&self, now: f64, _schedule: &Schedule) -> Option<f64> {
        self.law.map(|_| now + self.interval)
    }

    fn needs(&self) -> Needs {
        Needs::Every(1)
    }

    fn see(&mut self, simulation: &Simulation) {
        if self.law.is_some() {
            self.samples.push(NetworkSample::of(simulation, &self.lines(simulation)));
        }
    }

    fn needs_at_end(&self, _now: f64) -> Needs {
        Needs::Every(1)
    }

    fn end(&mut self, simulation: &Simulation) {
        self.lines = self.lines(simulation);
    }

    fn stored(&self) -> Result<Stored, StoreError> {
        Stored::of(&self.samples)
    }

    fn restore(&mut self, stored: &Stored) -> Result<(), StoreError> {
        self.samples = stored.read()?;
        Ok(())
    }
}
