//! Files for ParaView that a frame (instant) of a trajectory has in addition to the file of its particles.

use super::Vtp;
use crate::observe::ContactLine;

/// File that a frame (instant of a trajectory) has in addition to the file of its particles. The number of each kind,
/// such as 1 for `Walls`, is the part number of the file in the index for ParaView.
#[derive(Clone, Copy)]
pub(super) enum Beside {
    /// Surfaces of the walls at one instant, if walls move.
    Walls = 1,
    /// Contacts of the particles at one instant, if the case requests the contact network.
    Contacts = 2,
}

impl Beside {
    /// Path of the file for the frame (instant) with the number `number` of the trajectory `name`, relative to the
    /// folder of the trajectories.
    pub(super) fn path(self, name: &str, number: usize) -> String {
        let kind = match self {
            Self::Walls => "walls",
            Self::Contacts => "contacts",
        };
        format!("{name}/{number:06}-{kind}.vtp")
    }
}

/// File for ParaView with contacts as lines, each with its force [N] and the ids of its two particles. For a wall, the
/// id -1 is written. `time` [s] is the simulated time.
pub(in crate::output) fn contact_file(time: f64, lines: &[ContactLine]) -> Vec<u8> {
    let ends = lines.iter().map(|line| [line.from.into(), line.to.into()]);
    Vtp::of_lines(time, lines.len(), ends, |file| {
        file.array("force_N", lines.iter().map(|line| [line.force]));
        file.array("id", lines.iter().map(|line| [line.id as i32]));
        file.array("other", lines.iter().map(|line| [line.other.map_or(-1, |id| id as i32)]));
    })
}
