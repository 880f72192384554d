//! Impact of two viscoelastic spheres as a function of one number, the damping number β.
//!
//! The units are the effective mass M, the speed of approach u and Hertz's constant k. The overlap x then obeys x'' =
//! -x^(3/2) - β sqrt(x) x' with the damping number β. At touch x = 0 and x' = 1. The impact ends when x = 0 again. With
//! w = sqrt(x), p = x' and the integration variable σ, defined by dt = 2 w dσ, the equations are polynomials: dw/dσ =
//! p, dp/dσ = -2 w² (w² + β p). So the classical Runge-Kutta method keeps its order at touch and at the end, where
//! sqrt(x) in the force would otherwise reduce it.

use std::sync::LazyLock;

/// [-] step of the integration variable σ, divided by the shortest scale of σ on which the state changes. The error of
/// the method is below 1e-9.
const STEP: f64 = 0.02;
/// [-] largest β/(1 + β) in the table of impacts, with the damping number β. This is β = 9, where the restitution e is
/// 9e-5.
const LARGEST: f64 = 0.9;
/// Number of intervals of the table of impacts. Cubic interpolation errs by less than 2e-9 of the values.
const INTERVALS: usize = 1024;

/// Impact of two viscoelastic spheres, in units of the mass M, the speed of approach u and Hertz's constant k.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ViscoelasticImpact {
    /// [-] restitution e: speed of rebound divided by speed of approach.
    pub restitution: f64,
    /// [-] contact time in units of (M²/(k² u))^(1/5).
    pub duration: f64,
    /// [-] largest overlap in units of (M u²/k)^(2/5).
    pub depth: f64,
}

/// State of an impact at one instant, in units of the mass M, the speed of approach u and Hertz's constant k.
#[derive(Clone, Copy)]
struct ImpactState {
    /// [-] square root of x, where x is the overlap in units of (M u²/k)^(2/5).
    root: f64,
    /// [-] rate of change of the overlap, divided by the speed of approach u; 1 at touch, negative during the rebound.
    rate: f64,
    time: f64,
}

impl ImpactState {
    /// State after a step `h` of the integration variable σ, by the classical Runge-Kutta method. `slope` returns the
    /// derivatives of a state with respect to σ.
    fn step(&self, h: f64, slope: impl Fn(&Self) -> Self) -> Self {
        let along = |slope: &Self, h: f64| Self {
            root: self.root + h * slope.root,
            rate: self.rate + h * slope.rate,
            time: self.time + h * slope.time,
        };
        let first = slope(self);
        let second = slope(&along(&first, 0.5 * h));
        let third = slope(&along(&second, 0.5 * h));
        let fourth = slope(&along(&third, h));
        let mean = |of: fn(&Self) -> f64| (of(&first) + 2.0 * (of(&second) + of(&third)) + of(&fourth)) / 6.0;
        along(&Self { root: mean(|s| s.root), rate: mean(|s| s.rate), time: mean(|s| s.time) }, h)
    }
}

/// Integrates the equation of motion of an impact with the damping β = `damping` [-].
fn integrate(damping: f64) -> ViscoelasticImpact {
    let slope = |s: &ImpactState| {
        let overlap = s.root * s.root;
        ImpactState { root: s.rate, rate: -2.0 * overlap * (overlap + damping * s.rate), time: 2.0 * s.root }
    };
    // derivatives with respect to another variable: `rate` for the step to the largest overlap, `root` for the step to
    // the end
    let over_rate = |s: &ImpactState| {
        let ImpactState { root, rate, time } = slope(s);
        ImpactState { root: root / rate, rate: 1.0, time: time / rate }
    };
    let over_root = |s: &ImpactState| {
        let ImpactState { root, rate, time } = slope(s);
        ImpactState { root: 1.0, rate: rate / root, time: time / root }
    };
    let mut now = ImpactState { root: 0.0, rate: 1.0, time: 0.0 };
    let mut depth = 0.0;
    // root of the overlap below which inertia determines the end of a strongly damped impact
    let least = (1.0 + damping).powi(-2);
    loop {
        let scale =
            2.0 * damping * now.root * now.root + (8.0 * now.root.powi(3)).sqrt() + now.rate.abs() / (now.root + least);
        let next = now.step(STEP / scale, slope);
        if now.rate > 0.0 && next.rate <= 0.0 {
            let root = now.step(-now.rate, over_rate).root;
            depth = root * root;
        }
        if next.root <= 0.0 {
            let end = now.step(-now.root, over_root);
            return ViscoelasticImpact { restitution: -end.rate, duration: end.time, depth };
        }
        now = next;
    }
}

/// Three values that the table stores for the damping number β = `damping`: (1 + β) e^(1/5) with the restitution e,
/// the duration, and the largest overlap times (1 + β)^(2/5). These values are smooth functions of β/(1 + β), so they
/// can be interpolated.
fn smooth(damping: f64) -> [f64; 3] {
    let ViscoelasticImpact { restitution, duration, depth } = integrate(damping);
    let stretched = 1.0 + damping;
    [restitution.powf(0.2) * stretched, duration, depth * stretched.powf(0.4)]
}

/// Table of the three functions of the damping number β that `smooth` returns, at equal intervals of β/(1 + β) from 0
/// to `LARGEST`. The table is made at first use.
static TABLE: LazyLock<Vec<[f64; 3]>> = LazyLock::new(|| {
    let share = |k: usize| LARGEST * k as f64 / INTERVALS as f64;
    let mut table: Vec<[f64; 3]> = (0..=INTERVALS).map(|k| smooth(share(k) / (1.0 - share(k)))).collect();
    // without damping e = 1 exactly
    table[0][0] = 1.0;
    table
});

/// Impact of two viscoelastic spheres with the damping number β = 3/2 A (k/M)^(2/5) u^(1/5) [-], β >= 0. A [s] is a
/// constant of the material, k Hertz's constant, M the effective mass, and u the normal speed.
///
/// For small β, e = 1 - C1 β + C2 β² - ... with C1 = 1.15344 and C2 = 3/5 C1² (Ramírez, Pöschel, Brilliantov and
/// Schwager 1999, Phys. Rev. E 60, 4465). The series diverges for fast impacts; this function is the solution of the
/// equation of motion, to 2e-9. An impact ends when the overlap is zero, so the force is attractive at the end. Beyond
/// β = 9, where e is below 1e-4, e falls as β^-5, and the duration is that of β = 9.
pub fn viscoelastic_impact(damping: f64) -> ViscoelasticImpact {
    let stretched = 1.0 + damping;
    let place = (damping / stretched).min(LARGEST) / LARGEST * INTERVALS as f64;
    // four points around the place, for cubic interpolation
    let first = (place as usize).clamp(1, INTERVALS - 2) - 1;
    let u = place - first as f64;
    let weights = [
        (u - 1.0) * (u - 2.0) * (u - 3.0) / -6.0,
        u * (u - 2.0) * (u - 3.0) / 2.0,
        u * (u - 1.0) * (u - 3.0) / -2.0,
        u * (u - 1.0) * (u - 2.0) / 6.0,
    ];
    let points = &TABLE[first..first + 4];
    let value = |k: usize| weights.iter().zip(points).map(|(weight, point)| weight * point[k]).sum::<f64>();
    ViscoelasticImpact {
        restitution: (value(0) / stretched).powi(5).min(1.0),
        duration: value(1),
        depth: value(2) / stretched.powf(0.4),
    }
}

/// [-] damping number β of viscoelastic spheres for which an impact has the restitution e = `restitution`, 0 < e <= 1.
pub fn damping_for(restitution: f64) -> f64 {
    let (mut low, mut high) = (0.0, 1.0);
    while viscoelastic_impact(high).restitution > restitution {
        high *= 2.0;
    }
    if restitution >= 1.0 {
        return 0.0;
    }
    // there are more halvings than bits in the fraction of a floating-point number
    for _ in 0..60 {
        let middle = 0.5 * (low + high);
        if viscoelastic_impact(middle).restitution > restitution { low = middle } else { high = middle }
    }
    high
}

#[cfg(test)]
mod tests {
    use super::*;

    /// C1 = 1.15344 of Ramírez et al. (1999), with more digits: 4/5 (5/4)^(3/5) B(3/5, 3/2) with the beta function B.
    /// It is the work of the viscous force along the undamped impact.
    const FIRST: f64 = 1.153_448_858;

    /// Compares with the series for small damping. The test uses the terms up to β². The error is then the next term,
    /// a_3 β³ with |a_3| < 1.
    #[test]
    fn slow_impacts_follow_the_series() {
        for damping in [1e-3, 1e-2, 0.05] {
            let series = 1.0 - FIRST * damping + 0.6 * FIRST * FIRST * damping * damping;
            let found = viscoelastic_impact(damping).restitution;
            assert!((found - series).abs() < damping.powi(3) + 1e-8, "{damping}: {found} against {series}");
        }
    }

    /// The undamped impact is that of Hertz: depth (5/4)^(2/5), duration 2.943275 depth (Johnson 1985, Eq. 11.24).
    #[test]
    fn without_damping_the_impact_is_that_of_hertz() {
        let found = viscoelastic_impact(0.0);
        assert_eq!(found.restitution, 1.0);
        assert!((found.depth / 1.25f64.powf(0.4) - 1.0).abs() < 1e-9);
        assert!((found.duration / (2.943_275 * found.depth) - 1.0).abs() < 1e-6);
    }

    /// Compares interpolated values of the table of impacts with solutions of the equation of motion at the same
    /// damping.
    #[test]
    fn the_table_holds_the_solution_of_the_equation_of_motion() {
        for k in 0..60 {
            let damping = 1e-3 * 1.16f64.powi(k);
            let (exact, found) = (integrate(damping), viscoelastic_impact(damping));
            for (name, exact, found) in [
                ("restitution", exact.restitution, found.restitution),
                ("duration", exact.duration, found.duration),
                ("depth", exact.depth, found.depth),
            ] {
                assert!((found / exact - 1.0).abs() < 2e-9, "{name}, {damping}: {found} of {exact}");
            }
        }
    }

    #[test]
    fn the_damping_of_a_restitution_gives_that_restitution() {
        for restitution in [1.0, 1.0 - 1e-9, 0.97, 0.5, 0.01, 1e-6] {
            let found = viscoelastic_impact(damping_for(restitution)).restitution;
            assert!((found / restitution - 1.0).abs() < 1e-12, "{restitution}: {found}");
        }
    }
}
