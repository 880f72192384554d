//! Cells around the points of a grid.

use crate::output::limits::{Cell, Class, Shade};

/// The ends of the cell around each of some ascending values: halfway to the next, on a logarithmic axis in its measure.
pub fn edges(values: &[f64], log: bool) -> Vec<(f64, f64)> {
    let from = |at: f64| if log { at.exp() } else { at };
    let at: Vec<f64> = values.iter().map(|value| if log { value.ln() } else { *value }).collect();
    let half = |k: usize, l: usize| 0.5 * (at[l] - at[k]);
    let last = at.len() - 1;
    let end = |k: usize| {
        let below = if k > 0 { half(k - 1, k) } else { half(0, 1.min(last)) };
        let above = if k < last { half(k, k + 1) } else { below };
        // what is never negative has no cells below zero
        let low = from(at[k] - below);
        (if values[k] >= 0.0 { low.max(0.0) } else { low }, from(at[k] + above))
    };
    (0..at.len()).map(end).collect()
}

/// The cells of a grid whose points run through `x` first; `class` gives that of the point's number.
pub fn cells(x: &[f64], y: &[f64], log: [bool; 2], class: impl Fn(usize) -> usize) -> Vec<Cell> {
    let (across, up) = (edges(x, log[0]), edges(y, log[1]));
    let points = (0..y.len()).flat_map(|j| (0..x.len()).map(move |i| (i, j)));
    points.enumerate().map(|(k, (i, j))| Cell { x: across[i], y: up[j], class: class(k) }).collect()
}

/// All points of a grid, through `x` first.
pub fn points(x: &[f64], y: &[f64]) -> Vec<(f64, f64)> {
    y.iter().flat_map(|&y| x.iter().map(move |&x| (x, y))).collect()
}

/// A class.
pub fn class(label: impl Into<String>, shade: Shade) -> Class {
    Class { label: label.into(), shade }
}

/// `count` values from `first` to `last`, equally apart.
pub fn even(first: f64, last: f64, count: usize) -> Vec<f64> {
    let step = (last - first) / (count - 1) as f64;
    // what is left of a decimal step after adding it up would show in tables
    (0..count).map(|k| ((first + step * k as f64) * 1e9).round() / 1e9).collect()
}

/// `count` values from `first` to `last`, in equal ratios.
pub fn ratios(first: f64, last: f64, count: usize) -> Vec<f64> {
    let ratio = (last / first).powf(1.0 / (count - 1) as f64);
    (0..count).map(|k| first * ratio.powi(k as i32)).collect()
}
