//! Figures at the top of the page of a comparison: differences in per cent with the margin of equivalence (largest
//! accepted difference), and the cost. The pictures use the colours of the page, so that they fit its dark mode too. In
//! separate files the pictures have light colours. A variant is one of the experiments of a case.

use crate::output::numbers::significant;
use crate::output::panel::Figure;
use crate::output::{Study, Verdict, ranked_cost};
use crate::statistics::{Answer, Estimate, Judged, slice_column};
use maud::{Markup, html};

/// Name of the picture with the differences between variants (experiments of a case) and their references.
pub const IN_PER_CENT: &str = "differences-in-per-cent";
/// Name of the picture with the computing cost of the variants (experiments of a case).
pub const COST: &str = "cost";

/// [px] width of a picture.
const WIDTH: f64 = 560.0;
/// [px] width of the column with the names of the rows.
const NAMES: f64 = 168.0;
/// [px] height of a row of the picture without its points. [`POINT`] is the additional height for each point.
const ROW: f64 = 10.0;
const POINT: f64 = 11.0;
/// [margins] largest difference on the axis, in units of the margin of equivalence (largest accepted difference). A
/// larger difference is drawn at the frame, with its number.
const FURTHEST: f64 = 4.0;
/// Colours of the variants (experiments of a case), equal to those in other pictures. The file style.css contains the
/// colours of the dark mode.
const COLOURS: [&str; 7] = super::chart::COLOURS;

fn colour(place: usize) -> String {
    let place = place % COLOURS.len();
    format!("var(--series-{}, {})", place + 1, COLOURS[place])
}

/// Symbol of a quantity for pictures, such as U; the name of the quantity if it has no symbol.
pub fn symbol(quantity: &str) -> String {
    slice_column(quantity).map_or(quantity, |column| column.symbol).into()
}

/// [%] main difference in a quantity (the difference that a report names first), with its standard error, in per cent
/// of the scale. The scale is the value by which differences of this quantity are divided. `None` if the quantity has
/// no main difference.
pub fn in_per_cent(one: &Judged) -> Option<Estimate> {
    let found = one.tested.headline()?;
    Some(Estimate::new(found.difference, found.error).times(100.0 / one.tested.scale))
}

/// Names of all compared quantities, in order of first appearance.
pub fn quantities<'a>(verdicts: impl Iterator<Item = &'a Verdict>) -> Vec<&'a str> {
    let mut names: Vec<&str> = Vec::new();
    for one in verdicts.filter_map(|verdict| verdict.comparison.as_ref()).flat_map(|comparison| &comparison.judged) {
        if !names.contains(&&*one.tested.name) {
            names.push(&one.tested.name);
        }
    }
    names
}

/// Figure of the difference between each variant (experiment of a case) and its reference for each quantity, in % of
/// the scale of the quantity (the value by which its differences are divided). A band shows the margin, the largest
/// accepted difference. `None` without a comparison.
pub fn differences(study: &Study) -> Option<Figure> {
    let judged =
        |verdict: &Verdict| verdict.comparison.as_ref().map_or(Vec::new(), |comparison| comparison.judged.clone());
    let names = quantities(study.comparisons.iter());
    let margin = 100.0 * study.comparisons.iter().map(|verdict| verdict.margin).fold(0.0, f64::max);
    if names.is_empty() || margin <= 0.0 {
        return None;
    }
    let rows = names.iter().map(|name| {
        let points = study.comparisons.iter().filter_map(|verdict| {
            let place = study.outcomes.iter().position(|o| o.experiment.name == verdict.variant)?;
            let one = judged(verdict).into_iter().find(|one| one.tested.name == *name)?;
            Some(DifferenceMark { place, found: in_per_cent(&one)?, interval: one.interval.map(|end| 100.0 * end) })
        });
        (symbol(name), points.collect())
    });
    let picture = Differences { margin, rows: rows.collect() };
    let one = study.comparisons.len() == 1;
    let caption = format!(
        "Differences in per cent of each quantity’s scale{}. Grey band: the margin of {} %. Dot and bar: the difference of the means, or that in one slice or at one instant if it is clearer, ± 1 standard error. Pale bar: \
         the differences in all slices or at all instants with their 5 % limits; inside the band the two are equivalent.",
        if one { "" } else { ", a colour per variant" },
        significant(margin, 2)
    );
    Some(Figure::new(IN_PER_CENT, caption, picture.draw(study).into_string()))
}

/// Mark of one variant (experiment of a case) in a row of the picture: difference between the variant and its reference
/// in one quantity.
struct DifferenceMark {
    /// Index of the variant (experiment of a case), by which the colour of the mark is chosen.
    place: usize,
    /// [%] difference with its standard error, in per cent of the scale of the quantity (the value by which its
    /// differences are divided).
    found: Estimate,
    /// [%] confidence interval that contains the differences at all positions or instants, in per cent of the scale of
    /// the quantity (the value by which its differences are divided).
    interval: [f64; 2],
}

struct Differences {
    /// [%] margin of equivalence: largest accepted difference, in per cent of the scale of the quantity (the value by
    /// which its differences are divided).
    margin: f64,
    rows: Vec<(String, Vec<DifferenceMark>)>,
}

impl Differences {
    /// [%] right end of the axis of differences. The left end has the opposite sign.
    fn end(&self) -> f64 {
        let reach = |mark: &DifferenceMark| mark.interval.iter().fold(0.0, |most: f64, end| most.max(end.abs()));
        let marks = self.rows.iter().flat_map(|(_, marks)| marks).map(reach).filter(|reach| reach.is_finite());
        marks.fold(1.6 * self.margin, f64::max).min(FURTHEST * self.margin)
    }

    fn draw(&self, study: &Study) -> Markup {
        let end = self.end();
        let middle = NAMES + 0.5 * (WIDTH - NAMES - 12.0);
        let at = |value: f64| middle + 0.5 * (WIDTH - NAMES - 12.0) * (value / end).clamp(-1.0, 1.0);
        let several = study.comparisons.len() > 1;
        let top = if several { 24.0 } else { 6.0 };
        let heights: Vec<f64> = self.rows.iter().map(|(_, marks)| ROW + POINT * marks.len().max(1) as f64).collect();
        let bottom = top + heights.iter().sum::<f64>();
        let starts = heights.iter().scan(top, |y, height| Some(std::mem::replace(y, *y + height)));
        let rows: Vec<(f64, &(String, Vec<DifferenceMark>))> = starts.zip(&self.rows).collect();
        html! {
            svg.themed xmlns="http://www.w3.org/2000/svg" viewBox=(format!("0 0 {WIDTH} {}", bottom + 34.0)) role="img"
                aria-label="Differences in per cent with the margin as a band; the table of answers holds the same numbers"
                font-family="Helvetica, Arial, sans-serif" font-size="13" fill="var(--ink, #1b1b1b)" {
                rect x=(at(-self.margin)) y=(top) width=(at(self.margin) - at(-self.margin)) height=(bottom - top) fill="var(--open, #ececec)" {}
                @if several { (names(study)) }
                @for (y, (name, marks)) in &rows {
                    text x=(NAMES - 10.0) y=(y + 0.5 * (ROW + POINT * marks.len().max(1) as f64) + 4.5) text-anchor="end" { (name) }
                    @for (k, mark) in marks.iter().enumerate() { (mark.draw(&at, y + 0.5 * ROW + POINT * (k as f64 + 0.5), end)) }
                }
                line x1=(at(0.0)) x2=(at(0.0)) y1=(top) y2=(bottom) stroke="var(--ink, #1b1b1b)" {}
                line x1=(NAMES) x2=(WIDTH - 12.0) y1=(bottom) y2=(bottom) stroke="var(--muted, #565656)" {}
                @for value in [-end, -self.margin, 0.0, self.margin, end] {
                    text x=(at(value)) y=(bottom + 15.0) text-anchor="middle" { (percent(value)) }
                }
                text x=(middle) y=(bottom + 31.0) text-anchor="middle" fill="var(--muted, #565656)" { "difference [% of scale]" }
            }
        }
    }
}

fn percent(value: f64) -> String {
    let text = significant(value, 2);
    if text.contains('.') { text.trim_end_matches('0').trim_end_matches('.').to_owned() } else { text }
}

/// Legend with the colour of each variant (experiment of a case).
fn names(study: &Study) -> Markup {
    let variants = study.comparisons.iter().filter_map(|verdict| {
        let place = study.outcomes.iter().position(|o| o.experiment.name == verdict.variant)?;
        Some((place, verdict.variant.as_str()))
    });
    let wide = |name: &str| 26.0 + 7.0 * name.chars().count() as f64;
    let starts = variants.scan(NAMES, |x, (place, name)| Some((std::mem::replace(x, *x + wide(name)), place, name)));
    // names that do not fit are left out; the table contains them
    let shown: Vec<_> = starts.filter(|(x, _, name)| x + wide(name) < WIDTH).collect();
    html! {
        @for (x, place, name) in &shown {
            circle cx=(x + 6.0) cy="11" r="4.5" fill=(colour(*place)) {}
            text x=(x + 15.0) y="15.5" { (name) }
        }
    }
}

impl DifferenceMark {
    fn draw(&self, at: &impl Fn(f64) -> f64, y: f64, end: f64) -> Markup {
        let Estimate { value, error } = self.found;
        let error = error.unwrap_or(0.0);
        let colour = colour(self.place);
        let beyond = value.abs() > end;
        let side = if value > 0.0 { "end" } else { "start" };
        html! {
            rect x=(at(self.interval[0])) width=(at(self.interval[1]) - at(self.interval[0])) y=(y - 4.0) height="8" fill=(colour) opacity="0.18" {}
            @if beyond {
                text x=(at(value) - 12.0 * value.signum()) y=(y + 4.5) text-anchor=(side) font-size="12" { (percent(value)) " %" }
                path d=(arrow(at(value), y, value.signum())) fill=(colour) {}
            } @else {
                line x1=(at(value - error)) x2=(at(value + error)) y1=(y) y2=(y) stroke=(colour) stroke-width="2.5" {}
                circle cx=(at(value)) cy=(y) r="4.5" fill=(colour) {}
            }
        }
    }
}

fn arrow(x: f64, y: f64, side: f64) -> String {
    format!("M{x} {y} l{} -5 v10 z", -9.0 * side)
}

/// Figure of the computing cost of each variant (experiment of a case): wall-clock time per simulated time, with one
/// bar per variant. `None` without a comparison, or if no finished run took at least 0.1 s of wall-clock time.
pub fn cost(study: &Study) -> Option<Figure> {
    let outcomes = study.outcomes;
    let cheapest = outcomes.iter().filter_map(ranked_cost).reduce(f64::min)?;
    if study.comparisons.is_empty() || outcomes.len() < 2 {
        return None;
    }
    let rows = outcomes.iter().enumerate().map(|(place, outcome)| {
        let judged = study.comparisons.iter().find(|verdict| verdict.variant == outcome.experiment.name);
        let answer = judged.map(|verdict| verdict.answer);
        let ratio = ranked_cost(outcome).map(|cost| cost / cheapest);
        let words = match (ratio, answer) {
            (None, _) if outcome.failure.is_none() => "too short a run: not ranked".to_owned(),
            (None, _) => format!("stopped after {} s: not ranked", significant(outcome.simulated_seconds, 3)),
            (Some(ratio), None) => format!("{} ×", significant(ratio, 2)),
            (Some(ratio), Some(Answer::Equivalent)) => format!("{} ×, equivalent", significant(ratio, 2)),
            (Some(ratio), Some(Answer::Unresolved)) => {
                format!("{} ×, not shown to be equivalent", significant(ratio, 2))
            }
            (Some(ratio), Some(Answer::Different)) => format!("{} ×, not the same result", significant(ratio, 2)),
        };
        let equal = matches!(answer, None | Some(Answer::Equivalent));
        Bar { place, name: outcome.experiment.name.clone(), ratio, words, equal }
    });
    let bars: Vec<Bar> = rows.collect();
    let caption = "Wall-clock time per simulated time over that of the cheapest. Full colour: the reference, and what is shown to be as \
                   accurate, so that costs are those of equal accuracy; outlined: what is not, so that the cost of the same answer is not known here.";
    Some(Figure::new(COST, caption, draw(&bars).into_string()))
}

struct Bar {
    place: usize,
    name: String,
    /// [-] cost of the run, divided by the cost of the cheapest run among those that took at least 0.1 s. `None` for a
    /// run that stopped early or took less time.
    ratio: Option<f64>,
    words: String,
    /// True for a reference, and for a variant (experiment of a case) that is equivalent to its reference within the
    /// margin (largest accepted difference).
    equal: bool,
}

fn draw(bars: &[Bar]) -> Markup {
    let most = bars.iter().filter_map(|bar| bar.ratio).fold(1.0, f64::max);
    // the text is to the right of the bar, so that the bar takes at most half of the width
    let wide = |ratio: f64| 0.48 * (WIDTH - NAMES) * ratio / most;
    let height = 24.0;
    html! {
        svg.themed xmlns="http://www.w3.org/2000/svg" viewBox=(format!("0 0 {WIDTH} {}", 4.0 + height * bars.len() as f64)) role="img"
            aria-label="Cost of each variant over that of the cheapest" font-family="Helvetica, Arial, sans-serif" font-size="13" fill="var(--ink, #1b1b1b)" {
            @for (k, bar) in bars.iter().enumerate() {
                @let y = height * k as f64 + 4.0;
                @let end = NAMES + bar.ratio.map_or(0.0, wide);
                text x=(NAMES - 10.0) y=(y + 14.0) text-anchor="end" { (short(&bar.name)) }
                @if bar.ratio.is_some() {
                    rect x=(NAMES) y=(y + 2.0) width=(end - NAMES) height=(height - 8.0) stroke=(colour(bar.place)) stroke-width="1.5"
                        fill=(if bar.equal { colour(bar.place) } else { "none".to_owned() }) {}
                }
                text x=(end + 8.0) y=(y + 14.0) { (bar.words) }
            }
        }
    }
}

/// Shortens a name so that it fits next to its bar.
fn short(name: &str) -> String {
    const LONGEST: usize = 23;
    if name.chars().count() <= LONGEST {
        name.to_owned()
    } else {
        name.chars().take(LONGEST - 1).chain(['…']).collect()
    }
}
