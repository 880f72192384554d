//! Session of an open page of the lab: runs two panels side by side while the page is visible. Each session has its own
//! thread.
//!
//! Both panels advance to equal simulated times. Nothing is computed while the page has two frames that it has not
//! drawn. A slow, hidden or paused page therefore causes no work, and a page always shows a recent frame.

use super::engine_lock::EngineLock;
use super::frame::{Head, Now, PanelComparison, bytes};
use super::panel::LabPanel;
use super::protocol::{Ask, Listed, SceneChoice, Tell};
use super::scene_state::SceneState;
use super::scenes::SCENES;
use crate::clock::Clock;
use crate::outcome::Outcome;
use crate::statistics::{U, UU, VV, WW};
use crate::study::judge;
use std::sync::mpsc::{Receiver, RecvTimeoutError, TryRecvError};
use std::time::Duration;
use tokio::sync::mpsc::Sender;

/// Largest number of frames that have been sent to the page, but that the page has not drawn.
const UNDRAWN: u32 = 2;

/// Wall time from one frame to the next.
const FRAME: Duration = Duration::from_millis(33);

/// Largest wall time that one panel may compute for one frame. A panel that needs longer shows the simulated time that
/// it has reached.
const BUDGET: Duration = Duration::from_millis(14);

/// Largest wall time since the last frame that is converted to simulated time for the next frame. The rest of a longer
/// pause is left out.
const LATEST: Duration = Duration::from_millis(100);

/// Wall time from one comparison of the panels to the next.
const VERDICT: Duration = Duration::from_millis(1500);

/// [-] margin of equivalence of the comparison, equal to the default of the command `compare`.
const MARGIN: f64 = 0.01;

/// [-] smallest and largest factor that a user can apply to the default pace of a scene.
const PACES: [f64; 2] = [0.02, 10.0];

/// Message of a session to its page.
#[derive(Debug)]
pub enum PageMessage {
    /// Message of the type `Tell`, as JSON text.
    Text(String),
    /// Frame (data of one instant, from which the page draws), as bytes.
    Frame(Vec<u8>),
}

/// Session of one open page of the lab: channels to the page, and the lock of the engines.
pub struct Session {
    /// Channel of requests from the page.
    pub asks: Receiver<Ask>,
    /// Channel of messages to the page.
    pub tells: Sender<PageMessage>,
    /// Lock that all sessions share. The session computes only while it holds this lock.
    pub turn: EngineLock,
}

/// State of the page, from its requests so far. It consists of motion on or off, page visible or not, single frame
/// requested or not, number of frames that the page has not drawn, and factor on the pace.
struct Wish {
    playing: bool,
    looking: bool,
    single: bool,
    undrawn: u32,
    factor: f64,
}

/// Error that ends the session: the page has been closed.
struct Gone;

impl Session {
    /// Runs the session until the user closes the page.
    pub fn run(self) {
        let scenes = SCENES.iter().map(|scene| Listed { name: scene.name, title: scene.title }).collect();
        let mut next =
            self.tell(&Tell::Scenes { scenes, version: env!("CARGO_PKG_VERSION") }).and_then(|()| self.first());
        let mut wish = Wish { playing: true, looking: true, single: false, undrawn: 0, factor: 1.0 };
        while let Ok(stage) = next {
            next = self.play(&stage, &mut wish);
        }
    }

    fn tell(&self, tell: &Tell) -> Result<(), Gone> {
        let text = serde_json::to_string(tell).map_err(|_| Gone)?;
        self.tells.blocking_send(PageMessage::Text(text)).map_err(|_| Gone)
    }

    /// Waits until the page opens a scene that can be run.
    fn first(&self) -> Result<SceneState, Gone> {
        loop {
            if let Ask::Open(choice) = self.asks.recv().map_err(|_| Gone)?
                && let Some(stage) = self.open(&choice)?
            {
                return Ok(stage);
            }
        }
    }

    /// Opens the scene that the user has chosen on the page, and sends its description. If the scene cannot be run, the
    /// reason is sent, and `None` is returned.
    fn open(&self, choice: &SceneChoice) -> Result<Option<SceneState>, Gone> {
        let stage = {
            let _turn = self.turn.take();
            SceneState::open(choice)
        };
        match stage {
            Ok(stage) => self.tell(&Tell::Opened(Box::new(stage.opened()))).map(|()| Some(stage)),
            Err(why) => self.tell(&Tell::Refused { serial: choice.serial, why }).map(|()| None),
        }
    }

    /// Runs a scene until the page opens another scene, which is returned.
    fn play(&self, stage: &SceneState, wish: &mut Wish) -> Result<SceneState, Gone> {
        let mut run = StageRun::new(stage);
        // the initial state is always sent, also to a paused page
        self.show(&mut run, wish)?;
        loop {
            if let Some(stage) = self.listen(wish, &run)? {
                return Ok(stage);
            }
            if wish.wants(&run) && run.is_due() {
                let stretch = run.stretch(wish.factor, wish.single);
                wish.single = false;
                {
                    let _turn = self.turn.take();
                    run.go_on(stretch);
                }
                self.show(&mut run, wish)?;
            }
        }
    }

    /// Handles requests of the page until the next frame is due. Returns the new scene if the page has opened one.
    fn listen(&self, wish: &mut Wish, run: &StageRun) -> Result<Option<SceneState>, Gone> {
        let mut choice = None;
        let mut ask = if wish.wants(run) {
            match self.asks.recv_timeout(run.until_next_frame()) {
                Ok(ask) => Some(ask),
                Err(RecvTimeoutError::Timeout) => None,
                Err(RecvTimeoutError::Disconnected) => return Err(Gone),
            }
        } else {
            Some(self.asks.recv().map_err(|_| Gone)?)
        };
        while let Some(next) = ask {
            match next {
                // only the last of several choices is opened, because a slider sends many choices while it is moved
                Ask::Open(other) => choice = Some(other),
                Ask::Play { on } => wish.playing = on,
                Ask::Step => wish.single = true,
                Ask::Pace { factor } if factor.is_finite() => wish.factor = factor.clamp(PACES[0], PACES[1]),
                Ask::Pace { .. } => {}
                Ask::Look { on } => wish.looking = on,
                Ask::Drawn => wish.undrawn = wish.undrawn.saturating_sub(1),
            }
            ask = match self.asks.try_recv() {
                Ok(ask) => Some(ask),
                Err(TryRecvError::Empty) => None,
                Err(TryRecvError::Disconnected) => return Err(Gone),
            };
        }
        match choice {
            Some(choice) => self.open(&choice),
            None => Ok(None),
        }
    }

    fn show(&self, run: &mut StageRun, wish: &mut Wish) -> Result<(), Gone> {
        wish.undrawn += 1;
        self.tells.blocking_send(PageMessage::Frame(run.frame())).map_err(|_| Gone)
    }
}

impl Wish {
    /// True if the next frame should be computed: the motion is on, the page is visible and has drawn enough frames,
    /// and at least one panel has not reached its end.
    fn wants(&self, run: &StageRun) -> bool {
        let moving = self.playing || self.single;
        moving && self.looking && self.undrawn < UNDRAWN && run.panels.iter().any(|panel| panel.running().is_some())
    }
}

/// Panels of an opened scene while they run, with the times of the last frame and of the last comparison.
struct StageRun<'a> {
    stage: &'a SceneState,
    panels: [LabPanel<'a>; 2],
    clock: Clock,
    /// Wall time at which the last frame was made, measured by `clock`.
    shown: Duration,
    /// Comparison of the panels for the next frame; `None` if the page has got the last comparison.
    judged: Option<PanelComparison>,
    /// Wall time of the last comparison of the panels, measured by `clock`.
    judged_at: Duration,
}

impl<'a> StageRun<'a> {
    fn new(stage: &'a SceneState) -> Self {
        let frame = stage.pace() * FRAME.as_secs_f64();
        let panel =
            |side: usize| LabPanel::new(&stage.experiments[side], stage.starts[side].clone(), stage.scene.gauge, frame);
        let clock = Clock::wall();
        let now = clock.now();
        Self { stage, panels: [panel(0), panel(1)], clock, shown: now, judged: None, judged_at: now }
    }

    fn is_due(&self) -> bool {
        self.clock.now() >= self.shown + FRAME
    }

    fn until_next_frame(&self) -> Duration {
        // at least 1 ms, so that other sessions can get the lock of the engine
        (self.shown + FRAME).saturating_sub(self.clock.now()).max(Duration::from_millis(1))
    }

    /// [s] simulated time by which the panels advance for the next frame: wall time since the last frame times pace.
    /// `factor` [-] multiplies the default pace. If `single` is true, the wall time is that from one frame to the next.
    fn stretch(&self, factor: f64, single: bool) -> f64 {
        let passed = if single { FRAME } else { (self.clock.now() - self.shown).min(LATEST) };
        self.stage.pace() * factor * passed.as_secs_f64()
    }

    /// Advances both panels to equal simulated times: the time of the panel that is behind, plus `stretch` [s].
    fn go_on(&mut self, stretch: f64) {
        let times = self.panels.iter().filter_map(LabPanel::running);
        let until = times.fold(f64::INFINITY, f64::min) + stretch;
        self.panels.iter_mut().for_each(|panel| panel.run(until, BUDGET));
        let now = self.clock.now();
        if now - self.judged_at > VERDICT {
            self.judge();
            self.judged_at = self.clock.now();
        }
    }

    /// Compares the results of both panels so far. Nothing is compared in scenes whose statistics are not tested.
    fn judge(&mut self) {
        let [Some(left), Some(right)] = [self.panels[0].outcome(), self.panels[1].outcome()] else { return };
        let outcomes = [left, right];
        self.judged = judge(&outcomes, &[], MARGIN).into_iter().next().map(|verdict| {
            let answer = serde_json::to_value(verdict.answer).ok();
            let answer = answer.as_ref().and_then(serde_json::Value::as_str).unwrap_or_default().to_owned();
            let from = outcomes[0].steadiness.from;
            PanelComparison {
                answer,
                sentence: verdict.sentence,
                from,
                profiles: [profile(&outcomes[0]), profile(&outcomes[1])],
            }
        });
    }

    fn frame(&mut self) -> Vec<u8> {
        self.shown = self.clock.now();
        let sides: [Now; 2] = [self.panels[0].now(), self.panels[1].now()];
        let head = Head { serial: self.stage.choice.serial, sides: &sides, judged: self.judged.take() };
        let particles = [self.panels[0].particles(), self.panels[1].particles()];
        bytes(&head, [&particles[0], &particles[1]])
    }
}

/// Profile of a channel for the page, one row for each slice: height y [mm], streamwise velocity and its standard error
/// [m/s], and granular temperature [m²/s²].
fn profile(outcome: &Outcome) -> Vec<[Option<f64>; 4]> {
    let rows = outcome.profiles.slices.iter().map(|row| {
        let normal: Option<Vec<f64>> = [UU, VV, WW].into_iter().map(|one| Some(row.of(one)?.value)).collect();
        let temperature = normal.map(|normal| normal.iter().sum::<f64>() / 3.0);
        let mean = row.of(U);
        [Some(1e3 * row.y), mean.map(|mean| mean.value), mean.and_then(|mean| mean.error), temperature]
    });
    rows.collect()
}
