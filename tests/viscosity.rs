//! Shear viscosity: free flight in closed form, a gas in equilibrium against Enskog, and a sheared box against Garzó and
//! Dufty.

use crate::measurements::{agrees, gas, measured, number};
use crate::support::{case, placed};
use diptych::Vector3;
use diptych::contact_law::ContactLaw;
use diptych::domain::Domain;
use diptych::experiment::{Amount, Experiment, Model, Spheres, ViscositySettings};
use diptych::kinetic_theory::{GasTransport, collision_frequency};
use diptych::observe::{Observation, Viscosity};
use std::f64::consts::PI;

/// Contact value of the pair distribution by Carnahan and Starling.
fn contact_value(phi: f64) -> f64 {
    (1.0 - 0.5 * phi) / (1.0 - phi).powi(3)
}

/// Result of the viscosity measurement of a run that is averaged from the time `from` [s] on. `duration` [s] is the
/// longest time of the correlations; a run needs some tens of it for an error.
fn viscosity(experiment: &Experiment, from: f64, duration: Option<f64>) -> Observation {
    let settings = ViscositySettings { duration };
    measured(experiment, from, |_, schedule| Viscosity::new(schedule, settings))
}

/// The viscosity is measured from G, the time integral of the stress times the volume V. Without collisions a
/// component of G grows at a constant rate K. So the rate of growth of G² at the time t, divided by 2 V k_B T
/// (temperature k_B T), is K² t/(V k_B T).
#[test]
fn free_flight_has_the_viscosity_of_its_constant_stress() {
    let mut gas = gas(3, 0.001, 1.0, Model::Hard);
    let edge = 10.0;
    gas.scene.domain = Domain::new(Vector3::repeat(edge), [true; 3]);
    // three lanes along z, so that none of the spheres meets another; the sum of the velocities is 3, 0.6, 0.9
    let lanes = [([1.0, 1.0, 1.0], 4.0), ([4.0, 4.0, 4.0], -3.0), ([7.0, 7.0, 9.0], 2.0)];
    let lanes = lanes.map(|(x, v)| (x, [0.0, 0.0, v]));
    gas.start[0].amount = Amount::Placed(placed(&gas.scene, &lanes));
    (gas.run.duration, gas.statistics.sample_interval) = (50.0, Some(0.5));
    let found = viscosity(&gas, 0.0, Some(10.0));
    // Σ m c_z² of the velocities 4, -3 and 2 less their mean of 1; only the last component differs from 0, and its square
    // is that of the sum over 3; k_B T is the sum over 6
    let sum = (9.0 + 16.0 + 1.0) * gas.scene.species[0].mass();
    let (square, thermal_energy) = (sum * sum / 3.0 / 5.0, sum / 6.0);
    for (t, value) in found.places.iter().zip(&found.curves[0].values) {
        let exact = square * t / (edge.powi(3) * thermal_energy);
        let value = value.unwrap().value;
        // squares of G of up to 50 s differ by those of 0.5 s: a magnification of rounding by some 1e4
        assert!((value - exact).abs() < 1e-10 * exact.max(sum), "{t}: {value} {exact}");
    }
    // the mean from 5 s to 10 s
    let exact = square * 7.5 / (edge.powi(3) * thermal_energy);
    assert!((number(&found, "viscosity_Pa_s").value / exact - 1.0).abs() < 1e-10);
}

/// In the limit of elastic spheres, the theory agrees with textbooks: η/η_0 = 1/χ + 0.8 y + 0.761 y² χ with y = 4 φ
/// (Chapman and Cowling 1970, 16.5). Here η is the viscosity, η_0 that of the dilute gas, χ the contact value and φ
/// the volume fraction. The number 0.761 contains the exact η_0, 1.6 % above the first approximation; the two differ
/// by 1.3 % of the last term at most.
#[test]
fn elastic_spheres_have_the_viscosity_of_enskog() {
    for phi in [0.0, 0.1, 0.3, 0.45] {
        let (chi, y) = (contact_value(phi), 4.0 * phi);
        let exact = 1.0 / chi + 0.8 * y + 0.761 * y * y * chi;
        let found = GasTransport::of(phi, 1.0);
        assert!((found.viscosity / exact - 1.0).abs() < 0.013, "{phi}: {found:?} {exact}");
        assert_eq!(found.cooling_rate, 0.0);
    }
    // 5/16 sqrt(T/π) m/d² of a dilute gas of unit spheres
    let frequency = collision_frequency(2.0, 1.0, 4.0);
    assert!((2.0 * 4.0 / frequency - 5.0 / 16.0 * (4.0 / PI).sqrt()).abs() < 1e-12);
}

/// Steady shear by the theory of Garzó and Dufty at the restitution 0.9. Granular temperature and stress, in units of
/// mass, diameter and shear rate, agree with those of a separate program (docs/design/shear.md).
#[test]
fn steady_shear_is_that_of_garzo_and_dufty() {
    for (phi, temperature, stress) in [(0.1, 6.86, 0.573), (0.3, 1.236, 0.751)] {
        let (density, transport) = (6.0 * phi / PI, GasTransport::of(phi, 0.9));
        let unit = collision_frequency(density, 1.0, 1.0);
        let t = (transport.steady_shear_rate() * unit).powi(-2);
        let found = density * t * transport.viscosity * transport.steady_shear_rate();
        // half a unit in the last digit
        assert!((t / temperature - 1.0).abs() < 8e-4 && (found / stress - 1.0).abs() < 9e-4, "{phi}: {t} {found}");
    }
}

#[test]
fn a_gas_in_equilibrium_has_the_viscosity_of_enskog() {
    // Of molecular dynamics the viscosity over Enskog's is 1.00 ± 0.02 up to φ = 0.3 (Alder, Gass and Wainwright 1970, J.
    // Chem. Phys. 53, 3813). The box of six to nine diameters may add 2 %.
    for (model, phi, longest, interval, duration) in [
        (Model::Hard, 0.1, 8.0, 0.2, 3000.0),
        (Model::Hard, 0.3, 1.4, 0.03, 600.0),
        (Model::Soft, 0.3, 1.4, 0.03, 20.0),
    ] {
        let mut gas = gas(108, phi, 1.0, model);
        (gas.run.duration, gas.statistics.sample_interval) = (duration, Some(interval));
        if model == Model::Soft {
            let law = ContactLaw::linear(1e5);
            (gas.soft.law, gas.run.spheres) = (Some(law), Spheres::Soft(law));
        }
        let found = viscosity(&gas, 0.0, Some(longest));
        assert!(found.remark.is_none());
        let (_, theory) = found.numbers[0].theory.unwrap();
        let chi = contact_value(phi);
        // T is 1 m²/s², and a sphere of unit diameter has a mass of 1 kg
        let mass = gas.scene.species[0].mass();
        let dilute = 5.0 / 16.0 / PI.sqrt() * mass;
        let y = 4.0 * phi;
        let enskog = dilute * (1.0 / chi + 0.8 * y + (0.16 + 48.0 / (25.0 * PI)) * y * y * chi);
        // T at the start is drawn from 107 x 3 numbers
        assert!((theory / enskog - 1.0).abs() < 0.12, "{theory} {enskog}");
        let eta = number(&found, "viscosity_Pa_s");
        println!("{model:?}, {phi}: {} ± {} of Enskog", eta.value / theory, eta.error.unwrap() / theory);
        agrees(&format!("{model:?}, φ = {phi}"), eta, theory, 0.04 * theory);
        assert!(eta.error.unwrap() < if model == Model::Hard { 0.05 } else { 0.3 } * theory);
    }
}

#[test]
fn samples_that_are_far_apart_are_told() {
    let mut gas = gas(100, 0.3, 1.0, Model::Hard);
    (gas.run.duration, gas.statistics.sample_interval) = (40.0, Some(0.2));
    let found = viscosity(&gas, 0.0, Some(2.0));
    assert!(found.remark.is_some_and(|remark| remark.contains("sample_interval")));
}

/// In a steadily sheared gas of nearly elastic spheres, the shear rate is small compared with the collision rate, so a
/// theory of first order in the shear rate holds.
#[test]
fn a_sheared_box_has_the_viscosity_of_garzo_and_dufty() {
    for (phi, duration) in [(0.1, 400.0), (0.3, 150.0)] {
        let mut gas = gas(200, phi, 0.98, Model::Hard);
        // T of the steady state, so that the run begins near it
        let transport = GasTransport::of(phi, 0.98);
        let t = (transport.steady_shear_rate() * collision_frequency(6.0 * phi / PI, 1.0, 1.0)).powi(-2);
        gas.scene.domain = gas.scene.domain.sheared(1.0, 0.0);
        gas.start[0].velocity_fluctuation = Vector3::repeat(t.sqrt());
        (gas.run.duration, gas.statistics.sample_interval) = (duration, Some(0.25));
        let found = viscosity(&gas, 0.1 * duration, None);
        assert!(
            found.curves.is_empty() && found.remark.is_some_and(|remark| remark.contains("nearly elastic spheres"))
        );
        let (name, theory) = found.numbers[0].theory.unwrap();
        assert_eq!(name, "Garzó and Dufty");
        // second order in the rate: (γ/ν_0)² is 0.02, and the stress at e = 0.9, where it is 0.1, is 6 % less
        agrees(&format!("φ = {phi}"), number(&found, "viscosity_Pa_s"), theory, 0.02 * theory);
        let kinetic = number(&found, "kinetic_viscosity_Pa_s").value;
        assert!(kinetic > 0.1 * theory && kinetic < 0.9 * theory, "{kinetic} of {theory}");
    }
}

const CASE: &str = "[domain]\nsize = [\"10 mm\", \"10 mm\", \"10 mm\"]\nperiodic = [\"x\", \"y\", \"z\"]\n[[particles]]\n\
                    diameter = \"1 mm\"\ndensity = \"2500 kg/m^3\"\ncount = 100\nvelocity_fluctuation = \"1 m/s\"\n[contact]\n\
                    restitution = 1.0\nfriction = 0.0\n[run]\nduration = \"1 s\"\n[statistics]\nsample_interval = \"1 ms\"\n";

#[test]
fn cases_ask_for_a_viscosity_where_there_is_one() {
    let with = |table: &str, sets: &[&str]| case(&format!("{CASE}{table}"), Model::Hard, sets);
    let at_rest = "[observe.viscosity]\nduration = \"20 ms\"\n";
    assert_eq!(with(at_rest, &[]).unwrap().observe.viscosity, Some(ViscositySettings { duration: Some(0.02) }));
    let sheared = "[observe.viscosity]\n[domain.shear]\nrate = \"100 1/s\"\n";
    assert_eq!(with(sheared, &[]).unwrap().observe.viscosity, Some(ViscositySettings { duration: None }));
    for (table, sets, words) in [
        ("[observe.viscosity]\n", &[][..], "required key `observe.viscosity.duration`"),
        (at_rest, &["contact.restitution=0.9"], "needs a sheared box or a gas in equilibrium"),
        (at_rest, &["observe.viscosity.duration=5 ms"], "10 samples"),
        (at_rest, &["observe.viscosity.duration=2 s"], "up to the run"),
        (sheared, &["observe.viscosity.duration=20 ms"], "is not used in a sheared box"),
    ] {
        let why = with(table, sets).unwrap_err();
        assert!(why.contains(words), "{why}");
    }
}
