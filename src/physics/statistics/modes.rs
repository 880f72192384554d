//! Smooth shapes (polynomials) for profiles across a channel, and averages over positions that are mirror images about
//! the mid-plane.

/// Symmetry of a profile under a reflection at the mid-plane of the channel.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Parity {
    /// The reflection at the mid-plane does not change the profile: density, streamwise velocity, normal stresses.
    Even,
    /// The reflection at the mid-plane reverses the sign of the profile: shear stress, wall-normal velocity.
    Odd,
    /// The profile has no symmetry, because the mid-plane is no mirror plane of the scene.
    Neither,
}

/// Largest number of smooth shapes of one parity. This number is enough for smooth differences, and small enough for
/// one test.
const SHAPES: usize = 3;

/// Indices of the slices that remain if each of `count` slices is averaged with its mirror image about the mid-plane
/// (folding). Each remaining slice has a row with the weights of all slices.
pub fn fold(count: usize, parity: Parity) -> (Vec<usize>, Vec<Vec<f64>>) {
    let unit = |place: usize| {
        let mut row = vec![0.0; count];
        row[place] = 1.0;
        row
    };
    match parity {
        Parity::Neither => ((0..count).collect(), (0..count).map(unit).collect()),
        Parity::Even | Parity::Odd => {
            let sign = if parity == Parity::Even { 1.0 } else { -1.0 };
            // in the middle slice an odd profile is zero
            let half = if parity == Parity::Even { count.div_ceil(2) } else { count / 2 };
            let row = |place: usize| {
                let mut row = vec![0.0; count];
                row[place] += 0.5;
                row[count - 1 - place] += 0.5 * sign;
                row
            };
            ((0..half).collect(), (0..half).map(row).collect())
        }
    }
}

/// Legendre polynomials of the parity `parity` at the positions `places`, which extend from -1 to 1. Each row is one
/// polynomial; the first even one is constant. The polynomials are orthogonal on these positions, and their mean square
/// is one. With few positions there are fewer polynomials. The first `skip` polynomials are left out, because their
/// coefficients vanish.
pub fn shapes(places: &[f64], parity: Parity, skip: usize) -> Vec<Vec<f64>> {
    let (first, step, wanted) = match parity {
        Parity::Even => (0, 2, SHAPES),
        Parity::Odd => (1, 2, SHAPES),
        Parity::Neither => (0, 1, 2 * SHAPES - 1),
    };
    let count = places.len() as f64;
    let mut found: Vec<Vec<f64>> = Vec::new();
    for k in 0..wanted.min(places.len()) {
        let mut shape: Vec<f64> = places.iter().map(|place| place.powi(first + step * k as i32)).collect();
        for other in &found {
            let overlap = shape.iter().zip(other).map(|(s, o)| s * o).sum::<f64>() / count;
            shape.iter_mut().zip(other).for_each(|(s, o)| *s -= overlap * o);
        }
        let norm = (shape.iter().map(|s| s * s).sum::<f64>() / count).sqrt();
        // if positions coincide, a further polynomial consists of rounding errors
        if norm < 1e-9 {
            break;
        }
        found.push(shape.into_iter().map(|s| s / norm).collect());
    }
    found.drain(..skip.min(found.len()));
    found
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn folding_keeps_what_has_the_parity_and_takes_away_what_has_not() {
        for count in [1, 2, 5, 8] {
            let y: Vec<f64> = (0..count).map(|k| (2 * k + 1) as f64 / count as f64 - 1.0).collect();
            let apply = |row: &Vec<f64>, f: fn(f64) -> f64| row.iter().zip(&y).map(|(w, &y)| w * f(y)).sum::<f64>();
            for (parity, own, other) in [
                (Parity::Even, (|y| 1.0 + y * y) as fn(f64) -> f64, (|y| y - y.powi(3)) as fn(f64) -> f64),
                (Parity::Odd, |y| y - y.powi(3), |y| 1.0 + y * y),
            ] {
                let (places, rows) = fold(count, parity);
                assert_eq!(places.len(), rows.len());
                for (place, row) in places.iter().zip(&rows) {
                    assert!((apply(row, own) - own(y[*place])).abs() < 1e-14 && apply(row, other).abs() < 1e-14);
                }
            }
        }
    }

    #[test]
    fn shapes_are_orthogonal_and_begin_with_the_mean() {
        let y: Vec<f64> = (0..20).map(|k| (2 * k + 1) as f64 / 40.0 - 1.0).collect();
        for parity in [Parity::Even, Parity::Odd, Parity::Neither] {
            let shapes = shapes(&y, parity, 0);
            assert_eq!(shapes.len(), if parity == Parity::Neither { 5 } else { 3 });
            for (i, a) in shapes.iter().enumerate() {
                for (j, b) in shapes.iter().enumerate() {
                    let product = a.iter().zip(b).map(|(a, b)| a * b).sum::<f64>() / 20.0;
                    assert!((product - f64::from(u8::from(i == j))).abs() < 1e-12, "{i} {j}");
                }
            }
            assert_eq!(parity != Parity::Odd, shapes[0].iter().all(|s| (s - 1.0).abs() < 1e-12));
        }
        assert_eq!(super::shapes(&y[..1], Parity::Even, 0), [[1.0]]);
        assert!(super::shapes(&y[..1], Parity::Even, 1).is_empty() && super::shapes(&[], Parity::Even, 0).is_empty());
    }
}
