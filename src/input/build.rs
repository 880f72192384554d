//! The folders `cases` and `models` are built into the program: what is added to them is to be seen by the next build.

fn main() {
    println!("cargo:rerun-if-changed=../../cases");
    println!("cargo:rerun-if-changed=../../models");
}
