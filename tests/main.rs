//! All integration tests in one binary.

mod drag; // drag laws against independent integrations; order of the splitting
