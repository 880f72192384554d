//! Placeholder.

pub mod law;
