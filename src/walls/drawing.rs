//! The surfaces of walls as triangles, for pictures.

use super::round::{Frustum, RoundAxis};
use super::{Cavity, Hollow, Obstacle, Sides, WallGeometry};
use nalgebra::{Vector2, Vector3};
use std::f64::consts::TAU;

/// Number of sides with which round bodies are drawn.
const SIDES: u32 = 64;

/// Corners [m], and three corner indices for each triangle.
pub type Drawing = (Vec<Vector3<f64>>, Vec<[u32; 3]>);

impl WallGeometry {
    /// Name of the shape for a description of the scene.
    pub fn in_words(&self) -> String {
        match self {
            Self::Plane(_) => "plane".into(),
            Self::Obstacle(_) | Self::Frustum(Frustum { solid: true, .. }) => "solid body".into(),
            Self::Frustum(_) => "thin round shell, open at both ends".into(),
            Self::Hollow(hollow) => match hollow.room() {
                Cavity::Box { .. } => "hollow box with the particles inside".into(),
                Cavity::Sphere { .. } => "hollow sphere with the particles inside".into(),
                Cavity::ClosedCylinder(_) => "closed round vessel with the particles inside".into(),
                Cavity::Pipe { .. } => "pipe without ends with the particles inside".into(),
            },
            Self::Mesh(mesh) => {
                let count = mesh.triangles().1.len();
                let side = match mesh.sides() {
                    Sides::Outside => "solid body",
                    Sides::Inside => "vessel with the particles inside",
                    Sides::Both => "thin sheet",
                };
                let through = ["x", "y", "z"].into_iter().zip(mesh.spans()).filter(|(_, spans)| *spans);
                let through: Vec<&str> = through.map(|(name, _)| name).collect();
                let without_end = match through.is_empty() {
                    true => String::new(),
                    false => format!(", without end along {}", through.join(" and ")),
                };
                format!("{side} of {count} triangles{without_end}")
            }
            Self::Repeated(body) => body.shape().in_words(),
            Self::Other(_) => "shape of the caller's".into(),
        }
    }

    /// Surface of the wall as triangles; an endless pipe is drawn as long as the box, `size` [m]. Empty for planes,
    /// which are drawn to the edges of the box, and for shapes of the calling program.
    pub fn drawing(&self, size: &Vector3<f64>) -> Drawing {
        match self {
            Self::Plane(_) | Self::Other(_) => Drawing::default(),
            Self::Repeated(body) => body.shape().drawing(size),
            Self::Obstacle(obstacle) => obstacle.triangles(),
            Self::Frustum(frustum) => turned(&frustum.axle, &frustum.outline()),
            Self::Hollow(hollow) => inside(hollow, size),
            Self::Mesh(mesh) => {
                let (points, triangles) = mesh.triangles();
                (points.to_vec(), triangles.collect())
            }
        }
    }
}

fn inside(hollow: &Hollow, size: &Vector3<f64>) -> Drawing {
    match *hollow.room() {
        Cavity::Box { center, half_extents } => Obstacle::cuboid(center, half_extents).triangles(),
        Cavity::Sphere { center, radius } => Obstacle::sphere(center, radius).triangles(),
        Cavity::ClosedCylinder(can) => turned(&can.axle, &Frustum { solid: true, ..can }.outline()),
        Cavity::Pipe { axle, radius } => {
            let at = axle.center[axle.axis];
            turned(&axle, &[Vector2::new(radius, -at), Vector2::new(radius, size[axle.axis] - at)])
        }
    }
}

/// Surface of revolution of a line [m] in the half-plane about the axis.
fn turned(axle: &RoundAxis, outline: &[Vector2<f64>]) -> Drawing {
    let (mut corners, mut triangles) = (Vec::new(), Vec::new());
    for point in outline {
        for side in 0..SIDES {
            let (sin, cos) = (TAU * f64::from(side) / f64::from(SIDES)).sin_cos();
            let mut corner = axle.center;
            corner[(axle.axis + 1) % 3] += point.x * cos;
            corner[(axle.axis + 2) % 3] += point.x * sin;
            corner[axle.axis] += point.y;
            corners.push(corner);
        }
    }
    for (ring, ends) in outline.windows(2).enumerate() {
        for side in 0..SIDES {
            let next = (side + 1) % SIDES;
            let [low, high] = [ring as u32 * SIDES, (ring as u32 + 1) * SIDES];
            // at the axis a ring is one point
            if ends[0].x > 0.0 {
                triangles.push([low + side, low + next, high + next]);
            }
            if ends[1].x > 0.0 {
                triangles.push([low + side, high + next, high + side]);
            }
        }
    }
    (corners, triangles)
}
