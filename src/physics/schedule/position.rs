//! Position of a run in its schedule. A schedule divides a run into windows (times between two exchanges with the gas),
//! with samples (measurements) at the ends of some windows.

use super::{Schedule, ScheduleStep};
use serde::{Deserialize, Serialize};

/// [-] fraction of a window (time between two exchanges with the gas) by which the time of a simulation may differ from
/// that of the schedule. Rounding errors of the time add up to less than this fraction over 10⁶ windows.
const DRIFT: f64 = 1e-3;

/// Position of a run in its schedule. A run may stop at any time within a window (time between two exchanges with the
/// gas); when the run is continued, this window is completed first.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct SchedulePosition {
    schedule: Schedule,
    /// Number of completed windows (times between two exchanges with the gas). A longer window counts as several of the
    /// shortest windows of the schedule.
    done: u64,
    /// [s] simulated time at which the run has been interrupted within a window (time between two exchanges with the
    /// gas); `None` if the run is at the end of a window.
    cut: Option<f64>,
}

impl SchedulePosition {
    /// Creates the position at the start of a run.
    pub fn new(schedule: Schedule) -> Self {
        Self { schedule, done: 0, cut: None }
    }

    /// Finds the position of a simulation at `time` [s] in a schedule.
    pub fn at(schedule: Schedule, time: f64) -> Self {
        let done = (time / schedule.window + DRIFT).floor() as u64;
        let done = done - done % schedule.together(done);
        let is_within = (time - done as f64 * schedule.window).abs() > DRIFT * schedule.window;
        Self { schedule, done, cut: is_within.then_some(time) }
    }

    /// Schedule of the run.
    pub fn schedule(&self) -> &Schedule {
        &self.schedule
    }

    /// [s] present time according to the schedule. It is computed from the number of windows, so it is free of the
    /// rounding errors that add up in the time of the simulation itself.
    pub fn now(&self) -> f64 {
        self.cut.unwrap_or_else(|| self.after(0))
    }

    /// [s] time at which the next `windows` windows end, counted from the start of the present window, if all are as
    /// long as this window. With `windows` = 0 it is the start of the present window.
    pub fn after(&self, windows: u64) -> f64 {
        (self.done + windows * self.schedule.together(self.done)) as f64 * self.schedule.window
    }

    /// [s] length of the present window (time between two exchanges with the gas).
    pub fn window(&self) -> f64 {
        self.schedule.window * self.schedule.together(self.done) as f64
    }

    /// [s] time of the next sample (measurement).
    pub fn next_sample(&self) -> f64 {
        let windows = self.schedule.windows_per_sample.max(1);
        ((self.done / windows + 1) * windows) as f64 * self.schedule.window
    }

    /// True if the run is exactly at the end of its schedule.
    pub fn is_over(&self) -> bool {
        self.done == self.schedule.length()
    }

    /// True if `time` [s] of a simulation is the present time of the schedule.
    pub fn is_at(&self, time: f64) -> bool {
        (self.now() - time).abs() <= DRIFT * self.schedule.window
    }

    /// Returns the next piece of the run: several whole windows (times between two exchanges with the gas), or a part
    /// of one window. The piece ends at the time `until` [s] at the latest.
    pub fn next(&self, until: f64) -> ScheduleStep {
        let (schedule, now) = (&self.schedule, self.now());
        let step = match schedule.instants {
            None if self.cut.is_some() => ScheduleStep::ToEnd(self.after(1)),
            _ => schedule.piece(self.done, now),
        };
        match step {
            ScheduleStep::Windows(windows) => {
                let allowed = (until - now + schedule.rounding()) / self.window();
                if allowed < 1.0 {
                    ScheduleStep::ToInstant(until)
                } else {
                    ScheduleStep::Windows(windows.min(allowed as u64))
                }
            }
            ScheduleStep::ToInstant(end) | ScheduleStep::ToEnd(end) if until < end - schedule.rounding() => {
                ScheduleStep::ToInstant(until)
            }
            step => step,
        }
    }

    /// Number of windows (times between two exchanges with the gas) in a piece of the run, and the length [s] of each.
    pub fn lengths(&self, step: ScheduleStep) -> (u64, f64) {
        match step {
            ScheduleStep::Windows(windows) => (windows, self.window()),
            ScheduleStep::ToInstant(end) | ScheduleStep::ToEnd(end) => (1, end - self.now()),
        }
    }

    /// Moves the position to the end of a piece of the run, or to the end of its first `ran` windows if the engine did
    /// not run all of them.
    pub fn advance(&mut self, step: ScheduleStep, ran: u64) {
        let together = self.schedule.together(self.done);
        match step {
            ScheduleStep::Windows(_) => self.done += ran * together,
            ScheduleStep::ToInstant(instant) => self.cut = Some(instant),
            ScheduleStep::ToEnd(_) => (self.done, self.cut) = (self.done + together, None),
        }
    }
}
