//! Impacts of two rotating spheres with finite stiffness.

use super::*;

/// Pair of spheres of a reference case.
struct Pair {
    /// Radius [m] and density [kg/m³] of the two spheres p and q.
    spheres: [(f64, f64); 2],
    stiffness: f64,
    surfaces: Surfaces,
    normal: [f64; 3],
    /// [m/s] velocity of sphere p relative to sphere q.
    velocity: [f64; 3],
    /// [rad/s] spins of the spheres p and q.
    spins: [[f64; 3]; 2],
}

const fn smooth(restitution: f64, friction: f64, stiffness: f64) -> Surfaces {
    Surfaces { restitution, friction, stiffness, dashpot: 0.0, walton: 0.0 }
}

impl Pair {
    fn scene(&self) -> (Scene, Particles) {
        let Surfaces { restitution, friction, .. } = self.surfaces;
        let species = |(radius, density): (f64, f64)| Species { diameter: 2.0 * radius, density, ..small() };
        let mut scene = empty([0.02; 3], [false; 3], species(self.spheres[0]), surface(restitution, friction));
        scene.species.push(species(self.spheres[1]));
        scene.rotation = Some(Rotation::new(self.surfaces.tangential(), ImpactRule::COULOMB));
        let mut particles = Particles::default();
        let (middle, normal) = (Vector3::repeat(0.01), Vector3::from(self.normal));
        let apart = self.spheres[0].0 + self.spheres[1].0 + 1e-13;
        let relative = Vector3::from(self.velocity);
        let [p, q] = [0, 1].map(|k| scene.species[k].mass());
        for (k, position, velocity) in
            [(0, middle + normal * apart, relative * (q / (p + q))), (1, middle, relative * (-p / (p + q)))]
        {
            let species = &scene.species[k];
            particles.push(position, velocity, 0.5 * species.diameter, species.mass(), k as u16);
        }
        scene.let_rotate(&mut particles);
        particles.spin = Some(self.spins.map(Vector3::from).to_vec());
        (scene, particles)
    }

    /// Relative velocity [m/s] and spins [rad/s] after the impact. Checks that momentum and angular momentum are
    /// conserved, and that the ledger explains the energy up to the fraction `unexplained` [-].
    fn rebound(&self, stepping: SoftStepping, steps: f64, unexplained: f64) -> (Vector3<f64>, [Vector3<f64>; 2]) {
        let (scene, particles) = self.scene();
        let law = ContactLaw::linear(self.stiffness);
        let bodies = Bodies::between(&scene, 0, 1);
        let time = law.contact_time(&law.between(&bodies), 1.0);
        let engine = Soft::new(law, Integrator::VelocityVerlet, time / steps, stepping);
        let mut simulation = Simulation::with_engine(scene, particles, Box::new(engine));
        let (momentum, angular) = (simulation.particles.momentum(), angular_momentum(&simulation.particles));
        let energy = simulation.energy();
        simulation.run(4, 2.0 * time).unwrap();
        let (after, turned) = (simulation.particles.momentum(), angular_momentum(&simulation.particles));
        assert!((after - momentum).norm() < 1e-13 * simulation.particles.mass[0]);
        // each of the 8 N_c uniform steps rounds positions of 0.01 m, in free flight in one direction: by 2e-18 m, for
        // lever arms of 4e-4 m; in local stepping a free flight is one step
        let uniform = 8.0 * steps * 2.0 * 2e-18 / 4e-4;
        let rounded = if stepping == SoftStepping::Uniform { uniform } else { 3e-12 };
        assert!((turned - angular).norm() < rounded * angular.norm(), "{turned} for {angular}");
        let residual = simulation.record.ledger.residual(energy, simulation.energy());
        assert!(residual.abs() < unexplained * energy, "{residual:.1e} of {energy:.1e}");
        let particles = &simulation.particles;
        let spins = particles.spin.as_ref().unwrap();
        let of = |id: u32| particles.id.iter().position(|own| *own == id).unwrap();
        (particles.velocity[of(0)] - particles.velocity[of(1)], [spins[of(0)], spins[of(1)]])
    }
}

/// [kg m²/s] total angular momentum of the particles about the middle of the box.
pub fn angular_momentum(particles: &Particles) -> Vector3<f64> {
    let (spins, inertia) = (particles.spin.as_ref().unwrap(), particles.inertia.as_ref().unwrap());
    let of = |k: usize| {
        let arm = particles.position[k] - Vector3::repeat(0.01);
        arm.cross(&particles.velocity[k]) * particles.mass[k] + spins[k] * inertia[k]
    };
    (0..particles.len()).map(of).sum()
}

/// Reference case: name, pair, and relative velocity [m/s] and spins [rad/s] after the impact.
type ReferencePair = (&'static str, Pair, [f64; 3], [[f64; 3]; 2]);

/// Pairs of spheres with finite stiffness (section RB of the catalogue of reference values). The lever arms of
/// friction end at a common point of contact. The pair RB2 moves in three dimensions; its spring turns with the spin
/// about the normal.
fn reference_pairs() -> [ReferencePair; 5] {
    let (half, one) = ([(5e-4, 2500.0); 2], [(2e-4, 1038.0), (7.5e-4, 1032.0)]);
    let turned = [2.0 / 3.0, -1.0 / 3.0, 2.0 / 3.0];
    [
        (
            "P1",
            Pair {
                spheres: half,
                stiffness: 1e5,
                surfaces: smooth(1.0, 0.3, 0.285714286),
                normal: [1.0, 0.0, 0.0],
                velocity: [-1.0, 0.8, 0.0],
                spins: [[0.0; 3]; 2],
            },
            [0.997363255, 0.346157596, 0.0],
            [[0.0, 0.0, 1146.0954467], [0.0, 0.0, 1146.0954467]],
        ),
        (
            "P2",
            Pair {
                spheres: half,
                stiffness: 1e5,
                surfaces: smooth(0.9, 0.3, 0.8),
                normal: [1.0, 0.0, 0.0],
                velocity: [-1.0, 1.2, 0.0],
                spins: [[0.0, 0.0, 300.0], [0.0, 0.0, -900.0]],
            },
            [0.893626724, 0.649534697, 0.0],
            [[0.0, 0.0, 1692.4541894], [0.0, 0.0, 492.4541894]],
        ),
        (
            "P4",
            Pair {
                spheres: one,
                stiffness: 100.0,
                surfaces: smooth(0.9, 0.4, 0.285714286),
                normal: [1.0, 0.0, 0.0],
                velocity: [-0.5, 0.9, 0.0],
                spins: [[0.0; 3], [0.0, 0.0, 700.0]],
            },
            [0.413255432, 0.702593925, 0.0],
            [[0.0, 0.0, 2675.5670904], [0.0, 0.0, 713.6084428]],
        ),
        (
            "V1",
            Pair {
                spheres: one,
                stiffness: 3000.0,
                surfaces: smooth(0.94, 0.325, 0.8),
                normal: turned,
                velocity: [-1.3, 0.7, 0.1],
                spins: [[100.0, -50.0, 20.0], [-30.0, 10.0, 60.0]],
            },
            [0.2923953494, -0.0994276058, 1.1039933366],
            [[-2380.6035441, -4951.2706607, 51.1538967], [-42.6168211, -14.9287941, 60.1584546]],
        ),
        (
            "V2",
            Pair {
                spheres: half,
                stiffness: 300.0,
                surfaces: smooth(1.0, 0.5, 0.285714286),
                normal: [1.0, 0.0, 0.0],
                velocity: [-0.6, 0.25, 0.0],
                spins: [[9000.0, 0.0, 100.0], [7000.0, 200.0, 0.0]],
            },
            [0.5938642168, 0.1609342973, -0.0166808587],
            [[9000.1790266, -37.7331037, 367.3305818], [7000.1790266, 162.2668963, 267.3305818]],
        ),
    ]
}

/// [-] largest deviation from the reference after an impact, of the relative velocity or of radius times spin, over
/// the speed before the impact.
fn deviation((name, pair, velocity, spins): &ReferencePair, (v, w): (Vector3<f64>, [Vector3<f64>; 2])) -> f64 {
    let speed = Vector3::from(pair.velocity).norm();
    let off = (v - Vector3::from(*velocity)).norm() / speed;
    let turns = (0..2).map(|k| (w[k] - Vector3::from(spins[k])).norm() * pair.spheres[k].0 / speed);
    let off = turns.fold(off, f64::max);
    println!("{name}: {off:.1e}");
    off
}

#[test]
fn soft_pairs_are_those_of_the_reference() {
    for case in reference_pairs() {
        let off = deviation(&case, case.1.rebound(SoftStepping::Local, 200.0, 1e-7));
        assert!(off < 1e-6, "{}: {off:.1e}", case.0);
    }
}

/// Results of uniform steps converge to the reference for short steps. Each particle of a pair rotates, the spring
/// turns with both spins, and the loss by friction does not contain the energy of the spring.
#[test]
fn soft_pairs_by_uniform_stepping_converge() {
    for case in reference_pairs() {
        for steps in [100.0, 400.0] {
            let off = deviation(&case, case.1.rebound(SoftStepping::Uniform, steps, 0.5 / steps));
            assert!(off < 2e-3 * 100.0 / steps, "{} with {steps} steps: {off:.1e}", case.0);
        }
    }
}
