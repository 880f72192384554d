//! The integration tests: one binary, one module per kind of evidence.

mod support;

mod analytic; // closed forms: two bodies, walls, bouncing, oblique impacts (oracle A, B, C)
mod cli; // the binary: exit codes, messages, files, silence
mod docs; // imports point one way; documents name what exists; public numbers say their unit
mod drag; // drag laws against independent integrations; order of the splitting
mod fluid; // gas profiles against other k-epsilon solvers, DNS and closed forms
mod inputs; // case files, good and bad: what is refused, where, and with which words
mod output; // every file a study leaves behind, from made-up outcomes
