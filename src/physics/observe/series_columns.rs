//! Columns of the averages over time. The file `series.csv`, verdicts (tests whether two runs differ) and pictures use
//! these columns.

use super::series::{FrictionSums, Row};
use nalgebra::Vector3;

/// Quantity of all particles over time, which is a column of `series.csv`.
#[derive(Clone, Copy)]
pub struct SeriesColumn {
    /// Name of the column in `series.csv`, with its unit.
    pub key: &'static str,
    /// Name of the quantity in a sentence.
    pub name: &'static str,
    /// SI unit of the quantity; empty for a pure number.
    pub unit: &'static str,
    /// True if the quantity is a sum over all particles, false if it is a mean.
    pub is_sum: bool,
    /// Scale by which differences of the quantity between two runs are divided in a verdict (test whether the runs
    /// differ); `None` if verdicts do not compare the quantity.
    pub scale: Option<CurveScale>,
    /// Function that returns the quantity of a row (an instant of the run). It returns `None` if the scene does not
    /// have the quantity.
    pub of: fn(&Row) -> Option<f64>,
}

/// Scale by which differences of a curve over time between two runs are divided in a verdict (test whether the runs
/// differ).
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum CurveScale {
    /// Largest magnitude of the quantity over time.
    LargestValue,
    /// Largest change of the quantity over time, or the agitation if it is larger. This scale is used for velocities,
    /// whose values depend on the frame of reference.
    LargestChange,
}

impl SeriesColumn {
    const fn compared(mut self, scale: CurveScale) -> Self {
        self.scale = Some(scale);
        self
    }
}

/// Component of a vector along the axis `axis` (0: x, 1: y, 2: z); `None` if the scene does not have the vector.
fn part(of: Option<Vector3<f64>>, axis: usize) -> Option<f64> {
    of.map(|vector| vector[axis])
}

const fn mean(key: &'static str, name: &'static str, unit: &'static str, of: fn(&Row) -> Option<f64>) -> SeriesColumn {
    SeriesColumn { key, name, unit, is_sum: false, scale: None, of }
}

const fn sum(key: &'static str, name: &'static str, unit: &'static str, of: fn(&Row) -> Option<f64>) -> SeriesColumn {
    SeriesColumn { key, name, unit, is_sum: true, scale: None, of }
}

/// Columns of `series.csv` in the order of the file, after the time.
pub const SERIES_COLUMNS: [SeriesColumn; 28] = [
    mean("granular_temperature_m2_s2", "granular temperature", "m²/s²", Row::granular_temperature)
        .compared(CurveScale::LargestValue),
    mean("Txx_m2_s2", "T along x", "m²/s²", |row| part(row.temperature, 0)).compared(CurveScale::LargestValue),
    mean("Tyy_m2_s2", "T along y", "m²/s²", |row| part(row.temperature, 1)).compared(CurveScale::LargestValue),
    mean("Tzz_m2_s2", "T along z", "m²/s²", |row| part(row.temperature, 2)).compared(CurveScale::LargestValue),
    mean("mean_velocity_x_m_s", "mean velocity along x", "m/s", |row| Some(row.velocity.x)),
    mean("mean_velocity_y_m_s", "mean velocity along y", "m/s", |row| Some(row.velocity.y)),
    mean("mean_velocity_z_m_s", "mean velocity along z", "m/s", |row| Some(row.velocity.z))
        .compared(CurveScale::LargestChange),
    sum("kinetic_energy_J", "kinetic energy", "J", |row| Some(row.kinetic_energy)),
    sum("elastic_energy_J", "elastic energy", "J", |row| Some(row.elastic_energy)),
    sum("momentum_x_kg_m_s", "momentum along x", "kg m/s", |row| Some(row.momentum.x)),
    sum("momentum_y_kg_m_s", "momentum along y", "kg m/s", |row| Some(row.momentum.y)),
    sum("momentum_z_kg_m_s", "momentum along z", "kg m/s", |row| Some(row.momentum.z)),
    sum("pair_impacts", "pair impacts so far", "", |row| Some(row.pair_impacts as f64))
        .compared(CurveScale::LargestValue),
    sum("wall_impacts", "wall impacts so far", "", |row| Some(row.wall_impacts as f64))
        .compared(CurveScale::LargestValue),
    mean("coordination_number", "contacts per particle", "", |row| Some(row.coordination)),
    mean("largest_overlap", "largest overlap over the diameter", "", |row| Some(row.largest_overlap)),
    mean("centre_of_mass_x_m", "centre of mass along x", "m", |row| row.centre[0]),
    mean("centre_of_mass_y_m", "height of the centre of mass", "m", |row| row.centre[1])
        .compared(CurveScale::LargestValue),
    mean("centre_of_mass_z_m", "centre of mass along z", "m", |row| row.centre[2]),
    sum("rotational_energy_J", "rotational energy", "J", |row| row.rotation.map(|rotation| rotation.energy)),
    mean("rotational_temperature_m2_s2", "rotational temperature", "m²/s²", Row::rotational_temperature)
        .compared(CurveScale::LargestValue),
    mean("Rxx_m2_s2", "T_r along x", "m²/s²", |row| part(row.rotation.map(|rotation| rotation.temperature), 0)),
    mean("Ryy_m2_s2", "T_r along y", "m²/s²", |row| part(row.rotation.map(|rotation| rotation.temperature), 1)),
    mean("Rzz_m2_s2", "T_r along z", "m²/s²", |row| part(row.rotation.map(|rotation| rotation.temperature), 2)),
    mean("mean_spin_x_rad_s", "mean spin along x", "rad/s", |row| part(row.rotation.map(|rotation| rotation.spin), 0)),
    mean("mean_spin_y_rad_s", "mean spin along y", "rad/s", |row| part(row.rotation.map(|rotation| rotation.spin), 1)),
    mean("mean_spin_z_rad_s", "mean spin along z", "rad/s", |row| part(row.rotation.map(|rotation| rotation.spin), 2)),
    sum("energy_J", "energy", "J", |row| Some(row.energy())).compared(CurveScale::LargestValue),
];

/// Value that the function `energy` takes from the friction energies of a row; `None` if spheres do not rotate.
fn friction(row: &Row, energy: impl FnOnce(FrictionSums) -> f64) -> Option<f64> {
    row.friction.map(energy)
}

/// Further columns of `series.csv` for spheres that rotate: losses by friction since the start, and energies of
/// springs.
pub const FRICTION_COLUMNS: [SeriesColumn; 9] = [
    sum("sliding_loss_J", "loss by sliding", "J", |row| friction(row, |of| of.sliding)),
    sum("tangential_restitution_loss_J", "loss by tangential restitution", "J", |row| {
        friction(row, |of| of.losses.tangential_restitution)
    }),
    sum("separation_loss_J", "loss of springs at separation", "J", |row| friction(row, |of| of.losses.separation)),
    sum("rescaling_loss_J", "loss by rescaled springs", "J", |row| friction(row, |of| of.losses.rescaling)),
    sum("rolling_loss_J", "loss by rolling resistance", "J", |row| friction(row, |of| of.losses.rolling)),
    sum("twisting_loss_J", "loss by twisting resistance", "J", |row| friction(row, |of| of.losses.twisting)),
    sum("tangential_spring_energy_J", "energy of tangential springs", "J", |row| friction(row, |of| of.springs[0])),
    sum("rolling_spring_energy_J", "energy of rolling springs", "J", |row| friction(row, |of| of.springs[1])),
    sum("twisting_spring_energy_J", "energy of twisting springs", "J", |row| friction(row, |of| of.springs[2])),
];

/// Further columns of `series.csv` for scenes with turbulence: means over all particles and the three components.
pub const TURBULENCE_COLUMNS: [SeriesColumn; 3] = [
    mean("gas_variance_m2_s2", "variance of the gas", "m²/s²", |row| row.turbulence.map(|of| of.of_gas)),
    mean("gas_variance_seen_m2_s2", "variance of the gas seen", "m²/s²", |row| row.turbulence.map(|of| of.seen)),
    mean("gas_particle_covariance_m2_s2", "covariance of gas and particles", "m²/s²", |row| {
        row.turbulence.map(|of| of.covariance)
    }),
];

/// Further columns of `series.csv` for scenes with two-way coupling: flow of the gas on which the particles act.
pub const GAS_COLUMNS: [SeriesColumn; 4] = [
    mean("gas_pressure_gradient_Pa_m", "pressure drop of the gas", "Pa/m", |row| {
        row.gas.map(|gas| gas.pressure_gradient)
    }),
    mean("gas_bulk_velocity_m_s", "flow rate of the gas", "m/s", |row| row.gas.map(|gas| gas.bulk_velocity)),
    mean("gas_friction_velocity_m_s", "friction velocity of the gas", "m/s", |row| {
        row.gas.map(|gas| gas.friction_velocity)
    }),
    sum("gas_momentum_z_kg_m_s", "momentum of the gas along z", "kg m/s", |row| row.gas.map(|gas| gas.momentum)),
];

/// Further columns of `series.csv` for scenes with servo walls (walls on which the pressure is kept constant): state
/// of the first of these walls.
pub const SERVO_COLUMNS: [SeriesColumn; 3] = [
    mean("servo_displacement_m", "displacement of the servo wall", "m", |row| row.servo.map(|of| of.displacement)),
    mean("servo_speed_m_s", "speed of the servo wall", "m/s", |row| row.servo.map(|of| of.speed)),
    mean("servo_pressure_Pa", "pressure on the servo wall", "Pa", |row| row.servo.map(|of| of.pressure)),
];

/// Further columns of `series.csv` for sheared boxes: the work of shear since the start, and the stress yz.
pub const SHEAR_COLUMNS: [SeriesColumn; 3] = [
    sum("shear_work_J", "work of shear", "J", |row| row.shear.map(|of| of.work)),
    mean("kinetic_stress_yz_Pa", "kinetic stress yz", "Pa", |row| row.shear.map(|of| of.kinetic)),
    mean("contact_stress_yz_Pa", "contact stress yz", "Pa", |row| row.shear.and_then(|of| of.contact)),
];

/// Further column of `series.csv` for scenes with a thermostat or thermal walls: the energy given to the particles
/// since the start.
pub const THERMOSTAT_COLUMNS: [SeriesColumn; 1] =
    [sum("thermostat_work_J", "work of the thermostat", "J", |row| row.thermostat_work)];

/// Further column of `series.csv` for scenes with inlets or outlets: the number of particles.
pub const OPENING_COLUMNS: [SeriesColumn; 1] =
    [sum("particles", "number of particles", "", |row| row.particles.map(|count| count as f64))
        .compared(CurveScale::LargestValue)];

/// Further columns of `series.csv` for runs that measure the velocity distribution: its Sonine coefficients.
pub const SONINE_COLUMNS: [SeriesColumn; 2] = [
    mean("a2", "a₂ of the velocities", "", |row| row.sonine.map(|of| of.a2)),
    mean("a3", "a₃ of the velocities", "", |row| row.sonine.map(|of| of.a3)),
];
