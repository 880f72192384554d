//! Turbulence that particles see: local statistics of the gas, and a Langevin equation for the gas velocity along the
//! path of a particle. `docs/design/turbulence.md` gives the reasons. k [m²/s²] is the turbulent kinetic energy, ε
//! [m²/s³] its dissipation rate. The slip is the velocity of a particle relative to the gas.

use super::k_epsilon::ChannelFlow;
use super::profile::Profile;
use super::table::VelocityTable;
use nalgebra::Vector3;
use rand::rngs::ChaCha8Rng;
use rand_distr::{Distribution, Exp1, StandardNormal};
use serde::{Deserialize, Serialize};
use std::sync::Arc;

/// [-] shortest turnover time k/ε of eddies, over the Kolmogorov time sqrt(ν/ε) with the kinematic viscosity ν (Durbin
/// 1991, Theor. Comput. Fluid Dyn. 3, 1).
const SHORTEST_TURNOVER: f64 = 6.0;

/// [-] largest time over the mean lifetime of eddies, for which a discrete random walk draws every eddy. Above it, the
/// mean of the fluctuation is nearly Gaussian: its fourth moment differs by the fraction 2 over this number.
const MOST_EDDIES: f64 = 1e4;

/// Number of strips into which the cross-section of the gas flow is divided, to compute means over the cross-section.
const STRIPS: usize = 2000;

/// Turbulence that particles see: statistics of the gas, and the law by which the gas velocity changes along the path
/// of a particle.
#[derive(Clone, Debug, Serialize)]
pub struct Turbulence {
    /// Local statistics of the gas velocity.
    pub statistics: TurbulenceStatistics,
    /// Law of the gas velocity along the path of a particle.
    pub law: EddyLaw,
    /// Constants of the Langevin equation, which both variants of [`EddyLaw`] use.
    pub langevin: Langevin,
}

/// Law by which the gas velocity changes along the path of a particle.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum EddyLaw {
    /// Langevin equation. The store of particles holds **s** = **u**/σ of each particle: the fluctuation **u** over its
    /// standard deviation σ.
    #[default]
    Langevin,
    /// Discrete random walk (Gosman and Ioannides 1983, J. Energy 7, 482): the fluctuation **u** [m/s], which the store
    /// holds, is constant until the eddy ends. Eddies have random lifetimes. The mean lifetime is the integral time
    /// along the slip ([`Langevin::times`]). A new **u** has the standard deviation σ at the particle. This law has no
    /// drift term, so light particles gather where the turbulence is weak.
    Eddy,
}

/// Standard deviation of the gas velocity, and turnover time of the eddies, as functions of position. The turbulence
/// is assumed isotropic.
#[derive(Clone, Debug, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum TurbulenceStatistics {
    /// Constant values: the standard deviation σ of a velocity component [m/s], and the turnover time k/ε [s].
    Uniform(f64, f64),
    /// Values that depend on the position through the [`depth`](Profile::depth) of the gas profile: the distance from
    /// the wall, or the coordinate y.
    Profile(Arc<TurbulenceProfile>),
}

/// Statistics of turbulence as functions of the [`depth`](Profile::depth) of a gas profile: the distance from the wall,
/// or the coordinate y.
#[derive(Clone, Debug, Serialize)]
pub struct TurbulenceProfile {
    /// [m/s] standard deviation σ of a component of the gas velocity.
    deviation: VelocityTable,
    /// [s] turnover time k/ε of the eddies.
    turnover: VelocityTable,
}

/// Statistics of the gas velocity at one position.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LocalTurbulence {
    /// [m/s] standard deviation σ = sqrt(2k/3) of each velocity component.
    pub deviation: f64,
    /// [1/s] gradient of the standard deviation σ at the position.
    pub gradient: Vector3<f64>,
    /// [s] Lagrangian integral time T_L of the gas.
    pub time: f64,
}

/// [s] turnover time k/ε of eddies, at least that of the smallest eddies. `k` is in m²/s², `epsilon` > 0 in m²/s³, and
/// the kinematic viscosity `viscosity` in m²/s.
fn turnover(k: f64, epsilon: f64, viscosity: f64) -> f64 {
    (k / epsilon).max(SHORTEST_TURNOVER * (viscosity / epsilon).sqrt())
}

impl TurbulenceStatistics {
    /// Homogeneous turbulence with the kinetic energy `k` [m²/s²] and the dissipation rate `epsilon` [m²/s³] > 0, in a
    /// gas of kinematic viscosity `viscosity` [m²/s].
    pub fn uniform(k: f64, epsilon: f64, viscosity: f64) -> Self {
        Self::Uniform((2.0 / 3.0 * k).sqrt(), turnover(k, epsilon, viscosity))
    }

    /// Statistics as monotone cubics through points (y [m], k [m²/s²], ε [m²/s³] > 0) in ascending order of y. Outside
    /// the points the values are constant. `viscosity` [m²/s] is the kinematic viscosity.
    ///
    /// # Errors
    ///
    /// Those of [`VelocityTable::new`].
    pub fn table(points: &[[f64; 3]], viscosity: f64) -> Result<Self, String> {
        let deviation: Vec<_> = points.iter().map(|[y, k, _]| (*y, (2.0 / 3.0 * k).sqrt())).collect();
        let time: Vec<_> = points.iter().map(|[y, k, epsilon]| (*y, turnover(*k, *epsilon, viscosity))).collect();
        let profile =
            TurbulenceProfile { deviation: VelocityTable::new(&deviation)?, turnover: VelocityTable::new(&time)? };
        Ok(Self::Profile(Arc::new(profile)))
    }

    /// Statistics of a solved channel or pipe flow. With wall functions, k and ε below the first node are those of the
    /// first node. Otherwise k is 0 at the wall.
    ///
    /// # Errors
    ///
    /// A solved flow gives no error. If its nodes were altered, the errors are those of [`VelocityTable::new`].
    pub fn of(flow: &ChannelFlow) -> Result<Self, String> {
        let nodes = flow.nodes.iter().map(|node| [node.y, node.k, node.epsilon]);
        let wall = flow.nodes.first().filter(|_| flow.model.reaches_the_wall()).map(|node| [0.0, 0.0, node.epsilon]);
        // the slopes are zero on the centre plane, so it has the values of the last node
        let centre = flow.nodes.last().map(|node| [0.5 * flow.height, node.k, node.epsilon]);
        let points: Vec<[f64; 3]> = wall.into_iter().chain(nodes).chain(centre).collect();
        Self::table(&points, flow.kinematic_viscosity)
    }
}

impl Turbulence {
    /// Statistics of the gas velocity at the position `place` [m], in a gas with the velocity profile `profile`.
    #[inline]
    pub fn at(&self, profile: &Profile, place: &Vector3<f64>) -> LocalTurbulence {
        let (deviation, gradient, turnover) = match &self.statistics {
            TurbulenceStatistics::Uniform(deviation, turnover) => (*deviation, Vector3::zeros(), *turnover),
            TurbulenceStatistics::Profile(of) => {
                let (depth, direction) = profile.depth(place);
                (of.deviation.value(depth), direction * of.deviation.slope(depth), of.turnover.value(depth))
            }
        };
        LocalTurbulence { deviation, gradient, time: self.langevin.share_of_turnover() * turnover }
    }

    /// [m/s] fluctuation **u** of the gas velocity that a particle sees. `eddy` is the value in the particle store:
    /// **u** over its standard deviation σ for the Langevin equation, or **u** itself for the discrete random walk.
    #[inline]
    pub fn seen(&self, eddy: &Vector3<f64>, local: &LocalTurbulence) -> Vector3<f64> {
        match self.law {
            EddyLaw::Langevin => eddy * local.deviation,
            EddyLaw::Eddy => *eddy,
        }
    }

    /// Statistics at the middles of narrow strips, on a line along y from wall to wall; in a pipe the line crosses the
    /// axis. `height` [m] is the height of the box. The number before each entry is the weight [-] of the strip in a
    /// mean over the cross-section.
    pub fn strips(&self, profile: &Profile, height: f64) -> impl Iterator<Item = (f64, LocalTurbulence)> {
        let [low, high] = profile.between(height);
        let axis = match profile {
            Profile::Pipe(pipe) => Some(pipe.center()),
            Profile::Uniform(_) | Profile::Tabulated(_) | Profile::Channel(_) | Profile::LogLaw(_) => None,
        };
        (0..STRIPS).map(move |strip| {
            let y = low + (high - low) * (strip as f64 + 0.5) / STRIPS as f64;
            let local = self.at(profile, &Vector3::new(axis.map_or(0.0, |[x, _]| x), y, 0.0));
            match axis {
                // the area of a ring is proportional to its radius; each ring has two strips
                Some([_, middle]) => (4.0 * (y - middle).abs() / ((high - low) * STRIPS as f64), local),
                None => (1.0 / STRIPS as f64, local),
            }
        })
    }

    /// [1/s] largest rate at which the fluctuation changes along the path of particles with the response time
    /// `response` [s], between the walls of the gas in a box of `height` [m]. The rates are the drift ∇σ/(1 + St) and
    /// the turnover 1/(T_L + τ) of eddies that particles follow. Here σ is the standard deviation of the gas velocity,
    /// T_L its integral time, τ the response time of the particles, and St = τ/T_L.
    pub fn largest_rate(&self, profile: &Profile, height: f64, response: f64) -> f64 {
        let rates = self.strips(profile, height).map(|(_, local)| {
            let slowest = local.time + response;
            (local.gradient.norm() * local.time / slowest).max(1.0 / slowest)
        });
        rates.fold(0.0, f64::max)
    }

    /// [m²/s²] variance of a velocity component of particles in the turbulence, as a mean over the cross-section and
    /// the three components, in a box of `height` [m]. It is σ² T_L/(T_L + τ) (Tchen 1947), with the response time τ =
    /// `response` [s] and the integral time T_L of the gas velocity that a particle sees. A slip speed `slip` [m/s]
    /// shortens T_L, because particles cross eddies.
    pub fn induced_variance(&self, profile: &Profile, height: f64, response: f64, slip: f64) -> f64 {
        let variances =
            self.strips(profile, height).filter(|(_, local)| local.deviation > 0.0).map(|(weight, local)| {
                let [along, across] = self.langevin.times(&local, slip * slip).map(|time| time / (time + response));
                weight * local.deviation * local.deviation * (along + 2.0 * across) / 3.0
            });
        variances.sum()
    }
}

/// Langevin equation for the fluctuation **u** of the gas velocity that a particle sees. With the standard deviation σ
/// of this velocity and **s** = **u**/σ, it is d**s** = (-**s**/T + ∇σ/(1 + St)) dt + sqrt(2/T) dW (Thomson 1987, J.
/// Fluid Mech. 180, 529; Simonin, Deutsch and Minier 1993, Appl. Sci. Res. 51, 275).
///
/// T is the integral time along the path of the particle ([`times`](Self::times)), and dW a random increment with the
/// variance dt. St = τ/T_L is the Stokes number with the response time τ of the particle and the integral time T_L of
/// the gas. The variance of each component of **u** stays σ² = 2k/3. The equation leaves out anisotropy and shear
/// stress of the turbulence, its production along the path of a particle, and correlations between particles.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Langevin {
    /// [-] Kolmogorov constant C_0 of the Lagrangian structure function, in T_L = (k/ε)/(1/2 + 3/4 C_0).
    pub kolmogorov_constant: f64,
    /// [-] ratio β = T_L/T_E of two integral times of the gas velocity: T_L along the path of the gas, and T_E at a
    /// point that moves with the mean flow. With 0, the crossing of eddies by a particle does not shorten the integral
    /// time.
    pub time_scale_ratio: f64,
}

impl Default for Langevin {
    fn default() -> Self {
        Self {
            // Pope 1994, Annu. Rev. Fluid Mech. 26, 23
            kolmogorov_constant: 2.1,
            // C_β = β² = 0.45 along the slip, and 4 β² = 1.8 across it: Deutsch and Simonin 1991
            time_scale_ratio: 0.670_820_393_249_936_9,
        }
    }
}

/// State of a particle that determines the change of the fluctuation it sees.
#[derive(Clone, Copy, Debug)]
pub struct EddySeen {
    /// [-] fluctuation **s** of the gas velocity over its standard deviation. For the discrete random walk, the
    /// fluctuation **u** itself [m/s].
    pub fluctuation: Vector3<f64>,
    /// [m/s] velocity of the particle relative to the mean gas velocity.
    pub velocity: Vector3<f64>,
    /// [s] response time τ of the particle.
    pub response: f64,
}

/// Direction of the slip of a particle, as a unit vector [-]; zero if there is no slip.
#[derive(Clone, Copy, Debug)]
struct AlongSlip(Vector3<f64>);

impl AlongSlip {
    /// Returns the vector `v` with its part along the slip multiplied by `along`, and its part across the slip by
    /// `across`.
    #[inline]
    fn scaled(&self, [along, across]: [f64; 2], v: Vector3<f64>) -> Vector3<f64> {
        v * across + self.0 * ((along - across) * self.0.dot(&v))
    }
}

/// Constants of the exact solution of the Langevin equation over a time h along one direction, with x = h/T and the
/// integral time T of the fluctuation that a particle sees.
#[derive(Clone, Copy, Debug)]
struct Relaxation {
    /// [-] share of the initial fluctuation that remains after the time h: exp(-x). Here x = h/T, with the integral
    /// time T of the fluctuation that the particle sees.
    kept: f64,
    /// [-] standard deviation of the fluctuation after the time h about its expected value: sqrt(1 - exp(-2x)). Here x
    /// is h over the integral time of the fluctuation.
    drawn: f64,
    /// [-] factor tanh(x/2)/x, where x = h/T is the time h over the integral time T of the fluctuation. This factor
    /// times the sum of the fluctuations at the start and at the end is the expected mean of the fluctuation over h.
    ends: f64,
    /// [-] standard deviation of the mean fluctuation over the time h, for given fluctuations at the start and at the
    /// end: sqrt(2 (x - 2 tanh(x/2)))/x. Here x is h over the integral time of the fluctuation.
    between: f64,
}

impl Relaxation {
    fn over(x: f64) -> Self {
        if x == 0.0 {
            return Self { kept: 1.0, drawn: 0.0, ends: 0.5, between: 0.0 };
        }
        let ends = (0.5 * x).tanh() / x;
        // rounding makes the difference inexact only for x below 1e-5, where the term itself is at most 1.3e-3
        Self {
            kept: (-x).exp(),
            drawn: (-(-2.0 * x).exp_m1()).sqrt(),
            ends,
            between: (2.0 * (1.0 - 2.0 * ends) / x).max(0.0).sqrt(),
        }
    }
}

/// [-] weight of the gas velocity at the end of a kick (change of velocities by drag) in the mean gas velocity to
/// which a particle responds. The weight is coth(r/2) - 2/r with r = `ratio` = h/τ, for a kick of length h and the
/// response time τ. It is 0 for long response times and 1 for short response times.
#[inline]
fn lateness(ratio: f64) -> f64 {
    // first term of the series; the next term is at most 6e-12
    if ratio < 1e-3 { ratio / 6.0 } else { 1.0 / (0.5 * ratio).tanh() - 2.0 / ratio }
}

impl Langevin {
    /// [-] Lagrangian integral time over the turnover time, T_L ε/k.
    #[inline]
    pub(super) fn share_of_turnover(&self) -> f64 {
        // Pope 1994, Annu. Rev. Fluid Mech. 26, 23: 1/2 + 3/4 C_0
        1.0 / (0.5 + 0.75 * self.kolmogorov_constant)
    }

    /// [s] integral times of the gas velocity that a particle sees, along its slip and across it. `square` [m²/s²] is
    /// the square of the slip speed (Csanady 1963, J. Atmos. Sci. 20, 201).
    #[inline]
    pub fn times(&self, local: &LocalTurbulence, square: f64) -> [f64; 2] {
        let crossing = self.time_scale_ratio * self.time_scale_ratio * square / (local.deviation * local.deviation);
        [local.time / (1.0 + crossing).sqrt(), local.time / (1.0 + 4.0 * crossing).sqrt()]
    }

    /// Integral times [s] of the gas velocity along and across the slip, which [`times`](Self::times) returns, and the
    /// direction of the slip. `slip` [m/s] is the velocity of the particle relative to the gas.
    #[inline]
    fn scales(&self, local: &LocalTurbulence, slip: Vector3<f64>) -> ([f64; 2], AlongSlip) {
        let square = slip.norm_squared();
        let direction = if square > 0.0 { slip / square.sqrt() } else { Vector3::zeros() };
        (self.times(local, square), AlongSlip(direction))
    }

    /// Advances the fluctuation that a particle sees at its position by `duration` [s], exactly. Returns the
    /// fluctuation at the end, and the weighted mean over this time to which the particle responds. Both are divided
    /// by the standard deviation σ of the gas velocity [-]. `noise` [-] contains independent Gaussian numbers of mean
    /// 0 and variance 1.
    ///
    /// The effect of an eddy on a particle decays with the response time τ of the particle: the weight of the time t
    /// before the end is exp(-t/τ). This weight is replaced by the sum of a constant weight and a weight at the end,
    /// with the same centre. The result is exact for long and for short response times.
    #[inline]
    pub fn advance(
        &self,
        seen: &EddySeen,
        local: &LocalTurbulence,
        duration: f64,
        noise: &[Vector3<f64>; 2],
    ) -> [Vector3<f64>; 2] {
        let s = seen.fluctuation;
        if local.deviation <= 0.0 {
            return [s; 2];
        }
        let following = |time: f64| time / (time + seen.response);
        // the slip decays during a kick, to zero for particles that follow the gas; `lasting` is the mean of this
        // decay over the kick
        let ratio = duration / seen.response;
        let lasting = if ratio > 0.0 { -(-ratio).exp_m1() / ratio } else { 1.0 };
        let guess = (seen.velocity - s * (local.deviation * following(local.time))) * lasting;
        let (first, split) = self.scales(local, guess);
        // the part of the slip that does not follow the fluctuation
        let slip = (seen.velocity - split.scaled(first.map(following), s) * local.deviation) * lasting;
        let (times, split) = self.scales(local, slip);
        let scaled = |factors: [f64; 2], v: Vector3<f64>| split.scaled(factors, v);
        let [along, across] = times.map(|time| Relaxation::over(duration / time));
        let drift = scaled(times, scaled(times.map(following), local.gradient));
        let end = drift + scaled([along.kept, across.kept], s - drift) + scaled([along.drawn, across.drawn], noise[0]);
        let mean = drift
            + scaled([along.ends, across.ends], s + end - 2.0 * drift)
            + scaled([along.between, across.between], noise[1]);
        let late = lateness(ratio);
        [end, mean * (1.0 - late) + end * late]
    }
}

impl Langevin {
    /// Advances the fluctuation **u** [m/s] of a discrete random walk by `duration` [s], exactly. Returns **u** at the
    /// end, and the weighted mean of **u** to which the particle responds. `seen.fluctuation` is **u** here. The
    /// lifetimes of eddies have an exponential distribution, so a new lifetime may be drawn at each call. The
    /// fluctuation then has the correlation exp(-t/T) of the Langevin equation, with the integral time T.
    ///
    /// The lifetime vanishes with the standard deviation of the gas velocity. If more than 10⁴ eddies are expected, the
    /// end and the mean are Gaussian numbers with the variances that follow from this correlation.
    pub fn walk(
        &self,
        seen: &EddySeen,
        local: &LocalTurbulence,
        duration: f64,
        random: &mut ChaCha8Rng,
    ) -> [Vector3<f64>; 2] {
        let slip = seen.velocity - seen.fluctuation;
        let [lifetime, _] =
            if local.deviation > 0.0 { self.times(local, slip.norm_squared()) } else { [local.time; 2] };
        let late = lateness(duration / seen.response);
        let lives = if duration > 0.0 { duration / lifetime } else { 0.0 };
        if lives > MOST_EDDIES || lives.is_nan() {
            let Relaxation { kept, drawn, ends, between } = Relaxation::over(lives);
            let mut draw = || -> Vector3<f64> { Vector3::from_fn(|_, _| StandardNormal.sample(random)) };
            let end = seen.fluctuation * kept + draw() * (drawn * local.deviation);
            let mean = (seen.fluctuation + end) * ends + draw() * (between * local.deviation);
            return [end, mean * (1.0 - late) + end * late];
        }
        let (mut left, mut eddy, mut sum) = (duration, seen.fluctuation, Vector3::zeros());
        loop {
            let life: f64 = lifetime * Distribution::<f64>::sample(&Exp1, random);
            if life >= left {
                sum += eddy * left;
                break;
            }
            sum += eddy * life;
            left -= life;
            eddy = Vector3::from_fn(|_, _| StandardNormal.sample(random)) * local.deviation;
        }
        let mean = if duration > 0.0 { sum / duration } else { eddy };
        [eddy, mean * (1.0 - late) + eddy * late]
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use rand::SeedableRng;

    /// Checks the moments of the end value and of the mean of a fluctuation over a time h, from a start of variance 1.
    /// Here x is h over the integral time T. The end has the variance 1 and the covariance exp(-x) with the start. The
    /// mean has the variance 2 (x - 1 + exp(-x))/x², and the covariance (1 - exp(-x))/x with the start and with the
    /// end. These are integrals of exp(-|t - t'|/T), computed independently of the tested formulas.
    #[test]
    fn a_step_has_the_moments_of_the_exponential_correlation() {
        for x in [1e-9_f64, 1e-4, 0.1, 1.0, 7.0, 1e3, f64::INFINITY] {
            let Relaxation { kept, drawn, ends, between } = Relaxation::over(x);
            let close = |name: &str, found: f64, wanted: f64| {
                // the expected values lose digits by cancellation; their error is at most the rounding over x²
                let tolerance = 1e-12 + 4.0 * f64::EPSILON / x.min(1.0).powi(2).max(1e-5);
                assert!((found - wanted).abs() < tolerance, "{name} at {x}: {found}, not {wanted}");
            };
            close("variance of the end", kept * kept + drawn * drawn, 1.0);
            let covariance = if x.is_finite() { -(-x).exp_m1() / x } else { 0.0 };
            close("start and mean", ends * (1.0 + kept), covariance);
            close("end and mean", ends * (kept + 1.0), covariance);
            if x > 1e-3 && x.is_finite() {
                let variance = 2.0 * (x + (-x).exp_m1()) / (x * x);
                close("variance of the mean", ends * ends * (2.0 + 2.0 * kept) + between * between, variance);
            }
        }
    }

    /// Tests that two steps of half the length equal one whole step. The expected values at the end agree, also with
    /// drift. For an infinite response time, the mean over the whole step is the average of the means over both halves.
    #[test]
    fn two_half_steps_are_a_whole_step() {
        let langevin = Langevin { time_scale_ratio: 0.0, ..Langevin::default() };
        let local = LocalTurbulence { deviation: 2.0, gradient: Vector3::new(0.0, 3.0, 0.0), time: 0.4 };
        let start = Vector3::new(1.0, -0.5, 0.2);
        for response in [0.1, f64::INFINITY] {
            let advance = |fluctuation, duration| {
                let seen = EddySeen { fluctuation, velocity: Vector3::zeros(), response };
                langevin.advance(&seen, &local, duration, &[Vector3::zeros(); 2])
            };
            let [whole, mean] = advance(start, 0.3);
            let [half, first] = advance(start, 0.15);
            let [end, second] = advance(half, 0.15);
            assert!((whole - end).norm() < 1e-14, "{whole} {end}");
            assert!(response.is_finite() || (mean - 0.5 * (first + second)).norm() < 1e-14);
        }
    }

    /// Checks a discrete random walk with very many eddies in one time, as where the turbulence vanishes. The mean has
    /// the variance 2 σ²/x, with the number x of lifetimes. It is measured to 1.5 %. No number of eddies takes long.
    #[test]
    fn a_walk_through_very_many_eddies_ends() {
        let langevin = Langevin { time_scale_ratio: 1.0, ..Langevin::default() };
        let mut random = ChaCha8Rng::seed_from_u64(1);
        let mut walk = |deviation: f64, speed: f64, time: f64| {
            let local = LocalTurbulence { deviation, gradient: Vector3::zeros(), time };
            let (fluctuation, velocity) = (Vector3::zeros(), Vector3::z() * speed);
            langevin.walk(&EddySeen { fluctuation, velocity, response: f64::INFINITY }, &local, 1.0, &mut random)
        };
        for deviation in [1e-300, 1e-100, 1e-12] {
            let [end, mean] = walk(deviation, 1.0, 0.1);
            assert!(end.norm() < 10.0 * deviation && mean.norm() < 1e-4 * deviation, "{deviation}: {end} {mean}");
        }
        assert_eq!(walk(0.0, 1.0, 0.0), [Vector3::zeros(); 2]);
        walk(1.0, f64::INFINITY, 0.1);
        assert!(walk(1.0, f64::NAN, 0.1)[0].x.is_nan());
        let (samples, lives) = (3000, 2e4);
        let square: f64 = (0..samples).map(|_| walk(2.0, 0.0, 1.0 / lives)[1].norm_squared()).sum();
        let variance = square / (3.0 * f64::from(samples));
        assert!((variance * lives / 8.0 - 1.0).abs() < 0.06, "{variance}");
    }

    /// Checks `lateness` by centres of weights. Here r is the duration of a kick over the response time, and z the
    /// time before the end of the kick over its duration. The weight exp(-r z) has its centre at z = 1/r - 1/(exp(r) -
    /// 1). A constant weight has its centre at 1/2, and a weight at the end at 0.
    #[test]
    fn the_mean_has_the_centre_of_the_response() {
        for ratio in [1e-9_f64, 9e-4, 0.01, 1.0, 30.0] {
            let centre = if ratio < 1e-3 { 0.5 - ratio / 12.0 } else { 1.0 / ratio - 1.0 / ratio.exp_m1() };
            assert!((0.5 * (1.0 - lateness(ratio)) - centre).abs() < 1e-11, "{ratio}");
        }
        assert_eq!(lateness(f64::INFINITY), 1.0);
    }
}
