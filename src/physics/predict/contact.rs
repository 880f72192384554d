//! Duration of contacts and largest overlaps, and the longest time steps that they allow. The paper is that of
//! `docs/paper.md`.

use super::integrator::{Realised, Scheme, realised_restitution};
use crate::contact_law::{Bodies, ContactLaw, Spring};
use crate::experiment::{Amount, Experiment, Population};
use crate::neighbours::along_walls;
use crate::record::Histogram;
use crate::scene::Scene;
use nalgebra::Vector3;
use serde::Serialize;
use std::f64::consts::PI;

/// [-] largest allowed change of the distance of two colliding particles in one time step, over the diameter
/// (CFL_p^col in the paper, see `docs/paper.md`). The value is the lowest in the paper (Table 1, cases B and E). The
/// limit applies at the normal speed that 99 % of the impacts do not exceed.
const CFL_COLLISION: f64 = 0.01;

/// [-] largest allowed displacement of a particle in one time step, over the cell size of the grid of the gas (CFL_p
/// in the paper, Table 1).
const CFL_PARTICLE: f64 = 1.5;

/// Kind of contact: between particles of two species, or between a species and walls with the same surface properties.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct ContactKind {
    /// Names of the two touching bodies.
    pub name: String,
    /// True if one of the two touching bodies is a wall.
    pub wall: bool,
    /// Properties of the two bodies on which a contact law depends.
    #[serde(flatten)]
    pub bodies: Bodies,
    /// [m] diameter of the smaller particle, or of the particle at a wall. Overlaps are divided by this diameter.
    pub diameter: f64,
    /// Distribution of the normal speeds of impact.
    pub speeds: ImpactSpeeds,
}

/// Distribution of the normal speeds of the impacts of one kind of contact.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum ImpactSpeeds {
    /// Speeds in a Maxwellian gas. The normal speed u of impacts between particles or at walls has the density u/s²
    /// exp(-u²/(2s²)), with the variance s² of the relative normal velocity. If the velocity variance depends on
    /// position or direction, s² does too.
    Gas {
        /// [m²/s²] mean variance s² of the relative normal velocity. Between species p and q it is the sum T_p + T_q of
        /// their granular temperatures; at a wall it is T_p.
        variance: f64,
        /// [-] groups of impacts, each with its own variance s². The two numbers of a group are its share of all
        /// impacts, and its s over the root of the mean `variance`.
        #[serde(skip)]
        parts: Vec<[f64; 2]>,
    },
    /// Speeds counted in a short run with few particles, if their distribution is not Maxwellian.
    Measured {
        /// [m²/s²] variance s² of the relative normal velocity.
        variance: f64,
        /// [m/s] distribution of the counted normal speeds of impact.
        #[serde(skip)]
        speeds: Histogram,
    },
    /// Speed of the fastest impact that the energy of a few bodies allows.
    Bodies {
        /// [m/s] normal speed of the fastest impact that is possible.
        speed: f64,
    },
}

impl ImpactSpeeds {
    /// Makes the distribution in a gas that is the same everywhere and in all directions. `variance` [m²/s²] is that of
    /// the relative normal velocity: 2T between equal spheres, and T at a wall.
    pub fn isotropic(variance: f64) -> Self {
        Self::Gas { variance, parts: vec![[1.0, 1.0]] }
    }

    /// [m/s] quantile of the normal speeds of impact: the speed below which the fraction `q` [-] of the impacts lies.
    pub fn quantile(&self, q: f64) -> f64 {
        match self {
            Self::Gas { variance, parts } => {
                let faster = |speed: f64| -> f64 {
                    let one = |[share, s]: &[f64; 2]| share * (-0.5 * (speed / s).powi(2)).exp();
                    parts.iter().filter(|[_, s]| *s > 0.0).map(one).sum()
                };
                let widest = parts.iter().map(|[_, s]| *s).fold(0.0, f64::max);
                let (mut low, mut high) = (0.0, widest * (-2.0 * (1.0 - q).ln()).sqrt());
                for _ in 0..60 {
                    let middle = 0.5 * (low + high);
                    if faster(middle) > 1.0 - q { low = middle } else { high = middle }
                }
                high * variance.sqrt()
            }
            Self::Measured { variance, speeds } => {
                speeds.quantile(q).unwrap_or_else(|| Self::isotropic(*variance).quantile(q))
            }
            Self::Bodies { speed } => *speed,
        }
    }

    /// [m/s] mean normal speed of impact. In a gas it is s sqrt(π/2), with the variance s² of the relative normal
    /// velocity; between equal spheres it is sqrt(πT).
    pub fn mean(&self) -> f64 {
        match self {
            Self::Gas { variance, parts } => {
                (0.5 * PI * variance).sqrt() * parts.iter().map(|[share, s]| share * s).sum::<f64>()
            }
            Self::Measured { variance, speeds } => speeds.mean().unwrap_or_else(|| Self::isotropic(*variance).mean()),
            Self::Bodies { speed } => *speed,
        }
    }

    /// Mean of the normal speed of impact to the power `p` [(m/s)^p]. In a gas it is s^p 2^(p/2) Γ(1 + p/2), with the
    /// variance s² of the relative normal velocity.
    pub fn mean_power(&self, p: f64) -> f64 {
        /// Number of quantiles by which a measured distribution of speeds is represented.
        const QUANTILES: u32 = 256;
        match self {
            // a linear spring requires p = 1, since its overlaps are proportional to the speed
            _ if p == 1.0 => self.mean(),
            Self::Gas { variance, parts } => {
                let unit = (2.0 * variance).powf(0.5 * p) * libm::tgamma(1.0 + 0.5 * p);
                unit * parts.iter().map(|[share, s]| share * s.powf(p)).sum::<f64>()
            }
            Self::Measured { .. } => {
                let middle = |k: u32| (f64::from(k) + 0.5) / f64::from(QUANTILES);
                (0..QUANTILES).map(|k| self.quantile(middle(k)).powf(p)).sum::<f64>() / f64::from(QUANTILES)
            }
            Self::Bodies { speed } => speed.powf(p),
        }
    }

    /// [m/s] mean relative speed u_r (Eq. 8 of the paper, see `docs/paper.md`, corrected): the mean of the normal
    /// relative speed over random pairs. It is s sqrt(2/π), with the variance s² of the relative normal velocity;
    /// between equal spheres it is sqrt(4T/π) with the granular temperature T.
    pub fn of_random_pairs(&self) -> f64 {
        match self {
            Self::Gas { variance, .. } | Self::Measured { variance, .. } => (2.0 / PI * variance).sqrt(),
            // for a few bodies no ratio of u_r to this speed is known, so the ratio for a gas is used
            Self::Bodies { speed } => 2.0 / PI * speed,
        }
    }
}

/// Predictions for one kind of contact, under a contact law.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct ContactPrediction {
    /// Two bodies of the contact, and distribution of the speeds of their impacts.
    #[serde(flatten)]
    pub contact: ContactKind,
    /// [N/m] stiffness of a linear spring; for Hertz's law the constant k_H [N/m^1.5].
    pub stiffness: f64,
    /// [s] contact time T_c (Eq. 7 of the paper, see `docs/paper.md`). If it depends on the speed, it is the contact
    /// time at the mean speed of impact.
    pub contact_time: f64,
    /// [-] overlap number κ_n: largest overlap of an elastic impact at the mean relative speed u_r, over the diameter
    /// d. For a linear spring it is u_r/d sqrt(M/k_n), with the effective mass M, the stiffness k_n and u_r =
    /// sqrt(4T/π).
    pub kappa: f64,
    /// [m/s] mean normal speed of the impacts of this kind.
    pub impact_speed: f64,
    /// [-] largest overlap of an impact, divided by the diameter; mean over all impacts.
    pub mean_overlap: f64,
    /// [-] largest overlap of an impact, divided by the diameter; 99 % of the impacts have a smaller value.
    pub overlap_99: f64,
    /// [-] number of time steps per contact N_c, at the chosen time step.
    pub steps: f64,
    /// [-] mean restitution that time steps of the chosen integrator give; `None` if the contact does not end.
    pub realised_restitution: Option<f64>,
    /// [-] mean square of the restitution that time steps of the chosen integrator give; `None` if the contact does not
    /// end.
    pub realised_mean_square: Option<f64>,
}

/// Lists all possible kinds of contact of a scene. `counts` holds the number of particles of each species. `pair`
/// returns the distribution of impact speeds for the indices of two species, and `at_wall` returns that for the index
/// of a species at a wall. Walls count as one kind of contact if they are equal in all of [`Bodies`]. A species with one
/// particle has no contact with itself. A restitution that depends on the speed is taken at the mean speed of the
/// impacts.
pub fn contacts(
    scene: &Scene,
    counts: &[usize],
    pair: impl Fn(usize, usize) -> ImpactSpeeds,
    at_wall: impl Fn(usize) -> ImpactSpeeds,
) -> Vec<ContactKind> {
    let mut found = Vec::new();
    let there = |species: usize, least: usize| counts.get(species).copied().unwrap_or(0) >= least;
    for (p, one) in scene.species.iter().enumerate() {
        for (q, other) in scene.species.iter().enumerate().skip(p) {
            if !there(p, if p == q { 2 } else { 1 }) || !there(q, 1) {
                continue;
            }
            let speeds = pair(p, q);
            found.push(ContactKind {
                name: if p == q { format!("{} pair", one.name) } else { format!("{} with {}", one.name, other.name) },
                wall: false,
                bodies: Bodies::between(scene, p as u16, q as u16).at_speed(speeds.mean()),
                diameter: one.diameter.min(other.diameter),
                speeds,
            });
        }
        let pairs = found.len();
        for wall in (0..scene.walls.len() as u32).filter(|_| there(p, 1)) {
            let speeds = at_wall(p);
            let bodies = Bodies::beside(scene, p as u16, wall).at_speed(speeds.mean());
            if found[pairs..].iter().any(|known: &ContactKind| known.bodies == bodies) {
                continue;
            }
            let name = format!("{} at a wall", one.name);
            found.push(ContactKind { name, wall: true, bodies, diameter: one.diameter, speeds });
        }
    }
    found
}

impl ContactKind {
    /// Constants of a contact law for the two bodies of this kind of contact.
    pub fn spring(&self, law: &ContactLaw) -> Spring {
        law.between(&self.bodies)
    }

    /// [m] largest overlap of an impact of this kind of contact at the normal speed `speed` [m/s].
    pub fn largest_overlap(&self, law: &ContactLaw, speed: f64) -> f64 {
        law.greatest_overlap(&self.spring(law), speed)
    }

    /// [-] overlap number κ_n of this kind of contact: largest overlap of an elastic impact at the mean relative speed
    /// u_r, over the diameter.
    pub fn kappa(&self, law: &ContactLaw) -> f64 {
        let elastic = law.between(&self.bodies.elastic());
        law.greatest_overlap(&elastic, self.speeds.of_random_pairs()) / self.diameter
    }

    /// [-] factor by which the elastic constant of the law must increase so that 99 % of the impacts have overlaps
    /// below `overlap` [-], which is relative to the diameter.
    pub fn stiffening_for(&self, law: &ContactLaw, overlap: f64) -> f64 {
        let now = self.largest_overlap(law, self.speeds.quantile(0.99)) / self.diameter;
        law.stiffening(now / overlap)
    }

    /// [-] overlap of a contact at rest that carries `force` [N], divided by the diameter.
    pub fn static_overlap(&self, law: &ContactLaw, force: f64) -> f64 {
        law.static_overlap(&self.spring(law), force) / self.diameter
    }

    /// [s] contact time of an impact at the mean normal speed of this kind of contact.
    pub fn contact_time(&self, law: &ContactLaw) -> f64 {
        law.contact_time(&self.spring(law), self.speeds.mean())
    }

    /// Predicts contacts of this kind under `law`, for a time step of `time_step` [s] and the integrator `scheme`.
    pub fn predict(&self, law: &ContactLaw, time_step: f64, scheme: Scheme) -> ContactPrediction {
        let contact_time = self.contact_time(law);
        let steps = contact_time / time_step;
        let realised: Option<Realised> =
            realised_restitution(scheme, law, (&self.spring(law), self.speeds.mean()), steps);
        let overlap = |speed: f64| self.largest_overlap(law, speed) / self.diameter;
        ContactPrediction {
            contact: self.clone(),
            stiffness: self.spring(law).stiffness,
            contact_time,
            kappa: self.kappa(law),
            impact_speed: self.speeds.mean(),
            mean_overlap: overlap(1.0) * self.speeds.mean_power(2.0 / (law.exponent() + 1.0)),
            overlap_99: overlap(self.speeds.quantile(0.99)),
            steps,
            realised_restitution: realised.map(|e| e.mean),
            realised_mean_square: realised.map(|e| e.mean_square),
        }
    }
}

/// All possible kinds of contact of an experiment, each with the normal speed of its fastest impacts.
pub fn at_fastest_impacts(experiment: &Experiment) -> Vec<ContactKind> {
    let speed = fastest_impact(experiment);
    let speeds = || ImpactSpeeds::Bodies { speed };
    contacts(&experiment.scene, &experiment.counts(), |_, _| speeds(), |_| speeds())
}

/// Shortest possible contact times of a scene [s], which the time step must resolve. Contact times differ between
/// pairs and walls, because the effective masses differ.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ContactTimes {
    /// [s] shortest contact time of two particles; `None` if there are fewer than two particles.
    pub pair: Option<f64>,
    /// [s] shortest contact time of a particle at any wall; `None` without walls or particles.
    pub wall: Option<f64>,
}

impl ContactTimes {
    /// Computes the shortest contact times of an experiment with `particles` particles, at the fastest impacts.
    pub fn of(experiment: &Experiment, law: &ContactLaw, particles: usize) -> Self {
        // contacts of the smallest possible spheres are the shortest
        let extremes = experiment.scene.at_extremes();
        let (scene, speed) = (&extremes[0], fastest_impact(experiment));
        let time = |bodies: Bodies| law.contact_time(&law.between(&bodies.at_speed(speed)), speed);
        let pairs = scene.meetings().filter(|_| particles > 1);
        let pairs = pairs.map(|(one, other, _)| time(Bodies::between(scene, one, other)));
        let walls = scene.meetings_at_walls().filter(|_| particles > 0);
        let walls = walls.map(|(one, wall, _)| time(Bodies::beside(scene, one, wall)));
        Self { pair: pairs.min_by(f64::total_cmp), wall: walls.min_by(f64::total_cmp) }
    }

    /// [s] shortest contact time of pairs and walls; `None` if no contact is possible.
    pub fn governing(&self) -> Option<f64> {
        self.pair.into_iter().chain(self.wall).min_by(f64::total_cmp)
    }
}

/// [-] velocity fluctuation of particles in a channel flow, divided by the gas velocity on the centre plane. The ratio
/// was measured in the channel cases of this project (0.4 m/s at 17.7 m/s).
pub const AGITATION: f64 = 0.025;

/// [m/s] speed of impact that is assumed for bodies that do not move at all: the speed after a fall from 1 µm.
const AT_REST: f64 = 5e-3;

/// [m/s] normal speed that hardly any impact of an experiment exceeds; always positive. It is estimated from the
/// velocities at the start and at inlets, gravity, the gas, the shear of the box and the speed of walls that move.
///
/// For laws whose contacts last longer at lower speed, the time step is computed from this speed. The duration of a
/// Hertzian contact is proportional to u^(-1/5), so an error of a factor of two in the speed changes the step by 13 %.
pub fn fastest_impact(experiment: &Experiment) -> f64 {
    /// [-] ratio u/σ that one in a million collisions in a Maxwellian gas exceeds: exp(-u²/(4σ²)) is 1e-6. Here u is
    /// the relative normal velocity, and σ the standard deviation of a velocity component of a particle.
    const FASTEST: f64 = 7.5;
    let scene = &experiment.scene;
    let frame = along_walls(scene, mean_velocity(&experiment.start));
    let drawn = |streams: f64, mean: &Vector3<f64>, fluctuation: &Vector3<f64>| {
        streams * (mean - frame).norm() + FASTEST * fluctuation.max()
    };
    // two populations, or the particles of an inlet and others, may fly against each other
    let streams = if experiment.start.len() > 1 { 2.0 } else { 1.0 };
    let start = experiment.start.iter().map(|population| match &population.amount {
        Amount::Placed(placed) => 2.0 * placed.velocity.iter().map(|v| (v - frame).norm()).fold(0.0, f64::max),
        Amount::Count(_) => drawn(streams, &population.velocity_mean, &population.velocity_fluctuation),
    });
    let coming = scene.inlets.iter().map(|inlet| drawn(2.0, &inlet.velocity_mean, &inlet.velocity_fluctuation));
    let sheared = scene.domain.strain_rate() * scene.largest_diameter();
    let start = start.chain(coming).fold(AT_REST, f64::max) + 2.0 * scene.wall_speed() + sheared;
    let gas = scene.fluid.as_ref().map_or(0.0, |fluid| fluid.profile.velocity(0.5 * scene.domain.size.y).abs());
    (start * start + 2.0 * fall(scene) + (FASTEST * AGITATION * gas).powi(2)).sqrt()
}

/// [m/s] normal speed of a usual impact of an experiment; always positive. Predictions evaluate a restitution that
/// depends on the speed at this value. The value is the root of the sum of the squares of three speeds:
///
/// * the mean speed of impact in a gas with the velocity fluctuation σ of the start, sqrt(π) σ. For particles with
///   listed velocities it is the largest speed, without the common motion along walls. The speeds of moving walls and
///   of the shear over a diameter are added;
/// * the speed after a fall through half of the box;
/// * the mean speed of impact at the agitation that a channel flow maintains.
pub fn usual_impact(scene: &Scene, start: &[Population]) -> f64 {
    let frame = along_walls(scene, mean_velocity(start));
    let drawn = start.iter().map(|population| match &population.amount {
        Amount::Placed(placed) => placed.velocity.iter().map(|v| (v - frame).norm()).fold(0.0, f64::max),
        Amount::Count(_) => (PI / 3.0).sqrt() * population.velocity_fluctuation.norm(),
    });
    let sheared = scene.domain.strain_rate() * scene.largest_diameter();
    let drawn = drawn.fold(0.0, f64::max) + scene.wall_speed() + sheared;
    let gas = scene.fluid.as_ref().map_or(0.0, |fluid| fluid.profile.velocity(0.5 * scene.domain.size.y).abs());
    let speed = (drawn * drawn + fall(scene) + PI * (AGITATION * gas).powi(2)).sqrt();
    if speed > 0.0 { speed } else { AT_REST }
}

/// [m²/s²] square of the speed after a fall from rest through half of the box. Only the components of gravity along
/// axes that are not periodic count.
fn fall(scene: &Scene) -> f64 {
    let axes = (0..3).filter(|axis| !scene.domain.periodic[*axis]);
    axes.map(|axis| scene.gravity[axis].abs() * scene.domain.size[axis]).sum()
}

/// [m/s] mean velocity of all particles at the start. It is subtracted from velocities, because a common motion along
/// walls causes no impacts.
fn mean_velocity(start: &[Population]) -> Vector3<f64> {
    let sum = |population: &Population| match &population.amount {
        Amount::Placed(placed) => placed.velocity.iter().sum(),
        Amount::Count(count) => population.velocity_mean * *count as f64,
    };
    let count: usize = start.iter().map(|population| population.amount.count()).sum();
    start.iter().map(sum).sum::<Vector3<f64>>() / count.max(1) as f64
}

/// Limit on the time step of soft spheres (section 3.4 of the paper, see `docs/paper.md`).
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct StepLimit {
    /// Name of the process that the time step must resolve.
    pub name: String,
    /// [s] longest time step with which the process `name` is resolved.
    pub longest: f64,
}

/// Quantities of a run from which the limits on the time step of soft spheres are computed.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct StepScales {
    /// [-] number of time steps per contact, N_c.
    pub steps_per_contact: f64,
    /// [m/s] largest speed of any particle.
    pub speed: f64,
    /// [s] window h: time between two exchanges of momentum with the gas. It is the time step of the gas.
    pub window: f64,
    /// [m] smallest edge of a cell of the grid of the gas; `None` if the gas has no grid.
    pub fluid_cell: Option<f64>,
}

/// All limits on the time step of soft spheres, the shortest first. The first one determines the time step. `springs`
/// are the limits due to tangential, rolling and twisting springs.
pub fn step_limits(contacts: &[ContactPrediction], springs: Vec<StepLimit>, motion: &StepScales) -> Vec<StepLimit> {
    let mut limits = Vec::new();
    for row in contacts {
        limits.push(StepLimit {
            name: format!("contact, T_c/N_c: {}", row.contact.name),
            longest: row.contact_time / motion.steps_per_contact,
        });
        let speed = row.contact.speeds.quantile(0.99);
        if speed > 0.0 {
            limits.push(StepLimit {
                name: format!("overlap at first sight, {CFL_COLLISION} d/u_n: {}", row.contact.name),
                longest: CFL_COLLISION * row.contact.diameter / speed,
            });
        }
    }
    if let Some(cell) = motion.fluid_cell.filter(|_| motion.speed > 0.0) {
        let longest = CFL_PARTICLE * cell / motion.speed;
        limits.push(StepLimit { name: format!("particle over gas cell, {CFL_PARTICLE} dx/u_p"), longest });
    }
    limits.extend(springs);
    limits.push(StepLimit { name: "fluid step, the window h".into(), longest: motion.window });
    limits.sort_by(|a, b| a.longest.total_cmp(&b.longest));
    limits
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Pair of the small spheres of the paper in `docs/paper.md` (406 µm, 1038 kg/m³), at the granular temperature T
    /// of its case D, computed from the mean relative speed u_r = 0.79 m/s.
    fn pair() -> ContactKind {
        ContactKind {
            name: "S pair".into(),
            wall: false,
            bodies: Bodies {
                effective_mass: 0.5 * 3.6372577e-8,
                effective_radius: 0.25 * 406e-6,
                restitution: 1.0,
                by_speed: None,
                elasticity: [None; 2],
                stiffness_ratio: 1.0,
            },
            diameter: 406e-6,
            speeds: ImpactSpeeds::isotropic(2.0 * 0.4902),
        }
    }

    /// Compares predicted overlaps with those of a Rayleigh distribution of impact speeds, computed independently for
    /// three stiffnesses. The granular temperature T is given with four digits.
    #[test]
    fn overlaps_in_a_gas() {
        for (stiffness, mean, most) in
            [(300.0, 0.023798, 0.057625), (3000.0, 0.007525, 0.018223), (30000.0, 0.002380, 0.005762)]
        {
            let row = pair().predict(
                &ContactLaw::linear(stiffness),
                1e-7,
                Scheme::of(crate::experiment::Integrator::Rk2, crate::experiment::SoftStepping::Uniform),
            );
            assert!((row.mean_overlap / mean - 1.0).abs() < 5e-4, "{row:?}");
            assert!((row.overlap_99 / most - 1.0).abs() < 5e-4, "{row:?}");
            // the mean overlap is π/2 κ_n
            assert!((row.mean_overlap / row.kappa - 0.5 * PI).abs() < 1e-12);
            assert!((pair().stiffening_for(&ContactLaw::linear(stiffness), row.overlap_99) - 1.0).abs() < 1e-12);
        }
        // overlap number κ_n of the paper's case D
        let scheme =
            Scheme::of(crate::experiment::Integrator::VelocityVerlet, crate::experiment::SoftStepping::Uniform);
        assert!((pair().predict(&ContactLaw::linear(3000.0), 1e-6, scheme).kappa / 0.004791 - 1.0).abs() < 5e-4);
        assert!((pair().predict(&ContactLaw::linear(3000.0), 1e-6, scheme).steps - 7.735).abs() < 1e-3);
    }

    #[test]
    fn the_shortest_limit_comes_first() {
        let scheme = Scheme::of(crate::experiment::Integrator::VelocityVerlet, crate::experiment::SoftStepping::Local);
        let rows = [pair().predict(&ContactLaw::linear(3000.0), 1e-7, scheme)];
        let motion = StepScales { steps_per_contact: 20.0, speed: 15.0, window: 1e-4, fluid_cell: Some(1e-5) };
        let limits = step_limits(&rows, Vec::new(), &motion);
        assert_eq!(limits.len(), 4);
        assert!(limits[0].name.contains("T_c/N_c") && (limits[0].longest / 3.8675e-7 - 1.0).abs() < 1e-4);
        let still = step_limits(&rows, Vec::new(), &StepScales { fluid_cell: None, window: 1e-9, ..motion });
        assert_eq!(still.len(), 3);
        assert!(still[0].name.contains("window"));
    }
}
