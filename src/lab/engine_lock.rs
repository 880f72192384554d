//! One engine computes at a time, however many pages are open, so that a core is left for the server and the browser.

use std::sync::{Arc, Mutex, MutexGuard, PoisonError};

/// Whose turn it is, shared by all sessions of a lab.
#[derive(Clone, Debug, Default)]
pub struct EngineLock(Arc<Mutex<()>>);

impl EngineLock {
    /// Waits for the turn, and holds it until the answer is dropped.
    pub fn take(&self) -> MutexGuard<'_, ()> {
        // nothing is kept under the lock that a panic could have left half done
        self.0.lock().unwrap_or_else(PoisonError::into_inner)
    }
}
