//! Documents (contents of reports) of the studies, one file for each study or part of a report.

mod budgets;
mod chart;
mod energy;
mod files_study;
mod gas_flow;
mod hybrid;
mod impact;
mod kinds;
mod limits;
mod measurements;
mod openings;
mod overview;
mod plan;
mod run;
mod sensitivity;
mod stress;
mod sweep;
mod trust;
mod validation;
mod verdict;
mod work;

pub use budgets::budget_sentences;
pub use chart::{chart_answers, write_chart};
pub use files_study::write_files_study;
pub use impact::write_impact;
pub use limits::{limits_answers, write_limits};
pub use plan::{PlanDocument, plan_json, plan_text};
pub use run::{write_part, write_study};
pub use sensitivity::{write_sensitivity, write_sensitivity_part};
pub use sweep::{sweep_verdicts, write_sweep};
pub use validation::{validation_answers, write_validation};
