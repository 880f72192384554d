//! Parts of a report about the budgets of the second moments of velocity (means of products of two fluctuations): the
//! rates at which impacts, drag and other effects change these moments.

use crate::observe::{Budgets, MOMENTS, Terms};
use crate::output::document::Block;
use crate::output::numbers::with_error;
use crate::statistics::Estimate;

/// Sentences on the budgets of a run: the terms of each second moment of velocity, averaged over all particles, and
/// the contributions of impacts on walls.
pub fn budget_sentences(budgets: &Budgets) -> Vec<String> {
    let term = |term: &Estimate| with_error(*term);
    let sentence = |(&(name, ..), terms): (&(&str, usize, usize), &Terms<Estimate>)| {
        format!(
            "{name} per second, mean over all particles [m²/s³]: production {}, impacts {}, drag {}; rest {}.",
            term(&terms.production),
            term(&terms.impacts),
            term(&terms.drag),
            term(&terms.rest)
        )
    };
    let walls = format!(
        "Of these, friction at walls gives {} to uu + ww, and their restitution {} to vv. Averaged from {:.4} s on.",
        term(&budgets.wall_friction),
        term(&budgets.wall_restitution),
        budgets.from
    );
    MOMENTS.iter().zip(&budgets.whole).map(sentence).chain([walls]).collect()
}

/// Section about the budgets of the second moments of velocity; `pictures` makes its pictures. The list is empty if
/// the user did not ask for budgets.
pub(super) fn blocks(budgets: Option<&Budgets>, pictures: impl FnOnce() -> Vec<Block>) -> Vec<Block> {
    let Some(budgets) = budgets else { return Vec::new() };
    let mut blocks = vec![Block::heading("Budgets of the second moments"), Block::List(budget_sentences(budgets))];
    blocks.extend(pictures());
    blocks
}
