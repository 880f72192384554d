//! A heap of three balls is stable if the friction coefficient is at least the value that statics requires.

use super::*;

/// [mm] height of the centre of the top ball of a heap of three after 0.1 s.
fn height(model: Model, sets: &[String]) -> f64 {
    let text = std::fs::read_to_string("cases/rotation/three-balls.toml").unwrap();
    let sets: Vec<&str> = sets.iter().map(String::as_str).collect();
    let experiment = case(&text, model, &sets).unwrap();
    let start = initial_state(&experiment).unwrap();
    let mut simulation = Simulation::new(&experiment, start);
    simulation.run(1000, 1e-4).unwrap();
    let top = simulation.particles.id.iter().position(|id| *id == 0).unwrap();
    1e3 * simulation.particles.position[top].y
}

/// By statics, the friction coefficient μ must be at least tan 15° with rotation. Without rotation it must be at least
/// the root of 1.5 μ² + 2 √3 μ = 0.5. At rest the overlaps are 1e-5 of a diameter, and the top ball sinks by about as
/// much.
#[test]
fn three_balls_stand_where_statics_says_so() {
    let rough = f64::to_radians(15.0).tan();
    let root = (-2.0 * 3f64.sqrt() + (12.0 + 3.0_f64).sqrt()) / 3.0;
    let (standing, fallen) = (1.0 + 3f64.sqrt(), 1.0);
    let ways = [(Model::Soft, "local"), (Model::Soft, "uniform"), (Model::Hybrid, "auto")];
    for (model, stepping) in ways {
        for (rotates, limit) in [(true, rough), (false, root)] {
            for (share, expected) in [(1.03, standing), (0.96, fallen)] {
                let friction = share * limit;
                let set = |key: &str| format!("{key}.friction={friction}");
                let stepping = format!("soft.stepping={stepping}");
                let sets = [set("contact"), set("walls[0]"), format!("contact.rotation={rotates}"), stepping];
                let found = height(model, &sets);
                assert!((found - expected).abs() < 0.1, "{model:?}, rotation {rotates}, μ {friction}: {found} mm");
            }
        }
    }
}
