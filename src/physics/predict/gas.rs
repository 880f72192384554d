//! Kinetic theory of the particles, treated as a dense gas of hard spheres.
//!
//! Enskog's theory of hard spheres is exact in the dilute limit, and accurate to about 1 % up to a volume fraction of
//! 0.45. The theory is valid for many particles with nearly Maxwellian and uncorrelated velocities. It is not valid for
//! a bed, a row or a few bodies.

use crate::contact_law::{Bodies, ContactLaw};
use crate::kinetic_theory::contact_value;
use crate::scene::{Scene, Species, Surface};
use nalgebra::Vector3;
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
    /// [m] mean free path of a particle between collisions with other particles; infinite if none collide. It does not
    /// depend on an agitation that all components share, so that a gas at rest has one too.
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
///
/// Two walls may leave the centres a width w below one diameter d. For such a layer the rate of pair collisions is that
/// of dilute spheres at any w, and for w = 0 that of disks. The contact value is that of spheres in the width d. Up to
/// an area fraction of 0.5 it is at most 10 % below that of disks (Henderson 1975, Mol. Phys. 30, 971). Each wall of a
/// layer has sqrt(T/2π)/w impacts per particle and time, and none for w = 0.
pub fn gas(scene: &Scene, components: &[Component], spread: &AgitationSpread) -> Gas {
    let volume = scene.domain.volume();
    let total: f64 = components.iter().map(|c| c.count as f64).sum();
    let sphere = |c: &Component| c.count as f64 * PI / 6.0 * c.diameter.powi(3);
    let volume_fraction = components.iter().map(sphere).sum::<f64>() / volume;
    // the volume available to the centres of a component is smaller than the box
    let room: Vec<CentreVolume> = components.iter().map(|c| CentreVolume::of(scene, c.diameter)).collect();
    let density: Vec<f64> = components.iter().zip(&room).map(|(c, room)| c.count as f64 / room.volume).collect();
    let moment = |power: i32| -> f64 {
        let packed = components.iter().zip(&room).map(|(c, room)| (c.count as f64 / room.packed, c.diameter));
        packed.map(|(n, diameter)| PI / 6.0 * n * diameter.powi(power)).sum()
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
            .map(|((c, n), room)| {
                let speed = (c.variance / (2.0 * PI)).sqrt();
                n * compressibility * speed * room.wall_area + c.count as f64 * speed * room.walls_over_width
            })
            .sum::<f64>();
    let collision_rate = if total > 0.0 { 2.0 * pairs / total } else { 0.0 };
    let mean_speed: f64 =
        components.iter().map(|c| c.count as f64 * (8.0 * c.variance / PI).sqrt()).sum::<f64>() / total.max(1.0);
    let mean_free_path = if collision_rate > 0.0 {
        mean_speed / collision_rate
    } else if total > 0.0 && components.iter().all(|c| c.variance == 0.0) {
        let moving: Vec<Component> = components.iter().map(|c| Component { variance: 1.0, ..*c }).collect();
        gas(scene, &moving, spread).mean_free_path
    } else {
        f64::INFINITY
    };
    Gas { volume_fraction, contact_value, pair_rate: pairs, wall_rate, collision_rate, mean_free_path }
}

/// Part of the box that is available to the centres of spheres of one diameter d. Two walls that leave the centres a
/// width below d make the spheres a layer.
struct CentreVolume {
    /// [m³] volume of the box that is available to the centres of the spheres. A layer counts with the width 2 d. The
    /// rate of dilute pairs, averaged over the directions that the walls allow, is then right at any width.
    volume: f64,
    /// [m³] volume from which the contact value follows. It is `volume`, except that a layer has the width d.
    packed: f64,
    /// [m²] area of all flat walls that are perpendicular to an axis of the box; walls of layers do not count.
    wall_area: f64,
    /// [1/m] number of walls of a layer over the width in which the centres move between them; 0 without a layer, or
    /// without such a width.
    walls_over_width: f64,
}

impl CentreVolume {
    /// Computes the volume of the domain minus a layer, half a diameter thick, at each flat wall perpendicular to an
    /// axis of the box. Other walls are ignored.
    fn of(scene: &Scene, diameter: f64) -> Self {
        /// [-] width for the centres over the diameter, below which it is a rounding error of the places of walls.
        const ROUNDING: f64 = 1e-9; // far above the rounding of coordinates, 1e-16 of the box
        let (mut size, mut walls) = (scene.domain.size, Vector3::<f64>::zeros());
        for wall in &scene.walls {
            if let Some(plane) = wall.geometry.plane()
                && let Some(axis) = (0..3).find(|&axis| plane.normal[axis].abs() > 1.0 - 1e-9)
            {
                size[axis] -= 0.5 * diameter;
                walls[axis] += 1.0;
            }
        }
        let (mut packed, mut wall_area, mut walls_over_width) = (size, 0.0, 0.0);
        for axis in 0..3 {
            if walls[axis] == 0.0 || size[axis] >= diameter {
                wall_area += walls[axis] * (scene.domain.volume() / scene.domain.size[axis]);
                continue;
            }
            if size[axis] > ROUNDING * diameter {
                walls_over_width += walls[axis] / size[axis];
            }
            (size[axis], packed[axis]) = (2.0 * diameter, diameter);
        }
        Self { volume: size.product(), packed: packed.product(), wall_area, walls_over_width }
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

    /// Checks a gas without agitation, which has no collisions. Its mean free path is that of the same gas with any
    /// agitation.
    #[test]
    fn a_gas_at_rest_has_a_mean_free_path() {
        let (scene, even) = (cube(20.0, true), AgitationSpread::even());
        let kinds = |variance: f64| [1.0, 0.5].map(|diameter| Component { count: 500, diameter, variance });
        let (still, moving) = (gas(&scene, &kinds(0.0), &even), gas(&scene, &kinds(2.5), &even));
        assert_eq!((still.collision_rate, still.wall_rate), (0.0, 0.0));
        assert!((still.mean_free_path / moving.mean_free_path - 1.0).abs() < 1e-12, "{still:?}");
        let alone = Component { count: 1, diameter: 1.0, variance: 0.0 };
        assert_eq!(gas(&scene, &[alone], &even).mean_free_path, f64::INFINITY);
        assert_eq!(gas(&scene, &[], &even).mean_free_path, f64::INFINITY);
    }

    /// Checks layers of spheres between walls that leave the centres a width w below one diameter. At w = 0 the spheres
    /// are disks: a disk collides 2 n d g sqrt(π T) times per time, with the number n per area. The contact value g of
    /// disks is (1 - 7η/16)/(1 - η)² at the area fraction η (Henderson 1975, Mol. Phys. 30, 971). At w = d the rate is
    /// continuous.
    #[test]
    fn layers_of_spheres() {
        let (count, even) = (10_000, AgitationSpread::even());
        let component = Component { count, diameter: 1.0, variance: 2.0 };
        for fraction in [0.01, 0.3, 0.5] {
            let edge = (count as f64 * 0.25 * PI / fraction).sqrt();
            let layer = |height: f64| {
                let mut scene = cube(height, true);
                scene.domain = Domain::new(Vector3::new(edge, height, edge), [true, false, true]);
                gas(&scene, &[component], &even)
            };
            let flat = layer(1.0);
            let disks = (1.0 - 7.0 / 16.0 * fraction) / (1.0 - fraction) / (1.0 - fraction);
            assert!((flat.contact_value / disks - 1.0).abs() < 0.101, "{fraction}: {flat:?}");
            let rate = 2.0 * count as f64 / (edge * edge) * flat.contact_value * (2.0 * PI).sqrt();
            assert!((flat.collision_rate / rate - 1.0).abs() < 2e-4, "{fraction}: {flat:?}, {rate}");
            assert_eq!(flat.wall_rate, 0.0);
            assert!(flat.mean_free_path > 0.0 && flat.mean_free_path.is_finite());
            let [below, above] = [2.0 - 1e-9, 2.0 + 1e-9].map(|height| layer(height).collision_rate);
            assert!((below / above - 1.0).abs() < 1e-6, "{fraction}: {below} {above}");
            let impacts = 2.0 * count as f64 / 0.5 * (2.0 / (2.0 * PI)).sqrt();
            assert!((layer(1.5).wall_rate / impacts - 1.0).abs() < 1e-12);
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
