//! All integration tests in one binary.

mod drag; // drag laws against independent integrations; order of the splitting
mod fluid; // gas profiles against other k-epsilon solvers, DNS and closed forms
