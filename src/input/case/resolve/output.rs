//! Settings of trajectory files.

use super::Resolver;
use crate::case::diagnostic::Diagnostic;
use crate::case::file::CaseFile;
use crate::experiment::{Experiment, Trajectories, TrajectoryFormat};

/// [byte] size of a trajectory per particle and frame. A frame contains positions, velocities and five more numbers.
const BYTES: f64 = 80.0;
/// [byte] total size of the trajectories of a variant (the case with one collision model and some settings) above which
/// the user is warned.
const MUCH: f64 = 2e10;

impl Resolver {
    /// Settings of trajectory files that a case requests; `None` if it requests none.
    pub(in crate::case) fn trajectories(&mut self, file: &CaseFile) -> Result<Option<Trajectories>, Diagnostic> {
        let Some(output) = file.output.as_ref().map(|output| &output.value) else { return Ok(None) };
        let Some(typed) = &output.every else {
            if let Some(format) = &output.format {
                let message = format!("{} is not used: no trajectories are asked for", self.as_typed(format));
                self.warn(&format.origin, message, "add `every = \"1 ms\"`, or leave it out");
            }
            return Ok(None);
        };
        let help = "the time between two instants of a trajectory, for example \"1 ms\"; leave it out for none";
        let every = self.in_range(typed, help)?;
        let format = output.format.as_ref().map_or(TrajectoryFormat::Vtp, |format| format.value);
        Ok(Some(Trajectories { every, format }))
    }

    /// Warns if the trajectory files that the case requests would be very large.
    pub(super) fn check_trajectories(&mut self, file: &CaseFile, experiment: &Experiment) -> Result<(), Diagnostic> {
        let asked = self.trajectories(file)?;
        let typed = file.output.as_ref().and_then(|output| output.value.every.as_ref());
        let (Some(asked), Some(typed)) = (asked, typed) else { return Ok(()) };
        let instants = experiment.run.duration / asked.every + 1.0;
        let bytes = BYTES * instants * experiment.expected_count();
        if bytes > MUCH {
            let message =
                format!("{} makes {instants:.0} instants, some {:.0} GB a variant", self.as_typed(typed), 1e-9 * bytes);
            self.warn(&typed.origin, message, "write them less often, or make sure that the disk is large enough");
        }
        Ok(())
    }
}
