//! Tree of boxes around the triangles of a mesh, and nearest points of single triangles. Both use the library parry.

use nalgebra::Vector3;
use parry3d_f64::bounding_volume::Aabb;
use parry3d_f64::math::Vector as ParryVector;
use parry3d_f64::partitioning::{Bvh, BvhBuildStrategy, BvhNode};
use parry3d_f64::query::PointQueryWithLocation;
use parry3d_f64::shape::{Triangle, TrianglePointLocation};

/// [-] rounding error of a squared distance, divided by this square. Because of this error, a box may appear to be
/// farther away than the triangle in it.
const ROUNDING: f64 = 1e-12;

/// Part of a triangle on which a point lies: face, edge or corner.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum TriangleFeature {
    /// The inside of the triangle.
    Face,
    /// The edge from the corner with this number (0 to 2) to the next corner.
    Edge(usize),
    /// The corner with the number 0, 1 or 2.
    Corner(usize),
}

/// Search tree of boxes around triangles or bodies.
#[derive(Clone)]
pub struct Tree(Bvh);

impl Tree {
    /// Makes a tree of triangles, which are given by their corners [m].
    pub fn new(triangles: impl Iterator<Item = [Vector3<f64>; 3]>) -> Self {
        let boxes: Vec<Aabb> = triangles.map(|corners| Aabb::from_points(corners.iter().map(to_parry))).collect();
        Self(Bvh::from_leaves(BvhBuildStrategy::Binned, &boxes))
    }

    /// Makes a tree of boxes, which are given by their lowest and highest corners [m].
    pub fn of_boxes(boxes: impl Iterator<Item = [Vector3<f64>; 2]>) -> Self {
        let boxes: Vec<Aabb> = boxes.map(|[low, high]| Aabb::new(to_parry(&low), to_parry(&high))).collect();
        Self(Bvh::from_leaves(BvhBuildStrategy::Binned, &boxes))
    }

    /// Calls `visit` with the index of every triangle or body whose box is within `reach` [m] of `point` [m] along all
    /// three axes.
    pub fn for_each_near(&self, point: &Vector3<f64>, reach: f64, mut visit: impl FnMut(u32)) {
        let half = ParryVector::splat(reach);
        let around = Aabb::new(to_parry(point) - half, to_parry(point) + half);
        self.0.intersect_aabb(&around).for_each(&mut visit);
    }

    /// Indices of the triangles whose box is within `reach` [m] of a point [m], up to rounding.
    pub fn within(&self, point: &Vector3<f64>, reach: f64) -> impl Iterator<Item = u32> + '_ {
        let (point, square) = (to_parry(point), reach * reach * (1.0 + ROUNDING));
        self.0.leaves(move |node| square_distance(node, point) <= square)
    }

    /// True if the box of any triangle is within `reach` [m] of `point` [m].
    pub fn is_near(&self, point: &Vector3<f64>, reach: f64) -> bool {
        let point = to_parry(point);
        self.0.leaves(|node| square_distance(node, point) <= reach * reach).next().is_some()
    }

    /// Calls `visit` with the index of every triangle whose box, enlarged by `reach` [m] on all sides, intersects the
    /// straight line from `from` to `to` [m].
    pub fn for_each_along(&self, from: &Vector3<f64>, to: &Vector3<f64>, reach: f64, visit: impl FnMut(u32)) {
        let (from, way) = (to_parry(from), to_parry(&(to - from)));
        let inverse = ParryVector::new(1.0 / way.x, 1.0 / way.y, 1.0 / way.z);
        let meets = |node: &BvhNode| {
            let (low, high) = (node.mins() - from, node.maxs() - from);
            let mut range = (0.0f64, 1.0f64);
            for axis in 0..3 {
                let (low, high) = (low[axis] - reach, high[axis] + reach);
                if way[axis] == 0.0 {
                    if low > 0.0 || high < 0.0 {
                        return false;
                    }
                    continue;
                }
                let (a, b) = (low * inverse[axis], high * inverse[axis]);
                range = (range.0.max(a.min(b)), range.1.min(a.max(b)));
            }
            range.0 <= range.1
        };
        self.0.leaves(meets).for_each(visit);
    }

    /// Finds the triangle nearest to a point [m], and its distance [m]; `None` if no distance is below `reach` [m].
    /// `distance` returns the distance [m] of a triangle from the point. It may return the distance that limits the
    /// search instead, if the triangle is not nearer. `distance` is not called for triangles whose box is farther away
    /// than the smallest distance found so far.
    pub fn closest(&self, point: &Vector3<f64>, reach: f64, distance: impl Fn(u32) -> f64) -> Option<(u32, f64)> {
        let point = to_parry(point);
        self.0.find_best(
            reach,
            |node: &BvhNode, _| square_distance(node, point).sqrt(),
            |triangle, _| Some(distance(triangle)),
        )
    }
}

/// Point [m] of a triangle that is nearest to `point` [m], and the part of the triangle (face, edge or corner) on which
/// it lies.
pub fn on_triangle(corners: &[Vector3<f64>; 3], point: &Vector3<f64>) -> (Vector3<f64>, TriangleFeature) {
    let [a, b, c] = corners.each_ref().map(to_parry);
    let (projection, location) = Triangle::new(a, b, c).project_local_point_and_get_location(to_parry(point), false);
    let nearest = Vector3::new(projection.point.x, projection.point.y, projection.point.z);
    let feature = match location {
        TrianglePointLocation::OnVertex(corner) => TriangleFeature::Corner(corner as usize),
        // parry numbers the edges in the order of this program: ab, bc, ca
        TrianglePointLocation::OnEdge(edge, _) => TriangleFeature::Edge(edge as usize),
        TrianglePointLocation::OnFace(..) | TrianglePointLocation::OnSolid => TriangleFeature::Face,
    };
    (nearest, feature)
}

/// [m²] squared distance from a point to the box of a node of the tree; 0 for a point in the box.
fn square_distance(node: &BvhNode, point: ParryVector) -> f64 {
    (node.mins() - point).max(point - node.maxs()).max(ParryVector::ZERO).length_squared()
}

fn to_parry(v: &Vector3<f64>) -> ParryVector {
    ParryVector::new(v.x, v.y, v.z)
}
