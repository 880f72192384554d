//! Properties of impacts, computed from force and stored energy. Contact laws without closed forms use these functions.

use super::{Law, Spring};

/// Number of time steps in the time that an approach at constant speed takes from touch to the largest overlap. For
/// smooth forces, the relative error of the fourth-order method is below 1e-10.
const STEPS: f64 = 1000.0;
/// [-] largest duration of an impact, divided by the time that an approach at constant speed takes from touch to the
/// largest overlap. Longer impacts count as endless.
const ENDLESS: f64 = 100.0;
/// Number of overlaps at which the slope of the elastic force, or the stored energy, is evaluated.
const SAMPLES: u32 = 64;
/// [-] step of central differences over the overlap, relative to the overlap. It is chosen for small errors of both
/// rounding and curvature.
const DIFFERENCE: f64 = 1e-5;

/// Zero of a function that changes from negative to positive. The search begins at `guess` > 0, which may be far from
/// the zero. `None` if the function is negative up to 1e30 times the guess.
fn rising_zero(function: impl Fn(f64) -> f64, guess: f64) -> Option<f64> {
    let (mut low, mut high) = (guess, guess);
    while function(high) < 0.0 {
        high *= 2.0;
        if high > 1e30 * guess {
            return None;
        }
    }
    while function(low) > 0.0 && low > 1e-30 * guess {
        low *= 0.5;
    }
    for _ in 0..200 {
        let middle = 0.5 * (low + high);
        if function(middle) < 0.0 { low = middle } else { high = middle }
    }
    Some(high)
}

/// [m] overlap at which the stored energy equals the kinetic energy at a normal speed [m/s]. It is the largest overlap
/// of an impact without damping. `None` if the law cannot store this energy.
fn undamped_overlap<L: Law + ?Sized>(law: &L, spring: &Spring, speed: f64) -> Option<f64> {
    let energy = 0.5 * spring.effective_mass * speed * speed;
    rising_zero(|overlap| law.stored_energy(spring, overlap) - energy, 1e-6)
}

/// An impact of two bodies, integrated in time steps from touch on.
#[derive(Clone, Debug)]
pub struct IntegratedImpact {
    /// [s] time step of the integration.
    step: f64,
    /// Overlap [m] and rate of the overlap [m/s] at the start of each step, and at the end of the impact.
    states: Vec<[f64; 2]>,
    /// [s] duration of the impact: time from touch to the end of the overlap.
    duration: f64,
}

impl IntegratedImpact {
    /// Integrates the impact at normal speed `speed` > 0 [m/s] in time steps; `None` if the impact does not end.
    pub fn new<L: Law + ?Sized>(law: &L, spring: &Spring, speed: f64) -> Option<Self> {
        let depth = undamped_overlap(law, spring, speed)?;
        let step = depth / speed / STEPS;
        let rate = |[overlap, growth]: [f64; 2]| {
            let (elastic, viscous) = law.force(spring, overlap, -growth);
            [growth, -(elastic + viscous) / spring.effective_mass]
        };
        let advance = |state: [f64; 2], h: f64| {
            let along = |slope: [f64; 2], h: f64| [0, 1].map(|i| state[i] + h * slope[i]);
            let first = rate(state);
            let second = rate(along(first, 0.5 * h));
            let third = rate(along(second, 0.5 * h));
            let fourth = rate(along(third, h));
            [0, 1].map(|i| state[i] + h / 6.0 * (first[i] + 2.0 * second[i] + 2.0 * third[i] + fourth[i]))
        };
        let mut states = vec![[0.0, speed]];
        let mut state = states[0];
        while (states.len() as f64) < ENDLESS * STEPS {
            let next = advance(state, step);
            if next[0] <= 0.0 {
                // the last step is shortened so that the overlap at its end is zero
                let part = rising_zero(|part| -advance(state, part * step)[0], 0.5)?.min(1.0);
                let duration = ((states.len() - 1) as f64 + part) * step;
                states.push(advance(state, part * step));
                return Some(Self { step, states, duration });
            }
            state = next;
            states.push(state);
        }
        None
    }

    /// [s] time from touch to the end of the overlap.
    pub fn duration(&self) -> f64 {
        self.duration
    }

    /// [m/s] normal speed at which the two bodies separate after the impact.
    pub fn rebound_speed(&self) -> f64 {
        -self.states[self.states.len() - 1][1]
    }

    /// [m] largest overlap during the impact.
    pub fn greatest_overlap(&self) -> f64 {
        self.states.iter().fold(0.0, |deepest, state| deepest.max(state[0]))
    }

    /// Overlap [m] and rate of the overlap [m/s] at a time [s] after touch, interpolated linearly between the steps.
    pub fn at(&self, time: f64) -> (f64, f64) {
        let last = self.states.len() - 2;
        let first = ((time / self.step).max(0.0) as usize).min(last);
        let length = if first == last { self.duration - last as f64 * self.step } else { self.step };
        let part = ((time - first as f64 * self.step) / length).clamp(0.0, 1.0);
        let [overlap, growth] = [0, 1].map(|i| {
            let (from, to) = (self.states[first][i], self.states[first + 1][i]);
            from + part * (to - from)
        });
        (overlap, growth)
    }
}

/// [m] largest overlap of an impact at the normal speed `speed` [m/s], by integration in time steps. For an impact that
/// does not end, it is the overlap without damping. It is infinite if no overlap stores the kinetic energy of the
/// impact.
pub fn greatest_overlap<L: Law + ?Sized>(law: &L, spring: &Spring, speed: f64) -> f64 {
    match IntegratedImpact::new(law, spring, speed) {
        Some(impact) => impact.greatest_overlap(),
        None => undamped_overlap(law, spring, speed).unwrap_or(f64::INFINITY),
    }
}

/// Overlaps [m] at equal intervals, from one interval up to the largest overlap of undamped impacts at the normal speed
/// `speed` [m/s].
fn overlaps<L: Law + ?Sized>(law: &L, spring: &Spring, speed: f64) -> impl Iterator<Item = f64> {
    let deepest = undamped_overlap(law, spring, speed).unwrap_or(f64::INFINITY);
    (1..=SAMPLES).map(move |k| deepest * f64::from(k) / f64::from(SAMPLES))
}

/// [N/m] slope of the elastic force at an overlap [m].
fn slope<L: Law + ?Sized>(law: &L, spring: &Spring, overlap: f64) -> f64 {
    let force = |overlap: f64| law.force(spring, overlap, 0.0).0;
    let step = DIFFERENCE * overlap;
    (force(overlap + step) - force(overlap - step)) / (2.0 * step)
}

/// [1/s] highest angular frequency in an impact, as [`Law::frequency`] defines it, from slopes at `SAMPLES` overlaps.
pub fn frequency<L: Law + ?Sized>(law: &L, spring: &Spring, speed: f64) -> f64 {
    let squares = overlaps(law, spring, speed).map(|overlap| slope(law, spring, overlap) / spring.effective_mass);
    squares.fold(0.0, f64::max).sqrt()
}

/// [-] damping ratio as [`Law::damping_ratio`] defines it, from the viscous forces at `SAMPLES` overlaps.
pub fn damping_ratio<L: Law + ?Sized>(law: &L, spring: &Spring, speed: f64) -> f64 {
    let viscous = overlaps(law, spring, speed).map(|overlap| -law.force(spring, overlap, speed).1 / speed);
    viscous.fold(0.0, f64::max) / (2.0 * spring.effective_mass * law.frequency(spring, speed))
}

/// [m] length that [`Law::thermal_overlap`] defines, by Simpson's rule. It is infinite if no overlap stores 37 times
/// the energy `energy` [J].
pub fn thermal_overlap<L: Law + ?Sized>(law: &L, spring: &Spring, energy: f64) -> f64 {
    /// Ratio V/E above which the weights exp(-V/E) are negligible (below 1e-16). V is the stored energy, and E the
    /// energy scale `energy`.
    const NEGLIGIBLE: f64 = 37.0;
    /// Number of intervals of Simpson's rule.
    const INTERVALS: u32 = 2000;
    let Some(end) = rising_zero(|overlap| law.stored_energy(spring, overlap) - NEGLIGIBLE * energy, 1e-6) else {
        return f64::INFINITY;
    };
    let step = end / f64::from(INTERVALS);
    let weight = |k: u32| match k {
        0 | INTERVALS => 1.0,
        _ if k % 2 == 1 => 4.0,
        _ => 2.0,
    };
    let value = |k: u32| (-law.stored_energy(spring, f64::from(k) * step) / energy).exp();
    (0..=INTERVALS).map(|k| weight(k) * value(k)).sum::<f64>() * step / 3.0
}

/// [J] depth of the minimum of the stored energy, as [`Law::well_depth`] defines it, from the energies at `SAMPLES`
/// overlaps. It is infinite if the stored energy is negative at all overlaps.
pub fn well_depth<L: Law + ?Sized>(law: &L, spring: &Spring) -> f64 {
    let energy = |overlap: f64| law.stored_energy(spring, overlap);
    let Some(end) = rising_zero(energy, 1e-6) else { return f64::INFINITY };
    let within = (1..SAMPLES).map(|k| energy(end * f64::from(k) / f64::from(SAMPLES)));
    -within.fold(0.0, f64::min)
}

/// [m] overlap of a contact at rest with the normal force `force` [N], by bisection. It is 0 if `force` is not
/// positive, and infinite if the elastic force is below `force` at all overlaps.
pub fn static_overlap<L: Law + ?Sized>(law: &L, spring: &Spring, force: f64) -> f64 {
    if force <= 0.0 {
        return 0.0;
    }
    rising_zero(|overlap| law.force(spring, overlap, 0.0).0 - force, 1e-6).unwrap_or(f64::INFINITY)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::contact_law::{Bodies, ContactLaw, Hertz, LinearSpringDashpot, Parameter};
    use crate::scene::Elasticity;

    /// Law that defines only the four required functions of another law. All its other functions are numerical.
    #[derive(Debug)]
    struct Bare<L>(L);

    impl<L: Law> Law for Bare<L> {
        fn between(&self, bodies: &Bodies) -> Spring {
            self.0.between(bodies)
        }

        fn force(&self, spring: &Spring, overlap: f64, normal_velocity: f64) -> (f64, f64) {
            self.0.force(spring, overlap, normal_velocity)
        }

        fn stored_energy(&self, spring: &Spring, overlap: f64) -> f64 {
            self.0.stored_energy(spring, overlap)
        }

        fn parameters(&self) -> Vec<Parameter> {
            self.0.parameters()
        }
    }

    fn agree(law: &dyn Law, bare: &dyn Law, restitution: f64, speed: f64) {
        let spring = law.between(&Bodies {
            effective_mass: 5.2e-6,
            effective_radius: 0.5e-3,
            restitution,
            by_speed: None,
            elasticity: [None; 2],
            stiffness_ratio: 1.0,
        });
        let near = |name: &str, exact: f64, found: f64, tolerance: f64| {
            assert!(
                (found - exact).abs() <= tolerance * exact.abs(),
                "{law:?}, {restitution}: {name} {found} of {exact}"
            );
        };
        // Hertz's damping has an infinite slope at touch, which reduces the order of the integration method
        near("time", law.contact_time(&spring, speed), bare.contact_time(&spring, speed), 2e-4);
        near("overlap", law.greatest_overlap(&spring, speed), bare.greatest_overlap(&spring, speed), 1e-5);
        near("frequency", law.frequency(&spring, speed), bare.frequency(&spring, speed), 1e-6);
        near("damping", law.damping_ratio(&spring, speed), bare.damping_ratio(&spring, speed), 1e-6);
        let energy = 1e-3 * spring.effective_mass * speed * speed;
        near("thermal", law.thermal_overlap(&spring, energy), bare.thermal_overlap(&spring, energy), 1e-6);
        near("static", law.static_overlap(&spring, 1e-4), bare.static_overlap(&spring, 1e-4), 1e-12);
        let (exact, found) = (law.course(&spring, speed), bare.course(&spring, speed));
        let time = 0.3 * law.contact_time(&spring, speed);
        near("course", exact(time).0, found(time).0, 1e-3);
        let impact = IntegratedImpact::new(bare, &spring, speed).unwrap();
        near("rebound", restitution * speed, impact.rebound_speed(), 2e-4);
    }

    #[test]
    fn what_follows_from_force_and_energy_is_what_closed_forms_say() {
        let elasticity = Elasticity { youngs_modulus: 70e9, poissons_ratio: 0.22 };
        for restitution in [1.0, 0.9, 0.5] {
            for speed in [0.01, 1.0] {
                let linear = LinearSpringDashpot { stiffness: 1e5 };
                agree(&linear, &Bare(linear), restitution, speed);
                let hertz = Hertz { elasticity };
                agree(&hertz, &Bare(hertz), restitution, speed);
            }
        }
    }

    #[test]
    fn an_impact_that_does_not_end_is_said_not_to() {
        let law = ContactLaw::other(Bare(LinearSpringDashpot { stiffness: 1e3 }));
        let spring = Spring { effective_mass: 1.0, restitution: 0.0, stiffness: 1e3, dashpot: 1e3 };
        assert_eq!(law.contact_time(&spring, 1.0), f64::INFINITY);
        assert!(law.greatest_overlap(&spring, 1.0).is_finite());
    }

    /// Checks that a law of the calling program, made twice as stiff, equals a law of a case made twice as stiff.
    #[test]
    fn laws_of_the_callers_are_made_stiffer_and_compared_by_their_parameters() {
        let (linear, bare) =
            (LinearSpringDashpot { stiffness: 1e3 }, |k| ContactLaw::other(Bare(LinearSpringDashpot { stiffness: k })));
        let bodies = Bodies {
            effective_mass: 1.0,
            effective_radius: 1.0,
            restitution: 0.9,
            by_speed: None,
            elasticity: [None; 2],
            stiffness_ratio: 1.0,
        };
        assert_eq!(bare(1e3).stiffened(2.0).between(&bodies), linear.stiffened(2.0).between(&bodies));
        assert_eq!(bare(1e3).stiffened(2.0), bare(2e3));
        assert_ne!(bare(1e3), bare(2e3));
    }
}
