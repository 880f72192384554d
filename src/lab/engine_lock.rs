//! Lock that lets only one engine compute at a time, for any number of open pages. Other processor cores remain free
//! for the server and the browser.

use std::sync::{Arc, Mutex, MutexGuard, PoisonError};

/// Lock that all sessions of a lab share; each open page has a session. A session computes only while it holds this
/// lock.
#[derive(Clone, Debug, Default)]
pub struct EngineLock(Arc<Mutex<()>>);

impl EngineLock {
    /// Waits for the lock, and returns a guard that holds it until the guard is dropped.
    pub fn take(&self) -> MutexGuard<'_, ()> {
        // the lock protects no data, so no data can be incomplete if the thread that held it has panicked
        self.0.lock().unwrap_or_else(PoisonError::into_inner)
    }
}
