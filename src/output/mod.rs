//! Placeholder.

pub mod fluid_figure;
