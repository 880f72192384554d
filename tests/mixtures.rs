//! Mixtures: pairs of species with their own contact properties, and spheres of very different sizes.

mod moving_walls;

use crate::support::*;
use diptych::engine::hard::Hard;
use diptych::experiment::{Experiment, Model};
use diptych::neighbours::NeighbourList;
use diptych::observe::{KindAverages, MeetingAverages, SpeciesAverages};
use diptych::placement::initial_state;
use diptych::simulation::{Simulation, soft_step};
use diptych::statistics::Estimate;
use diptych::study::execute;

/// Case of two species of spheres and a floor. Two spheres of glass, a sphere of glass and one of steel, and a sphere
/// of steel and the floor have one impact each, at 1 m/s and 45 degrees, far from other spheres.
const PAIRS: &str = r#"
[domain]
size = ["40 mm", "10 mm", "10 mm"]
periodic = ["x", "z"]

[[particles]]
name = "glass"
diameter = "1 mm"
density = "2500 kg/m^3"
at = [
    { position = ["2 mm", "5 mm", "5 mm"], velocity = ["1 m/s", "1 m/s", "0 m/s"] },
    { position = ["3.05 mm", "5.05 mm", "5 mm"] },
    { position = ["12 mm", "5 mm", "5 mm"], velocity = ["1 m/s", "1 m/s", "0 m/s"] },
]

[[particles]]
name = "steel"
diameter = "2 mm"
density = "7800 kg/m^3"
at = [
    { position = ["13.55 mm", "5.05 mm", "5 mm"] },
    { position = ["25 mm", "1.05 mm", "5 mm"], velocity = ["1 m/s", "-1 m/s", "0 m/s"] },
]

[[walls]]
name = "floor"
plane = { point = ["0 m", "0 m", "0 m"], normal = [0, 1, 0] }
restitution = 0.6
friction = 0.3

[[walls]]
plane = { point = ["0 m", "10 mm", "0 m"], normal = [0, -1, 0] }
restitution = 1.0

[contact]
restitution = 0.95
friction = 0.05

[[contact.pairs]]
between = ["steel", "glass"]
restitution = 0.8
friction = 0.2
overlap = "2 um"
impact_speed = "1 m/s"

[[contact.pairs]]
between = ["floor", "steel"]
restitution = 0.7
friction = 0.1
contact_time = "2e-6 s"

[soft.linear_spring_dashpot]
stiffness = "50 MN/m"

[soft]
steps_per_contact = 50

[run]
model = "hard"
duration = "0.3 ms"
"#;

/// Restitution and friction of the three impacts, from the velocities after them: glass on glass, glass on steel, steel
/// on the floor.
fn met(experiment: &Experiment) -> [[f64; 2]; 3] {
    let start = initial_state(experiment).unwrap();
    let mut simulation = Simulation::new(experiment, start);
    simulation.run(6, 5e-5).unwrap();
    assert_eq!((simulation.record.pairs.count, simulation.record.walls.count), (2, 1));
    let mut after = simulation.particles.clone();
    after.sort_by_id();
    let v = |k: usize| after.velocity[k];
    // the normal is x; the slip is along y and does not end, so that J_t = μ (1 + e) M u
    let pair = |a: usize, b: usize| {
        let mass = 1.0 / (1.0 / after.mass[a] + 1.0 / after.mass[b]);
        let e = v(b).x - v(a).x;
        [e, after.mass[b] * v(b).y / (mass * (1.0 + e))]
    };
    let e = v(4).y;
    [pair(0, 1), pair(2, 3), [e, (1.0 - v(4).x) / (1.0 + e)]]
}

#[test]
fn every_pair_has_its_own_restitution_and_friction() {
    let want = [[0.95, 0.05], [0.8, 0.2], [0.7, 0.1]];
    for (model, sets, tolerance) in [
        (Model::Hard, vec![], 1e-9),
        // during a soft contact the spheres continue to slide, and the normal turns by a few thousandths of a radian
        (Model::Soft, vec!["soft.stepping=local"], 5e-3),
        (Model::Soft, vec!["soft.stepping=uniform"], 5e-3),
    ] {
        let experiment = case(PAIRS, model, &sets).unwrap();
        for (found, want) in met(&experiment).iter().zip(&want) {
            assert!((found[0] - want[0]).abs() < tolerance, "{sets:?}: {found:?} for {want:?}");
            let friction = if model == Model::Hard { 1e-9 } else { 0.03 * want[1] };
            assert!((found[1] - want[1]).abs() < friction, "{sets:?}: {found:?} for {want:?}");
        }
    }
}

/// A contact has the duration or the overlap that the case gives for its pair. The stiffest pair determines the time
/// step.
#[test]
fn stiffness_of_a_pair_from_contact_time_or_overlap() {
    let sets =
        ["soft.stepping=local", "contact.friction=0", "contact.pairs[0].friction=0", "contact.pairs[1].friction=0"];
    let experiment = case(PAIRS, Model::Soft, &sets).unwrap();
    let start = initial_state(&experiment).unwrap();
    let step = soft_step(&experiment, start.len());
    let mut simulation = Simulation::new(&experiment, start);
    simulation.run(6, 5e-5).unwrap();
    let (pairs, walls) = (simulation.record.pairs.summary(), simulation.record.walls.summary());
    // of the two pairs, glass and steel is much softer
    close("overlap", pairs.largest_overlap.unwrap() * 1e-3, 2e-6, 1e-3);
    close("contact time", walls.mean_duration.unwrap(), 2e-6, 1e-4);
    // glass on glass is the stiffest pair here, with 50 MN/m, and has the shortest contact
    let spring = LinearSpring { stiffness: 50e6 };
    let mass = 2500.0 * std::f64::consts::PI / 6.0 * 1e-9;
    close("time step", step, spring.contact_time(0.5 * mass, 0.95) / 50.0, 1e-9);
    // if another pair is made stiffer, it determines the time step
    let stiffer = case(PAIRS, Model::Soft, &[&sets[..], &["contact.pairs[1].contact_time=1e-7 s"]].concat()).unwrap();
    close("time step of the stiffest", soft_step(&stiffer, 5), 1e-7 / 50.0, 1e-9);
}

#[test]
fn pairs_that_cannot_be_are_refused() {
    for (set, words) in [
        ("contact.pairs[0].between=[\"steel\", \"glas\"]", vec!["glas", "did you mean `glass`", "floor"]),
        ("contact.pairs[0].between=[\"floor\", \"floor\"]", vec!["two walls, which never meet"]),
        ("contact.pairs[0].between=[\"steel\", \"floor\"]", vec!["listed before"]),
        ("contact.pairs[0].between=[\"steel\"]", vec!["between"]),
        ("contact.pairs[0].restitution=1.5", vec!["restitution", "0 ..= 1"]),
        ("contact.pairs[0].friction=-1", vec!["friction", "0 ..= 100"]),
        ("contact.pairs[0].stiffness=1 kN/m", vec!["keep one of `stiffness`, `contact_time` and `overlap`"]),
        ("contact.pairs[0].overlap=1e-30 m", vec!["means a spring of", "allowed: 1e-9 ..= 1e20 N/m"]),
        ("contact.pairs[1].impact_speed=1 m/s", vec!["goes with `overlap`"]),
        ("walls[0].name=glass", vec!["both called \"glass\""]),
    ] {
        let message = case(PAIRS, Model::Soft, &[set]).expect_err(set);
        for part in words {
            assert!(message.contains(part), "{set}: no {part:?} in\n{message}");
        }
    }
    let text = PAIRS.replace("impact_speed = \"1 m/s\"\n", "");
    let message = case(&text, Model::Soft, &[]).expect_err("no speed");
    assert!(message.contains("add `impact_speed`"), "{message}");
    let missing = PAIRS.replace("between = [\"steel\", \"glass\"]\n", "");
    let message = case(&missing, Model::Hard, &[]).expect_err("nobody");
    assert!(message.contains("contact.pairs[0].between"), "{message}");
}

/// Case of a periodic box with spheres of two sizes, in a ratio of ten; each size has a volume fraction of 0.15.
const TEN_TO_ONE: &str = r#"
[domain]
size = ["12 mm", "10 mm", "9 mm"]
periodic = ["x", "y", "z"]

[[particles]]
name = "small"
diameter = "0.4 mm"
density = "1000 kg/m^3"
volume_fraction = 0.15
velocity_fluctuation = "0.5 m/s"

[[particles]]
name = "large"
diameter = "4 mm"
density = "1000 kg/m^3"
volume_fraction = 0.15

[contact]
restitution = 1.0

[run]
model = "hard"
duration = "1 ms"
"#;

/// A random start must find room for small spheres between large ones, and for large ones among small ones. This takes
/// only seconds, because each size has its own cells and the smaller sphere of a pair is moved aside.
#[test]
fn ten_to_one_starts_without_overlap() {
    for share in ["0.15", "0.08"] {
        // volume fractions for which spheres are pushed apart, and for which they are inserted
        let sets = [format!("particles[0].volume_fraction={share}"), format!("particles[1].volume_fraction={share}")];
        let experiment = case(TEN_TO_ONE, Model::Hard, &[&sets[0], &sets[1]]).unwrap();
        let start = initial_state(&experiment).unwrap();
        assert!(smallest_gap(&experiment.scene, &start) > 0.0, "{share}");
        // every particle has its species at the start
        let large = start.radius.iter().zip(&start.species).filter(|(r, species)| (**r == 2e-3) != (**species == 1));
        assert_eq!(large.count(), 0);
    }
}

/// Every pair whose gap is smaller than the margin (skin) of the neighbour list is listed once, for all sizes, with
/// and without periodic sides.
#[test]
fn lists_of_very_different_sizes_hold_every_pair_once() {
    for (periodic, seed) in [([true; 3], 1), ([false, true, false], 2)] {
        let species = small();
        let scene = empty([6e-3, 5e-3, 7e-3], periodic, species, surface(1.0, 0.0));
        let mut particles = random(&scene, 400, 0.1, seed);
        // radii from 1 to 1/60, with all sizes in between, which need seven levels of cells
        for (k, r) in particles.radius.iter_mut().enumerate() {
            *r = 1e-3 * 60f64.powf(-(k as f64 / 399.0).sqrt());
        }
        let mut list = NeighbourList::default();
        list.build(&mut particles, &scene, 1e-3);
        let near = |i: usize, j: usize| {
            let apart = scene.domain.separation(&particles.position[i], &particles.position[j]).norm();
            apart < particles.radius[i] + particles.radius[j] + list.skin()
        };
        let (mut want, count) = (Vec::new(), particles.len());
        for i in 0..count {
            want.extend((i + 1..count).filter(|&j| near(i, j)).map(|j| (i as u32, j as u32)));
        }
        let mut found: Vec<(u32, u32)> = list.pairs.iter().map(|p| (p.i.min(p.j), p.i.max(p.j))).collect();
        assert!(list.pairs.is_sorted_by_key(|pair| pair.i), "grouped by the first");
        found.sort_unstable();
        assert!(want.len() > 1000);
        assert_eq!(found, want);
    }
}

/// The event queue of all particles finds every touch among three sizes. There are no overlaps, and energy is
/// conserved, in a periodic box and between walls.
#[test]
fn one_calendar_misses_no_touch_of_unlike_spheres() {
    let middle = "name = \"middle\"\ndiameter = \"1.1 mm\"\ndensity = \"1000 kg/m^3\"\nvolume_fraction = 0.05\n\n[[particles]]\nname = \"large\"";
    let all = TEN_TO_ONE.replace("name = \"large\"", middle);
    let mut between = all.replace("[\"x\", \"y\", \"z\"]", "[\"x\", \"z\"]");
    for plane in ["0 m\", \"0 m\"], normal = [0, 1, 0]", "10 mm\", \"0 m\"], normal = [0, -1, 0]"] {
        between += &format!("\n[[walls]]\nplane = {{ point = [\"0 m\", \"{plane} }}\nrestitution = 1.0\n");
    }
    for (what, text) in [("periodic", all), ("walls", between)] {
        let experiment = case(&text, Model::Hard, &["particles[0].volume_fraction=0.12"]).unwrap();
        let start = initial_state(&experiment).unwrap();
        let energy = start.kinetic_energy();
        let engine = Box::new(Hard::with_one_calendar());
        let mut simulation = Simulation::with_engine(experiment.scene.clone(), start, engine);
        for _ in 0..3 {
            simulation.run(2, 5e-4).unwrap();
            let gap = smallest_gap(&experiment.scene, &simulation.particles);
            assert!(gap > -1e-15, "{what}: {gap:e} m");
        }
        let count = simulation.record.pairs.count;
        assert!(count > 4000, "{what}: {count}");
        close("energy", simulation.particles.kinetic_energy() / energy, 1.0, 1e-12);
    }
}

/// Case of 1000 elastic spheres, and 100 spheres three times as large, at a volume fraction of 0.2. Both have equal m
/// v² at the start.
const THREE_TO_ONE: &str = r#"
[domain]
size = ["8.53 mm", "8.53 mm", "8.53 mm"]
periodic = ["x", "y", "z"]

[[particles]]
name = "small"
diameter = "0.4 mm"
density = "1000 kg/m^3"
count = 1000
velocity_fluctuation = "0.55 m/s"

[[particles]]
name = "large"
diameter = "1.2 mm"
density = "1000 kg/m^3"
count = 100

[contact]
restitution = 1.0

[soft.linear_spring_dashpot]
stiffness = "30 kN/m"

[soft]
stepping = "uniform"

[run]
model = "hard"
duration = "1 s"
average_from = "20 ms"

[statistics]
slices = 1
"#;

/// [-] contact value of two spheres at the volume fraction `eta` [-] of all spheres. `z` is twice the product of the
/// two diameters over their sum, times the mean square over the mean cube of all diameters.
type ContactValue = fn(f64, f64) -> f64;

/// Contact value of Boublík (1970), J. Chem. Phys. 53, 471, and Mansoori, Carnahan, Starling and Leland (1971), J.
/// Chem. Phys. 54, 1523.
fn bmcsl(eta: f64, z: f64) -> f64 {
    let left = 1.0 - eta;
    1.0 / left + 1.5 * eta * z / left.powi(2) + 0.5 * (eta * z).powi(2) / left.powi(3)
}

/// Contact value with one more power of z. It is exact at z = 2, where BMCSL is not: there a flat wall meets spheres of
/// one size, and the pressure on the wall is that of the gas. The contact value is then the compressibility factor 1 +
/// 4 η g, with g of Carnahan and Starling 1969. (Santos, Yuste and López de Haro 2005, arXiv:cond-mat/0510102, use such
/// conditions for a cubic in z.)
fn right_at_walls(eta: f64, z: f64) -> f64 {
    let left = 1.0 - eta;
    let alike = (1.0 - 0.5 * eta) / left.powi(3);
    let start = |z: f64| 1.0 / left + 1.5 * eta * z / left.powi(2);
    // the sum of the terms a z² + b z³, at z = 1 and at z = 2
    let (one, two) = (alike - start(1.0), 1.0 + 4.0 * eta * alike - start(2.0));
    let b = 0.25 * two - one;
    start(z) + (one - b) * z * z + b * z.powi(3)
}

/// [1/s] impact rate of two species with `counts` spheres, `diameters` [m] and `masses` [kg] in equilibrium at kT [J].
/// The source is the kinetic theory of hard spheres (Chapman and Cowling 1970, section 5.21). The volume [m³] has the
/// moments ξ_2 [1/m] and ξ_3 [-] of all sizes.
fn rate(
    counts: [f64; 2],
    diameters: [f64; 2],
    masses: [f64; 2],
    same: bool,
    (kt, volume, xi, contact): (f64, f64, [f64; 2], ContactValue),
) -> f64 {
    let [d, e] = diameters;
    let [xi_2, xi_3] = xi;
    let contact = contact(xi_3, 2.0 * d * e / (d + e) * xi_2 / xi_3);
    let sigma = 0.5 * (d + e);
    let pairs = if same { 0.5 * counts[0] * (counts[0] - 1.0) } else { counts[0] * counts[1] };
    let speed = (8.0 * std::f64::consts::PI * kt * (1.0 / masses[0] + 1.0 / masses[1])).sqrt();
    pairs / volume * sigma * sigma * contact * speed
}

/// Checks that both species have equal energies, and checks the rates of the three kinds of pairs, each within
/// `tolerance` [-] or three standard errors.
fn equilibrium(experiment: &Experiment, contact: ContactValue, tolerance: f64) {
    let start = initial_state(experiment).unwrap();
    let kt = 2.0 * start.kinetic_energy() / (3.0 * start.len() as f64 - 3.0);
    let counts = [0, 1].map(|kind| start.species.iter().filter(|species| **species == kind).count() as f64);
    let (outcome, _) = execute(experiment, start, &mut []);
    assert!(outcome.failure.is_none());
    let scene = &experiment.scene;
    let volume = scene.domain.volume();
    let moment = |power: i32| {
        let each = scene.species.iter().zip(counts).map(|(s, count)| count * s.diameter.powi(power));
        std::f64::consts::PI / 6.0 * each.sum::<f64>() / volume
    };
    let near = |what: String, found: f64, error: f64, want: f64| {
        println!("{what}: {:.4} ± {:.4}", found / want, error / want);
        let bar = (3.0 * error / want).max(tolerance);
        assert!((found / want - 1.0).abs() < bar, "{what}: {found} ± {error} for {want}");
    };
    for of in &outcome.kinds.species {
        let energy = of.random_energy.unwrap();
        near(format!("energy of {}", of.name), energy.value, energy.error.unwrap(), 0.5 * kt);
    }
    assert_eq!(outcome.kinds.meetings.len(), 3);
    for met in &outcome.kinds.meetings {
        let which = met.between.each_ref().map(|name| usize::from(name == "large"));
        let (d, m) = (which.map(|k| scene.species[k].diameter), which.map(|k| scene.species[k].mass()));
        let want =
            rate(which.map(|k| counts[k]), d, m, which[0] == which[1], (kt, volume, [moment(2), moment(3)], contact));
        let found = met.rate.unwrap();
        near(format!("{:?}", met.between), found.value, found.error.unwrap(), want);
    }
    let all: u64 = outcome.kinds.meetings.iter().map(|met| met.count).sum();
    assert!(all > 10_000 && all.abs_diff(outcome.pairs.count) <= all / 100);
}

#[test]
fn elastic_mixtures_share_energy_and_meet_as_theory_says() {
    equilibrium(&case(THREE_TO_ONE, Model::Hard, &["run.duration=0.4 s"]).unwrap(), bmcsl, 0.01);
    equilibrium(&case(THREE_TO_ONE, Model::Dsmc, &["run.duration=0.4 s"]).unwrap(), bmcsl, 0.01);
    let sets = ["run.duration=25 ms", "run.average_from=5 ms"];
    equilibrium(&case(THREE_TO_ONE, Model::Soft, &sets).unwrap(), bmcsl, 0.01);
}

#[test]
#[ignore = "minutes: long enough for the rarest pairs"]
fn elastic_mixtures_for_long() {
    // at a volume fraction of 0.1, both contact values are equal within 0.1 %; docs/validation.md, "Collision rates in
    // mixtures", lists measured numbers
    let dilute = "domain.size=[\"10.747 mm\", \"10.747 mm\", \"10.747 mm\"]";
    for (model, duration) in [(Model::Hard, "run.duration=3 s"), (Model::Soft, "run.duration=0.6 s")] {
        equilibrium(&case(THREE_TO_ONE, model, &[duration, dilute]).unwrap(), bmcsl, 0.01);
        equilibrium(&case(THREE_TO_ONE, model, &[duration]).unwrap(), right_at_walls, 0.01);
    }
}

/// Replicas (runs with different seeds) of a mixture are pooled. Errors of means fall with the number of runs, and
/// impacts of all runs are added. A pair of species with impacts in one run only has no error.
#[test]
fn replicas_pool_what_is_said_of_each_kind() {
    let species = |velocity: f64, error: Option<f64>| SpeciesAverages {
        name: "glass".into(),
        count: 5,
        number_density: 2.0,
        velocity: Some(Estimate { value: velocity, error }),
        temperature: Some(Estimate { value: 4.0, error: Some(0.3) }),
        random_energy: None,
        profiles: Default::default(),
        batches: Default::default(),
    };
    let meeting = |other: &str, count: u64, speed: f64| MeetingAverages {
        between: ["glass".into(), other.into()],
        count,
        rate: Some(Estimate { value: count as f64, error: Some(1.0) }),
        normal_speed: Some(speed),
        restitution_asked: 0.9,
        restitution: Some(0.9),
    };
    let one = KindAverages {
        species: vec![species(1.0, Some(0.3))],
        meetings: vec![meeting("glass", 30, 1.0)],
        curves: Vec::new(),
    };
    let two = KindAverages {
        species: vec![species(2.0, Some(0.4))],
        meetings: vec![meeting("glass", 10, 2.0), meeting("steel", 4, 3.0)],
        curves: Vec::new(),
    };
    let pooled = KindAverages::pool(&[&one, &two], false);
    let velocity = pooled.species[0].velocity.unwrap();
    close("velocity", velocity.value, 1.5, 1e-12);
    close("its error", velocity.error.unwrap(), 0.25, 1e-12);
    close("temperature", pooled.species[0].temperature.unwrap().error.unwrap(), 0.3 / 2.0_f64.sqrt(), 1e-12);
    assert_eq!(pooled.species[0].random_energy, None);
    let [glass, steel] = pooled.meetings.as_slice() else { panic!("{:?}", pooled.meetings) };
    assert_eq!((glass.count, steel.count), (40, 4));
    close("rate", glass.rate.unwrap().value, 20.0, 1e-12);
    close("speed", glass.normal_speed.unwrap(), 1.25, 1e-12);
    close("restitution", glass.restitution.unwrap(), 0.9, 1e-12);
    assert_eq!(steel.rate.unwrap(), Estimate { value: 2.0, error: None });
    let unknown = KindAverages { species: vec![species(1.0, None)], meetings: Vec::new(), curves: Vec::new() };
    assert_eq!(KindAverages::pool(&[&one, &unknown], false).species[0].velocity.unwrap().error, None);
}
