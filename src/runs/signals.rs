//! Ctrl-C and the signal to end: once to stop at the end of the window, twice to end at once.

use super::error::StudyError;
use signal_hook::consts::{SIGINT, SIGTERM};
use signal_hook::flag;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};

/// Exit code of a program that Ctrl-C has ended, as shells report it: 128 plus the number of the signal.
const ENDED: i32 = 130;

/// Flag that the user wants the command to stop.
#[derive(Clone)]
pub struct Signals(Arc<AtomicBool>);

impl Signals {
    /// Takes note of the signals from now on.
    ///
    /// # Errors
    /// The system refuses to set the handler.
    pub fn listen() -> Result<Self, StudyError> {
        Self::heard().map_err(|why| StudyError::Failed(format!("error: cannot listen to signals: {why}")))
    }

    fn heard() -> std::io::Result<Self> {
        let stop = Arc::new(AtomicBool::new(false));
        for signal in [SIGINT, SIGTERM] {
            // in this order: the first signal finds the flag down and raises it, the second finds it raised
            flag::register_conditional_shutdown(signal, ENDED, Arc::clone(&stop))?;
            flag::register(signal, Arc::clone(&stop))?;
        }
        // a file that outgrows the limit of a shell is an error to be reported, not the end of the program
        #[cfg(unix)]
        flag::register(signal_hook::consts::SIGXFSZ, Arc::new(AtomicBool::new(false)))?;
        Ok(Self(stop))
    }

    /// True if a signal to stop has come.
    pub fn say_stop(&self) -> bool {
        self.0.load(Ordering::Relaxed)
    }

    /// Raises the flag as a signal to stop would.
    pub fn raise(&self) {
        self.0.store(true, Ordering::Relaxed);
    }
}
