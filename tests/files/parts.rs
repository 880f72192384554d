//! Bodies that tests write to files: cubes, vessels, prisms.

use nalgebra::{Rotation3, Vector3};

/// Triangles by their corners, in the unit of the file.
pub type Heap = Vec<[Vector3<f64>; 3]>;

/// OBJ file of a cube with edges of 10 about the origin; its faces are squares. The numbers of corners begin with 1.
pub const CUBE: &str = "v -5 -5 -5\nv 5 -5 -5\nv 5 5 -5\nv -5 5 -5\nv -5 -5 5\nv 5 -5 5\nv 5 5 5\nv -5 5 5\n\
    f 1 4 3 2\nf 5 6 7 8\nf 1 2 6 5\nf 2 3 7 6\nf 3 4 8 7\nf 1 5 8 4\n";

/// Corners of the outline of a comb.
pub const COMB: [[f64; 2]; 12] = [
    [0.0, 0.0],
    [9.0, 0.0],
    [9.0, 5.0],
    [7.0, 5.0],
    [7.0, 1.0],
    [5.0, 1.0],
    [5.0, 5.0],
    [3.0, 5.0],
    [3.0, 1.0],
    [1.0, 1.0],
    [1.0, 5.0],
    [0.0, 5.0],
];

/// Cube with the given half width about the origin, with outward normals.
pub fn cube(half: f64) -> [[Vector3<f64>; 3]; 12] {
    let corner =
        |k: usize| Vector3::from_fn(|axis, _| if [0x66, 0xcc, 0xf0][axis] >> k & 1 == 1 { half } else { -half });
    let faces = [[0, 3, 2, 1], [4, 5, 6, 7], [0, 1, 5, 4], [1, 2, 6, 5], [2, 3, 7, 6], [0, 4, 7, 3]];
    std::array::from_fn(|k| {
        let [a, b, c, d] = faces[k / 2].map(corner);
        if k % 2 == 0 { [a, b, c] } else { [a, c, d] }
    })
}

/// STL in text form: a solid of this name, with seven lines per triangle.
pub fn text(name: &str, heap: &[[Vector3<f64>; 3]]) -> Vec<u8> {
    let mut text = format!("solid {name}\n");
    for triangle in heap {
        text += "facet normal 0 0 0\n outer loop\n";
        for corner in triangle {
            text += &format!("  vertex {} {} {}\n", short(corner.x), short(corner.y), short(corner.z));
        }
        text += " endloop\nendfacet\n";
    }
    (text + &format!("endsolid {name}\n")).into_bytes()
}

/// Number with at most five decimals, without zeros at the end.
fn short(value: f64) -> String {
    ((value * 1e5).round() / 1e5).to_string()
}

/// STL in binary form with the given header.
pub fn binary(head: &[u8], heap: &[[Vector3<f64>; 3]]) -> Vec<u8> {
    let mut bytes = head.to_vec();
    bytes.resize(80, 0);
    bytes.extend((heap.len() as u32).to_le_bytes());
    for triangle in heap {
        bytes.extend([0; 12]);
        bytes.extend(triangle.iter().flatten().flat_map(|value| (*value as f32).to_le_bytes()));
        bytes.extend([0; 2]);
    }
    bytes
}

/// OBJ file of a prism over a counter-clockwise outline, turned by an angle. Each end of the prism is one polygon.
pub fn prism(outline: &[[f64; 2]], height: f64, angle: f64) -> Vec<u8> {
    let turn = Rotation3::from_euler_angles(angle, 0.4 * angle, -0.7 * angle);
    let mut text = String::new();
    for z in [0.0, height] {
        for [x, y] in outline {
            let corner = turn * Vector3::new(*x, *y, z);
            text += &format!("v {} {} {}\n", corner.x, corner.y, corner.z);
        }
    }
    let count = outline.len();
    let ring = |numbers: Vec<usize>| numbers.iter().map(|number| format!(" {number}")).collect::<String>();
    text += &format!("f{}\n", ring((1..=count).rev().collect()));
    text += &format!("f{}\n", ring((count + 1..=2 * count).collect()));
    for k in 0..count {
        let next = (k + 1) % count;
        // the line to a hole and back is not a side of the prism
        let way = (0..count).any(|other| outline[other] == outline[next] && outline[(other + 1) % count] == outline[k]);
        if !way {
            text += &format!("f {} {} {} {}\n", k + 1, next + 1, count + next + 1, count + k + 1);
        }
    }
    text.into_bytes()
}
