//! Response of the particles to the gas, and of the gas to the particles. The slip is the velocity of a particle
//! relative to the gas.

use crate::drag::{Drag, Sphere};
use crate::fluid::{ChannelFlow, Fluid, Profile, Section};
use crate::scene::{Scene, Species};
use serde::Serialize;

/// [-] factor in the lifetime of eddies by Simonin's closure, T_L = 3/2 C_μ k/ε with C_μ = 0.09, as in the program
/// MFIX (`Tau_1` in its drag_gs.f). Here k is the turbulent kinetic energy and ε its dissipation rate. Particles with
/// a slip velocity leave eddies sooner, so a velocity variance computed with this factor is an upper limit.
const EDDY_TIME: f64 = 1.5 * 0.09;

/// Response of one species of particles to the gas.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Flow {
    /// Name of the species of particles.
    pub species: String,
    /// [s] Stokes response time: time in which drag reduces a small slip velocity to 1/e of its value.
    pub stokes_time: f64,
    /// [m/s] terminal slip speed, at which drag balances the weight; 0 without gravity.
    pub terminal_slip: f64,
    /// [-] particle Reynolds number at the terminal slip speed.
    pub slip_reynolds: f64,
    /// [s] response time of a particle at the terminal slip speed.
    pub response_time: f64,
    /// [-] Stokes number with the bulk velocity, τ_S U_b/L_y, with the Stokes response time τ_S and the width L_y of
    /// the channel.
    pub stokes_bulk: f64,
    /// [-] Stokes number with the friction velocity, τ_S u_τ/L_y, with the Stokes response time τ_S and the width L_y
    /// of the channel. `None` if the gas profile has no walls.
    pub stokes_friction: Option<f64>,
    /// [-] mass of this species divided by the mass of the gas in the box.
    pub mass_loading: f64,
    /// [m²/s²] variance of a velocity component of the particles due to the turbulence of the gas. If the turbulence
    /// does not act on the particles in this case, the value is the variance that the turbulence would cause. `None`
    /// without a turbulence model.
    pub turbulent_variance: Option<f64>,
}

/// Response to the gas of each species that has particles; empty without gas or drag. `counts` contains the number of
/// particles of each species.
pub fn flows(scene: &Scene, counts: &[usize]) -> Vec<Flow> {
    let Some(fluid) = &scene.fluid else { return Vec::new() };
    let (height, volume) = (scene.domain.size.y, scene.domain.volume());
    let density = |count: usize| count as f64 / volume;
    let present = scene.species.iter().zip(counts).filter(|(_, count)| **count > 0);
    let fraction = scene.species.iter().zip(counts).map(|(species, &count)| density(count) * species.volume()).sum();
    let gravity = |species: &Species| scene.gravity_of(species).norm();
    present
        .filter_map(|(species, &count)| flow(fluid, species, [density(count), fraction], gravity(species), height))
        .collect()
}

/// [m/s] component of the mean gas velocity against gravity, minus the largest terminal slip speed of any species (the
/// speed relative to the gas at which drag balances the weight). If the difference is positive, the gas lifts all
/// particles. `None` without drag or gravity. The gas flows along z.
pub fn lift(scene: &Scene, flows: &[Flow]) -> Option<f64> {
    scene.fluid.as_ref().filter(|_| !flows.is_empty() && scene.gravity.norm() > 0.0).map(|fluid| {
        let against = -scene.gravity.z / scene.gravity.norm() * bulk_velocity(fluid, scene.domain.size.y);
        against - flows.iter().map(|flow| flow.terminal_slip).fold(0.0, f64::max)
    })
}

/// Response to the gas of one species, whose particles have the number density `number_density` [1/m³]. Particles of
/// all species together have the volume fraction `fraction` [-]. The channel has the width `height` [m], and gravity
/// the magnitude `gravity` [m/s²]. `None` without drag.
pub fn flow(
    fluid: &Fluid,
    species: &Species,
    [number_density, fraction]: [f64; 2],
    gravity: f64,
    height: f64,
) -> Option<Flow> {
    let drag = fluid.drag.as_ref()?;
    let sphere = fluid.sphere(species).among(fraction);
    let slip = terminal_slip(drag, &sphere, gravity);
    let bulk = bulk_velocity(fluid, height);
    let response = drag.law().response_time(&sphere, slip);
    Some(Flow {
        species: species.name.clone(),
        stokes_time: sphere.stokes_time,
        terminal_slip: slip,
        slip_reynolds: slip * sphere.reynolds_per_speed,
        response_time: response,
        stokes_bulk: sphere.stokes_time * bulk.abs() / height,
        stokes_friction: fluid.profile.wall_scale().map(|wall| sphere.stokes_time * wall.friction_velocity / height),
        mass_loading: number_density * species.density * species.volume() / fluid.density,
        turbulent_variance: match &fluid.turbulence {
            Some(turbulence) => Some(turbulence.induced_variance(&fluid.profile, height, response, slip)),
            None => fluid.profile.channel_flow().map(|flow| unseen_variance(flow, response)),
        },
    })
}

/// [m²/s²] variance of a velocity component that the turbulence of a flow would cause in particles with the response
/// time `response` [s], averaged over the cross-section.
fn unseen_variance(flow: &ChannelFlow, response: f64) -> f64 {
    // mean over the cross-section, for particles that are spread evenly over it, with trapezoids between nodes; rings
    // of a pipe are narrower towards the axis
    let nodes = &flow.nodes;
    // velocities of eddies have the correlation exp(-t/T_L); a particle with a linear response of time τ then
    // has the fraction T_L/(T_L + τ) of their variance
    let induced = |k: f64, epsilon: f64| {
        let eddy = if epsilon > 0.0 { EDDY_TIME * k / epsilon } else { 0.0 };
        2.0 / 3.0 * k * eddy / (eddy + response)
    };
    let strips = nodes.windows(2).map(|pair| {
        let [a, b] = pair else { return (0.0, 0.0) };
        let area = match flow.section {
            Section::Channel => b.y - a.y,
            Section::Pipe => (b.y - a.y) * (0.5 * flow.height - 0.5 * (a.y + b.y)),
        };
        (0.5 * area * (induced(a.k, a.epsilon) + induced(b.k, b.epsilon)), area)
    });
    let (sum, area) = strips.fold((0.0, 0.0), |(sum, area), (more, strip)| (sum + more, area + strip));
    if area > 0.0 { sum / area } else { 0.0 }
}

/// [m/s] terminal slip speed w of a sphere, at which drag balances the weight: w = g τ(w). `gravity` is the
/// acceleration g [m/s²], reduced by buoyancy if there is any.
pub fn terminal_slip(drag: &Drag, sphere: &Sphere, gravity: f64) -> f64 {
    // w increases along the interval and g τ(w) does not: bisection between 0 and the slip speed of Stokes drag
    let (mut low, mut high) = (0.0, gravity * sphere.stokes_time);
    for _ in 0..200 {
        let middle = 0.5 * (low + high);
        if middle < gravity * drag.law().response_time(sphere, middle) { low = middle } else { high = middle }
    }
    0.5 * (low + high)
}

/// [m/s] mean gas velocity over the width `height` [m] of a channel, or over the cross-section of a pipe.
pub fn bulk_velocity(fluid: &Fluid, height: f64) -> f64 {
    const STRIPS: usize = 2000;
    if let (Profile::Pipe(_), Some(bulk)) = (&fluid.profile, fluid.profile.bulk_velocity()) {
        return bulk;
    }
    let velocities = (0..STRIPS).map(|i| fluid.profile.velocity((i as f64 + 0.5) * height / STRIPS as f64));
    velocities.sum::<f64>() / STRIPS as f64
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::drag::SchillerNaumann;
    use crate::fluid::{Pipe, Profile};

    /// Compares terminal slip speed and response time of the spheres of the paper (`docs/paper.md`) at g = 9.81 m/s²
    /// with an independent root of the drag law. The Stokes numbers use U_b = 15.9075 m/s.
    #[test]
    fn spheres_of_the_paper() {
        for (diameter, density, stokes, slip, reynolds, response, number) in [
            (406e-6, 1038.0, 0.520687601, 1.67597328, 44.91387, 0.170843, 207.07),
            (1.5e-3, 1032.0, 7.066266793, 5.56350207, 550.84179, 0.567126, 2810.2),
        ] {
            let fluid =
                Fluid::new(1.205, 1.515e-5, Profile::Uniform(15.9075), Some(Drag::SchillerNaumann(SchillerNaumann)));
            let species = Species::new("P", diameter, density);
            let found = flow(&fluid, &species, [1e7, 0.0], 9.81, 0.04).expect("there is drag");
            assert!((found.stokes_time / stokes - 1.0).abs() < 1e-8);
            assert!((found.terminal_slip / slip - 1.0).abs() < 1e-8, "{found:?}");
            assert!((found.slip_reynolds / reynolds - 1.0).abs() < 1e-6);
            assert!((found.response_time / response - 1.0).abs() < 1e-5);
            assert!((found.stokes_bulk / number - 1.0).abs() < 1e-4, "{found:?}");
            assert_eq!(found.turbulent_variance, None);
        }
    }

    /// Checks that tracers have the variance 2/3 k of the gas, averaged over the area of the pipe and not over its
    /// diameter.
    #[test]
    fn tracers_in_a_pipe_have_the_mean_variance_over_its_area() {
        let (diameter, viscosity) = (0.04, 1.515e-5);
        let flow_of_gas = ChannelFlow::solve_pipe(15.0, diameter, viscosity, None).unwrap();
        let nodes = flow_of_gas.nodes.clone();
        let profile = Profile::Pipe(std::sync::Arc::new(Pipe::new([0.02; 2], flow_of_gas).unwrap()));
        let drag = Some(Drag::SchillerNaumann(SchillerNaumann));
        let fluid = Fluid::new(1.205, viscosity, profile, drag);
        let tracer = Species::new("T", 1e-7, 1000.0);
        let found = flow(&fluid, &tracer, [1e7, 0.0], 9.81, diameter).unwrap().turbulent_variance.unwrap();
        // circles about the axis through the middles between nodes
        let radius = |y: f64| 0.5 * diameter - y;
        let rings = nodes.windows(3).map(|near| {
            let [outer, inner] = [near[0].y + near[1].y, near[1].y + near[2].y].map(|sum| radius(0.5 * sum));
            let area = outer * outer - inner * inner;
            (area * 2.0 / 3.0 * near[1].k, area)
        });
        let (sum, area) = rings.fold((0.0, 0.0), |(sum, area), (more, ring)| (sum + more, area + ring));
        assert!((found / (sum / area) - 1.0).abs() < 2e-3, "{found} for {}", sum / area);
    }
}
