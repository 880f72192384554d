//! Territories: regions of the box in which the threads make new shells at the same time. A shell is a ball around a
//! particle, in which its neighbour list is valid.
//!
//! Each cell of the grid of shells belongs to one part (the particles of one thread), or to none. All shells in a cell
//! that belongs to a part are shells of this part. A part makes new shells only in its *inner* cells: those whose
//! neighbours all belong to the part. So no two threads use the same cell, and a new shell in an inner cell overlaps no
//! shell of another part.

use super::cells::ShellGrid;
use super::division::Division;
use super::next_events::NextEvents;

/// For each cell of the grid of shells (balls in which neighbour lists are valid), the part to which the cell belongs.
/// A part is the set of particles of one thread.
#[derive(Clone, Debug, Default)]
pub struct Territories {
    /// For each cell, the number of the part (particles of one thread) to which the cell belongs; [`NO_PART`] if the
    /// cell contains shells of several parts.
    owner: Vec<u16>,
    /// For each cell, the number of the part (particles of one thread) to which the cell and all its neighbours belong;
    /// [`NO_PART`] if they belong to different parts or to none.
    inner: Vec<u16>,
}

/// Mark of a cell that belongs to no part (no thread).
const NO_PART: u16 = u16::MAX;

/// Mark of a cell without particles, before the cell is given to a part (particles of one thread).
const EMPTY: u16 = u16::MAX - 1;

/// Largest number of parts (threads), so that the number of a part never equals [`NO_PART`] or [`EMPTY`].
pub const MOST_PARTS: usize = EMPTY as usize;

impl Territories {
    /// Gives each cell of `cells` to the part (particles of one thread) whose shells the cell contains. `next_events`
    /// contains the shells of all particles. An empty cell goes to the part of the cell with the next lower number.
    pub fn of(cells: &ShellGrid, division: &Division, next_events: &[NextEvents]) -> Self {
        let mut owner = vec![EMPTY; cells.cells()];
        for (index, events) in (0..).zip(next_events) {
            let (part, owner) = (number(division, index), &mut owner[cells.cell(&events.shell.rounded_centre())]);
            *owner = if *owner == EMPTY || *owner == part { part } else { NO_PART };
        }
        let mut before = NO_PART;
        for owner in &mut owner {
            before = if *owner == EMPTY { before } else { *owner };
            *owner = before;
        }
        let is_alike = |cell: usize| cells.around(cell).all(|other| owner[other] == owner[cell]);
        let inner = (0..owner.len()).map(|cell| if is_alike(cell) { owner[cell] } else { NO_PART }).collect();
        Self { owner, inner }
    }

    /// True if a thread may move the shell of its particle `index` from the point `old` [m] to the point `new` [m],
    /// while other threads move shells of their particles. A shell is the ball in which a neighbour list is valid.
    pub fn allow(&self, index: u32, division: &Division, cells: &ShellGrid, [old, new]: [&[f32; 3]; 2]) -> bool {
        let part = number(division, index);
        self.inner.get(cells.cell(new)) == Some(&part) && self.owner.get(cells.cell(old)) == Some(&part)
    }

    /// Notes that the shell of particle `index` has been moved to the point `centre` [m]. If the cell there does not
    /// belong to the part of this particle, the cell then belongs to no part.
    pub fn enter(&mut self, index: u32, division: &Division, cells: &ShellGrid, centre: &[f32; 3]) {
        let cell = cells.cell(centre);
        if self.owner.get(cell).is_some_and(|owner| *owner != number(division, index)) {
            self.owner[cell] = NO_PART;
            cells.around(cell).for_each(|other| self.inner[other] = NO_PART);
        }
    }
}

fn number(division: &Division, index: u32) -> u16 {
    division.number(index) as u16
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::domain::Domain;
    use nalgebra::Vector3;

    const EDGE: usize = 12;

    /// Centres of shells in the middle of each of the 12³ cells of unit length, in the order of z.
    fn centres() -> impl Iterator<Item = [f32; 3]> {
        let middle = |k: usize| k as f32 + 0.5;
        (0..EDGE.pow(3)).map(move |k| [middle(k % EDGE), middle(k / EDGE % EDGE), middle(k / (EDGE * EDGE))])
    }

    /// Grid of cells with one shell in each, and the territories of two parts: the halves below and above z = 6.
    fn halves(periodic: bool) -> (ShellGrid, Division, Territories) {
        let domain = Domain::new(Vector3::repeat(EDGE as f64), [periodic; 3]);
        let count = EDGE.pow(3);
        let (cells, division) = (ShellGrid::new(&domain, 0.99, count), Division::new(count, 2));
        let mut next_events = vec![NextEvents::blank(); count];
        for ((index, events), centre) in (0..).zip(&mut next_events).zip(centres()) {
            events.shell = events.shell.about(centre, false);
            cells.put(index, centre);
        }
        let territories = Territories::of(&cells, &division, &next_events);
        (cells, division, territories)
    }

    /// True if the shell of a particle of the part number `part` may move within the layer number `layer` along z.
    fn is_free((cells, division, territories): &(ShellGrid, Division, Territories), part: usize, layer: usize) -> bool {
        let centre = [5.5, 5.5, layer as f32 + 0.5];
        territories.allow((part * EDGE.pow(3) / 2) as u32, division, cells, [&centre, &centre])
    }

    #[test]
    fn each_part_is_free_except_at_its_borders() {
        for periodic in [false, true] {
            let halves = halves(periodic);
            for layer in 0..EDGE {
                // with periodic sides, the first and the last layer are neighbours too
                let at_side = periodic && [0, EDGE - 1].contains(&layer);
                let is_inner = ![5, 6].contains(&layer) && !at_side;
                assert_eq!(is_free(&halves, 0, layer), is_inner && layer < 6, "{layer} {periodic}");
                assert_eq!(is_free(&halves, 1, layer), is_inner && layer > 6, "{layer} {periodic}");
            }
        }
    }

    #[test]
    fn no_inner_cell_of_one_part_is_beside_a_cell_of_another() {
        let (cells, _, Territories { owner, inner }) = halves(true);
        for cell in (0..cells.cells()).filter(|cell| inner[*cell] != NO_PART) {
            assert_eq!(cells.around(cell).count(), 27);
            assert!(cells.around(cell).all(|other| owner[other] == inner[cell]));
        }
    }

    #[test]
    fn a_shell_of_another_part_makes_the_cells_around_it_forbidden() {
        let mut halves = halves(false);
        let (cells, division, territories) = &mut halves;
        let foreign = division.of(0).end;
        territories.enter(0, division, cells, &[5.5, 5.5, 2.5]);
        assert!(territories.allow(0, division, cells, [&[5.5, 5.5, 2.5]; 2]), "a shell of the part itself");
        territories.enter(foreign, division, cells, &[5.5, 5.5, 2.5]);
        let allowed: Vec<bool> = (0..6).map(|layer| is_free(&halves, 0, layer)).collect();
        assert_eq!(allowed, [true, false, false, false, true, false]);
    }
}
