//! Walls of a scene as line segments, for animations on a page.

use crate::output::trajectory::flat;
use crate::scene::Scene;
use crate::walls::{Plane, WallGeometry};
use nalgebra::Vector3;
use std::collections::HashMap;

/// [-] cosine of 25 degrees. The common edge of two triangles is drawn if their normals differ by a larger angle.
const SHARP: f64 = 0.906;

/// Largest number of line segments that are drawn for one surface. More segments would hide the spheres.
const MOST: usize = 2000;

/// Line segments that outline each wall, with six coordinates [m] per segment: borders of planes, and edges of bodies.
pub fn outlines(scene: &Scene) -> Vec<Vec<f64>> {
    let of = |geometry: &WallGeometry| match geometry {
        WallGeometry::Plane(plane) => around(plane, scene),
        other => {
            let (corners, triangles) = other.law().drawing(&scene.domain.size);
            edges(&corners, &triangles)
        }
    };
    scene.walls.iter().map(|wall| of(&wall.geometry)).collect()
}

fn segment(from: &Vector3<f64>, to: &Vector3<f64>) -> impl Iterator<Item = f64> {
    let (from, to): ([f64; 3], [f64; 3]) = ((*from).into(), (*to).into());
    // single precision is enough for a screen, and its text is shorter
    from.into_iter().chain(to).map(|x| f64::from(x as f32))
}

fn around(plane: &Plane, scene: &Scene) -> Vec<f64> {
    let (corners, _) = flat(plane, &scene.domain);
    let next = corners.iter().cycle().skip(1);
    corners.iter().zip(next).flat_map(|(from, to)| segment(from, to)).collect()
}

/// Line segments of the edges at which a surface ends or bends. Two triangles have a common edge if the positions of
/// two corners are equal, even if the indices of the corners differ.
fn edges(corners: &[Vector3<f64>], triangles: &[[u32; 3]]) -> Vec<f64> {
    let key = |corner: u32| corners[corner as usize].map(f64::to_bits).data.0[0];
    let mut found: HashMap<_, (u32, u32, Vec<Vector3<f64>>)> = HashMap::new();
    let mut order = Vec::new();
    for triangle in triangles {
        let [a, b, c] = triangle.map(|corner| corners[corner as usize]);
        let Some(normal) = (b - a).cross(&(c - a)).try_normalize(0.0) else { continue };
        for k in 0..3 {
            let (from, to) = (triangle[k], triangle[(k + 1) % 3]);
            let ends = (key(from).min(key(to)), key(from).max(key(to)));
            let edge = found.entry(ends).or_insert_with(|| {
                order.push(ends);
                (from, to, Vec::new())
            });
            edge.2.push(normal);
        }
    }
    let sharp = |normals: &[Vector3<f64>]| match normals {
        [one, other] => one.dot(other) < SHARP,
        _ => true,
    };
    let shown = order.iter().filter_map(|ends| found.get(ends)).filter(|(_, _, normals)| sharp(normals));
    shown.take(MOST).flat_map(|(from, to, _)| segment(&corners[*from as usize], &corners[*to as usize])).collect()
}
