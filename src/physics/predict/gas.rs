//! Kinetic theory of the particles, treated as a dense gas of hard spheres.
//!
//! Enskog's theory of hard spheres is exact in the dilute limit, and accurate to about 1 % up to a volume fraction of
//! 0.45. The theory is valid for many particles with nearly Maxwellian and uncorrelated velocities. It is not valid for
//! a bed, a row or a few bodies.

use crate::contact_law::{Bodies, ContactLaw};
use crate::kinetic_theory::contact_value;
use crate::scene::{Scene, Species, Surface};
use serde::Serialize;
use std::f64::consts::PI;

/// [-] volume fraction of freezing, above which spheres form an ordered state (Hoover and Ree 1968, J. Chem. Phys. 49,
/// 3609). The formula for the contact value is valid up to this volume fraction.
pub const FREEZING: f64 = 0.494;

/// Predictions of kinetic theory for all particles. Rates per particle are means over all species.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Gas {
    /// [-] volume fraction of the particles in the whole box.
    pub volume_fraction: f64,
    /// [-] contact value of the pair distribution: number density of the centres of other particles that touch a
    /// particle, over the mean number density. With several species it is a mean over all pairs of species, weighted
    /// by their collision rates.
    pub contact_value: f64,
    /// [1/s] number of collisions between all particles per time.
    pub pair_rate: f64,
    /// [1/s] number of impacts of all particles on all walls per time.
    pub wall_rate: f64,
    /// [1/s] number of collisions per particle and time with other particles.
    pub collision_rate: f64,
    /// [m] mean free path of a particle between collisions with other particles.
    pub mean_free_path: f64,
}

/// Component of the gas: all particles of a species or, if the sizes within the species differ, those of nearly one
/// size.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Component {
    /// Number of particles of this component of the gas.
    pub count: usize,
    /// [m] diameter of the particles of this component.
    pub diameter: f64,
    /// [m²/s²] granular temperature T of these particles: variance of their velocity along one axis.
    pub variance: f64,
}

impl Component {
    /// Makes the components of `count` particles of a species. `variance` [m²/s²] is the variance of their velocity
    /// along one axis. If the sizes differ, up to sixteen components are made, with about the same number of
    /// particles. The particles of each component have the median diameter of a sixteenth of the size distribution.
    pub fn of(species: &Species, count: usize, variance: f64) -> Vec<Self> {
        const PARTS: usize = 16;
        let Some(sizes) = &species.sizes else { return vec![Self { count, diameter: species.diameter, variance }] };
        let of = |part: usize| Self {
            count: count * (part + 1) / PARTS - count * part / PARTS,
            diameter: sizes.quantile((part as f64 + 0.5) / PARTS as f64),
            variance,
        };
        (0..PARTS).map(of).filter(|component| component.count > 0).collect()
    }
}

/// Measurements in a slice of the scene. A slice is the space between two planes parallel to a wall.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Slice {
    /// [-] fraction of all particles whose centres are in the slice.
    pub particles: f64,
    /// [-] volume of the slice that is available to centres of particles, over the available volume of the whole
    /// scene.
    pub room: f64,
    /// [m²/s²] variances of the velocity components along x, y and z of the particles in the slice.
    pub variance: [f64; 3],
}

/// Effect on collisions of an agitation that depends on position and direction, relative to a uniform gas with the same
/// mean agitation. All numbers are ratios [-]; s is the standard deviation of the normal relative velocity.
#[derive(Clone, Debug, PartialEq)]
pub struct AgitationSpread {
    /// Rate of pair collisions over that of a uniform gas with the same mean agitation.
    pub pair_rate: f64,
    /// Rate of wall impacts over that of a uniform gas with the same mean agitation, for walls perpendicular to y.
    pub wall_rate: f64,
    /// Groups of pair collisions, each with a standard deviation s of the normal relative velocity. The two numbers of
    /// a group are its share of all pair collisions, and its s over that of the uniform gas.
    pub pairs: Vec<[f64; 2]>,
    /// Groups of wall impacts, each with a standard deviation s of the normal relative velocity. The two numbers of a
    /// group are its share of all wall impacts, and its s over that of the uniform gas.
    pub walls: Vec<[f64; 2]>,
}

impl AgitationSpread {
    /// Makes the ratios to a uniform gas for an agitation that is the same everywhere and in all directions; all are
    /// 1.
    pub fn even() -> Self {
        Self { pair_rate: 1.0, wall_rate: 1.0, pairs: vec![[1.0, 1.0]], walls: vec![[1.0, 1.0]] }
    }

    /// Computes the ratios to a uniform gas from measurements in slices along y, of which the first and the last are
    /// at walls. Velocities are taken as Gaussian, with independent components that have the variances of the slice.
    /// Collisions with the normal n then occur at a rate proportional to s(n) = sqrt(Σ n_i² σ_i²), with the variances
    /// σ_i² along the three axes.
    pub fn of(slices: &[Slice]) -> Self {
        /// Number of values of each of two angles in the quadrature over directions. The integrand is smooth.
        const ANGLES: usize = 12;
        let slices: Vec<&Slice> = slices.iter().filter(|slice| slice.particles > 0.0 && slice.room > 0.0).collect();
        let mean = slices.iter().map(|slice| slice.particles * slice.variance.iter().sum::<f64>() / 3.0).sum::<f64>();
        let (Some(first), Some(last), true) = (slices.first(), slices.last(), mean > 0.0) else { return Self::even() };
        let angle = |k: usize| (k as f64 + 0.5) / ANGLES as f64;
        let mut pairs = Vec::new();
        for slice in &slices {
            let weight = slice.particles * slice.particles / slice.room / (ANGLES * ANGLES) as f64;
            for (i, j) in (0..ANGLES * ANGLES).map(|k| (k / ANGLES, k % ANGLES)) {
                // directions at the centres of equal areas on an octant of the unit sphere, given by the cosine to z
                // and the angle around z
                let (cosine, (sine, other)) = (angle(i), (0.5 * PI * angle(j)).sin_cos());
                let across = 1.0 - cosine * cosine;
                let [x, y, z] = slice.variance;
                let s = ((across * (other * other * x + sine * sine * y) + cosine * cosine * z) / mean).sqrt();
                pairs.push([weight * s, s]);
            }
        }
        let wall = |slice: &Slice| {
            let s = (slice.variance[1] / mean).sqrt();
            [0.5 * slice.particles / slice.room * s, s]
        };
        let mut walls = vec![wall(first), wall(last)];
        let (pair_rate, wall_rate) = (normalise(&mut pairs), normalise(&mut walls));
        Self { pair_rate, wall_rate, pairs, walls }
    }
}

/// In a list of pairs [weight, number], divides the weights by their sum. Returns this sum.
fn normalise(parts: &mut [[f64; 2]]) -> f64 {
    let sum: f64 = parts.iter().map(|[weight, _]| weight).sum();
    parts.iter_mut().for_each(|[weight, _]| *weight /= sum);
    sum
}

/// Predicts collision rates and mean free path by kinetic theory, for the given components in the box of the scene.
///
/// The rate of pair collisions per volume is n_i n_j σ² g sqrt(8π (T_i + T_j)) for different components i and j. Here n
/// is the number density, σ the collision distance, g the contact value and T the granular temperature. The rate within
/// one component of N particles is half of this expression times 1 - 1/N. Flat walls keep centres half a diameter away.
/// Within a distance σ of a wall, a quarter of the collision directions is impossible on average. The density is
/// otherwise taken as uniform, unless `spread` was measured. The rate of wall impacts per area is n Z sqrt(T/2π), with
/// Z = 1 + 4 φ g and the volume fraction φ (the contact theorem).
pub fn gas(scene: &Scene, components: &[Component], spread: &AgitationSpread) -> Gas {
    let volume = scene.domain.volume();
    let total: f64 = components.iter().map(|c| c.count as f64).sum();
    let sphere = |c: &Component| c.count as f64 * PI / 6.0 * c.diameter.powi(3);
    let volume_fraction = components.iter().map(sphere).sum::<f64>() / volume;
    // the volume available to the centres of a component is smaller than the box
    let room: Vec<CentreVolume> = components.iter().map(|c| CentreVolume::of(scene, c.diameter)).collect();
    let density: Vec<f64> = components.iter().zip(&room).map(|(c, room)| c.count as f64 / room.volume).collect();
    let moment = |power: i32| -> f64 {
        components.iter().zip(&density).map(|(c, n)| PI / 6.0 * n * c.diameter.powi(power)).sum()
    };
    let (filled, second) = (moment(3).min(0.74), moment(2)); // no packing is denser than 0.7405 (Kepler)
    let (mut pairs, mut weighted) = (0.0, 0.0);
    for (i, a) in components.iter().enumerate() {
        for (j, b) in components.iter().enumerate().skip(i) {
            let reach = 0.5 * (a.diameter + b.diameter);
            let g = contact_value(a.diameter, b.diameter, filled, second);
            let share = if i == j { 0.5 * (1.0 - 1.0 / a.count.max(1) as f64) } else { 1.0 };
            let smaller = if room[i].volume < room[j].volume { &room[i] } else { &room[j] };
            let seen = 1.0 - smaller.hidden(reach);
            let rate =
                share * density[i] * density[j] * reach * reach * g * (8.0 * PI * (a.variance + b.variance)).sqrt();
            pairs += rate * smaller.volume * seen;
            weighted += rate * smaller.volume * seen * g;
        }
    }
    pairs *= spread.pair_rate;
    weighted *= spread.pair_rate;
    let contact_value = if pairs > 0.0 { weighted / pairs } else { contact_value(1.0, 1.0, filled, filled) };
    let compressibility = 1.0 + 4.0 * filled * contact_value;
    let walls = components.iter().zip(&density).zip(&room);
    let wall_rate = spread.wall_rate
        * walls
            .map(|((c, n), room)| n * compressibility * (c.variance / (2.0 * PI)).sqrt() * room.wall_area)
            .sum::<f64>();
    let collision_rate = if total > 0.0 { 2.0 * pairs / total } else { 0.0 };
    let mean_speed: f64 =
        components.iter().map(|c| c.count as f64 * (8.0 * c.variance / PI).sqrt()).sum::<f64>() / total.max(1.0);
    Gas {
        volume_fraction,
        contact_value,
        pair_rate: pairs,
        wall_rate,
        collision_rate,
        mean_free_path: mean_speed / collision_rate,
    }
}

/// Part of the box that is available to the centres of spheres of one diameter.
struct CentreVolume {
    /// [m³] volume of the box that is available to the centres of the spheres.
    volume: f64,
    /// [m²] area of all flat walls that are perpendicular to an axis of the box.
    wall_area: f64,
}

impl CentreVolume {
    /// Computes the volume of the domain minus a layer, half a diameter thick, at each flat wall perpendicular to an
    /// axis of the box. Other walls are ignored.
    fn of(scene: &Scene, diameter: f64) -> Self {
        let mut size = scene.domain.size;
        let mut area = 0.0;
        for wall in &scene.walls {
            if let Some(plane) = wall.geometry.plane()
                && let Some(axis) = (0..3).find(|&axis| plane.normal[axis].abs() > 1.0 - 1e-9)
            {
                size[axis] -= 0.5 * diameter;
                area += scene.domain.volume() / scene.domain.size[axis];
            }
        }
        Self { volume: size.product(), wall_area: area }
    }

    /// [-] fraction of the collision directions that walls make impossible, averaged over the available volume. Within
    /// `reach` [m] of a wall the fraction is 1/4 on average.
    fn hidden(&self, reach: f64) -> f64 {
        (0.25 * reach * self.wall_area / self.volume).min(1.0)
    }
}

/// [-] apparent decrease of the diameter of soft spheres of one species, over the diameter d. The apparent diameter is
/// that of Barker and Henderson (1967, J. Chem. Phys. 47, 4714) at the granular temperature T [m²/s²]. For a linear
/// spring the decrease is sqrt(π m T/(2 k))/d. The relative decrease of the cross-section is twice as large. The effect
/// on the collision rate depends on the density of the gas (docs/theory/softness.md).
pub fn softness(law: &ContactLaw, species: &Species, temperature: f64) -> f64 {
    // the stored energy does not depend on the restitution
    let surface = Surface::new(1.0, 0.0);
    let spring = law.between(&Bodies::alike(species, &surface));
    law.thermal_overlap(&spring, species.mass() * temperature) / species.diameter
}

/// [-] largest apparent decrease of the contact distance of soft spheres over this distance, among all pairs of
/// species that have particles. For two spheres of one species, the decrease is that of [`softness`]. `temperatures`
/// holds the granular temperature [m²/s²] of each species, `None` for a species without particles. The result is
/// `None` if no species has particles.
pub fn softest(law: &ContactLaw, scene: &Scene, temperatures: &[Option<f64>]) -> Option<f64> {
    let present: Vec<(u16, f64)> = (0..).zip(temperatures).filter_map(|(species, t)| Some((species, (*t)?))).collect();
    let of_pair = |(one, t): (u16, f64), (other, u): (u16, f64)| {
        // the stored energy does not depend on the restitution
        let bodies = Bodies::between(scene, one, other).elastic();
        let [first, second] = [one, other].map(|species| scene.species[usize::from(species)].diameter);
        law.thermal_overlap(&law.between(&bodies), bodies.effective_mass * (t + u)) / (0.5 * (first + second))
    };
    let pairs = present.iter().enumerate().flat_map(|(k, one)| present[k..].iter().map(move |other| (*one, *other)));
    pairs.map(|(one, other)| of_pair(one, other)).reduce(f64::max)
}

/// [-] factor by which the elastic constant of the law must increase so that the apparent cross-section of soft
/// spheres is smaller than that of hard spheres by at most the fraction `error` [-]. The spheres belong to `species`
/// and have the granular temperature `temperature` [m²/s²].
pub fn stiffening_for(law: &ContactLaw, species: &Species, temperature: f64, error: f64) -> f64 {
    law.stiffening(2.0 * softness(law, species, temperature) / error)
}

/// Expected size of the largest cluster of particles that are connected by collisions within a certain time. Each
/// particle has on average `collisions` [-] collisions in this time. The result is the smallest size such that fewer
/// than one larger cluster is expected among `count` particles. `None` if clusters grow without bound (one collision
/// per particle or more).
///
/// The clusters are those of a random graph with the mean degree c. The probability that a particle is in a cluster of
/// size s is that of Borel's distribution, P(s) = (cs)^(s-1) e^(-cs)/s! (Borel 1942). The number of clusters of size s
/// is proportional to P(s)/s.
pub fn largest_island(collisions: f64, count: usize) -> Option<usize> {
    if collisions >= 1.0 {
        return None;
    }
    if collisions <= 0.0 || count == 0 {
        return Some(count.min(1));
    }
    let mut rest = 1.0;
    let mut factorial = 0.0;
    for size in 1..count {
        let s = size as f64;
        factorial += s.ln();
        rest -= ((s - 1.0) * (collisions * s).ln() - collisions * s - factorial).exp();
        // number of larger clusters: the number of particles in them, divided by their size
        if count as f64 * rest.max(0.0) / (s + 1.0) < 1.0 {
            return Some(size);
        }
    }
    Some(count)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::domain::Domain;
    use crate::scene::Surface;
    use crate::walls::{Plane, Wall, WallGeometry};
    use nalgebra::Vector3;

    fn cube(edge: f64, walls: bool) -> Scene {
        let smooth = Surface::new(1.0, 0.0);
        let plane = |y: f64, n: f64| {
            Wall::new(
                WallGeometry::Plane(Plane { point: Vector3::new(0.0, y, 0.0), normal: Vector3::new(0.0, n, 0.0) }),
                smooth,
            )
        };
        Scene {
            walls: if walls { vec![plane(0.0, 1.0), plane(edge, -1.0)] } else { Vec::new() },
            ..Scene::new(Domain::new(Vector3::new(edge, edge, edge), [true, !walls, true]), smooth, Vec::new())
        }
    }

    /// Compares the predicted collision rate Γ of a particle, as Γ σ/sqrt(T) with the diameter σ and the granular
    /// temperature T, with values tabulated independently. The values are those of Enskog's theory with the contact
    /// value of Carnahan and Starling.
    #[test]
    fn collision_rates() {
        for (fraction, rate) in
            [(0.0012, 0.016298), (0.01, 0.138853), (0.1, 1.764544), (0.3, 10.066590), (0.45, 28.383272)]
        {
            let count = 1_000_000_000;
            let edge = (count as f64 * PI / 6.0 / fraction).cbrt();
            let found =
                gas(&cube(edge, false), &[Component { count, diameter: 1.0, variance: 1.0 }], &AgitationSpread::even());
            assert!((found.collision_rate / rate - 1.0).abs() < 5e-5, "{fraction}: {found:?}");
            let path = (8.0 / PI).sqrt() / rate;
            assert!((found.mean_free_path / path - 1.0).abs() < 5e-5);
        }
    }

    /// Compares collision rates with event-driven runs of another code in a slit 12 diameters wide. With 200 and 400
    /// spheres, the collision rates of a particle are 0.996 and 2.365. The pressures, as momentum of the impacts on
    /// both walls per time and area, are 0.1633 and 0.4262. The tolerance allows for an error of 1 % of the runs, and
    /// for a density that is not uniform.
    #[test]
    fn a_slit() {
        for (count, rate, pressure) in [(200, 0.996, 0.1633), (400, 2.365, 0.4262)] {
            let found =
                gas(&cube(12.0, true), &[Component { count, diameter: 1.0, variance: 1.0 }], &AgitationSpread::even());
            assert!((found.collision_rate / rate - 1.0).abs() < 0.04, "{found:?}");
            // the mean momentum per impact is 2 sqrt(π/2)
            let found = found.wall_rate * 2.0 * (0.5 * PI).sqrt() / (2.0 * 144.0);
            assert!((found / pressure - 1.0).abs() < 0.06, "{found}");
        }
    }

    /// Checks two uneven gases, relative to a uniform gas. For motion along one axis only, the standard deviation s of
    /// the velocity along a normal is sqrt(3) |cos θ|, with the angle θ between normal and axis. Rates are then
    /// sqrt(3)/2, and the mean of s over collisions is <s²>/<s> = 2/sqrt(3). In a gas twice as dense in one half as in
    /// the other, the rate is ((4 + 1)/2)/(3/2)².
    #[test]
    fn uneven_gases() {
        let even = Slice { particles: 0.5, room: 0.5, variance: [2.0; 3] };
        let found = AgitationSpread::of(&[even, even]);
        assert!((found.pair_rate - 1.0).abs() < 1e-12 && (found.wall_rate - 1.0).abs() < 1e-12);
        let line = Slice { variance: [0.0, 0.0, 1.0], ..even };
        let found = AgitationSpread::of(&[line, line]);
        assert!((found.pair_rate - 0.75f64.sqrt()).abs() < 1e-3, "{}", found.pair_rate);
        let mean: f64 = found.pairs.iter().map(|[share, s]| share * s).sum();
        assert!((mean * 0.75f64.sqrt() - 1.0).abs() < 4e-3, "{mean}");
        let across = Slice { variance: [0.0, 1.0, 0.0], ..even };
        assert!((AgitationSpread::of(&[across, across]).pair_rate - 0.75f64.sqrt()).abs() < 4e-3);
        assert!((AgitationSpread::of(&[across, across]).wall_rate - 3f64.sqrt()).abs() < 1e-12);
        let halves = [Slice { particles: 2.0 / 3.0, ..even }, Slice { particles: 1.0 / 3.0, ..even }];
        assert!((AgitationSpread::of(&halves).pair_rate - 10.0 / 9.0).abs() < 1e-12);
        assert_eq!(AgitationSpread::of(&[]), AgitationSpread::even());
    }

    #[test]
    fn a_mixture_of_equals_is_the_pure_gas() {
        let scene = cube(20.0, false);
        let half = Component { count: 500_000, diameter: 0.1, variance: 2.0 };
        let pure = gas(&scene, &[Component { count: 1_000_000, ..half }], &AgitationSpread::even());
        let mixed = gas(&scene, &[half, half], &AgitationSpread::even());
        assert!((mixed.pair_rate / pure.pair_rate - 1.0).abs() < 1e-5);
        assert!((mixed.contact_value / pure.contact_value - 1.0).abs() < 1e-12);
    }

    /// Compares the decrease 1 - d_eff/σ of the apparent diameter d_eff of soft spheres of the diameter σ with values
    /// computed independently to two digits. The cases are B, D, E and G of the paper (`docs/paper.md`).
    #[test]
    fn soft_spheres_are_smaller() {
        for (mass, t, stiffness, diameter, shrink) in [
            (3.6372577e-8, 0.866, 3000.0, 406e-6, 0.0100),
            (3.6372577e-8, 0.490, 3000.0, 406e-6, 0.0075),
            (1.8236945e-6, 0.292, 5000.0, 1.5e-3, 0.0086),
            (1.8236945e-6, 0.221, 5000.0, 1.5e-3, 0.0075),
        ] {
            let law = ContactLaw::linear(stiffness);
            let density = mass / (PI / 6.0 * f64::powi(diameter, 3));
            let species = Species::new("S", diameter, density);
            let found = softness(&law, &species, t);
            assert!((found - shrink).abs() < 6e-5, "{found}");
            assert!((stiffening_for(&law, &species, t, 2.0 * found) - 1.0).abs() < 1e-12);
            assert!((stiffening_for(&law, &species, t, found) - 4.0).abs() < 1e-12);
        }
    }

    #[test]
    fn islands() {
        assert_eq!(largest_island(0.0, 1000), Some(1));
        assert_eq!(largest_island(1.0, 1000), None);
        // number of clusters of two: N c/2 are expected; 1000 particles with 1e-3 collisions each make half a pair
        assert_eq!(largest_island(1e-4, 1000), Some(1));
        assert_eq!(largest_island(1e-2, 1000), Some(2));
        assert!(largest_island(0.5, 100_000) > largest_island(0.1, 100_000));
    }
}
