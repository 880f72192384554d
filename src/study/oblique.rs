//! Oblique impacts of the two bodies of `diptych impact`, for comparison with measured points. Each variant gives a
//! curve: the reduced slip s/(μ u_n) after an impact as a function of the reduced slip before it. Here s is the slip, μ
//! the coefficient of friction and u_n the normal speed. A variant is one of the experiments of a case.

use super::impact::ImpactPair;
use crate::engine::Partner;
use crate::experiment::Experiment;
use crate::output::{ObliqueCurve, ObliqueStudy};
use crate::particles::Particles;
use crate::rotation::{PartialSlip, slip};
use crate::simulation::Simulation;
use nalgebra::Vector3;

/// Number of impacts, each with another slip, from which a curve is made.
const POINTS: usize = 28;

/// [-] largest reduced slip s/(μ u_n) before an impact (slip s, coefficient of friction μ, normal speed u_n). This
/// number is in units of the reduced slip at which sticking ends under Walton's rule with tangential restitution β_0 =
/// 0.
const REACH: f64 = 2.0;

/// Number of windows (pieces of the run) in the time from the start to the expected end of the contact. If the contact
/// has not ended after `LONGEST` windows, the impact has no point on the curve.
const WINDOWS: f64 = 10.0;
const LONGEST: u64 = 60;

/// [-] Mindlin's ratio k_t/k_n = 4 G*/E* of the tangential and normal stiffness of the two bodies (G*, E*: their
/// effective shear and Young's modulus). It is computed with the contact law of the first variant (experiment of the
/// case) whose law has elastic constants; `None` without such a law.
fn compliance_ratio(variants: &[(&Experiment, &Particles)], meeting: &ImpactPair) -> Option<f64> {
    let ratio = |(experiment, _): &(&Experiment, &Particles)| {
        // `shear_ratio` is 8 G*/(4/3 E*), from k_t = 8 G* a and the factor 4/3 E* of Hertz's force. The normal
        // stiffness, the derivative of this force, is k_n = 2 E* a (a: radius of the contact area)
        Some(experiment.law()?.shear_ratio(meeting.bodies.elasticity) / 1.5)
    };
    variants.iter().filter_map(ratio).find(|ratio| *ratio > 0.0)
}

/// [-] ratio M_t/M of the effective masses of slip and normal motion for solid spheres (docs/rotation.md). The measured
/// points are valid for this ratio.
const SOLID: f64 = 2.0 / 7.0;

/// Measured angle [°] between the velocity before the impact and the normal, and tangential velocity of the centre
/// after the impact divided by that before it. Spheres of aluminium oxide of 5 mm hit thick soda-lime glass at 3.9 m/s
/// (Kharaz, Gorham and Salman 2001, Powder Technol. 120, 281; numbers as in the test DEM05 of MFIX,
/// truongd8593/mfix@15c6363a).
const MEASURED: [(f64, f64); 8] = [
    (2.0275, 0.7938),
    (3.9282, 0.7450),
    (9.6304, 0.6728),
    (20.0845, 0.5964),
    (30.2218, 0.6883),
    (39.3031, 0.7719),
    (49.5459, 0.8469),
    (59.8416, 0.9019),
];

/// [-] coefficient of friction of the surfaces in the measured impacts (MFIX DEM05).
const MEASURED_FRICTION: f64 = 0.092;

/// Oblique impacts of the two bodies with each variant (experiment of a case), at the normal speed `speed` [m/s] of
/// the case. `None` if there is no rotation, no friction or no approach.
pub(super) fn oblique(
    variants: &[(&Experiment, &Particles)],
    meeting: &ImpactPair,
    speed: f64,
) -> Option<ObliqueStudy> {
    let (first, particles) = variants.first()?;
    let friction = meeting.surface.friction;
    if first.scene.rotation.is_none() || friction <= 0.0 || speed <= 0.0 {
        return None;
    }
    let mass_ratio = mass_ratio(particles, meeting)?;
    let restitution = meeting.surface.restitution;
    let most = REACH * (1.0 + restitution) / mass_ratio;
    let slips = (1..=POINTS).map(|k| most * k as f64 / POINTS as f64);
    let curve = |(experiment, particles): &(&Experiment, &Particles)| {
        let points = slips.clone().filter_map(|reduced| {
            let after = thrown(experiment, particles, meeting, (speed, reduced * friction * speed))?;
            Some((reduced, after / (friction * speed)))
        });
        ObliqueCurve { name: experiment.name.clone(), points: points.collect() }
    };
    let curves: Vec<ObliqueCurve> = variants.iter().map(curve).collect();
    let measured = MEASURED.iter().map(|(angle, ratio)| {
        let reduced = angle.to_radians().tan() / MEASURED_FRICTION;
        // an impact changes the slip of the surface by 1/(M_t/M) times the change of the velocity of the centre, with
        // the effective masses M_t of the slip and M of the normal motion
        (reduced, reduced * (1.0 - (1.0 - ratio) / SOLID))
    });
    let solid = (mass_ratio - SOLID).abs() < 1e-6;
    let measured = if solid { measured.filter(|(reduced, _)| *reduced <= most).collect() } else { Vec::new() };
    let impulse = (1.0 + restitution) / mass_ratio;
    let partial_slip = match compliance_ratio(variants, meeting) {
        Some(ratio) => {
            let impact = PartialSlip::new(ratio, mass_ratio);
            slips.map(|reduced| (reduced, impact.rebound(reduced))).collect()
        }
        None => Vec::new(),
    };
    Some(ObliqueStudy { curves, measured, partial_slip, impulse })
}

/// [-] ratio M_t/M of the effective mass of the slip to that of the normal motion of the two bodies. `None` if the
/// particles do not rotate.
fn mass_ratio(particles: &Particles, meeting: &ImpactPair) -> Option<f64> {
    let inertia = particles.inertia.as_ref()?;
    let others = if matches!(meeting.partner, Partner::Particle(_)) { 2 } else { 1 };
    let body = |k: usize| (particles.mass[k], particles.radius[k], inertia[k]);
    Some(crate::rotation::tangential_mass((0..others).map(body)) / meeting.bodies.effective_mass)
}

/// [m/s] slip of the surfaces after an impact without gas and gravity. The last argument has the normal speed [m/s] and
/// the slip [m/s] before the impact. `None` if the impact does not end within the run, or if the run fails.
fn thrown(
    experiment: &Experiment,
    particles: &Particles,
    meeting: &ImpactPair,
    (normal_speed, slip_before): (f64, f64),
) -> Option<f64> {
    /// [-] gap between the surfaces at the start of the run, divided by the radius of the first particle.
    const GAP: f64 = 1e-6;
    let mut experiment = experiment.clone();
    experiment.scene.gravity = Vector3::zeros();
    experiment.scene.fluid = None;
    let mut particles = particles.clone();
    particles.spin = Some(vec![Vector3::zeros(); particles.len()]);
    let gap = GAP * particles.radius[0];
    let (normal, other) = match meeting.partner {
        Partner::Wall(wall) => {
            let wall = &experiment.scene.walls[wall as usize];
            let nearest = wall.geometry.law().nearest(&particles.position[0]);
            particles.position[0] -= nearest.normal * (nearest.distance - particles.radius[0] - gap);
            (
                nearest.normal,
                wall.surface_velocity(&(particles.position[0] - nearest.normal * (particles.radius[0] + gap)), 0.0),
            )
        }
        Partner::Particle(_) => {
            experiment.scene.walls.clear();
            let apart = experiment.scene.domain.separation(&particles.position[0], &particles.position[1]);
            let normal = apart.normalize();
            let closer = apart.norm() - particles.radius[0] - particles.radius[1] - gap;
            particles.position[0] -= normal * closer;
            particles.velocity[1] = Vector3::zeros();
            (normal, Vector3::zeros())
        }
    };
    let along =
        normal.cross(&Vector3::x()).try_normalize(0.1).unwrap_or_else(|| normal.cross(&Vector3::y()).normalize());
    particles.velocity[0] = other - normal * normal_speed + along * slip_before;
    let law = experiment.law();
    let lasts = law.map_or(0.0, |law| law.contact_time(&law.between(&meeting.bodies), normal_speed));
    let window = (gap / normal_speed + lasts) / WINDOWS;
    let mut simulation = Simulation::new(&experiment, particles);
    for _ in 0..LONGEST {
        simulation.run(1, window).ok()?;
        let record = &simulation.record;
        if record.pairs.count + record.walls.count > 0 {
            let particles = &simulation.particles;
            let of = |id: u32| particles.id.iter().position(|own| *own == id);
            let surface = |k: usize| particles.spin_of(k) * particles.radius[k];
            let i = of(0)?;
            let (velocity, surface) = match meeting.partner {
                Partner::Wall(_) => (particles.velocity[i] - other, surface(i)),
                Partner::Particle(_) => {
                    let j = of(1)?;
                    (particles.velocity[i] - particles.velocity[j], surface(i) + surface(j))
                }
            };
            return Some(slip(&velocity, &normal, &surface).dot(&along));
        }
    }
    None
}
