//! Live view of one run: a server sends frames (data of one instant each) to its pages while the run goes on.
//!
//! The view only reads the simulation, at ends of windows (times between two exchanges with the gas). A run with a view
//! therefore has the same results, bit for bit, as a run without a view.

use super::frame::{Live, Now, bytes, drawn};
use super::gauge::Graph;
use crate::clock::Clock;
use crate::experiment::{AverageFrom, Experiment};
use crate::observe::{Motion, Observer};
use crate::output::numbers::{significant, with_error};
use crate::output::outlines;
use crate::particles::Sample;
use crate::schedule::Schedule;
use crate::simulation::Simulation;
use serde::Serialize;
use serde_json::json;
use std::sync::atomic::{AtomicUsize, Ordering};
use std::sync::{Arc, Mutex, PoisonError};
use std::time::Duration;

/// Wall time from one frame (picture of one instant) to the next while a page is open.
pub const FRAME: Duration = Duration::from_millis(33);

/// Wall time from one frame (picture of one instant) to the next while no page is open, so that a page that opens shows
/// a recent state.
const UNSEEN: Duration = Duration::from_millis(500);

/// Wall time from one test whether the run is steady to the next test.
const VERDICT: Duration = Duration::from_millis(1500);

/// Largest number of particles in a frame (picture of one instant). A browser draws so many particles about ten times
/// per second.
const MOST_DRAWN: usize = 20_000;

/// Largest number of points of a curve. A picture with a width of 440 pixels cannot show more.
const MOST_ROWS: usize = 500;

/// [-] largest rounding error in the time of a sample (instant of measurement), divided by the time between two
/// samples.
const ROUNDING: f64 = 1e-6;

/// Latest frame of a run (data of one instant, from which a page draws), for all pages of a server.
pub struct LiveFeed {
    /// Description of the scene for a page, as JSON.
    pub opened: String,
    /// Number of pages that are open.
    pub pages: AtomicUsize,
    latest: Mutex<(u64, Arc<[u8]>)>,
}

impl LiveFeed {
    /// Latest frame (data of one instant, from which a page draws) and its number; the number is 0 before the first
    /// frame.
    pub fn latest(&self) -> (u64, Arc<[u8]>) {
        self.latest.lock().unwrap_or_else(PoisonError::into_inner).clone()
    }

    fn put(&self, frame: Vec<u8>) {
        let mut latest = self.latest.lock().unwrap_or_else(PoisonError::into_inner);
        *latest = (latest.0 + 1, frame.into());
    }
}

/// Part of a live frame (data of one instant, from which a page draws) that is sent as JSON.
#[derive(Serialize)]
struct LiveHead<'a> {
    counts: [usize; 1],
    sides: [&'a Now; 1],
    sentence: &'a str,
}

/// Observer that makes the frames of a run: data of one instant each, from which a page draws.
pub struct LiveView {
    feed: Arc<LiveFeed>,
    clock: Clock,
    /// Measurements with which the run is tested for a steady state. `None` if the view is not called at the samples
    /// (instants of measurement) of the run.
    motion: Option<Motion>,
    average_from: AverageFrom,
    /// [s] time between two samples (instants of measurement).
    interval: f64,
    /// [s] unit of the time axis of the curves.
    unit: f64,
    at_start: Option<f64>,
    /// Points of the curves so far: time in `unit`, mean velocity along z [m/s], granular temperature [m²/s²], impacts.
    rows: Vec<Vec<f64>>,
    /// [s] unit of the time axis of the curves: 1, 1e-3 or 1e-6, depending on the duration of the run.
    thinning: (usize, usize),
    /// Wall time and simulated time [s] of the latest frame (data sent to the page).
    shown: (Duration, f64),
    /// [s] simulated time from the latest frame (data sent to the page) to the next, estimated from the speed of the
    /// run between the two latest frames.
    stretch: f64,
    judged: Duration,
    sentence: String,
}

impl LiveView {
    /// Creates the view of a run of the experiment. `title` is the heading of the page. If `samples` is true, the view
    /// is called at all samples (instants of measurement) of the run, and tests for a steady state. If it is false,
    /// there is no such test.
    pub fn new(experiment: &Experiment, title: &str, samples: bool) -> Self {
        let duration = experiment.run.duration;
        let (unit, label) = match duration {
            1.0.. => (1.0, "time [s]"),
            1e-3.. => (1e-3, "time [ms]"),
            _ => (1e-6, "time [µs]"),
        };
        let graph = |title, y, column| Graph::new(title, (0, label), y, vec![column]);
        let graphs = [
            graph("Mean velocity along z", "velocity [m/s]", 1),
            graph("Granular temperature, about the mean velocity", "T [m²/s²]", 2),
            graph("Impacts so far", "impacts", 3),
        ];
        let scene = &experiment.scene;
        let (size, name) = (scene.domain.size, experiment.model().name());
        let right = if size.x >= size.z { 0 } else { 2 };
        let opened = json!({
            "tell": "opened",
            "title": title,
            "sides": [{"title": name, "model": name, "method": ""}],
            "size": <[f64; 3]>::from(size),
            "periodic": scene.domain.periodic,
            "view": {"right": right, "up": 1, "region": null, "magnify": null},
            "walls": outlines(scene),
            "graphs": graphs,
            "until": duration / unit,
            "version": env!("CARGO_PKG_VERSION"),
        });
        let feed = LiveFeed { opened: opened.to_string(), pages: AtomicUsize::new(0), latest: Mutex::default() };
        Self {
            feed: Arc::new(feed),
            clock: Clock::wall(),
            motion: samples.then(|| Motion::new(experiment)),
            average_from: experiment.run.average_from,
            interval: Schedule::new(experiment).interval(),
            unit,
            at_start: None,
            rows: Vec::new(),
            thinning: (1, 0),
            shown: (Duration::ZERO, 0.0),
            stretch: 0.0,
            judged: Duration::ZERO,
            sentence: String::new(),
        }
    }

    /// Frames of the run (data of one instant each), which a server sends to its pages.
    pub fn feed(&self) -> Arc<LiveFeed> {
        Arc::clone(&self.feed)
    }

    /// Makes a frame (data of the present instant for the page) if the latest frame is older than `FRAME`. While no
    /// page is open, the limit is `UNSEEN`. The state of the run is not changed.
    pub fn offer(&mut self, simulation: &Simulation) {
        let pause = if self.feed.pages.load(Ordering::Relaxed) > 0 { FRAME } else { UNSEEN };
        if self.clock.now() >= self.shown.0 + pause || self.at_start.is_none() {
            self.show(simulation, "running");
        }
    }

    /// Makes a frame (data of the present instant for the page), and adds a point to the curves. `state` is the state
    /// of the run: `running` or `over`.
    pub fn show(&mut self, simulation: &Simulation, state: &'static str) {
        let (now, time) = (self.clock.now(), simulation.time);
        // the first frame may show a later instant, so the energy at the start is that by the balance up to then
        let ledger = &simulation.record.ledger;
        let at_start = *self.at_start.get_or_insert_with(|| ledger.residual(0.0, simulation.energy()));
        self.add_row(simulation);
        if now >= self.judged + VERDICT || state == "over" {
            self.sentence = self.motion.as_ref().map_or(String::new(), |motion| sentence(motion, self.average_from));
            self.judged = now;
        }
        let live = Live::of(simulation, at_start);
        let side = Now { time, state, failure: None, rows: self.rows.clone(), live };
        let particles = drawn(simulation, MOST_DRAWN);
        let head = LiveHead { counts: [particles.len()], sides: [&side], sentence: &self.sentence };
        self.feed.put(bytes(&head, &[particles]));
        let (wall, before) = std::mem::replace(&mut self.shown, (now, time));
        let pace = (time - before) / (now - wall).as_secs_f64().max(1e-6);
        self.stretch = (pace * FRAME.as_secs_f64()).max(0.0);
    }

    fn add_row(&mut self, simulation: &Simulation) {
        let (every, since) = &mut self.thinning;
        *since += 1;
        if *since < *every {
            return;
        }
        *since = 0;
        let speed = Sample::from(&simulation.particles).fluctuation_speed();
        let impacts = simulation.record.pairs.count + simulation.record.walls.count;
        let mean = simulation.mean_velocity().z;
        self.rows.push(vec![simulation.time / self.unit, mean, speed * speed / 3.0, impacts as f64]);
        if self.rows.len() > MOST_ROWS {
            let mut place = 0;
            self.rows.retain(|_| {
                place += 1;
                place % 2 == 1
            });
            *every *= 2;
        }
    }
}

impl Observer for LiveView {
    fn next(&self, now: f64, schedule: &Schedule) -> Option<f64> {
        let interval = schedule.interval();
        let sample = ((now / interval + ROUNDING).floor() + 1.0) * interval;
        Some(sample.min(now + self.stretch))
    }

    fn needs_velocities(&self) -> bool {
        // between samples (instants of measurement) half a kick (change of velocity by drag) is still missing in the
        // velocities, but this is too little to be seen in a picture
        false
    }

    fn see(&mut self, simulation: &Simulation) {
        let samples = simulation.time / self.interval;
        if let Some(motion) = self.motion.as_mut().filter(|_| (samples - samples.round()).abs() < ROUNDING) {
            motion.see(simulation);
        }
        self.offer(simulation);
    }

    fn end(&mut self, simulation: &Simulation) {
        self.show(simulation, "over");
    }
}

/// Sentence that states whether the run is steady so far, with the granular temperature since averaging began. Empty if
/// this temperature is not known.
fn sentence(motion: &Motion, average_from: AverageFrom) -> String {
    let steadiness = motion.steadiness(average_from, Vec::new());
    let since = significant(steadiness.from, 3);
    let temperature = motion.temperature(motion.first(steadiness.from));
    let Some(temperature) = temperature.map(with_error) else { return String::new() };
    let state = if steadiness.steady { "Steady" } else { "Not steady yet" };
    format!("{state}, averaged from {since} s on: granular temperature {temperature} m²/s².")
}
