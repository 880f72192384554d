//! Comparison of two variants with few bodies, by position and velocity of each body at the same instants.
//!
//! Paths of colliding spheres are chaotic: small differences grow with every impact. The growth is measured with a twin
//! of the reference, a second run whose initial velocities are slightly disturbed. Paths are compared up to the instant
//! at which this disturbance has grown a thousandfold. Later differences are not due to the models. A variant is one of
//! the experiments of a case.

use super::Finding;
use super::words::{self, percent};
use crate::experiment::Experiment;
use crate::observe::PathSample;
use crate::outcome::Outcome;
use crate::output::Basis;
use crate::output::numbers::{quantity, significant};
use crate::placement::initial_state;
use crate::predict::contact::at_fastest_impacts;
use crate::runs::execute;
use crate::statistics::Answer;
use nalgebra::Vector3;

/// [-] change of the initial velocities in the disturbed second run of the reference, divided by the largest speed. It
/// is far above rounding and far below the differences that are compared.
const DISTURBANCE: f64 = 1e-6;

/// [-] largest growth of the disturbance of the initial velocities up to which paths are compared. If the disturbance
/// has grown more, even an initial difference of 1 % would have become larger than the speeds themselves.
const GROWTH: f64 = 1e3;

/// Positions and velocities of all particles at one recorded instant, sorted by id.
type Instant<'a> = &'a [PathSample];

/// Recorded states of all particles of a run: one list of states for each instant, in order of time.
fn instants(run: &Outcome) -> Vec<Instant<'_>> {
    run.paths.points.chunk_by(|a, b| a.time == b.time).collect()
}

/// True if the times `s` and `t` [s] are equal within a relative error of 1e-9.
fn near(s: f64, t: f64) -> bool {
    (s - t).abs() <= 1e-9 * s.abs().max(t.abs())
}

/// Recorded states of the runs `a` and `b`, one pair for each instant that both runs have recorded with the same number
/// of particles.
fn common<'a>(a: &'a Outcome, b: &'a Outcome) -> Vec<[Instant<'a>; 2]> {
    let others = instants(b);
    let same = |one: Instant<'a>| {
        let place = others.partition_point(|other| other[0].time < one[0].time * (1.0 - 1e-9));
        let other = others.get(place).filter(|other| near(other[0].time, one[0].time) && other.len() == one.len())?;
        Some([one, *other])
    };
    instants(a).into_iter().filter_map(same).collect()
}

/// [m/s] largest difference of a particle's velocities in two recorded states, with the id of this particle.
fn velocity_apart([a, b]: [Instant; 2]) -> (f64, u32) {
    let apart = a.iter().zip(b).map(|(p, q)| ((p.velocity - q.velocity).norm(), p.id));
    apart.fold((0.0, 0), |most, one| if one.0 > most.0 { one } else { most })
}

/// [m/s] largest speed of any particle of a run at any recorded instant.
fn largest_speed(run: &Outcome) -> f64 {
    run.paths.points.iter().map(|point| point.velocity.norm()).fold(0.0, f64::max)
}

/// True if the later paths of `reference` cannot be predicted, because a small disturbance of its initial velocities
/// grows a thousandfold during the run.
pub fn is_chaotic(reference: &Outcome) -> bool {
    predictable(reference).is_some()
}

/// Compares the paths of the particles of two variants (experiments of a case), as long as the paths of the reference
/// can be predicted. `margin` [-] is the largest accepted difference: of velocities divided by the largest speed, and
/// of positions divided by this speed times the elapsed time.
pub fn judge(variant: &Outcome, reference: &Outcome, margin: f64) -> Finding {
    let reason = "There are few particles: the path of each is compared.".to_owned();
    let unresolved = |sentence: String| Finding {
        answer: Answer::Unresolved,
        basis: Basis::Paths,
        sentence: format!("unresolved: {sentence}"),
        reason: reason.clone(),
        comparison: None,
    };
    if variant.initial_state_hash != reference.initial_state_hash {
        return unresolved("the two do not start from the same state, so that paths cannot be compared.".into());
    }
    let common = common(variant, reference);
    let (speed, rest) = (largest_speed(reference), reference.experiment.scene.rest_speed());
    if speed <= rest && largest_speed(variant) <= rest {
        let sentence = "equivalent: nothing moves in either.".into();
        return Finding { answer: Answer::Equivalent, basis: Basis::Paths, sentence, reason, comparison: None };
    }
    let speed = if speed > 0.0 { speed } else { largest_speed(variant) };
    let until = predictable(reference).unwrap_or(f64::INFINITY);
    if common.iter().all(|[a, _]| a[0].time == 0.0) {
        return unresolved("the two have no instant in common after the start.".into());
    }
    let before: Vec<&[Instant; 2]> =
        common.iter().filter(|[a, _]| a[0].time > 0.0 && a[0].time <= until * (1.0 + 1e-9)).collect();
    let Some(last) = before.last() else {
        return unresolved("a disturbance grows a thousandfold before the first common instant.".into());
    };
    let time = last[0][0].time;
    let impacts = reference.series.rows.iter().rev().find(|row| row.time <= time * (1.0 + 1e-9));
    let chaotic = until < common.last().map_or(0.0, |[a, _]| a[0].time);
    if chaotic && impacts.is_none_or(|row| row.pair_impacts + row.wall_impacts == 0) {
        return unresolved(format!(
            "beyond t = {}, before any impact, a disturbance of 10⁻⁶ grows a thousandfold.",
            quantity(until, "s", 3)
        ));
    }
    let until =
        if chaotic { ", the last instant before a disturbance of 10⁻⁶ has grown a thousandfold" } else { "" };
    let Some(apart) = Widest::of(&before, [variant, reference], margin * time) else {
        return unresolved("at every common instant all particles are in the course of an impact.".into());
    };
    let diameter = reference.experiment.scene.species.first().map_or(1.0, |species| species.diameter);
    let (velocity, place) = (apart.velocity, apart.place);
    let shares = [velocity.size / speed, place.size / (speed * time)];
    let answer = if shares.iter().all(|share| *share < margin) { Answer::Equivalent } else { Answer::Different };
    let at = |one: &Apart| format!("(particle {}, t = {})", one.id, quantity(one.time, "s", 3));
    let sizes = format!(
        "at most {} m/s, {} of the largest speed, in velocity {} and {} diameters in place {} up to t = {}{until}",
        significant(velocity.size, 3),
        percent(shares[0]),
        at(&velocity),
        significant(place.size / diameter, 2),
        at(&place),
        quantity(time, "s", 3)
    );
    let late = quantity(margin * time, "s", 2);
    let sentence = match answer {
        Answer::Equivalent => {
            format!(
                "equivalent within {}: the paths are apart by {sizes}, where one may be late by {late}.",
                words::margin(margin)
            )
        }
        Answer::Different | Answer::Unresolved => format!("different: the paths are apart by {sizes}."),
    };
    Finding { answer, basis: Basis::Paths, sentence, reason, comparison: None }
}

/// Deviation of one particle, in position or in velocity, between two runs.
#[derive(Clone, Copy, Default)]
struct Apart {
    /// [m] or [m/s] magnitude of the deviation: in metres for a position, in metres per second for a velocity.
    size: f64,
    id: u32,
    /// [s] simulated time of the deviation.
    time: f64,
}

/// Largest deviations between two runs, one in the velocity and one in the position of a particle, over all common
/// instants.
struct Widest {
    velocity: Apart,
    place: Apart,
}

/// Recorded instants of a run, with marks for the particles that are in an impact at each instant.
struct ImpactSpans<'a> {
    instants: Vec<Instant<'a>>,
    /// True if a particle is in an impact at an instant. The first index is that of the instant, the second that of
    /// the particle in the order of ids.
    during: Vec<Vec<bool>>,
}

impl<'a> ImpactSpans<'a> {
    /// Marks the instants at which a particle is in an impact: it touches another body, and the touch began at most
    /// `longest` [s] before or ends at most `longest` [s] later.
    fn of(run: &'a Outcome, longest: f64) -> Self {
        let instants = instants(run);
        let mut during: Vec<Vec<bool>> = instants.iter().map(|instant| vec![false; instant.len()]).collect();
        for k in 0..instants.first().map_or(0, |instant| instant.len()) {
            let touches = |at: &usize| instants[*at].get(k).is_some_and(|point| point.overlap > 0.0);
            let mut at = 0;
            while at < instants.len() {
                let end = (at..instants.len()).find(|at| !touches(at)).unwrap_or(instants.len());
                // a contact that exists at the first instant has no known beginning, and one that exists at the last
                // instant has no known end
                let began = if at == 0 { f64::NEG_INFINITY } else { instants[at][0].time };
                let ceases = instants.get(end).map_or(f64::INFINITY, |instant| instant[0].time);
                for (instant, row) in instants[at..end].iter().zip(&mut during[at..end]) {
                    let time = instant[0].time;
                    row[k] = time - began <= longest || ceases - time <= longest;
                }
                at = end.max(at + 1);
            }
        }
        Self { instants, during }
    }

    /// Range of indices of the recorded instants from the time `from` [s] to the time `to` [s].
    fn between(&self, from: f64, to: f64) -> std::ops::Range<usize> {
        let first = self.instants.partition_point(|instant| instant[0].time < from);
        first..first.max(self.instants.partition_point(|instant| instant[0].time <= to))
    }

    /// Index of the first recorded instant that is not before `time` [s]. If all instants are earlier, index of the
    /// last one.
    fn at(&self, time: f64) -> usize {
        self.instants.partition_point(|instant| instant[0].time < time).min(self.instants.len() - 1)
    }
}

impl Widest {
    /// Largest deviations of the `variant` from the `reference`; `before` has pairs of their states at common instants.
    /// `None` if every particle is in an impact at all these instants.
    ///
    /// A velocity is compared with the closest velocity that the particle has in the reference up to `late` [s] earlier
    /// or later, since an impact may be delayed. Particles in an impact (shortly after a touch begins, or shortly
    /// before it ends) are left out, because they differ by the contact itself.
    fn of(before: &[&[Instant; 2]], [variant, reference]: [&Outcome; 2], late: f64) -> Option<Self> {
        /// [-] longest time after the beginning or before the end of a touch in which particles count as in an impact,
        /// divided by the contact time of the fastest impacts. With Hertz's law slow impacts last longer: the contact
        /// time varies as the speed to the power −1/5.
        const SLOW: f64 = 3.0;
        let domain = &reference.experiment.scene.domain;
        let longest = SLOW * impact_time(&variant.experiment).max(impact_time(&reference.experiment));
        let [ours, theirs] = [variant, reference].map(|run| ImpactSpans::of(run, longest));
        let mut widest = Self { velocity: Apart::default(), place: Apart::default() };
        let mut compared = false;
        for [one, other] in before {
            let time = one[0].time;
            let (here, there) = (ours.at(time), theirs.at(other[0].time));
            let near = theirs.between(time - late, time + late).chain([there]);
            for (k, (p, q)) in one.iter().zip(*other).enumerate() {
                if ours.during[here][k] {
                    continue;
                }
                if !theirs.during[there][k] {
                    let size = domain.at(time).separation(&p.position, &q.position).norm();
                    widest.place = widest.place.or(Apart { size, id: p.id, time });
                }
                let others = near.clone().filter(|at| theirs.during[*at].get(k) == Some(&false));
                // velocities relative to the flow, since a body that has just crossed a sheared side differs by the
                // velocity of the image box
                let relative = |of: &PathSample| of.velocity - domain.mean_flow(&of.position);
                let sizes = others.map(|at| (relative(p) - relative(&theirs.instants[at][k])).norm());
                if let Some(size) = sizes.reduce(f64::min) {
                    compared = true;
                    widest.velocity = widest.velocity.or(Apart { size, id: p.id, time });
                }
            }
        }
        compared.then_some(widest)
    }
}

/// [s] longest contact time among all kinds of contacts (pairs of species, species at walls), each at its fastest
/// impacts. It is 0 for hard spheres, and if no contact has an end.
fn impact_time(experiment: &Experiment) -> f64 {
    let Some(law) = experiment.law() else { return 0.0 };
    let times = at_fastest_impacts(experiment).into_iter().map(|kind| kind.contact_time(&law));
    times.filter(|time| time.is_finite()).fold(0.0, f64::max)
}

impl Apart {
    /// Returns the deviation of larger magnitude: `self` or `other`.
    fn or(self, other: Self) -> Self {
        if other.size > self.size { other } else { self }
    }
}

/// [s] last recorded instant before a small disturbance of the initial velocities has grown a thousandfold. `None` if
/// the disturbance does not grow so much, or if it later falls below this limit again at half of the instants or more.
/// `None` also if the particles cannot be placed again.
fn predictable(reference: &Outcome) -> Option<f64> {
    let speed = largest_speed(reference);
    let mut start = initial_state(&reference.experiment).ok()?;
    let ids = start.id.clone();
    for (velocity, id) in start.velocity.iter_mut().zip(ids) {
        // directions are arbitrary, but differ from particle to particle
        let angle = f64::from(id);
        *velocity += DISTURBANCE * speed * Vector3::new(angle.sin(), (2.0 * angle).cos(), angle.cos()).normalize();
    }
    let (twin, _) = execute(&reference.experiment, start, &mut []);
    let grown = |both: &[Instant; 2]| velocity_apart(*both).0 > GROWTH * DISTURBANCE * speed;
    let common = common(reference, &twin);
    let first = common.iter().position(grown)?;
    // an impact that occurs a little earlier or later causes a difference at one instant only
    let lasting = common[first..].iter().filter(|both| grown(both)).count() * 2 > common.len() - first;
    lasting.then(|| common[first.saturating_sub(1)][0][0].time)
}

/// [s] time up to which the paths of a reference can be predicted; `None` if they can be predicted until the run ends.
pub struct Horizon(Option<f64>);

impl Horizon {
    /// True if the paths cannot be predicted until the run ends.
    pub fn is_chaotic(&self) -> bool {
        self.0.is_some()
    }
}

/// Finds the time up to which the paths of the reference can be predicted, by a second run with slightly disturbed
/// initial velocities.
pub fn horizon(reference: &Outcome) -> Horizon {
    Horizon(predictable(reference))
}

/// Largest velocity and displacement of any particle in a weighted sum of the states of several runs. The weights add
/// up to zero, so both are zero if all runs are equal.
pub struct Missed {
    /// [s] simulated time at which the states are summed.
    pub time: f64,
    /// [m/s] largest speed of a particle in the reference. If nothing moves in the reference, largest speed in the
    /// other runs.
    pub speed: f64,
    /// [m/s] largest velocity of a particle in the weighted sum of the runs, as a magnitude.
    pub velocity: f64,
    /// [m] largest displacement of a particle in the weighted sum of the runs, as a magnitude.
    pub place: f64,
}

/// Sums the states of several runs, each with its weight [-], particle by particle. The weights add up to zero. The
/// states are taken at the last common instant at which no particles touch or, without such an instant, at the last
/// common one.
///
/// # Errors
/// Returns an error if the runs start from different states, if nothing moves, or if no common instant lies in the time
/// for which the reference can be predicted.
pub fn apart(runs: &[(f64, &Outcome)], reference: &Outcome, horizon: &Horizon) -> Result<Missed, String> {
    if runs.iter().any(|(_, run)| run.initial_state_hash != reference.initial_state_hash) {
        return Err("it starts from another state, so that paths cannot be compared".into());
    }
    let all: Vec<Vec<[Instant; 2]>> = runs.iter().map(|(_, run)| common(run, reference)).collect();
    let until = horizon.0.unwrap_or(f64::INFINITY);
    let times = all.first().into_iter().flatten().map(|[one, _]| one[0].time);
    let seen = |time: f64| -> Option<Vec<[Instant; 2]>> {
        all.iter().map(|run| run.iter().find(|[one, _]| near(one[0].time, time)).copied()).collect()
    };
    let before = times.filter(|time| *time > 0.0 && *time <= until * (1.0 + 1e-9));
    let rows: Vec<Vec<[Instant; 2]>> = before.filter_map(seen).collect();
    let free =
        |row: &&Vec<[Instant; 2]>| row.iter().flatten().all(|instant| instant.iter().all(|point| point.overlap == 0.0));
    let last = rows.iter().rev().find(free).or(rows.last());
    let Some(last) = last else { return Err("a disturbance grows a thousandfold before the first instant".into()) };
    let domain = &reference.experiment.scene.domain;
    let (mut velocity, mut place) = (0.0_f64, 0.0_f64);
    for particle in 0..last[0][1].len() {
        let sum = |of: &dyn Fn(&PathSample, &PathSample) -> Vector3<f64>| -> f64 {
            let terms =
                last.iter().zip(runs).map(|([one, base], (weight, _))| *weight * of(&one[particle], &base[particle]));
            terms.sum::<Vector3<f64>>().norm()
        };
        velocity = velocity.max(sum(&|one, base| one.velocity - base.velocity));
        place = place.max(sum(&|one, base| domain.at(one.time).separation(&one.position, &base.position)));
    }
    let speed = largest_speed(reference);
    let speed = if speed > 0.0 { speed } else { runs.iter().map(|(_, run)| largest_speed(run)).fold(0.0, f64::max) };
    if speed == 0.0 {
        return Err("nothing moves".into());
    }
    Ok(Missed { time: last[0][0][0].time, speed, velocity, place })
}
