//! Times at which a polynomial in time rises to zero.

/// [s] first time t in `(0, until]` at which c_0 + c_1 t + c_2 t² + ... rises to zero from below; `None` without such a
/// time. `coefficients` begins with c_0. A polynomial that is not below zero at t = 0 describes a sphere that touches
/// already. The result is then 0 if c_1 exceeds `resolution`, the rounding error of c_1. Otherwise it is the time at
/// which the polynomial, after falling, reaches its first value again.
pub(super) fn way_out(coefficients: &[f64; 5], resolution: f64, until: f64) -> Option<f64> {
    let [at, rate, rest @ ..] = *coefficients;
    if at < 0.0 {
        return first_rise(coefficients, until);
    }
    if rate > resolution {
        return Some(0.0);
    }
    let [second, third, fourth] = rest;
    first_rise(&[rate.min(-resolution), second, third, fourth], until)
}

/// [s] first time in `(0, until]` at which a polynomial that is negative at the beginning rises to zero; `None` without
/// such a time.
fn first_rise(coefficients: &[f64], until: f64) -> Option<f64> {
    rises(coefficients, until).next()
}

/// [s] all times in `(0, until]` at which a polynomial rises to zero from below, in ascending order. At time 0 the
/// polynomial may be zero if it falls from there.
pub(super) fn rises(coefficients: &[f64], until: f64) -> impl Iterator<Item = f64> {
    let until = until.min(farthest(coefficients));
    let mut from = 0.0;
    let turns = crossings(&derivative(coefficients), until);
    turns.into_iter().chain([until]).filter_map(move |to| {
        let between = [from, to];
        from = to;
        let rises = value(coefficients, to) >= 0.0 && value(coefficients, between[0]) <= 0.0;
        rises.then(|| bisect(coefficients, between))
    })
}

/// [s] all times in `(0, until)` at which a polynomial changes sign, in ascending order. At most one of these times
/// lies between two successive sign changes of the derivative.
fn crossings(coefficients: &[f64], until: f64) -> Vec<f64> {
    if coefficients.len() < 2 {
        return Vec::new();
    }
    let (mut found, mut from) = (Vec::new(), 0.0);
    for to in crossings(&derivative(coefficients), until).into_iter().chain([until]) {
        if (value(coefficients, from) < 0.0) != (value(coefficients, to) < 0.0) {
            found.push(bisect(coefficients, [from, to]));
        }
        from = to;
    }
    found
}

/// Finds a zero of a polynomial in an interval, at whose ends the polynomial has different signs, by bisection. The
/// interval is halved until no floating-point number lies between its ends. Returns the later end.
fn bisect(coefficients: &[f64], [mut from, mut to]: [f64; 2]) -> f64 {
    let below = value(coefficients, from) < 0.0 || value(coefficients, to) > 0.0;
    loop {
        let middle = 0.5 * (from + to);
        if middle <= from || middle >= to {
            return to;
        }
        let past = value(coefficients, middle) >= 0.0;
        if past == below { to = middle } else { from = middle }
    }
}

fn value(coefficients: &[f64], t: f64) -> f64 {
    coefficients.iter().rev().fold(0.0, |sum, c| sum * t + c)
}

fn derivative(coefficients: &[f64]) -> Vec<f64> {
    (1u32..).zip(coefficients.iter().skip(1)).map(|(power, c)| f64::from(power) * c).collect()
}

/// Upper limit of the magnitude of all roots of a polynomial (Cauchy's bound).
fn farthest(coefficients: &[f64]) -> f64 {
    let Some(last) = coefficients.iter().rposition(|c| *c != 0.0) else { return 0.0 };
    1.0 + coefficients[..last].iter().map(|c| (c / coefficients[last]).abs()).fold(0.0, f64::max)
}
