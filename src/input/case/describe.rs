//! Describes an experiment in plain words. A variant is the case with one collision model and some settings.

use super::parameters::{bulk_velocity, volume_fraction};
use crate::experiment::{
    Amount, AverageFrom, DsmcSettings, Experiment, HardStepping, Integrator, Model, SoftStepping, TimeStep,
};
use crate::fluid::{EddyLaw, Fluid, Langevin, LocalTurbulence, Turbulence};
use crate::predict::contact::usual_impact;
use crate::predict::flow::terminal_slip;
use crate::scene::{Kind, OutletShape, Scene, Species, Surface, Thermostat};
use crate::walls::{Geometry, PrescribedMotion, Wall};
use nalgebra::Vector3;
use std::fmt::Write;

/// Describes the scene of an experiment, its model and its run, with one statement per line.
pub fn describe(experiment: &Experiment) -> String {
    format!("{}{}\n{}", scene_in_words(experiment), model_in_words(experiment), run_in_words(experiment))
}

/// Describes all variants, with one statement per line. First are the statements about the scene that hold for all
/// variants. Then follows one line per variant, with its name, its model and its other statements. Last are the
/// statements about the run that hold for all variants.
pub fn describe_variants<'a>(variants: impl IntoIterator<Item = &'a Experiment>) -> String {
    let variants: Vec<&Experiment> = variants.into_iter().collect();
    let words = |part: fn(&Experiment) -> String| variants.iter().map(|one| part(one)).collect::<Vec<String>>();
    let (scenes, runs) = (words(scene_in_words), words(run_in_words));
    let (scene, run) = (common(&scenes), common(&runs));
    let mut text: String = scene.iter().map(|line| format!("{line}\n")).collect();
    for ((experiment, own_scene), own_run) in variants.iter().zip(&scenes).zip(&runs) {
        let model = model_in_words(experiment);
        let own = own_scene.lines().filter(|line| !scene.contains(line));
        let own = own.chain(own_run.lines().filter(|line| !run.contains(line)));
        let line = std::iter::once(model.trim_start_matches("Model ")).chain(own).collect::<Vec<_>>().join(" ");
        let line = format!("\"{}\": {line}\n", experiment.name);
        // a variant may have the same settings at several points of a sweep; its line is then written once
        if !text.contains(&line) {
            text += &line;
        }
    }
    text.extend(run.iter().map(|line| format!("{line}\n")));
    text
}

/// Lines of the first text that occur in all texts.
fn common(texts: &[String]) -> Vec<&str> {
    let lines = texts.first().map_or("", String::as_str).lines();
    lines.filter(|line| texts.iter().all(|text| text.lines().any(|other| other == *line))).collect()
}

fn run_in_words(experiment: &Experiment) -> String {
    let run = &experiment.run;
    let average = match run.average_from {
        AverageFrom::Time(0.0) => "averaged over all of it".to_string(),
        AverageFrom::Time(from) => format!("averaged from {} on", time(from)),
        AverageFrom::Steady => "averaged from where the run finds itself steady".to_string(),
    };
    let slices = match experiment.statistics.slices {
        1 => "over the whole height".to_string(),
        slices => format!("in {slices} slices across y"),
    };
    let mut text = format!(
        "Run: {}, {average}, {slices}; seed {}; window {}.\n",
        time(run.duration),
        run.seed,
        run.window.map_or("chosen by the run".to_string(), time),
    );
    let observed = experiment.observe.names();
    if !observed.is_empty() {
        let _ = writeln!(text, "Measured in addition: {}.", observed.join(", "));
    }
    text
}

/// Adds to `text` a line about the shear of the box and one about its orbit, if the box has them.
fn shear_in_words(text: &mut String, scene: &Scene) {
    if let Some(shear) = &scene.domain.shear {
        let speed = scene.domain.sliding();
        let _ = writeln!(
            text,
            "Shear: {} 1/s along z, growing along y; images across y slide at {} m/s.",
            short(shear.rate, 4),
            short(speed, 4)
        );
    }
    if let Some(orbit) = scene.domain.orbit() {
        let _ = writeln!(
            text,
            "Orbit: {} 1/s about x, oscillations along x at {} 1/s.",
            short(orbit.rate, 4),
            short(orbit.vertical_frequency, 4)
        );
    }
}

/// Adds to `text` one line of description for each outlet and each inlet.
fn openings_in_words(text: &mut String, scene: &Scene) {
    for outlet in &scene.outlets {
        let place = match &outlet.shape {
            OutletShape::Behind(plane) => {
                let [p, n] = [plane.point, plane.normal].map(|v| v.map(|x| short(x, 4)));
                format!("behind the plane through ({}, {}, {}) m facing ({}, {}, {})", p.x, p.y, p.z, n.x, n.y, n.z)
            }
            OutletShape::Body(body) => format!("in a {}", body.in_words()),
            OutletShape::Mesh(mesh) => format!("in a closed surface of {} triangles", mesh.triangles().1.len()),
        };
        let _ = writeln!(text, "Outlet \"{}\": particles leave {place}.", outlet.name);
    }
    for inlet in &scene.inlets {
        let species = &scene.species[usize::from(inlet.species)];
        let closes = if inlet.end.is_finite() { format!(" until {}", time(inlet.end)) } else { String::new() };
        let _ = writeln!(
            text,
            "Inlet \"{}\": {} particles per second come in, {} kg/s, from {}{closes}.",
            inlet.name,
            short(inlet.rate, 4),
            short(inlet.rate * species.own_mass(), 4),
            time(inlet.start)
        );
    }
}

/// Describes the scene of an experiment, without its model and its run.
pub(crate) fn scene_in_words(experiment: &Experiment) -> String {
    let scene = &experiment.scene;
    let mut text = String::new();
    let size = scene.domain.size;
    let periodic: Vec<&str> =
        ["x", "y", "z"].into_iter().zip(scene.domain.periodic).filter(|(_, on)| *on).map(|(axis, _)| axis).collect();
    let periodic = if periodic.is_empty() {
        "not periodic".to_string()
    } else {
        format!("periodic along {}", periodic.join(" and "))
    };
    let _ = writeln!(
        text,
        "Box: {} x {} x {} (x spanwise, y wall-normal, z streamwise), {periodic}.",
        length(size.x),
        length(size.y),
        length(size.z)
    );
    shear_in_words(&mut text, scene);
    if let Some(thermostat) = &scene.thermostat {
        let _ = match thermostat {
            Thermostat::Stochastic { heating } => writeln!(
                text,
                "Thermostat: random accelerations that raise T by {} m^2/s^3 per second.",
                short(*heating, 4)
            ),
            Thermostat::Gaussian { rate } => writeln!(
                text,
                "Thermostat: velocities relative to the mean grow exponentially at {} 1/s.",
                short(*rate, 4)
            ),
        };
    }
    for (index, wall) in scene.walls.iter().enumerate() {
        let shape = match wall.geometry.plane() {
            Some(plane) => {
                let (p, n) = (plane.point, plane.normal);
                format!(
                    "plane through ({}, {}, {}) facing ({}, {}, {})",
                    length(p.x),
                    length(p.y),
                    length(p.z),
                    short(n.x, 4),
                    short(n.y, 4),
                    short(n.z, 4)
                )
            }
            None => wall.geometry.law().in_words(),
        };
        let _ = writeln!(text, "Wall {index}: {shape}, {}{}.", surface(&wall.surface), motion_in_words(wall));
    }
    openings_in_words(&mut text, scene);
    particles_in_words(&mut text, experiment, scene);
    if scene.gravity_alone().norm() > 0.0 {
        let g = scene.gravity_alone();
        let _ = writeln!(text, "Gravity: ({}, {}, {}) m/s^2.", g.x, g.y, g.z);
    } else {
        text.push_str("No gravity.\n");
    }
    gas_in_words(&mut text, scene);
    text
}

/// Describes in words the motion of a wall and of its surface, and its coefficients of rolling and twisting friction.
/// The text is empty if the wall has none of these.
fn motion_in_words(wall: &Wall) -> String {
    let mut text = String::new();
    let vector = |v: &Vector3<f64>| format!("({}, {}, {})", short(v.x, 4), short(v.y, 4), short(v.z, 4));
    if wall.velocity.norm() > 0.0 {
        let _ = write!(text, ", its surface moves at {} m/s", vector(&wall.velocity));
    }
    if let Some(turning) = &wall.turning {
        let _ = write!(text, ", its surface turns at {} rad/s", vector(&turning.spin));
    }
    if let Some(moving) = &wall.moving {
        let _ = match moving.motion() {
            PrescribedMotion::Translation { velocity } => write!(text, ", moves at {} m/s", vector(velocity)),
            PrescribedMotion::Vibration { amplitude, frequency, .. } => write!(
                text,
                ", vibrates at {} Hz with the amplitude ({}, {}, {}), {} m/s at most",
                short(*frequency, 4),
                length(amplitude.x),
                length(amplitude.y),
                length(amplitude.z),
                short(moving.largest_speed(), 4)
            ),
            PrescribedMotion::Path(_) => {
                write!(text, ", moves on a given path, at {} m/s at most", short(moving.largest_speed(), 4))
            }
            PrescribedMotion::Turning(turning) => write!(text, ", turns at {} rad/s", vector(&turning.spin)),
            PrescribedMotion::Servo(servo) => write!(
                text,
                ", moves along its normal at {} m/s at most, so that particles press on it with {} Pa",
                short(servo.largest_speed, 4),
                short(servo.pressure, 4)
            ),
        };
    }
    if let Some(roughness) = &wall.roughness {
        let _ = write!(text, ", rough with facets inclined by {} degrees", short(roughness.deviation.to_degrees(), 4));
    }
    if let Some(thermal) = &wall.thermal {
        let _ = write!(text, ", thermal with T = {} m^2/s^2", short(thermal.temperature, 4));
    }
    for (name, friction) in [("rolling", wall.resistance.rolling), ("twisting", wall.resistance.twisting)] {
        if let Some(friction) = friction {
            let _ = write!(text, ", {name} friction {friction}");
        }
    }
    text
}

fn particles_in_words(text: &mut String, experiment: &Experiment, scene: &Scene) {
    for population in &experiment.start {
        let Some(species) = scene.species.get(usize::from(population.species)) else { continue };
        let count = population.amount.count();
        let start = match population.amount {
            Amount::Count(_) => {
                let (mean, spread) = (population.velocity_mean, population.velocity_fluctuation);
                let spread = if spread.x == spread.y && spread.y == spread.z {
                    format!("{} m/s of fluctuation per component", spread.x)
                } else {
                    format!("fluctuations of ({}, {}, {}) m/s", spread.x, spread.y, spread.z)
                };
                format!("at random places, mean velocity ({}, {}, {}) m/s with {spread}", mean.x, mean.y, mean.z)
            }
            Amount::Placed(_) => "at given places".to_string(),
        };
        let _ = writeln!(
            text,
            "Particles: {count} of \"{}\", {}, density {} kg/m^3, {start}.",
            species.name,
            sizes_in_words(species),
            species.density
        );
    }
    let _ = writeln!(
        text,
        "Together they fill {:.4e} of the box. Particle against particle: {}.",
        volume_fraction(experiment, scene),
        surface(&scene.contact)
    );
    if scene.depends_on_speed() {
        let speed = usual_impact(scene, &experiment.start);
        let _ = writeln!(
            text,
            "Restitution depends on the normal speed u of the impact; a usual one has u = {speed:.3e} m/s."
        );
    }
    if let Some(rotation) = &scene.rotation {
        let _ = writeln!(text, "Particles rotate: {rotation}.");
    } else if rests_by_friction(scene) {
        text.push_str("Particles do not rotate: columns and heaps that friction holds stand or fall otherwise than those of particles that do.\n");
    }
    for (species, other, meeting) in scene.pairs.iter() {
        let other = match other {
            Kind::Species(other) => format!("\"{}\"", scene.species[usize::from(*other)].name),
            Kind::Wall(wall) => format!("wall {wall}"),
        };
        let stiff = match meeting.stiffness_ratio {
            1.0 => String::new(),
            ratio => format!(", soft contacts {} times as stiff as the law says", short(ratio, 4)),
        };
        let _ = writeln!(
            text,
            "\"{}\" against {other}: {}{stiff}.",
            scene.species[usize::from(*species)].name,
            surface(&meeting.surface)
        );
    }
}

/// True if the scene has both gravity and friction, so that a particle may rest on a slope.
fn rests_by_friction(scene: &Scene) -> bool {
    let at_walls = scene.walls.iter().map(|wall| wall.surface.friction);
    let of_pairs = scene.pairs.iter().map(|(_, _, meeting)| meeting.surface.friction);
    let rough = at_walls.chain(of_pairs).chain([scene.contact.friction]).any(|friction| friction > 0.0);
    rough && scene.gravity != Vector3::zeros()
}

fn sizes_in_words(species: &Species) -> String {
    match &species.sizes {
        None => format!("diameter {}", length(species.diameter)),
        Some(sizes) => format!("{sizes}, mean volume that of {}", length(species.diameter)),
    }
}

fn gas_in_words(text: &mut String, scene: &Scene) {
    let Some(fluid) = &scene.fluid else {
        text.push_str("No gas.\n");
        return;
    };
    let drag = fluid.drag.as_ref().map_or_else(|| "no drag".into(), |drag| drag.law().title());
    let buoyancy = if fluid.buoyancy.is_some() { "; buoyancy" } else { "" };
    let height = scene.domain.size.y;
    let velocity = if fluid.coupling.is_some() { "velocity without particles" } else { "frozen velocity" };
    let _ = writeln!(
        text,
        "Gas: {} kg/m^3, kinematic viscosity {:e} m^2/s, {velocity} along z: {:.4} m/s on average, {:.4} m/s at y = {}; {drag}{buoyancy}.",
        fluid.density,
        fluid.kinematic_viscosity,
        bulk_velocity(fluid, height),
        fluid.profile.velocity(0.5 * height),
        length(0.5 * height)
    );
    if fluid.drag.is_some() {
        for species in &scene.species {
            let time = fluid.sphere(species).stokes_time;
            let _ = writeln!(text, "Stokes response time of \"{}\": {time:.4} s.", species.name);
        }
    }
    if let Some(turbulence) = &fluid.turbulence {
        turbulence_in_words(text, (scene, fluid), turbulence);
    }
}

/// Adds to `text` a description of the turbulence that particles see, and of the agitation (kinetic energy of velocity
/// fluctuations) that they are expected to get from it.
fn turbulence_in_words(text: &mut String, (scene, fluid): (&Scene, &Fluid), turbulence: &Turbulence) {
    let (profile, height) = (&fluid.profile, scene.domain.size.y);
    let mean = |of: fn(&LocalTurbulence) -> f64| -> f64 {
        turbulence.strips(profile, height).map(|(weight, local)| weight * of(&local)).sum()
    };
    let (k, eddies) = (1.5 * mean(|local| local.deviation * local.deviation), mean(|local| local.time));
    let Langevin { kolmogorov_constant, time_scale_ratio } = turbulence.langevin;
    let law = match turbulence.law {
        EddyLaw::Langevin => "a Langevin equation",
        EddyLaw::Eddy => "a discrete random walk through eddies",
    };
    let _ = writeln!(
        text,
        "Particles see turbulence by {law}, C_0 = {kolmogorov_constant}, T_L/T_E = {}: k = {k:.4} m^2/s^2 and T_L = {eddies:.4} s on average.",
        short(time_scale_ratio, 4)
    );
    let Some(drag) = &fluid.drag else { return };
    for species in &scene.species {
        let sphere = fluid.sphere(species);
        let slip = terminal_slip(drag, &sphere, scene.gravity_of(species).norm());
        let response = drag.law().response_time(&sphere, slip);
        let share = 1.5 * turbulence.induced_variance(profile, height, response, slip) / k;
        let _ = writeln!(
            text,
            "\"{}\": Stokes number {:.3} on T_L at the terminal slip; turbulence alone would give it {:.3} of the k of the gas.",
            species.name,
            response / eddies,
            share
        );
    }
}

/// Describes in words the settings of direct simulation Monte Carlo, in which pairs collide by chance.
fn dsmc_in_words(settings: &DsmcSettings) -> String {
    let cells = settings
        .cells
        .map_or("cells chosen from the mean free path".to_string(), |[x, y, z]| format!("{x} x {y} x {z} cells"));
    let factor = if settings.enskog { "with" } else { "without" };
    let step = settings.step;
    format!(
        "Model dsmc: pairs collide by chance in {cells}, {factor} the Enskog factor, in steps of at most {step} mean free times; \
         collisions carry momentum over no distance and do not conserve angular momentum."
    )
}

pub(crate) fn model_in_words(experiment: &Experiment) -> String {
    match experiment.model() {
        Model::Hybrid => {
            let times = experiment.hybrid.clearance;
            let law = experiment.law().map_or("no contact law".to_string(), |law| law.to_string());
            format!(
                "Model hybrid: an instant where two touch and no other particle comes within {times} contact times; elsewhere soft \
                 contacts, {law}, {}.",
                step_in_words(experiment)
            )
        }
        Model::Soft => {
            let soft = &experiment.soft;
            // these texts name the methods of the soft engine (engine/soft/local) for each choice
            let integrator = match (soft.integrator, soft.stepping) {
                (Integrator::Rk2, _) => "second-order Runge-Kutta",
                (Integrator::VelocityVerlet, SoftStepping::Uniform) => "velocity Verlet",
                (Integrator::VelocityVerlet, SoftStepping::Local) => {
                    "fourth-order Runge-Kutta, and velocity Verlet for all particles where too many touch"
                }
                (Integrator::VelocityVerlet, SoftStepping::Auto) => {
                    "velocity Verlet for all particles or fourth-order Runge-Kutta for those in contact"
                }
            };
            let stepping = match soft.stepping {
                SoftStepping::Uniform => "every particle at every step",
                SoftStepping::Local => "only particles in contact are stepped where few touch",
                SoftStepping::Auto => "whichever costs less",
            };
            let step = step_in_words(experiment);
            let law = soft.law.map_or("no contact law".to_string(), |law| law.to_string());
            format!("Model soft: {law}; {step}, {integrator}, {stepping}.")
        }
        Model::Dsmc => dsmc_in_words(&experiment.dsmc),
        Model::Hard => match experiment.hard.stepping {
            HardStepping::Events => match experiment.hard.contact_time {
                None => "Model hard: collisions at the exact instants of touch.".to_string(),
                Some(contact_time) => format!(
                    "Model hard: collisions at the exact instants of touch; elastic within {} of another (TC model).",
                    time(contact_time)
                ),
            },
            HardStepping::Steps { theta } => {
                format!("Model hard: collisions found as overlaps at the ends of steps, theta = {theta}.")
            }
        },
    }
}

fn step_in_words(experiment: &Experiment) -> String {
    match experiment.soft.time_step {
        TimeStep::PerContact(steps) => format!("{steps} time steps in the shortest contact"),
        TimeStep::Fixed(step) => format!("time steps of {step:.4e} s"),
    }
}

fn surface(surface: &Surface) -> String {
    let Surface { restitution, friction, by_speed } = surface;
    match by_speed {
        None => format!("restitution {restitution}, friction {friction}"),
        Some(law) => format!("restitution {law} ({restitution:.4} in a usual impact), friction {friction}"),
    }
}

/// Text of a length [m] in um, mm or m, depending on its size.
pub(crate) fn length(metres: f64) -> String {
    let (number, unit) = match metres.abs() {
        0.0 => (0.0, "m"),
        size if size < 1e-3 => (metres * 1e6, "um"),
        size if size < 1.0 => (metres * 1e3, "mm"),
        _ => (metres, "m"),
    };
    // six decimal places hide the rounding error of the product
    format!("{} {unit}", short(number, 6))
}

/// Text of a time [s] in us, ms or s, depending on its size.
fn time(seconds: f64) -> String {
    let (number, unit) = match seconds.abs() {
        0.0 => (0.0, "s"),
        size if size < 1e-3 => (seconds * 1e6, "us"),
        size if size < 1.0 => (seconds * 1e3, "ms"),
        _ => (seconds, "s"),
    };
    format!("{} {unit}", short(number, 6))
}

/// Text of a number with at most `places` decimal places, without zeros at its end. If rounding to these places would
/// change the number by more than 1 %, the text is in scientific notation instead, such as `1.235e-7`.
fn short(number: f64, places: usize) -> String {
    let text = format!("{number:.places$}");
    if text.parse().is_ok_and(|short: f64| (short - number).abs() > 0.01 * number.abs()) {
        return format!("{number:.3e}");
    }
    let text = text.trim_end_matches('0').trim_end_matches('.');
    if text == "-0" { "0".to_string() } else { text.to_string() }
}
