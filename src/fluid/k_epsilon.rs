//! Stub until the k-ε solver is merged.

/// A k-ε model.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum TurbulenceModel {
    /// Standard k-ε with wall functions.
    WallFunctions,
    /// Launder and Sharma (1974).
    LaunderSharma,
}
