//! Progress on the terminal: the simulated time that the run in progress has reached, its speed, and the remaining wall
//! time of all runs. If the output is not a terminal, one line is printed per interval.
//!
//! A run stores the time that it has reached in its clock, also within a window (time between two exchanges of momentum
//! with the gas). A separate thread reads this clock and updates the display. So the display changes during a long
//! window as well, and does not slow the run down.

use super::terminal::tell;
use crate::clock::Reached;
use crate::experiment::{Experiment, Model};
use crate::legible;
use crate::observe::{Needs, Observer};
use crate::output::numbers::significant;
use crate::simulation::Simulation;
use indicatif::{HumanDuration, ProgressBar, ProgressStyle};
use std::io::{IsTerminal, stderr};
use std::sync::mpsc::{RecvTimeoutError, Sender, channel};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::thread::JoinHandle;
use std::time::{Duration, Instant};

/// Wall time between two printed lines of progress, if the output is not a terminal.
pub const INTERVAL: Duration = Duration::from_secs(10);

/// Wall time between two updates of the display.
const REFRESH: Duration = Duration::from_millis(200);

/// Number of positions of the progress bar from empty to full.
const TICKS: u64 = 10_000;

/// [-] share of the wall time of a run, at its present end, over which the present speed is measured. The speed may
/// change: a settling bed, for example, becomes slower.
const RECENT: f64 = 1.0 / 3.0;

/// [s] wall time of a run after which its remaining time is estimated. A run first makes lists and tables, so its
/// initial speed is not typical.
const UNKNOWN: f64 = 1.0;

/// Progress of all runs of a command, and the thread that displays it.
pub struct Progress {
    board: Arc<Mutex<Board>>,
    show: Option<(Sender<()>, JoinHandle<()>)>,
}

/// Progress of all runs of a command, and the form of its display. The display thread and the runs share these data.
struct Board {
    runs: Vec<RunProgress>,
    display: ProgressDisplay,
    said: Instant,
}

/// Form in which progress is displayed: nothing, a bar, or lines of text.
enum ProgressDisplay {
    Silent,
    Bar(ProgressBar),
    Lines,
}

/// Progress of one run, with its name, model and duration for the display.
struct RunProgress {
    name: String,
    model: Model,
    /// [s] simulated duration of the whole run.
    duration: f64,
    stage: RunStage,
}

impl RunProgress {
    /// Progress of a run that has not begun.
    fn of(experiment: &Experiment) -> Self {
        Self {
            name: legible::message(&experiment.name).into_owned(),
            model: experiment.model(),
            duration: experiment.run.duration,
            stage: RunStage::Waiting,
        }
    }
}

enum RunStage {
    Waiting,
    Running(Track),
    /// The run has ended. The two numbers are the simulated time [s] that it reached, and its speed [s/s]: simulated time
    /// divided by wall time, not a positive number if the speed is not known.
    Over([f64; 2]),
}

/// Progress of a run that has begun, as a function of wall time.
struct Track {
    began: Instant,
    /// [s] simulated time at `began`; above 0 if the run was resumed.
    from: f64,
    reached: ProgressSource,
    /// [s] points from which the present speed is computed, in order of time. A point has the wall time since the run
    /// began, and the simulated time.
    points: Vec<[f64; 2]>,
}

/// Source of the simulated time that a run has reached, for the display.
enum ProgressSource {
    /// The run is in this process, and its clock is read. `None` if the run has no clock.
    Here(Option<Reached>),
    /// The run is in another process; the number is the simulated time [s] in its latest message.
    Told(f64),
}

impl ProgressSource {
    /// [s] simulated time that the run has reached, as far as it is known in this process; 0 without a clock.
    fn time(&self) -> f64 {
        match self {
            Self::Here(reached) => reached.as_ref().map_or(0.0, Reached::time),
            Self::Told(time) => *time,
        }
    }
}

impl Track {
    /// Progress of a run that this process observes from now on.
    fn begin(reached: ProgressSource) -> Self {
        Self { began: Instant::now(), from: reached.time(), reached, points: Vec::new() }
    }

    /// [s] simulated time that the run has reached, and its present speed [s/s]: simulated time divided by wall time.
    /// The speed is `None` while it is not known. A point for later measurements of the speed is stored, and old points
    /// are dropped.
    fn now(&mut self) -> (f64, Option<f64>) {
        let wall = self.began.elapsed().as_secs_f64();
        let time = self.reached.time();
        // a point is stored if the wall time has increased by one per cent since the previous point
        if self.points.last().is_none_or(|[last, _]| wall > 1.01 * last) {
            self.points.push([wall, time]);
        }
        let recent = self.points.partition_point(|[then, _]| *then < (1.0 - RECENT) * wall);
        self.points.drain(..recent.saturating_sub(1));
        let [then, there] = self.points[0];
        let rate = (time - there) / (wall - then);
        (time, Some(rate).filter(|rate| wall >= UNKNOWN && *rate > 0.0 && rate.is_finite()))
    }
}

impl Progress {
    /// Creates the progress display of runs with these experiments. Nothing is displayed if `quiet` is true.
    pub fn new<'a>(experiments: impl IntoIterator<Item = &'a Experiment>, quiet: bool) -> Self {
        let display = if quiet {
            ProgressDisplay::Silent
        } else if stderr().is_terminal() {
            ProgressDisplay::Bar(ProgressBar::new(TICKS).with_style(style()))
        } else {
            ProgressDisplay::Lines
        };
        let runs = experiments.into_iter().map(RunProgress::of).collect();
        let board = Board { runs, display, said: Instant::now() };
        let silent = matches!(board.display, ProgressDisplay::Silent);
        let board = Arc::new(Mutex::new(board));
        let show = (!silent).then(|| {
            let (sender, receiver) = channel();
            let board = Arc::clone(&board);
            let look = move || {
                while receiver.recv_timeout(REFRESH) == Err(RecvTimeoutError::Timeout) {
                    lock(&board).show();
                }
            };
            (sender, std::thread::spawn(look))
        });
        Self { board, show }
    }

    /// Creates an observer that reports the progress of one run; `run` is its index among the experiments.
    pub fn watch(&self, run: usize) -> Watch {
        Watch { board: Arc::clone(&self.board), run }
    }
}

impl Progress {
    /// Adds the run of an experiment to the display.
    pub fn add(&self, experiment: &Experiment) {
        lock(&self.board).runs.push(RunProgress::of(experiment));
    }

    /// Records that another process does the run with the index `run`, and has reached the simulated time `time` [s] in
    /// it.
    pub fn is_elsewhere(&self, run: usize, time: f64) {
        let stage = &mut lock(&self.board).runs[run].stage;
        if matches!(stage, RunStage::Waiting) {
            *stage = RunStage::Running(Track::begin(ProgressSource::Told(time)));
        } else if let RunStage::Running(Track { reached: ProgressSource::Told(known), .. }) = stage {
            *known = time;
        }
    }

    /// Records that another process has ended the run with the index `run`. A complete run counts as simulated to its
    /// full duration, a failed one to the time that was last reported.
    pub fn ended_elsewhere(&self, run: usize, is_complete: bool) {
        lock(&self.board).end_elsewhere(run, is_complete);
    }

    /// Indices of the runs in progress, each with the simulated time [s] that the run has reached.
    pub fn under_way(&self) -> Vec<(usize, f64)> {
        let board = lock(&self.board);
        let one = |(place, run): (usize, &RunProgress)| match &run.stage {
            RunStage::Running(track) => Some((place, track.reached.time())),
            RunStage::Waiting | RunStage::Over(_) => None,
        };
        board.runs.iter().enumerate().filter_map(one).collect()
    }
}

impl Drop for Progress {
    fn drop(&mut self) {
        if let Some((sender, thread)) = self.show.take() {
            drop(sender);
            // the display thread returns no result
            let _ = thread.join();
        }
        if let ProgressDisplay::Bar(bar) = &lock(&self.board).display {
            bar.finish_and_clear();
        }
    }
}

/// Locks the board, even if a thread has panicked while it held the lock; the entries of the board are complete even
/// then.
fn lock(board: &Mutex<Board>) -> MutexGuard<'_, Board> {
    board.lock().unwrap_or_else(PoisonError::into_inner)
}

/// Observer of one run that is called when the run starts and when it ends. In between, the display reads the clock of
/// the run. In a resumed run the first call is at the next sample (instant of measurement).
pub struct Watch {
    board: Arc<Mutex<Board>>,
    run: usize,
}

impl Observer for Watch {
    fn needs(&self) -> Needs {
        Needs::Nothing
    }

    fn see(&mut self, simulation: &Simulation) {
        let stage = &mut lock(&self.board).runs[self.run].stage;
        if matches!(stage, RunStage::Waiting) {
            let reached = ProgressSource::Here(simulation.clock().reached());
            *stage = RunStage::Running(Track::begin(reached));
        }
    }

    fn end(&mut self, simulation: &Simulation) {
        lock(&self.board).end(self.run, simulation.time);
    }
}

impl Board {
    /// Updates the display if it is due. The display shows the run in progress with the highest index.
    fn show(&mut self) {
        let due = match &self.display {
            ProgressDisplay::Silent => false,
            ProgressDisplay::Bar(_) => true,
            ProgressDisplay::Lines => self.said.elapsed() >= INTERVAL,
        };
        let Some(run) = self.runs.iter().rposition(|run| matches!(run.stage, RunStage::Running(_))) else { return };
        if !due {
            // stores the points from which the speed is measured
            self.rates();
            return;
        }
        self.said = Instant::now();
        let (done, text) = self.line(run);
        match &self.display {
            ProgressDisplay::Silent => {}
            ProgressDisplay::Bar(bar) => {
                bar.set_position((done * TICKS as f64) as u64);
                bar.set_message(text);
            }
            ProgressDisplay::Lines => tell(text),
        }
    }

    fn end_elsewhere(&mut self, run: usize, is_complete: bool) {
        let time = match &self.runs[run].stage {
            _ if is_complete => self.runs[run].duration,
            RunStage::Running(track) => track.reached.time(),
            RunStage::Waiting | RunStage::Over(_) => 0.0,
        };
        self.end(run, time);
    }

    /// Records that the run with the index `run` has ended at the simulated time `time` [s]. If this is the full
    /// duration of the run, a line is printed unless the display is silent.
    fn end(&mut self, run: usize, time: f64) {
        let (wall, from) = match &self.runs[run].stage {
            RunStage::Running(track) => (track.began.elapsed().as_secs_f64(), track.from),
            RunStage::Waiting | RunStage::Over(_) => (0.0, 0.0),
        };
        let one = &mut self.runs[run];
        one.stage = RunStage::Over([time, (time - from) / wall]);
        let complete = share(time, one.duration) >= 1.0;
        let text = format!("{}: {} s simulated (100 %) in {}", one.name, one.duration, span(wall));
        match &self.display {
            ProgressDisplay::Bar(bar) if complete => bar.suspend(|| tell(text)),
            ProgressDisplay::Lines if complete => tell(text),
            ProgressDisplay::Silent | ProgressDisplay::Bar(_) | ProgressDisplay::Lines => {}
        }
    }

    /// Simulated time [s] that each run has reached, and speed of the run [s/s]: simulated time divided by wall time,
    /// `None` if the speed is not known.
    fn rates(&mut self) -> Vec<(f64, Option<f64>)> {
        let one = |run: &mut RunProgress| match &mut run.stage {
            RunStage::Waiting => (0.0, None),
            RunStage::Running(track) => track.now(),
            // a run that had ended before the command began has the wall time 0, and thus no speed
            RunStage::Over([time, speed]) => (*time, Some(*speed).filter(|rate| rate.is_finite() && *rate > 0.0)),
        };
        self.runs.iter_mut().map(one).collect()
    }

    /// Simulated share of all runs [-], from 0 to 1, and a line of text on all runs and on the run with the index `k`.
    fn line(&mut self, k: usize) -> (f64, String) {
        let rates = self.rates();
        let (time, rate) = rates[k];
        let run = &self.runs[k];
        let percent = 100.0 * share(time, run.duration);
        let speed = rate.map_or(String::new(), |rate| format!(", {} s/s", significant(rate, 3)));
        let here = format!("{}: {} of {} s ({percent:.0} %){speed}", run.name, significant(time, 4), run.duration);
        let left = rate.map(|rate| (run.duration - time).max(0.0) / rate);
        if self.runs.len() == 1 {
            return (share(time, run.duration), format!("{}, {here}", remaining(left)));
        }
        let all = self.left(&rates);
        let simulated: f64 = self.runs.iter().zip(&rates).map(|(run, (time, _))| share(*time, run.duration)).sum();
        let over = self.runs.iter().filter(|run| matches!(run.stage, RunStage::Over(_))).count();
        let count = self.runs.len();
        let about = if all.is_some() { "about " } else { "" };
        let text = format!("all {count} runs: {over} done, {about}{}; {here}, {}", remaining(all), remaining(left));
        (simulated / count as f64, text)
    }

    /// [s] remaining wall time of all runs: the sum over the runs, divided by the number of runs in progress. A run
    /// that has not begun is assumed to be as fast as, on average, the runs with its model whose speeds are known.
    /// Without such runs, all known speeds are averaged. `None` if the speed of a run in progress is not known, or if
    /// no speed is known at all while a run waits.
    fn left(&self, rates: &[(f64, Option<f64>)]) -> Option<f64> {
        let mean = |model: Option<Model>| {
            let known = self.runs.iter().zip(rates).filter(|(run, _)| model.is_none_or(|model| run.model == model));
            let times: Vec<f64> = known.filter_map(|(_, (_, rate))| Some(1.0 / (*rate)?)).collect();
            (!times.is_empty()).then(|| times.iter().sum::<f64>() / times.len() as f64)
        };
        let one = |(run, (time, rate)): (&RunProgress, &(f64, Option<f64>))| match run.stage {
            RunStage::Over(_) => Some(0.0),
            RunStage::Running(_) => Some((run.duration - time).max(0.0) / (*rate)?),
            RunStage::Waiting => Some(run.duration * mean(Some(run.model)).or_else(|| mean(None))?),
        };
        let all: Option<f64> = self.runs.iter().zip(rates).map(one).sum();
        let at_once = self.runs.iter().filter(|run| matches!(run.stage, RunStage::Running(_))).count();
        Some(all? / at_once.max(1) as f64)
    }
}

/// Text on the remaining wall time `left` [s]; `None` means that the time is not known.
fn remaining(left: Option<f64>) -> String {
    left.map_or("estimating the time left".to_owned(), |left| format!("{} left", span(left)))
}

/// Time span `seconds` [s] as text, such as "3 minutes".
pub fn span(seconds: f64) -> String {
    /// [s] longest span that is written: a thousand years, which is within the range of the type of durations.
    const LONGEST: f64 = 3.2e10;
    if seconds < 10.0 {
        return format!("{} s", significant(seconds, 2));
    }
    HumanDuration(Duration::from_secs_f64(seconds.min(LONGEST))).to_string()
}

/// [-] share of a run of `duration` [s] that is simulated at `time` [s], exactly 1 at the end despite rounding errors.
fn share(time: f64, duration: f64) -> f64 {
    if duration > 0.0 { (time * (1.0 + 1e-9) / duration).min(1.0) } else { 1.0 }
}

/// Style of the progress line, for a terminal of any width. Text that is too long is cut off.
fn style() -> ProgressStyle {
    let template = "{percent:>3} % {bar:16} {wide_msg}";
    // the default bar is used if the template is not valid
    ProgressStyle::with_template(template).unwrap_or_else(|_| ProgressStyle::default_bar())
}

#[cfg(test)]
mod tests;
