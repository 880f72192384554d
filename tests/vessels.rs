//! Vessels smaller than the box: random starts in vessels, starts in a part of the domain, slabs as thin as a sphere,
//! and the cost of islands in vessels.

use crate::support::{case, diptych, experiment, surface};
use diptych::experiment::{Experiment, Model};
use diptych::particles::Particles;
use diptych::placement::initial_state;
use diptych::scene::{Scene, Species};
use diptych::simulation::Simulation;
use diptych::walls::{Cavity, Frustum, Hollow, RoundAxis, Wall, WallGeometry};
use nalgebra::Vector3;

/// Beginning of a case with spheres of 1 mm in a box of 20 mm, without walls and particles.
const HEAD: &str = r#"
[domain]
size = ["20 mm", "20 mm", "20 mm"]
[contact]
restitution = 0.9
[soft.linear_spring_dashpot]
stiffness = "10 kN/m"
[run]
duration = "1 ms"
model = "soft"
"#;

fn with(rest: &str) -> Experiment {
    case(&format!("{HEAD}{rest}"), Model::Hard, &[]).unwrap_or_else(|why| panic!("{why}"))
}

/// Text of a case that defines a species of spheres of 1 mm with the keys `keys`.
fn kind(keys: &str) -> String {
    format!("[[particles]]\ndiameter = \"1 mm\"\ndensity = \"2500 kg/m^3\"\n{keys}\n")
}

/// Text of a case that defines a wall with the shape `shape`.
fn wall(shape: &str) -> String {
    format!("[[walls]]\n{shape}\nrestitution = 0.9\n")
}

/// Checks that all pairs are at least a diameter apart, up to rounding.
fn overlaps_nothing(experiment: &Experiment, particles: &Particles, what: &str) {
    let scene = &experiment.scene;
    for i in 0..particles.len() {
        for j in 0..i {
            let apart = scene.domain.separation(&particles.position[i], &particles.position[j]).norm();
            let reach = particles.radius[i] + particles.radius[j];
            assert!(apart >= reach * (1.0 - 1e-12), "{what}: {i} and {j} overlap by {:e} m", reach - apart);
        }
        for wall in &scene.walls {
            let gap = wall.geometry.nearest(&particles.position[i]).distance - particles.radius[i];
            assert!(gap >= -1e-9 * particles.radius[i], "{what}: {i} is {gap:e} m in a wall");
        }
    }
}

#[test]
fn a_vessel_is_filled_by_what_it_holds_and_not_by_what_the_box_does() {
    // 33 spheres have a volume fraction of 0.27 in the vessel, and of 0.002 in the box
    let small =
        r#"box = { center = ["4 mm", "4 mm", "4 mm"], half_extents = ["2 mm", "2 mm", "2 mm"], inside = true }"#;
    let round = r#"sphere = { center = ["10 mm", "10 mm", "10 mm"], radius = "4 mm", inside = true }"#;
    let silo = r#"cylinder = { center = ["10 mm", "10 mm", "6 mm"], axis = "z", radius = "4 mm", half_height = "5 mm", inside = true }"#;
    for (shape, count) in [(small, 33), (small, 45), (round, 150), (round, 250), (silo, 300), (silo, 480)] {
        let experiment = with(&(kind(&format!("count = {count}")) + &wall(shape)));
        let start = initial_state(&experiment).unwrap_or_else(|why| panic!("{count} in {shape}: {why}"));
        overlaps_nothing(&experiment, &start, shape);
    }
}

#[test]
fn what_a_vessel_cannot_hold_is_refused_with_the_room_it_has() {
    let shape =
        r#"box = { center = ["4 mm", "4 mm", "4 mm"], half_extents = ["2 mm", "2 mm", "2 mm"], inside = true }"#;
    // 80 spheres would have a volume fraction of 0.65 in the vessel
    let text = format!("{HEAD}{}{}", kind("count = 80"), wall(shape));
    let why = case(&text, Model::Hard, &[]).unwrap_err();
    assert!(why.contains("80 particles fill 0.6545 of the room that they have"), "{why}");
    // the volume of bodies in the box is measured: this body leaves no room for so many spheres
    let filled = r#"sphere = { center = ["10 mm", "10 mm", "10 mm"], radius = "9.5 mm" }"#;
    let sides =
        r#"box = { center = ["10 mm", "10 mm", "10 mm"], half_extents = ["10 mm", "10 mm", "10 mm"], inside = true }"#;
    let experiment = with(&(kind("count = 6000") + &wall(filled) + &wall(sides)));
    let why = initial_state(&experiment).unwrap_err();
    // 8000 minus 4/3 π 9.5³ mm³, within the error of the measured volume
    assert!((why.room / 4.4086e-6 - 1.0).abs() < 0.02, "{why}");
    assert!(why.to_string().contains("a larger box around a vessel is of no use"), "{why}");
}

#[test]
fn particles_start_in_the_region_that_is_asked_for() {
    let hopper = r#"name = "hopper"
cone = { center = ["10 mm", "10 mm", "8 mm"], axis = "z", lower_radius = "1 mm", upper_radius = "8 mm", half_height = "6 mm", open = true }"#;
    let block = r#"in = { box = { center = ["10 mm", "10 mm", "18 mm"], half_extents = ["9 mm", "9 mm", "2 mm"] } }"#;
    let can = r#"in = { cylinder = { center = ["3 mm", "3 mm", "7 mm"], axis = "z", radius = "2.5 mm", half_height = "7 mm" } }"#;
    let experiment = with(
        &(kind("count = 150\nin = { inside = \"hopper\" }")
            + &kind(&format!("volume_fraction = 0.3\n{block}"))
            + &kind(&format!("count = 20\n{can}"))
            + &kind("count = 50")
            + &wall(hopper)),
    );
    let start = initial_state(&experiment).unwrap();
    overlaps_nothing(&experiment, &start, "regions");
    let mut counts = [0; 4];
    for (x, species) in start.position.iter().zip(&start.species) {
        counts[usize::from(*species)] += 1;
        let x = x * 1e3;
        let inside = match species {
            0 => (x.x - 10.0).hypot(x.y - 10.0) < 1.0 + 7.0 * (x.z - 2.0) / 12.0 && x.z > 2.0 && x.z < 14.0,
            1 => (x.x - 10.0).abs() <= 8.5 && (x.y - 10.0).abs() <= 8.5 && (x.z - 18.0).abs() <= 1.5,
            2 => (x.x - 3.0).hypot(x.y - 3.0) <= 2.0 && (x.z - 7.0).abs() <= 6.5,
            _ => true,
        };
        assert!(inside, "one of kind {species} starts at {x:?} mm");
    }
    // a volume fraction of 0.3 in 18 by 18 by 4 mm³
    assert_eq!(counts, [150, (0.3 * 18.0 * 18.0 * 4.0 / (std::f64::consts::PI / 6.0)) as usize, 20, 50]);
}

#[test]
fn regions_that_make_no_sense_are_refused() {
    let open = "in = { inside = \"floor\" }";
    let floor = "name = \"floor\"\nplane = { point = [\"0 m\", \"0 m\", \"0 m\"], normal = [0, 0, 1] }";
    let far = r#"in = { box = { center = ["10 mm", "10 mm", "19 mm"], half_extents = ["2 mm", "2 mm", "2 mm"] } }"#;
    let both = r#"in = { inside = "floor", box = { center = ["5 mm", "5 mm", "5 mm"], half_extents = ["2 mm", "2 mm", "2 mm"] } }"#;
    let placed = format!("at = [{{ position = [\"3 mm\", \"3 mm\", \"3 mm\"] }}]\n{far}");
    let refused = [
        (format!("count = 2\n{open}"), "names a wall that has no inside"),
        ("count = 2\nin = { inside = \"roof\" }".into(), "names no wall"),
        (format!("count = 2\n{far}"), "1.7000e-2 ..= 2.1000e-2 m"),
        (format!("count = 2\n{both}"), "keep one of `box`, `cylinder` and `inside`"),
        ("count = 2\nin = {}".into(), "missing: `particles[0].in.box` (or `cylinder`, `inside`)"),
        (placed, "is of no use: these particles have given places"),
    ];
    for (keys, words) in refused {
        let text = format!("{HEAD}{}{}", kind(&keys), wall(floor));
        let why = case(&text, Model::Hard, &[]).unwrap_err();
        assert!(why.contains(words), "{keys}: {why}");
    }
}

#[test]
fn a_slab_as_thick_as_a_sphere_is_filled_in_its_middle() {
    let sides = |z: f64| {
        wall("plane = { point = [\"0 m\", \"0 m\", \"0 m\"], normal = [0, 0, 1] }")
            + &wall(&format!("plane = {{ point = [\"0 m\", \"0 m\", \"{z} mm\"], normal = [0, 0, -1] }}"))
    };
    for (thick, count) in [(1.0, 100), (1.0005, 100), (1.002, 100), (1.0, 250)] {
        let text = HEAD.replace("\"20 mm\", \"20 mm\", \"20 mm\"", &format!("\"20 mm\", \"20 mm\", \"{thick} mm\""));
        let text = text.replace("[contact]", "periodic = [\"x\", \"y\"]\n[contact]");
        let random = kind(&format!("count = {count}\nvelocity_fluctuation = [\"0.3 m/s\", \"0.3 m/s\", \"0 m/s\"]"));
        for model in [Model::Soft, Model::Hard, Model::Hybrid] {
            let experiment = case(&format!("{text}{random}{}", sides(thick)), model, &[]).unwrap();
            let start = initial_state(&experiment).unwrap_or_else(|why| panic!("{thick} mm, {count}: {why}"));
            overlaps_nothing(&experiment, &start, "slab");
            let mut simulation = Simulation::new(&experiment, start);
            simulation.run(4, 1e-3).unwrap_or_else(|why| panic!("{thick} mm, {count}, {model:?}: {why}"));
            if thick == 1.0 {
                assert!(simulation.particles.velocity.iter().all(|v| v.z.abs() < 1e-6), "{model:?}");
            }
        }
    }
}

/// Islands (groups of particles that may meet) in round vessels, with windows (pieces of the run) of different
/// durations. The work per impact must not depend on the duration.
#[test]
fn islands_in_round_vessels_cost_no_more_in_long_windows() {
    let axle = RoundAxis { center: Vector3::repeat(0.01), axis: 2 };
    let can = |low: f64, high: f64| {
        Cavity::ClosedCylinder(Frustum { axle, radii: [low, high], half_height: 0.005, solid: true })
    };
    let rooms = [
        can(0.005, 0.005),
        can(0.004, 0.006),
        Cavity::Sphere { center: axle.center, radius: 0.00567 },
        Cavity::Pipe { axle, radius: 0.0035 },
    ];
    let smooth = surface(1.0, 0.0);
    let species = Species::new("bead", 3e-4, 2500.0);
    for room in rooms {
        let vessel = Wall::new(WallGeometry::Hollow(Hollow::new(room)), smooth);
        let empty = crate::support::empty([0.02; 3], [false, false, true], species.clone(), smooth);
        let scene = Scene { walls: vec![vessel], ..empty };
        for model in [Model::Soft, Model::Hybrid] {
            let experiment = experiment(scene.clone(), 400, [0.0; 3], 0.5, model, 1);
            let mut work = Vec::new();
            for window in [2.5e-4, 5e-4, 1e-3, 2e-3] {
                let mut simulation = Simulation::new(&experiment, initial_state(&experiment).unwrap());
                simulation.run((0.02 / window) as u64, window).unwrap();
                let counters = simulation.counters();
                // islands must be small; larger islands, such as 129 members, would examine thousands of pairs in each
                // step
                assert!(counters.largest_island <= 48, "{room:?}, {model:?}, {window} s: {counters:?}");
                work.push(counters.force_evaluations + counters.pair_checks);
            }
            let (least, most) = (work.iter().min().unwrap(), work.iter().max().unwrap());
            assert!(*most <= 8 * *least, "{room:?}, {model:?}: {work:?}");
        }
    }
}

#[test]
fn check_refuses_what_run_refuses() {
    let folder = tempfile::tempdir().unwrap();
    let filled = wall(r#"sphere = { center = ["10 mm", "10 mm", "10 mm"], radius = "9.5 mm" }"#);
    let sides = wall(
        r#"box = { center = ["10 mm", "10 mm", "10 mm"], half_extents = ["10 mm", "10 mm", "10 mm"], inside = true }"#,
    );
    let crowded = folder.path().join("crowded.toml");
    // spheres of 7.5 mm do not fit between the ball and the corners
    let spheres = kind("count = 1").replace("1 mm", "7.5 mm");
    std::fs::write(&crowded, format!("# crowded\n{HEAD}{spheres}{filled}{sides}")).unwrap();
    let case = crowded.to_str().unwrap();
    for command in [&["check", case][..], &["run", case, "--model", "soft", "--out", "never"]] {
        let output = diptych(command).output().unwrap();
        assert_eq!(output.status.code(), Some(2), "{output:?}");
        let told = String::from_utf8_lossy(&output.stderr);
        assert!(told.contains("no random start without overlap found"), "{told}");
    }
}
