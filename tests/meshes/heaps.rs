//! Lists of triangles for tests: floors, boxes, spheres and tori.

use nalgebra::Vector3;
use std::f64::consts::TAU;

/// List of triangles by their corners [m].
pub type Heap = Vec<[Vector3<f64>; 3]>;

/// Square of 2 n² triangles in the plane y = 0, from -1 m to `size` + 1 m along x and z.
pub fn floor(size: f64, n: u32) -> Heap {
    let at = |i: u32, j: u32| {
        let along = |k: u32| -1.0 + (size + 2.0) * f64::from(k) / f64::from(n);
        Vector3::new(along(i), 0.0, along(j))
    };
    let mut heap = Heap::new();
    for i in 0..n {
        for j in 0..n {
            heap.push([at(i, j), at(i, j + 1), at(i + 1, j + 1)]);
            heap.push([at(i, j), at(i + 1, j + 1), at(i + 1, j)]);
        }
    }
    heap
}

/// Faces of a box, each of 2 n² triangles.
pub fn block(center: Vector3<f64>, half: Vector3<f64>, n: u32) -> Heap {
    let mut heap = Heap::new();
    for axis in 0..3 {
        for side in [-1.0, 1.0] {
            let at = |i: u32, j: u32| {
                let along = |k: u32| if k == n { 1.0 } else { 2.0 * f64::from(k) / f64::from(n) - 1.0 };
                let mut unit = Vector3::zeros();
                unit[axis] = side;
                unit[(axis + 1) % 3] = along(i);
                unit[(axis + 2) % 3] = along(j);
                center + half.component_mul(&unit)
            };
            for i in 0..n {
                for j in 0..n {
                    heap.push([at(i, j), at(i + 1, j), at(i + 1, j + 1)]);
                    heap.push([at(i, j), at(i + 1, j + 1), at(i, j + 1)]);
                }
            }
        }
    }
    heap
}

/// Sphere about `center` of 20 · 4^n triangles: an icosahedron whose triangles are divided into four, n times.
pub fn ball(center: Vector3<f64>, radius: f64, n: u32) -> Heap {
    let golden = 0.5 * (1.0 + 5.0f64.sqrt());
    let corners: Vec<Vector3<f64>> = (0..3)
        .flat_map(|axis| {
            [(1.0, 1.0), (1.0, -1.0), (-1.0, 1.0), (-1.0, -1.0)].map(|(a, b)| {
                let mut corner = Vector3::zeros();
                corner[axis] = a;
                corner[(axis + 1) % 3] = b * golden;
                corner
            })
        })
        .collect();
    let near = |a: usize, b: usize| (corners[a] - corners[b]).norm() < 2.1;
    let mut heap = Heap::new();
    for a in 0..12 {
        for b in a + 1..12 {
            for c in b + 1..12 {
                if near(a, b) && near(b, c) && near(a, c) {
                    heap.push([corners[a], corners[b], corners[c]]);
                }
            }
        }
    }
    assert_eq!(heap.len(), 20);
    for _ in 0..n {
        let cut = |[a, b, c]: [Vector3<f64>; 3]| {
            // both triangles at an edge get the same midpoint, bit by bit
            let middle = |p: Vector3<f64>, q: Vector3<f64>| (p + q).normalize() * corners[0].norm();
            let (ab, bc, ca) = (middle(a, b), middle(b, c), middle(c, a));
            [[a, ab, ca], [ab, b, bc], [ca, bc, c], [ab, bc, ca]]
        };
        heap = heap.into_iter().flat_map(cut).collect();
    }
    heap.iter().map(|triangle| triangle.map(|corner| center + corner.normalize() * radius)).collect()
}

/// Torus about the y axis of 2 · `around` · `across` triangles.
pub fn torus(center: Vector3<f64>, [large, small]: [f64; 2], around: u32, across: u32) -> Heap {
    let at = |i: u32, j: u32| {
        let (i, j) = (f64::from(i % around) / f64::from(around) * TAU, f64::from(j % across) / f64::from(across) * TAU);
        let out = large + small * j.cos();
        center + Vector3::new(out * i.cos(), small * j.sin(), out * i.sin())
    };
    let mut heap = Heap::new();
    for i in 0..around {
        for j in 0..across {
            heap.push([at(i, j), at(i + 1, j), at(i + 1, j + 1)]);
            heap.push([at(i, j), at(i + 1, j + 1), at(i, j + 1)]);
        }
    }
    heap
}
