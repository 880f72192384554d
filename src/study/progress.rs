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
            bar.set_style(style());
            How::Bar(bar)
        } else {
            How::Lines
        };
        let now = Instant::now();
        Self { how, began: now, said: now }
    }

    /// Takes note of where the run is.
    pub fn show(&mut self, progress: Progress) {
        // rounding of a sum of windows must not keep a run from its end
        let share = progress.time * (1.0 + 1e-9) / progress.duration;
        let done = if progress.duration > 0.0 { share.min(1.0) } else { 1.0 };
        let elapsed = self.began.elapsed().as_secs_f64();
        let rate = progress.time / elapsed.max(1e-9);
        match &self.how {
            How::Silent => {}
            How::Bar(bar) => {
                bar.set_message(format!(
                    "{}: {:.3} of {} s, {rate:.3} s/s",
                    progress.name, progress.time, progress.duration
                ));
                bar.set_position((done * TICKS as f64) as u64);
                if done >= 1.0 {
                    // a line of its own stays where the bar was
                    bar.finish_and_clear();
                    tell(line(&progress, done, rate, 0.0));
                }
            }
            How::Lines => {
                if self.said.elapsed() >= INTERVAL || done >= 1.0 {
                    self.said = Instant::now();
                    let left = if done > 0.0 { elapsed * (1.0 / done - 1.0) } else { f64::INFINITY };
                    tell(line(&progress, done, rate, left));
                }
            }
        }
    }
}

/// Where a run is, in one line: `rate` in s/s, `left` in s of wall time.
fn line(progress: &Progress, done: f64, rate: f64, left: f64) -> String {
    format!(
        "{}: {:.4} of {} s simulated ({:.0} %), {rate:.3} s/s, {left:.0} s left",
        progress.name,
        progress.time,
        progress.duration,
        100.0 * done
    )
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
            let now = Instant::now();
            let mut reporter = Reporter { how: How::Bar(bar.clone()), began: now, said: now };
            for part in 1..4 {
                let name = "soft, a stiffness of 3000 N/m, twenty steps per contact";
                reporter.show(Progress { name, time: 0.3 * f64::from(part), duration: 1.2345678 });
                bar.tick();
            }
            let drawn = terminal.1.lock().unwrap();
            let widest = drawn.iter().map(|line| line.chars().count()).max().unwrap();
            assert!(widest > 30 && widest <= usize::from(columns), "{widest} of {columns}: {drawn:#?}");
            assert!(drawn.iter().any(|line| line.contains('%') && (columns < 60 || line.contains("soft, a"))));
        }
    }
}
