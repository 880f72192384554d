//! Tests of the display of progress.

use super::*;
use crate::clock::Clock;
use indicatif::{ProgressDrawTarget, TermLike};
use std::io::Result;

/// Terminal for tests, with a given number of columns. It stores the text that is drawn on it.
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

/// Creates a run that has reached the simulated time `time` [s] after the wall time `wall` [s], at constant speed.
fn running(model: Model, duration: f64, time: f64, wall: f64) -> RunProgress {
    let clock = Clock::wall();
    clock.tell(time);
    let began = Instant::now().checked_sub(Duration::from_secs_f64(wall)).unwrap();
    let track = Track { began, from: 0.0, reached: ProgressSource::Here(clock.reached()), points: vec![[0.0, 0.0]] };
    let name = "soft, a stiffness of 3000 N/m, twenty steps per contact".to_owned();
    RunProgress { name, model, duration, stage: RunStage::Running(track) }
}

fn board(runs: Vec<RunProgress>, display: ProgressDisplay) -> Board {
    Board { runs, display, said: Instant::now() }
}

#[test]
fn the_bar_keeps_to_one_line() {
    for columns in [40, 60, 80, 200] {
        let terminal = Narrow(columns, Arc::default());
        let target = ProgressDrawTarget::term_like(Box::new(terminal.clone()));
        let bar = ProgressBar::with_draw_target(Some(TICKS), target).with_style(style());
        let mut board = board(vec![running(Model::Soft, 1.2345678, 0.3, 3.0)], ProgressDisplay::Bar(bar.clone()));
        board.show();
        bar.tick();
        let drawn = terminal.1.lock().unwrap();
        let widest = drawn.iter().map(|line| line.chars().count()).max().unwrap();
        assert!(widest > 30 && widest <= usize::from(columns), "{widest} of {columns}: {drawn:#?}");
        assert!(drawn.iter().any(|line| line.contains("left") && (columns < 60 || line.contains("soft, a"))));
    }
}

#[test]
fn nothing_is_said_of_the_time_left_before_it_is_known() {
    let line = |time, wall| board(vec![running(Model::Hard, 2.0, time, wall)], ProgressDisplay::Lines).line(0).1;
    assert!(line(0.0, 30.0).starts_with("estimating the time left"), "no step has been done");
    assert!(line(0.5, 0.2).starts_with("estimating the time left"), "{}", line(0.5, 0.2));
    // after 30 s a quarter of the work is done
    let known = line(0.5, 30.0);
    assert!(known.starts_with("90 seconds left") || known.starts_with("2 minutes left"), "{known}");
}

/// Checks the remaining time of four runs. A hard run of 1 s ended after 10 s, and a soft run has simulated half of
/// 1 s in 40 s. Another soft run and another hard run have not begun.
#[test]
fn the_time_left_is_that_of_all_runs() {
    let waiting = |model| RunProgress { stage: RunStage::Waiting, ..running(model, 1.0, 0.0, 0.0) };
    let over = RunProgress { stage: RunStage::Over([1.0, 0.1]), ..running(Model::Hard, 1.0, 1.0, 10.0) };
    let running = running(Model::Soft, 1.0, 0.5, 40.0);
    let mut board = board(vec![over, running, waiting(Model::Soft), waiting(Model::Hard)], ProgressDisplay::Lines);
    let rates = board.rates();
    let left = board.left(&rates).unwrap();
    // 40 s for this run, 80 s for the other soft run and 10 s for the other hard run; the clock continues during
    // the test
    assert!((left - 130.0).abs() < 1.0, "{left}");
    let (done, text) = board.line(1);
    assert!((done - 0.375).abs() < 1e-6 && text.starts_with("all 4 runs: 1 done, about 2 minutes left"), "{text}");
}

#[test]
fn a_run_that_fails_in_another_process_is_not_complete() {
    for (is_complete, time) in [(true, 2.0), (false, 0.5)] {
        let mut board = board(vec![running(Model::Soft, 2.0, 0.5, 30.0)], ProgressDisplay::Lines);
        board.end_elsewhere(0, is_complete);
        assert!(matches!(board.runs[0].stage, RunStage::Over([reached, _]) if reached == time));
    }
}

/// Checks that the present speed of a run is the recent one: the run simulated its first nine tenths quickly and is
/// now slow.
#[test]
fn the_speed_is_that_of_late() {
    let mut run = running(Model::Soft, 1.0, 0.95, 60.0);
    let RunStage::Running(track) = &mut run.stage else { panic!("it runs") };
    track.points = vec![[0.0, 0.0], [1.0, 0.9], [30.0, 0.92], [40.0, 0.93], [50.0, 0.94]];
    let rate = track.now().1.unwrap();
    assert!((rate - 0.001).abs() < 1e-5, "{rate} s/s");
}

/// A run that was resumed at half of its duration of 2 s, and ended 10 s later, has the speed of these 10 s.
#[test]
fn the_speed_of_a_resumed_run_is_that_since_the_resumption() {
    let mut run = running(Model::Soft, 2.0, 2.0, 10.0);
    let RunStage::Running(track) = &mut run.stage else { panic!("it runs") };
    track.from = 1.0;
    let mut board = board(vec![run], ProgressDisplay::Lines);
    board.end(0, 2.0);
    let rate = board.rates()[0].1.unwrap();
    assert!((rate - 0.1).abs() < 1e-3, "{rate} s/s");
}
