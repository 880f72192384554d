//! Expected and remaining wall time of all runs of a chart, used for progress messages only.

use crate::runs::INTERVAL;
use crate::simulation::Simulation;
use std::time::Instant;

/// [-] weight of the wall time that was estimated before the runs, when the remaining time is computed. The estimate
/// counts as much as measured runs that make up this share of the whole chart.
const PRIOR: f64 = 0.05;

/// Progress of the runs of a chart, with the expected wall time of each run.
pub struct Outlook {
    told: Option<fn(&str)>,
    /// [s] expected wall time of each run, in the order of the runs.
    expected: Vec<f64>,
    done: usize,
    /// Name of the run that is in progress, for the messages.
    name: String,
    began: Instant,
    said: Instant,
}

impl Outlook {
    /// Creates the progress messages of a chart. `told` is a function that prints one line. With `None`, nothing is
    /// printed and no wall time is estimated.
    pub fn new(told: Option<fn(&str)>) -> Self {
        let now = Instant::now();
        Self { told, expected: Vec::new(), done: 0, name: String::new(), began: now, said: now }
    }

    /// Prints one line of text, if messages are printed.
    pub fn tell(&mut self, text: &str) {
        if let Some(told) = self.told {
            told(text);
            self.said = Instant::now();
        }
    }

    /// Stores the expected wall time [s] of each run and prints their sum. The function `estimate` computes these
    /// times; it is called only if messages are printed.
    ///
    /// # Errors
    /// Returns the error of the function `estimate`.
    pub fn expect<E>(&mut self, estimate: impl FnOnce() -> Result<Vec<f64>, E>) -> Result<(), E> {
        if self.told.is_some() {
            self.expected = estimate()?;
            let total = self.expected.iter().sum();
            self.tell(&format!("{} runs, {} in all, by a trial of each", self.expected.len(), in_words(total)));
            self.restart();
        }
        Ok(())
    }

    /// Sets the progress back to the first run. This is needed when the runs begin, or begin again with another
    /// reference method.
    pub fn restart(&mut self) {
        self.done = 0;
        self.began = Instant::now();
    }

    /// Sets the name of the run that begins, for the messages.
    pub fn begin(&mut self, name: String) {
        self.name = name;
    }

    /// Observer that prints the progress of the present run of the chart, which may consist of several simulations.
    /// `whole` [s] is the simulated time of all these simulations, `before` [s] that of the completed ones.
    pub fn watching(&mut self, before: f64, whole: f64) -> impl FnMut(&Simulation) {
        move |simulation| self.within((before + simulation.time) / whole)
    }

    /// Prints the completed share `part` [-] of the present run, if the last message is older than the interval between
    /// messages.
    fn within(&mut self, part: f64) {
        if self.said.elapsed() >= INTERVAL {
            self.tell(&format!("{}: {:.0} % of it{}", self.name, 100.0 * part, self.left(part)));
        }
    }

    /// Counts the present run as completed, and prints a line with its name and the text `how`.
    pub fn end(&mut self, how: &str) {
        self.done += 1;
        self.tell(&format!("{}: {how}{}", self.name, self.left(0.0)));
    }

    fn left(&self, part: f64) -> String {
        match time_left(&self.expected, self.done, part, self.began.elapsed().as_secs_f64()) {
            Some(seconds) if seconds >= 1.0 => format!("; {} left in all", in_words(seconds)),
            _ => String::new(),
        }
    }
}

/// [s] wall time until all runs have ended; `None` after the end of all runs. So far `done` runs and the share `part`
/// [-] of the next run took the wall time `elapsed` [s]. `expected` [s] are the estimated wall times of all runs.
fn time_left(expected: &[f64], done: usize, part: f64, elapsed: f64) -> Option<f64> {
    let next = expected.get(done)?;
    let total: f64 = expected.iter().sum();
    let over = expected[..done].iter().sum::<f64>() + part * next;
    let prior = PRIOR * total;
    Some((total - over) * (elapsed + prior) / (over + prior))
}

/// Wall time as text, rounded to whole seconds, minutes or hours.
fn in_words(seconds: f64) -> String {
    match seconds {
        s if s < 1.0 => "less than a second".into(),
        s if s < 100.0 => format!("about {s:.0} s"),
        s if s < 6000.0 => format!("about {:.0} min", s / 60.0),
        s => format!("about {:.0} h", s / 3600.0),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_left_follows_what_was_measured() {
        let expected = [10.0, 10.0, 30.0];
        let close = |found: Option<f64>, wanted: f64| assert!((found.unwrap() - wanted).abs() < 1e-12, "{found:?}");
        close(time_left(&expected, 0, 0.0, 0.0), 50.0);
        // the runs are as fast as expected, so the remaining time is the expected time of the remaining runs
        close(time_left(&expected, 1, 0.5, 15.0), 35.0);
        // the runs are twice as slow: 40 s instead of 20 s; the estimate has the weight of 2.5 s
        close(time_left(&expected, 2, 0.0, 40.0), 30.0 * 42.5 / 22.5);
        assert_eq!(time_left(&expected, 3, 0.0, 50.0), None);
        assert_eq!(time_left(&[], 0, 0.0, 1.0), None);
    }

    #[test]
    fn times_are_said_in_the_unit_one_plans_with() {
        let words = [0.3, 42.4, 1830.0, 9000.0].map(in_words);
        assert_eq!(words, ["less than a second", "about 42 s", "about 30 min", "about 2 h"]);
    }
}
