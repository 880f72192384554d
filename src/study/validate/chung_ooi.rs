//! Validation rows (comparisons with references) of the benchmark impacts of Chung and Ooi (2011, Granular Matter 13,
//! 643), with points of their figures that were digitised for the tests of Kratos.

use super::check::{CheckResult, CheckScene, ValidationCheck, exact, read_off, run_to, stopped};
use super::oblique::rebound;
use crate::contact_law::Bodies;
use crate::experiment::Model;
use crate::output::ValidationTier::{ClosedForms, OtherCodes};
use crate::output::panel::{Panel, PanelSeries, SeriesPoint, SeriesStyle};
use crate::runs::StudyError;
use crate::simulation::Simulation;

/// Largest force [N] and duration [s] of the impact of two balls, or of one ball on the first wall, with the speed of
/// approach `speed` [m/s]. The force is that of the contact law at the largest overlap of the run.
fn normal_impact(scene: &CheckScene, speed: f64) -> Result<[f64; 2], StudyError> {
    let experiment = scene.experiment(Model::Soft, None, &[])?;
    let mut simulation = scene.simulation(Model::Soft, None, &[])?;
    let Some(law) = experiment.law() else { return Err(StudyError::Failed("error: no contact law".into())) };
    let particles = &simulation.particles;
    let pair = particles.len() == 2;
    let bodies = if pair {
        Bodies::pair(simulation.scene(), particles, 0, 1)
    } else {
        Bodies::at_wall(simulation.scene(), particles, 0, 0)
    };
    let (diameter, spring) = (2.0 * particles.radius[0], law.between(&bodies));
    let time = law.contact_time(&spring, speed);
    run_to(&mut simulation, 2e-3 * diameter / speed + 1.5 * time, 1)?;
    let record = &simulation.record;
    let seen = if pair { record.pairs.summary() } else { record.walls.summary() };
    let overlap = seen.largest_overlap.unwrap_or(f64::NAN) * diameter;
    Ok([law.force(&spring, overlap, 0.0).0, seen.mean_duration.unwrap_or(f64::NAN)])
}

/// Comparison with a reference (row of the validation suite): head-on impact of two balls of glass (test 1 of Chung
/// and Ooi).
pub const HEAD_ON: ValidationCheck = ValidationCheck {
    name: "chung-ooi-1",
    tier: OtherCodes,
    case: "validation/head-on",
    scene: "Two glass balls of 20 mm meet at 10 m/s each, elastic, with Hertz's law.",
    source: "Chung and Ooi (2011), test 1, as digitised in KratosMultiphysics/Kratos@0b18c804, applications/DEMApplication/tests/DEM3D_chung_ooi_tests/test1_data/paper_data/benchmark1_graph2.dat: largest force, and time at which it is zero again.",
    not_shown: "Whether real glass follows Hertz's law at this speed. The paper itself was not read.",
    takes_minutes: false,
    measure: |scene| force_and_time(normal_impact(scene, 20.0)?, [(10.70e3, 20.0), (40.47e-6, 0.1e-6)]),
};

/// Comparison with a reference (row of the validation suite): normal impact of a ball of aluminium alloy on a rigid
/// plane (test 2 of Chung and Ooi).
pub const ON_PLANE: ValidationCheck = ValidationCheck {
    name: "chung-ooi-2",
    tier: OtherCodes,
    case: "validation/plane",
    scene: "A ball of aluminium alloy (200 mm) meets a rigid plane at 0.2 m/s, elastic, with Hertz's law.",
    source: "Chung and Ooi (2011), test 2, as digitised in KratosMultiphysics/Kratos@85067e3a, applications/DEMApplication/tests/DEM3D_chung_ooi_tests/test2_data/paper_data/benchmark2_graph2.dat: largest force, and times of zero force.",
    not_shown: "Waves in the ball, which Hertz's law leaves out. The paper itself was not read.",
    takes_minutes: false,
    measure: |scene| force_and_time(normal_impact(scene, 0.2)?, [(11.36e3, 20.0), (726.5e-6, 2e-6)]),
};

/// Results of a normal impact: largest force [N] and duration [s]. `expected` has the reference values of both, each
/// with its reading error of 1/500 of the axis.
fn force_and_time(ours: [f64; 2], expected: [(f64, f64); 2]) -> Result<CheckResult, StudyError> {
    let [force, time] = expected;
    Ok(vec![
        read_off("largest force", "N", force, ours[0], 0.02 * force.0),
        read_off("duration", "s", time, ours[1], 0.02 * time.0),
    ]
    .into())
}

/// Comparison with a reference (row of the validation suite): restitution of a ball that meets a rigid plane (test 3
/// of Chung and Ooi).
pub const RESTITUTION: ValidationCheck = ValidationCheck {
    name: "chung-ooi-3",
    tier: ClosedForms,
    case: "rotation/mindlin",
    scene: "A ball of aluminium oxide (5 mm) meets a rigid plane at 3.9 m/s along the normal, with Hertz's law and e = 0.2 to 1.",
    source: "Chung and Ooi (2011), test 3: the restitution that was asked for. Parameters: ParticulateFlow/LIGGGHTS-PFM@d075b977, examples/LIGGGHTS/PFM/tests/contact_models/chung.",
    not_shown: "How the restitution of a real material depends on speed: the dashpot makes it constant.",
    takes_minutes: false,
    measure: restitution,
};

fn restitution(scene: &CheckScene) -> Result<CheckResult, StudyError> {
    let mut numbers = Vec::new();
    for asked in [0.2, 0.4, 0.6, 0.8, 1.0] {
        let sets = [
            format!("walls[0].restitution={asked}"),
            "particles[0].at[0].velocity[0]=0 m/s".to_owned(),
            "particles[0].at[0].velocity[1]=-3.9 m/s".to_owned(),
            "soft.stepping=local".to_owned(),
            "soft.steps_per_contact=200".to_owned(),
        ];
        let mut simulation = scene.simulation(Model::Soft, None, &sets)?;
        run_to(&mut simulation, 1e-4, 1)?;
        let found = simulation.particles.velocity[0].y / 3.9;
        // the tolerance covers the error of local time steps of fourth order, 200 per contact
        numbers.push(exact(format!("e = {asked}"), "", asked, found, 1e-3));
    }
    Ok(numbers.into())
}

/// Comparison with a reference (row of the validation suite): oblique impacts of a ball of aluminium oxide on a rigid
/// plane (test 4 of Chung and Ooi).
pub const OBLIQUE: ValidationCheck = ValidationCheck {
    name: "chung-ooi-4",
    tier: OtherCodes,
    case: "rotation/mindlin",
    scene: "A ball of aluminium oxide (5 mm) hits a rigid plane at 3.9 m/s and 5 to 85 degrees from the normal, e = 0.98, μ = 0.092, Hertz and Mindlin, displacements remembered.",
    source: "Chung and Ooi (2011), test 4, as digitised in KratosMultiphysics/Kratos, applications/DEMApplication/tests/DEM3D_chung_ooi_tests/test4_data/paper_data/benchmark4_graph1_ref.dat (@5081be0b) and benchmark4_graph2_ref.dat (@d086b69b), taken at the nearest multiple of 5 degrees.",
    not_shown: "Other histories of the tangential spring, which differ by up to 0.1 at 5 degrees. Reading errors are those of the points in gross sliding, where the answer is known. The paper itself was not read.",
    takes_minutes: false,
    measure: oblique,
};

/// Test 4 of Chung and Ooi: angle [°] between the velocity before the impact and the normal, ratio v_t'/v_t [-] of the
/// tangential velocities after and before the impact, and spin after the impact [rad/s].
const TEST_4: [(f64, f64, f64); 13] = [
    (5.0, 0.9481, 19.27),
    (10.0, 0.6870, 213.00),
    (15.0, 0.6244, 377.83),
    (20.0, 0.6161, 510.55),
    (25.0, 0.6343, 599.39),
    (30.0, 0.6837, 616.51),
    (35.0, 0.7372, 582.26),
    (40.0, 0.7809, 544.80),
    (50.0, 0.8451, 457.03),
    (60.0, 0.8929, 357.49),
    (70.0, 0.9316, 246.18),
    (80.0, 0.9662, 126.30),
    (85.0, 0.9827, 63.15),
];

fn oblique(scene: &CheckScene) -> Result<CheckResult, StudyError> {
    let sets = ["soft.tangential.mindlin.history=displacement".to_owned()];
    let (mut numbers, mut found) = (Vec::new(), Vec::new());
    for (angle, ratio, spin) in TEST_4 {
        let left = rebound(scene, angle, &sets)?;
        // from 35 degrees on the ball slides during the whole contact; the digitised points then deviate from the
        // closed form by up to 0.003 in the ratio and 3 rad/s in the spin
        numbers.push(read_off(format!("v_t'/v_t at {angle}°"), "", (ratio, 0.003), left.ratio, 0.03));
        numbers.push(read_off(format!("spin at {angle}°"), "rad/s", (spin, 3.0), left.spin, 20.0));
        found.push(SeriesPoint::at(angle, left.spin));
    }
    let points = TEST_4.map(|(angle, _, spin)| SeriesPoint::at(angle, spin));
    let panel = Panel {
        x_label: "angle from the normal  [°]".into(),
        y_label: "spin after the impact  [rad/s]".into(),
        series: vec![
            PanelSeries::new("this program", SeriesStyle::Sweep(0), found),
            PanelSeries::new("Chung and Ooi 2011", SeriesStyle::Winner, points),
        ],
        ..Panel::default()
    };
    Ok(CheckResult { numbers, picture: Some(("Spin after an oblique impact (test 4).", panel)) })
}

/// Changes of keys for test 5 of Chung and Ooi: a steel ball of 20 µm in a box of 1 mm. `along` [m/s] is its velocity
/// along the plane.
fn steel(along: f64) -> Vec<String> {
    let mut sets: Vec<String> = [
        "particles[0].diameter=20 um",
        "particles[0].density=7850 kg/m^3",
        "soft.hertz.youngs_modulus=208 GPa",
        "walls[0].friction=0.3",
        "soft.tangential.mindlin.history=rescaled",
        "domain.size[0]=1 mm",
        "domain.size[1]=1 mm",
        "domain.size[2]=1 mm",
        "particles[0].at[0].position[0]=0.5 mm",
        "particles[0].at[0].position[1]=10.001 um",
        "particles[0].at[0].position[2]=0.5 mm",
        "particles[0].at[0].velocity[1]=-5 m/s",
    ]
    .map(str::to_owned)
    .into();
    sets.push(format!("particles[0].at[0].velocity[0]={along} m/s"));
    sets
}

/// Comparison with a reference (row of the validation suite): oblique impacts of a steel ball, compared with finite
/// elements (test 5 of Chung and Ooi).
pub const FINITE_ELEMENTS: ValidationCheck = ValidationCheck {
    name: "chung-ooi-5",
    tier: OtherCodes,
    case: "validation/plane",
    scene: "A steel ball of 20 µm hits a rigid plane with a normal speed of 5 m/s, e = 1, μ = 0.3, Hertz and Mindlin, rescaled forces: R ω'/(μ v_n) over v_t/(μ v_n).",
    source: "Chung and Ooi (2011), test 5, finite elements, as digitised in KratosMultiphysics/Kratos@d086b69b, applications/DEMApplication/tests/DEM3D_chung_ooi_tests/paper_data_5_to_8/benchmark5_graph2.dat, block FEM.",
    not_shown: "A closed form: partial slip within the contact, which finite elements have, is in no history of a single spring. The paper itself was not read.",
    takes_minutes: false,
    measure: finite_elements,
};

/// Test 5 of Chung and Ooi, by finite elements: v_t/(μ v_n) [-] before the impact, and R ω'/(μ v_n) [-] after it. Here
/// v_t and v_n are the tangential and the normal velocity before the impact, μ is the coefficient of friction, R the
/// radius and ω' the spin after the impact.
const TEST_5: [(f64, f64); 10] = [
    (0.5954, 0.4056),
    (1.1850, 0.9818),
    (1.8960, 1.7933),
    (2.7630, 2.8564),
    (3.8902, 4.0412),
    (4.6879, 4.5685),
    (5.6590, 4.9415),
    (7.0289, 4.9407),
    (9.0405, 4.9721),
    (18.8035, 4.9749),
];

fn finite_elements(scene: &CheckScene) -> Result<CheckResult, StudyError> {
    let (mut numbers, mut found) = (Vec::new(), Vec::new());
    for (slip, expected) in TEST_5 {
        let mut simulation = scene.simulation(Model::Soft, None, &steel(slip * 0.3 * 5.0))?;
        run_to(&mut simulation, 1e-7, 1)?;
        let spin = -simulation.particles.spin_of(0).z * 1e-5 / (0.3 * 5.0);
        // in gross sliding the closed form of R ω'/(μ v_n) is 5, while the digitised points are 4.94 to 4.97. R is the
        // radius, ω' the spin after the impact, μ the coefficient of friction, v_n the normal velocity
        numbers.push(read_off(format!("R ω'/(μ v_n) at {slip}"), "", (expected, 0.03), spin, 0.25));
        found.push(SeriesPoint::at(slip, spin));
    }
    let points = TEST_5.map(|(slip, spin)| SeriesPoint::at(slip, spin));
    let panel = Panel {
        x_label: "v_t/(μ v_n)  [-]".into(),
        y_label: "R ω'/(μ v_n)  [-]".into(),
        series: vec![
            PanelSeries::new("this program", SeriesStyle::Sweep(0), found),
            PanelSeries::new("finite elements", SeriesStyle::Winner, points),
        ],
        ..Panel::default()
    };
    Ok(CheckResult { numbers, picture: Some(("Spin after an oblique elastic impact (test 5).", panel)) })
}

/// Comparison with a reference (row of the validation suite): normal impact of a ball with spin on a rigid plane (test
/// 6 of Chung and Ooi).
pub const SPINNING: ValidationCheck = ValidationCheck {
    name: "chung-ooi-6",
    tier: OtherCodes,
    case: "validation/plane",
    scene: "A ball of aluminium alloy (200 mm) with spin meets a rigid plane at 0.2 m/s, e = 0.5, μ = 0.4, Hertz and Mindlin, displacements remembered: β, the slip after over that before, turned round.",
    source: "Chung and Ooi (2011), test 6, as digitised in KratosMultiphysics/Kratos@5924ef79, applications/DEMApplication/tests/DEM3D_chung_ooi_tests/paper_data_5_to_8/benchmark8_graph1.dat, third block, taken at v_st = 0.2 m/s tan(5° k).",
    not_shown: "The tangential law of the paper's codes, which is not stated with the points. With a tangential dashpot of the damping ratio of the normal one, ours are within 0.07 of the points from 0.17 m/s on, and 0.26 too high at the smallest slip.",
    takes_minutes: false,
    measure: spinning,
};

/// Test 6 of Chung and Ooi: number k, which gives the slip before the impact as 0.2 m/s tan(5° k), and coefficient β
/// [-]. The coefficient β is minus the slip after the impact divided by the slip before it.
const TEST_6: [(u32, f64); 9] = [
    (1, -0.3386),
    (2, -0.2588),
    (4, -0.1622),
    (6, -0.1034),
    (8, 0.0058),
    (10, 0.0898),
    (12, 0.0961),
    (14, -0.2378),
    (16, -0.6262),
];

fn spinning(scene: &CheckScene) -> Result<CheckResult, StudyError> {
    let (mut numbers, mut found) = (Vec::new(), Vec::new());
    for (k, expected) in TEST_6 {
        let slip = 0.2 * (5.0 * f64::from(k)).to_radians().tan();
        let mut sets: Vec<String> = [
            "walls[0].restitution=0.5",
            "walls[0].friction=0.4",
            "particles[0].density=2700 kg/m^3",
            "soft.hertz.poissons_ratio=0.33",
        ]
        .map(str::to_owned)
        .into();
        // a ball that turns backwards has a positive spin about z; its surface then moves along +x at the plane
        sets.push(format!("particles[0].at[0].spin[2]={} rad/s", slip / 0.1));
        let mut simulation = scene.simulation(Model::Soft, None, &sets)?;
        run_to(&mut simulation, 2e-3, 1)?;
        let after = surface_speed(&simulation, 0.1);
        // in gross sliding β is 3.5 μ (1 + e) v_n/v_st - 1, with coefficient of friction μ, restitution e, normal
        // velocity v_n and slip v_st. The digitised points deviate from this by 0.003
        numbers.push(read_off(format!("β at v_st = {slip:.3} m/s"), "", (expected, 0.005), -after / slip, 0.03));
        found.push(SeriesPoint::at(slip, -after / slip));
    }
    let points = TEST_6.map(|(k, beta)| SeriesPoint::at(0.2 * (5.0 * f64::from(k)).to_radians().tan(), beta));
    let panel = Panel {
        x_label: "slip before the impact  [m/s]".into(),
        y_label: "β  [-]".into(),
        log_x: true,
        series: vec![
            PanelSeries::new("this program", SeriesStyle::Sweep(0), found),
            PanelSeries::new("Chung and Ooi 2011", SeriesStyle::Winner, points),
        ],
        ..Panel::default()
    };
    Ok(CheckResult { numbers, picture: Some(("Tangential restitution of a ball with spin (test 6).", panel)) })
}

/// [m/s] velocity along x of the lowest point of the surface of the first ball. `radius` [m] is that of the ball.
fn surface_speed(simulation: &Simulation, radius: f64) -> f64 {
    simulation.particles.velocity[0].x + radius * simulation.particles.spin_of(0).z
}

/// Comparison with a reference (row of the validation suite): head-on impact of two balls with opposite spins (test 7
/// of Chung and Ooi).
pub const OPPOSITE_SPINS: ValidationCheck = ValidationCheck {
    name: "chung-ooi-7",
    tier: ClosedForms,
    case: "validation/head-on",
    scene: "Two balls of aluminium alloy (200 mm) with opposite spins of 21 rad/s meet at 0.2 m/s each, e = 0.5, μ = 0.4: their surfaces move alike, and nothing slips.",
    source: "Chung and Ooi (2011), test 7: spins as before, no velocity across, 0.5 of the speed along. KratosMultiphysics/Kratos@7d0df8eb, applications/DEMApplication/tests/DEM3D_chung_ooi_tests/paper_data_5_to_8/benchmark7_graph2.dat has the same.",
    not_shown: "Friction, which this scene must not have.",
    takes_minutes: false,
    measure: opposite_spins,
};

fn opposite_spins(scene: &CheckScene) -> Result<CheckResult, StudyError> {
    let sets = [
        "domain.size[0]=2 m",
        "domain.size[1]=2 m",
        "domain.size[2]=2 m",
        "particles[0].diameter=200 mm",
        "particles[0].density=2700 kg/m^3",
        "particles[0].at[0].position[0]=0.89 m",
        "particles[0].at[0].position[1]=1 m",
        "particles[0].at[0].position[2]=1 m",
        "particles[0].at[1].position[0]=1.1 m",
        "particles[0].at[1].position[1]=1 m",
        "particles[0].at[1].position[2]=1 m",
        "particles[0].at[0].velocity[0]=0.2 m/s",
        "particles[0].at[1].velocity[0]=-0.2 m/s",
        "particles[0].at[0].spin[2]=21 rad/s",
        "particles[0].at[1].spin[2]=-21 rad/s",
        "contact.restitution=0.5",
        "contact.friction=0.4",
        "soft.hertz.youngs_modulus=70 GPa",
        "soft.hertz.poissons_ratio=0.33",
    ];
    let mut simulation = scene.simulation(Model::Soft, None, &sets.map(str::to_owned))?;
    simulation.run(1, 0.04).map_err(stopped)?;
    simulation.particles.sort_by_id();
    let particles = &simulation.particles;
    Ok(vec![
        exact("spin", "rad/s", 21.0, particles.spin_of(0).z, 1e-12),
        exact("velocity across", "m/s", 0.0, particles.velocity[0].y, 1e-15),
        // the tolerance covers the error of 200 time steps per contact
        exact("velocity along", "m/s", -0.1, particles.velocity[0].x, 1e-4),
    ]
    .into())
}
