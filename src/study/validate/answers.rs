//! Answers for the numbers of a validation row, by the tests with which `compare` judges a single number.

use crate::output::{ValidationNumber, ValidationRule};
use crate::statistics::{Answer, Deviation, EQUIVALENCE_LEVEL, LEVEL, holm};

/// Assumed degrees of freedom of a standard error whose source does not state the number of runs. With so many,
/// Student's distribution equals the normal distribution within 0.2 %.
const STATED: f64 = 1000.0;

/// Sets the answers (such as "equivalent") of the numbers in one row of a suite with `rows` rows (comparisons). The
/// probability of any false difference in the whole suite is at most 1 %. Each row has an equal share of this
/// probability, which Holm's procedure divides among the numbers of the row.
pub fn judge_numbers(numbers: &mut [ValidationNumber], rows: usize) {
    let deviations: Vec<Deviation> = numbers.iter().map(deviation).collect();
    let chances: Vec<f64> = deviations.iter().map(Deviation::chance).collect();
    let detected = holm(&chances, LEVEL / rows.max(1) as f64);
    for ((number, deviation), detected) in numbers.iter_mut().zip(&deviations).zip(detected) {
        let within = match number.rule {
            ValidationRule::Tolerance => deviation.difference.abs() <= number.allowed,
            ValidationRule::Margin => deviation.bound(EQUIVALENCE_LEVEL) < number.allowed,
        };
        // without a standard error, a deviation beyond the tolerance is a difference
        let differs = detected || number.rule == ValidationRule::Tolerance;
        number.answer = match (within, differs) {
            (true, _) => Answer::Equivalent,
            (false, true) => Answer::Different,
            // neither equivalence nor a difference is shown
            (false, false) => Answer::Unresolved,
        };
    }
}

/// Result minus reference, with the standard error of this difference and its degrees of freedom by Welch (1947).
fn deviation(number: &ValidationNumber) -> Deviation {
    let found = number.difference();
    let (a, b) = (number.ours.error.unwrap_or(0.0).powi(2), number.reference.error.unwrap_or(0.0).powi(2));
    let freedom = (a + b).powi(2) / (a * a / number.freedom.min(STATED) + b * b / STATED);
    Deviation { place: None, difference: found.value, error: (a + b).sqrt(), freedom: freedom.min(STATED) }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::statistics::Estimate;
    use crate::study::validate::check::{averaged, exact, read_off};

    fn answer(number: ValidationNumber) -> Answer {
        let mut numbers = [number];
        judge_numbers(&mut numbers, 30);
        numbers[0].answer
    }

    #[test]
    fn a_number_without_scatter_keeps_its_tolerance_or_is_different() {
        assert_eq!(answer(exact("n", "m", 1.0, 1.0 + 0.9e-6, 1e-6)), Answer::Equivalent);
        assert_eq!(answer(exact("n", "m", 1.0, 1.0 - 1.1e-6, 1e-6)), Answer::Different);
        assert_eq!(answer(exact("n", "m", 1.0, f64::NAN, 1e-6)), Answer::Different);
    }

    #[test]
    fn a_reading_error_leaves_a_small_difference_unresolved() {
        assert_eq!(answer(read_off("n", "", (1.0, 0.01), 1.02, 0.05)), Answer::Equivalent);
        // the deviation 0.035 plus 1.65 standard errors exceeds the margin (largest accepted difference), so
        // equivalence is not shown. The answer "different" needs a deviation of 3.6 standard errors
        assert_eq!(answer(read_off("n", "", (1.0, 0.01), 1.035, 0.05)), Answer::Unresolved);
        assert_eq!(answer(read_off("n", "", (1.0, 0.01), 1.06, 0.05)), Answer::Different);
    }

    #[test]
    fn runs_that_scatter_are_judged_by_students_test() {
        let runs = [0.99, 1.01, 1.0, 0.995, 1.005];
        assert_eq!(answer(averaged("n", "", Estimate::exact(1.0), runs, 0.02)), Answer::Equivalent);
        assert_eq!(answer(averaged("n", "", Estimate::exact(1.0), runs, 0.005)), Answer::Unresolved);
        assert_eq!(answer(averaged("n", "", Estimate::exact(1.2), runs, 0.02)), Answer::Different);
        // an uncertain reference counts as well
        assert_eq!(answer(averaged("n", "", Estimate::new(1.2, 0.2), runs, 0.02)), Answer::Unresolved);
    }

    #[test]
    fn many_numbers_of_a_row_share_the_chance_of_a_false_difference() {
        // a deviation of 3.6 standard errors has a probability of 3e-4 by chance. This is below the level 0.01/30 for
        // one number, but not below the level for five numbers
        let number = || read_off("n", "", (0.0, 1.0), 3.61, 0.1);
        let mut one = [number()];
        judge_numbers(&mut one, 30);
        assert_eq!(one[0].answer, Answer::Different);
        let mut five = [number(), read_off("m", "", (0.0, 1.0), 0.0, 9.0), number(), number(), number()];
        judge_numbers(&mut five, 30);
        assert_eq!(five[0].answer, Answer::Unresolved);
    }
}
