//! The ledger of a run: work, losses of energy, and impulses, summed since the start.

use crate::exact::{ExactSum, add_rows, none, values};
use crate::particles::SideCrossings;
use nalgebra::{Matrix3, Vector3};
use serde::{Deserialize, Deserializer, Serialize, Serializer};
use std::sync::OnceLock;

/// Length of a [`Ledger`] that is written as an array: a multiple of four, for vector instructions.
pub const ENTRIES: usize = 44;

/// Length of the lists [`OF_PAIRS`] and [`AT_WALLS`]: number of ledger entries to which one contact adds.
pub const SOME: usize = 12;

/// Indices, in [`Ledger::to_array`], of the entries to which a contact of two particles adds. In this order they are:
/// first column of the matrix [`Ledger::pair_virial`], loss by restitution, second column, loss by friction, third
/// column, loss by tangential restitution. A column has three entries.
pub const OF_PAIRS: [usize; SOME] = [18, 19, 20, 3, 21, 22, 23, 4, 24, 25, 26, 27];

/// Indices, in [`Ledger::to_array`], of the entries to which a contact with a wall adds. In this order they are:
/// impulse (three components), loss by restitution, work of the wall, impulse along the normal, work of gravity, loss
/// by friction, loss by tangential restitution. The last index is repeated, with amounts of 0, to fill the array.
pub const AT_WALLS: [usize; SOME] = [15, 16, 17, 5, 2, 8, 1, 6, 27, 27, 27, 27];

/// Indices, in [`Ledger::to_array`], of the entries to which only contacts with tangential, rolling or twisting springs
/// add: [`FrictionLosses`] without the loss by tangential restitution.
pub const OF_SPRINGS: [usize; 4] = [28, 29, 30, 31];

/// Index, in the array of a ledger (see [`Ledger::to_array`]), of the x component of the impulse of walls on
/// particles.
const BY_WALLS: usize = 15;

/// Indices, in [`Ledger::to_array`], of the work of a sheared box and of the three components of its impulse.
pub const BY_SHEAR: [usize; 4] = [32, 33, 34, 35];

/// Index, in the array of a ledger (see [`Ledger::to_array`]), of the work of a thermostat. The three components of
/// the impulse of the thermostat follow.
const BY_THERMOSTAT: usize = 36;

/// Index, in the array of a ledger (see [`Ledger::to_array`]), of the energy of particles that came in less that of
/// particles that left. The three components of their momentum follow.
const BY_FLOW: usize = 40;

/// Sums of work, losses and impulses in an island (a group of particles that may meet), a window (the time between two
/// exchanges with the gas) or a run.
///
/// Balance: kinetic, rotational and elastic energy now = that at the start + drag_work + gravity_work + wall_work +
/// shear_work + thermostat_work + flow_energy - dissipated. The left side minus the right side is the residual. For
/// hard spheres the residual is a rounding error; for soft spheres it is the energy that the integrator creates (> 0)
/// or loses (< 0).
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Ledger {
    /// [J] work done by drag on the particles.
    pub drag_work: f64,
    /// [J] work done by gravity and buoyancy on the particles.
    pub gravity_work: f64,
    /// [J] work done on the particles by walls that move, or whose surface moves along itself.
    pub wall_work: f64,
    /// [J] energy lost to restitution (dashpot) in impacts between particles, >= 0.
    pub pair_restitution_loss: f64,
    /// [J] energy lost to friction in impacts between particles, >= 0.
    pub pair_friction_loss: f64,
    /// [J] energy lost to restitution (dashpot) in impacts on walls, >= 0 except in the TC model of hard spheres
    /// (contact time t_c). In that model, a sphere of mass m that begins to rest on a wall under the acceleration a_n
    /// gains m a_n² t_c²/32 from the wall, which is subtracted here.
    pub wall_restitution_loss: f64,
    /// [J] energy lost to friction in impacts on walls, >= 0.
    pub wall_friction_loss: f64,
    /// [J] energy that collisions would have lost if the TC model had not made them elastic, >= 0. In this model a
    /// collision is elastic if one of its bodies had another collision less than the contact time t_c before. The
    /// particles keep this energy, so it is not part of the balance.
    pub contact_time_kept: f64,
    /// [kg m/s] momentum given to the particles by drag.
    pub drag_impulse: Vector3<f64>,
    /// [kg m/s] momentum given to the particles by gravity and buoyancy.
    pub gravity_impulse: Vector3<f64>,
    /// [kg m/s] momentum given to the particles by walls.
    pub wall_impulse: Vector3<f64>,
    /// [kg m/s] sum over impacts of the magnitude of the wall's impulse along the normal of the wall.
    pub wall_normal_impulse: f64,
    /// [J s] time integral of Σ r f over pairs of particles in contact, with the components of r as rows and those of f
    /// as columns. The vector r points from the centre of the first particle to that of the second, and f is the force
    /// on the second particle. For a collision, the impulse takes the place of the integral of f.
    pub pair_virial: Matrix3<f64>,
    /// Parts of the losses by friction between particles and at walls; 0 for spheres without rotation.
    pub friction: FrictionLosses,
    /// [J] work of the shear of a sheared box on the particles in the box. Particles that cross a sheared side get the
    /// velocity of their image. A contact across that side acts on the image.
    pub shear_work: f64,
    /// [kg m/s] momentum that particles gain where they cross a sheared side and get the velocity of their image.
    pub shear_impulse: Vector3<f64>,
    /// [J] energy given to the particles by a thermostat and by thermal walls. It does not contain the work of walls
    /// that move, which is in `wall_work`.
    pub thermostat_work: f64,
    /// [kg m/s] momentum given to the particles by a thermostat; zero but for rounding.
    pub thermostat_impulse: Vector3<f64>,
    /// [J] kinetic, rotational and elastic energy of the particles that came in through inlets, less that of the
    /// particles that left through outlets. The elastic energy is that of the contacts that were cut.
    pub flow_energy: f64,
    /// [kg m/s] momentum of the particles that came in through inlets, less that of those that left through outlets.
    pub flow_impulse: Vector3<f64>,
}

impl std::ops::AddAssign<SideCrossings> for Ledger {
    fn add_assign(&mut self, SideCrossings { impulse, work }: SideCrossings) {
        self.shear_work += work;
        self.shear_impulse.z += impulse;
    }
}

impl std::ops::AddAssign for Ledger {
    fn add_assign(&mut self, other: Self) {
        let (own, others) = (self.to_array(), other.to_array());
        *self = Self::from_array(std::array::from_fn(|k| own[k] + others[k]));
    }
}

impl std::ops::AddAssign<SideCrossings> for Books {
    fn add_assign(&mut self, crossings: SideCrossings) {
        let mut ledger = Ledger::default();
        ledger += crossings;
        *self += ledger;
    }
}

impl std::ops::Neg for Ledger {
    type Output = Self;

    fn neg(self) -> Self {
        Self::from_array(self.to_array().map(|number| -number))
    }
}

/// Parts of the energy that spheres with rotation lose by friction [J], or parts of the power of this loss [W]. The
/// rest of the loss is sliding friction ([`Ledger::sliding_loss`]).
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct FrictionLosses {
    /// Loss [J] (or its power [W]) by the tangential dashpot of a soft contact while its surfaces stick, or by a hard
    /// impact whose surfaces stick under Walton's rule.
    pub tangential_restitution: f64,
    /// Energy [J] (or power [W]) lost at the end of contacts: the energy that is then stored in their tangential,
    /// rolling and twisting springs.
    pub separation: f64,
    /// Loss [J] (or its power [W]) by Mindlin's tangential spring when its stiffness changes with the overlap. With the
    /// rescaled history the spring never gains energy, so the loss is >= 0.
    pub rescaling: f64,
    /// Loss [J] (or its power [W]) by rolling resistance: by the limit of its torque and by its dashpot.
    pub rolling: f64,
    /// Loss [J] (or its power [W]) by twisting resistance: by the limit of its torque and by its dashpot.
    pub twisting: f64,
}

impl FrictionLosses {
    /// Energies lost in tangential, rolling and twisting springs, in the order of [`OF_SPRINGS`].
    pub fn of_springs(&self) -> [f64; 4] {
        [self.separation, self.rescaling, self.rolling, self.twisting]
    }

    /// Makes the losses from the loss by tangential restitution and the losses to springs, in the order of
    /// [`OF_SPRINGS`].
    pub fn new(tangential_restitution: f64, [separation, rescaling, rolling, twisting]: [f64; 4]) -> Self {
        Self { tangential_restitution, separation, rescaling, rolling, twisting }
    }

    /// Sum of all five losses [J], or of their powers [W].
    pub fn sum(&self) -> f64 {
        self.tangential_restitution + self.of_springs().iter().sum::<f64>()
    }
}

impl std::ops::Mul<f64> for FrictionLosses {
    type Output = Self;

    fn mul(self, factor: f64) -> Self {
        Self::new(self.tangential_restitution * factor, self.of_springs().map(|loss| loss * factor))
    }
}

impl std::ops::AddAssign for FrictionLosses {
    fn add_assign(&mut self, other: Self) {
        self.tangential_restitution += other.tangential_restitution;
        self.separation += other.separation;
        self.rescaling += other.rescaling;
        self.rolling += other.rolling;
        self.twisting += other.twisting;
    }
}

impl Ledger {
    /// [J] energy lost to sliding friction: all losses by friction less the five parts of [`FrictionLosses`].
    pub fn sliding_loss(&self) -> f64 {
        self.pair_friction_loss + self.wall_friction_loss - self.friction.sum()
    }

    /// [J] energy that the particles lost in impacts, by restitution and by friction.
    pub fn dissipated(&self) -> f64 {
        self.pair_restitution_loss + self.pair_friction_loss + self.wall_restitution_loss + self.wall_friction_loss
    }

    /// [J] energy that the particles have gained in other ways than by impacts. It is the work of drag, gravity, moving
    /// walls, shear and a thermostat, plus the energy that came in through inlets, minus that lost through outlets.
    pub fn work(&self) -> f64 {
        self.gains().iter().sum()
    }

    /// [J] energies that the particles have gained in other ways than by impacts: works of drag, gravity, walls, shear
    /// and thermostat, and energy by inlets and outlets. A negative number is a loss.
    fn gains(&self) -> [f64; 6] {
        let Self { drag_work, gravity_work, wall_work, shear_work, thermostat_work, flow_energy, .. } = *self;
        [drag_work, gravity_work, wall_work, shear_work, thermostat_work, flow_energy]
    }

    /// [J] total energy turnover: the magnitude of `energy_at_start` plus the magnitudes of all gains of energy in
    /// other ways than by impacts. These gains are the works of drag, gravity, walls, shear and a thermostat, and the
    /// energy that came in and left.
    pub fn through(&self, energy_at_start: f64) -> f64 {
        self.gains().iter().fold(energy_at_start.abs(), |sum, gain| sum + gain.abs())
    }

    /// [J] residual of the energy balance: the change of energy that work and losses do not explain. Both arguments are
    /// kinetic, rotational and elastic energy together [J]: `energy_at_start` at the start, `energy_now` at present.
    pub fn residual(&self, energy_at_start: f64, energy_now: f64) -> f64 {
        energy_now - energy_at_start - self.work() + self.dissipated()
    }
}

impl Ledger {
    /// All numbers of the ledger as an array; [`OF_PAIRS`], [`AT_WALLS`] and similar constants are indices into this
    /// array.
    pub fn to_array(&self) -> [f64; ENTRIES] {
        let (drag, weight, walls) = (&self.drag_impulse, &self.gravity_impulse, &self.wall_impulse);
        let [[xx, yx, zx], [xy, yy, zy], [xz, yz, zz]] = self.pair_virial.data.0;
        let FrictionLosses { tangential_restitution, separation, rescaling, rolling, twisting } = self.friction;
        [
            self.drag_work,
            self.gravity_work,
            self.wall_work,
            self.pair_restitution_loss,
            self.pair_friction_loss,
            self.wall_restitution_loss,
            self.wall_friction_loss,
            self.contact_time_kept,
            self.wall_normal_impulse,
            drag.x,
            drag.y,
            drag.z,
            weight.x,
            weight.y,
            weight.z,
            walls.x,
            walls.y,
            walls.z,
            xx,
            yx,
            zx,
            xy,
            yy,
            zy,
            xz,
            yz,
            zz,
            tangential_restitution,
            separation,
            rescaling,
            rolling,
            twisting,
            self.shear_work,
            self.shear_impulse.x,
            self.shear_impulse.y,
            self.shear_impulse.z,
            self.thermostat_work,
            self.thermostat_impulse.x,
            self.thermostat_impulse.y,
            self.thermostat_impulse.z,
            self.flow_energy,
            self.flow_impulse.x,
            self.flow_impulse.y,
            self.flow_impulse.z,
        ]
    }

    /// Adds `amounts` to the numbers whose indices in [`Self::to_array`] are `entries`.
    pub(crate) fn add_to<const K: usize>(&mut self, entries: &[usize; K], amounts: [f64; K]) {
        let mut all = self.to_array();
        entries.iter().zip(amounts).for_each(|(&entry, amount)| all[entry] += amount);
        *self = Self::from_array(all);
    }

    /// Makes a ledger from its numbers, in the order of [`to_array`](Self::to_array).
    fn from_array(all: [f64; ENTRIES]) -> Self {
        let vector = |first: usize| Vector3::new(all[first], all[first + 1], all[first + 2]);
        Self {
            drag_work: all[0],
            gravity_work: all[1],
            wall_work: all[2],
            pair_restitution_loss: all[3],
            pair_friction_loss: all[4],
            wall_restitution_loss: all[5],
            wall_friction_loss: all[6],
            contact_time_kept: all[7],
            wall_normal_impulse: all[8],
            drag_impulse: vector(9),
            gravity_impulse: vector(12),
            wall_impulse: vector(BY_WALLS),
            pair_virial: Matrix3::from_column_slice(&all[18..27]),
            friction: FrictionLosses::new(all[27], OF_SPRINGS.map(|entry| all[entry])),
            shear_work: all[BY_SHEAR[0]],
            shear_impulse: vector(BY_SHEAR[1]),
            thermostat_work: all[BY_THERMOSTAT],
            thermostat_impulse: vector(BY_THERMOSTAT + 1),
            flow_energy: all[BY_FLOW],
            flow_impulse: vector(BY_FLOW + 1),
        }
    }
}

/// Exact running sums of all entries of a ledger, so that the order in which amounts are added does not matter. A
/// [`Books`] dereferences to a [`Ledger`] of the rounded totals.
#[derive(Clone, Debug)]
pub struct Books {
    sums: [ExactSum; ENTRIES],
    /// Rounded totals, computed when they are first read.
    rounded: OnceLock<Ledger>,
}

impl Default for Books {
    fn default() -> Self {
        Self { sums: none(), rounded: OnceLock::new() }
    }
}

impl PartialEq for Books {
    fn eq(&self, other: &Self) -> bool {
        self.sums == other.sums
    }
}

/// Stores the exact sums in binary formats, and the rounded ledger in formats that people read.
impl Serialize for Books {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        if serializer.is_human_readable() {
            (**self).serialize(serializer)
        } else {
            self.sums[..].serialize(serializer)
        }
    }
}

impl<'de> Deserialize<'de> for Books {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        if deserializer.is_human_readable() {
            let mut books = Self::default();
            books += Ledger::deserialize(deserializer)?;
            return Ok(books);
        }
        let sums: Vec<ExactSum> = Deserialize::deserialize(deserializer)?;
        let sums = sums.try_into().map_err(|_| serde::de::Error::custom("a ledger of another version"))?;
        Ok(Self { sums, rounded: OnceLock::new() })
    }
}

impl Books {
    /// Adds several ledgers, each as an array in the order of [`Ledger::to_array`].
    pub fn add(&mut self, amounts: &[[f64; ENTRIES]]) {
        add_rows(self.sums.each_mut(), amounts);
        self.rounded.take();
    }

    /// Exact sums of the components of [`Ledger::wall_impulse`], the impulse that walls give to particles.
    pub fn given_by_walls(&self) -> [ExactSum; 3] {
        std::array::from_fn(|axis| self.sums[BY_WALLS + axis].clone())
    }

    /// Adds the exact sums of another ledger, such as that of another process.
    pub fn merge(&mut self, other: &Self) {
        self.sums.iter_mut().zip(&other.sums).for_each(|(sum, other)| sum.merge(other));
        self.rounded.take();
    }

    /// [kg m/s] momentum given to the particles by walls. To save computing time, no other entry of the ledger is
    /// rounded.
    pub fn by_walls(&self) -> Vector3<f64> {
        values(&self.given_by_walls()).into()
    }
}

impl std::ops::Deref for Books {
    type Target = Ledger;

    fn deref(&self) -> &Ledger {
        self.rounded.get_or_init(|| Ledger::from_array(values(&self.sums)))
    }
}

impl std::ops::AddAssign<Ledger> for Books {
    fn add_assign(&mut self, amount: Ledger) {
        self.add(&[amount.to_array()]);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_number_of_a_ledger_comes_back() {
        let numbers: [f64; ENTRIES] = std::array::from_fn(|k| 1.5 + k as f64);
        let ledger = Ledger::from_array(numbers);
        assert_eq!(ledger.to_array(), numbers);
        assert_eq!(ledger.wall_impulse.as_slice(), &numbers[15..18]);
        let mut books = Books::default();
        (0..2).for_each(|_| books += ledger);
        assert_eq!(books.by_walls(), books.wall_impulse);
        assert_eq!(books.to_array(), numbers.map(|number| 2.0 * number));
    }
}
