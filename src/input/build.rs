//! Tells cargo to compile again after a change in the folders `cases` or `models`, which are built into the program.

fn main() {
    println!("cargo:rerun-if-changed=../../cases");
    println!("cargo:rerun-if-changed=../../models");
}
