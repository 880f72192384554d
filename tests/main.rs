//! The integration tests: one binary, one module per kind of evidence.

mod support;

mod analytic; // closed forms: two bodies, walls, bouncing, oblique impacts (oracle A, B, C)
