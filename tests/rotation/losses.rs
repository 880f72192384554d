//! Parts of the losses by friction (sliding, dashpot, lost springs): closed forms, sums computed independently, and
//! the results of runs.

use super::*;
use diptych::contact_law::Hertz;
use diptych::observe::FRICTION_COLUMNS;
use diptych::record::Ledger;
use diptych::rotation::SpringHistory;
use diptych::scene::Elasticity;

const STEEL: Elasticity = Elasticity { youngs_modulus: 208e9, poissons_ratio: 0.3 };

/// Oblique impact of a sphere without spin on a floor.
struct ObliqueFall {
    law: ContactLaw,
    tangential: TangentialLaw,
    restitution: f64,
    friction: f64,
    /// [m/s] normal and tangential speed before the impact.
    speeds: [f64; 2],
}

impl ObliqueFall {
    /// Impact of a sphere under the linear laws, with the ratios of the tangential to the normal stiffness and
    /// dashpot.
    fn linear(restitution: f64, friction: f64, [stiffness, dashpot]: [f64; 2], speeds: [f64; 2]) -> Self {
        let tangential = TangentialLaw::Linear(LinearTangential::Ratios { stiffness, dashpot });
        Self { law: ContactLaw::linear(STIFFNESS), tangential, restitution, friction, speeds }
    }

    fn effective_mass(&self) -> f64 {
        2.0 / 7.0 * ball().mass()
    }

    /// [J] kinetic energy of the slip before the impact.
    fn slip_energy(&self) -> f64 {
        0.5 * self.effective_mass() * self.speeds[1].powi(2)
    }

    /// Ledger (sums of energies lost) of the impact, of soft spheres with a kind and a number of time steps per
    /// contact, or of hard spheres (`None`) with the impact rule `rule`.
    fn ledger(&self, soft: Option<(SoftStepping, f64)>, rule: ImpactRule) -> Ledger {
        let of = surface(self.restitution, self.friction);
        let mut scene = empty([0.1; 3], [true, false, true], ball(), of);
        scene.walls = vec![plane([0.0; 3], [0.0, 1.0, 0.0], of)];
        scene.rotation = Some(Rotation::new(self.tangential, rule));
        let [normal, along] = self.speeds;
        let mut particles = placed(&scene, &[([0.05, RADIUS + 1e-9, 0.05], [along, -normal, 0.0])]);
        scene.let_rotate(&mut particles);
        let time = self.law.contact_time(&self.law.between(&Bodies::of_wall(&ball(), &of, None)), normal);
        let engine: Box<dyn Engine> = match soft {
            None => Box::new(Hard::new()),
            Some((stepping, steps)) => {
                Box::new(Soft::new(self.law, Integrator::VelocityVerlet, time / steps, stepping))
            }
        };
        let mut simulation = Simulation::with_engine(scene, particles, engine);
        let energy = simulation.energy();
        simulation.run(4, 0.4 * time + 1e-9 / normal).unwrap();
        let ledger = *simulation.record.ledger;
        assert_eq!(simulation.record.walls.count, 1);
        let residual = ledger.residual(energy, simulation.energy());
        assert!(residual.abs() < 2e-2 * energy, "{residual:.1e} of {energy:.1e}");
        ledger
    }
}

const LOCAL: Option<(SoftStepping, f64)> = Some((SoftStepping::Local, 400.0));
const UNIFORM: Option<(SoftStepping, f64)> = Some((SoftStepping::Uniform, 2000.0));

fn is_near(what: &str, found: f64, expected: f64, tolerance: f64) {
    assert!((found - expected).abs() < tolerance, "{what}: {found:.6e} for {expected:.6e}");
}

/// Gross sliding without a dashpot: the tangential spring has the length that the normal force allows, and zero length
/// at both ends of the contact. The loss is μ ∫ f_n s dt = μ J (s_0 - μ J/(2 M_t)). Here J = 2 m u is the normal
/// impulse, s the slip, s_0 its initial value and M_t its effective mass. In every engine all of it is sliding.
#[test]
fn gross_sliding_is_all_sliding() {
    let fall = ObliqueFall::linear(1.0, 0.1, [0.3, 0.0], [1.0, 5.0]);
    let impulse = 0.1 * 2.0 * ball().mass();
    let expected = impulse * (5.0 - 0.5 * impulse / fall.effective_mass());
    for (engine, tolerance) in [(LOCAL, 1e-6), (UNIFORM, 2e-3), (None, 1e-9)] {
        let ledger = fall.ledger(engine, ImpactRule::COULOMB);
        is_near("total", ledger.wall_friction_loss, expected, tolerance * expected);
        is_near("sliding", ledger.sliding_loss(), expected, tolerance * expected);
        is_near("the rest", ledger.friction.sum(), 0.0, tolerance * expected);
    }
}

/// A contact that lasts half a period of the tangential spring and hardly slides. The spring returns to zero length,
/// and its dashpot dissipates ½ M_t s² (1 - β²) (slip s, its effective mass M_t, tangential restitution β). Walton's
/// rule has the same loss, in the same entry of the ledger.
#[test]
fn a_contact_that_sticks_for_half_a_period_loses_to_its_dashpot_only() {
    let restitution = 0.6;
    let mut fall = ObliqueFall::linear(1.0, 100.0, [0.0; 2], [1.0, 1e-2]);
    fall.tangential = TangentialLaw::Linear(LinearTangential::Restitution(restitution));
    let expected = fall.slip_energy() * (1.0 - restitution * restitution);
    let walton = ImpactRule::Walton { tangential_restitution: restitution };
    for (engine, tolerance) in [(LOCAL, 1e-4), (UNIFORM, 1e-2), (None, 1e-9)] {
        let ledger = fall.ledger(engine, walton.clone());
        let found = ledger.friction.tangential_restitution;
        is_near("dashpot", found, expected, tolerance * expected);
        is_near("total", ledger.wall_friction_loss, expected, tolerance * expected);
    }
}

/// Without a dashpot, a contact that sticks has the energy ½ M_t s² sin²(ω_t T) in its tangential spring when the
/// normal force ends (slip s, effective mass M_t, frequency ω_t, contact time T). This energy is lost with the
/// contact. A small part slips back while the normal force falls to zero, and counts as sliding.
#[test]
fn a_spring_under_tension_is_lost_where_the_contact_ends() {
    let ratio = 0.1f64;
    let fall = ObliqueFall::linear(1.0, 100.0, [ratio, 0.0], [1.0, 1e-3]);
    let turned = (std::f64::consts::PI * (ratio * 3.5).sqrt()).sin();
    let expected = fall.slip_energy() * turned * turned;
    for (engine, tolerance) in [(LOCAL, 1e-3), (UNIFORM, 1e-2)] {
        let ledger = fall.ledger(engine, ImpactRule::COULOMB);
        is_near("total", ledger.wall_friction_loss, expected, tolerance * expected);
        let at_the_end = ledger.friction.separation + ledger.sliding_loss();
        is_near("spring", at_the_end, expected, tolerance * expected);
        assert!(ledger.friction.tangential_restitution == 0.0);
        assert!(ledger.friction.separation > 0.9 * expected, "{ledger:?}");
    }
}

/// Losses of an impact by rescaling of the tangential spring and by sliding, divided by the energy of the slip before.
/// The laws are those of Hertz and Mindlin without damping. The units are the mass, the normal speed and Hertz's
/// constant. The motion is computed here in many small steps.
fn stepped_by_hand(history: SpringHistory, stiffness: f64, slip: f64, friction: f64) -> [f64; 2] {
    let (steps, effective_mass) = (400_000, 2.0 / 7.0);
    let dt = 2.95 * 1.25f64.powf(0.4) / f64::from(steps) * 1.05;
    let (mut overlap, mut speed, mut slips, mut force) = (0.0f64, 1.0, slip, 0.0f64);
    let mut losses = [0.0; 2];
    for _ in 0..steps {
        let before = overlap;
        speed -= overlap.max(0.0).powf(1.5) * dt;
        overlap += speed * dt;
        if overlap <= 0.0 {
            break;
        }
        let [old, new] = [before, overlap].map(|overlap| stiffness * overlap.sqrt());
        let keeps = history == SpringHistory::Force || (history == SpringHistory::Rescaled && new > old);
        let stored = if old > 0.0 { 0.5 * force * force / old } else { 0.0 };
        if !keeps && old > 0.0 {
            force *= new / old;
        }
        let kept = 0.5 * force * force / new;
        losses[0] += stored - kept;
        let wanted = force + new * slips * dt;
        let limit = friction * overlap.powf(1.5);
        let after = wanted.clamp(-limit, limit);
        let mean = 0.5 * (force + after);
        if after != wanted {
            losses[1] += mean * slips * dt - (0.5 * after * after / new - kept);
        }
        slips -= after / effective_mass * dt;
        force = after;
    }
    losses.map(|loss| loss / (0.5 * effective_mass * slip * slip))
}

#[test]
fn rescaling_is_what_an_independent_sum_finds() {
    let law = ContactLaw::Hertz(Hertz { elasticity: STEEL });
    let stiffness = law.shear_ratio([None, None]);
    for history in [SpringHistory::Rescaled, SpringHistory::Force, SpringHistory::Displacement] {
        for slip in [0.02, 0.3] {
            let friction = 0.3;
            let [rescaled, slid] = stepped_by_hand(history, stiffness, slip, friction);
            let tangential = TangentialLaw::Mindlin { history, dashpot: 0.0 };
            let fall = ObliqueFall { law, tangential, restitution: 1.0, friction, speeds: [1.0, slip] };
            let unit = fall.slip_energy();
            for (engine, tolerance) in [(LOCAL, 2e-3), (UNIFORM, 2e-2)] {
                let ledger = fall.ledger(engine, ImpactRule::COULOMB);
                is_near("rescaling", ledger.friction.rescaling / unit, rescaled, tolerance);
                let at_the_end = (ledger.sliding_loss() + ledger.friction.separation) / unit;
                is_near("sliding", at_the_end, slid, 2.0 * tolerance);
            }
            assert!(history != SpringHistory::Rescaled || rescaled > 0.05, "{rescaled}");
        }
    }
}

/// A ball that rolls on a floor loses its energy to rolling resistance, except for the energy of its rolling spring. A
/// ball that spins about the vertical loses it to twisting resistance.
#[test]
fn rolling_and_twisting_balls_lose_to_their_own_resistance() {
    for stepping in [SoftStepping::Local, SoftStepping::Uniform] {
        for (rolls, damping) in [(true, 0.0), (true, 0.3), (false, 0.0)] {
            let law = RollingLaw::Spring { friction: 0.05, stiffness: None, damping };
            let mut floor = rolling::OnFloor::new(law, stepping);
            floor.stiffness = 1000.0;
            floor.twisting = Some(TwistingLaw { damping });
            let (speed, spin) = if rolls { (0.02, Vector3::z() * -20.0) } else { (0.0, Vector3::y() * 100.0) };
            let mut simulation = floor.simulation(speed, spin, 100.0);
            let motion = |simulation: &Simulation| {
                simulation.particles.kinetic_energy() + simulation.particles.rotational_energy()
            };
            let before = motion(&simulation);
            simulation.run(40, 2.5e-4).unwrap();
            let lost = before - motion(&simulation);
            let [_, rolling, twisting] = simulation.spring_energies();
            let ledger = &simulation.record.ledger;
            let (own, stored, other) = if rolls {
                (ledger.friction.rolling, rolling, ledger.friction.twisting)
            } else {
                (ledger.friction.twisting, twisting, ledger.friction.rolling)
            };
            assert!(
                own > 5e-3 * before && (damping > 0.0 || stored > 0.0),
                "{stepping:?} {own:.1e} {stored:.1e} of {before:.1e}"
            );
            is_near("motion", own + stored, lost, 2e-2 * lost);
            is_near("the other", other, 0.0, 1e-9 * before);
            let all = ledger.pair_friction_loss + ledger.wall_friction_loss;
            is_near("total", own, all, 2e-2 * all);
        }
    }
}

/// The series of a scene with rotating spheres has columns of friction. The series of smooth spheres has none.
#[test]
fn columns_of_friction_appear_where_spheres_rotate() {
    let fall = ObliqueFall::linear(0.8, 0.3, [0.3, 0.5], [1.0, 0.5]);
    for rotates in [true, false] {
        let of = surface(fall.restitution, fall.friction);
        let mut scene = empty([3e-3; 3], [true, false, true], small(), of);
        scene.walls = vec![plane([0.0; 3], [0.0, 1.0, 0.0], of), plane([0.0, 3e-3, 0.0], [0.0, -1.0, 0.0], of)];
        let mut experiment = experiment(scene, 20, [0.0; 3], 0.5, Model::Soft, 4);
        experiment.scene.rotation = rotates.then(|| Rotation::new(fall.tangential, ImpactRule::COULOMB));
        let schedule = diptych::schedule::Schedule::new(&experiment);
        let mut simulation = Simulation::new(&experiment, initial_state(&experiment).unwrap());
        let mut series = diptych::observe::Series::new(&experiment, &schedule);
        simulation.run(20, 1e-3).unwrap();
        diptych::observe::Observer::see(&mut series, &simulation);
        let values: Vec<Option<f64>> = FRICTION_COLUMNS.iter().map(|column| (column.of)(&series.rows[0])).collect();
        assert!(values.iter().all(|value| value.is_some() == rotates), "{values:?}");
        let losses: f64 = values[..6].iter().flatten().sum();
        let ledger = &simulation.record.ledger;
        let all = ledger.pair_friction_loss + ledger.wall_friction_loss;
        assert!(!rotates || (all > 0.0 && (losses - all).abs() < 1e-12 * all), "{losses} {all}");
    }
}
