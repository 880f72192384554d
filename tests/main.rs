//! x
/// What runs leave on disk.
mod output;
#[test]
fn t() {}
