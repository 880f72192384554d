//! Rolling and twisting friction of individual walls and pairs.

use super::*;
use diptych::rotation::ResistanceFriction;

const STEPPINGS: [SoftStepping; 2] = [SoftStepping::Local, SoftStepping::Uniform];

/// Velocity and spin of a ball after rolling and spinning on a floor for 10 ms.
fn rolled(floor: &rolling::OnFloor) -> (Vector3<f64>, Vector3<f64>) {
    let mut simulation = floor.simulation(0.02, Vector3::new(0.0, 60.0, -20.0), 30.0);
    simulation.run(20, 5e-4).unwrap();
    (simulation.particles.velocity[0], simulation.particles.spin_of(0))
}

/// A rolling friction coefficient of a wall or a pair replaces that of the rolling law. The motion has the same bits
/// as with a law of this coefficient. A pair has priority over its wall.
#[test]
fn a_wall_or_a_pair_has_its_own_rolling_friction() {
    let law = |friction: f64| RollingLaw::Spring { friction, stiffness: None, damping: 0.1 };
    let own = |rolling: f64| ResistanceFriction { rolling: Some(rolling), twisting: None };
    for stepping in STEPPINGS {
        let expected = rolled(&rolling::OnFloor::new(law(0.03), stepping));
        let usual = rolling::OnFloor::new(law(0.1), stepping);
        assert_ne!(rolled(&usual), expected, "{stepping:?}");
        let mut floor = rolling::OnFloor::new(law(0.1), stepping);
        floor.own = own(0.03);
        assert_eq!(rolled(&floor), expected, "{stepping:?}");
        (floor.own, floor.of_pair) = (own(0.2), Some(own(0.03)));
        assert_eq!(rolled(&floor), expected, "{stepping:?}");
        // without friction, the ball continues to roll
        (floor.own, floor.of_pair) = (own(0.0), None);
        let (velocity, _) = rolled(&floor);
        assert!((velocity.x / 0.02 - 1.0).abs() < 1e-6, "{stepping:?}: {velocity}");
    }
}

/// With half the coefficient of twisting friction, the spin about the vertical falls by half as much.
#[test]
fn a_wall_has_its_own_twisting_friction() {
    for stepping in STEPPINGS {
        let slowed = |twisting: Option<f64>| {
            let law = RollingLaw::Spring { friction: 0.05, stiffness: None, damping: 0.1 };
            let mut floor = rolling::OnFloor::new(law, stepping);
            floor.twisting = Some(TwistingLaw { damping: 0.0 });
            floor.own = ResistanceFriction { rolling: None, twisting };
            60.0 - rolled(&floor).1.y
        };
        let of_friction = slowed(None);
        assert!(of_friction > 0.01, "{stepping:?}: {of_friction}");
        assert_eq!(slowed(Some(0.3)), of_friction, "{stepping:?}");
        let half = slowed(Some(0.15)) / of_friction;
        assert!((half - 0.5).abs() < 0.02, "{stepping:?}: {half}");
        assert_eq!(slowed(Some(0.0)), 0.0, "{stepping:?}");
    }
}
