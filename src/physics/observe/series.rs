//! Time series of averages over all particles of a run. A sample is an instant at which measurements are taken.

use super::velocity_distribution::Sonine;
use super::{Needs, Observer, plain_data};
use crate::domain::Domain;
use crate::experiment::Experiment;
use crate::particles::Sample;
use crate::record::FrictionLosses;
use crate::schedule::Schedule;
use crate::simulation::Simulation;
use crate::statistics::VelocitySpread;
use crate::walls::ServoState;
use nalgebra::Vector3;
use serde::{Deserialize, Serialize};

/// Largest number of rows (instants) of a time series, for runs of any duration. A picture cannot show more rows.
const MOST: u64 = 1000;

/// Smallest number of rows (instants) that is sufficient for a curve over time. A scene with few particles gets this
/// number of rows even if it has fewer samples (instants of measurement).
const CURVE: u64 = 200;

/// Largest number of particles for which rows of a time series may be more frequent than samples (instants of
/// measurement). A row of so few particles takes little computing time.
const FEW: usize = 10_000;

/// Averages over all particles at one instant: a row of the time series.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Row {
    /// [s] simulated time of the row.
    pub time: f64,
    /// [m²/s²] parts of the granular temperature T along x, y and z, relative to the mean velocities of slices; T is
    /// the mean of the three. `None` if every slice contains at most one particle.
    pub temperature: Option<Vector3<f64>>,
    /// [m/s] mean velocity of all particles; relative to the mean flow in a sheared box.
    pub velocity: Vector3<f64>,
    /// [J] kinetic energy of the translation of all particles.
    pub kinetic_energy: f64,
    /// [J] elastic energy stored in the springs of all contacts.
    pub elastic_energy: f64,
    /// Rotation of the particles; `None` if spheres do not rotate.
    pub rotation: Option<RotationSums>,
    /// Losses by friction, and energies of springs in contacts; `None` if spheres do not rotate.
    pub friction: Option<FrictionSums>,
    /// Turbulence of the gas at the positions of the particles; `None` if turbulence does not act on the particles.
    pub turbulence: Option<TurbulenceMeans>,
    /// Flow of a gas on which the particles act; `None` if the particles do not change the gas flow.
    pub gas: Option<GasMeans>,
    /// Stress in a sheared box; `None` without shear.
    pub shear: Option<ShearStress>,
    /// State of the first servo wall, a wall that moves so that the pressure on it is constant; `None` without servo
    /// walls.
    pub servo: Option<ServoState>,
    /// [J] energy that a thermostat (heating of particles from outside) and thermal walls have given to the particles
    /// since the start; `None` without any of them.
    pub thermostat_work: Option<f64>,
    /// Number of particles at this instant; `None` in a scene without inlets and outlets.
    pub particles: Option<u64>,
    /// Sonine coefficients a₂ and a₃ of the velocity distribution; `None` unless the case asks for this distribution.
    pub sonine: Option<Sonine>,
    /// [kg m/s] momentum of all particles.
    pub momentum: Vector3<f64>,
    /// Number of finished impacts between particles since the start.
    pub pair_impacts: u64,
    /// Number of finished impacts on walls since the start.
    pub wall_impacts: u64,
    /// [-] coordination number: number of present contacts per particle, with other particles and with walls. It is 0
    /// if contacts have no duration.
    pub coordination: f64,
    /// [-] largest overlap of all present contacts, divided by the diameter of the smaller particle.
    pub largest_overlap: f64,
    /// [m] centre of mass along x, y and z. `None` without particles, and along a periodic axis, where no centre of
    /// mass is defined.
    pub centre: [Option<f64>; 3],
}

/// Component yz of the stress in a sheared box, and the work of shear. For a positive shear rate the stress is
/// negative, because the particles carry momentum along z downwards. The power of this stress on the particles is -rate
/// times stress times volume.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct ShearStress {
    /// [J] work of the shear on the particles since the start.
    pub work: f64,
    /// [Pa] kinetic part of the stress: Σ m c_y c_z divided by the volume of the box, with the masses m of the
    /// particles and their velocities c relative to the mean flow.
    pub kinetic: f64,
    /// [Pa] part of the stress by contacts and collisions, averaged over the time since the previous row of the time
    /// series; `None` in the first row.
    pub contact: Option<f64>,
    /// [J s] time integral of Σ r_y f_z since the start, over the pairs in contact, with the vector r between their
    /// centres and the force f. For a collision, the impulse takes the place of the time integral of f.
    pub(super) virial: f64,
}

impl ShearStress {
    /// Returns the stress in a sheared box at the present instant; `None` without shear. `before` is the previous row
    /// of the time series; `None` at the start.
    pub(super) fn of(simulation: &Simulation, before: Option<&Row>) -> Option<Self> {
        let domain = &simulation.scene().domain;
        domain.shear?;
        let (relative, ledger) = (simulation.relative_to_flow(), &simulation.record.ledger);
        let sample = simulation.sample().with(&relative);
        let [mass, y, z, yz] = sample.sums(|place| {
            let (c, m) = (relative.velocity[place], relative.mass[place]);
            [m, m * c.y, m * c.z, m * c.y * c.z]
        });
        let virial = ledger.pair_virial[(1, 2)];
        let since = |row: &Row| Some((virial - row.shear?.virial) / (simulation.time - row.time) / domain.volume());
        let kinetic = if mass > 0.0 { (yz - y * z / mass) / domain.volume() } else { 0.0 };
        Some(Self { work: ledger.shear_work, kinetic, contact: before.and_then(since), virial })
    }
}

/// Energy lost to friction since the start, and energy stored in the springs of contacts.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct FrictionSums {
    /// [J] energy lost to sliding friction since the start.
    pub sliding: f64,
    /// [J] other energies lost to friction since the start: by tangential restitution, in springs, by rolling and by
    /// twisting.
    pub losses: FrictionLosses,
    /// [J] energies stored in the tangential, the rolling and the twisting springs of contacts.
    pub springs: [f64; 3],
}

impl FrictionSums {
    fn of(simulation: &Simulation) -> Option<Self> {
        simulation.scene().rotation.as_ref()?;
        let springs = simulation.spring_energies();
        let ledger = &simulation.record.ledger;
        Some(Self { sliding: ledger.sliding_loss(), losses: ledger.friction, springs })
    }
}

/// Rotation of all particles at one instant.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct RotationSums {
    /// [J] rotational energy of all particles.
    pub energy: f64,
    /// [m²/s²] parts of the rotational temperature T_r along x, y and z: Σ I (ω - Ω)²/Σ m per component. Each particle
    /// has the mass m, the moment of inertia I and the spin ω, and the mean spin is Ω = Σ I ω/Σ I. T_r is the mean of
    /// the three parts. It equals the granular temperature if rotation and translation have equal energies.
    pub temperature: Vector3<f64>,
    /// [rad/s] mean spin Ω = Σ I ω/Σ I of the particles, weighted by their moments of inertia I.
    pub spin: Vector3<f64>,
}

impl RotationSums {
    fn of(sample: Sample, mass: f64) -> Option<Self> {
        let particles = sample.particles;
        let (spins, inertia) = (particles.spin.as_ref()?, particles.inertia.as_ref()?);
        let sums = sample.sums(|place| {
            let (own, spin) = (inertia[place], spins[place]);
            let (moment, square) = (spin * own, spin.component_mul(&spin) * own);
            [own, moment.x, moment.y, moment.z, square.x, square.y, square.z]
        });
        let [all, x, y, z, xx, yy, zz] = sums;
        let (moment, squares) = (Vector3::new(x, y, z), Vector3::new(xx, yy, zz));
        let spin = if all > 0.0 { moment / all } else { Vector3::zeros() };
        let about = squares - spin.component_mul(&moment);
        let temperature = if mass > 0.0 { about / mass } else { Vector3::zeros() };
        Some(Self { energy: 0.5 * squares.sum(), temperature, spin })
    }
}

/// Turbulence of the gas at the positions of the particles, averaged over all particles and the three components. u is
/// the fluctuation of the gas velocity at the position of a particle.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct TurbulenceMeans {
    /// [m²/s²] variance of a component of the gas velocity at the positions of the particles: 2k/3, with the turbulent
    /// kinetic energy k.
    pub of_gas: f64,
    /// [m²/s²] mean square of the fluctuation u of the gas velocity at the positions of the particles.
    pub seen: f64,
    /// [m²/s²] mean product of the fluctuation u of the gas velocity and the particle velocity relative to the mean gas
    /// velocity. It is a third of the covariance q_fp of Simonin (1996).
    pub covariance: f64,
}

impl TurbulenceMeans {
    fn of(simulation: &Simulation) -> Option<Self> {
        let fluid = simulation.scene().fluid.as_ref()?;
        let turbulence = fluid.turbulence.as_ref()?;
        let sample = simulation.sample();
        let particles = sample.particles;
        let eddies = particles.eddies.as_deref().unwrap_or_default();
        let sums = sample.sums(|place| {
            let position = &particles.position[place];
            let local = turbulence.at(&fluid.profile, position);
            let deviation = local.deviation;
            let seen = eddies.get(place).map_or_else(Vector3::zeros, |eddy| turbulence.seen(eddy, &local));
            let gas = Vector3::new(0.0, 0.0, fluid.profile.velocity_at(position));
            let covariance = seen.dot(&(particles.velocity[place] - gas));
            [deviation * deviation, seen.norm_squared() / 3.0, covariance / 3.0]
        });
        let [of_gas, seen, covariance] = sums.map(|sum| sum / simulation.count().max(1) as f64);
        Some(Self { of_gas, seen, covariance })
    }
}

/// Flow of a gas on which the particles act (two-way coupling), at one instant.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct GasMeans {
    /// [Pa/m] pressure drop of the gas per length in its latest time step, without the hydrostatic part.
    pub pressure_gradient: f64,
    /// [m/s] flow rate of the gas divided by the area of the cross-section.
    pub bulk_velocity: f64,
    /// [m/s] friction velocity of the gas; negative if the gas flows backwards at the wall.
    pub friction_velocity: f64,
    /// [kg m/s] momentum of the gas in the box along z.
    pub momentum: f64,
}

impl GasMeans {
    fn of(simulation: &Simulation) -> Option<Self> {
        let flow = simulation.loaded_flow()?;
        Some(Self {
            pressure_gradient: flow.pressure_gradient(),
            bulk_velocity: flow.bulk_velocity(),
            friction_velocity: flow.friction_velocity(),
            momentum: flow.balance.now,
        })
    }
}

impl Row {
    /// [J] sum of the kinetic, rotational and elastic energy of all particles.
    pub fn energy(&self) -> f64 {
        self.kinetic_energy + self.elastic_energy + self.rotation.map_or(0.0, |rotation| rotation.energy)
    }

    /// [m²/s²] rotational temperature T_r; `None` if spheres do not rotate.
    pub fn rotational_temperature(&self) -> Option<f64> {
        self.rotation.map(|rotation| rotation.temperature.sum() / 3.0)
    }

    /// Returns the averages over all particles at the present instant. `before` is the previous row of the time
    /// series. The granular temperature is relative to the mean velocities of `slices` equal slices along y.
    fn of(simulation: &Simulation, slices: usize, before: Option<&Self>) -> Self {
        let (time, sample) = (simulation.time, simulation.sample());
        let touching = simulation.touching();
        Self {
            elastic_energy: simulation.elastic_energy(),
            friction: FrictionSums::of(simulation),
            turbulence: TurbulenceMeans::of(simulation),
            gas: GasMeans::of(simulation),
            shear: ShearStress::of(simulation, before),
            servo: simulation.servo_states().first().copied(),
            particles: simulation.scene().has_openings().then_some(simulation.count() as u64),
            thermostat_work: simulation.scene().is_heated().then_some(simulation.record.ledger.thermostat_work),
            pair_impacts: simulation.record.pairs.count,
            wall_impacts: simulation.record.walls.count,
            coordination: touching.ends as f64 / simulation.count().max(1) as f64,
            largest_overlap: touching.largest_overlap,
            ..Self::of_sample(time, sample, simulation.mean_velocity(), (&simulation.scene().domain, slices))
        }
    }

    /// Returns the averages over the particles of `sample` at `time` [s], with 0 for contacts and impacts. The
    /// granular temperature is relative to the mean velocities of `slices` equal slices along y. Sums are taken
    /// relative to `reference` [m/s], a velocity near the mean. In a sheared box, temperature and mean velocity are
    /// relative to the mean flow.
    pub fn of_sample(time: f64, sample: Sample, reference: Vector3<f64>, (domain, slices): (&Domain, usize)) -> Self {
        let relative = sample.particles.relative_to_flow(domain);
        let spread = VelocitySpread::about(reference, sample.with(&relative), slices, domain.size.y);
        let sums = MassSums::of(sample);
        let centre = |axis: usize| (!domain.periodic[axis] && sums.mass > 0.0).then(|| sums.moment[axis] / sums.mass);
        Self {
            time,
            temperature: spread.components(),
            velocity: spread.mean(),
            kinetic_energy: sums.kinetic_energy,
            elastic_energy: 0.0,
            rotation: RotationSums::of(sample, sums.mass),
            friction: None,
            turbulence: None,
            gas: None,
            shear: None,
            servo: None,
            thermostat_work: None,
            particles: None,
            sonine: None,
            momentum: sums.momentum,
            pair_impacts: 0,
            wall_impacts: 0,
            coordination: 0.0,
            largest_overlap: 0.0,
            centre: std::array::from_fn(centre),
        }
    }

    /// [m²/s²] granular temperature T of all particles; `None` if every slice contains at most one particle.
    pub fn granular_temperature(&self) -> Option<f64> {
        self.temperature.map(|parts| parts.sum() / 3.0)
    }
}

/// Mass, momentum and kinetic energy of all particles, and the sum of their masses times positions.
struct MassSums {
    /// [kg] mass of all particles.
    mass: f64,
    /// [kg m] sum of mass times position over all particles.
    moment: Vector3<f64>,
    /// [kg m/s] momentum of all particles.
    momentum: Vector3<f64>,
    /// [J] kinetic energy of all particles.
    kinetic_energy: f64,
}

impl MassSums {
    fn of(sample: Sample) -> Self {
        let particles = sample.particles;
        let sums = sample.sums(|place| {
            let (mass, velocity) = (particles.mass[place], particles.velocity[place]);
            let (moment, momentum) = (particles.position[place] * mass, velocity * mass);
            let energy = 0.5 * mass * velocity.norm_squared();
            [mass, moment.x, moment.y, moment.z, momentum.x, momentum.y, momentum.z, energy]
        });
        let [mass, x, y, z, px, py, pz, kinetic_energy] = sums;
        Self { mass, moment: Vector3::new(x, y, z), momentum: Vector3::new(px, py, pz), kinetic_energy }
    }
}

/// [s] time between two rows of a series with at most `most` rows. It is a whole number of sample intervals or, with
/// fewer than `least` samples, of windows (times between two exchanges with the gas). The schedule may prescribe
/// instants that all variants of a case (models or settings that are compared) have in common. Their interval, or a
/// multiple of it, is used instead if it is shorter, or if it gives enough rows for a curve.
pub(super) fn interval(schedule: &Schedule, least: u64, most: u64) -> f64 {
    let between = |all: u64, rows: u64| all.div_ceil(rows.max(1)).max(1) as f64;
    let own = if schedule.samples >= least {
        between(schedule.samples, most) * schedule.interval()
    } else {
        between(schedule.length(), least.min(most)) * schedule.window
    };
    let duration = schedule.length() as f64 * schedule.window;
    let asked = schedule.instants.map(|every| between((duration / every).ceil() as u64, most) * every);
    asked.map_or(own, |asked| if duration / asked >= CURVE as f64 - 0.5 { asked } else { asked.min(own) })
}

/// Averages over all particles at times that are equal in all variants of a case (models or settings that are
/// compared). The series has at most a thousand rows (instants), and one more row at the end of the run.
#[derive(Clone, Debug, Default, Serialize, Deserialize)]
pub struct Series {
    /// Number of slices along y. Velocities in the granular temperature are relative to the mean velocity of their
    /// slice.
    slices: usize,
    /// [s] time between two rows of the series.
    interval: f64,
    /// True if rows contain the Sonine coefficients of the velocity distribution.
    has_sonine: bool,
    /// Rows of the series in the order of time.
    pub rows: Vec<Row>,
}

impl Series {
    /// Creates the observer for a run of `experiment`. The instants of the rows are chosen from those of `schedule`.
    pub fn new(experiment: &Experiment, schedule: &Schedule) -> Self {
        let least = if experiment.count() <= FEW { CURVE } else { 0 };
        Self {
            slices: experiment.statistics.slices,
            interval: interval(schedule, least, MOST),
            has_sonine: experiment.observe.velocity_distribution.is_some(),
            rows: Vec::new(),
        }
    }
}

impl Series {
    /// True if the last row is earlier than `time` [s], or if there are no rows.
    fn lacks(&self, time: f64) -> bool {
        self.rows.last().is_none_or(|row| row.time < time)
    }
}

impl Observer for Series {
    fn next(&self, now: f64, _schedule: &Schedule) -> Option<f64> {
        Some(now + self.interval)
    }

    fn needs(&self) -> Needs {
        Needs::Sums
    }

    fn see(&mut self, simulation: &Simulation) {
        let sonine = if self.has_sonine { Sonine::of(simulation, self.slices) } else { None };
        self.rows.push(Row { sonine, ..Row::of(simulation, self.slices, self.rows.last()) });
    }

    fn needs_at_end(&self, now: f64) -> Needs {
        if self.lacks(now) { Needs::Sums } else { Needs::Nothing }
    }

    fn end(&mut self, simulation: &Simulation) {
        if self.lacks(simulation.time) {
            self.see(simulation);
        }
    }

    plain_data!();
}
