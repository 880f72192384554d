//! All parameters of an experiment, with defaults and computed values, as JSON in SI.

use crate::contact_law::ContactLaw;
use crate::experiment::{Amount, AverageFrom, Experiment, HardStepping, Model, TimeStep};
use crate::fluid::{EddyLaw, Fluid, Profile};
use crate::rotation::ResistanceFriction;
use crate::scene::{Inlet, Kind, Meeting, Outlet, OutletShape, Scene, Surface};
use crate::walls::{Hollow, Wall};
use nalgebra::Vector3;
use serde_json::{Value, json};

/// Number of heights y at which the velocity of the gas is listed.
const PROFILE_POINTS: usize = 41;

/// All parameters of an experiment in SI units, under the names of the keys of a case.
pub fn parameters(experiment: &Experiment) -> Value {
    let scene = &experiment.scene;
    let mut domain = json!({ "size": three(&scene.domain.size), "periodic": scene.domain.periodic });
    if let Some(shear) = &scene.domain.shear {
        domain["shear"] = json!({ "rate": shear.rate, "offset": shear.start });
    }
    if let Some(orbit) = scene.domain.orbit() {
        domain["shear"]["orbit"] = json!({ "rate": orbit.rate, "vertical_frequency": orbit.vertical_frequency });
    }
    let mut value = json!({
        "domain": domain,
        "gravity": { "acceleration": three(&scene.gravity_alone()) },
        "fluid": scene.fluid.as_ref().map(|fluid| fluid_parameters(fluid, scene.domain.size.y)),
        "particles": particles(experiment),
        "walls": scene.walls.iter().map(wall).collect::<Vec<_>>(),
        "contact": contact(experiment),
        "soft": soft(experiment),
        "hard": hard(experiment),
        "run": {
            "model": experiment.model(),
            "duration": experiment.run.duration,
            "average_from": match experiment.run.average_from { AverageFrom::Time(t) => json!(t), AverageFrom::Steady => json!("steady") },
            "window": experiment.run.window.map_or(json!("auto"), |window| json!(window)),
            "seed": experiment.run.seed,
        },
        "statistics": {
            "slices": experiment.statistics.slices,
            "sample_interval": experiment.statistics.sample_interval,
        },
        "observe": experiment.observe,
    });
    match experiment.model() {
        Model::Hybrid => value["hybrid"] = json!(experiment.hybrid),
        Model::Dsmc => value["dsmc"] = json!(experiment.dsmc),
        Model::Soft | Model::Hard => {}
    }
    if !scene.outlets.is_empty() {
        value["outlets"] = scene.outlets.iter().map(outlet).collect();
    }
    if !scene.inlets.is_empty() {
        value["inlets"] = scene.inlets.iter().map(|one| inlet(one, scene)).collect();
    }
    if let Some(thermostat) = &scene.thermostat {
        value["thermostat"] = json!(thermostat);
    }
    value
}

fn outlet(outlet: &Outlet) -> Value {
    let (key, shape) = match &outlet.shape {
        OutletShape::Behind(plane) => {
            ("plane", json!({ "point": three(&plane.point), "normal": three(&plane.normal) }))
        }
        OutletShape::Body(body) => ("body", room(body)),
        OutletShape::Mesh(mesh) => ("mesh", json!(mesh.as_ref())),
    };
    json!({ "name": outlet.name, key: shape })
}

/// Shape of a hollow body (block or cylinder of an inlet or outlet) as JSON. The surfaces that bound the body are left
/// out, because they follow from its shape.
fn room(body: &Hollow) -> Value {
    json!(body)["room"].take()
}

/// Inlet as JSON, with the name of its species. The entry `end` of an inlet that stays open is null.
fn inlet(inlet: &Inlet, scene: &Scene) -> Value {
    let mut value = json!(inlet);
    value["region"] = room(&inlet.region);
    value["species"] = json!(scene.species.get(usize::from(inlet.species)).map(|species| &species.name));
    value
}

/// Settings of the soft engine as JSON. The contact law is a table within them, as in a case.
fn soft(experiment: &Experiment) -> Value {
    let soft = &experiment.soft;
    let mut value = json!({
        "steps_per_contact": match soft.time_step { TimeStep::PerContact(n) => Some(n), TimeStep::Fixed(_) => None },
        "time_step": match soft.time_step { TimeStep::Fixed(dt) => Some(dt), TimeStep::PerContact(_) => None },
        "stepping": soft.stepping,
        "integrator": soft.integrator,
        "allow_unstable": soft.allow_unstable,
    });
    if let Some(rotation) = &experiment.scene.rotation {
        value["tangential"] = json!(rotation.tangential);
        if let Some(rolling) = rotation.rolling {
            value["rolling"] = json!(rolling);
        }
        if let Some(twisting) = rotation.twisting {
            value["twisting"] = json!(twisting);
        }
    }
    if let Some(law) = &soft.law {
        let values = law.parameters();
        let table = values.iter().map(|parameter| (parameter.key.to_owned(), json!(parameter.value)));
        value[law.parameter().law] = table.collect();
    }
    value
}

/// Settings of the hard engine as JSON. They include the impact rule if spheres rotate.
fn hard(experiment: &Experiment) -> Value {
    let mut value = match experiment.hard.stepping {
        HardStepping::Events => json!({ "stepping": "events", "contact_time": experiment.hard.contact_time }),
        HardStepping::Steps { theta } => json!({ "stepping": "steps", "theta": theta }),
    };
    if let Some(rotation) = &experiment.scene.rotation {
        value["friction"] = json!(rotation.impact);
    }
    value
}

fn three(vector: &Vector3<f64>) -> [f64; 3] {
    [vector.x, vector.y, vector.z]
}

fn surface(surface: &Surface) -> Value {
    let mut value = json!({ "restitution": surface.restitution, "friction": surface.friction });
    if let Some(law) = &surface.by_speed {
        value["restitution_by_speed"] = json!(law);
    }
    value
}

/// Adds to `value` the coefficients of rolling and twisting friction that a wall or a pair has in place of those of
/// all contacts.
fn add_resistance(value: &mut Value, own: &ResistanceFriction) {
    for (key, friction) in [("rolling_friction", own.rolling), ("twisting_friction", own.twisting)] {
        if let Some(friction) = friction {
            value[key] = json!(friction);
        }
    }
}

/// Contact properties of particles as JSON: those common to all particles, and those of the pairs that differ. A wall
/// is given by its index in the case.
fn contact(experiment: &Experiment) -> Value {
    let scene = &experiment.scene;
    let mut value = surface(&scene.contact);
    value["rotation"] = json!(scene.rotation.is_some());
    let pair = |(species, other, meeting): &(u16, Kind, Meeting)| {
        let mut value = surface(&meeting.surface);
        let other = match other {
            Kind::Species(other) => json!(scene.species[usize::from(*other)].name),
            Kind::Wall(wall) => json!({ "wall": wall }),
        };
        add_resistance(&mut value, &meeting.resistance);
        value["between"] = json!([scene.species[usize::from(*species)].name, other]);
        if let Some(ContactLaw::LinearSpringDashpot(law)) = &experiment.soft.law {
            value["stiffness"] = json!(law.stiffness * meeting.stiffness_ratio);
        }
        value
    };
    if !scene.pairs.is_empty() {
        value["pairs"] = scene.pairs.iter().map(pair).collect();
    }
    value
}

fn wall(wall: &Wall) -> Value {
    let mut value = surface(&wall.surface);
    add_resistance(&mut value, &wall.resistance);
    if let Some(turning) = &wall.turning {
        value["rotation"] = json!({ "center": three(&turning.center), "spin": three(&turning.spin) });
    }
    if let Some(moving) = &wall.moving {
        value["motion"] = json!(moving.motion());
    }
    if let Some(roughness) = &wall.roughness {
        value["roughness"] = json!({ "deviation": roughness.deviation });
    }
    if let Some(thermal) = &wall.thermal {
        value["temperature"] = thermal.temperature.into();
    }
    match wall.geometry.plane() {
        Some(plane) => value["plane"] = json!({ "point": three(&plane.point), "normal": three(&plane.normal) }),
        None => value["obstacle"] = json!(format!("{:?}", wall.geometry.law())),
    }
    value
}

fn fluid_parameters(fluid: &Fluid, height: f64) -> Value {
    let profile: Vec<[f64; 2]> = (0..PROFILE_POINTS)
        .map(|point| height * point as f64 / (PROFILE_POINTS - 1) as f64)
        .map(|y| [y, fluid.profile.velocity(y)])
        .collect();
    let mut value = json!({
        "density": fluid.density,
        "kinematic_viscosity": fluid.kinematic_viscosity,
        "bulk_velocity": bulk_velocity(fluid, height),
        "profile_y_U": profile,
        "drag": fluid.drag,
    });
    if fluid.buoyancy.is_some() {
        value["buoyancy"] = json!(true);
    }
    if let Some(lift) = &fluid.lift {
        value["lift"] = json!(lift);
    }
    if let Some(coupling) = &fluid.coupling {
        value["coupling"] = json!(coupling);
    }
    if let Some(turbulence) = &fluid.turbulence {
        value["turbulence"] = match turbulence.law {
            EddyLaw::Langevin => json!({ "langevin": turbulence.langevin }),
            EddyLaw::Eddy => json!({ "eddy": turbulence.langevin }),
        };
    }
    value
}

/// [m/s] mean gas velocity over 0 ≤ y ≤ `height` [m], by the midpoint rule on 2000 strips. For a pipe it is the mean
/// over its cross-section.
pub(super) fn bulk_velocity(fluid: &Fluid, height: f64) -> f64 {
    const STRIPS: usize = 2000;
    if let (Profile::Pipe(_), Some(bulk)) = (&fluid.profile, fluid.profile.bulk_velocity()) {
        return bulk;
    }
    let strip = height / STRIPS as f64;
    (0..STRIPS).map(|i| fluid.profile.velocity((i as f64 + 0.5) * strip)).sum::<f64>() / STRIPS as f64
}

/// [-] volume of all particles at the start, divided by the volume of the box.
pub(super) fn volume_fraction(experiment: &Experiment, scene: &Scene) -> f64 {
    let volumes = experiment.start.iter().filter_map(|population| {
        let species = scene.species.get(usize::from(population.species))?;
        Some(population.amount.count() as f64 * species.volume())
    });
    volumes.sum::<f64>() / scene.domain.volume()
}

fn particles(experiment: &Experiment) -> Vec<Value> {
    let scene = &experiment.scene;
    experiment
        .start
        .iter()
        .filter_map(|population| {
            let species = scene.species.get(usize::from(population.species))?;
            let count = population.amount.count();
            Some(json!({
                "name": species.name,
                "diameter": species.diameter,
                "sizes": species.sizes,
                "density": species.density,
                "added_density": species.added_density,
                "mass": species.mass(),
                "count": count,
                "volume_fraction": count as f64 * species.volume() / scene.domain.volume(),
                "start": match population.amount { Amount::Count(_) => "random", Amount::Placed(_) => "placed" },
                "velocity_mean": three(&population.velocity_mean),
                "velocity_fluctuation": three(&population.velocity_fluctuation),
                "inertia_factor": species.inertia_factor,
                "spin_mean": three(&population.spin_mean),
                "spin_fluctuation": population.spin_fluctuation,
                "stokes_time": scene.fluid.as_ref().map(|fluid| fluid.sphere(species).stokes_time),
            }))
        })
        .collect()
}
