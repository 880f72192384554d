//! The programs of `examples/` run without failure, and are short.

#[path = "../examples/both_engines.rs"]
mod both_engines;
#[path = "../examples/mesh.rs"]
mod mesh;
#[path = "../examples/own_contact_law.rs"]
mod own_contact_law;
#[path = "../examples/own_drag_law.rs"]
mod own_drag_law;
#[path = "../examples/own_observer.rs"]
mod own_observer;

/// Number of lines of a program outside the implementation of a trait, without empty lines and comments.
fn lines(path: &std::path::Path) -> usize {
    let text = std::fs::read_to_string(path).unwrap();
    let mut is_inside = false;
    let counted = text.lines().filter(|line| {
        is_inside |= line.starts_with("impl");
        let counts = !is_inside && !line.trim().is_empty() && !line.trim().starts_with("//");
        is_inside &= *line != "}";
        counts
    });
    counted.count()
}

#[test]
fn every_example_runs_and_is_short() {
    both_engines::main().unwrap();
    mesh::main().unwrap();
    own_contact_law::main().unwrap();
    own_drag_law::main().unwrap();
    own_observer::main().unwrap();
    let listed: Vec<_> = std::fs::read_dir(concat!(env!("CARGO_MANIFEST_DIR"), "/examples")).unwrap().collect();
    // a new example needs a line in the list above
    assert_eq!(listed.len(), 5);
    for example in listed {
        let path = example.unwrap().path();
        assert!(lines(&path) <= 30, "{}: {} lines", path.display(), lines(&path));
    }
}
