//! Orientation of neighbouring triangles: triangles are flipped until all neighbours face the same way.

use super::surface::{Edges, Findings, count};

/// Flips triangles until all neighbours face the same way. Stores in `findings` how many triangles were flipped, the
/// number of the first of them in the file, and the number of edges whose triangles cannot face the same way.
pub(super) fn face_alike(triangles: &mut [([u32; 3], usize)], edges: &Edges, findings: &mut Findings) {
    // neighbours of each triangle, each with a flag that is true if one of the two triangles must be flipped: both
    // list the two corners of their common edge in the same order
    let mut beside: Vec<Vec<(u32, bool)>> = vec![Vec::new(); triangles.len()];
    for there in edges.values() {
        if let [(a, of_a), (b, of_b)] = there[..] {
            let same = triangles[a as usize].0[of_a] == triangles[b as usize].0[of_b];
            beside[a as usize].push((b, same));
            beside[b as usize].push((a, same));
        }
    }
    let mut turn: Vec<Option<bool>> = vec![None; triangles.len()];
    let mut twisted = 0;
    for first in 0..triangles.len() {
        if turn[first].is_some() {
            continue;
        }
        turn[first] = Some(false);
        let mut part = vec![first];
        let mut next = 0;
        while next < part.len() {
            let at = part[next];
            next += 1;
            for &(other, same) in &beside[at] {
                let wanted = turn[at].map(|turned| turned != same);
                let other = other as usize;
                if turn[other].is_none() {
                    turn[other] = wanted;
                    part.push(other);
                } else if turn[other] != wanted {
                    twisted += 1;
                }
            }
        }
        keep_most(&mut turn, &part);
    }
    // each twisted edge was counted twice, once from each of its triangles
    findings.twisted_edges = twisted / 2;
    for (k, turned) in turn.iter().enumerate() {
        if *turned == Some(true) {
            let (corners, number) = &mut triangles[k];
            corners.swap(1, 2);
            count(&mut findings.turned, *number);
        }
    }
}

/// Inverts the marks in `turn` (true: the triangle must be flipped) of the connected triangles `part`, if more than
/// half of these triangles have the mark true. The majority of the triangles then keeps its orientation.
fn keep_most(turn: &mut [Option<bool>], part: &[usize]) {
    let turned = part.iter().filter(|k| turn[**k] == Some(true)).count();
    if 2 * turned > part.len() {
        for &k in part {
            turn[k] = turn[k].map(|turned| !turned);
        }
    }
}
