//! Observables by which two steady runs are compared: averages over time. Averages that are equal in all runs by
//! definition or by symmetry are left out. A variant is one of the experiments of a case.

use crate::experiment::Experiment;
use crate::fluid::Profile;
use crate::observe::SpeciesAverages;
use crate::outcome::Outcome;
use crate::scene::Scene;
use crate::statistics::{
    Batches, MEAN_SPIN_X, NUMBER_DENSITY, Observable, Parity, ProfileTable, ROTATIONAL_TEMPERATURE, SliceColumn, U, UU,
    UV, VV, WW,
};
use crate::walls::Wall;
use nalgebra::Vector3;
use std::borrow::Cow;

/// Smallest number of slices across the box with which profiles of the number density, the shear stress and the mean
/// spin are compared.
const SLICES: usize = 4;

/// Number of points in each half of the channel at which the gas profile is tested for mirror symmetry.
const POINTS: usize = 20;

/// Observables of a variant (experiment of a case) and of its reference, in the same order in both lists. A mixture
/// adds the granular temperature and the impact rate of each species. It also adds the streamwise velocity of each
/// species if gas, gravity or walls drive a stream.
///
/// The velocities V (normal to the walls) and W (spanwise) are left out, and so are the stresses uw and vw, the means
/// of products of two components of the fluctuation. V vanishes since mass is conserved; W, uw and vw vanish by
/// symmetry. Other averages are compared only under a condition. The streamwise velocity U needs gas, gravity along
/// the stream, or walls that move, since momentum is conserved otherwise. The number density needs walls or gravity.
/// The stress uv needs walls and a stream, or a sheared box. The rotational temperature T_r needs spheres that rotate
/// in both variants. The mean spin needs rotation, walls and a stream.
pub fn observables(variant: &Outcome, reference: &Outcome) -> [Vec<Observable>; 2] {
    let scene = &reference.experiment.scene;
    let walls = !scene.walls.is_empty();
    let driven = [variant, reference].iter().any(|one| is_driven(&one.experiment.scene));
    let mirrored = [variant, reference].iter().all(|one| is_mirrored(&one.experiment));
    let mut columns: Vec<SliceColumn> = Vec::new();
    let across = reference.profiles.slices.len() >= SLICES;
    columns.extend((across && (walls || scene.gravity.norm() > 0.0)).then_some(NUMBER_DENSITY));
    columns.extend(driven.then_some(U));
    columns.extend([UU, VV, WW]);
    columns.extend(((across && driven && walls) || scene.domain.shear.is_some()).then_some(UV));
    if [variant, reference].iter().all(|one| one.experiment.scene.rotation.is_some()) {
        columns.push(ROTATIONAL_TEMPERATURE);
        columns.extend((across && driven && walls).then_some(MEAN_SPIN_X));
    }
    let scales: Vec<Option<Scale>> = columns.iter().map(|column| scale(column, reference)).collect();
    let until = variant.profiles.until.min(reference.profiles.until);
    let of = |outcome: &Outcome| -> Vec<Observable> {
        let profile = |(column, scale): (&SliceColumn, &Option<Scale>)| {
            Some(profile(column, (*scale)?, mirrored, &outcome.profiles, until))
        };
        let profiles = columns.iter().zip(&scales).filter_map(profile);
        let kinds = if driven { 0..3 } else { 1..3 };
        let kinds = kinds.flat_map(|which| of_kinds(outcome, reference, until, which));
        profiles.chain(numbers(outcome, reference, until)).chain(kinds).collect()
    };
    [of(variant), of(reference)]
}

fn profile(
    column: &SliceColumn,
    (scale, scale_is): Scale,
    mirrored: bool,
    table: &ProfileTable,
    until: f64,
) -> Observable {
    let SliceColumn { name, unit, parity, .. } = *column;
    let part = |slice: usize| Some(table.batches(slice, *column)?.until(until));
    Observable {
        name: name.into(),
        unit,
        places: table.slices.iter().map(|row| row.y).collect(),
        parity: if mirrored { parity } else { Parity::Neither },
        fixed_mean: *column == NUMBER_DENSITY,
        scale,
        scale_is,
        parts: (0..table.slices.len()).map(part).collect(),
    }
}

/// Observables of `outcome` that are single numbers: granular temperature, impact rates and shear stress. Numbers that
/// `reference` lacks are left out. If the particles of `reference` are at rest, all numbers are left out. Times after
/// `until` [s] do not count.
fn numbers(outcome: &Outcome, reference: &Outcome, until: f64) -> Vec<Observable> {
    let of = |outcome: &Outcome| {
        let averaged = outcome.averaged.clone();
        [
            ("granular temperature", "m²/s²", averaged.temperature),
            ("pair impacts per time", "1/s", averaged.pair_rate),
            ("wall impacts per time", "1/s", averaged.wall_rate),
            ("shear stress yz", "Pa", averaged.shear_stress),
        ]
    };
    let both = of(outcome).into_iter().zip(of(reference));
    // with inlets or outlets the number of particles is a result too, and the number at the end is not the mean number
    let comes_and_goes = has_openings([outcome, reference]);
    let numbers = both.filter_map(|((name, unit, own), (_, _, other))| {
        // rates are scaled to the number of particles of the reference
        let counts = (unit == "1/s" && !comes_and_goes).then_some((reference.particles, outcome.particles));
        // particles at rest have no meaningful temperature or impact rates
        let rest = reference.experiment.scene.rest_speed().powi(2);
        reference.temperature.filter(|temperature| temperature.value > rest)?;
        let scale = (value(&other)?, "its value");
        Some(number(name.into(), unit, scale, of_as_many(own, counts).map(|batches| batches.until(until))))
    });
    numbers.collect()
}

/// Observables of each species of a mixture, chosen by `which`: 0 for the streamwise velocity, 1 for the granular
/// temperature, 2 for the rate of impacts with particles. Species that `reference` lacks are left out, and so are times
/// after `until` [s].
fn of_kinds(outcome: &Outcome, reference: &Outcome, until: f64, which: usize) -> Vec<Observable> {
    let (name, unit) = [("U", "m/s"), ("granular temperature", "m²/s²"), ("impacts per time", "1/s")][which];
    let of = |other: &SpeciesAverages| {
        let own = outcome.kinds.species.iter().find(|own| own.name == other.name)?;
        let scale = match which {
            0 => scale(&U, reference)?,
            _ => (value(&other.batches[which])?, "its value"),
        };
        let counts = (which == 2 && !has_openings([outcome, reference])).then_some((other.count, own.count));
        let batches = of_as_many(own.batches[which].clone(), counts).map(|batches| batches.until(until));
        Some(number(format!("{name} of {}", other.name).into(), unit, scale, batches))
    };
    reference.kinds.species.iter().filter_map(of).filter(|one| one.scale > 0.0).collect()
}

fn value(batches: &Option<Batches>) -> Option<f64> {
    batches.as_ref()?.values.first().copied().filter(|value| *value > 0.0)
}

/// Scales a sum over particles to another number of particles. `counts` has this number, then the number of particles
/// in the sum. Without `counts` the sum is unchanged.
fn of_as_many(batches: Option<Batches>, counts: Option<(usize, usize)>) -> Option<Batches> {
    match counts {
        Some((wanted, present)) if wanted != present => {
            batches.map(|batches| batches.project(&[vec![wanted as f64 / present.max(1) as f64]]))
        }
        _ => batches,
    }
}

pub(super) fn number(
    name: Cow<'static, str>,
    unit: &'static str,
    (scale, scale_is): Scale,
    part: Option<Batches>,
) -> Observable {
    let (places, parity, fixed_mean, parts) = (Vec::new(), Parity::Even, false, vec![part]);
    Observable { name, unit, places, parity, fixed_mean, scale, scale_is, parts }
}

/// Scale of an observable in its unit, by which differences are divided, and the description of this scale in a
/// sentence.
pub(super) type Scale = (f64, &'static str);

/// Scale by which the differences of a profile are divided, in the unit of the profile; `column` is one of the
/// averages over slices of the box. The scale is the mean for the density, a normal stress and the rotational
/// temperature, and the largest magnitude for the shear stress and the mean spin. For the streamwise velocity it is
/// the mean slip between gas and particles or, without gas, the mean velocity past walls. It is at least the agitation
/// √T (granular temperature T). None of these scales depends on the frame of reference. `None` without a measured
/// value, or if nothing moves.
pub(super) fn scale(column: &SliceColumn, reference: &Outcome) -> Option<Scale> {
    let table = &reference.profiles;
    let known: Vec<(f64, f64)> = (0..table.slices.len())
        .filter_map(|slice| Some((table.slices[slice].y, *table.batches(slice, *column)?.values.first()?)))
        .collect();
    let mean = |of: &dyn Fn(&(f64, f64)) -> f64| known.iter().map(of).sum::<f64>() / known.len().max(1) as f64;
    let scene = &reference.experiment.scene;
    let scale = match column.name {
        "number_density_ratio" => (1.0, "the mean density"),
        "U" => {
            let relative = match &scene.fluid {
                Some(fluid) => (mean(&|(y, u)| (fluid.profile.velocity(*y) - u).abs()), "the mean slip"),
                None if scene.walls.is_empty() => (0.0, ""),
                None => (mean(&|(_, u)| *u).abs(), "the mean velocity"),
            };
            let agitation = reference.temperature.map_or(0.0, |temperature| temperature.value.max(0.0)).sqrt();
            if relative.0 > agitation { relative } else { (agitation, "the agitation √T") }
        }
        "uv" | "mean_spin_x" => {
            (known.iter().fold(0.0, |most: f64, (_, value)| most.max(value.abs())), "its largest magnitude")
        }
        _ => (mean(&|(_, value)| *value), "its mean"),
    };
    // particles at rest have no velocities that could be compared
    let rest = match column.name {
        "number_density_ratio" => 0.0,
        "U" => scene.rest_speed(),
        "mean_spin_x" => 2.0 * scene.rest_speed() / scene.smallest_diameter(),
        _ => scene.rest_speed().powi(2),
    };
    (scale.0 > rest && !known.is_empty()).then_some(scale)
}

/// True if the scene of at least one of the two runs has openings through which particles come in or leave.
fn has_openings(runs: [&Outcome; 2]) -> bool {
    runs.iter().any(|run| run.experiment.scene.has_openings())
}

/// True if gas, gravity or walls that move may drive a stream along z.
fn is_driven(scene: &Scene) -> bool {
    scene.fluid.is_some() || scene.gravity.z != 0.0 || scene.walls.iter().any(Wall::surface_moves)
}

/// True if a mirror at the mid-plane y = L_y/2 of the box does not change the scene: its walls, gravity and gas.
fn is_mirrored(experiment: &Experiment) -> bool {
    let Scene { domain, gravity, fluid, walls, .. } = &experiment.scene;
    let height = domain.size.y;
    let mirror = |v: Vector3<f64>| Vector3::new(v.x, -v.y, v.z);
    let has_image = |wall: &Wall| {
        let Some(plane) = wall.geometry.plane() else { return false };
        let point = Vector3::new(plane.point.x, height - plane.point.y, plane.point.z);
        let is_like = |other: &&Wall| {
            other.surface == wall.surface
                && other.roughness == wall.roughness
                && other.thermal == wall.thermal
                && other.turning.is_none()
                && other.velocity == mirror(wall.velocity)
        };
        walls.iter().filter(is_like).filter_map(|other| other.geometry.plane()).any(|image| {
            let apart = (image.point - point).dot(&image.normal).abs();
            (image.normal - mirror(plane.normal)).norm() < 1e-9 && apart < 1e-9 * height
        })
    };
    let even = |profile: &Profile| {
        (0..POINTS).map(|k| (k as f64 + 0.5) / (2 * POINTS) as f64 * height).all(|y| {
            let (low, high) = (profile.velocity(y), profile.velocity(height - y));
            (low - high).abs() <= 1e-6 * low.abs().max(high.abs())
        })
    };
    let scene = &experiment.scene;
    let still = gravity.y == 0.0 && !scene.has_moving_walls() && !scene.has_openings();
    // the mirror image of a sheared box is sheared the other way
    let still = still && domain.shear.is_none();
    still && walls.iter().all(has_image) && fluid.as_ref().is_none_or(|fluid| even(&fluid.profile))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::case::Case;
    use std::path::Path;

    #[test]
    fn a_channel_is_its_own_mirror_image_unless_a_wall_or_gravity_tells_its_sides_apart() {
        let mirrored = |sets: &[&str]| {
            let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("cases/channel-d.toml");
            let sets: Vec<String> = sets.iter().map(|set| (*set).to_owned()).collect();
            is_mirrored(&Case::read(&path, &sets).unwrap().experiment(None, None).unwrap().0)
        };
        assert!(mirrored(&[]));
        assert!(!mirrored(&["walls[1].restitution=0.9"]), "walls that differ");
        assert!(!mirrored(&["gravity.acceleration[1]=-1 m/s^2"]), "gravity across the channel");
        assert!(!mirrored(&["walls[1].plane.point[1]=39 mm"]), "a wall that stands elsewhere");
        assert!(!mirrored(&[r#"walls[1].velocity=["0 m/s", "0 m/s", "1 m/s"]"#]), "a wall that slides");
        let sheared = Path::new(env!("CARGO_MANIFEST_DIR")).join("cases/shear/simple-shear.toml");
        assert!(!is_mirrored(&Case::read(&sheared, &[]).unwrap().experiment(None, None).unwrap().0));
    }
}
