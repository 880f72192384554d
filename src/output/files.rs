//! The folder results go to: refused before computing, filled file by file, each whole or absent.

use super::OutputError;
use super::limits::MAPS;
use std::fs::{File, TryLockError};
use std::io::Write;
use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicBool, Ordering};

/// The file whose presence says that all results are there. It is written last.
pub const SUMMARY: &str = "summary.json";

/// The subfolder of pictures.
pub const FIGURES: &str = "figures";

/// The page; a comparison that was stopped between two variants leaves it without a [`SUMMARY`].
const REPORT: &str = "report.html";

/// What a run leaves beside [`SUMMARY`]; cleared when it is replaced, so that no file of another run stays behind.
const TABLES: [&str; 7] =
    ["profiles.csv", "impacts.csv", "overlaps.csv", "state.csv", "impact.csv", "chart.csv", REPORT];

/// The file that a command keeps locked while it writes into the folder.
const LOCK: &str = ".diptych-lock";

/// An output folder that exists, can be written to, is written to by nobody else, and holds no results that the user
/// did not offer to replace.
#[derive(Debug)]
pub struct Folder {
    path: PathBuf,
    /// Whether results of an earlier run are still there. They stay until the first new file is ready.
    stale: AtomicBool,
    /// The lock file, locked until this is dropped or the process ends in whatever way.
    lock: Option<File>,
}

impl Folder {
    /// Makes the folder (and its `figures/`) if it is not there. Call it before computing: it refuses what would fail after.
    ///
    /// # Errors
    /// [`OutputError::Occupied`] if it holds a `summary.json` or `report.html` and `overwrite` is false; [`OutputError::InUse`] if
    /// another command writes into it at present; [`OutputError::Io`] if it cannot be made or written to.
    pub fn create(path: impl Into<PathBuf>, overwrite: bool) -> Result<Self, OutputError> {
        let path = path.into();
        let is_occupied = || [SUMMARY, REPORT].iter().any(|name| path.join(name).exists());
        if is_occupied() && !overwrite {
            return Err(OutputError::Occupied { path });
        }
        std::fs::create_dir_all(&path).map_err(|source| OutputError::io("make the folder", &path, source))?;
        let lock = lock(&path)?;
        // whoever had the folder locked may have finished since it was looked at
        let occupied = is_occupied();
        if occupied && !overwrite {
            unlock(&path, lock);
            return Err(OutputError::Occupied { path });
        }
        let figures = path.join(FIGURES);
        std::fs::create_dir_all(&figures).map_err(|source| OutputError::io("make the folder", &figures, source))?;
        for place in [&path, &figures] {
            tempfile::tempfile_in(place).map_err(|source| OutputError::io("write into", place, source))?;
        }
        Ok(Self { path, stale: AtomicBool::new(occupied), lock })
    }

    /// Where it is.
    pub fn path(&self) -> &Path {
        &self.path
    }

    /// Writes one file, `name` being relative to the folder: aside first, then renamed, so that whoever reads it sees
    /// the whole file or none. Returns where it is.
    ///
    /// # Errors
    /// [`OutputError::Io`] with the path, if the disk refuses; a file of that name that was there stays as it was.
    pub fn write(&self, name: &str, bytes: &[u8]) -> Result<PathBuf, OutputError> {
        if self.stale.swap(false, Ordering::Relaxed) {
            self.clear()?;
        }
        let target = self.path.join(name);
        let fail = |source| OutputError::io("write", &target, source);
        let place = target.parent().unwrap_or(&self.path);
        std::fs::create_dir_all(place).map_err(fail)?;
        let mut aside = tempfile::Builder::new().prefix(".diptych-").tempfile_in(place).map_err(fail)?;
        aside.write_all(bytes).map_err(fail)?;
        // Temporary files are private; results are for whoever may read the folder.
        #[cfg(unix)]
        {
            use std::os::unix::fs::PermissionsExt;
            aside.as_file().set_permissions(std::fs::Permissions::from_mode(0o644)).map_err(fail)?;
        }
        aside.persist(&target).map_err(|error| fail(error.error))?;
        Ok(target)
    }

    /// Removes the files an earlier run wrote, the summary first: without it a folder does not count as results.
    fn clear(&self) -> Result<(), OutputError> {
        let mut old: Vec<PathBuf> =
            std::iter::once(&SUMMARY).chain(&TABLES).map(|name| self.path.join(name)).filter(|p| p.exists()).collect();
        for (folder, extension) in [(FIGURES, "svg"), (MAPS, "csv")] {
            old.extend(self.files(folder, extension)?);
        }
        remove(&old)
    }

    /// Removes the pictures of other names, which a comparison of fewer variants has left.
    ///
    /// # Errors
    /// [`OutputError::Io`] with the path, if the disk refuses.
    pub fn keep_pictures(&self, names: &[&str]) -> Result<(), OutputError> {
        let mut others = self.files(FIGURES, "svg")?;
        others.retain(|file| !file.file_stem().is_some_and(|stem| names.iter().any(|name| stem == *name)));
        remove(&others)
    }

    /// The files of a subfolder with that extension.
    fn files(&self, folder: &str, extension: &str) -> Result<Vec<PathBuf>, OutputError> {
        let folder = self.path.join(folder);
        if !folder.exists() {
            return Ok(Vec::new());
        }
        let entries = std::fs::read_dir(&folder).map_err(|source| OutputError::io("read", &folder, source))?;
        let files = entries.flatten().map(|entry| entry.path());
        Ok(files.filter(|file| file.extension().is_some_and(|e| e == extension)).collect())
    }
}

impl Drop for Folder {
    fn drop(&mut self) {
        unlock(&self.path, self.lock.take());
    }
}

/// Locks a folder for this process; `None` on a file system that knows no locks. The system gives the lock back when the
/// process ends, so that the lock file of a run that was killed holds nobody up.
fn lock(folder: &Path) -> Result<Option<File>, OutputError> {
    let path = folder.join(LOCK);
    let fail = |source| OutputError::io("write into", folder, source);
    loop {
        let file = File::options().create(true).append(true).open(&path).map_err(fail)?;
        match file.try_lock() {
            Ok(()) if is_at(&file, &path) => return Ok(Some(file)),
            // whoever held it removed the file between opening and locking it here: lock the new one
            Ok(()) => {}
            Err(TryLockError::WouldBlock) => return Err(OutputError::InUse { path: folder.to_owned() }),
            Err(TryLockError::Error(why)) if why.kind() == std::io::ErrorKind::Unsupported => {
                unlock(folder, Some(file));
                return Ok(None);
            }
            Err(TryLockError::Error(why)) => return Err(fail(why)),
        }
    }
}

/// Removes the lock file, still locked, and gives the lock back. A file that cannot be removed holds nobody up either.
fn unlock(folder: &Path, lock: Option<File>) {
    if let Some(file) = lock {
        let _ = std::fs::remove_file(folder.join(LOCK));
        drop(file);
    }
}

/// Whether the open file is the one that the path leads to.
#[cfg(unix)]
fn is_at(file: &File, path: &Path) -> bool {
    use std::os::unix::fs::MetadataExt;
    match (file.metadata(), std::fs::metadata(path)) {
        (Ok(open), Ok(there)) => (open.dev(), open.ino()) == (there.dev(), there.ino()),
        _ => false,
    }
}

/// Elsewhere an open file cannot be replaced by another of its name.
#[cfg(not(unix))]
fn is_at(_: &File, path: &Path) -> bool {
    path.exists()
}

fn remove(files: &[PathBuf]) -> Result<(), OutputError> {
    for path in files {
        std::fs::remove_file(path).map_err(|source| OutputError::io("remove the old", path, source))?;
    }
    Ok(())
}
