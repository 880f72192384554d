//! Handles Ctrl-C and the signal to terminate. The first signal stops the command at the end of the present window
//! (time between two exchanges of momentum with the gas). The second signal ends the command at once.

use super::error::StudyError;
use signal_hook::consts::{SIGINT, SIGTERM};
use signal_hook::flag;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};

/// Exit code after the second signal: 128 plus the number of the signal of Ctrl-C, as shells report it.
const ENDED: i32 = 130;

/// Flag that is set when the user has asked the command to stop. Clones share the flag.
#[derive(Clone)]
pub struct Signals(Arc<AtomicBool>);

impl Signals {
    /// Sets the signal handlers. They set the flag when a signal arrives.
    ///
    /// # Errors
    /// Returns an error if the system refuses to set a handler.
    pub fn listen() -> Result<Self, StudyError> {
        Self::heard().map_err(|why| StudyError::Failed(format!("error: cannot listen to signals: {why}")))
    }

    fn heard() -> std::io::Result<Self> {
        let stop = Arc::new(AtomicBool::new(false));
        for signal in [SIGINT, SIGTERM] {
            // order of the handlers: at the first signal the flag is not set, so the program continues and the flag is
            // set; at the second signal the flag is set, and the program ends
            flag::register_conditional_shutdown(signal, ENDED, Arc::clone(&stop))?;
            flag::register(signal, Arc::clone(&stop))?;
        }
        // without this handler, a file that exceeds the size limit of the shell would end the program instead of
        // causing an error
        #[cfg(unix)]
        flag::register(signal_hook::consts::SIGXFSZ, Arc::new(AtomicBool::new(false)))?;
        Ok(Self(stop))
    }

    /// True if a signal to stop has arrived, or if the flag was set by [`raise`](Self::raise).
    pub fn say_stop(&self) -> bool {
        self.0.load(Ordering::Relaxed)
    }

    /// Sets the flag, just as if a signal to stop had arrived.
    pub fn raise(&self) {
        self.0.store(true, Ordering::Relaxed);
    }
}
