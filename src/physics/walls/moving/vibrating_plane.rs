//! Time of touch of a sphere and a plane that vibrates.
//!
//! The gap is g(t) = g0 + v t + a t²/2 - A (sin(ωt + ψ) - sin ψ), with the symbols of [`VibratingGap`]. The zeros of
//! g'' are known in closed form. Between two successive zeros of g'', g' is monotone and has at most one zero. Between
//! successive zeros of g', g is monotone. So every root of g lies in a known interval, and no root is missed.

use crate::walls::plane::first_closing;
use std::f64::consts::{PI, TAU};

/// Gap between a sphere in flight and a vibrating plane.
#[derive(Clone, Copy, Debug)]
pub struct VibratingGap {
    /// [m] gap g0 between sphere and plane at the beginning of the flight.
    pub gap: f64,
    /// [m/s] component v of the velocity of the sphere along the normal at the beginning.
    pub speed: f64,
    /// [m/s²] component a of gravity along the normal.
    pub acceleration: f64,
    /// [m] component A of the amplitude along the normal.
    pub amplitude: f64,
    /// [rad/s] angular frequency ω > 0 of the vibration.
    pub frequency: f64,
    /// [rad] phase ψ of the vibration at the beginning of the flight.
    pub phase: f64,
}

impl VibratingGap {
    /// [m] gap at time `t` [s]. The difference of the sines is a product, which loses no digits for small `t`.
    fn at(&self, t: f64) -> f64 {
        let half = 0.5 * self.frequency * t;
        let wall = 2.0 * self.amplitude * (self.phase + half).cos() * half.sin();
        self.gap + (self.speed + 0.5 * self.acceleration * t) * t - wall
    }

    /// [m/s] rate of change of the gap at time `t` [s]; negative while the sphere approaches the plane.
    fn rate(&self, t: f64) -> f64 {
        self.speed + self.acceleration * t - self.wall_speed(t)
    }

    /// [m/s] component of the velocity of the plane along the normal, at time `t` [s].
    fn wall_speed(&self, t: f64) -> f64 {
        self.amplitude * self.frequency * (self.frequency * t + self.phase).cos()
    }

    /// [m/s²] second derivative of the gap at time `t` [s].
    fn curvature(&self, t: f64) -> f64 {
        self.acceleration + self.amplitude * self.frequency.powi(2) * (self.frequency * t + self.phase).sin()
    }

    /// [s] first time in 0 ..= `until` at which the gap falls to zero; `None` if it does not. A sphere that overlaps
    /// the plane and approaches it touches at time 0. A rate of change below `resolution` [m/s] counts as rounding. A
    /// sphere in contact with so small a rate touches at time 0 if sphere and plane accelerate towards each other.
    pub fn first_touch(&self, until: f64, resolution: f64) -> Option<f64> {
        // an overlap without approach counts as rounding, as on a plane at rest
        let here = Self { gap: self.gap.max(0.0), ..*self };
        let mut from = here.out_of_reach_until()?;
        if self.gap <= 0.0 && self.rate(0.0) <= resolution {
            if self.rate(0.0) < -resolution || self.curvature(0.0) < 0.0 {
                return Some(0.0);
            }
            // the wall moves away from the sphere, at least up to the next zero of the second derivative of the gap
            from = here.next_inflection(0.0);
        }
        while from < until {
            let to = here.next_inflection(from).min(until);
            if let Some(touch) = here.touch_between(from, to) {
                return Some(touch);
            }
            if here.leaves(to) {
                return None;
            }
            from = to;
        }
        None
    }

    /// [m] height of the sphere, at time `t` [s], above the position at which it would touch the plane without
    /// displacement.
    fn height(&self, t: f64) -> f64 {
        self.gap + self.amplitude * self.phase.sin() + (self.speed + 0.5 * self.acceleration * t) * t
    }

    /// [s] time before which the sphere is certainly above the highest position of the plane; `None` if it is there at
    /// all times.
    fn out_of_reach_until(&self) -> Option<f64> {
        let beyond = self.height(0.0) - self.amplitude.abs();
        if beyond <= 0.0 {
            return Some(0.0);
        }
        first_closing(beyond, self.speed, self.acceleration)
    }

    /// True if the sphere is above the highest position of the plane at time `t` [s] and never comes back. Also true if
    /// the motions of sphere and plane have repeated themselves for a whole period.
    fn leaves(&self, t: f64) -> bool {
        let gone = self.height(t) > self.amplitude.abs() && self.speed + self.acceleration * t >= 0.0;
        let repeats = self.speed == 0.0 && self.acceleration == 0.0 && self.frequency * t > TAU;
        (gone && self.acceleration >= 0.0) || repeats
    }

    /// [s] first zero of the second derivative of the gap after `t` [s]; infinite if there is none.
    fn next_inflection(&self, t: f64) -> f64 {
        let sine = -self.acceleration / (self.amplitude * self.frequency.powi(2));
        if sine.is_nan() || sine.abs() >= 1.0 {
            return f64::INFINITY;
        }
        let angle = self.frequency * t + self.phase;
        let after = |zero: f64| {
            // a zero that rounding puts at `t` itself counts as passed
            let turns = ((angle - zero) / TAU + 1e-12).floor() + 1.0;
            (zero + TAU * turns - self.phase) / self.frequency
        };
        after(sine.asin()).min(after(PI - sine.asin())).max(t * (1.0 + f64::EPSILON))
    }

    /// [s] first touch between the times `from` and `to` [s], between which the rate of change of the gap is monotone;
    /// `None` without a touch.
    fn touch_between(&self, from: f64, to: f64) -> Option<f64> {
        let (before, after) = (self.rate(from), self.rate(to));
        let extreme = || {
            let sign = if before > 0.0 { 1.0 } else { -1.0 };
            bracketed_root(|t| (sign * self.rate(t), sign * self.curvature(t)), from, to)
        };
        let (from, to) = match (before > 0.0, after > 0.0) {
            (true, true) => return None,
            (false, false) => (from, to),
            (true, false) => (extreme(), to),
            (false, true) => (from, extreme()),
        };
        if self.at(from) <= 0.0 {
            return Some(from);
        }
        (self.at(to) <= 0.0).then(|| bracketed_root(|t| (self.at(t), self.rate(t)), from, to))
    }
}

/// Root of a function between `low`, where the function is positive, and `high`, where it is zero or negative.
/// `function` returns its value and its derivative. Newton's method finds the root, safeguarded by bisection.
fn bracketed_root(function: impl Fn(f64) -> (f64, f64), low: f64, high: f64) -> f64 {
    let (mut low, mut high) = (low, high);
    let mut t = 0.5 * (low + high);
    let mut length = high - low;
    while high - low > 2.0 * f64::EPSILON * high.abs() {
        let (value, slope) = function(t);
        if value > 0.0 {
            low = t
        } else {
            high = t
        }
        let newton = t - value / slope;
        if (newton - t).abs() <= f64::EPSILON * t.abs() {
            return t;
        }
        // Newton's step must stay in the bracket and be shorter than half the previous step; otherwise the bracket is
        // halved
        let next = if newton > low && newton < high && 2.0 * (newton - t).abs() < length {
            newton
        } else {
            0.5 * (low + high)
        };
        length = (next - t).abs();
        t = next;
    }
    high
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Gap of a sphere in uniform acceleration over a plate that vibrates with the amplitude 1 m and the angular
    /// frequency 1 rad/s.
    fn falling(gap: f64, speed: f64, acceleration: f64, phase: f64) -> VibratingGap {
        VibratingGap { gap, speed, acceleration, amplitude: 1.0, frequency: 1.0, phase }
    }

    /// First time [s] at which the gap is not positive, found in small steps by an independent search; `None` if there
    /// is none.
    fn by_steps(flight: &VibratingGap, until: f64) -> Option<f64> {
        const STEPS: usize = 400_000;
        let time = |k: usize| until * k as f64 / STEPS as f64;
        let plain = |t: f64| {
            let wall = flight.amplitude * ((flight.frequency * t + flight.phase).sin() - flight.phase.sin());
            flight.gap + flight.speed * t + 0.5 * flight.acceleration * t * t - wall
        };
        (1..=STEPS).find(|&k| plain(time(k)) <= 0.0).map(time)
    }

    #[test]
    fn the_first_touch_is_that_of_a_search_in_small_steps() {
        let mut touched = 0;
        for k in 0..2000 {
            // values without a pattern between the four numbers: multiples of irrational numbers, modulo 1
            let part = |factor: f64| (f64::from(k) * factor).fract();
            let (gap, speed) = (0.02 + 3.0 * part(0.618_034), 4.0 * part(0.414_214) - 2.0);
            let flight = falling(gap, speed, 1.2 * part(0.732_051) - 0.9, TAU * part(0.236_068));
            let (found, known) = (flight.first_touch(20.0, 0.0), by_steps(&flight, 20.0));
            // the step of the search is 5e-5 s; the search may miss overlaps that last for a shorter time
            match (found, known) {
                (Some(found), Some(known)) => assert!((known - found).abs() < 6e-5 || found < known, "{flight:?}"),
                (None, Some(known)) => panic!("missed {known}: {flight:?}"),
                (Some(_), None) | (None, None) => {}
            }
            if let Some(found) = found {
                touched += 1;
                // the gap at the touch is zero up to the rounding of its terms, which are below 300
                assert!(flight.at(found).abs() < 1e-13, "{flight:?}: {}", flight.at(found));
            }
        }
        assert!(touched > 1000, "{touched}");
    }

    #[test]
    fn a_sphere_that_leaves_does_not_touch_again_at_once() {
        // the plate moves up at 1 and the sphere at 1.5: the sphere comes back after about 2 (1.5 - 1)/(2 - 0), more
        // exactly where 0.5 t - t² + (t - sin t) = 0
        let flight = VibratingGap { speed: 1.5, ..falling(-1e-17, 0.0, -2.0, 0.0) };
        let touch = flight.first_touch(10.0, 1e-15).expect("comes back");
        assert!(touch > 0.4 && (1.5 * touch - touch * touch - touch.sin()).abs() < 1e-15, "{touch}");
        // at equal velocities sphere and plate are pressed together if the plate decelerates by less than gravity
        let resting = VibratingGap { speed: 0.5_f64.sqrt(), ..falling(0.0, 0.0, -1.0, 0.25 * PI) };
        assert_eq!(resting.first_touch(10.0, 1e-15), Some(0.0));
        for rounding in [-1e-16, 0.0, 1e-16] {
            let thrown = VibratingGap { acceleration: -0.5, speed: resting.wall_speed(0.0) + rounding, ..resting };
            assert!(thrown.first_touch(10.0, 1e-15).is_some_and(|touch| touch > 0.1), "{rounding}");
        }
    }
}
