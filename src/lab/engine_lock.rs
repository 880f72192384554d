//! Lock by which only one engine computes at a time, for any number of open pages. Another core then remains for the
//! server and the browser.

use std::sync::{Arc, Mutex, MutexGuard, PoisonError};

/// Lock shared by all sessions of a lab; only the session that holds the lock may compute.
#[derive(Clone, Debug, Default)]
pub struct EngineLock(Arc<Mutex<()>>);

impl EngineLock {
    /// Waits for the lock, which is held until the returned guard is dropped.
    pub fn take(&self) -> MutexGuard<'_, ()> {
        // the lock protects no data, so no data can be incomplete after a panic of the thread that held the lock
        self.0.lock().unwrap_or_else(PoisonError::into_inner)
    }
}
