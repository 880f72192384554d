//! Lab, opened by `diptych lab`: a page on which two simulations, such as soft and hard spheres, run side by side. The
//! page is served to this machine only.
//!
//! ```text
//!  browser --WebSocket--> server (one thread) --asks--> session (a thread per page) --> two panels --> Simulation
//!          <--frames------------------------- <--tells--
//! ```
//!
//! A scene is a case of `cases/` with changes in the form of `--set` arguments. If the page has not drawn the last two
//! frames, no new frame is computed, so a slow page gets fewer frames.
//!
//! The lab reads and writes no files. Its address contains a secret token. A request that names another host than this
//! machine is refused ([`access`]).

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

/// Wall time between two checks whether the user has pressed Ctrl-C.
const LOOK: Duration = Duration::from_millis(100);

/// Runs `diptych lab`: serves the page until Ctrl-C or the signal to terminate.
///
/// # Errors
/// Returns an error for bad input if the port is taken, or if the system refuses to set a handler for signals. It
/// returns a failure if standard output cannot be written.
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
