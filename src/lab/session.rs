//! Session of an open page of the lab: runs two panels (simulations side by side) while the page is visible. Each
//! session has its own thread.
//!
//! Both panels advance to the same simulated time. A frame is the picture of one instant. Nothing is computed while the
//! page is hidden or paused, or has received two frames that it has not drawn. Frames therefore do not queue up, and a
//! page always shows a recent one.

use super::engine_lock::EngineLock;
use super::protocol::{Ask, Listed, SceneChoice, Tell};
use super::scene_state::SceneState;
use super::scenes::SCENES;
use super::stage_run::StageRun;
use std::sync::mpsc::{Receiver, RecvTimeoutError, TryRecvError};
use tokio::sync::mpsc::Sender;

/// Largest number of frames (pictures of one instant) that have been sent to the page, but that the page has not drawn.
const UNDRAWN: u32 = 2;

/// [-] smallest and largest factor that a user can apply to the default pace (simulated time divided by wall time) of a
/// scene.
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
    /// Channel by which requests from the page arrive.
    pub asks: Receiver<Ask>,
    /// Channel by which messages to the page are sent.
    pub tells: Sender<PageMessage>,
    /// Lock that all sessions share. The session computes only while it holds this lock.
    pub turn: EngineLock,
}

/// State of the page, according to its requests so far: motion on or off, page visible or not, and a single frame
/// (picture of one instant) requested or not. It also has the number of frames that the page has not drawn, and the
/// factor by which the pace is multiplied.
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

    /// Handles requests of the page until the next frame (picture of one instant) is due. If no frame is to be
    /// computed, waits for a request. Returns the new scene, or `None` if the page has opened no scene that can be run.
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
                // if several choices have come, only the last is opened, because a slider sends many choices while it
                // is moved
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
    /// True if the next frame (picture of one instant) should be computed. There are four conditions. The motion is on
    /// or a single frame is requested. The page is visible. It has fewer than two undrawn frames. At least one panel
    /// has not reached its end.
    fn wants(&self, run: &StageRun) -> bool {
        let moving = self.playing || self.single;
        moving && self.looking && self.undrawn < UNDRAWN && run.panels.iter().any(|panel| panel.running().is_some())
    }
}
