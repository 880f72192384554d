//! Walls of a scene as surfaces for trajectory files. Planes are cut at the sides of the box, and bodies consist of
//! triangles.

use super::vtp::Vtp;
use crate::domain::Domain;
use crate::scene::Scene;
use crate::walls::{Plane, WallGeometry};
use nalgebra::Vector3;

/// Surface as the list of its corners [m], and a list of polygons. A polygon is a list of indices of corners.
pub(in crate::output) type DrawnSurface = (Vec<Vector3<f64>>, Vec<Vec<u32>>);

/// VTK file (of the kind PolyData) with the surfaces of all walls at `time` [s], as three parts to be written one after
/// the other. Moving walls of `scene` must already be at their places at that time. For each polygon, the file contains
/// the index of its wall in the case. `None` if no wall has a surface in the box.
pub(super) fn walls(scene: &Scene, time: f64) -> Option<[Vec<u8>; 3]> {
    let surfaces = scene.walls.iter().map(|wall| match &wall.geometry {
        WallGeometry::Plane(plane) => flat(plane, &scene.domain),
        other => {
            let (corners, triangles) = other.law().drawing(&scene.domain.size);
            (corners, triangles.into_iter().map(Vec::from).collect())
        }
    });
    let (mut corners, mut polygons): DrawnSurface = (Vec::new(), Vec::new());
    let mut number = Vec::new();
    for (wall, (points, faces)) in surfaces.enumerate() {
        let first = corners.len() as u32;
        number.extend(std::iter::repeat_n(wall as u32, faces.len()));
        polygons.extend(faces.iter().map(|face| face.iter().map(|corner| corner + first).collect::<Vec<u32>>()));
        corners.extend(points);
    }
    if polygons.is_empty() {
        return None;
    }
    let mut file = Vtp::begin(Vec::new(), time, [corners.len(), 0, polygons.len()]);
    file.part("CellData", |file| file.array("wall", number.into_iter().map(|number| [number])));
    file.part("Points", |file| file.array::<f64, 3>("Points", corners.iter().map(|corner| (*corner).into())));
    let mut end = 0;
    let ends = polygons.iter().map(|polygon| {
        end += polygon.len() as i32;
        end
    });
    let ends: Vec<i32> = ends.collect();
    file.part("Polys", |file| {
        file.array("connectivity", polygons.iter().flatten().map(|corner| [*corner as i32]));
        file.array("offsets", ends.into_iter().map(|end| [end]));
    });
    Some(file.finish())
}

/// Part of a plane inside the box: one convex polygon, anticlockwise when seen from the side to which the normal
/// points. Both lists of the surface are empty if the plane does not cut the box.
pub(in crate::output) fn flat(plane: &Plane, domain: &Domain) -> DrawnSurface {
    let corner = |k: usize| Vector3::from_fn(|axis, _| if k >> axis & 1 == 1 { domain.size[axis] } else { 0.0 });
    let height = |x: &Vector3<f64>| (x - plane.point).dot(&plane.normal);
    // tolerance for rounding if the plane is a side of the box
    let near = 1e-9 * domain.size.max();
    let mut corners: Vec<Vector3<f64>> = (0..8).map(corner).filter(|x| height(x).abs() <= near).collect();
    let edges = (0..8).flat_map(|k| (0..3).filter(move |axis| k >> axis & 1 == 0).map(move |axis| (k, k | 1 << axis)));
    for (a, b) in edges {
        let (a, b) = (corner(a), corner(b));
        let (from, to) = (height(&a), height(&b));
        if from.abs() > near && to.abs() > near && (from > 0.0) != (to > 0.0) {
            corners.push(a + (b - a) * (from / (from - to)));
        }
    }
    if corners.len() < 3 {
        return (Vec::new(), Vec::new());
    }
    let middle = corners.iter().sum::<Vector3<f64>>() / corners.len() as f64;
    let first = (corners[0] - middle).normalize();
    let second = plane.normal.cross(&first);
    let angle = |x: &Vector3<f64>| (x - middle).dot(&second).atan2((x - middle).dot(&first));
    corners.sort_by(|a, b| angle(a).total_cmp(&angle(b)));
    let polygon = (0..corners.len() as u32).collect();
    (corners, vec![polygon])
}
