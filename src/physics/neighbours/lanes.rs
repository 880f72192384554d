//! Test of one ball for overlap with eight other balls at the same time, in single precision. A ball contains a sphere
//! or its path.
//!
//! If the processor has vectors of eight numbers (AVX2, tested at run time), the code uses them. Otherwise the code
//! does the same operations on vectors of four numbers, in the same order, with equal results.

use wide::f32x4;

/// Number of balls that are tested for overlap with one ball at the same time. A lane is the position of one number in
/// a vector register (which holds several numbers) of the processor.
pub const LANES: usize = 8;

/// [m] coordinates x, y, z of the centres, and radii, of `LANES` balls.
pub type Spots<'a> = [&'a [f32; LANES]; 4];

/// Bit mask in which the lowest `count` bits are set, one for each lane (position in a vector).
#[inline(always)]
fn first(count: usize) -> usize {
    (1 << count.min(LANES)) - 1
}

/// Test for overlap of one ball with eight others, each of which occupies one lane (position) of a vector.
pub trait Lanes: Copy {
    /// Vector of the processor with one number per lane (position in the vector).
    type Wide: Copy;

    /// Vector that contains the number `number` in all its lanes (positions).
    fn splat(self, number: f32) -> Self::Wide;

    /// Returns a bit mask of the first `count` balls: a bit is set if the ball overlaps the ball `one` (centre and
    /// radius, [m]). The lowest bit belongs to the first ball. `period` [m] is the distance between images along each
    /// axis. `ACROSS` must be true if the nearest image of a ball may lie across a periodic side; otherwise `period`
    /// is not used.
    fn near<const ACROSS: bool>(self, one: &[Self::Wide; 4], others: Spots, count: usize, period: &[f32; 3]) -> usize;
}

/// Test for overlap by processor vectors of four numbers, for every processor.
#[derive(Clone, Copy)]
pub struct FourLanes;

impl FourLanes {
    #[inline(always)]
    fn overlap<const ACROSS: bool>(one: &[f32x4; 4], others: [f32x4; 4], period: &[f32; 3]) -> usize {
        let [x, y, z, reach] = others;
        let mut square = f32x4::ZERO;
        for (axis, there) in [x, y, z].into_iter().enumerate() {
            let mut apart = there - one[axis];
            if ACROSS {
                apart = apart.abs();
                apart = apart.fast_min((f32x4::splat(period[axis]) - apart).abs());
            }
            square += apart * apart;
        }
        let reach = one[3] + reach;
        square.simd_lt(reach * reach).to_bitmask() as usize
    }
}

impl Lanes for FourLanes {
    type Wide = f32x4;

    #[inline(always)]
    fn splat(self, number: f32) -> f32x4 {
        f32x4::splat(number)
    }

    #[inline(always)]
    fn near<const ACROSS: bool>(self, one: &[f32x4; 4], others: Spots, count: usize, period: &[f32; 3]) -> usize {
        let four = |&[a, b, c, d, ..]: &[f32; LANES]| f32x4::new([a, b, c, d]);
        let four_on = |&[.., a, b, c, d]: &[f32; LANES]| f32x4::new([a, b, c, d]);
        let mut bits = Self::overlap::<ACROSS>(one, others.map(four), period);
        if count > 4 {
            bits |= Self::overlap::<ACROSS>(one, others.map(four_on), period) << 4;
        }
        bits & first(count)
    }
}

/// Test of one ball for overlap with eight others, by processor vectors of eight numbers (AVX2 instructions).
#[cfg(target_arch = "x86_64")]
pub mod eight {
    use super::{Lanes, Spots, first};
    use pulp::x86::V3;
    use std::arch::x86_64::{__m256, _CMP_LT_OQ};

    /// Test for overlap by AVX2 instructions. A value of type `V3` exists only if the processor has these instructions.
    #[derive(Clone, Copy)]
    pub struct Eight(pub V3);

    impl Lanes for Eight {
        type Wide = __m256;

        #[inline(always)]
        fn splat(self, number: f32) -> __m256 {
            self.0.avx._mm256_set1_ps(number)
        }

        #[inline(always)]
        fn near<const ACROSS: bool>(self, one: &[__m256; 4], others: Spots, count: usize, period: &[f32; 3]) -> usize {
            let avx = self.0.avx;
            let [x, y, z, reach] = others;
            let [x, y, z, reach]: [__m256; 4] = [pulp::cast(*x), pulp::cast(*y), pulp::cast(*z), pulp::cast(*reach)];
            let sign = avx._mm256_set1_ps(-0.0);
            let mut square = avx._mm256_setzero_ps();
            for (axis, there) in [x, y, z].into_iter().enumerate() {
                let mut apart = avx._mm256_sub_ps(there, one[axis]);
                if ACROSS {
                    apart = avx._mm256_andnot_ps(sign, apart);
                    let image = avx._mm256_andnot_ps(sign, avx._mm256_sub_ps(avx._mm256_set1_ps(period[axis]), apart));
                    apart = avx._mm256_min_ps(apart, image);
                }
                square = avx._mm256_add_ps(square, avx._mm256_mul_ps(apart, apart));
            }
            let reach = avx._mm256_add_ps(one[3], reach);
            let near = avx._mm256_cmp_ps::<_CMP_LT_OQ>(square, avx._mm256_mul_ps(reach, reach));
            avx._mm256_movemask_ps(near) as usize & first(count)
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    #[cfg(target_arch = "x86_64")]
    fn eight_at_a_time_find_the_same_as_four() {
        let Some(simd) = pulp::x86::V3::try_new() else { return };
        let eight = eight::Eight(simd);
        // this Kronecker sequence has no equal numbers
        let number = |k: usize| (0.754_877_7 * k as f32).fract();
        let mut all = 0;
        for k in 0..400 {
            let spot = |j: usize| [number(4 * j), number(4 * j + 1), number(4 * j + 2), 0.3 * number(4 * j + 3)];
            let one = spot(k);
            let others: [[f32; LANES]; 4] =
                std::array::from_fn(|part| std::array::from_fn(|lane| spot(7 * k + lane + 1)[part]));
            let others = others.each_ref();
            let (a, b) = (one.map(|x| FourLanes.splat(x)), one.map(|x| eight.splat(x)));
            let period = [1.0; 3];
            for count in 0..=LANES {
                let found = FourLanes.near::<true>(&a, others, count, &period);
                assert_eq!(found, eight.near::<true>(&b, others, count, &period), "{k} {count}");
                assert_eq!(
                    FourLanes.near::<false>(&a, others, count, &period),
                    eight.near::<false>(&b, others, count, &period)
                );
                all |= found;
            }
        }
        assert_eq!(all, 0xff, "each of the eight has been near");
    }
}
