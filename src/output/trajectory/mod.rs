//! Trajectory files: the particles at the same times in all variants (experiments of a case). The formats are VTK for
//! ParaView (`.vtp` with a `.pvd` index), and extended XYZ for OVITO and ASE.
//!
//! An observer copies the required data of the simulation, and sends the copy to a thread that sorts and writes it.
//! Each file is written either completely or not at all. A frame is the state at one instant, first in memory, then as
//! a file. At any time the memory holds at most three frames. If the disk is slower than the run, the run waits.
//!
//! If several processes share a run, each process writes its particles as one piece of the frame, in a VTK file. When
//! all pieces are written, the writing thread of the lead process writes a file that joins them (`.pvtp`).

mod beside;
mod frame;
mod pieces;
mod vtp;
mod walls;

use beside::Beside;
pub(super) use beside::contact_file;
pub(super) use vtp::Vtp;
pub(super) use walls::flat;

use super::{Folder, OutputError};
use crate::contact_law::ContactLaw;
use crate::experiment::{Trajectories, TrajectoryFormat};
use crate::observe::{Needs, Observer, contact_lines};
use crate::schedule::Schedule;
use crate::simulation::Simulation;
use crate::stored::{StoreError, Stored};
use frame::{Cast, TrajectoryFrame};
use pieces::FramePiece;
use std::fmt::Write;
use std::fs::File;
use std::io::Read;
use std::path::Path;
use std::sync::mpsc::{Receiver, SyncSender, channel, sync_channel};
use std::sync::{Arc, Condvar, Mutex, MutexGuard, PoisonError};
use std::thread::{Scope, ScopedJoinHandle};

/// Name of the subfolder with the trajectory files.
pub const TRAJECTORY: &str = "trajectory";

/// True if the file was written by this program: the word `diptych` is in its first 512 bytes. Other files in the
/// folder belong to the user.
pub(super) fn is_ours(path: &Path) -> bool {
    let mut beginning = [0; 512];
    let read = File::open(path).and_then(|mut file| file.read(&mut beginning));
    read.is_ok_and(|length| beginning[..length].windows(7).any(|word| word == b"diptych"))
}

/// Messages to the thread that writes trajectory files.
enum WriterMessage {
    /// Data needed before the first frame (file of one instant): surfaces of the walls (`None` if a wall moves), times
    /// [s] of existing frames, and a flag that is true if spheres rotate.
    Begin(Option<[Vec<u8>; 3]>, Vec<f64>, bool),
    /// A further file of the next frame (instant of the trajectory), with its content: moving walls, or contacts.
    Beside(Beside, Vec<u8>),
    /// Constant data of the particles, such as ids, for all frames (instants of the trajectory) until the next such
    /// message.
    Cast(Box<Cast>),
    Frame(TrajectoryFrame),
    /// Simulated time [s] of a frame (instant of the trajectory), and the number of processes that have written their
    /// particles of this instant as a piece.
    Pieces(f64, usize),
}

/// Progress of the thread that writes trajectory files, for the observer that sends the data.
#[derive(Default)]
struct WriterProgress {
    written: Mutex<Written>,
    changed: Condvar,
}

/// Work that the thread for writing trajectory files has done so far.
#[derive(Default)]
struct Written {
    frames: u64,
    /// True if the thread has ended, so that no more files of the trajectory will be written.
    ended: bool,
    /// Reason why writing failed; `None` if it has not failed.
    failed: Option<String>,
}

impl WriterProgress {
    fn now(&self) -> MutexGuard<'_, Written> {
        self.written.lock().unwrap_or_else(PoisonError::into_inner)
    }

    fn tell(&self, change: impl FnOnce(&mut Written)) {
        change(&mut self.now());
        self.changed.notify_all();
    }

    /// Waits until `frames` frames (files of one instant each) have been written, or until the writing thread has
    /// ended.
    fn wait(&self, frames: u64) {
        drop(self.changed.wait_while(self.now(), |written| written.frames < frames && !written.ended));
    }
}

/// Guard of the thread that writes trajectory files. When it is dropped, even after a panic, the end of the thread is
/// recorded.
struct Ended(Arc<WriterProgress>);

impl Drop for Ended {
    fn drop(&mut self) {
        self.0.tell(|written| written.ended = true);
    }
}

/// Observer that sends the particles to a thread that writes trajectory files, at equal intervals of simulated time.
pub struct Trajectory<'scope> {
    folder: &'scope Folder,
    name: String,
    asked: Trajectories,
    /// Contact law by which the forces of contacts are computed; `None` if the trajectory contains no contacts.
    contacts: Option<ContactLaw>,
    /// Channel to the thread that writes the files; `None` after the trajectory is finished.
    frames: Option<SyncSender<WriterMessage>>,
    /// Channel by which the writing thread returns the data of frames (instants of the trajectory) that it has written,
    /// so that their memory is used again.
    used: Receiver<TrajectoryFrame>,
    writer: Option<ScopedJoinHandle<'scope, Result<(), OutputError>>>,
    progress: Arc<WriterProgress>,
    /// True if the surfaces of the walls have been sent to the writing thread.
    begun: bool,
    /// True if the constant data of the particles have been sent to the writing thread.
    has_cast: bool,
    /// Particles of this process at one instant. The process writes them itself if several processes share the run.
    piece: FramePiece,
    /// [s] times of all frames (instants of the trajectory), including those from earlier parts of a resumed run.
    times: Vec<f64>,
    /// Number of frames (instants of the trajectory) from earlier parts of a resumed run.
    earlier: usize,
    failed: Option<OutputError>,
}

impl<'scope> Trajectory<'scope> {
    /// Creates a trajectory, whose files are written into `trajectory/NAME` of a folder of results by a thread of
    /// `scope`.
    pub fn new<'env>(
        scope: &'scope Scope<'scope, 'env>,
        folder: &'env Folder,
        name: &str,
        asked: Trajectories,
    ) -> Self {
        let (frames, to_write) = sync_channel(1);
        let (give_back, used) = channel();
        let progress = Arc::new(WriterProgress::default());
        let ended = Ended(progress.clone());
        let format = asked.format;
        let writer = Writer {
            folder,
            name: name.to_owned(),
            format,
            frames: Vec::new(),
            listed: 0,
            walls: false,
            rotates: false,
            spare: Vec::new(),
        };
        let writer = scope.spawn(move || {
            let result = writer.write(&to_write, |frame| {
                ended.0.tell(|written| written.frames += 1);
                frame.into_iter().for_each(|frame| drop(give_back.send(frame)));
            });
            if let Err(why) = &result {
                ended.0.tell(|written| written.failed = Some(why.to_string()));
            }
            result
        });
        Self {
            folder,
            name: name.to_owned(),
            asked,
            contacts: None,
            frames: Some(frames),
            used,
            writer: Some(writer),
            progress,
            begun: false,
            has_cast: false,
            piece: FramePiece::default(),
            times: Vec::new(),
            earlier: 0,
            failed: None,
        }
    }

    /// Makes the trajectory also write the contacts of soft spheres for ParaView, with forces by the contact law `law`.
    /// No contacts are written if `law` is `None`, or if the trajectory has no files in the format VTK.
    pub fn with_contacts(self, law: Option<ContactLaw>) -> Self {
        Self { contacts: law.filter(|_| self.asked.format.is_vtp()), ..self }
    }

    fn send(&mut self, message: WriterMessage) {
        // sending fails if the writing thread has ended; `finish` then stores the error of this thread
        if self.frames.as_ref().is_none_or(|frames| frames.send(message).is_err()) {
            self.finish();
        }
    }

    /// Waits until all files of the trajectory are written, and stores the error of the writing thread if there is one.
    fn finish(&mut self) {
        self.frames = None;
        let Some(writer) = self.writer.take() else { return };
        let panicked = |_| {
            let why = std::io::Error::other("the thread that writes them has panicked");
            Err(OutputError::io("write the trajectories into", Path::new(TRAJECTORY), why))
        };
        let failed = writer.join().unwrap_or_else(panicked).err();
        self.failed = self.failed.take().or(failed);
    }

    /// True if no file of the trajectory is to be written for `time` [s], because the file exists already, or because
    /// writing has failed.
    fn is_done(&self, time: f64) -> bool {
        self.failed.is_some() || self.times.last().is_some_and(|last| *last >= time)
    }

    /// Sends the data that the writing thread requires before a frame (file of one instant). Before the first frame
    /// these are walls, times of existing frames, and whether spheres rotate. Before each frame these are moving walls,
    /// and contacts if they are requested.
    fn begin(&mut self, simulation: &Simulation) {
        let (scene, moves) = (simulation.scene(), simulation.scene().has_moving_walls());
        if !self.begun {
            let at_rest = if moves { None } else { walls::walls(scene, 0.0) };
            self.send(WriterMessage::Begin(at_rest, self.times.clone(), scene.rotation.is_some()));
            self.begun = true;
        }
        if !self.asked.format.is_vtp() {
            return;
        }
        if let Some(surfaces) = walls::walls(scene, simulation.time).filter(|_| moves) {
            self.send(WriterMessage::Beside(Beside::Walls, surfaces.concat()));
        }
        if let Some(law) = &self.contacts {
            let contacts = contact_file(simulation.time, &contact_lines(simulation, law));
            self.send(WriterMessage::Beside(Beside::Contacts, contacts));
        }
    }

    /// Sends all particles to the writing thread, unless the file of the present time exists.
    fn take_all(&mut self, simulation: &Simulation) {
        if self.is_done(simulation.time) {
            return;
        }
        self.begin(simulation);
        // with inlets or outlets, each frame may have other particles than the frame before
        if !self.has_cast || simulation.scene().has_openings() {
            self.send(WriterMessage::Cast(Box::new(Cast::of(simulation))));
            self.has_cast = true;
        }
        self.times.push(simulation.time);
        let mut frame = self.used.try_recv().unwrap_or_default();
        frame.take(simulation);
        self.send(WriterMessage::Frame(frame));
    }

    /// Waits until all files of the trajectory are written, and returns the result of writing them.
    ///
    /// # Errors
    /// A file of the trajectory could not be written.
    pub fn written(mut self) -> Result<(), OutputError> {
        self.finish();
        self.failed.map_or(Ok(()), Err)
    }
}

impl Observer for Trajectory<'_> {
    /// [s] simulated time of the next frame (file of one instant): the next whole multiple of the requested interval.
    /// So the times are equal in all experiments of a case, for windows (times between two exchanges with the gas) of
    /// any length.
    fn next(&self, now: f64, _schedule: &Schedule) -> Option<f64> {
        // 1e-9 allows for the rounding error of a sum of windows
        Some(((now / self.asked.every * (1.0 + 1e-9)).floor() + 1.0) * self.asked.every)
    }

    /// Particles that the trajectory requires. Extended XYZ and files of contacts have one file per instant, and
    /// require all particles in one process. For other VTK files, each process requires its own particles.
    fn needs(&self) -> Needs {
        if self.asked.format.is_xyz() || self.contacts.is_some() { Needs::Every(1) } else { Needs::Parts }
    }

    fn see(&mut self, simulation: &Simulation) {
        match simulation.parts() {
            Some(processes) => self.take_part(simulation, processes),
            None => self.take_all(simulation),
        }
    }

    fn needs_at_end(&self, now: f64) -> Needs {
        if self.is_done(now) { Needs::Nothing } else { self.needs() }
    }

    fn end(&mut self, simulation: &Simulation) {
        // if several processes share the run, they have written the final frame already
        if simulation.parts().is_none() {
            self.take_all(simulation);
        }
        self.finish();
    }

    /// Waits until all files of the trajectory are written, and returns their times. A resumed run continues after
    /// these times.
    fn stored(&self) -> Result<Stored, StoreError> {
        self.progress.wait((self.times.len() - self.earlier) as u64);
        Stored::of(&self.times)
    }

    fn restore(&mut self, stored: &Stored) -> Result<(), StoreError> {
        self.times = stored.read()?;
        self.earlier = self.times.len();
        Ok(())
    }

    fn stop(&self) -> Option<String> {
        self.progress.now().failed.clone().or_else(|| self.failed.as_ref().map(ToString::to_string))
    }
}

/// State of the thread that writes the frames (files of one instant each) of a trajectory.
struct Writer<'env> {
    folder: &'env Folder,
    name: String,
    format: TrajectoryFormat,
    /// Simulated time [s] of each written frame (instant of the trajectory). The flag is true if each process has
    /// written its particles of the frame as a piece.
    frames: Vec<(f64, bool)>,
    /// Number of frames (instants of the trajectory) that the index file on the disk lists. The index is written
    /// rarely.
    listed: usize,
    /// True if one file contains the walls for the whole trajectory, because no wall moves.
    walls: bool,
    /// True if spheres rotate, so that the trajectory contains spins.
    rotates: bool,
    /// Names of files that an earlier part of the run wrote for the same instants. They are removed when the index file
    /// no longer lists them.
    spare: Vec<String>,
}

impl Writer<'_> {
    fn write(
        mut self,
        messages: &Receiver<WriterMessage>,
        written: impl Fn(Option<TrajectoryFrame>),
    ) -> Result<(), OutputError> {
        let (mut cast, mut memory) = (None, Vec::new());
        for message in messages {
            match message {
                WriterMessage::Begin(walls, times, rotates) => {
                    self.rotates = rotates;
                    self.begin(walls, &times)?;
                }
                WriterMessage::Beside(what, content) => {
                    let path = what.path(&self.name, self.frames.len());
                    self.folder.write_parts(&format!("{TRAJECTORY}/{path}"), &[content])?;
                }
                WriterMessage::Cast(mut all) => {
                    all.sort();
                    cast = Some(all);
                }
                WriterMessage::Frame(mut frame) => {
                    if let Some(cast) = &cast {
                        frame.sort();
                        memory = self.frame(cast, &frame, memory)?;
                    }
                    written(Some(frame));
                }
                WriterMessage::Pieces(time, count) => {
                    // if each process writes a piece of the frame, no memory for all particles is needed
                    (cast, memory) = (None, Vec::new());
                    self.join(time, count)?;
                    written(None);
                }
            }
        }
        let gone = self.gone();
        self.list(&gone)?;
        match gone.first() {
            None => Ok(()),
            Some(first) => {
                let path = self.folder.path().join(self.file(*first));
                Err(OutputError::Gone { path, gone: gone.len(), frames: self.frames.len() })
            }
        }
    }

    /// Numbers of the frames (instants of the trajectory) whose files other programs have removed from the folder.
    fn gone(&self) -> Vec<usize> {
        let is_gone = |number: &usize| !self.folder.path().join(self.file(*number)).exists();
        (0..self.frames.len()).filter(is_gone).collect()
    }

    /// Path of the file of a frame (instant of the trajectory), relative to the folder of results. `number` counts the
    /// frames from 0.
    fn file(&self, number: usize) -> String {
        let kind = match self.frames[number].1 {
            true => "pvtp",
            false if self.format.is_vtp() => "vtp",
            false => "xyz",
        };
        format!("{TRAJECTORY}/{}/{number:06}.{kind}", self.name)
    }

    fn begin(&mut self, walls: Option<[Vec<u8>; 3]>, times: &[f64]) -> Result<(), OutputError> {
        let is_joined = |number| self.folder.path().join(pieces::joined(&self.name, number)).exists();
        self.frames = times.iter().enumerate().map(|(number, time)| (*time, is_joined(number))).collect();
        self.listed = times.len();
        self.walls = walls.is_some() && self.format.is_vtp();
        if let Some(walls) = walls.filter(|_| self.walls) {
            self.folder.write_parts(&format!("{TRAJECTORY}/{}-walls.vtp", self.name), &walls)?;
        }
        Ok(())
    }

    fn frame(&mut self, cast: &Cast, frame: &TrajectoryFrame, memory: Vec<u8>) -> Result<Vec<u8>, OutputError> {
        let number = self.frames.len();
        let path = format!("{TRAJECTORY}/{}/{number:06}", self.name);
        let mut memory = memory;
        if self.format.is_vtp() {
            let parts = frame.vtp(cast, memory);
            self.folder.write_parts(&format!("{path}.vtp"), &parts)?;
            let [_, data, _] = parts;
            memory = data;
        }
        if self.format.is_xyz() {
            self.folder.write_parts(&format!("{path}.xyz"), &[frame.xyz(cast)])?;
        }
        self.spare.push(pieces::joined(&self.name, number));
        self.spare.extend(self.pieces_from(number, 0));
        self.is_written(frame.time, false)?;
        Ok(memory)
    }

    /// Writes the file that joins the pieces of a frame (instant of the trajectory); each of `count` processes has
    /// written its particles as a piece. `time` [s] is the simulated time of the frame.
    fn join(&mut self, time: f64, count: usize) -> Result<(), OutputError> {
        let number = self.frames.len();
        let sources = (0..count).map(|rank| format!("{number:06}-{rank}.vtp"));
        self.folder.write_parts(
            &pieces::joined(&self.name, number),
            &[TrajectoryFrame::joined(time, self.rotates, sources)],
        )?;
        self.spare.push(format!("{TRAJECTORY}/{}/{number:06}.vtp", self.name));
        self.spare.extend(self.pieces_from(number, count));
        self.is_written(time, true)
    }

    /// Names of the existing pieces of a frame (files with the particles of one process at one instant) that were
    /// written by processes whose number is `rank` or higher. `number` is the number of the frame.
    fn pieces_from(&self, number: usize, rank: usize) -> Vec<String> {
        let names = (rank..).map(|rank| pieces::piece(&self.name, number, rank));
        names.take_while(|name| self.folder.path().join(name).exists()).collect()
    }

    fn is_written(&mut self, time: f64, in_pieces: bool) -> Result<(), OutputError> {
        self.frames.push((time, in_pieces));
        // the index is not written after each frame, because the total work would then grow with the square of the
        // number of frames
        if self.frames.len() <= 100 || self.frames.len() >= self.listed + self.listed / 20 {
            self.list(&[])?;
        }
        Ok(())
    }

    /// Writes the index file for ParaView, which lists time and file of each frame (instant of the trajectory). The
    /// frames with the numbers in `gone` are left out. Then removes the files in `spare`. Does nothing for a trajectory
    /// without VTK files, or if the index lists all frames.
    fn list(&mut self, gone: &[usize]) -> Result<(), OutputError> {
        if !self.format.is_vtp() || gone.is_empty() && self.listed == self.frames.len() {
            return Ok(());
        }
        let name = &self.name;
        let mut text = String::from(
            "<?xml version=\"1.0\"?>\n<!-- written by diptych -->\n<VTKFile type=\"Collection\" version=\"1.0\">\n<Collection>\n",
        );
        for (number, (time, in_pieces)) in self.frames.iter().enumerate() {
            if gone.binary_search(&number).is_ok() {
                continue;
            }
            let kind = if *in_pieces { "pvtp" } else { "vtp" };
            // writing to a string cannot fail
            let _ = writeln!(text, "<DataSet timestep=\"{time:?}\" part=\"0\" file=\"{name}/{number:06}.{kind}\"/>");
            if self.walls {
                let _ = writeln!(text, "<DataSet timestep=\"{time:?}\" part=\"1\" file=\"{name}-walls.vtp\"/>");
            }
            for what in [Beside::Walls, Beside::Contacts] {
                let (part, file) = (what as u32, what.path(name, number));
                // a frame has a file of walls only if walls move, and one of contacts only if the case requests them
                if self.folder.path().join(TRAJECTORY).join(&file).exists() {
                    let _ = writeln!(text, "<DataSet timestep=\"{time:?}\" part=\"{part}\" file=\"{file}\"/>");
                }
            }
        }
        text += "</Collection>\n</VTKFile>\n";
        self.folder.write_parts(&format!("{TRAJECTORY}/{name}.pvd"), &[text.into_bytes()])?;
        self.listed = self.frames.len();
        self.folder.remove(&std::mem::take(&mut self.spare))
    }
}
