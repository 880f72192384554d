//! Laws of Hertz and Mindlin: tests 5, 6 and 7 of Chung and Ooi (2011) against values computed independently (section
//! RD of the catalogue of reference values), and closed energy balances.

use super::*;
use diptych::contact_law::Hertz;
use diptych::rotation::SpringHistory::{self, Displacement, Force, Rescaled};
use diptych::scene::Elasticity;

/// Sphere for an impact on a rigid plane: radius [m], density [kg/m³], Young's modulus [Pa], Poisson's ratio [-].
struct Sphere {
    radius: f64,
    density: f64,
    elasticity: Elasticity,
    restitution: f64,
    friction: f64,
}

const STEEL: Sphere = Sphere {
    radius: 1e-5,
    density: 7850.0,
    elasticity: Elasticity { youngs_modulus: 208e9, poissons_ratio: 0.3 },
    restitution: 1.0,
    friction: 0.3,
};

const ALUMINIUM: Sphere = Sphere {
    radius: 0.1,
    density: 2700.0,
    elasticity: Elasticity { youngs_modulus: 70e9, poissons_ratio: 0.33 },
    restitution: 0.5,
    friction: 0.4,
};

/// Kind of time steps and steps per contact of soft spheres; `None` for hard spheres with the impact rule of the
/// spring.
type Stepping = Option<(SoftStepping, f64)>;

impl Sphere {
    fn species(&self) -> Species {
        Species { diameter: 2.0 * self.radius, density: self.density, ..small() }
    }

    fn engine(&self, bodies: &Bodies, speed: f64, stepping: Stepping) -> Box<dyn Engine> {
        let law = ContactLaw::Hertz(Hertz { elasticity: self.elasticity });
        let Some((stepping, steps)) = stepping else { return Box::new(Hard::new()) };
        let step = law.contact_time(&law.between(bodies), speed) / steps;
        Box::new(Soft::new(law, Integrator::VelocityVerlet, step, stepping))
    }

    /// Velocity along the plane [m/s], spin [rad/s] (positive: rolling forward) and normal speed [m/s] after an
    /// impact. `history` tells the change of the spring with the normal force.
    fn rebound(&self, history: SpringHistory, [normal, along, spin]: [f64; 3], stepping: Stepping) -> [f64; 3] {
        let of = surface(self.restitution, self.friction);
        let species = self.species();
        let mut scene = empty([20.0 * self.radius; 3], [true, false, true], species.clone(), of);
        // a practically rigid plane
        let rigid = Elasticity { youngs_modulus: 1e30, poissons_ratio: 0.3 };
        scene.walls = vec![plane([0.0; 3], [0.0, 1.0, 0.0], of)];
        scene.walls[0].elasticity = Some(rigid);
        let law = ContactLaw::Hertz(Hertz { elasticity: self.elasticity });
        let tangential = TangentialLaw::Mindlin { history, dashpot: 0.0 };
        let kinds = scene.impact_kinds(|elasticity| law.shear_ratio(elasticity));
        scene.rotation = Some(Rotation::new(tangential, ImpactRule::of_spring(&tangential, &kinds)));
        let middle = 10.0 * self.radius;
        let gap = 1e-4 * self.radius;
        let mut particles = placed(&scene, &[([middle, self.radius + gap, middle], [along, -normal, 0.0])]);
        scene.let_rotate(&mut particles);
        particles.spin.as_mut().unwrap()[0].z = -spin;
        let bodies = Bodies::of_wall(&species, &of, Some(rigid));
        let spring = law.between(&bodies);
        let engine = self.engine(&bodies, normal, stepping);
        let mut simulation = Simulation::with_engine(scene, particles, engine);
        let energy = simulation.energy();
        simulation.run(4, 0.25 * (1.5 * law.contact_time(&spring, normal) + gap / normal)).unwrap();
        // the work of rescaling counts as friction in the ledger, so that the balance closes for every history
        let residual = simulation.record.ledger.residual(energy, simulation.energy());
        let closes = if stepping.is_some_and(|(stepping, _)| stepping == SoftStepping::Uniform) { 2e-2 } else { 2e-4 };
        assert!(residual.abs() < closes * energy, "{history:?} {stepping:?}: {residual:.1e} of {energy:.1e}");
        let velocity = simulation.particles.velocity[0];
        [velocity.x, -simulation.particles.spin_of(0).z, velocity.y]
    }
}

/// Test 5 of Chung and Ooi: speed along the plane before the impact [m/s]. Then the slip and R ω' after it (radius R,
/// spin ω'), both over μ u_n (friction, normal speed), for the three histories of the spring.
const OBLIQUE: &[(f64, [[f64; 2]; 3])] = &[
    (0.1, [[0.063652, 0.002153], [0.060511, 0.004397], [0.034561, 0.022933]]),
    (0.6, [[0.381062, 0.013527], [0.307550, 0.066036], [0.202643, 0.140969]]),
    (1.5, [[0.666837, 0.237974], [0.503488, 0.354651], [0.414983, 0.417869]]),
    (3.0, [[-0.276258, 1.625898], [-0.175621, 1.554015], [-0.190808, 1.564863]]),
    (6.0, [[-1.397981, 3.855701], [-1.559906, 3.971361], [-1.397981, 3.855701]]),
    (9.0, [[-0.981406, 4.986718], [-1.000000, 5.000000], [-0.981406, 4.986718]]),
    (21.0, [[7.000000, 5.000000], [7.000000, 5.000000], [7.000000, 5.000000]]),
];

#[test]
fn oblique_impacts_of_steel_are_those_of_the_reference() {
    let unit = 0.3 * 5.0;
    for (stepping, tolerance) in
        [(Some((SoftStepping::Local, 200.0)), 2e-4), (Some((SoftStepping::Uniform, 200.0)), 2e-2), (None, 2e-5)]
    {
        let mut worst = 0.0f64;
        for (along, expected) in OBLIQUE {
            for (history, [slip, spin]) in [Displacement, Force, Rescaled].into_iter().zip(expected) {
                let [v, w, _] = STEEL.rebound(history, [5.0, *along, 0.0], stepping);
                let found = [(v - STEEL.radius * w) / unit, STEEL.radius * w / unit];
                let miss = (found[0] - slip).abs().max((found[1] - spin).abs());
                worst = worst.max(miss / (along / unit).max(1.0));
            }
        }
        println!("Chung and Ooi 5, {stepping:?}: largest error {worst:.1e} of the larger of slip and μ u_n");
        assert!(worst < tolerance, "{stepping:?}: {worst:.1e}");
    }
}

/// Test 6 of Chung and Ooi: spin before the impact [rad/s]. Then the velocity along the plane [m/s] and the spin
/// [rad/s] after it, for the three histories of the spring.
const SPINNING: &[(f64, [[f64; 2]; 3])] = &[
    (0.175, [[-0.0033667, 0.0908328], [-0.0045680, 0.0608001], [-0.0048897, 0.0527565]]),
    (1.2, [[-0.0494663, -0.0366567], [-0.0491210, -0.0280257], [-0.0490555, -0.0263874]]),
    (2.8, [[-0.1057884, 0.1552896], [-0.1072049, 0.1198778], [-0.1056563, 0.1585923]]),
    (4.0, [[-0.1225956, 0.9351095], [-0.1217175, 0.9570627], [-0.1217175, 0.9570627]]),
    (21.0, [[-0.1237813, 17.9054672], [-0.1236560, 17.9085997], [-0.1236560, 17.9085997]]),
];

/// In the reference, a positive spin moves the surface at the contact along +x. Our positive spin rolls forward, so it
/// has the opposite sign.
#[test]
fn a_spinning_sphere_leaves_the_plane_as_the_reference() {
    for (stepping, tolerance) in [(Some((SoftStepping::Local, 200.0)), 1e-3), (None, 1e-4)] {
        let mut worst = 0.0f64;
        for (spin, expected) in SPINNING {
            for (history, [along, left]) in [Displacement, Force, Rescaled].into_iter().zip(expected) {
                let [v, w, n] = ALUMINIUM.rebound(history, [0.2, 0.0, -spin], stepping);
                // in units of the change of a sliding sphere: μ (1+e) u_n for the velocity, and 5/2 of this over R for
                // the spin
                let change = 0.4 * 1.5 * 0.2;
                let miss = ((v - along) / change).abs().max(((-w - left) * 0.1 / (2.5 * change)).abs());
                worst = worst.max(miss);
                assert!((n / 0.1 - 1.0).abs() < 3e-4, "{n}");
            }
        }
        println!("Chung and Ooi 6, {stepping:?}: largest error {worst:.1e} of the change by sliding");
        assert!(worst < tolerance, "{stepping:?}: {worst:.1e}");
    }
}

/// Test 7 of Chung and Ooi: two spheres with opposite spins, whose surfaces move alike, collide as if they were
/// smooth.
#[test]
fn opposite_spins_do_not_slip() {
    let of = surface(0.5, 0.4);
    let species = ALUMINIUM.species();
    let mut scene = empty([2.0; 3], [true; 3], species.clone(), of);
    scene.rotation =
        Some(Rotation::new(TangentialLaw::Mindlin { history: Rescaled, dashpot: 0.0 }, ImpactRule::COULOMB));
    let speed = 0.2;
    let mut particles =
        placed(&scene, &[([0.8, 1.0, 1.0], [speed, 0.0, 0.0]), ([1.0001, 1.0, 1.0], [-speed, 0.0, 0.0])]);
    scene.let_rotate(&mut particles);
    particles.spin = Some(vec![Vector3::new(0.0, 0.0, 21.0), Vector3::new(0.0, 0.0, -21.0)]);
    let bodies = Bodies::alike(&species, &of);
    let engine = ALUMINIUM.engine(&bodies, 2.0 * speed, Some((SoftStepping::Local, 50.0)));
    let mut simulation = Simulation::with_engine(scene, particles, engine);
    simulation.run(20, 1e-3).unwrap();
    assert_eq!(simulation.record.pairs.count, 1);
    assert_eq!(simulation.particles.spin_of(0), Vector3::new(0.0, 0.0, 21.0));
    assert_eq!(simulation.particles.velocity[0].y, 0.0);
    assert!((simulation.particles.velocity[0].x / -0.1 - 1.0).abs() < 2e-3);
}
