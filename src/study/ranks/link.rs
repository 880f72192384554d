//! How processes reach one another.

#[allow(unused_imports, reason = "for the links in the comments")]
use crate::communicator::Communicator;

/// What processes that work on one command need of what joins them. All of it is called from the thread that made it.
pub trait Link {
    /// Number of this process, from 0.
    fn rank(&self) -> usize;

    /// How many there are.
    fn size(&self) -> usize;

    /// How many of them share this machine.
    fn on_this_machine(&self) -> usize;

    /// Sends bytes to another process; they arrive in the order in which they were sent.
    fn send(&self, to: usize, bytes: &[u8]);

    /// What has arrived from any process and has not been taken yet, with the number of its sender.
    fn take(&self) -> Option<(usize, Vec<u8>)>;

    /// The bytes of all processes, in the order of their numbers. Everybody must call it.
    fn gather(&self, own: &[u8]) -> Vec<Vec<u8>>;

    /// As [`Communicator::exchange`].
    fn exchange(&self, outgoing: Vec<Vec<u8>>) -> Vec<Vec<u8>>;

    /// As [`Communicator::broadcast`].
    fn broadcast(&self, bytes: Vec<u8>) -> Vec<u8>;

    /// As [`Communicator::sum`].
    fn sum(&self, numbers: &mut [i64]);

    /// As [`Communicator::largest`].
    fn largest(&self, values: &mut [f64]);
}

/// A process by itself.
pub struct LoneProcess;

impl Link for LoneProcess {
    fn rank(&self) -> usize {
        0
    }

    fn size(&self) -> usize {
        1
    }

    fn on_this_machine(&self) -> usize {
        1
    }

    fn send(&self, _to: usize, _bytes: &[u8]) {}

    fn take(&self) -> Option<(usize, Vec<u8>)> {
        None
    }

    fn gather(&self, own: &[u8]) -> Vec<Vec<u8>> {
        vec![own.to_vec()]
    }

    fn exchange(&self, outgoing: Vec<Vec<u8>>) -> Vec<Vec<u8>> {
        outgoing
    }

    fn broadcast(&self, bytes: Vec<u8>) -> Vec<u8> {
        bytes
    }

    fn sum(&self, _numbers: &mut [i64]) {}

    fn largest(&self, _values: &mut [f64]) {}
}

/// Whether this process was started as one of several: by Open MPI, MPICH and what is built on it, or Slurm with PMIx. Each of
/// them gives its processes a number in one of these variables.
pub fn is_one_of_several() -> bool {
    ["OMPI_COMM_WORLD_RANK", "PMIX_RANK", "PMI_RANK"].iter().any(|name| std::env::var_os(name).is_some())
}
