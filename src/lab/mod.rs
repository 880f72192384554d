//! `diptych lab`: a page, served on this machine only, on which both collision models run side by side.
//!
//! ```text
//!  browser --WebSocket--> server (one thread) --asks--> session (a thread per page) --> two panels --> Simulation
//!          <--frames------------------------- <--tells--
//! ```
//!
//! A scene is a case of `cases/` with changes, as `--set` makes them: there is no second description of a scene here. Frames
//! are made only when the page has drawn the ones before, so that a slow page drops frames and nothing piles up.
//!
//! Nothing is read from or written to the disk. The address has a token that cannot be guessed. A request under another
//! name than this machine's is refused ([`guard`]).

pub mod access;
mod engine_lock;
mod frame;
mod gauge;
mod page;
mod panel;
mod parameter;
pub mod protocol;
mod scene_state;
pub mod scenes;
mod server;
mod session;

pub use parameter::{LabParameter, ParameterKind, ParameterRange, ParameterValue};
pub use scene_state::SceneState;
pub use server::{LabError, LabServer};

use crate::cli;
use crate::study::{self, Signals, StudyError};
use std::time::Duration;

/// Between two looks at whether Ctrl-C has come.
const LOOK: Duration = Duration::from_millis(100);

/// Serves the page until Ctrl-C or the signal to end.
///
/// # Errors
/// The port is taken, or the system refuses to set a handler for signals: bad input. Standard output cannot be written.
pub fn lab(args: &cli::Lab) -> Result<(), StudyError> {
    let bad = |why: &dyn std::fmt::Display| StudyError::Input(format!("error: {why}"));
    let signals = Signals::listen()?;
    let lab = LabServer::start(args.port.unwrap_or(0)).map_err(|why| bad(&why))?;
    let url = lab.url();
    study::answer(&format!("The lab is at {url}\nOpen it in a browser on this machine. Ctrl-C ends it.\n"))?;
    while !signals.say_stop() {
        std::thread::sleep(LOOK);
    }
    lab.stop();
    Ok(())
}
