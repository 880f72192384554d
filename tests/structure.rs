//! Structure factor, contact network and coarse-grained fields, against plain sums, the Percus-Yevick equation, Carnahan and
//! Starling, statics, a crystal, and the laws of conservation.

use crate::measurements::{agrees, curve, gas, measured, number, of_states, points};
use crate::support::Crew;
use diptych::Vector3;
use diptych::domain::Domain;
use diptych::experiment::{
    Amount, ClustersSettings, DiffusionSettings, Experiment, FieldsSettings, FreeSurfaceSettings, Model,
    ObserveSettings, PairDistributionSettings, StructureFactorSettings, VelocityDistributionSettings,
    ViscositySettings,
};
use diptych::observe::{ContactNetwork, Fields, Measurement, Measurements, Observer, StructureFactor, run};
use diptych::particles::Particles;
use diptych::placement::initial_state;
use diptych::schedule::Schedule;
use diptych::simulation::Simulation;
use rand::{RngExt, SeedableRng};
use rand_distr::StandardNormal;
use rand_xoshiro::Xoshiro256PlusPlus;
use std::f64::consts::PI;

/// Mean of the structure factor over all wave vectors in a periodic cube whose wavenumber is in a bin, as a plain sum
/// over both signs. Also returns the number of wave vectors.
fn plain_structure(size: f64, positions: &[Vector3<f64>], from: f64, to: f64) -> (f64, usize) {
    let most = (to * size / (2.0 * PI)).ceil() as i32;
    let (mut sum, mut count) = (0.0, 0);
    for x in -most..=most {
        for y in -most..=most {
            for z in -most..=most {
                let k = Vector3::new(f64::from(x), f64::from(y), f64::from(z)) * (2.0 * PI / size);
                if (x, y, z) != (0, 0, 0) && (from..to).contains(&k.norm()) {
                    let parts = positions.iter().map(|p| k.dot(p).sin_cos());
                    let (sin, cos) = parts.fold((0.0, 0.0), |sum, part| (sum.0 + part.0, sum.1 + part.1));
                    sum += (sin * sin + cos * cos) / positions.len() as f64;
                    count += 1;
                }
            }
        }
    }
    (sum / count as f64, count)
}

#[test]
fn the_structure_factor_is_a_plain_sum() {
    let mut random = Xoshiro256PlusPlus::seed_from_u64(11);
    let gas = gas(50, 0.1, 1.0, Model::Hard);
    let size = gas.scene.domain.size.x;
    let mut state = points(&gas, 50, &mut random);
    let positions = state.position.clone();
    // places in the neighbouring periods are the same
    state.position[3].x += size;
    state.position[7].z -= size;
    let settings = StructureFactorSettings { wavelength: size / 3.5, bins: 7 };
    let found = of_states(&gas, StructureFactor::new(&gas, &Schedule::new(&gas), settings), [state]);
    let width = PI / size;
    let mut bins = found.places.iter().zip(curve(&found, "S"));
    for bin in 0..7 {
        let (exact, count) = plain_structure(size, &positions, f64::from(bin) * width, f64::from(bin + 1) * width);
        // bins with more than 24 vectors of one sign use some of them
        if count == 0 || count > 48 {
            if count > 48 {
                bins.next();
            }
            continue;
        }
        let (place, value) = bins.next().unwrap();
        assert!((f64::from(bin) * width..f64::from(bin + 1) * width).contains(place), "{place}");
        // rounding of 50 terms
        assert!((value.unwrap().value - exact).abs() < 1e-12 * (1.0 + exact), "bin {bin}: {value:?} {exact}");
    }
}

/// Structure factor at the wavenumber `q` by the Percus-Yevick equation, from Simpson's rule over the direct
/// correlation function.
fn percus_yevick_structure(q: f64, phi: f64) -> f64 {
    const PARTS: usize = 2000;
    let free = (1.0 - phi).powi(4);
    let (first, second) = ((1.0 + 2.0 * phi).powi(2) / free, -(1.0 + 0.5 * phi).powi(2) / free);
    let direct = |x: f64| -(first + 6.0 * phi * second * x + 0.5 * phi * first * x.powi(3));
    let of = |x: f64| x * (q * x).sin() / q * direct(x);
    let weight = |k: usize| if k == 0 || k == PARTS { 1.0 } else { 2.0 + 2.0 * (k % 2) as f64 };
    let integral: f64 = (0..=PARTS).map(|k| weight(k) * of(k as f64 / PARTS as f64)).sum::<f64>() / (3 * PARTS) as f64;
    1.0 / (1.0 - 24.0 * phi * integral)
}

#[test]
fn the_structure_factor_is_that_of_hard_spheres() {
    let mut random = Xoshiro256PlusPlus::seed_from_u64(12);
    for (phi, duration) in [(0.0, 0.0), (0.1, 400.0), (0.3, 150.0), (0.45, 60.0)] {
        let mut gas = gas(500, if phi > 0.0 { phi } else { 0.1 }, 1.0, Model::Hard);
        let settings = StructureFactorSettings { wavelength: 0.5, bins: 40 };
        let found = if phi > 0.0 {
            gas.run.duration = duration;
            gas.statistics.sample_interval = Some(duration / 200.0);
            measured(&gas, 0.05 * duration, |gas, schedule| StructureFactor::new(gas, schedule, settings))
        } else {
            let states: Vec<Particles> = (0..200).map(|_| points(&gas, 500, &mut random)).collect();
            of_states(&gas, StructureFactor::new(&gas, &Schedule::new(&gas), settings), states)
        };
        let (_, theory) = found.curves[0].theory.as_ref().unwrap();
        for ((q, value), theory) in found.places.iter().zip(curve(&found, "S")).zip(theory) {
            let value = value.unwrap();
            if phi == 0.0 {
                agrees(&format!("ideal gas: S({q})"), value, 1.0, 0.0);
                continue;
            }
            let exact = percus_yevick_structure(*q, phi);
            // S over a bin of width 0.3 differs from that at its mean wave number by the curvature
            assert!((theory - exact).abs() < 0.06 * exact.max(0.2), "{q}: {theory} {exact}");
            // Percus-Yevick is 6 % high at the first peak at a volume fraction of 0.45 (Hansen and McDonald 2013, section 4.4)
            agrees(&format!("φ = {phi}: S({q})"), value, *theory, (0.02 + 0.3 * phi * phi) * theory.max(0.2));
        }
        if phi > 0.0 {
            let exact = (1.0 - phi).powi(4) / (1.0 + 4.0 * phi + 4.0 * phi * phi - 4.0 * phi.powi(3) + phi.powi(4));
            // S at the smallest k of the box, q = 0.5 to 0.7, is above S(0) by up to q²/12 of its scale
            agrees(
                &format!("φ = {phi}: S at the smallest k"),
                number(&found, "smallest_k"),
                exact,
                0.05 * exact + 0.01,
            );
        }
    }
}

/// Experiment and state of spheres in a face-centred cubic crystal. Neighbours overlap by a thousandth of the
/// diameter.
fn crystal() -> (Experiment, Particles) {
    let mut crystal = gas(256, 0.1, 1.0, Model::Soft);
    let edge = 2.0_f64.sqrt() * 0.999;
    crystal.scene.domain = Domain::new(Vector3::repeat(4.0 * edge), [true; 3]);
    let mut state = Particles::default();
    for k in 0..64 {
        let cell = Vector3::new(f64::from(k % 4), f64::from(k / 4 % 4), f64::from(k / 16));
        for place in [[0.0, 0.0, 0.0], [0.5, 0.5, 0.0], [0.5, 0.0, 0.5], [0.0, 0.5, 0.5]] {
            state.push((cell + Vector3::from(place)) * edge, Vector3::zeros(), 0.5, 1.0, 0);
        }
    }
    crystal.start[0].amount = Amount::Placed(state.clone());
    (crystal, state)
}

#[test]
fn a_crystal_has_twelve_contacts() {
    let (crystal, state) = crystal();
    let mut network = ContactNetwork::new(&crystal, &Schedule::new(&crystal));
    let simulation = Simulation::new(&crystal, state);
    network.see(&simulation);
    network.end(&simulation);
    let found = network.result(&crystal, 0.0);
    let value = |column: &str| {
        found.numbers.iter().find(|number| number.quantity.column == column).unwrap().value.unwrap().value
    };
    assert_eq!((value("coordination"), value("mechanical_coordination"), value("rattlers")), (12.0, 12.0, 0.0));
    for (component, exact) in [("xx", 1.0), ("yy", 1.0), ("zz", 1.0), ("xy", 0.0), ("xz", 0.0), ("yz", 0.0)] {
        // a third by the symmetry of the cube; rounding
        assert!((value(&format!("fabric_{component}")) - exact / 3.0).abs() < 1e-12, "{component}");
    }
    // the elastic force of the spring, 1e6 N/m times 0.001 m
    assert!((value("mean_force_N") - 1000.0).abs() < 1e-6 && found.lines.len() == 6 * 256);
    for line in &found.lines {
        let apart = line.from - line.to;
        assert!(line.other.is_some_and(|other| other > line.id), "{line:?}");
        assert!((apart.norm() - 0.999).abs() < 1e-12 && (apart - line.normal * 0.999).norm() < 1e-12, "{line:?}");
        assert!((0..3).all(|axis| (0.0..crystal.scene.domain.size[axis]).contains(&line.from[axis])));
    }
}

/// A column of spheres at rest: the contact with number k from the top carries the weight of k spheres.
#[test]
fn a_column_carries_its_weight() {
    let path = std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("cases/column.toml");
    let sets = ["observe.contact_network={}".to_owned(), "run.average_from=0.35 s".to_owned()];
    let case = diptych::case::Case::read(&path, &sets).unwrap();
    let (column, _) = case.experiment(Some(Model::Soft), None).unwrap();
    let start = initial_state(&column).unwrap();
    let (outcome, _) = diptych::runs::execute(&column, start, &mut []);
    let found = &outcome.observations[0];
    let value = |column: &str| number(found, column).value;
    // 9 contacts between spheres and one with the floor; the uppermost sphere has one contact
    assert!((value("coordination") - 1.9).abs() < 1e-12 && (value("rattlers") - 0.1).abs() < 1e-12);
    assert!((value("mechanical_coordination") - 2.0).abs() < 1e-12);
    assert!((value("fabric_yy") - 1.0).abs() < 1e-12 && value("fabric_xx") == 0.0);
    let weight = column.scene.species[0].mass() * 9.81;
    assert_eq!(found.lines.len(), 10);
    for line in &found.lines {
        // ids are counted from the floor
        let carried = if line.other.is_some() { 9 - line.id } else { 10 };
        // what is left of the motion after 0.35 s, eight relaxation times of the slowest mode
        assert!((line.force / weight - f64::from(carried)).abs() < 0.02 * f64::from(carried), "{line:?}, {weight}");
        assert!((line.normal.y.abs() - 1.0).abs() < 1e-12);
    }
    // hard spheres have no contacts, and say so
    let mut hard = gas(20, 0.1, 1.0, Model::Hard);
    (hard.run.duration, hard.observe.contact_network) = (0.1, true);
    let start = initial_state(&hard).unwrap();
    let (outcome, _) = diptych::runs::execute(&hard, start, &mut []);
    let found = &outcome.observations[0];
    assert!(found.remark.is_some() && found.numbers.iter().all(|number| number.value.is_none()));
}

/// The integral of each coarse-grained field over the box is the sum over the particles.
#[test]
fn fields_conserve_mass_momentum_and_stress() {
    let mut random = Xoshiro256PlusPlus::seed_from_u64(13);
    for periodic in [[true; 3], [true, false, true], [false; 3]] {
        for width in [1e-3, 0.7, 3.0] {
            let mut gas = gas(300, 0.3, 1.0, Model::Soft);
            let size = Vector3::new(8.0, 10.0, 9.0);
            gas.scene.domain = Domain::new(size, periodic);
            let mut state = points(&gas, 300, &mut random);
            let mut draw = || Vector3::from_fn(|_, _| random.sample(StandardNormal));
            for (v, x) in state.velocity.iter_mut().zip(&mut state.position) {
                *v = draw();
                // half of the places are in a neighbouring period
                if periodic[2] && v.x > 0.0 {
                    x.z += size.z;
                }
            }
            let settings = FieldsSettings { width, cells: [4, 7, 5] };
            let (mass, momentum) = (state.total_mass(), state.momentum());
            let mut fields = Fields::new(&gas, &Schedule::new(&gas), settings);
            let mut network = ContactNetwork::new(&gas, &Schedule::new(&gas));
            let simulation = Simulation::new(&gas, state);
            fields.see(&simulation);
            network.end(&simulation);
            let found = fields.result(&gas, 0.0);
            let grid = found.grid.unwrap();
            let (cell, [rho, velocity, kinetic, contact]) =
                (grid.spacing.product(), [0, 1, 2, 3].map(|k| grid.fields[k].2.as_slice()));
            assert!((rho.iter().sum::<f64>() * cell - mass).abs() < 1e-11 * mass);
            for axis in 0..3 {
                let total: f64 = rho.iter().zip(velocity.chunks(3)).map(|(rho, v)| rho * v[axis]).sum();
                assert!((total * cell - momentum[axis]).abs() < 1e-10 * mass, "{axis}: {total} {momentum}");
                // kinetic stress and ρ V V together are Σ m v v
                let all: f64 = rho
                    .iter()
                    .zip(velocity.chunks(3))
                    .zip(kinetic.chunks(6))
                    .map(|((rho, v), six)| rho * v[axis] * v[axis] + six[axis])
                    .sum();
                let exact: f64 = simulation.particles.velocity.iter().map(|v| v[axis] * v[axis]).sum();
                assert!((all * cell - exact).abs() < 1e-10 * exact);
                let pairs = network.result(&gas, 0.0).lines;
                let pairs = pairs.iter().filter(|line| line.other.is_some());
                let exact: f64 = pairs.map(|line| (line.from - line.to)[axis] * line.normal[axis] * line.force).sum();
                let all: f64 = contact.chunks(6).map(|six| six[axis]).sum();
                assert!(exact > 0.0 && (all * cell - exact).abs() < 1e-10 * exact, "{all} {exact}");
            }
        }
    }
}

/// Fields of a crystal, coarse-grained with a Gaussian that is wider than the cells of the crystal. Density and stress
/// are uniform, and the pressure is Σ r f/(3V) (distance r and force f of each contact, volume V).
#[test]
fn fields_of_a_crystal_are_uniform() {
    let (crystal, state) = crystal();
    let settings = FieldsSettings { width: 1.5, cells: [5, 5, 5] };
    let mut fields = Fields::new(&crystal, &Schedule::new(&crystal), settings);
    fields.see(&Simulation::new(&crystal, state));
    let grid = fields.result(&crystal, 0.0).grid.unwrap();
    let volume = crystal.scene.domain.volume();
    let pressure = 6.0 * 256.0 * 0.999 * 1000.0 / (3.0 * volume);
    // what is left of the first waves of the crystal, exp(-(2π w/a)²/2) with a = 1/√2, is below rounding; that of the
    // grid and of the cut at four widths is 1e-3
    for (rho, six) in grid.fields[0].2.iter().zip(grid.fields[3].2.chunks(6)) {
        assert!((rho * volume / 256.0 - 1.0).abs() < 2e-3, "{rho}");
        assert!(six[..3].iter().all(|p| (p / pressure - 1.0).abs() < 2e-3), "{six:?} {pressure}");
        assert!(six[3..].iter().all(|p| (p / pressure).abs() < 2e-3), "{six:?} {pressure}");
    }
}

/// The kinetic stress of a gas of hard spheres in a cell is n m T for any grid (number density n, mass m, granular
/// temperature T).
#[test]
fn fields_of_a_gas_have_its_temperature() {
    let mut gas = gas(1000, 0.1, 1.0, Model::Hard);
    gas.run.duration = 40.0;
    gas.statistics.sample_interval = Some(0.2);
    let settings = FieldsSettings { width: 1.0, cells: [3, 4, 3] };
    let found = measured(&gas, 0.0, |gas, schedule| Fields::new(gas, schedule, settings));
    let density = 1000.0 / gas.scene.domain.volume();
    for layer in 0..4 {
        // T is 1 m²/s²; the mean velocity of a layer is subtracted over the whole time
        agrees(&format!("density {layer}"), curve(&found, "density_kg_m3")[layer].unwrap(), density, 0.0);
        agrees(&format!("stress {layer}"), curve(&found, "kinetic_yy_Pa")[layer].unwrap(), density, 0.005 * density);
    }
    assert!(curve(&found, "contact_yy_Pa").iter().all(|value| value.unwrap().value == 0.0));
    let mass = &found.numbers[0];
    assert!((mass.value.unwrap().value / mass.theory.unwrap().1 - 1.0).abs() < 1e-12);
}

/// Results of all measurements of a run that `size` threads share in place of processes; `None` means one process.
fn shared_by(size: Option<usize>, gas: &Experiment) -> String {
    let (schedule, start) = (Schedule::new(gas), initial_state(gas).unwrap());
    let mut own = Measurements::new(gas, &schedule);
    let count = own.each().count();
    let simulation = || Simulation::new(gas, start.clone());
    let mut crew = Crew::of(size.unwrap_or(1));
    let lead = crew.remove(0);
    std::thread::scope(|scope| {
        for communicator in crew {
            scope.spawn(|| {
                let mut own = Measurements::new(gas, &schedule);
                simulation().shared(communicator, count).follow(&mut |simulation, place, kept| {
                    let observer = own.each().nth(place).unwrap();
                    kept.into_iter().for_each(|kept| observer.restore(kept).unwrap());
                    observer.see(simulation);
                });
            });
        }
        let mut simulation = if size.is_some() { simulation().shared(lead, count) } else { simulation() };
        let mut observers: Vec<&mut dyn Observer> = own.each().map(|one| one as &mut dyn Observer).collect();
        run(&mut simulation, &schedule, &mut observers).unwrap();
    });
    format!("{:?}", own.results(gas, 0.0))
}

#[test]
fn measurements_of_several_processes_are_those_of_one() {
    for model in [Model::Hard, Model::Soft] {
        let mut gas = gas(600, 0.05, 0.9, model);
        (gas.run.duration, gas.statistics.sample_interval) = (1.0, Some(0.05));
        gas.observe = ObserveSettings {
            seen_gas: false,
            pair_distribution: Some(PairDistributionSettings { reach: 4.0, bins: 20 }),
            velocity_distribution: Some(VelocityDistributionSettings { largest_speed: 4.0, bins: 20 }),
            diffusion: Some(DiffusionSettings { duration: 0.1 }),
            structure_factor: Some(StructureFactorSettings { wavelength: 2.0, bins: 10 }),
            contact_network: true,
            fields: Some(FieldsSettings { width: 1.0, cells: [3, 4, 5] }),
            viscosity: Some(ViscositySettings { duration: Some(0.2) }),
            clusters: Some(ClustersSettings { gap: 0.1 }),
            free_surface: Some(FreeSurfaceSettings { up: (1, 1.0), spacing: 0.5, smoothing: 0.0 }),
        };
        let alone = shared_by(None, &gas);
        assert!(alone.len() > 10_000);
        for size in [1, 2, 3] {
            assert!(shared_by(Some(size), &gas) == alone, "{model:?} on {size}");
        }
    }
}
