//! Exact sums of the powers and forces of contacts. The sums do not depend on the order of contacts, nor on the process
//! or thread that adds them. A window is the time between two exchanges with the gas.

use super::contact::ContactForce;
use super::rates::Rates;
use crate::encounter::Couple;
use crate::exact::{ExactSum, add_rows, condense, none, values};
use crate::record::{AT_WALLS, BY_SHEAR, FrictionLosses, Ledger, OF_PAIRS, OF_SPRINGS, SOME};
use crate::scene::Scene;
use nalgebra::{Matrix3, Vector3};

/// Number of rows (powers and forces of one contact each) that are replaced by a few rows with the same sums at the
/// same time. So many rows take 3 kB, which stay in the processor's cache. With 128 rows a dense scene takes 9 %
/// longer.
const BATCH: usize = 32;

/// Contributions of one contact to the sums, in the order of [`OF_PAIRS`] or [`AT_WALLS`]: powers [W], and for a pair
/// the virial (products of the vector between the centres and the force) [N m], or for a wall forces [N].
type SumRow = [f64; SOME];

/// Powers [W] at which the springs of one contact lose energy, in the order of [`OF_SPRINGS`].
type SpringRow = [f64; 4];

/// Power [W] of the shear of the box on one contact, in the order of [`BY_SHEAR`], followed by three zeros.
type ShearRow = [f64; 4];

/// Rows of powers and forces, one per contact, separate for pairs and for walls. A contact whose springs lose energy
/// has a second row, and so has a contact across a sheared side of the box.
#[derive(Default)]
pub struct ContactRows {
    of_pairs: Vec<SumRow>,
    at_walls: Vec<SumRow>,
    of_springs: Vec<SpringRow>,
    by_shear: Vec<ShearRow>,
}

impl ContactRows {
    /// Adds a row with the powers and the force of one contact. `at` contains the scene and the time [s] from the
    /// action of the force to the end of the window. Full batches of rows are condensed: a few rows with the same sums
    /// are added to `few`.
    #[inline(always)]
    pub fn add(&mut self, couple: &Couple, force: &ContactForce, at: (&Scene, f64), few: &mut Self) {
        self.add_row(couple, force, 0.0, at, few);
    }

    /// Adds the rows (powers and forces) of a contact between rotating bodies, with the arguments of
    /// [`add`](Self::add). `losses` [W] are the parts of the friction power of the force.
    #[inline(always)]
    pub fn add_rotating(
        &mut self,
        couple: &Couple,
        (force, losses): (&ContactForce, &FrictionLosses),
        at: (&Scene, f64),
        few: &mut Self,
    ) {
        self.add_row(couple, force, losses.tangential_restitution, at, few);
        let of_springs = losses.of_springs();
        if of_springs != [0.0; 4] {
            self.of_springs.push(of_springs);
            if self.of_springs.len() == BATCH {
                condense(&mut self.of_springs, &mut few.of_springs);
            }
        }
    }

    #[inline(always)]
    fn add_row(
        &mut self,
        couple: &Couple,
        force: &ContactForce,
        damped: f64,
        (scene, remaining): (&Scene, f64),
        few: &mut Self,
    ) {
        let ContactForce { on_i: f, normal, restitution_power, friction_power, wall_power, shear_power, arm } = *force;
        if shear_power != 0.0 {
            self.by_shear.push([shear_power, 0.0, 0.0, 0.0]);
            if self.by_shear.len() == BATCH {
                condense(&mut self.by_shear, &mut few.by_shear);
            }
        }
        if couple.is_wall() {
            // until the end of the window, gravity does work on the momentum that walls add
            let late = scene.gravity.dot(&f) * remaining;
            let given =
                [f.x, f.y, f.z, restitution_power, wall_power, normal, late, friction_power, damped, 0.0, 0.0, 0.0];
            self.at_walls.push(given);
            if self.at_walls.len() == BATCH {
                condense(&mut self.at_walls, &mut few.at_walls);
            }
        } else {
            let [x, y, z] = [f.x, f.y, f.z].map(|f| [arm.x * f, arm.y * f, arm.z * f]);
            let (first, second) = (restitution_power, friction_power);
            let virial = [x[0], x[1], x[2], first, y[0], y[1], y[2], second, z[0], z[1], z[2], damped];
            self.of_pairs.push(virial);
            if self.of_pairs.len() == BATCH {
                condense(&mut self.of_pairs, &mut few.of_pairs);
            }
        }
    }

    /// Condenses all rows (powers and forces of single contacts) into a few rows with the same sums, which are added to
    /// `few`.
    pub fn leave(&mut self, few: &mut Self) {
        condense(&mut self.of_pairs, &mut few.of_pairs);
        condense(&mut self.at_walls, &mut few.at_walls);
        condense(&mut self.of_springs, &mut few.of_springs);
        condense(&mut self.by_shear, &mut few.by_shear);
    }

    /// Removes all rows (powers and forces of contacts), and keeps their memory for new rows.
    pub fn clear(&mut self) {
        self.of_pairs.clear();
        self.at_walls.clear();
        self.of_springs.clear();
        self.by_shear.clear();
    }
}

/// Adds the rows `rows` (powers and forces of contacts), multiplied by `weight` [-], to `sums`, column by column. The
/// addition has no rounding errors.
fn add_weighted<const K: usize>(sums: &mut [ExactSum; K], rows: &[[f64; K]], weight: f64) {
    if rows.is_empty() || weight == 0.0 {
        return;
    }
    if weight == 1.0 {
        add_rows(sums.each_mut(), rows);
    } else {
        let weighted: Vec<[f64; K]> = rows.iter().map(|row| row.map(|number| weight * number)).collect();
        add_rows(sums.each_mut(), &weighted);
    }
}

/// Exact sums of the powers and forces of contacts, over all steps since the sums were last recorded.
pub struct ContactSums {
    of_pairs: [ExactSum; SOME],
    at_walls: [ExactSum; SOME],
    of_springs: [ExactSum; 4],
    by_shear: [ExactSum; 4],
    is_empty: bool,
}

impl Default for ContactSums {
    fn default() -> Self {
        Self { of_pairs: none(), at_walls: none(), of_springs: none(), by_shear: none(), is_empty: true }
    }
}

impl ContactSums {
    /// Adds rows (powers and forces of contacts) to the sums, multiplied by `weight` [-]. The weight is a power of two,
    /// or 0, so the products are exact.
    pub fn add(&mut self, rows: &ContactRows, weight: f64) {
        self.is_empty &= weight == 0.0 || (rows.of_pairs.is_empty() && rows.at_walls.is_empty());
        add_weighted(&mut self.of_pairs, &rows.of_pairs, weight);
        add_weighted(&mut self.at_walls, &rows.at_walls, weight);
        add_weighted(&mut self.of_springs, &rows.of_springs, weight);
        add_weighted(&mut self.by_shear, &rows.by_shear, weight);
    }

    /// Replaces the sums by their totals over all processes, which `total` computes.
    pub fn gather(&mut self, total: impl Fn(&mut [&mut ExactSum])) {
        total(&mut self.of_pairs.each_mut());
        total(&mut self.at_walls.each_mut());
        total(&mut self.of_springs.each_mut());
        total(&mut self.by_shear.each_mut());
        self.is_empty = false;
    }

    /// Powers [W], forces [N] and virial (products of force and distance [N m]), summed over all contacts.
    pub fn rates(&self) -> Rates {
        if self.is_empty {
            return Rates::default();
        }
        let [p, w] = [values(&self.of_pairs), values(&self.at_walls)];
        Rates {
            pair_restitution: p[3],
            pair_friction: p[7],
            wall_restitution: w[3],
            wall_friction: w[7],
            wall_work: w[4],
            wall_force: Vector3::new(w[0], w[1], w[2]),
            wall_force_moment: Vector3::zeros(),
            wall_normal_force: w[5],
            pair_virial: Matrix3::from_columns(
                &[[p[0], p[1], p[2]], [p[4], p[5], p[6]], [p[8], p[9], p[10]]].map(Vector3::from),
            ),
            shear: self.by_shear[0].value(),
        }
    }

    /// [W] power that friction dissipates in all contacts, listed by cause.
    pub fn friction_losses(&self) -> FrictionLosses {
        if self.is_empty {
            return FrictionLosses::default();
        }
        let damped = self.of_pairs[11].value() + self.at_walls[8].value();
        FrictionLosses::new(damped, values(&self.of_springs))
    }

    /// Adds the sums, multiplied by the time `time` [s] for which they act, to the ledger (energies and momenta of the
    /// run).
    pub fn book(&self, time: f64, ledger: &mut Ledger) {
        if !self.is_empty {
            ledger.add_to(&OF_PAIRS, values(&self.of_pairs).map(|number| number * time));
            ledger.add_to(&AT_WALLS, values(&self.at_walls).map(|number| number * time));
            ledger.add_to(&OF_SPRINGS, values(&self.of_springs).map(|number| number * time));
            ledger.add_to(&BY_SHEAR, values(&self.by_shear).map(|number| number * time));
        }
    }
}
