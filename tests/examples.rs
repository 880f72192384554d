//! The programs of `examples/` run without failure.

#[path = "../examples/both_engines.rs"]
mod both_engines;
#[path = "../examples/own_drag_law.rs"]
mod own_drag_law;
#[path = "../examples/own_observer.rs"]
mod own_observer;

#[test]
fn every_example_runs() {
    both_engines::main().unwrap();
    own_drag_law::main().unwrap();
    own_observer::main().unwrap();
    let listed = std::fs::read_dir(concat!(env!("CARGO_MANIFEST_DIR"), "/examples")).unwrap();
    // a new example needs a line in the list above
    assert_eq!(listed.count(), 3);
}
