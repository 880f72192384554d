//! Test whether neighbours approach a particle, for four neighbours at the same time. The event queue of all particles
//! (the calendar) uses the test to predict collisions.
//!
//! If the processor has vectors of four numbers (AVX2, tested at run time), the code uses these vectors. Otherwise it
//! does the same operations one by one in the same order. So both results are equal bit for bit.

use super::next_events::FlightState;
use crate::domain::Domain;

/// The particle whose neighbours are tested, with its flight in the frame that falls with gravity.
pub struct ObservingParticle<'a> {
    /// Flight of the particle.
    pub flight: &'a FlightState,
    /// [s] time since the epoch (zero of the event queue's time) up to which touches are looked for.
    pub until: f64,
    /// [s] present time since the epoch (zero of the event queue's time).
    pub now: f64,
    /// True if no neighbour has a flight that began later than the particle's flight.
    pub is_latest: bool,
    /// True if the test must look for the nearest periodic image of each neighbour (its copy, shifted by an edge of the
    /// box).
    pub across: bool,
    /// The box of the scene, with its periodic sides.
    pub domain: &'a Domain,
}

/// Relative motion of the particle and four of its neighbours; each array has one value per neighbour. The values apply
/// to the instant at which both flights, of the particle and of the neighbour, have begun: the start of the later
/// flight. So a predicted touch depends only on the two flights, and not on the instant of the prediction.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct FourNeighbours {
    /// [s] start of the later of both flights, since the epoch (zero of the event queue's time).
    pub start: [f64; 4],
    /// [m²/s] half the rate at which the squared distance of the centres decreases; positive if the particles approach.
    pub closing: [f64; 4],
    /// [m²] squared distance of the centres minus the squared distance at which the particles touch; negative if they
    /// overlap.
    pub gap: [f64; 4],
    /// [m⁴/s²] discriminant of the quadratic equation for the time of touch; negative if the particles will pass each
    /// other without a touch.
    pub discriminant: [f64; 4],
}

/// [-] factor 2 in the test `gap` ≤ 2 `closing` t, with the fields of [`FourNeighbours`]. Here t is the time from
/// `start` to the time `until`, up to which touches are looked for. A touch cannot occur earlier than `gap`/(2
/// `closing`) after `start`. The factor is slightly larger than 2 to allow for rounding, so that touches at equal times
/// are all found.
const TWICE: f64 = 2.0 * (1.0 + 1e-9);

/// Array of four numbers: the values f(0), f(1), f(2) and f(3).
#[inline(always)]
fn each(f: impl Fn(usize) -> f64) -> [f64; 4] {
    [f(0), f(1), f(2), f(3)]
}

impl ObservingParticle<'_> {
    /// Computes the relative motion of the particle and the neighbours `others`; `touch` [m²] contains the squared
    /// distances of the centres at touch. Also returns a bit mask: bit k is set if neighbour k will touch the particle
    /// and may do so before the time `until`. A touch cannot occur before `start` + `gap`/(2 `closing`), with these
    /// fields of [`FourNeighbours`]. Groups of fewer than four neighbours are filled up with the particle itself, for
    /// which no bit is set.
    #[inline(always)]
    pub fn one_by_one(&self, others: &[&FlightState; 4], touch: &[f64; 4]) -> (FourNeighbours, u32) {
        let own_start = self.flight.time;
        let is_own = |k: usize| self.is_latest || own_start > others[k].time;
        let start = each(|k| if is_own(k) { own_start } else { others[k].time });
        let axis = |axis: usize| {
            let own = self.flight.velocity[axis];
            let theirs = each(|k| others[k].velocity[axis]);
            let here = each(|k| self.flight.position[axis] + own * (start[k] - own_start));
            let there = each(|k| others[k].position[axis] + theirs[k] * (start[k] - others[k].time));
            let (size, per_size) = (self.domain.size[axis], self.domain.per_size[axis]);
            let mut apart = each(|k| here[k] - there[k]);
            let velocity = each(|k| own - theirs[k]);
            if self.across {
                let present = |k: usize| apart[k] + velocity[k] * (self.now - start[k]);
                apart = each(|k| apart[k] - size * (present(k) * per_size).round_ties_even());
            }
            (apart, velocity)
        };
        let ((x, u), (y, v), (z, w)) = (axis(0), axis(1), axis(2));
        let closing = each(|k| -(x[k] * u[k] + y[k] * v[k] + z[k] * w[k]));
        let gap = each(|k| x[k] * x[k] + y[k] * y[k] + z[k] * z[k] - touch[k]);
        let speed_square = each(|k| u[k] * u[k] + v[k] * v[k] + w[k] * w[k]);
        let discriminant = each(|k| closing[k] * closing[k] - speed_square[k] * gap[k]);
        let coming = (0..4).fold(0, |coming, k| {
            let soon = (self.until - start[k]) * TWICE;
            let comes = (closing[k] > 0.0) & (gap[k] <= closing[k] * soon) & (discriminant[k] >= 0.0);
            coming | u32::from(comes) << k
        });
        (FourNeighbours { start, closing, gap, discriminant }, coming)
    }
}

/// Test whether neighbours approach, with vector instructions of the processor (AVX2), which treat four neighbours at
/// once.
#[cfg(target_arch = "x86_64")]
pub mod wide {
    use super::{FlightState, FourNeighbours, ObservingParticle, TWICE};
    use nalgebra::Vector3;
    use pulp::x86::V3;
    use std::arch::x86_64::{
        __m256d, _CMP_GE_OQ, _CMP_GT_OQ, _CMP_LE_OQ, _MM_FROUND_NO_EXC, _MM_FROUND_TO_NEAREST_INT,
    };

    /// Mode of the rounding instruction: to the nearest integer, ties to even.
    const NEAREST: i32 = _MM_FROUND_TO_NEAREST_INT | _MM_FROUND_NO_EXC;

    /// State of the particle whose neighbours are tested, each number repeated four times in a processor vector.
    pub struct Wide {
        simd: V3,
        position: [__m256d; 3],
        velocity: [__m256d; 3],
        time: __m256d,
        until: __m256d,
        now: __m256d,
        is_latest: bool,
        /// [m] edges of the box, and [1/m] their inverse along periodic axes (0 along others). `None` if every
        /// neighbour itself is nearer than its periodic images.
        sides: Option<([__m256d; 3], [__m256d; 3])>,
    }

    impl Wide {
        /// Copies the state of the particle `view` into vectors. [`at_once`](Self::at_once) then marks the neighbours
        /// that may touch before the time `view.until`, as [`ObservingParticle::one_by_one`] does.
        #[inline(always)]
        pub fn new(simd: V3, view: &ObservingParticle) -> Self {
            let (domain, flight) = (view.domain, view.flight);
            Self {
                simd,
                position: axes(simd, &flight.position),
                velocity: axes(simd, &flight.velocity),
                time: simd.avx._mm256_set1_pd(flight.time),
                until: simd.avx._mm256_set1_pd(view.until),
                now: simd.avx._mm256_set1_pd(view.now),
                is_latest: view.is_latest,
                sides: view.across.then(|| (axes(simd, &domain.size), axes(simd, &domain.per_size))),
            }
        }

        /// Transposes a matrix of four rows and columns, given by its rows; returns its columns.
        #[inline(always)]
        fn columns(&self, rows: [__m256d; 4]) -> [__m256d; 4] {
            let (avx, [a, b, c, d]) = (self.simd.avx, rows);
            let (xz, yw) = (avx._mm256_unpacklo_pd(a, b), avx._mm256_unpackhi_pd(a, b));
            let (xz_on, yw_on) = (avx._mm256_unpacklo_pd(c, d), avx._mm256_unpackhi_pd(c, d));
            [
                avx._mm256_permute2f128_pd::<0x20>(xz, xz_on),
                avx._mm256_permute2f128_pd::<0x20>(yw, yw_on),
                avx._mm256_permute2f128_pd::<0x31>(xz, xz_on),
                avx._mm256_permute2f128_pd::<0x31>(yw, yw_on),
            ]
        }

        /// Separations [m] and relative velocities [m/s] along one axis: values of the particle minus those of four
        /// neighbours. If `sides` is given, the separations from the nearest images of the neighbours are computed.
        /// `there` [m] and `theirs` [m/s] are the positions of the neighbours at the starts of their flights, and their
        /// velocities. The flights of particle and neighbours began `ours` [s] and `since` [s] before the time `start`
        /// [s] at which the separations are computed.
        #[inline(always)]
        fn relative(
            &self,
            axis: usize,
            (there, theirs): (__m256d, __m256d),
            [start, ours, since]: [__m256d; 3],
        ) -> (__m256d, __m256d) {
            let avx = self.simd.avx;
            let mut here = self.position[axis];
            if !self.is_latest {
                here = avx._mm256_add_pd(here, avx._mm256_mul_pd(self.velocity[axis], ours));
            }
            let there = avx._mm256_add_pd(there, avx._mm256_mul_pd(theirs, since));
            let mut apart = avx._mm256_sub_pd(here, there);
            let velocity = avx._mm256_sub_pd(self.velocity[axis], theirs);
            if let Some((size, per_size)) = &self.sides {
                let flown = avx._mm256_mul_pd(velocity, avx._mm256_sub_pd(self.now, start));
                let present = avx._mm256_add_pd(apart, flown);
                let periods = avx._mm256_round_pd::<NEAREST>(avx._mm256_mul_pd(present, per_size[axis]));
                apart = avx._mm256_sub_pd(apart, avx._mm256_mul_pd(size[axis], periods));
            }
            (apart, velocity)
        }

        #[inline(always)]
        fn dot(&self, a: [__m256d; 3], b: [__m256d; 3]) -> __m256d {
            let avx = self.simd.avx;
            let xy = avx._mm256_add_pd(avx._mm256_mul_pd(a[0], b[0]), avx._mm256_mul_pd(a[1], b[1]));
            avx._mm256_add_pd(xy, avx._mm256_mul_pd(a[2], b[2]))
        }

        /// Computes with vector instructions the relative motion of four neighbours, and the bit mask of those that may
        /// touch soon, as [`ObservingParticle::one_by_one`] does.
        #[inline(always)]
        pub fn at_once(&self, others: &[&FlightState; 4], touch: &[f64; 4]) -> (FourNeighbours, u32) {
            let (avx, [a, b, c, d]) = (self.simd.avx, *others);
            let [x, y, z, time] = self.columns([index(a), index(b), index(c), index(d)]);
            let [u, v, w, _] = self.columns([speed(a), speed(b), speed(c), speed(d)]);
            // if both times are equal, the result is the second operand, as in the version without vectors
            let start = if self.is_latest { self.time } else { avx._mm256_max_pd(self.time, time) };
            let since = [start, avx._mm256_sub_pd(start, self.time), avx._mm256_sub_pd(start, time)];
            let zero = avx._mm256_setzero_pd();
            let (x, u) = self.relative(0, (x, u), since);
            let (y, v) = self.relative(1, (y, v), since);
            let (z, w) = self.relative(2, (z, w), since);
            let (apart, velocity) = ([x, y, z], [u, v, w]);
            let closing = avx._mm256_sub_pd(zero, self.dot(apart, velocity));
            let gap = avx._mm256_sub_pd(self.dot(apart, apart), pulp::cast(*touch));
            let speed_square = self.dot(velocity, velocity);
            let discriminant =
                avx._mm256_sub_pd(avx._mm256_mul_pd(closing, closing), avx._mm256_mul_pd(speed_square, gap));
            let nearer = avx._mm256_cmp_pd::<_CMP_GT_OQ>(closing, zero);
            let soon = avx._mm256_mul_pd(avx._mm256_sub_pd(self.until, start), avx._mm256_set1_pd(TWICE));
            let in_time = avx._mm256_cmp_pd::<_CMP_LE_OQ>(gap, avx._mm256_mul_pd(closing, soon));
            let touches = avx._mm256_cmp_pd::<_CMP_GE_OQ>(discriminant, zero);
            let comes = avx._mm256_and_pd(nearer, avx._mm256_and_pd(in_time, touches));
            let (start, closing) = (pulp::cast(start), pulp::cast(closing));
            let (gap, discriminant) = (pulp::cast(gap), pulp::cast(discriminant));
            (FourNeighbours { start, closing, gap, discriminant }, avx._mm256_movemask_pd(comes) as u32)
        }
    }

    /// Repeats each coordinate of `x` four times; returns one vector per axis.
    #[inline(always)]
    fn axes(simd: V3, x: &Vector3<f64>) -> [__m256d; 3] {
        [simd.avx._mm256_set1_pd(x.x), simd.avx._mm256_set1_pd(x.y), simd.avx._mm256_set1_pd(x.z)]
    }

    /// Position (x, y, z) [m] of a particle at the start of its flight, and the time [s] of this start, in one vector
    /// of four numbers.
    #[inline(always)]
    fn index(body: &FlightState) -> __m256d {
        let x = &body.position;
        pulp::cast([x.x, x.y, x.z, body.time])
    }

    /// Velocity (x, y, z) [m/s] of a particle, and a zero, in one vector of four numbers.
    #[inline(always)]
    fn speed(body: &FlightState) -> __m256d {
        let u = &body.velocity;
        pulp::cast([u.x, u.y, u.z, 0.0])
    }
}

#[cfg(test)]
#[cfg(target_arch = "x86_64")]
mod tests {
    use super::*;
    use nalgebra::Vector3;
    use rand::{RngExt, SeedableRng};
    use rand_xoshiro::Xoshiro256PlusPlus;

    /// Checks that the version with vectors and the one without give equal bits, also across periodic sides.
    #[test]
    fn vectors_of_four_give_the_bits_of_one_by_one() {
        let Some(simd) = pulp::x86::V3::try_new() else { return };
        let mut random = Xoshiro256PlusPlus::seed_from_u64(1);
        let mut draw = |from: f64, to: f64| Vector3::from_fn(|_, _| random.random_range(from..to));
        let domain = Domain::new(Vector3::new(3.0, 4.0, 5.0), [true, true, false]);
        let mut coming = 0;
        for round in 0..1000 {
            let body = |position: Vector3<f64>, velocity: Vector3<f64>| {
                let (position, time) = (position.component_mul(&domain.size), velocity.norm_squared());
                FlightState { position, velocity, time, kind: 0, collision_count: 0 }
            };
            let bodies: [FlightState; 4] = std::array::from_fn(|_| body(draw(0.0, 1.0), draw(-1.0, 1.0)));
            let is_latest = round % 4 < 2;
            let mut me = body(draw(0.0, 1.0), draw(-1.0, 1.0));
            me.time += if is_latest { 3.0 } else { 0.0 };
            let others = bodies.each_ref();
            let now = if is_latest { me.time } else { 9.0 };
            let (until, across, domain) = (now + 2.0, round % 2 == 0, &domain);
            let view = ObservingParticle { flight: &me, until, now, is_latest, across, domain };
            let touch = [1.0, 0.5, 0.25, 1.0];
            let wide = simd.vectorize(|| wide::Wide::new(simd, &view).at_once(&others, &touch));
            let plain = view.one_by_one(&others, &touch);
            assert_eq!(wide, plain);
            coming += plain.1.count_ones();
            let itself = view.one_by_one(&[&me; 4], &touch);
            assert_eq!(itself.1, 0);
        }
        // in this test some neighbours approach, most do not
        assert!((50..1000).contains(&coming), "{coming}");
    }
}
