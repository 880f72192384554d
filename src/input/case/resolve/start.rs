//! Initial particles of a case: their species, number, positions and velocities.

use super::overlap::Rule;
use super::{Resolver, short, vector};
use crate::case::diagnostic::Diagnostic;
use crate::case::file::{CaseFile, HardSteppingFile, ParticlesFile};
use crate::case::fluctuation::FluctuationFile;
use crate::case::located::Located;
use crate::case::source::Origin;
use crate::experiment::{Amount, Population};
use crate::particles::Particles;
use crate::placement::push_placed_apart;
use crate::scene::{Outlet, OutletShape, Scene, Species, StartRegion};
use nalgebra::Vector3;

/// [-] volume fraction of the densest random packing of equal spheres.
const RANDOM_PACKING: f64 = 0.64;
/// [-] volume fraction of the densest packing of equal spheres: π/sqrt(18).
const DENSEST_PACKING: f64 = 0.7405;
/// Largest number of particles; more particles would need more memory than a desktop computer has.
const MOST_PARTICLES: i64 = 50_000_000;
/// Largest number of species. The half a million pairs of 1000 species take about 100 MB and a second to check. Ten
/// times as many species would take 10 GB.
const MOST_KINDS: usize = 1000;
/// [byte] memory per particle, rounded up. It was measured as the growth of the peak memory of the process from 1e5 to
/// 4e5 particles in gas (265 bytes with hard, 296 with soft spheres).
const BYTES: f64 = 300.0;
/// [m/s] largest allowed component of a velocity; particles in a gas are slower.
pub(super) const FASTEST: f64 = 1e5;

/// True if spheres of the scene may differ in size.
fn has_unequal_spheres(scene: &Scene) -> bool {
    let smallest = scene.species.iter().map(Species::smallest).fold(f64::INFINITY, f64::min);
    scene.species.iter().any(|species| species.largest() > smallest)
}

/// Text for messages: a number of particles, the memory that these particles require, and the allowed number.
fn too_many(count: f64) -> String {
    let gigabytes = count * BYTES / 1e9;
    format!("{count:.3e} particles, which take about {gigabytes:.3e} GB of memory; allowed: up to {MOST_PARTICLES}")
}

/// [m³] volume of which a volume fraction is a share: that of the start region if it is a block or a cylinder, else of
/// the whole box.
fn share_of(region: &Option<StartRegion>, scene: &Scene) -> f64 {
    match region {
        Some(StartRegion::Body(body)) => body.volume(&scene.domain.size),
        Some(StartRegion::InsideWalls(_)) | None => scene.domain.volume(),
    }
}

/// Particle with a given initial position.
pub(super) struct Placed {
    /// [m] position of the centre, inside the box along periodic axes.
    pub position: Vector3<f64>,
    /// [m] radius of the particle.
    pub radius: f64,
    /// True if the particle comes, unchanged, from a state saved by a run.
    pub saved: bool,
    /// True if the particle comes from a file of another program.
    pub foreign: bool,
    /// Name of the particle in messages.
    pub label: String,
    /// Source position of the particle in the case or in a file.
    pub origin: Origin,
}

impl Resolver {
    /// Species of the particles, in the order of the case.
    pub(super) fn species(&mut self, file: &CaseFile) -> Result<Vec<Species>, Diagnostic> {
        let mut species: Vec<Species> = Vec::new();
        self.check_kinds(file)?;
        for (index, kind) in file.particles.iter().flatten().enumerate() {
            let (d, sizes) = self.diameter(kind)?;
            let density = self.need(&kind.value.density, "particles.density")?;
            let rho = density.value.0;
            let grams = format!("did you mean \"{} g/cm^3\", which is {} kg/m^3?", short(rho), short(rho * 1000.0));
            self.in_range(density, if rho > 0.0 { &grams } else { "a sphere has a positive density" })?;
            if rho < 50.0 {
                let message = format!("{} is light for a particle", self.as_typed(density));
                self.warn(&density.origin, message, grams);
            }
            let name = kind.value.name.as_ref().map_or(format!("particles {index}"), |name| name.value.clone());
            if let Some(typed) = kind.value.name.as_ref().filter(|typed| typed.value.trim() != typed.value) {
                let trimmed = toml::Value::from(name.trim());
                let help = format!("write name = {trimmed}; rows of files name kinds without these blanks");
                return Err(self.refuse(typed, "begins or ends with a blank").help(help));
            }
            if species.iter().any(|other| other.name == name) {
                let message = format!("two kinds of particles are called \"{name}\"");
                let origin = kind.value.name.as_ref().map_or(&kind.origin, |name| &name.origin);
                return Err(self.sources.error(origin, message).help("give each [[particles]] its own `name`"));
            }
            let elasticity = self.own_elasticity(file, &kind.value.elasticity)?;
            let inertia_factor = self.inertia_factor(kind)?;
            species.push(Species { elasticity, sizes, inertia_factor, ..Species::new(name, d, rho) });
        }
        Ok(species)
    }

    /// Refuses too many species, because memory grows with the number of their pairs.
    fn check_kinds(&self, file: &CaseFile) -> Result<(), Diagnostic> {
        let Some(kinds) = file.particles.as_ref().filter(|kinds| kinds.len() > MOST_KINDS) else { return Ok(()) };
        let (count, pairs) = (kinds.len(), kinds.len() * (kinds.len() + 1) / 2);
        let message =
            format!("{count} kinds of particles make {pairs} pairs of kinds; allowed: up to {MOST_KINDS} kinds");
        let help = "spheres that differ in their size alone are one kind with `sizes`";
        Err(self.sources.error(&kinds[MOST_KINDS].origin, message).help(help))
    }

    /// Initial particles of every species, in the order of the case.
    pub(super) fn start(&mut self, file: &CaseFile, scene: &Scene) -> Result<Vec<Population>, Diagnostic> {
        self.check_room(file, scene)?;
        let mut start = Vec::new();
        let mut all_placed: Vec<Placed> = Vec::new();
        for (index, kind) in file.particles.iter().flatten().enumerate() {
            let species = &scene.species[index];
            let mut particles = Particles { spin: scene.rotation.as_ref().map(|_| Vec::new()), ..Particles::default() };
            let kinds = file.particles.as_deref().unwrap_or_default();
            let placed = self.placed((kinds, index), scene, &mut particles)?;
            let (velocity_mean, velocity_fluctuation) = self.random_velocity(&kind.value, placed.is_some())?;
            let region = self.region(kind, file, scene)?;
            let amount = match placed {
                Some(placed) => {
                    all_placed.extend(placed);
                    Amount::Placed(particles)
                }
                None => Amount::Count(self.count(kind, species, share_of(&region, scene))?),
            };
            let (spin_mean, spin_fluctuation) =
                self.random_spin(&kind.value, scene, matches!(amount, Amount::Placed(_)))?;
            let species = index as u16;
            start.push(Population {
                species,
                amount,
                region,
                velocity_mean,
                velocity_fluctuation,
                spin_mean,
                spin_fluctuation,
            });
        }
        self.check_packing(file, scene, &start)?;
        let stepping = file.hard.as_ref().and_then(|hard| hard.value.stepping.as_ref());
        let stepped = stepping.is_some_and(|stepping| stepping.value == HardSteppingFile::Steps);
        let relax = file.run.as_ref().and_then(|run| run.value.relax.as_ref()).filter(|relax| relax.value);
        let rule = match relax {
            Some(_) => Rule::PushedApart,
            None if stepped => Rule::Steps,
            None => Rule::Events,
        };
        let overlaps = self.check_placed(&all_placed, scene, rule)?;
        if let (Some(relax), true) = (relax, overlaps > 0) {
            self.push_apart(relax, scene, &mut start, &mut all_placed)?;
            self.check_placed(&all_placed, scene, Rule::Events)?;
        }
        self.warn_of_open_sides(file, scene, &start);
        Ok(start)
    }

    /// Moves overlapping particles with given positions apart, and reports the largest displacement.
    fn push_apart(
        &mut self,
        relax: &Located<bool>,
        scene: &Scene,
        start: &mut [Population],
        placed: &mut [Placed],
    ) -> Result<(), Diagnostic> {
        let mut all = Particles::default();
        let mut populations: Vec<&mut Particles> = Vec::new();
        for population in start {
            if let Amount::Placed(particles) = &mut population.amount {
                all.append(particles);
                populations.push(particles);
            }
        }
        let moved = push_placed_apart(&mut all, scene).map_err(|left| {
            let message = format!("the placed particles could not be pushed apart: {left} overlaps are left");
            let help = "there is no room for all of them: make the box larger, or run them soft without `relax`";
            self.sources.error(&relax.origin, message).help(help)
        })?;
        let mut places = all.position.iter();
        for position in populations.into_iter().flat_map(|particles| &mut particles.position) {
            *position = places.next().copied().unwrap_or(*position);
        }
        for (placed, position) in placed.iter_mut().zip(&all.position) {
            placed.position = *position;
        }
        let (farthest, of) = (moved.farthest, &placed[moved.id as usize]);
        let message = format!(
            "placed particles were pushed apart: {} moved the farthest, by {farthest:.3e} m, {:.3e} of its diameter",
            of.label,
            farthest / (2.0 * of.radius)
        );
        self.warn(&relax.origin, message, "every model starts from these places");
        Ok(())
    }

    /// Warns about sides of the box that are neither periodic nor walls. Particles with random positions would leave
    /// the box through such sides.
    fn warn_of_open_sides(&mut self, file: &CaseFile, scene: &Scene, start: &[Population]) {
        if !start.iter().any(|population| matches!(population.amount, Amount::Count(count) if count > 0)) {
            return;
        }
        let walled = |axis: usize, sign: f64| {
            scene.walls.iter().any(|wall| wall.geometry.plane().is_some_and(|plane| sign * plane.normal[axis] > 0.1))
        };
        let lets_out = |axis: usize, sign: f64| {
            let behind = |outlet: &Outlet| match &outlet.shape {
                OutletShape::Behind(plane) => sign * plane.normal[axis] > 0.1,
                OutletShape::Body(_) | OutletShape::Mesh(_) => false,
            };
            scene.outlets.iter().any(behind)
        };
        let walled = |axis: usize, sign: f64| walled(axis, sign) || lets_out(axis, sign);
        let held = |axis: usize| scene.walls.iter().any(|wall| wall.geometry.law().holds_along(axis));
        let walled = |axis: usize| held(axis) || walled(axis, 1.0) && walled(axis, -1.0);
        let open: Vec<&str> = (0..3)
            .filter(|axis| !(scene.domain.periodic[*axis] || walled(*axis)))
            .map(|axis| ["x", "y", "z"][axis])
            .collect();
        if let (false, Some(domain)) = (open.is_empty(), &file.domain) {
            let message =
                format!("the box is open along {}: a run stops when a particle leaves it", open.join(" and "));
            self.warn(&domain.origin, message, "add [[walls]] at both sides, or name the axis in `domain.periodic`");
        }
    }

    /// Checks that no particle can touch its own periodic image, and that particles fit between sides that are not
    /// periodic.
    fn check_room(&self, file: &CaseFile, scene: &Scene) -> Result<(), Diagnostic> {
        let largest = scene.largest_diameter();
        let Some(size) = file.domain.as_ref().and_then(|domain| domain.value.size.as_ref()) else { return Ok(()) };
        for (axis, edge) in size.value.iter().enumerate() {
            let (least, why) = if scene.domain.periodic[axis] {
                (2.0 * largest, "twice the largest diameter: a particle would meet its own periodic image")
            } else {
                (largest, "the largest diameter")
            };
            if edge.value.0 < least {
                let what = format!("is out of range; allowed: at least {least:e} m, {why}");
                return Err(self.refuse(edge, what).help("make the box larger or the particles smaller"));
            }
        }
        Ok(())
    }

    /// Number of particles of a species that start at random positions in a `volume` [m³].
    fn count(&self, kind: &Located<ParticlesFile>, species: &Species, volume: f64) -> Result<usize, Diagnostic> {
        if let Some(count) = &kind.value.count {
            if count.value > MOST_PARTICLES {
                let what = format!("means {}", too_many(count.value as f64));
                return Err(self.refuse(count, what).help("ask for fewer particles"));
            }
            return self.whole(count, 0, MOST_PARTICLES, "a count is a whole number of particles");
        }
        let fraction = self.need(&kind.value.volume_fraction, "particles.volume_fraction")?;
        let help = "the share of the whole box that this kind fills; spheres at random places pack no denser than 0.64";
        let phi = self.in_range(fraction, help)?;
        // a volume fraction that was computed from a whole number of particles must yield that number again
        let count = (phi * volume / species.volume() * (1.0 + 1e-12)).floor();
        if count > MOST_PARTICLES as f64 {
            let what = format!("means {}", too_many(count));
            return Err(self.refuse(fraction, what).help("make the box smaller or the particles larger"));
        }
        Ok(count as usize)
    }

    /// Mean and standard deviation of the initial velocity [m/s] of a species with random positions. If `placed` is
    /// true, velocities come with the positions, and a typed mean or deviation causes a warning.
    fn random_velocity(
        &mut self,
        kind: &ParticlesFile,
        placed: bool,
    ) -> Result<(Vector3<f64>, Vector3<f64>), Diagnostic> {
        let mut mean = Vector3::zeros();
        if let Some(typed) = &kind.velocity_mean {
            for component in &typed.value {
                self.in_range(component, "a particle's mean velocity")?;
            }
            mean = vector(typed);
            if placed {
                let message = format!("`{}` is not used: velocities come with the places", typed.path);
                self.warn(&typed.origin, message, "leave it out");
            }
        }
        let Some(typed) = &kind.velocity_fluctuation else { return Ok((mean, Vector3::zeros())) };
        let help = "the standard deviation of each velocity component, or a list of those along x, y and z";
        let fluctuation = match &typed.value {
            FluctuationFile::Same(speed) => {
                let Located { origin, path, .. } = typed;
                let speed = Located { value: *speed, origin: origin.clone(), path: path.clone() };
                Vector3::repeat(self.in_range(&speed, help)?)
            }
            FluctuationFile::Each(three) => {
                let [x, y, z] = three.each_ref().map(|speed| self.in_range(speed, help));
                Vector3::new(x?, y?, z?)
            }
        };
        if placed {
            let message = format!("`{}` is not used: velocities come with the places", typed.path);
            self.warn(&typed.origin, message, "leave it out");
        }
        Ok((mean, fluctuation))
    }

    /// Particles with given positions of the species with the given `index`; `None` if the case gives no positions. The
    /// particles are also added to `particles`.
    fn placed(
        &mut self,
        (kinds, index): (&[Located<ParticlesFile>], usize),
        scene: &Scene,
        particles: &mut Particles,
    ) -> Result<Option<Vec<Placed>>, Diagnostic> {
        let kind = &kinds[index];
        if let Some(name) = &kind.value.file {
            return self.placed_in_file(name, (kinds, index), scene, particles).map(Some);
        }
        let Some(list) = &kind.value.at else { return Ok(None) };
        let species = &scene.species[index];
        let mut placed = Vec::new();
        for (number, item) in list.value.iter().enumerate() {
            let diameter = self.own_diameter(item, species)?;
            let (radius, mass) = (0.5 * diameter, species.of_one_size(diameter).mass());
            let position = scene.domain.wrap(&vector(self.need(&item.value.position, "position")?));
            for component in item.value.velocity.iter().flat_map(|velocity| &velocity.value) {
                self.in_range(component, "a particle's velocity")?;
            }
            let velocity = item.value.velocity.as_ref().map_or_else(Vector3::zeros, vector);
            particles.push(position, velocity, radius, mass, index as u16);
            let spin = self.spin(item.value.spin.as_ref(), scene)?;
            if let Some(own) = particles.spin.as_mut().and_then(|spins| spins.last_mut()) {
                *own = spin;
            }
            let label = format!("particle {number} of \"{}\"", species.name);
            placed.push(Placed { position, radius, saved: false, foreign: false, label, origin: item.origin.clone() });
        }
        Ok(Some(placed))
    }

    /// Refuses an initial state that is denser than any packing of equal spheres, or than any random packing of equal
    /// spheres if it has random positions. Also refuses too many particles. Warns if a state with random positions
    /// fills more than 0.62 of the volume.
    fn check_packing(&mut self, file: &CaseFile, scene: &Scene, start: &[Population]) -> Result<(), Diagnostic> {
        let mut total = 0.0;
        let mut random = 0.0;
        let mut number = 0usize;
        for population in start {
            let species = &scene.species[usize::from(population.species)];
            let count = population.amount.count();
            number = number.saturating_add(count);
            total += match (&population.amount, &species.sizes) {
                (Amount::Placed(placed), Some(_)) => {
                    placed.radius.iter().map(|r| species.of_one_size(2.0 * r).volume()).sum()
                }
                _ => count as f64 * species.volume(),
            };
            if matches!(population.amount, Amount::Count(_)) {
                random += count as f64 * species.volume();
            }
        }
        let phi = total / scene.room();
        let (limit, help) = match random > 0.0 {
            true => (RANDOM_PACKING, "spheres at random places pack no denser than 0.64"),
            false if has_unequal_spheres(scene) => (1.0, "particles fill no more than the whole room"),
            false => (DENSEST_PACKING, "spheres of one size pack no denser than 0.7405"),
        };
        let Some(first) = file.particles.as_ref().and_then(|kinds| kinds.first()) else { return Ok(()) };
        let kind = &first.value;
        let origin = kind.count.as_ref().map(|count| &count.origin).unwrap_or(&first.origin);
        if phi > limit {
            let message =
                format!("{number} particles fill {phi:.4} of the room that they have; allowed: up to {limit}");
            return Err(self.sources.error(origin, message).help(help));
        }
        if number as i64 > MOST_PARTICLES {
            let message = format!("the case means {}", too_many(number as f64));
            return Err(self.sources.error(origin, message).help("make the box smaller"));
        }
        if random > 0.0 && phi > 0.62 {
            let message =
                format!("the particles fill {phi:.3} of the room that they have: placing them at random may fail");
            self.warn(origin, message, "start from a file of positions instead");
        }
        Ok(())
    }
}
