//! Divides polygons with more than three corners into triangles.

use nalgebra::Vector3;
use rustc_hash::{FxHashMap, FxHashSet};
use spade::handles::FixedVertexHandle;
use spade::{ConstrainedDelaunayTriangulation, Point2, Triangulation};

/// [-] smallest sine of the angle by which the boundary of a polygon turns at each corner, for a division as a fan
/// (all triangles share the first corner). With smaller angles, triangles would be so thin that the surface ignores
/// them.
const TURN: f64 = 1e-6;
/// [-] relative error of an area that counts as rounding.
const ROUNDING: f64 = 1e-9;

/// Result of the division of a polygon into triangles.
#[derive(Debug)]
pub struct Cut {
    /// Triangles, each given by the indices of three corners of the polygon. The corners of a triangle follow one
    /// another in the same sense of rotation as those of the polygon.
    pub triangles: Vec<[usize; 3]>,
    /// [-] largest distance of a corner from the plane of the polygon, divided by the length of the polygon. The
    /// length is the largest distance of a corner from the first corner.
    pub off: f64,
}

/// Divides a polygon along lines between its corners. All corners remain, even those on a straight edge, so that the
/// triangles fit those of neighbouring polygons.
///
/// # Errors
/// A message in words: edges of the polygon cross each other.
pub fn cut(corners: &[Vector3<f64>]) -> Result<Cut, &'static str> {
    let fan = || (1..corners.len() - 1).map(|k| [0, k, k + 1]).collect();
    let length = corners.iter().map(|corner| (corner - corners[0]).norm()).fold(0.0, f64::max);
    if corners.len() == 3 || length == 0.0 {
        return Ok(Cut { triangles: fan(), off: 0.0 });
    }
    // after division by the length, squares of very small and very large numbers remain finite
    let places: Vec<Vector3<f64>> = corners.iter().map(|corner| (corner - corners[0]) / length).collect();
    let twice_area: Vector3<f64> = (1..places.len() - 1).map(|k| places[k].cross(&places[k + 1])).sum();
    let Some(normal) = twice_area.try_normalize(ROUNDING) else {
        let line =
            places.iter().max_by(|a, b| a.norm_squared().total_cmp(&b.norm_squared())).copied().unwrap_or_default();
        let flat = places.iter().all(|place| place.cross(&line).norm() <= ROUNDING);
        // this gives triangles without area, which are reported and ignored later
        return if flat { Ok(Cut { triangles: fan(), off: 0.0 }) } else { Err(CROSSES) };
    };
    let off = places.iter().map(|place| place.dot(&normal).abs()).fold(0.0, f64::max);
    let along = places
        .iter()
        .map(|place| place - normal * place.dot(&normal))
        .max_by(|a, b| a.norm_squared().total_cmp(&b.norm_squared()));
    let x = along.unwrap_or_default().normalize();
    let y = normal.cross(&x);
    let flat: Vec<[f64; 2]> = places.iter().map(|place| [place.dot(&x), place.dot(&y)]).collect();
    let triangles = if is_convex(&flat) { fan() } else { inside(&flat)? };
    let area: f64 = triangles.iter().map(|triangle| twice(triangle.map(|k| flat[k]))).sum();
    if (area - twice_area.norm()).abs() > ROUNDING * area {
        return Err(CROSSES);
    }
    Ok(Cut { triangles, off })
}

const CROSSES: &str = "the polygon crosses itself";

/// Twice the area of a triangle with the corners a, b and c; positive if they run anticlockwise, else negative.
fn twice([a, b, c]: [[f64; 2]; 3]) -> f64 {
    (b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0])
}

/// True if a polygon turns left at each corner, and no triangle is very thin when it is divided as a fan.
fn is_convex(flat: &[[f64; 2]]) -> bool {
    let (count, away) = (flat.len(), |a: [f64; 2], b: [f64; 2]| (b[0] - a[0]).hypot(b[1] - a[1]));
    let turns = |a: [f64; 2], b: [f64; 2], c: [f64; 2]| twice([a, b, c]) > TURN * away(a, b) * away(b, c);
    (0..count).all(|k| turns(flat[k], flat[(k + 1) % count], flat[(k + 2) % count]))
        && (1..count - 1).all(|k| turns(flat[0], flat[k], flat[k + 1]) && turns(flat[k], flat[k + 1], flat[0]))
}

/// Triangles between the corners of a polygon that lie inside the polygon. A path from such a triangle to the outside
/// crosses an odd number of edges of the polygon.
fn inside(flat: &[[f64; 2]]) -> Result<Vec<[usize; 3]>, &'static str> {
    let no_place = |_| "a corner of the polygon is no place";
    let mut plane = ConstrainedDelaunayTriangulation::<Point2<f64>>::new();
    let mut corners: Vec<FixedVertexHandle> = Vec::with_capacity(flat.len());
    for &place in flat {
        // smaller values are rounding errors, and too small for the geometric predicates of the library
        let [x, y] = place.map(|value| if value.abs() < f64::EPSILON * f64::EPSILON { 0.0 } else { value });
        corners.push(plane.insert(Point2::new(x, y)).map_err(no_place)?);
    }
    let number: FxHashMap<FixedVertexHandle, usize> = corners.iter().copied().zip(0..).collect();
    let pair = |a: FixedVertexHandle, b: FixedVertexHandle| [a.index().min(b.index()), a.index().max(b.index())];
    // an edge that the polygon follows twice, to a hole and back, does not separate inside and outside
    let mut borders = FxHashSet::default();
    for k in 0..corners.len() {
        let (from, to) = (corners[k], corners[(k + 1) % corners.len()]);
        if from == to {
            continue;
        }
        let edges = plane.try_add_constraint(from, to);
        if edges.is_empty() {
            return Err(CROSSES);
        }
        for edge in edges {
            let [a, b] = plane.directed_edge(edge).vertices().map(|vertex| vertex.fix());
            let border = pair(a, b);
            if !borders.remove(&border) {
                borders.insert(border);
            }
        }
    }
    // for each face a list of its neighbour faces, each with true if a border separates the two faces
    let mut beside = vec![Vec::new(); plane.num_all_faces()];
    for edge in plane.directed_edges() {
        let border = borders.contains(&pair(edge.from().fix(), edge.to().fix()));
        beside[edge.face().fix().index()].push((edge.rev().face().fix().index(), border));
    }
    let outer = plane.outer_face().fix().index();
    let mut within = vec![None; beside.len()];
    within[outer] = Some(false);
    let mut next = vec![outer];
    while let Some(face) = next.pop() {
        for &(other, border) in &beside[face] {
            if within[other].is_none() {
                within[other] = within[face].map(|within: bool| within != border);
                next.push(other);
            }
        }
    }
    let faces = plane.inner_faces().filter(|face| within[face.fix().index()] == Some(true));
    Ok(faces.map(|face| face.vertices().map(|vertex| number[&vertex.fix()])).collect())
}
