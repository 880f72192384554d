//! Contact laws of the calling program: spheres that stick, and laws that violate the requirements.

use crate::support::*;
use diptych::contact_law::{Bodies, BrokenContract, ContactLaw, Law, Parameter, Spring};
use diptych::engine::Failure;
use diptych::experiment::{Experiment, Model, SoftStepping, Spheres, TimeStep};
use diptych::simulation::Simulation;

/// Elastic force k δ (δ/δ_0 - 1), which attracts up to the overlap δ_0 and repels beyond it, with a linear dashpot.
#[derive(Debug)]
struct Sticky {
    /// [N/m] elastic constant k.
    stiffness: f64,
    /// [m] overlap δ_0 at which the force changes its sign.
    range: f64,
    /// [N s/m] constant of the dashpot.
    dashpot: f64,
}

impl Law for Sticky {
    fn between(&self, bodies: &Bodies) -> Spring {
        let Bodies { effective_mass, restitution, stiffness_ratio, .. } = *bodies;
        Spring { effective_mass, restitution, stiffness: self.stiffness * stiffness_ratio, dashpot: self.dashpot }
    }

    fn force(&self, spring: &Spring, overlap: f64, normal_velocity: f64) -> (f64, f64) {
        (spring.stiffness * overlap * (overlap / self.range - 1.0), -spring.dashpot * normal_velocity)
    }

    fn stored_energy(&self, spring: &Spring, overlap: f64) -> f64 {
        spring.stiffness * overlap * overlap * (overlap / (3.0 * self.range) - 0.5)
    }

    fn parameters(&self) -> Vec<Parameter> {
        let of = |key, value, unit| Parameter { law: "sticky", key, name: key, symbol: key, value, unit };
        vec![of("stiffness", self.stiffness, "N/m"), of("range", self.range, "m"), of("dashpot", self.dashpot, "N s/m")]
    }
}

/// Two spheres of 406 µm that approach head-on at a relative speed [m/s], with the time step `step` [s].
fn meeting(law: ContactLaw, speed: f64, step: f64, stepping: SoftStepping) -> Simulation {
    let scene = empty([4e-3; 3], [false; 3], small(), surface(1.0, 0.0));
    let right = 2e-3 + 406e-6 + 1e-6;
    let start = [([2e-3; 3], [0.5 * speed, 0.0, 0.0]), ([right, 2e-3, 2e-3], [-0.5 * speed, 0.0, 0.0])];
    let particles = placed(&scene, &start);
    let mut experiment = experiment(scene, 2, [0.0; 3], speed, Model::Soft, 1);
    experiment.soft.time_step = TimeStep::Fixed(step);
    experiment.soft.stepping = stepping;
    Simulation::new(&with(experiment, law), particles)
}

fn with(mut experiment: Experiment, law: ContactLaw) -> Experiment {
    experiment.soft.law = Some(law);
    experiment.run.spheres = Spheres::Soft(law);
    experiment
}

#[test]
fn slow_spheres_stick_at_the_bottom_of_the_well_and_fast_ones_part() {
    let range = 2e-6;
    for stepping in [SoftStepping::Uniform, SoftStepping::Local] {
        let law = ContactLaw::other(Sticky { stiffness: 300.0, range, dashpot: 1e-4 });
        let mut slow = meeting(law, 0.01, 2e-7, stepping);
        slow.run(40, 1e-4).unwrap_or_else(|why| panic!("{stepping:?}: {why}"));
        let gap = (slow.particles.position[1] - slow.particles.position[0]).norm() - 406e-6;
        assert!((gap + range).abs() < 1e-9, "{stepping:?}: {gap}");
        assert_eq!(slow.record.pairs.count, 0);

        let law = ContactLaw::other(Sticky { stiffness: 300.0, range, dashpot: 0.0 });
        let mut fast = meeting(law, 0.5, 1e-7, stepping);
        fast.run(20, 1e-4).unwrap();
        let pairs = fast.record.pairs.summary();
        assert_eq!(pairs.count, 1, "{stepping:?}");
        let spring = law.between(&Bodies::alike(&small(), &surface(1.0, 0.0)));
        let asked = law.contact_time(&spring, 0.5);
        // a uniform step is a thirtieth of the contact time
        assert!((pairs.mean_duration.unwrap() / asked - 1.0).abs() < 0.05, "{stepping:?}: {pairs:?}, {asked}");
        assert!((pairs.mean_restitution.unwrap() - 1.0).abs() < 2e-3, "{stepping:?}: {pairs:?}");
    }
}

/// Linear spring with a constant attraction [N], which begins at the touch with a jump.
#[derive(Debug)]
struct Jump(f64);
/// Linear spring with a stored energy stated as twice the true value.
#[derive(Debug)]
struct Liar;
/// Linear spring, and a dashpot with the wrong sign.
#[derive(Debug)]
struct Driven;
/// Constant force, which does not grow with the overlap.
#[derive(Debug)]
struct Flat;

macro_rules! linear {
    ($law:ty, $self:ident, $force:expr, $energy:expr) => {
        impl Law for $law {
            fn between(&self, bodies: &Bodies) -> Spring {
                let Bodies { effective_mass, restitution, .. } = *bodies;
                Spring { effective_mass, restitution, stiffness: 300.0, dashpot: 1e-3 }
            }

            fn force(&$self, spring: &Spring, overlap: f64, normal_velocity: f64) -> (f64, f64) {
                $force(spring, overlap, normal_velocity)
            }

            fn stored_energy(&$self, spring: &Spring, overlap: f64) -> f64 {
                $energy(spring, overlap)
            }

            fn parameters(&self) -> Vec<Parameter> {
                let name = stringify!($law);
                vec![Parameter { law: name, key: "none", name, symbol: "-", value: 1.0, unit: "-" }]
            }
        }
    };
}

linear!(Jump, self, |s: &Spring, x: f64, _| (s.stiffness * x - self.0, 0.0), |s: &Spring, x: f64| 0.5
    * s.stiffness
    * x
    * x
    - self.0 * x);
linear!(Liar, self, |s: &Spring, x: f64, _| (s.stiffness * x, 0.0), |s: &Spring, x: f64| s.stiffness * x * x);
linear!(Driven, self, |s: &Spring, x: f64, u: f64| (s.stiffness * x, s.dashpot * u), |s: &Spring, x: f64| 0.5
    * s.stiffness
    * x
    * x);
linear!(Flat, self, |_: &Spring, _, _| (0.0, 0.0), |_: &Spring, _| 0.0);

#[test]
fn laws_that_break_a_contract_are_refused_with_the_contract() {
    let refused = |law| match meeting(law, 0.1, 1e-7, SoftStepping::Uniform).run(1, 1e-4).unwrap_err() {
        Failure::BrokenContract { broken, .. } => broken,
        other => panic!("{other}"),
    };
    assert!(matches!(refused(ContactLaw::other(Jump(1e-3))), BrokenContract::ForceAtTouch { .. }));
    assert!(matches!(refused(ContactLaw::other(Liar)), BrokenContract::Energy { .. }));
    assert!(matches!(refused(ContactLaw::other(Driven)), BrokenContract::Drives { .. }));
    assert!(matches!(refused(ContactLaw::other(Flat)), BrokenContract::Bottomless { .. }));
}

/// The potential of [`Sticky`] has the depth k δ_0²/6. The energy that a contact can return is counted from its lowest
/// point.
#[test]
fn energy_that_a_contact_may_give_back_counts_from_the_bottom_of_the_well() {
    let law = ContactLaw::other(Sticky { stiffness: 300.0, range: 2e-6, dashpot: 0.0 });
    let spring = law.between(&Bodies::alike(&small(), &surface(1.0, 0.0)));
    let depth = 300.0 * 2e-6f64.powi(2) / 6.0;
    // the minimum is between two of 64 samples
    assert!((law.well_depth(&spring) / depth - 1.0).abs() < 1e-3, "{}", law.well_depth(&spring));
    for k in 0..100 {
        let overlap = 5e-8 * f64::from(k);
        assert!(law.available_energy(&spring, overlap) >= -1e-3 * depth, "{overlap} m");
    }
    let linear = ContactLaw::linear(300.0).available_energy(&spring, 1e-6);
    assert!((linear / 1.5e-10 - 1.0).abs() < 1e-12, "{linear}");
}

/// Two spheres pass through the well of [`Sticky`] without loss. The energy that the contact stores is negative
/// meanwhile, counted from the touch, and kinetic and elastic energy together stay constant.
#[test]
fn energy_stored_in_a_well_is_negative_and_kept() {
    let law = ContactLaw::other(Sticky { stiffness: 300.0, range: 2e-6, dashpot: 0.0 });
    let depth = 300.0 * 2e-6f64.powi(2) / 6.0;
    for stepping in [SoftStepping::Uniform, SoftStepping::Local] {
        let mut simulation = meeting(law, 0.01, 2e-8, stepping);
        let (start, mut lowest) = (simulation.energy(), 0.0_f64);
        for window in 0..150 {
            simulation.run(1, 2e-6).unwrap_or_else(|why| panic!("{stepping:?}, {window}: {why}"));
            let (energy, elastic) = (simulation.energy(), simulation.elastic_energy());
            // the overlap and the velocity may be a step apart, in which the force changes the energy by 0.2 %
            assert!((energy - start).abs() < 0.02 * depth, "{stepping:?}, {window}: {energy} of {start}, {elastic}");
            lowest = lowest.min(elastic);
        }
        assert!(lowest < -0.5 * depth && lowest > -1.01 * depth, "{stepping:?}: {lowest} of {depth}");
    }
}

/// Sticking spheres fulfil the requirements at every speed, even if the stored energy at the largest overlap is nearly
/// zero.
#[test]
fn a_law_that_attracts_keeps_its_contracts_at_every_speed() {
    let law = ContactLaw::other(Sticky { stiffness: 300.0, range: 2e-6, dashpot: 1e-4 });
    let spring = law.between(&Bodies::alike(&small(), &surface(1.0, 0.0)));
    for k in 0..60 {
        let speed = 1e-4 * 1.15f64.powi(k);
        assert_eq!(law.check(&spring, speed), Ok(()), "{speed} m/s");
    }
}

/// A law whose contacts never end has no number of steps per contact. Without a given time step the run is refused,
/// because its time step cannot be checked.
#[test]
fn a_law_whose_contacts_do_not_end_needs_a_time_step() {
    let law = ContactLaw::other(Sticky { stiffness: 300.0, range: 2e-6, dashpot: 1e-4 });
    let scene = empty([4e-3; 3], [true; 3], small(), surface(1.0, 0.0));
    let particles = random(&scene, 10, 1e-3, 1);
    let mut simulation = Simulation::new(&with(experiment(scene, 10, [0.0; 3], 1e-3, Model::Soft, 1), law), particles);
    let why = simulation.run(1, 1e-3).unwrap_err();
    assert!(matches!(why, Failure::StepTooLong { .. }), "{why}");
}
