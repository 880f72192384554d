//! Lab, opened by `diptych lab`: a page on which two simulations, such as soft and hard spheres, run side by side. The
//! page is served to this machine only. The module `live` shows any run on a similar page.
//!
//! ```text
//!  browser --WebSocket--> server (one thread) --asks--> session (a thread per page) --> two panels --> Simulation
//!          <--frames------------------------- <--tells--
//! ```
//!
//! A scene is a case of the folder `cases/` with changes in the form of `--set` arguments. A panel shows one
//! simulation. Asks are requests of the page, tells are messages to the page, and frames are the data of one instant,
//! from which the page draws a picture. No new frame is computed while the page has not drawn the two latest frames, so
//! a slow page gets fewer frames.
//!
//! The lab reads and writes no files, unless `--export` requests a file. The address of the lab contains a secret
//! token. A request that names another host than this machine is refused ([`access`]).

pub mod access;
mod engine_lock;
mod export;
mod frame;
mod gauge;
mod live;
mod live_session;
mod page;
mod panel;
mod parameter;
pub mod protocol;
mod scene_state;
pub mod scenes;
mod server;
mod session;
mod stage_run;

pub use live::{LiveFeed, LiveView};
pub use parameter::{LabParameter, ParameterKind, ParameterRange, ParameterValue};
pub use scene_state::SceneState;
pub use server::{LabError, LabServer};

use crate::cli;
use crate::output::put;
use crate::study::{self, CommandOrigin, Ranks, Signals, StudyError};
use std::path::Path;
use std::time::Duration;

/// Wall time between two checks whether a signal to stop has come, such as that of Ctrl-C.
const LOOK: Duration = Duration::from_millis(100);

/// Runs `diptych lab`: serves the page of the lab until Ctrl-C or the signal to terminate. With `--export`, writes a
/// page to a file instead.
///
/// # Errors
/// Returns an error for bad input if the port is taken, or if the system refuses to set a handler for signals. Returns
/// a failure if standard output cannot be written.
pub fn lab(args: &cli::Lab) -> Result<(), StudyError> {
    let bad = |why: &dyn std::fmt::Display| StudyError::Input(format!("error: {why}"));
    if let Some(file) = &args.export {
        return write_page(&args.scene, file);
    }
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

/// Writes a page with recorded runs of a scene to a new file. If the file exists, an error is returned.
fn write_page(scene: &str, file: &Path) -> Result<(), StudyError> {
    let scene = export::scene_named(scene).map_err(StudyError::Input)?;
    if file.exists() {
        let message =
            format!("error: --export {}: there is such a file\nhelp: remove it, or give another name", file.display());
        return Err(StudyError::Input(message));
    }
    let page = export::page(scene, study::tell).map_err(|why| StudyError::Failed(format!("error: {why}")))?;
    put(file, page.as_bytes())?;
    study::answer(&format!(
        "{} ({:.1} MB) opens in any browser, without the program.\n",
        file.display(),
        page.len() as f64 / 1e6
    ))
}

/// Runs `diptych run --live`: a run that a web page on this machine shows while the run goes on. The server of the page
/// ends with the run.
///
/// # Errors
/// Errors of `diptych run`, and an error for bad input if the server cannot start.
pub fn run_live(args: &cli::Run, ranks: &Ranks) -> Result<(), StudyError> {
    let mut server = None;
    let title = args.case.display().to_string();
    let result = study::run(
        args,
        CommandOrigin::Typed,
        ranks,
        Some(&mut |experiment| {
            let view = LiveView::new(experiment, &title, true);
            let lab = LabServer::start_live(view.feed());
            let lab = server.insert(lab.map_err(|why| StudyError::Input(format!("error: {why}")))?);
            study::tell(format!(
                "The run is shown at {} until it ends. Open this in a browser on this machine.",
                lab.url()
            ));
            Ok(Box::new(view))
        }),
    );
    if let Some(server) = server {
        server.stop();
    }
    result
}
