//! Connection between processes by MPI.

use super::link::Link;
use mpi::Threading;
use mpi::collective::{CommunicatorCollectives, Root, SystemOperation};
use mpi::datatype::PartitionMut;
use mpi::environment::Universe;
use mpi::point_to_point::{Destination, Source};
use mpi::topology::{Communicator, SimpleCommunicator};

/// [bytes] largest piece in which a message is sent. MPI stores the number of bytes of a piece in a signed number of
/// 32 bits.
const PIECE: usize = 1 << 30;

/// Tag of the messages within a run that several processes share. It distinguishes them from the messages between the
/// lead (process 0) and the helpers (all other processes).
const SHARED: i32 = 1;

/// Connection between the processes of a command by MPI.
pub struct Mpi {
    world: SimpleCommunicator,
    on_this_machine: usize,
    /// Handle that ends MPI when it is dropped. It must be the last field, because fields are dropped in the order of
    /// their declaration.
    _universe: Universe,
}

impl Mpi {
    /// Connects this process with the processes that were started together with it; `None` if MPI has already been
    /// started.
    pub fn join() -> Option<Self> {
        let (universe, _) = mpi::initialize_with_threading(Threading::Funneled)?;
        let world = universe.world();
        let on_this_machine = world.split_shared(world.rank()).size() as usize;
        Some(Self { world, on_this_machine, _universe: universe })
    }
}

impl Drop for Mpi {
    /// Aborts all processes if this process has panicked, since the other processes would wait for ever.
    fn drop(&mut self) {
        if std::thread::panicking() {
            self.world.abort(1);
        }
    }
}

impl Link for Mpi {
    fn rank(&self) -> usize {
        self.world.rank() as usize
    }

    fn size(&self) -> usize {
        self.world.size() as usize
    }

    fn on_this_machine(&self) -> usize {
        self.on_this_machine
    }

    fn send(&self, to: usize, bytes: &[u8]) {
        let to = self.world.process_at_rank(to as i32);
        to.send(&(bytes.len() as u64).to_le_bytes()[..]);
        bytes.chunks(PIECE).for_each(|piece| to.send(piece));
    }

    fn take(&self) -> Option<(usize, Vec<u8>)> {
        let (message, status) = self.world.any_process().immediate_matched_probe()?;
        let mut length = [0; 8];
        message.matched_receive_into(&mut length[..]);
        // the pieces follow directly, without other messages of this sender in between
        let from = self.world.process_at_rank(status.source_rank());
        let mut bytes = vec![0; u64::from_le_bytes(length) as usize];
        bytes.chunks_mut(PIECE).for_each(|piece| {
            from.receive_into(piece);
        });
        Some((status.source_rank() as usize, bytes))
    }

    fn gather(&self, own: &[u8]) -> Vec<Vec<u8>> {
        let mut lengths = vec![0; self.size()];
        self.world.all_gather_into(&(own.len() as i32), &mut lengths[..]);
        let starts: Vec<i32> =
            lengths.iter().scan(0, |end, length| Some(std::mem::replace(end, *end + length))).collect();
        let mut all = vec![0; lengths.iter().map(|length| *length as usize).sum()];
        let mut parts = PartitionMut::new(&mut all[..], &lengths[..], &starts[..]);
        self.world.all_gather_varcount_into(own, &mut parts);
        let part = |(start, length): (&i32, &i32)| all[*start as usize..(*start + *length) as usize].to_vec();
        starts.iter().zip(&lengths).map(part).collect()
    }

    fn exchange(&self, outgoing: Vec<Vec<u8>>) -> Vec<Vec<u8>> {
        let lengths: Vec<u64> = outgoing.iter().map(|bytes| bytes.len() as u64).collect();
        let mut coming = vec![0_u64; self.size()];
        self.world.all_to_all_into(&lengths[..], &mut coming[..]);
        let mut incoming: Vec<Vec<u8>> = coming.iter().map(|length| vec![0; *length as usize]).collect();
        let own = self.rank();
        let pieces = outgoing.iter().map(|bytes| bytes.len().div_ceil(PIECE)).sum();
        mpi::request::multiple_scope(pieces, |scope, sent| {
            // only processes for which there are bytes get a message
            for (rank, bytes) in outgoing.iter().enumerate().filter(|(rank, _)| *rank != own) {
                let to = self.world.process_at_rank(rank as i32);
                bytes.chunks(PIECE).for_each(|piece| {
                    sent.add(to.immediate_send_with_tag(scope, piece, SHARED));
                });
            }
            for (rank, bytes) in incoming.iter_mut().enumerate().filter(|(rank, _)| *rank != own) {
                let from = self.world.process_at_rank(rank as i32);
                bytes.chunks_mut(PIECE).for_each(|piece| {
                    from.receive_into_with_tag(piece, SHARED);
                });
            }
            sent.wait_all(&mut Vec::new());
        });
        if let (Some(kept), Some(bytes)) = (incoming.get_mut(own), outgoing.into_iter().nth(own)) {
            *kept = bytes;
        }
        incoming
    }

    fn broadcast(&self, bytes: Vec<u8>) -> Vec<u8> {
        let lead = self.world.process_at_rank(0);
        let mut length = bytes.len() as u64;
        lead.broadcast_into(&mut length);
        let mut bytes = bytes;
        bytes.resize(length as usize, 0);
        bytes.chunks_mut(PIECE).for_each(|piece| lead.broadcast_into(piece));
        bytes
    }

    fn sum(&self, numbers: &mut [i64]) {
        let own = numbers.to_vec();
        self.world.all_reduce_into(&own[..], numbers, SystemOperation::sum());
    }

    fn largest(&self, values: &mut [f64]) {
        let own = values.to_vec();
        self.world.all_reduce_into(&own[..], values, SystemOperation::max());
    }
}
