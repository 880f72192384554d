//! Spheres of four species between moving walls.

use crate::support::*;
use diptych::experiment::Model;
use diptych::placement::initial_state;
use diptych::study::execute;

/// Case of four species of inelastic spheres with friction, between walls that slide relative to each other, and around
/// a fixed ball.
const FOUR_BETWEEN_MOVING_WALLS: &str = r#"
[domain]
size = ["12 mm", "10 mm", "12 mm"]
periodic = ["x", "z"]

[[particles]]
name = "dust"
diameter = "0.3 mm"
density = "2500 kg/m^3"
volume_fraction = 0.04
velocity_fluctuation = "0.2 m/s"

[[particles]]
name = "light"
diameter = "0.5 mm"
density = "1000 kg/m^3"
volume_fraction = 0.04
velocity_fluctuation = "0.2 m/s"

[[particles]]
name = "glass"
diameter = "1 mm"
density = "2500 kg/m^3"
volume_fraction = 0.04
velocity_fluctuation = "0.2 m/s"

[[particles]]
name = "steel"
diameter = "2 mm"
density = "7800 kg/m^3"
volume_fraction = 0.04
velocity_fluctuation = "0.2 m/s"

[[walls]]
plane = { point = ["0 m", "0 m", "0 m"], normal = [0, 1, 0] }
velocity = ["0 m/s", "0 m/s", "1 m/s"]
restitution = 0.9
friction = 0.5

[[walls]]
plane = { point = ["0 m", "10 mm", "0 m"], normal = [0, -1, 0] }
velocity = ["0 m/s", "0 m/s", "-1 m/s"]
restitution = 0.9
friction = 0.5

[[walls]]
sphere = { center = ["0 m", "5 mm", "0 m"], radius = "2 mm" }
restitution = 0.9
friction = 0.2

[contact]
restitution = 0.9
friction = 0.1

[soft.linear_spring_dashpot]
stiffness = "2000 N/m"

[run]
model = "hard"
duration = "2.5 ms"
average_from = "0 s"

[statistics]
slices = 4
"#;

/// Energy balance of every engine. It is closed up to rounding for hard spheres, and up to the error of the time steps
/// for soft spheres. With uniform steps this error is linear in the step (docs/theory/model.md, "Energy and
/// momentum").
#[test]
fn energy_of_four_kinds_between_moving_walls_closes() {
    let residual = |model: Model, sets: &[&str]| {
        let experiment = case(FOUR_BETWEEN_MOVING_WALLS, model, sets).unwrap();
        let start = initial_state(&experiment).unwrap();
        let (outcome, _) = execute(&experiment, start, &mut []);
        assert!(outcome.failure.is_none());
        let residual = outcome.energy_residual.value / outcome.energy_at_start;
        println!("{model:?} {sets:?}: {} at walls, residual {residual:.1e}", outcome.walls.count);
        assert!(outcome.walls.count > 20 && outcome.record.ledger.wall_work > 0.01 * outcome.energy_at_start);
        residual.abs()
    };
    assert!(residual(Model::Hard, &["run.duration=1 ms"]) < 1e-12);
    assert!(residual(Model::Soft, &["soft.stepping=\"local\""]) < 1e-6);
    let coarse = residual(Model::Soft, &["soft.stepping=\"uniform\""]);
    let fine = residual(Model::Soft, &["soft.stepping=\"uniform\"", "soft.steps_per_contact=200"]);
    assert!(coarse < 5e-3 && fine < 0.3 * coarse, "{coarse:e} {fine:e}");
}
