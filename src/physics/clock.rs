//! The clock that measures the time spent in the parts of a run, such as engine and drag. It also holds the simulated
//! time that the run has reached, for a display of progress.
//!
//! The run loop and the engines never read the time of day by themselves. The program that starts a simulation can pass
//! a clock to it. The measured times appear only in reports.

use std::sync::atomic::{AtomicU64, Ordering};
use std::sync::{Arc, OnceLock};
use std::time::{Duration, Instant};

/// Clock that counts wall time (elapsed real time), or a stopped clock. A wall clock counts from the first reading of
/// time in the program. A stopped clock always reads 0 and costs no computing time.
///
/// A run reads wall time from the clock, and writes to it the simulated time that the run has reached.
#[derive(Clone, Debug, Default)]
pub struct Clock {
    read: Option<fn() -> Duration>,
    reached: Option<Reached>,
}

/// Simulated time that a run has reached. Another thread can read it during the run.
#[derive(Clone, Debug, Default)]
pub struct Reached(Arc<AtomicU64>);

impl Reached {
    /// [s] simulated time that the run had reached at its latest report of progress; 0 before the first report.
    pub fn time(&self) -> f64 {
        f64::from_bits(self.0.load(Ordering::Relaxed))
    }
}

impl Clock {
    /// Creates a clock that counts the wall time of the machine.
    pub fn wall() -> Self {
        static BEGAN: OnceLock<Instant> = OnceLock::new();
        Self { read: Some(|| BEGAN.get_or_init(Instant::now).elapsed()), reached: Some(Reached::default()) }
    }

    /// Wall time since the first reading of time in the program; 0 if the clock is stopped.
    pub fn now(&self) -> Duration {
        self.read.map_or(Duration::ZERO, |read| read())
    }

    /// Runs `work`, adds its duration to `spent` and returns its result.
    pub fn time<T>(&self, spent: &mut Duration, work: impl FnOnce() -> T) -> T {
        let began = self.now();
        let result = work();
        *spent += self.now() - began;
        result
    }

    /// Reports that the run has reached the simulated time `time` [s], for the display of progress. A report is one
    /// write to memory, so engines can report every step or event. A stopped clock ignores reports.
    pub fn tell(&self, time: f64) {
        if let Some(reached) = &self.reached {
            reached.0.store(time.to_bits(), Ordering::Relaxed);
        }
    }

    /// Handle from which another thread can read the simulated time that is reported to this clock or to its clones.
    /// `None` if the clock is stopped, because a stopped clock stores no reports.
    pub fn reached(&self) -> Option<Reached> {
        self.reached.clone()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_wall_clock_counts_and_none_stands_still() {
        let wait = || std::thread::sleep(Duration::from_millis(2));
        let (mut counted, mut none) = (Duration::ZERO, Duration::ZERO);
        Clock::wall().time(&mut counted, wait);
        Clock::default().time(&mut none, wait);
        assert!(counted >= Duration::from_millis(2));
        assert_eq!(none, Duration::ZERO);
    }

    #[test]
    fn what_a_clone_is_told_is_read_from_the_original() {
        let clock = Clock::wall();
        let reached = clock.reached().unwrap();
        std::thread::scope(|scope| scope.spawn(|| clock.clone().tell(0.25)).join()).unwrap();
        assert_eq!(reached.time(), 0.25);
        Clock::default().tell(1.0);
        assert!(Clock::default().reached().is_none());
    }
}
