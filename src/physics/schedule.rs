//! Schedule of a run: the lengths of windows and the times of samples. A window is the time between two exchanges of
//! momentum with the gas (drag kicks). At a sample, measurements are taken. The agitation is the random motion of the
//! particles: the root mean square of a velocity component about its mean.
//!
//! The schedule depends on the scene. It does not depend on the model, except with servo walls, which move to keep the
//! pressure on them. So, without servo walls, all engines split drag from motion in the same way, and take samples at
//! the same times. Windows may become longer during a run if drag is certain to slow the particles down. The slowing is
//! computed from the drag law alone, the same in every model, and not from the moving particles.

mod heat;
mod inlets;
mod orbit;
mod position;
mod servo;
mod slowing;

pub use heat::longest_for_thermostat;
pub use inlets::longest_for_inlets;
pub use position::SchedulePosition;
pub use servo::{impedance, longest_for_servo};

use crate::experiment::{Amount, Experiment, Population};
use crate::fluid::Profile;
use crate::predict::contact::AGITATION;
use crate::predict::flow::terminal_slip;
use crate::scene::{Scene, Species};
use heat::heated_rate;
use nalgebra::Vector3;
use serde::{Deserialize, Serialize};
use slowing::Slowing;
use std::f64::consts::PI;

/// [-] largest allowed relative error of the mean velocity and of the agitation (random motion of the particles) by the
/// splitting of drag from motion: drag acts only in kicks between windows. Standard errors of long runs are ten times
/// as large.
pub const SPLITTING: f64 = 1e-4;

/// [-] largest allowed relative error of the response of a single particle to the gas by the splitting of drag from
/// motion: drag acts only in kicks between windows. It is smaller than `SPLITTING`, because a single particle has no
/// scatter that hides the error.
pub const SPLITTING_ALONE: f64 = 1e-5;

/// [-] largest distance between the computed path of a particle within a window (time between two kicks) and the exact
/// parabola, divided by the smallest diameter. The value is that of [`SPLITTING_ALONE`].
const SAG: f64 = 1e-5;

/// Smallest number of samples (measurements) in a run without drag, if the case (input file) gives neither the window
/// nor the time between samples. Such a run has at least as many windows.
const PIECES: f64 = 200.0;

/// Number of collisions of each particle between two samples (measurements), in an elastic or heated gas without drag.
/// After this number of collisions the velocities are independent, and the cost of a sample is small compared with that
/// of the collisions.
const COLLISIONS: f64 = 5.0;

/// Largest number of samples (measurements) in an elastic or heated gas without drag. More samples would take much
/// memory and add little information.
const MOST_SAMPLES: f64 = 1e5;

/// Largest number of particles whose paths are stored; more paths could not be distinguished in a picture.
pub const MOST_FOLLOWED: usize = 50;

/// Number of rows of a curve over time, if variants (runs that are compared) have different sample times and share
/// common instants. `ROWS_OF_FEW` is for runs of at most `MOST_FOLLOWED` particles, whose paths are stored.
const ROWS: f64 = 200.0;
const ROWS_OF_FEW: f64 = 1000.0;

/// Number of samples (measurements) in one response time of drag. It is so large that velocities change little between
/// two samples.
const SAMPLES_PER_RESPONSE: f64 = 20.0;

/// Largest number of times that the length of windows (times between two exchanges with the gas) may be doubled during
/// a run, after drag has slowed the particles.
const DOUBLINGS: usize = 4;

/// [-] largest length of a window (time between two exchanges with the gas) that has been made longer during a run,
/// divided by the duration of the run. Curves over time would show steps if windows were longer.
const SHARE: f64 = 1e-3;

/// [-] smallest share of the windows (times between two exchanges with the gas) that must be saved by making windows
/// longer during the run. If fewer are saved, all windows keep one length.
const WORTH: f64 = 0.1;

/// Windows of a run (times between two exchanges with the gas) and samples (measurements) at the ends of some windows.
/// Either all windows have one length, or the windows become longer during the run: two, four, eight or sixteen of the
/// shortest are merged into one.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Schedule {
    /// [s] length h of a window (time between two exchanges with the gas). If windows become longer during the run, it
    /// is the length of the first windows, which are the shortest.
    pub window: f64,
    /// Number of windows between two samples (measurements), counted in the shortest windows of the run.
    pub windows_per_sample: u64,
    /// Number of samples (measurements) of the run, not counting the sample at its start.
    pub samples: u64,
    /// Numbers of the samples (measurements) from which on two, four, eight and sixteen of the shortest windows are
    /// merged into one window. `None` if the run has no windows of that length.
    pub longer: [Option<u64>; DOUBLINGS],
    /// [s] interval between the instants at which all particles are written or curves are compared. The first interval
    /// begins at the start of the run. A window (time between two exchanges with the gas) that contains such an instant
    /// is divided there. `None` if there are no such instants.
    pub instants: Option<f64>,
}

/// Next piece of a run through which an engine advances without interruption.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum ScheduleStep {
    /// This number of whole windows (times between two exchanges with the gas). The last of them ends at the next
    /// sample (measurement), or where the window begins that contains an instant of output.
    Windows(u64),
    /// A part of a window (time between two exchanges with the gas), up to an instant [s] within the window, such as
    /// one at which the particles are written.
    ToInstant(f64),
    /// The rest of a window (time between two exchanges with the gas), up to its end at this time [s].
    ToEnd(f64),
}

impl Schedule {
    /// Creates a schedule of `samples` samples (measurements) with `windows_per_sample` windows from one sample to the
    /// next. All windows have the length `window` [s].
    pub fn even(window: f64, windows_per_sample: u64, samples: u64) -> Self {
        Self { window, windows_per_sample, samples, ..Self::default() }
    }

    /// Schedule of an experiment. The experiment can give the length of the longest window (time between two exchanges
    /// with the gas). Otherwise the length is limited by inlets, and by errors that arise because drag, buoyancy,
    /// turbulence, coupling, heat and the forces of an orbit act only between windows. Servo walls limit the length in
    /// any case. The duration is a whole number of the shortest windows.
    pub fn new(experiment: &Experiment) -> Self {
        let duration = experiment.run.duration;
        if duration <= 0.0 {
            return Self::default();
        }
        let drag = experiment.start.iter().flat_map(|population| DragScales::of(experiment, population));
        let drag: Vec<DragScales> = drag.collect();
        let least = |values: &mut dyn Iterator<Item = f64>| values.fold(f64::INFINITY, f64::min);
        let (allowed, often) = if drag.is_empty() {
            let rate = heated_rate(experiment).unwrap_or_else(|| steady_rate(experiment));
            let often = (duration / PIECES).min((COLLISIONS / rate).max(duration / MOST_SAMPLES));
            (often, often)
        } else {
            let response = least(&mut drag.iter().map(|drag| drag.response));
            (least(&mut drag.iter().map(DragScales::longest_window)), response / SAMPLES_PER_RESPONSE)
        };
        let allowed = allowed.min(longest_with_kicks_of_buoyancy(&experiment.scene)).min(orbit::longest(experiment));
        let allowed = allowed.min(longest_for_eddies(experiment)).min(longest_for_coupling(experiment));
        let allowed = allowed.min(longest_for_thermostat(experiment)).min(longest_for_inlets(experiment));
        let longest = experiment.run.window.unwrap_or(allowed).min(longest_for_servo(experiment)).min(duration);
        // windows are shortened if samples are requested more often than windows end
        let interval = experiment.statistics.sample_interval.unwrap_or(often.max(longest)).min(duration);
        // the term 1e-9 keeps rounding of the quotient from adding a window
        let samples = (duration / interval - 1e-9).ceil().max(1.0);
        let windows_per_sample = (duration / samples / longest - 1e-9).ceil().max(1.0);
        let window = duration / (samples * windows_per_sample);
        let instants = experiment.run.instants;
        let even = Self { instants, ..Self::even(window, windows_per_sample as u64, samples as u64) };
        // an extremely long run can have more windows than a double counts exactly
        let countless = samples * windows_per_sample > 1e15;
        if experiment.run.window.is_some() || countless { even } else { even.growing(experiment) }
    }

    /// Merges windows (times between two exchanges with the gas) into longer ones while drag slows the particles down.
    /// If this does not save enough windows, the schedule is returned unchanged.
    fn growing(self, experiment: &Experiment) -> Self {
        let Some(slowing) = Slowing::of(experiment) else { return self };
        let most = SHARE * experiment.run.duration;
        let grown = |doublings: usize| {
            // the time between two samples becomes a whole number of the longest windows
            let windows_per_sample = self.windows_per_sample.next_multiple_of(1 << doublings);
            let window = self.interval() / windows_per_sample as f64;
            let mut grown = Self { window, windows_per_sample, ..self };
            for (k, longer) in grown.longer.iter_mut().enumerate().take(doublings) {
                let wanted = window * (2_u64 << k) as f64;
                let allowed = |sample: u64| slowing.longest_window(sample as f64 * self.interval()) >= wanted;
                // bisection for the first sample from which longer windows are allowed, since the allowed length grows
                // with time
                let (mut early, mut late) = (0, self.samples);
                while early < late {
                    let middle = early + (late - early) / 2;
                    if allowed(middle) { late = middle } else { early = middle + 1 }
                }
                *longer = Some(late).filter(|late| *late < self.samples && wanted <= most);
            }
            grown
        };
        let best = (1..=DOUBLINGS).map(grown).min_by_key(Self::windows);
        best.filter(|best| (best.windows() as f64) < (1.0 - WORTH) * self.windows() as f64).unwrap_or(self)
    }

    /// Number of the shortest windows that are merged into the next window. `done` is the number of the shortest
    /// windows that fit into the time before the next window.
    pub fn together(&self, done: u64) -> u64 {
        let sample = done / self.windows_per_sample.max(1);
        1 << self.longer.iter().flatten().filter(|first| **first <= sample).count()
    }

    /// [s] length of the longest window (time between two exchanges with the gas) of the run.
    pub fn longest(&self) -> f64 {
        self.window * (1_u64 << self.longer.iter().flatten().count()) as f64
    }

    /// [s] time between two successive samples (measurements).
    pub fn interval(&self) -> f64 {
        self.windows_per_sample as f64 * self.window
    }

    /// [s] time between two used samples (measurements), if every n-th sample is used. Here n is the smallest number
    /// with which at most `most` samples are used after the start.
    pub fn spacing(&self, most: u64) -> f64 {
        self.samples.div_ceil(most).max(1) as f64 * self.interval()
    }

    /// Duration of the whole run, as a number of the shortest windows (times between two exchanges with the gas).
    pub fn length(&self) -> u64 {
        self.samples * self.windows_per_sample
    }

    /// Number of windows (times between two exchanges with the gas) of the whole run. Windows that are merged count as
    /// one.
    pub fn windows(&self) -> u64 {
        let (mut windows, mut from, mut each) = (0, 0, self.windows_per_sample);
        for first in self.longer.iter().flatten() {
            windows += (first - from) * each;
            (from, each) = (*first, each / 2);
        }
        windows + (self.samples - from) * each
    }

    /// [s] allowance for rounding errors of a time: a millionth of the shortest window. For comparison: the time after
    /// 1e9 windows, computed as 1e9 times the length of a window, has a rounding error of 1e-7 of a window.
    pub fn rounding(&self) -> f64 {
        1e-6 * self.window
    }

    /// Returns the next piece of a run (some whole windows or a part of one), which begins at the time `now` [s]. The
    /// window that contains `now` begins at the end of the first `done` of the shortest windows.
    pub fn piece(&self, done: u64, now: f64) -> ScheduleStep {
        let together = self.together(done);
        let to_sample = (self.windows_per_sample - done % self.windows_per_sample) / together;
        let Some(every) = self.instants else { return ScheduleStep::Windows(to_sample) };
        let (window, end) = (self.window * together as f64, (done + together) as f64 * self.window);
        let number = ((now + self.rounding()) / every).floor() + 1.0;
        // if rounding has reduced the quotient, `number` belongs to the present instant instead of the next one
        let mut number = if number * every <= now + self.rounding() { number + 1.0 } else { number };
        if now > done as f64 * self.window + self.rounding() {
            let instant = number * every;
            return if instant < end - self.rounding() {
                ScheduleStep::ToInstant(instant)
            } else {
                ScheduleStep::ToEnd(end)
            };
        }
        loop {
            let instant = number * every;
            let windows = (instant - now) / window;
            if windows > to_sample as f64 - 1e-6 {
                return ScheduleStep::Windows(to_sample);
            }
            // an instant at the end of a window does not divide a window
            if (windows - windows.round()).abs() * window > self.rounding() {
                return if windows < 1.0 {
                    ScheduleStep::ToInstant(instant)
                } else {
                    ScheduleStep::Windows(windows as u64)
                };
            }
            number += 1.0;
        }
    }

    /// True if the instants at which particles are written are not all at ends of windows, so that some windows are
    /// divided in two.
    pub fn is_cut(&self) -> bool {
        let windows = self.instants.map_or(1.0, |every| every / self.longest());
        (windows - windows.round()).abs() > 1e-6 * windows.max(1.0) || windows.round() < 1.0
    }
}

/// Time scales that determine the splitting error of drag.
///
/// The action of drag during a window (time between two exchanges with the gas) is replaced by kicks at the two ends of
/// the window. Four quantities change within the window. The error of each is of second order in the window h (Strang
/// 1968, SIAM J. Numer. Anal. 5, 506; factors of the trapezoidal rule):
/// * the slip velocity changes by drag itself: relative error (h/τ)²/24. The time τ is the response time at the start
///   or the relaxation time τ_l of the later slip, whichever is shorter;
/// * the speed of a fall from rest changes by gravity and drag together: error h² (1/τ_l - 1/τ_0)/(12 t), relative to
///   the speed after the time t. τ_l is the relaxation time at that speed, and τ_0 the one at rest;
/// * the velocity changes by collisions at a rate ν, whose instants within the window are random. This increases the
///   agitation by the share ν τ (h/τ)²/24;
/// * the gas velocity at the particle changes by motion across the profile: error σ² h² u'/(6 L_y) of the mean
///   velocity. Here σ is the agitation, u' the gradient at the walls, and L_y the width of the channel.
///
/// The second error is found as follows. During the fall the speed w changes at the rate g - D(w), with the
/// deceleration D by drag. Primes of D denote derivatives with respect to w. Strang's splitting gives an error of at
/// most h² g ((D'² - D D'')/24 + g D''/12), from its double commutators. Once drag balances the weight, the relative
/// error of the speed is less than (h D')²/24. Before that, the last term dominates. The integral of this term over the
/// fall, with D = 0 and w = g t, is the second error.
#[derive(Clone, Copy, Debug)]
struct DragScales {
    /// [s] response time τ at the larger of two slip speeds: the slip speed at the start, and the slip speed that
    /// gravity causes.
    response: f64,
    /// [s] relaxation time τ_l at the slip speed that gravity causes.
    relaxation: f64,
    /// [s²] ratio t/(1/τ_l - 1/τ_0) for a fall from rest that takes the time t. τ_l is the relaxation time of the slip
    /// at the final speed, and τ_0 the relaxation time at rest. The ratio is infinite without a fall, or if drag is
    /// linear.
    fall: f64,
    /// [1/s] rate ν at which a particle collides.
    rate: f64,
    /// [1/s²] ratio σ² u'/(L_y U) for motion across the velocity profile of the gas. Here σ is the agitation (random
    /// motion of the particles), u' the gradient at the walls, L_y the width of the channel, and U the gas velocity.
    crossing: f64,
}

impl DragScales {
    /// Time scales for the particles of a population. If the particles differ in size, the scales are those of
    /// particles of the mean volume and of the smallest particles.
    fn of(experiment: &Experiment, population: &Population) -> Vec<Self> {
        let (velocity, fluctuation) = motion(population);
        let scene = &experiment.scene;
        let Some(fluid) = &scene.fluid else { return Vec::new() };
        let gas = fluid.profile.velocity(0.5 * scene.domain.size.y);
        // slip speed of the mean velocity, or that of a single particle if particles fly in all directions
        let slip = (velocity - Vector3::new(0.0, 0.0, gas)).norm().max(3.0_f64.sqrt() * fluctuation);
        let species = &scene.species[population.species as usize];
        let smallest = species.sizes.is_some().then(|| species.of_one_size(species.smallest()));
        let sizes = std::iter::once(species).chain(&smallest);
        sizes.filter_map(|species| Self::at(experiment, species, [slip, fluctuation])).collect()
    }

    /// Time scales for spheres of a species. The slip speed and the fluctuation of each velocity component are in m/s.
    /// `None` without drag.
    fn at(experiment: &Experiment, species: &Species, [slip, fluctuation]: [f64; 2]) -> Option<Self> {
        let scene = &experiment.scene;
        let fluid = scene.fluid.as_ref()?;
        let drag = fluid.drag.as_ref()?;
        let law = drag.law();
        let sphere = fluid.sphere(species).among(experiment.fraction_for_drag());
        let height = scene.domain.size.y;
        let gas = fluid.profile.velocity(0.5 * height);
        let gravity = scene.gravity_of(species).norm();
        let falling = terminal_slip(drag, &sphere, gravity).min(gravity * experiment.run.duration);
        let relaxation = law.relaxation_time(&sphere, falling);
        let steeper = 1.0 / relaxation - 1.0 / law.relaxation_time(&sphere, 0.0);
        let fall = if falling > 0.0 && steeper > 0.0 { falling / gravity / steeper } else { f64::INFINITY };
        let count = experiment.expected_count();
        let density = count / scene.domain.volume();
        // without agitation at the start, an agitation is assumed that will develop: a share of the gas velocity or,
        // for falling bodies, of their speed
        let kept_up = if count < 2.0 { 0.0 } else { AGITATION * gas.abs().max(falling) };
        let agitation = fluctuation.max(kept_up);
        // Chapman & Cowling 1970, 5.21: 4 n d² sqrt(π T), where T is the variance of a velocity component
        let rate = 4.0 * density * species.diameter.powi(2) * PI.sqrt() * agitation;
        let gradient = wall_gradient(&fluid.profile, 0.5 * species.diameter, height);
        let crossing = agitation * agitation * gradient / (height * gas.abs());
        Some(Self { response: law.response_time(&sphere, slip.max(falling)), relaxation, fall, rate, crossing })
    }

    /// [s] longest window for which the four errors by the splitting of drag from motion, which [`DragScales`]
    /// describes, are within their limits.
    fn longest_window(&self) -> f64 {
        let alone = (24.0 * SPLITTING_ALONE).sqrt() * self.response.min(self.relaxation);
        let fall = (12.0 * SPLITTING_ALONE * self.fall).sqrt();
        let agitation = (24.0 * SPLITTING / (1.0 + self.rate * self.response)).sqrt() * self.response;
        let crossing = (6.0 * SPLITTING / self.crossing).sqrt();
        // in a gas at rest 0/0 occurs, which sets no limit
        [fall, agitation, crossing].into_iter().fold(alone, f64::min)
    }
}

/// [s] longest window if weight and buoyancy accelerate the species differently. One acceleration common to all
/// species then acts during a window, and kicks at the ends of windows add the differences. The result is infinite if
/// there are no differences. With a difference b [m/s²] the path within a window of length h differs by at most b h²/8
/// from a parabola. This distance is at most [`SAG`] times the smallest diameter.
fn longest_with_kicks_of_buoyancy(scene: &Scene) -> f64 {
    let largest = scene.differences_in_gravity().iter().map(|difference| difference.norm()).fold(0.0, f64::max);
    if largest > 0.0 { (8.0 * SAG * scene.smallest_diameter() / largest).sqrt() } else { f64::INFINITY }
}

/// [s] longest window with turbulence; infinite without turbulence. The fluctuations of the gas velocity at the
/// particles are advanced separately from the motion of the particles. Within a window of length h the fluctuation
/// changes by a share h r of its standard deviation, with the rate r of
/// [`Turbulence::largest_rate`](crate::fluid::Turbulence::largest_rate). The relative error of this separation is a
/// twelfth of the square of h r (trapezoidal rule). The window is so short that this error is at most [`SPLITTING`].
pub fn longest_for_eddies(experiment: &Experiment) -> f64 {
    let scene = &experiment.scene;
    let Some(fluid) = &scene.fluid else { return f64::INFINITY };
    let (Some(turbulence), Some(drag)) = (&fluid.turbulence, &fluid.drag) else { return f64::INFINITY };
    let rates = scene.species.iter().map(|species| {
        let sphere = fluid.sphere(&species.of_one_size(species.smallest()));
        let slip = terminal_slip(drag, &sphere, scene.gravity_of(species).norm());
        turbulence.largest_rate(&fluid.profile, scene.domain.size.y, drag.law().response_time(&sphere, slip))
    });
    (12.0 * SPLITTING).sqrt() / rates.fold(0.0, f64::max)
}

/// [-] largest relative decrease, within a window, of the slip (velocity of the gas relative to the particles) by the
/// force on the gas. The gas velocity is constant in a kick. So the exchange of momentum is an explicit scheme: it is
/// stable if this number is below 2, and has an error of first order in this number.
const EXCHANGED: f64 = 0.1;

/// [s] longest window with two-way coupling; infinite if particles do not change the gas. The slip of the gas decays at
/// the rate Σ(m/τ)/(ρ_f V), with the mass m and response time τ of each particle, and the density ρ_f and volume V of
/// the gas. A window lasts at most a tenth of the inverse of this rate. Inlets count with the number of particles that
/// they are [expected](Experiment::expected_counts) to bring.
pub fn longest_for_coupling(experiment: &Experiment) -> f64 {
    let scene = &experiment.scene;
    let Some(fluid) = scene.fluid.as_ref().filter(|fluid| fluid.coupling.is_some()) else { return f64::INFINITY };
    let Some(drag) = &fluid.drag else { return f64::INFINITY };
    let volume = match &fluid.profile {
        Profile::Pipe(pipe) => PI * pipe.radius().powi(2) * scene.domain.size.z,
        Profile::Uniform(_) | Profile::Tabulated(_) | Profile::Channel(_) | Profile::LogLaw(_) => scene.domain.volume(),
    };
    let kinds = scene.species.iter().zip(experiment.expected_counts());
    let exchange = kinds.map(|(species, count)| {
        let sphere = fluid.sphere(species).among(experiment.fraction_for_drag());
        let slip = terminal_slip(drag, &sphere, scene.gravity_of(species).norm());
        count * species.mass() / drag.law().response_time(&sphere, slip)
    });
    EXCHANGED * fluid.density * volume / exchange.sum::<f64>()
}

/// [1/s] collision rate of each particle in a scene without losses, friction, gravity and a surrounding gas. In such a
/// scene the agitation (random motion) of the particles is constant. The result is 0 for all other scenes.
fn steady_rate(experiment: &Experiment) -> f64 {
    let scene = &experiment.scene;
    let surfaces = scene.surfaces(experiment.most_that_touch(experiment.count()));
    let elastic = surfaces.iter().all(|surface| surface.restitution == 1.0 && surface.friction == 0.0);
    let count = experiment.count() as f64;
    if !elastic || scene.gravity != Vector3::zeros() || scene.fluid.is_some() || count == 0.0 {
        return 0.0;
    }
    let each = experiment.start.iter().map(|population| {
        let agitation = motion(population).1;
        population.amount.count() as f64 / count
            * scene.species[usize::from(population.species)].diameter.powi(2)
            * agitation
    });
    // Chapman & Cowling 1970, 5.21, as in `DragScales::at`
    4.0 * count / scene.domain.volume() * PI.sqrt() * each.sum::<f64>()
}

/// Sets common instants for all variants (runs that are compared) if their times of measurement differ. Windows of all
/// variants are divided at these instants, and curves and paths are compared there.
pub fn align(experiments: &mut [&mut Experiment]) {
    let intervals: Vec<f64> = experiments.iter().map(|one| Schedule::new(one).interval()).collect();
    let durations = experiments.iter().map(|one| one.run.duration);
    let Some(longest) = durations.reduce(f64::max).filter(|longest| *longest > 0.0) else { return };
    let alike = |a: f64, b: f64| (a - b).abs() <= 1e-9 * a.abs();
    if intervals.windows(2).all(|pair| alike(pair[0], pair[1])) {
        return;
    }
    let few = experiments.iter().all(|one| one.count() <= MOST_FOLLOWED);
    let wanted = longest / if few { ROWS_OF_FEW } else { ROWS };
    for one in experiments {
        // the given interval must be a whole multiple of the common interval, which is shortened for this purpose
        let parts = one.run.instants.map(|every| every / (every / wanted - 1e-9).ceil().max(1.0));
        one.run.instants = Some(parts.unwrap_or(wanted));
    }
}

/// [m/s] mean velocity of the particles of a population at the start, and root mean square [m/s] of a velocity
/// component about this mean.
fn motion(population: &Population) -> (Vector3<f64>, f64) {
    let Amount::Placed(placed) = &population.amount else {
        return (population.velocity_mean, population.mean_fluctuation());
    };
    let count = placed.len().max(1) as f64;
    let mean = placed.velocity.iter().sum::<Vector3<f64>>() / count;
    let square = placed.velocity.iter().map(|v| (v - mean).norm_squared()).sum::<f64>() / count;
    (mean, (square / 3.0).sqrt())
}

/// [1/s] gradient of the gas velocity where a sphere with this radius [m] touches a wall of the gas: the larger of the
/// gradients at the lower and the upper wall. `height` [m] is the height of the box.
fn wall_gradient(profile: &Profile, radius: f64, height: f64) -> f64 {
    let [low, high] = profile.between(height);
    let steep = |near: f64, far: f64| (profile.velocity(far) - profile.velocity(near)).abs() / radius;
    steep(low + radius, low + 2.0 * radius).max(steep(high - radius, high - 2.0 * radius))
}
