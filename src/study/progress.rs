//! Progress on the terminal: rate and time left; one line per interval when piped.

use super::terminal::tell;
use crate::experiment::Experiment;
use crate::observe::Observer;
use crate::simulation::Simulation;
use indicatif::{ProgressBar, ProgressStyle};
use std::io::{IsTerminal, stderr};
use std::time::{Duration, Instant};

/// Between lines when there is no terminal.
pub const INTERVAL: Duration = Duration::from_secs(10);

/// Resolution of the bar.
const TICKS: u64 = 10_000;

/// Shows how a run goes.
pub struct Reporter {
    /// Name of the variant.
    name: String,
    /// [s] to be simulated.
    duration: f64,
    how: How,
    /// [s] simulated time that was first seen: a run that goes on has not been simulated from the start here.
    from: Option<f64>,
    began: Instant,
    said: Instant,
}

enum How {
    Silent,
    Bar(ProgressBar),
    Lines,
}

impl Reporter {
    /// For one run; silent if `quiet`.
    pub fn new(experiment: &Experiment, quiet: bool) -> Self {
        let how = if quiet {
            How::Silent
        } else if stderr().is_terminal() {
            let bar = ProgressBar::new(TICKS);
            bar.set_style(style());
            How::Bar(bar)
        } else {
            How::Lines
        };
        Self::with(how, experiment.name.clone(), experiment.run.duration)
    }

    fn with(how: How, name: String, duration: f64) -> Self {
        let now = Instant::now();
        Self { name, duration, how, from: None, began: now, said: now }
    }

    /// The run has come to `time` [s].
    fn show(&mut self, time: f64) {
        let done = self.share(time);
        let elapsed = self.began.elapsed().as_secs_f64();
        let from = *self.from.get_or_insert(time);
        let rate = (time - from) / elapsed.max(1e-9);
        match &self.how {
            How::Silent => {}
            How::Bar(bar) => {
                bar.set_message(format!("{}: {time:.3} of {} s, {rate:.3} s/s", self.name, self.duration));
                bar.set_position((done * TICKS as f64) as u64);
                if done >= 1.0 {
                    // a line of its own stays where the bar was
                    bar.finish_and_clear();
                    tell(self.line(time, rate, 0.0));
                }
            }
            How::Lines => {
                if self.said.elapsed() >= INTERVAL || done >= 1.0 {
                    self.said = Instant::now();
                    let left = if rate > 0.0 { (self.duration - time).max(0.0) / rate } else { f64::INFINITY };
                    tell(self.line(time, rate, left));
                }
            }
        }
    }

    /// Where the run is at `time` [s], in one line: `rate` in s/s, `left` in s of wall time.
    fn line(&self, time: f64, rate: f64, left: f64) -> String {
        let percent = 100.0 * self.share(time);
        let (name, duration) = (&self.name, self.duration);
        format!("{name}: {time:.4} of {duration} s simulated ({percent:.0} %), {rate:.3} s/s, {left:.0} s left")
    }

    /// [-] how much of the run is done at `time` [s]; rounding of a sum of windows does not keep it from its end.
    fn share(&self, time: f64) -> f64 {
        if self.duration > 0.0 { (time * (1.0 + 1e-9) / self.duration).min(1.0) } else { 1.0 }
    }
}

impl Observer for Reporter {
    fn see(&mut self, simulation: &Simulation) {
        self.show(simulation.time);
    }
}

/// One line of any width: what does not fit is cut off its end, where a wider bar would wrap.
fn style() -> ProgressStyle {
    let template = "{percent:>3} % {bar:16} {eta:>4} left  {wide_msg}";
    // a template that does not parse would only lose its looks
    ProgressStyle::with_template(template).unwrap_or_else(|_| ProgressStyle::default_bar())
}

impl Drop for Reporter {
    fn drop(&mut self) {
        // a run that stopped early leaves the line to what is said of it
        if let How::Bar(bar) = &self.how {
            bar.finish_and_clear();
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use indicatif::{ProgressDrawTarget, TermLike};
    use std::io::Result;
    use std::sync::{Arc, Mutex};

    /// A terminal of so many columns that keeps what is drawn.
    #[derive(Clone, Debug)]
    struct Narrow(u16, Arc<Mutex<Vec<String>>>);

    impl TermLike for Narrow {
        fn width(&self) -> u16 {
            self.0
        }
        fn move_cursor_up(&self, _: usize) -> Result<()> {
            Ok(())
        }
        fn move_cursor_down(&self, _: usize) -> Result<()> {
            Ok(())
        }
        fn move_cursor_right(&self, _: usize) -> Result<()> {
            Ok(())
        }
        fn move_cursor_left(&self, _: usize) -> Result<()> {
            Ok(())
        }
        fn write_line(&self, line: &str) -> Result<()> {
            self.write_str(line)
        }
        fn write_str(&self, text: &str) -> Result<()> {
            self.1.lock().unwrap().push(text.trim_end().to_owned());
            Ok(())
        }
        fn clear_line(&self) -> Result<()> {
            Ok(())
        }
        fn flush(&self) -> Result<()> {
            Ok(())
        }
    }

    #[test]
    fn the_bar_keeps_to_one_line() {
        for columns in [40, 60, 80, 200] {
            let terminal = Narrow(columns, Arc::default());
            let target = ProgressDrawTarget::term_like(Box::new(terminal.clone()));
            let bar = ProgressBar::with_draw_target(Some(TICKS), target).with_style(style());
            let name = "soft, a stiffness of 3000 N/m, twenty steps per contact";
            let mut reporter = Reporter::with(How::Bar(bar.clone()), name.to_owned(), 1.2345678);
            for part in 1..4 {
                reporter.show(0.3 * f64::from(part));
                bar.tick();
            }
            let drawn = terminal.1.lock().unwrap();
            let widest = drawn.iter().map(|line| line.chars().count()).max().unwrap();
            assert!(widest > 30 && widest <= usize::from(columns), "{widest} of {columns}: {drawn:#?}");
            assert!(drawn.iter().any(|line| line.contains('%') && (columns < 60 || line.contains("soft, a"))));
        }
    }
}
