//! Contacts of one sphere with one wall that numbers them by distance, the nearest first, as a mesh does. Two contacts
//! exchange their numbers when the nearer one becomes the farther one. Therefore the springs of a contact are found by
//! its normal, which changes little in a step, and not by its number.

use crate::encounter::{AtWall, Couple, Encounter, FrameTime, Other};
use crate::particles::Particles;
use crate::scene::Scene;
use nalgebra::Vector3;

/// [-] cosine of 45 degrees, the largest angle by which the normal of one contact may turn in a step. The value was
/// chosen for this program. The normals of two walls at a corner differ by more than this angle. In a time step that is
/// short compared with the contact, the normal turns by less.
const SAME: f64 = std::f64::consts::FRAC_1_SQRT_2;

/// True if the couple is a contact with a wall that numbers several contacts by distance.
pub fn is_numbered_by_distance(couple: &Couple, scene: &Scene) -> bool {
    let Other::Wall(at) = couple.other else { return false };
    let geometry = scene.walls[at.wall as usize].geometry.law();
    geometry.contacts() > 1 && geometry.is_nearest_first()
}

/// True if both couples are contacts of one particle with one wall.
pub fn are_of_one_wall(one: &Couple, other: &Couple) -> bool {
    match (one.other, other.other) {
        (Other::Wall(a), Other::Wall(b)) => one.i == other.i && a.wall == b.wall,
        _ => false,
    }
}

/// All encounters of a particle with a wall at the time `moment`, in the order of their numbers. `couple` is any
/// contact of this particle with this wall.
pub fn encounters(couple: &Couple, particles: &Particles, scene: &Scene, moment: FrameTime) -> Vec<Encounter> {
    let Other::Wall(AtWall { wall, .. }) = couple.other else { return vec![couple.meet(particles, scene, moment)] };
    let numbers = 0..scene.walls[wall as usize].geometry.contacts();
    let met = numbers.map(|which| Couple::at_wall(couple.i, AtWall { wall, which }).meet(particles, scene, moment));
    // a number without a contact has no normal
    met.take_while(|met| met.normal != Vector3::zeros()).collect()
}

/// For each contact, given by its earlier normal in `normals`, the index of its encounter in `now`; `None` if the
/// contact no longer exists. The nearest normals are matched first, and no encounter is used twice.
pub fn matched(normals: &[Vector3<f64>], now: &[Encounter]) -> Vec<Option<usize>> {
    let all = (0..normals.len()).flat_map(|k| (0..now.len()).map(move |n| (k, n)));
    let mut near: Vec<(f64, usize, usize)> = all.map(|(k, n)| (normals[k].dot(&now[n].normal), k, n)).collect();
    near.retain(|(cosine, ..)| *cosine > SAME);
    // pairs with equal cosines stay in the order of their numbers
    near.sort_by(|a, b| b.0.total_cmp(&a.0));
    let (mut of_contact, mut taken) = (vec![None; normals.len()], vec![false; now.len()]);
    for (_, k, n) in near {
        if of_contact[k].is_none() && !taken[n] {
            (of_contact[k], taken[n]) = (Some(n), true);
        }
    }
    of_contact
}

#[cfg(test)]
mod tests {
    use super::*;

    fn met(normal: Vector3<f64>) -> Encounter {
        Encounter { normal: normal.normalize(), ..Encounter::default() }
    }

    #[test]
    fn contacts_follow_their_normals() {
        let (x, y, z) = (Vector3::x(), Vector3::y(), Vector3::z());
        let tilted = (x + y * 0.3).normalize();
        // the contacts have exchanged their numbers, and the normal of one has turned a little
        assert_eq!(matched(&[x, y], &[met(y), met(tilted)]), [Some(1), Some(0)]);
        // one contact has ended, and another contact has begun
        assert_eq!(matched(&[x, y], &[met(z), met(y)]), [None, Some(1)]);
        // two contacts have become one, which continues the contact with the nearer normal
        let [a, b] = [x + y * 0.5, x - y * 0.4].map(|normal| normal.normalize());
        assert_eq!(matched(&[a, b], &[met(x)]), [None, Some(0)]);
        assert_eq!(matched(&[x], &[]), [None]);
    }
}
