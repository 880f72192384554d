//! A monotone cubic through tabulated points, evaluated in constant computing time.

use serde::Serialize;

/// Number of bins per given point in the index of a [`VelocityTable`], which divides the range of y into bins of equal
/// width. The search for the cubic piece at y begins with the piece at the lower edge of the bin. For evenly spaced
/// points most bins contain no point, so that the search ends there.
const BINS_PER_NODE: usize = 16;

/// Function u(y) through given points: piecewise cubic with continuous slope and no overshoot between points. The
/// units in this type are those of a velocity u; tables of a time or another quantity have other units. The scheme is
/// PCHIP: Fritsch and Butland 1984, slopes by the weighted harmonic mean of Brodlie. The function is constant outside
/// the points.
///
/// An index that divides the range of y into equal bins gives the cubic piece, so that an evaluation takes the same
/// computing time for every y. One evaluation is needed per particle and window (time between two exchanges of
/// momentum with the gas).
#[derive(Clone, Debug, Serialize)]
pub struct VelocityTable {
    pieces: Vec<CubicPiece>,
    /// Index in `pieces` of the cubic piece at the lower edge of each bin. The bins divide the range of y into equal
    /// parts.
    #[serde(skip)]
    index: Vec<u32>,
    /// [1/m] number of bins per length of the range of y.
    bins_per_length: f64,
    /// [m] first and last y of the given points.
    range: [f64; 2],
    /// [m/s] velocity u at the last of the given points.
    last: f64,
}

/// Cubic piece u = value + s (slope + s (square + s cube)) with s = y - start, for y from `start` to `end`.
#[derive(Clone, Copy, Debug, Serialize)]
struct CubicPiece {
    start: f64,
    end: f64,
    value: f64,
    slope: f64,
    square: f64,
    cube: f64,
}

impl VelocityTable {
    /// Makes a table from points (y [m], u [m/s]).
    ///
    /// # Errors
    ///
    /// Fewer than two points, a value that is not finite, or y that does not strictly increase.
    pub fn new(points: &[(f64, f64)]) -> Result<Self, String> {
        Self::with_end_slopes(points, [None, None])
    }

    /// Makes a table with given slopes [1/s] at the first and the last point; `None`: the slope is computed from the
    /// points.
    ///
    /// # Errors
    ///
    /// Errors of [`VelocityTable::new`].
    pub fn with_end_slopes(points: &[(f64, f64)], ends: [Option<f64>; 2]) -> Result<Self, String> {
        let (Some(first), Some(last)) = (points.first(), points.last()) else {
            return Err("a velocity table needs at least 2 points, it has none".into());
        };
        if points.len() < 2 {
            return Err("a velocity table needs at least 2 points, it has 1".into());
        }
        if let Some(bad) = points.iter().position(|(y, u)| !(y.is_finite() && u.is_finite())) {
            return Err(format!("point {} of the velocity table is not finite: {:?}", bad + 1, points[bad]));
        }
        if let Some(bad) = points.windows(2).position(|pair| pair[0].0 >= pair[1].0) {
            let (before, after) = (points[bad].0, points[bad + 1].0);
            return Err(format!(
                "y must increase in a velocity table; point {} has {after} m after {before} m",
                bad + 2
            ));
        }
        let slopes = slopes(points, ends);
        let pieces: Vec<CubicPiece> = points
            .windows(2)
            .zip(slopes.windows(2))
            .map(|(point, slope)| {
                let width = point[1].0 - point[0].0;
                let secant = (point[1].1 - point[0].1) / width;
                CubicPiece {
                    start: point[0].0,
                    end: point[1].0,
                    value: point[0].1,
                    slope: slope[0],
                    square: (3.0 * secant - 2.0 * slope[0] - slope[1]) / width,
                    cube: (slope[0] + slope[1] - 2.0 * secant) / (width * width),
                }
            })
            .collect();
        let bins = BINS_PER_NODE * points.len();
        let width = (last.0 - first.0) / bins as f64;
        let index = (0..bins)
            .map(|bin| {
                let y = first.0 + bin as f64 * width;
                pieces.partition_point(|piece| piece.start <= y).saturating_sub(1) as u32
            })
            .collect();
        Ok(Self { pieces, index, bins_per_length: 1.0 / width, range: [first.0, last.0], last: last.1 })
    }

    /// [m/s] velocity u at y [m]; outside the points it is the value at the first or the last point.
    #[inline]
    pub fn value(&self, y: f64) -> f64 {
        let [first, last] = self.range;
        if y <= first {
            return self.pieces[0].value;
        }
        if y >= last {
            return self.last;
        }
        let CubicPiece { start, value, slope, square, cube, .. } = *self.piece(y);
        let s = y - start;
        value + s * (slope + s * (square + s * cube))
    }

    /// [1/s] slope du/dy at y [m]; 0 outside the points.
    #[inline]
    pub fn slope(&self, y: f64) -> f64 {
        let [first, last] = self.range;
        if !(first..last).contains(&y) {
            return 0.0;
        }
        let CubicPiece { start, slope, square, cube, .. } = *self.piece(y);
        let s = y - start;
        slope + s * (2.0 * square + s * (3.0 * cube))
    }

    /// Cubic piece that contains y [m], which must be within the range of the points.
    #[inline]
    fn piece(&self, y: f64) -> &CubicPiece {
        // not-a-number leads to bin 0, and the result is then not-a-number
        let bin = (((y - self.range[0]) * self.bins_per_length) as u32 as usize).min(self.index.len() - 1);
        let mut pieces = &self.pieces[self.index[bin] as usize..];
        while pieces[0].end <= y {
            pieces = &pieces[1..];
        }
        &pieces[0]
    }

    /// [m²/s] integral of the velocity u over y from the first point to the last, exact for the cubics between points.
    pub fn integral(&self) -> f64 {
        self.pieces
            .iter()
            .map(|piece| {
                let s = piece.end - piece.start;
                s * (piece.value + s * (piece.slope / 2.0 + s * (piece.square / 3.0 + s * piece.cube / 4.0)))
            })
            .sum()
    }

    /// [m²/s] integral of u (1 - y/`end`) over the whole range of y, with the length `end` [m]. It is exact for the
    /// cubic pieces, by Gauss's rule with three points on each piece.
    pub fn integral_towards(&self, end: f64) -> f64 {
        let rule = [(-(0.6_f64.sqrt()), 5.0 / 18.0), (0.0, 8.0 / 18.0), (0.6_f64.sqrt(), 5.0 / 18.0)];
        self.pieces
            .iter()
            .map(|piece| {
                let width = piece.end - piece.start;
                let at = |place: f64| {
                    let s = 0.5 * width * (1.0 + place);
                    let value = piece.value + s * (piece.slope + s * (piece.square + s * piece.cube));
                    value * (1.0 - (piece.start + s) / end)
                };
                width * rule.iter().map(|(place, weight)| weight * at(*place)).sum::<f64>()
            })
            .sum()
    }

    /// [m/s] largest value of u. A monotone cubic takes its largest value at one of the given points.
    pub fn maximum(&self) -> f64 {
        self.pieces.iter().map(|piece| piece.value).fold(self.last, f64::max)
    }
}

/// [1/s] slopes at the points, for which every cubic piece is monotone (Fritsch and Butland 1984). The slope is 0 at
/// an extremum. Elsewhere it is the harmonic mean of the slopes of the two straight lines to the neighbouring points,
/// weighted by the distances to these points. At an end without a given slope, the slope follows from a one-sided
/// three-point formula, limited so that the piece is monotone.
fn slopes(points: &[(f64, f64)], ends: [Option<f64>; 2]) -> Vec<f64> {
    let width: Vec<f64> = points.windows(2).map(|p| p[1].0 - p[0].0).collect();
    let secant: Vec<f64> = points.windows(2).map(|p| (p[1].1 - p[0].1) / (p[1].0 - p[0].0)).collect();
    let end = |near: usize, far: usize| {
        let one_sided =
            ((2.0 * width[near] + width[far]) * secant[near] - width[near] * secant[far]) / (width[near] + width[far]);
        if one_sided * secant[near] <= 0.0 {
            0.0
        } else if secant[near] * secant[far] <= 0.0 && one_sided.abs() > 3.0 * secant[near].abs() {
            3.0 * secant[near] // three times the secant is the bound for a monotone piece, Fritsch and Carlson 1980
        } else {
            one_sided
        }
    };
    let last = width.len() - 1;
    let mut slopes = Vec::with_capacity(points.len());
    slopes.push(ends[0].unwrap_or_else(|| if last == 0 { secant[0] } else { end(0, 1) }));
    for i in 0..last {
        slopes.push(if secant[i] * secant[i + 1] <= 0.0 {
            0.0
        } else {
            let left = width[i] + 2.0 * width[i + 1];
            let right = 2.0 * width[i] + width[i + 1];
            (left + right) / (left / secant[i] + right / secant[i + 1])
        });
    }
    slopes.push(ends[1].unwrap_or_else(|| if last == 0 { secant[0] } else { end(last, last - 1) }));
    slopes
}
