//! One engine computes at a time, however many pages are open, so that a core is left for the server and the browser.

use std::sync::{Arc, Mutex, MutexGuard, PoisonError};

/// Lock of the engine, shared by all sessions of a lab: its holder may compute.
#[derive(Clone, Debug, Default)]
pub struct EngineLock(Arc<Mutex<()>>);

impl EngineLock {
    /// Waits for the lock. It is held until the returned guard is dropped.
    pub fn take(&self) -> MutexGuard<'_, ()> {
        // nothing is kept under the lock that a panic could have left half done
        self.0.lock().unwrap_or_else(PoisonError::into_inner)
    }
}
