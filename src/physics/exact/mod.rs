//! Sums that do not depend on the order of their terms. They are computed exactly, and rounded only once, at the end.
//!
//! A plain sum of floating-point numbers depends on the order of its terms. So the sum would depend on the order in
//! which particles are stored, and on the division of work among threads. Therefore sums over particles, over impacts,
//! and over groups of particles that are solved separately (islands) are computed with the types of this module.
//! [`ExactSum`] adds numbers one by one. [`add_rows`] adds many numbers at a time, with a quarter of the instructions.

mod rows;

pub use rows::{
    BLOCK, Groups, add_all, add_rows, condense, merged, none, side_by_side, sum, sum_and_largest, sums, sums_in_groups,
    values,
};

use serde::{Deserialize, Deserializer, Serialize, Serializer};

/// Number of bits of a digit of an exact sum, which is a number to the base 2^32.
const BITS: u32 = 32;
/// Number of 32-bit digits of an exact sum. They suffice for every finite `f64`, and for the sum of 2^40 numbers of the
/// largest size.
const DIGITS: usize = 67;
/// Number of 64-bit words after the digits of an exact sum. These words count the terms that are infinite, minus
/// infinite, and not a number.
const SPECIAL: usize = 3;
/// Number of 64-bit words in which an exact sum is stored: its digits and three counts of terms that are not finite.
const WORDS: usize = DIGITS + SPECIAL;
/// [-] exponent of two that belongs to the lowest bit of an exact sum. 2^-1075 is half of the smallest `f64` above 0.
const LOWEST: i32 = -1075;
/// Number of terms that can be added to an exact sum before carries must be passed from digit to digit. Each term adds
/// less than 2^52 to a 64-bit digit.
const MOST: u32 = 1024;

/// An exact sum of `f64`, rounded to the nearest (ties to even) when its value is read.
///
/// A "small superaccumulator": a fixed-point number that is as wide as the range of `f64`, in signed digits of 32
/// bits with delayed carries (R. M. Neal, "Fast exact summation using small and large superaccumulators",
/// arXiv:1505.05571, 2015).
///
/// ```
/// # extern crate diptych_physics as diptych;
/// use diptych::exact::ExactSum;
///
/// let mut sum = ExactSum::default();
/// [1e100, 1.0, -1e100].into_iter().for_each(|x| sum.add(x));
/// assert_eq!(sum.value(), 1.0);
/// ```
#[derive(Clone, Debug)]
pub struct ExactSum {
    /// 32-bit digits of the sum, followed by three counts of terms that are not finite. The sum is Σ `words[k]` 2^(32
    /// k - 1075) over the digits.
    words: [i64; WORDS],
    /// Bit k is set if `words[k]` may differ from 0.
    used: u128,
    /// Bound on the digits: the magnitude of each digit is at most this number times 2^52. One term adds less than 2^52
    /// to a digit.
    added: u32,
}

impl Default for ExactSum {
    fn default() -> Self {
        Self { words: [0; WORDS], used: 0, added: 0 }
    }
}

impl ExactSum {
    /// Adds a number to the sum.
    #[inline]
    pub fn add(&mut self, x: f64) {
        let bits = x.to_bits();
        let exponent = (bits >> 52) as usize & 0x7ff;
        let fraction = (bits & ((1 << 52) - 1)) as i64;
        if exponent == 0x7ff {
            return self.add_special(x);
        }
        // a subnormal number has the exponent of the smallest normal number, and no implicit leading one
        let (magnitude, exponent) = if exponent == 0 { (fraction, 1) } else { (fraction | 1 << 52, exponent) };
        if magnitude == 0 {
            return;
        }
        if self.added >= MOST {
            self.carry();
        }
        let signed = if x < 0.0 { -magnitude } else { magnitude };
        let (place, shift) = (exponent / BITS as usize, exponent as u32 % BITS);
        self.words[place] += (signed << shift) & ((1 << BITS) - 1);
        self.words[place + 1] += signed >> (BITS - shift);
        self.used |= 3 << place;
        self.added += 1;
    }

    #[cold]
    fn add_special(&mut self, x: f64) {
        let place = DIGITS + if x.is_nan() { 2 } else { usize::from(x < 0.0) };
        self.words[place] += 1;
        self.used |= 1 << place;
    }

    /// Adds the terms of another sum to this sum.
    pub fn merge(&mut self, other: &Self) {
        if self.added + other.added > 2 * MOST - 2 {
            self.carry();
        }
        for place in places(other.used) {
            self.words[place] += other.words[place];
        }
        self.used |= other.used;
        self.added += other.added;
    }

    /// Returns the exact difference of two sums: this sum minus `other`.
    pub fn less(&self, other: &Self) -> Self {
        let mut other = other.clone();
        other.words[..DIGITS].iter_mut().for_each(|word| *word = -*word);
        // the counts of terms that are not finite are subtracted too, so that such terms of `other` do not belong to
        // the difference
        other.words[DIGITS..].iter_mut().for_each(|word| *word = -*word);
        other.merge(self);
        other
    }

    /// Passes carries from digit to digit, so that every digit except the last lies in [-2^31, 2^31). Equal sums then
    /// have equal digits.
    fn carry(&mut self) {
        let mut carried = 0;
        let first = self.used.trailing_zeros() as usize;
        for place in first..DIGITS {
            let word = self.words[place] + carried;
            carried = (word + (1 << (BITS - 1))) >> BITS;
            // the last digit is not carried further
            self.words[place] = if place + 1 < DIGITS { word - (carried << BITS) } else { word };
        }
        self.used = (0..WORDS).filter(|&place| self.words[place] != 0).fold(0, |used, place| used | 1 << place);
        self.added = 1;
    }

    /// Returns the 64-bit words in which the sum is stored, for example to add up the sums of several processes. Word k
    /// of a total is the sum of the words k of all sums; up to 2^20 sums may be added in this way. The resulting words
    /// are those of the exact total, also with terms that are not finite.
    pub fn words(&mut self) -> &mut [i64; WORDS] {
        self.carry();
        // all words count as used, since the caller may change any of them
        (self.used, self.added) = ((1 << WORDS) - 1, MOST);
        &mut self.words
    }

    /// Value of the sum, correctly rounded; 0 without terms. If terms were not finite, the result is infinite or NaN,
    /// as for a plain sum.
    pub fn value(&self) -> f64 {
        let special = &self.words[DIGITS..];
        if special.iter().any(|&count| count != 0) {
            return match special {
                [_, 0, 0] => f64::INFINITY,
                [0, _, 0] => f64::NEG_INFINITY,
                _ => f64::NAN,
            };
        }
        if self.used == 0 {
            return 0.0;
        }
        let (first, last) =
            (self.used.trailing_zeros() as usize, u128::BITS as usize - self.used.leading_zeros() as usize);
        // carries between digits as `carry` does, but only over the words in use
        let (mut digits, mut carried, mut top) = ([0_i64; DIGITS], 0, first);
        for (place, (digit, word)) in digits.iter_mut().zip(&self.words).enumerate().skip(first) {
            if place >= last && carried == 0 {
                break;
            }
            let word = word + carried;
            carried = (word + (1 << (BITS - 1))) >> BITS;
            *digit = if place + 1 < DIGITS { word - (carried << BITS) } else { word };
            top = if *digit != 0 { place } else { top };
        }
        let negative = digits[top] < 0;
        // makes all digits of the magnitude positive or zero
        let mut borrowed = 0;
        for digit in &mut digits[first..=top] {
            let word = if negative { -*digit } else { *digit } + borrowed;
            (*digit, borrowed) = (word & ((1 << BITS) - 1), word >> BITS);
        }
        digits[top] += borrowed << BITS;
        let rounded = round(&digits[first..=top], first as i32);
        if negative { -rounded } else { rounded }
    }
}

/// Positions of the bits that are set in a number, from the lowest bit.
fn places(mut bits: u128) -> impl Iterator<Item = usize> {
    std::iter::from_fn(move || {
        (bits != 0).then(|| {
            let place = bits.trailing_zeros() as usize;
            bits &= bits - 1;
            place
        })
    })
}

/// Number whose digits to the base 2^32 are given, the lowest first, rounded to the nearest `f64` (ties to even). No
/// digit is negative. `first` is the index of the lowest given digit in the exact sum.
fn round(digits: &[i64], first: i32) -> f64 {
    let Some(top) = digits.iter().rposition(|&digit| digit != 0) else { return 0.0 };
    // the three leading digits, and a flag that is true if lower digits differ from 0
    let digit = |below: usize| top.checked_sub(below).map_or(0, |place| digits[place] as u128);
    let leading = digit(0) << (2 * BITS) | digit(1) << BITS | digit(2);
    let below = digits[..top.saturating_sub(2)].iter().any(|&digit| digit != 0);
    let lowest = LOWEST + BITS as i32 * (first + top as i32 - 2);
    // position of the last bit of the result: 53 bits below the first, or that of the smallest number
    let length = 128 - leading.leading_zeros() as i32;
    let place = (lowest + length - f64::MANTISSA_DIGITS as i32).max(LOWEST + 1);
    let shift = place - lowest;
    let (kept, rest) = (leading >> shift, leading & ((1 << shift) - 1));
    let half = 1_u128 << (shift - 1);
    let up = rest > half || (rest == half && (below || kept & 1 == 1));
    let kept = kept as u64 + u64::from(up);
    // the implicit leading one adds one to the exponent
    let exponent = (place - LOWEST - 1) as u64;
    if exponent > 2045 { f64::INFINITY } else { f64::from_bits((exponent << 52) + kept) }
}

/// Compares the exact values of two sums, not their rounded values.
impl PartialEq for ExactSum {
    fn eq(&self, other: &Self) -> bool {
        let [mut one, mut other] = [self, other].map(Self::clone);
        one.carry();
        other.carry();
        one.words == other.words
    }
}

/// Serializes a sum as the index and the value of each of its nonzero words. Text formats such as JSON contain the
/// rounded value instead.
impl Serialize for ExactSum {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        if serializer.is_human_readable() {
            return self.value().serialize(serializer);
        }
        let mut carried = self.clone();
        carried.carry();
        let used: Vec<(u8, i64)> = places(carried.used).map(|place| (place as u8, carried.words[place])).collect();
        used.serialize(serializer)
    }
}

impl<'de> Deserialize<'de> for ExactSum {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        let mut sum = Self::default();
        if deserializer.is_human_readable() {
            sum.add(f64::deserialize(deserializer)?);
            return Ok(sum);
        }
        for (place, word) in Vec::<(u8, i64)>::deserialize(deserializer)? {
            let of = sum.words.get_mut(usize::from(place)).filter(|_| word.unsigned_abs() >> 52 == 0);
            *of.ok_or_else(|| serde::de::Error::custom("a sum has no such digit"))? = word;
        }
        (sum.used, sum.added) = ((1 << WORDS) - 1, MOST);
        Ok(sum)
    }
}

#[cfg(test)]
mod tests;
