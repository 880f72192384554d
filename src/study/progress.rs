//! Progress on the terminal: rate and time left; one line per interval when piped.

use super::execute::Progress;
use super::terminal::tell;
use indicatif::{ProgressBar, ProgressStyle};
use std::io::{IsTerminal, stderr};
use std::time::{Duration, Instant};

/// Between lines when there is no terminal.
pub const INTERVAL: Duration = Duration::from_secs(10);

/// Resolution of the bar.
const TICKS: u64 = 10_000;

/// Shows how a run goes.
pub struct Reporter {
    how: How,
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
    pub fn new(quiet: bool) -> Self {
        let how = if quiet {
            How::Silent
        } else if stderr().is_terminal() {
            let bar = ProgressBar::new(TICKS);
            // a template that does not parse would only lose its looks
            if let Ok(style) = ProgressStyle::with_template("{prefix:24} {wide_bar} {percent:>3} %  {msg}, {eta} left")
            {
                bar.set_style(style);
            }
            How::Bar(bar)
        } else {
            How::Lines
        };
        let now = Instant::now();
        Self { how, began: now, said: now }
    }

    /// Takes note of where the run is.
    pub fn show(&mut self, progress: Progress) {
        let done = if progress.duration > 0.0 { (progress.time / progress.duration).min(1.0) } else { 1.0 };
        let elapsed = self.began.elapsed().as_secs_f64();
        let rate = progress.time / elapsed.max(1e-9);
        match &self.how {
            How::Silent => {}
            How::Bar(bar) => {
                bar.set_prefix(progress.name.to_owned());
                bar.set_message(format!("{:.3} of {} s, {rate:.3} s/s", progress.time, progress.duration));
                bar.set_position((done * TICKS as f64) as u64);
            }
            How::Lines => {
                if self.said.elapsed() >= INTERVAL || done >= 1.0 {
                    self.said = Instant::now();
                    let left = if done > 0.0 { elapsed * (1.0 / done - 1.0) } else { f64::INFINITY };
                    tell(format_args!(
                        "{}: {:.4} of {} s simulated ({:.0} %), {rate:.3} s/s, {left:.0} s left",
                        progress.name,
                        progress.time,
                        progress.duration,
                        100.0 * done
                    ));
                }
            }
        }
    }
}

impl Drop for Reporter {
    fn drop(&mut self) {
        if let How::Bar(bar) = &self.how {
            bar.finish();
        }
    }
}
