//! The clock that the parts of a run are timed with.
//!
//! Nothing below the run loop reads the time of day by itself: who starts a simulation lends it a clock or none, and only
//! reports show what it measured.

use std::sync::OnceLock;
use std::time::{Duration, Instant};

/// A clock that counts from an instant of its own, or one that stands still and costs nothing.
#[derive(Clone, Copy, Debug, Default)]
pub struct Clock(Option<fn() -> Duration>);

impl Clock {
    /// The wall clock of the machine.
    pub fn wall() -> Self {
        static BEGAN: OnceLock<Instant> = OnceLock::new();
        Self(Some(|| BEGAN.get_or_init(Instant::now).elapsed()))
    }

    /// What it shows now; always the same if it stands still.
    pub fn now(&self) -> Duration {
        self.0.map_or(Duration::ZERO, |read| read())
    }

    /// Does `work` and adds the time that it took to `spent`.
    pub fn time<T>(&self, spent: &mut Duration, work: impl FnOnce() -> T) -> T {
        let began = self.now();
        let result = work();
        *spent += self.now() - began;
        result
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
}
