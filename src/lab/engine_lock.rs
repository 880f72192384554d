//! Lock that lets only one engine compute at a time, for any number of open pages. Other processor cores remain free
//! for the server and the browser.

use std::sync::{Arc, Mutex, MutexGuard, PoisonError};

/// Lock shared by all sessions of a lab. Only the session that has locked it may compute.
#[derive(Clone, Debug, Default)]
pub struct EngineLock(Arc<Mutex<()>>);

impl EngineLock {
    /// Waits for the lock and returns a guard. The lock is released when the guard is dropped.
    pub fn take(&self) -> MutexGuard<'_, ()> {
        // the lock protects no data, so that a panic of the thread that had locked it leaves no data incomplete
        self.0.lock().unwrap_or_else(PoisonError::into_inner)
    }
}
