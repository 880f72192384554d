//! Error and cost of numerical methods: the Pareto front of their results, and the power law by which an error
//! decreases.

use serde::Serialize;

/// Power law y ∝ x^p that was fitted to several points.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct PowerLaw {
    /// [-] exponent p of the power law y ∝ x^p.
    pub exponent: f64,
    /// [-] standard error of the exponent, from the scatter of the logarithms about the fitted line.
    pub error: f64,
    /// Number of points to which the power law was fitted.
    pub points: usize,
}

/// Fits a power law to points (x, y) by least squares on the logarithms: ln y = p ln x + c. `None` with fewer than
/// three points, with a number that is not positive, or if all x are equal.
pub fn power_law(points: &[(f64, f64)]) -> Option<PowerLaw> {
    let count = points.len() as f64;
    if points.len() < 3 || points.iter().any(|(x, y)| !(x.ln().is_finite() && y.ln().is_finite())) {
        return None;
    }
    let logs: Vec<(f64, f64)> = points.iter().map(|(x, y)| (x.ln(), y.ln())).collect();
    let mean = |of: fn(&(f64, f64)) -> f64| logs.iter().map(of).sum::<f64>() / count;
    let (x, y) = (mean(|p| p.0), mean(|p| p.1));
    let spread: f64 = logs.iter().map(|p| (p.0 - x).powi(2)).sum();
    if spread <= 0.0 {
        return None;
    }
    let exponent = logs.iter().map(|p| (p.0 - x) * (p.1 - y)).sum::<f64>() / spread;
    let left: f64 = logs.iter().map(|p| (p.1 - y - exponent * (p.0 - x)).powi(2)).sum();
    Some(PowerLaw { exponent, error: (left / (count - 2.0) / spread).sqrt(), points: points.len() })
}

/// Indices of the points (cost, error) on the Pareto front, sorted by cost. A point is left out if another point has
/// both a cost and an error that are no larger, and one of them is smaller. Equal points are either all on the front or
/// all left out. Points with NaN are left out.
pub fn pareto_front(points: &[(f64, f64)]) -> Vec<usize> {
    let mut order: Vec<usize> = (0..points.len()).filter(|&k| !points[k].0.is_nan() && !points[k].1.is_nan()).collect();
    order.sort_by(|&a, &b| points[a].0.total_cmp(&points[b].0).then(points[a].1.total_cmp(&points[b].1)));
    let mut front: Vec<usize> = Vec::new();
    for k in order {
        let kept = front.last().is_none_or(|&last| points[k].1 < points[last].1 || points[k] == points[last]);
        if kept {
            front.push(k);
        }
    }
    front
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_exponent_of_a_power_law_comes_out_and_its_error_is_the_scatter() {
        let exact: Vec<(f64, f64)> = [5.0, 10.0, 20.0, 80.0].iter().map(|&x: &f64| (x, 3.0 * x.powi(-4))).collect();
        let fit = power_law(&exact).unwrap();
        assert!((fit.exponent + 4.0).abs() < 1e-12 && fit.error < 1e-12 && fit.points == 4, "{fit:?}");
        // by hand: ln x = -1, 0, 1 and ln y = 2.1, -0.2, -1.9 give slope -2, residuals 0.1, -0.2, 0.1, error
        // sqrt(0.06/1/2)
        let e = std::f64::consts::E;
        let rough = [(1.0 / e, 2.1f64.exp()), (1.0, (-0.2f64).exp()), (e, (-1.9f64).exp())];
        let fit = power_law(&rough).unwrap();
        assert!((fit.exponent + 2.0).abs() < 1e-12 && (fit.error - 0.03f64.sqrt()).abs() < 1e-12, "{fit:?}");
        assert_eq!(power_law(&rough[..2]), None);
        assert_eq!(power_law(&[(1.0, 1.0), (1.0, 2.0), (1.0, 3.0)]), None);
        assert_eq!(power_law(&[(1.0, 1.0), (2.0, 0.0), (3.0, 1.0)]), None);
        assert_eq!(power_law(&[(1.0, 1.0), (2.0, f64::NAN), (3.0, 1.0)]), None);
    }

    #[test]
    fn the_front_holds_what_nothing_beats() {
        //             0           1           2 beaten by 1  3           4 beaten by 3  5 = 3        6 unknown
        let points = [(1.0, 0.5), (2.0, 0.1), (3.0, 0.2), (4.0, 0.01), (4.0, 0.02), (4.0, 0.01), (0.5, f64::NAN)];
        assert_eq!(pareto_front(&points), [0, 1, 3, 5]);
        // an equal error at a higher cost is not on the front
        assert_eq!(pareto_front(&[(2.0, 0.1), (1.0, 0.1)]), [1]);
        assert_eq!(pareto_front(&[]), [0usize; 0]);
    }
}
