//! Predictions for scenes in which particles fall on a floor: slopes and chutes, buoyancy and drag, inlets.

use crate::support::case;
use diptych::experiment::{Experiment, Model};
use diptych::placement::initial_state;
use diptych::predict::rest::Rest;
use diptych::predict::transient::fades;
use diptych::predict::{EngineChoice, Obstacles};
use diptych::simulation::Simulation;
use diptych::study::plan_of;

/// Beads on a floor below gravity along y and z. The box is periodic along x and z.
const SLOPE: &str = r#"
[domain]
size = ["10 mm", "30 mm", "10 mm"]
periodic = ["x", "z"]
[gravity]
acceleration = ["0 m/s^2", "-9 m/s^2", "0 m/s^2"]
[[particles]]
name = "bead"
diameter = "1 mm"
density = "2500 kg/m^3"
count = 100
velocity_fluctuation = "0.1 m/s"
[[walls]]
name = "floor"
plane = { point = ["0 m", "0 m", "0 m"], normal = [0, 1, 0] }
restitution = 0.8
friction = 0.5
[[walls]]
name = "lid"
plane = { point = ["0 m", "30 mm", "0 m"], normal = [0, -1, 0] }
restitution = 0.8
friction = 0.5
[contact]
restitution = 0.8
friction = 0.5
rotation = false
[soft.linear_spring_dashpot]
stiffness = "1000 N/m"
[soft.tangential.linear]
stiffness_ratio = 0.2857
[run]
duration = "5 s"
"#;

/// Experiment of the case [`SLOPE`] with the changes of keys `sets`.
fn slope(sets: &[&str]) -> Experiment {
    case(SLOPE, Model::Hard, sets).unwrap()
}

/// Floor on which particles of a scene come to rest (`None` without one), and the reasons against hard spheres, as
/// text.
fn floor(experiment: &Experiment) -> (Option<Rest>, String) {
    let found = Obstacles::of(experiment, &initial_state(experiment).unwrap());
    let against = found.against_hard(experiment).join("\n");
    (found.rest, against)
}

/// Key of a case for gravity: `pull` [m/s²] along the floor, and 9 m/s² that press the beads onto the floor.
fn along(pull: f64) -> String {
    format!("gravity.acceleration=[\"0 m/s^2\", \"-9 m/s^2\", \"{pull} m/s^2\"]")
}

/// With a friction coefficient of 0.5, spheres that do not rotate slide if gravity along the floor exceeds 4.5 m/s².
/// Spheres that rotate roll on any slope, unless rolling friction holds them.
#[test]
fn gravity_along_a_floor_keeps_beads_moving() {
    let rotation = "contact.rotation=true";
    let rolling = "soft.rolling.spring.friction=0.1";
    let scenes: [(f64, &[&str], bool); 7] = [
        (0.0, &[], false),
        (4.0, &[], false),
        (5.0, &[], true),
        (5.0, &["walls[0].friction=0.6"], false),
        (0.5, &[rotation], true),
        (0.5, &[rotation, rolling], false),
        (1.0, &[rotation, rolling], true),
    ];
    for (pull, sets, slides) in scenes {
        let experiment = slope(&[&[along(pull).as_str()], sets].concat());
        let (rest, against) = floor(&experiment);
        assert_eq!(rest.unwrap().slides, slides, "{pull} {sets:?}");
        assert_eq!(fades(&experiment), !slides, "{pull} {sets:?}");
        // the bounces end in both cases
        let words = if slides { "slide or roll along it" } else { "come to rest after about" };
        assert!(against.contains(words), "{pull} {sets:?}: {against}");
    }
}

/// Gravity along rough walls drives a flow between them. Between smooth walls the beads fall together, without a
/// driven flow. Beads between the ends of a slope come to rest; beads that leave through an outlet do not.
#[test]
fn gravity_drives_where_something_holds_back_and_nothing_ends() {
    let vertical = "gravity.acceleration=[\"0 m/s^2\", \"0 m/s^2\", \"-9.81 m/s^2\"]";
    let smooth = ["walls[0].friction=0", "walls[1].friction=0", "contact.friction=0"];
    assert!(!fades(&slope(&[vertical])));
    assert!(fades(&slope(&[&[vertical], &smooth[..]].concat())));
    let steep = along(5.0);
    let closed = slope(&[&steep, "domain.periodic=[\"x\"]"]);
    assert!(fades(&closed) && !floor(&closed).0.unwrap().slides);
    let open = slope(&[&steep, "domain.periodic=[\"x\"]", "outlets=[{ side = \"+z\" }]"]);
    assert!(!fades(&open) && floor(&open).0.unwrap().slides);
}

/// Water with drag, buoyancy and added mass around one bead of half its density, 15 mm below the lid.
const WATER: [&str; 6] = [
    "fluid.density=\"1000 kg/m^3\"",
    "fluid.kinematic_viscosity=\"1e-6 m^2/s\"",
    "fluid.profile.uniform.velocity=\"0 m/s\"",
    "fluid.added_mass=true",
    "drag.schiller_naumann={}",
    "particles[0]={ name = \"bead\", diameter = \"1 mm\", density = \"500 kg/m^3\", at = [{ position = [\"5 mm\", \"14.5 mm\", \"5 mm\"] }] }",
];

/// A light bead rises to the lid. The plan gives upper limits of the time until then, and of the speed at the lid,
/// which drag limits.
#[test]
fn a_light_bead_rises_to_the_lid_at_its_settling_speed() {
    let bead = slope(&WATER);
    let rest = floor(&bead).0.unwrap();
    assert!(rest.rises && !rest.slides && (rest.height - 15e-3).abs() < 1e-9, "{rest:?}");
    // g (1/2)/(1/2 + 1/2), with the added mass
    assert!((rest.gravity - 4.5).abs() < 1e-9, "{rest:?}");
    let impacts = |time: f64| {
        let start = initial_state(&bead).unwrap();
        let mut run = Simulation::new(&bead, start);
        run.run(10_000, time / 1e4).unwrap();
        (run.record.walls.count, run.record.walls.summary().mean_normal_speed.unwrap_or(0.0))
    };
    let ((before, _), (after, speed)) = (impacts(0.9 * rest.fall), impacts(rest.fall));
    assert_eq!((before, after), (0, 1), "{rest:?}");
    // within a window of 24 us drag does not act, so that the speed differs by up to g h/2, 0.08 %
    assert!(speed < 1.002 * rest.speed && speed > 0.95 * rest.speed, "{speed} {rest:?}");
}

/// An inlet brings 300 beads per second to a box without particles, above a floor or above an outlet.
#[test]
fn a_box_that_an_inlet_fills_is_no_scene_of_few_bodies() {
    let sets = [
        "particles[0]={ name = \"bead\", diameter = \"1 mm\", density = \"2500 kg/m^3\", count = 0 }",
        "inlets=[{ particles = \"bead\", rate = \"300 1/s\", box = { center = [\"5 mm\", \"25 mm\", \"5 mm\"], half_extents = [\"4 mm\", \"2 mm\", \"4 mm\"] } }]",
    ];
    let filled = plan_of(&slope(&sets), 0.01, false).unwrap();
    let (plan, advice) = (filled.plan, filled.recommendation);
    assert_eq!((plan.particles, plan.coming), (0, Some(1501)));
    let rest = plan.rest.unwrap();
    // 26 mm from the top of the region to the floor, for the lower side of a bead in it: e = 0.8, 9 times the first fall
    let fall = (2.0 * 26e-3 / 9.0_f64).sqrt();
    assert!((rest.time / (9.0 * fall) - 1.0).abs() < 1e-9 && (rest.fall / fall - 1.0).abs() < 1e-9, "{rest:?}");
    assert_eq!(advice.engine, Some(EngineChoice::SoftUniform), "{advice:?}");
    assert!(plan.contacts.len() == 2 && !plan.effects.is_empty());
    let rain = ["walls=[]", "outlets=[{ side = \"-y\" }, { side = \"+y\" }]"];
    let advice = plan_of(&slope(&[&sets[..], &rain].concat()), 0.01, false).unwrap().recommendation;
    assert_eq!(advice.engine, Some(EngineChoice::Hard));
    assert!(advice.reasons[0].starts_with("Particles come in"), "{:?}", advice.reasons);
}
