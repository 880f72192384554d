//! Closed parts (connected groups of triangles) of a surface inside other closed parts. A part inside an odd number of
//! other parts bounds a cavity, and its triangles must face into the cavity.

use super::surface::{Edges, Findings, Numbered};
use super::{Sides, Tree};
use nalgebra::Vector3;
use rustc_hash::FxHashMap;
use serde::Serialize;

/// Largest number of triangles of a closed part (connected group of triangles) for which the program tests whether
/// they are inside other parts. If only some of the tested triangles are inside another part, the two parts cross.
const SAMPLES: usize = 8;
/// [-] directions of rays. A point is inside a closed part (connected group of triangles) if a ray from the point
/// crosses an odd number of triangles of the part. No direction is along an axis or a diagonal of typical drawings. If
/// a ray passes through an edge, the next direction is used.
const WAYS: [[f64; 3]; 4] =
    [[0.731, 0.419, 0.538], [-0.283, 0.874, 0.395], [0.467, -0.612, 0.638], [-0.571, -0.327, 0.753]];
/// [-] distance divided by the size of the surface. A point that is nearer to an edge or a triangle than this counts as
/// lying on that edge or triangle.
const ON: f64 = 1e-9;

/// Counts of the closed parts (connected groups of triangles) of a surface that lie inside other parts, by type.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize)]
pub struct Nested {
    /// Number of cavities. A closed part (connected group of triangles) inside an odd number of other parts is the
    /// boundary of a cavity.
    pub cavities: usize,
    /// Number of cavities whose triangles faced away from the cavity and were flipped.
    pub turned: usize,
    /// Number of outermost parts (connected groups of triangles) that were removed. They are the outer surfaces of
    /// vessels with thick walls that contain the particles.
    pub skins: usize,
    /// Number of solid bodies inside a vessel. The triangles of these bodies, as given, face the same way as those of
    /// the vessel: both outwards or both inwards.
    pub bodies: usize,
    /// Number of closed parts (connected groups of triangles) that lie only partly inside another part, which is a
    /// defect of the drawing.
    pub crossing: usize,
}

/// Flips the triangles of a closed surface so that they face the particles: outwards, and into cavities. If particles
/// are inside a vessel with a thick wall, the outer surface of the wall is removed. Without a thick wall the outermost
/// part (connected group of triangles) is the vessel, and the parts inside the vessel are solid bodies. Cavities,
/// bodies, and parts that are flipped or removed are counted in `findings`.
pub fn face_particles(
    points: &[Vector3<f64>],
    triangles: &mut Numbered,
    edges: &Edges,
    sides: Sides,
    findings: &mut Findings,
) {
    let parts = parts(triangles.len(), edges);
    let inward: Vec<bool> = parts.iter().map(|part| volume(points, triangles, part) < 0.0).collect();
    let around = parts_around(points, triangles, &parts, &mut findings.nested);
    let is_root = |part: usize| around[part].is_empty();
    // an outermost part is the outer surface of a thick wall if a part directly inside this part faces the other way
    let mut is_skin = vec![false; parts.len()];
    for (number, around) in around.iter().enumerate() {
        if let (Sides::Inside, &[root]) = (sides, &around[..]) {
            is_skin[root] |= inward[number] != inward[root];
        }
    }
    let mut stays = vec![true; triangles.len()];
    for (number, part) in parts.iter().enumerate() {
        let root = around[number].iter().copied().find(|part| is_root(*part)).unwrap_or(number);
        let (is_cavity, is_vessel) = (around[number].len() % 2 == 1, sides == Sides::Inside && !is_skin[root]);
        let nested = &mut findings.nested;
        if is_vessel {
            nested.bodies += usize::from(is_cavity);
        } else if is_skin[number] {
            nested.skins += 1;
            part.iter().for_each(|k| stays[*k] = false);
        } else if is_cavity {
            nested.cavities += 1;
            nested.turned += usize::from(!inward[number]);
        } else {
            findings.inside_out |= inward[number];
        }
        if inward[number] != (is_cavity != is_vessel) {
            part.iter().for_each(|k| triangles[*k].0.swap(1, 2));
        }
    }
    let mut stays = stays.into_iter();
    triangles.retain(|_| stays.next().unwrap_or(true));
}

/// Parts (connected groups of triangles) of a surface of `count` triangles, each as a list of triangle indices.
fn parts(count: usize, edges: &Edges) -> Vec<Vec<usize>> {
    let mut beside: Vec<Vec<u32>> = vec![Vec::new(); count];
    for there in edges.values() {
        if let [(a, _), (b, _)] = there[..] {
            beside[a as usize].push(b);
            beside[b as usize].push(a);
        }
    }
    let (mut seen, mut parts) = (vec![false; count], Vec::new());
    for first in 0..count {
        if std::mem::replace(&mut seen[first], true) {
            continue;
        }
        let (mut part, mut next) = (vec![first], 0);
        while next < part.len() {
            for &other in &beside[part[next]] {
                if !std::mem::replace(&mut seen[other as usize], true) {
                    part.push(other as usize);
                }
            }
            next += 1;
        }
        parts.push(part);
    }
    parts
}

/// [m³] six times the volume of the closed part `part`, a list of triangle indices; positive if these triangles face
/// outwards.
fn volume(points: &[Vector3<f64>], triangles: &Numbered, part: &[usize]) -> f64 {
    let from = points[triangles[part[0]].0[0] as usize];
    let each = part.iter().map(|k| {
        let [a, b, c] = triangles[*k].0.map(|corner| points[corner as usize] - from);
        a.dot(&b.cross(&c))
    });
    each.sum()
}

/// For each closed part (connected group of triangles), the indices of the other parts that contain this part, in
/// ascending order. The number of parts that cross others is added to `nested`.
fn parts_around(
    points: &[Vector3<f64>],
    triangles: &Numbered,
    parts: &[Vec<usize>],
    nested: &mut Nested,
) -> Vec<Vec<usize>> {
    if parts.len() < 2 {
        return vec![Vec::new(); parts.len()];
    }
    let corners = |k: usize| triangles[k].0.map(|corner| points[corner as usize]);
    let mut of = vec![0; triangles.len()];
    for (number, part) in parts.iter().enumerate() {
        part.iter().for_each(|k| of[*k] = number);
    }
    let low = points.iter().copied().reduce(|a, b| a.inf(&b)).unwrap_or_default();
    let high = points.iter().copied().reduce(|a, b| a.sup(&b)).unwrap_or_default();
    let crossings = Crossings { tree: Tree::new((0..triangles.len()).map(corners)), of, size: (high - low).norm() };
    let mut around = Vec::new();
    for (number, part) in parts.iter().enumerate() {
        let (mut asked, mut within) = (0, FxHashMap::default());
        for k in part.iter().step_by(part.len().div_ceil(SAMPLES)) {
            let [a, b, c] = corners(*k);
            let Some(others) = crossings.around(&((a + b + c) / 3.0), number, corners) else { continue };
            asked += 1;
            others.into_iter().for_each(|other| *within.entry(other).or_insert(0) += 1);
        }
        nested.crossing += usize::from(within.values().any(|count| *count < asked));
        let mut wholly: Vec<usize> =
            within.into_iter().filter(|(_, count)| *count == asked).map(|(other, _)| other).collect();
        wholly.sort_unstable();
        around.push(wholly);
    }
    around
}

/// All triangles of a surface, in a tree that finds the triangles along a ray.
struct Crossings {
    tree: Tree,
    /// Index of the part (connected group of triangles) to which each triangle belongs.
    of: Vec<usize>,
    /// [m] diagonal of the box around the whole surface.
    size: f64,
}

impl Crossings {
    /// Indices of the parts (connected groups of triangles) that contain a point [m], without the part with the index
    /// `own`. `None` if the rays in all directions of [`WAYS`] pass through edges.
    fn around(
        &self,
        point: &Vector3<f64>,
        own: usize,
        corners: impl Fn(usize) -> [Vector3<f64>; 3],
    ) -> Option<Vec<usize>> {
        WAYS.iter().find_map(|way| {
            let way = Vector3::from(*way).normalize();
            let (mut is_odd, mut is_clear) = (FxHashMap::default(), true);
            self.tree.for_each_along(point, &(point + way * (2.0 * self.size)), ON * self.size, |triangle| {
                let part = self.of[triangle as usize];
                if part != own {
                    match passes(point, &way, corners(triangle as usize), self.size) {
                        Some(true) => *is_odd.entry(part).or_insert(false) ^= true,
                        Some(false) => {}
                        None => is_clear = false,
                    }
                }
            });
            is_clear.then(|| is_odd.into_iter().filter(|(_, odd)| *odd).map(|(part, _)| part).collect())
        })
    }
}

/// True if a ray passes through a triangle, given by its corners [m]. The ray begins at the point `from` [m] and has
/// the direction of the unit vector `way`. `None` if the ray passes through an edge or begins on the triangle. `size`
/// [m] is the diagonal of the box around the surface.
fn passes(from: &Vector3<f64>, way: &Vector3<f64>, corners: [Vector3<f64>; 3], size: f64) -> Option<bool> {
    let [a, b, c] = corners.map(|corner| corner - from);
    // twice the signed area of the triangle formed by an edge and the start of the ray, projected along the ray; the
    // sign shows on which side of the edge the ray passes
    let sides = [(a, b), (b, c), (c, a)].map(|(p, q)| (way.dot(&p.cross(&q)), ON * size * (q - p).norm()));
    if sides.iter().any(|(side, on)| *side > *on) && sides.iter().any(|(side, on)| *side < -on) {
        return Some(false);
    }
    if sides.iter().any(|(side, on)| side.abs() <= *on) {
        return None;
    }
    let normal = (b - a).cross(&(c - a));
    let distance = a.dot(&normal) / way.dot(&normal);
    (distance.abs() > ON * size).then_some(distance > 0.0)
}
