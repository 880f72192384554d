//! Rolling and twisting resistance: closed forms (section RE of the catalogue of reference values), balances, and
//! contacts that are too short for resistance.

use super::*;
use diptych::rotation::{ResistanceFriction, RollingLaw, TwistingLaw};
use diptych::scene::{Kind, Meeting};

const STEPPINGS: [SoftStepping; 2] = [SoftStepping::Local, SoftStepping::Uniform];

/// Ball of 1 mm radius at rest on a floor, with gravity inclined by an angle [°].
pub(super) struct OnFloor {
    pub(super) stiffness: f64,
    friction: f64,
    /// [-] tangential stiffness and dashpot, divided by the normal ones.
    tangential: (f64, f64),
    rolling: Option<RollingLaw>,
    pub(super) twisting: Option<TwistingLaw>,
    /// Rolling and twisting friction of the floor (`own`), and of the pair of ball and floor (`of_pair`).
    pub(super) own: ResistanceFriction,
    pub(super) of_pair: Option<ResistanceFriction>,
    angle: f64,
    stepping: SoftStepping,
}

const SPRING: RollingLaw = RollingLaw::Spring { friction: 0.05, stiffness: None, damping: 0.0 };

impl OnFloor {
    pub(super) fn new(rolling: RollingLaw, stepping: SoftStepping) -> Self {
        let (friction, tangential) = (0.3, (2.0 / 7.0, 0.5));
        let (rolling, twisting, own, of_pair) = (Some(rolling), None, ResistanceFriction::default(), None);
        Self { stiffness: 1e4, friction, tangential, rolling, twisting, own, of_pair, angle: 0.0, stepping }
    }

    /// Simulation of the ball on the floor with a speed [m/s] and a spin [rad/s], pressed into the floor by its
    /// weight. A contact has `steps` time steps.
    pub(super) fn simulation(&self, speed: f64, spin: Vector3<f64>, steps: f64) -> Simulation {
        self.on(None, (speed, spin), steps)
    }

    fn on(
        &self,
        turning: Option<diptych::walls::Turning>,
        (speed, spin): (f64, Vector3<f64>),
        steps: f64,
    ) -> Simulation {
        let of = surface(0.5, self.friction);
        let species = Species { diameter: 2e-3, density: 2500.0, ..small() };
        let mut scene = empty([0.5; 3], [true, false, true], species.clone(), of);
        scene.walls = vec![plane([0.0; 3], [0.0, 1.0, 0.0], of)];
        (scene.walls[0].turning, scene.walls[0].resistance) = (turning, self.own);
        if let Some(resistance) = self.of_pair {
            scene.pairs.set(0, Kind::Wall(0), Meeting { resistance, ..of.into() });
        }
        let (sin, cos) = self.angle.to_radians().sin_cos();
        scene.gravity = Vector3::new(9.81 * sin, -9.81 * cos, 0.0);
        let (stiffness, dashpot) = self.tangential;
        let tangential = TangentialLaw::Linear(LinearTangential::Ratios { stiffness, dashpot });
        let rotation = Rotation::new(tangential, ImpactRule::COULOMB);
        scene.rotation = Some(Rotation { rolling: self.rolling, twisting: self.twisting, ..rotation });
        let sunk = species.mass() * 9.81 * cos / self.stiffness;
        let mut particles = placed(&scene, &[([0.1, 1e-3 - sunk, 0.1], [speed, 0.0, 0.0])]);
        scene.let_rotate(&mut particles);
        particles.spin.as_mut().unwrap()[0] = spin;
        let law = ContactLaw::linear(self.stiffness);
        let step = law.contact_time(&law.between(&Bodies::of_wall(&species, &of, None)), 1.0) / steps;
        Simulation::with_engine(
            scene,
            particles,
            Box::new(Soft::new(law, Integrator::VelocityVerlet, step, self.stepping)),
        )
    }

    /// Simulation of the ball at rest on a floor that turns.
    pub(super) fn turned(&self, turning: Option<diptych::walls::Turning>, steps: f64) -> Simulation {
        self.on(turning, (0.0, Vector3::zeros()), steps)
    }

    /// Simulation of the ball rolling at a speed [m/s].
    fn rolling(&self, speed: f64, steps: f64) -> Simulation {
        self.simulation(speed, Vector3::new(0.0, 0.0, -speed / 1e-3), steps)
    }
}

fn speeds(simulation: &Simulation) -> [f64; 2] {
    [simulation.particles.velocity[0].x, -simulation.particles.spin_of(0).z * 1e-3]
}

impl OnFloor {
    /// Checks that the ledger explains the energy of the ball and of its springs, up to the fraction `share` [-] of
    /// the initial energy `start` [J]. The energy of the initial overlap is added, because contacts are found in the
    /// first window.
    fn closes(&self, simulation: &Simulation, start: f64, share: f64) {
        let sunk = simulation.particles.mass[0] * 9.81 / self.stiffness;
        let residual =
            simulation.record.ledger.residual(start + 0.5 * self.stiffness * sunk * sunk, simulation.energy());
        assert!(
            residual.abs() < share * start,
            "{:?} {:?}: {residual:.1e} of {start:.1e}",
            self.stepping,
            self.twisting
        );
    }
}

/// On a level floor, a rolling ball slows down by (5/7) μ_r g (rolling friction μ_r, gravity g), with a spring at its
/// limit and with a constant torque. With a viscous torque it slows down exponentially.
#[test]
fn a_ball_on_a_level_floor_slows_down() {
    let (speed, time) = (0.02, 0.02_f64);
    let constant = RollingLaw::Constant { friction: 0.05 };
    let viscous = RollingLaw::Viscous { coefficient: 5.0 };
    let slower = speed - 5.0 / 7.0 * 0.05 * 9.81 * time;
    let decays = speed * (-5.0 / 7.0 * 5.0 * 9.81 * time).exp();
    for stepping in STEPPINGS {
        for (law, expected, tolerance) in [(SPRING, slower, 2e-3), (constant, slower, 1e-3), (viscous, decays, 1e-3)] {
            let floor = OnFloor::new(law, stepping);
            let mut simulation = floor.rolling(speed, 30.0);
            let energy = simulation.energy();
            simulation.run(100, 0.01 * time).unwrap();
            let [v, w] = speeds(&simulation);
            assert!((v - expected).abs() < tolerance * speed, "{stepping:?} {law:?}: {v} for {expected}");
            assert!((v - w).abs() < 1e-3 * speed, "{stepping:?} {law:?}: it slips, {v} {w}");
            floor.closes(&simulation, energy, 3e-4);
        }
    }
}

/// With a rolling spring, a ball of the speed u comes to rest after 7 u/(5 μ_r g) (rolling friction μ_r, gravity g)
/// and stays at rest. With a constant torque it oscillates slightly about rest.
#[test]
fn a_ball_comes_to_rest() {
    let (speed, friction) = (0.005, 0.05);
    let stops = 7.0 * speed / (5.0 * friction * 9.81);
    let way = 7.0 * speed * speed / (10.0 * friction * 9.81);
    for stepping in STEPPINGS {
        let damped = RollingLaw::Spring { friction, stiffness: None, damping: 0.3 };
        for (law, slow) in [(damped, 1e-6), (RollingLaw::Constant { friction }, 1e-4)] {
            let mut simulation = OnFloor::new(law, stepping).rolling(speed, 30.0);
            simulation.run(200, 0.02 * stops).unwrap();
            let [v, w] = speeds(&simulation);
            assert!(v.abs().max(w.abs()) < slow, "{stepping:?} {law:?}: {v} {w}");
            let gone = simulation.particles.position[0].x - 0.1;
            assert!((gone / way - 1.0).abs() < 0.03, "{stepping:?} {law:?}: {gone} for {way}");
        }
    }
}

/// Below its limit, a rolling spring of stiffness k_r makes the ball oscillate with ω² = 5 k_r/(7 m R²) (mass m,
/// radius R), if the contact hardly slips (section RE of the catalogue).
#[test]
fn a_rolling_spring_swings_below_its_limit() {
    for stepping in STEPPINGS {
        let mut floor = OnFloor::new(SPRING, stepping);
        (floor.stiffness, floor.tangential) = (1000.0, (10.0, 0.0));
        let speed = 1e-4;
        // the tangential spring has six times the frequency of the normal spring
        let mut simulation = floor.rolling(speed, 200.0);
        let energy = simulation.energy();
        // after half a period, the ball goes back at its initial speed
        let period = 0.010143712503510921;
        simulation.run(100, 0.005 * period).unwrap();
        let [v, _] = speeds(&simulation);
        assert!((v / -speed - 1.0).abs() < 2e-3, "{stepping:?}: {v}");
        let turned = simulation.particles.position[0].x - 0.1;
        assert!(turned.abs() < 5e-3 * speed * period, "{stepping:?}: {turned}");
        floor.closes(&simulation, energy, 1e-4);
    }
}

/// A ball rests on an incline with tan α <= μ_r (rolling friction μ_r; section RE of the catalogue). On a steeper
/// incline it rolls with the acceleration (5/7) g (sin α - μ_r cos α), and slips if friction is too small for rolling.
#[test]
fn a_ball_on_an_incline_rests_rolls_or_slips() {
    for stepping in STEPPINGS {
        for (angle, friction, rolling, expected) in [
            (5.0, 0.3, 0.1, [0.0, 0.0]),
            (20.0, 0.3, 0.05, [2.067355982520944; 2]),
            (30.0, 0.12, 0.02, [3.8855148946649583, 2.123927302781336]),
        ] {
            let law = RollingLaw::Spring { friction: rolling, stiffness: None, damping: 0.3 };
            let mut floor = OnFloor::new(law, stepping);
            (floor.angle, floor.friction, floor.stiffness) = (angle, friction, 1e5);
            let mut simulation = floor.simulation(0.0, Vector3::zeros(), 20.0);
            simulation.run(50, 2e-4).unwrap();
            let before = speeds(&simulation);
            simulation.run(50, 2e-4).unwrap();
            let after = speeds(&simulation);
            for k in 0..2 {
                let rate = (after[k] - before[k]) / 0.01;
                assert!((rate - expected[k]).abs() < 5e-3, "{stepping:?} {angle}°: {rate} for {}", expected[k]);
            }
        }
    }
}

/// A spin ω about the vertical ends after 3 R² ω/(5 μ g a) if the contact resists twisting (radius R, friction μ,
/// contact radius a; section RE of the catalogue). Otherwise it continues.
#[test]
fn a_spin_about_the_vertical_slows_down() {
    let spin = Vector3::new(0.0, 100.0, 0.0);
    for stepping in STEPPINGS {
        // up to the limit of the spring, an angle of 4 μ N/(3 k_t a), the torque grows linearly with time
        let (load, contact_radius) = (1.027300798e-4, 1.01355848e-5);
        let loading = 4.0 * 0.3 * load / (3.0 * 2.0 / 7.0 * 1000.0 * contact_radius) / 100.0;
        let slows = 100.0 - 100.0 / 2.011463589537948 * (0.02 - 0.5 * loading);
        for (twisting, expected) in [(None, 100.0), (Some(TwistingLaw { damping: 0.0 }), slows)] {
            let mut floor = OnFloor::new(SPRING, stepping);
            (floor.stiffness, floor.twisting) = (1000.0, twisting);
            let mut simulation = floor.simulation(0.0, spin, 30.0);
            let energy = simulation.energy();
            simulation.run(100, 2e-4).unwrap();
            let left = simulation.particles.spin_of(0).y;
            assert!((left - expected).abs() < 1e-4, "{stepping:?}: {left} for {expected}");
            floor.closes(&simulation, energy, 1e-6);
        }
    }
}

/// Rolling resistance begins only in lasting contacts, so an impact does not change by it.
#[test]
fn impacts_leave_rolling_resistance_out() {
    for stepping in STEPPINGS {
        let run = |rolling: Option<RollingLaw>| {
            let mut floor = OnFloor::new(SPRING, stepping);
            floor.rolling = rolling;
            let mut simulation = floor.simulation(0.1, Vector3::new(300.0, 20.0, 50.0), 30.0);
            simulation.particles.position[0].y = 1.05e-3;
            simulation.particles.velocity[0].y = -0.5;
            simulation.run(10, 1e-4).unwrap();
            assert_eq!(simulation.record.walls.count, 1);
            (simulation.particles.velocity[0], simulation.particles.spin_of(0))
        };
        assert_eq!(run(None), run(Some(RollingLaw::Constant { friction: 1.0 })), "{stepping:?}");
    }
}

/// Two spheres that are pressed together roll and twist on each other. Resistance is a couple, so that angular momentum
/// is conserved, and the energy balance closes.
#[test]
fn resistance_keeps_angular_momentum() {
    let local = pressed_and_rolling(SoftStepping::Local, 200.0);
    assert!(local.abs() < 2e-5, "{local:.1e}");
    let uniform = [100.0, 200.0, 400.0].map(|steps| pressed_and_rolling(SoftStepping::Uniform, steps).abs());
    assert!(uniform[0] > 1.9 * uniform[1] && uniform[1] > 1.9 * uniform[2] && uniform[2] < 2e-4, "{uniform:?}");
}

/// Two spheres roll and twist on each other. Returns the fraction of the energy that the ledger does not explain.
fn pressed_and_rolling(stepping: SoftStepping, steps: f64) -> f64 {
    let of = surface(0.5, 0.4);
    let mut scene = empty([0.02; 3], [true; 3], small(), of);
    scene.species.push(large());
    scene.species[1].name = "large".into();
    let tangential = TangentialLaw::Linear(LinearTangential::Ratios { stiffness: 0.8, dashpot: 0.3 });
    let rotation = Rotation::new(tangential, ImpactRule::COULOMB);
    scene.rotation = Some(Rotation { rolling: Some(SPRING), twisting: Some(TwistingLaw { damping: 0.2 }), ..rotation });
    let reach = 0.5 * (small().diameter + large().diameter);
    let mut particles = Particles::default();
    let normal = Vector3::new(2.0, -1.0, 2.0) / 3.0;
    let middle = Vector3::repeat(0.01);
    for (k, species, position) in [(0u16, small(), middle + normal * (0.99 * reach)), (1, large(), middle)] {
        particles.push(position, Vector3::zeros(), 0.5 * species.diameter, species.mass(), k);
    }
    scene.let_rotate(&mut particles);
    particles.spin = Some(vec![Vector3::new(900.0, -300.0, 100.0), Vector3::new(-200.0, 400.0, 700.0)]);
    let law = ContactLaw::linear(3000.0);
    let time = law.contact_time(&law.between(&Bodies::between(&scene, 0, 1)), 1.0);
    let engine = Soft::new(law, Integrator::VelocityVerlet, time / steps, stepping);
    let mut simulation = Simulation::with_engine(scene, particles, Box::new(engine));
    let before = pairs::angular_momentum(&simulation.particles);
    let energy = simulation.energy() + 0.5 * 3000.0 * (0.01 * reach).powi(2);
    simulation.run(4, 0.1 * time).unwrap();
    let spins = simulation.particles.spin.clone().unwrap();
    let after = pairs::angular_momentum(&simulation.particles);
    assert!((after - before).norm() < 1e-11 * before.norm(), "{stepping:?}: {after} for {before}");
    assert!((spins[0].x - 900.0).abs() > 0.1, "nothing resisted");
    simulation.record.ledger.residual(energy, simulation.energy()) / energy
}

/// Spheres that roll and twist on a floor continue with identical bits from a snapshot.
#[test]
fn resistance_is_remembered_by_snapshots() {
    for stepping in STEPPINGS {
        let mut scene = empty([3e-3; 3], [true, false, true], small(), surface(0.3, 0.4));
        scene.walls = vec![plane([0.0; 3], [0.0, 1.0, 0.0], surface(0.3, 0.3))];
        scene.gravity = Vector3::new(400.0, -8000.0, 0.0);
        let mut settling = experiment(scene, 3, [0.0; 3], 0.5, Model::Soft, 4);
        let rolling = Some(RollingLaw::Spring { friction: 0.3, stiffness: None, damping: 0.3 });
        let twisting = Some(TwistingLaw { damping: 0.1 });
        settling.scene.rotation = Some(Rotation { rolling, twisting, ..Rotation::new(W3.tangential(), W3.walton()) });
        settling.start[0].spin_fluctuation = 2000.0;
        settling.soft.stepping = stepping;
        let begin = || Simulation::new(&settling, initial_state(&settling).unwrap());
        let mut whole = begin();
        whole.run_while(20, 1e-4, &mut |_, _| true).unwrap();
        let mut first = begin();
        first.run_while(20, 1e-4, &mut |_, done| done < 15).unwrap();
        assert!(!first.contacts().is_empty(), "{stepping:?}: nothing lies on the floor");
        let stored = first.snapshot().unwrap();
        let mut second = Simulation::restore(&settling, stored).unwrap();
        second.run_while(5, 1e-4, &mut |_, _| true).unwrap();
        assert_eq!(whole.state(), second.state(), "{stepping:?}");
    }
}
