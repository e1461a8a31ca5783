//! Vectors of float64 and of float32 numbers, by the instructions of the CPU.
//!
//! A kernel is written once, generic over [`Simd`], with every function inlined into one entry. The entry is
//! compiled for each set of instructions, and the best that the CPU has is picked at run time. Every operation rounds as
//! IEEE 754 says, so all of them give the same bits.

#[cfg(target_arch = "x86_64")]
mod avx2;
#[cfg(target_arch = "x86_64")]
mod avx512;
mod portable;
mod single;
#[cfg(test)]
mod tests;

use std::fmt::Debug;
use std::ops::Index;

use crate::math::Real;

#[cfg(target_arch = "x86_64")]
use avx2::Avx2;
#[cfg(target_arch = "x86_64")]
use avx512::Avx512;
pub(crate) use portable::Portable;

/// A set of instructions.
pub(crate) trait Simd: Copy + 'static {
    type F64x4: Doubles<Array = [f64; 4]>;
    /// The float64 numbers of the widest register: four or eight.
    type Wide: Doubles;
    type F32x8: Singles;
    /// Eight unsigned integers.
    type U32x8: Copy;

    /// Does work by these instructions, in a function of its own: then code that is needed in several places is
    /// compiled once.
    fn call<T: Task>(task: T) -> T::Output;

    /// Four float32 numbers as float64.
    fn widen(from: &[f32; 4]) -> Self::F64x4;

    /// Eight integers from memory.
    fn load_u32(from: &[u32; 8]) -> Self::U32x8;

    /// Eight integers to memory.
    fn store_u32(values: Self::U32x8, to: &mut [u32; 8]);

    /// Sorts the lanes of a mask by their numbers, which are not negative, in descending order. Returns a key for each
    /// such lane, and zeros behind them. The low three bits of a key are the lane, the others those of the number, plus 8:
    /// so no key is zero. Numbers that differ only in those bits count as equal.
    fn descending(numbers: Self::F32x8, lanes: Self::F32x8) -> Self::U32x8;

    /// The values at the positions given by the low three bits of each lane.
    fn permute(values: Self::U32x8, positions: Self::U32x8) -> Self::U32x8;

    /// The values of the lanes of a mask, in order, and then anything.
    fn compress(values: Self::U32x8, lanes: u8) -> Self::U32x8;

    /// A mask of the lanes with values of at most `most`. Both must be below `2^31`.
    fn at_most(values: Self::U32x8, most: u32) -> u8;

    /// For each bit of 64 bytes, a mask of the bytes in which it is set.
    fn transpose_bits(bytes: &[u8; 64]) -> [u64; 8];

    /// Asks for a cache line that is needed soon.
    fn prefetch<T>(at: *const T);
}

/// Work that is written once for all sets of instructions. Its functions are inlined into one that is compiled for the
/// instructions.
pub(crate) trait Task {
    type Output;
    fn run<S: Simd>(self) -> Self::Output;
}

/// Does work by the best instructions that the CPU has.
#[inline]
pub(crate) fn dispatch<T: Task>(task: T) -> T::Output {
    #[cfg(target_arch = "x86_64")]
    {
        if avx512::is_supported() {
            return Avx512::call(task);
        }
        if avx2::is_supported() {
            return Avx2::call(task);
        }
    }
    Portable::call(task)
}

/// Some float64 numbers. Comparisons give a mask, the first lane in the lowest bit.
pub(crate) trait Doubles: Real + Debug {
    const LANES: usize;
    /// The mask of all lanes.
    const ALL: u8 = ((1u32 << Self::LANES) - 1) as u8;
    type Array: Copy + Debug + Index<usize, Output = f64>;
    fn load(from: &Self::Array) -> Self;
    /// The number of each lane.
    fn from_fn(number: impl Fn(usize) -> f64) -> Self;
    /// The numbers of eight from the position `first`, which must be a multiple of the number of lanes.
    fn load_some(from: &[f64; 8], first: usize) -> Self;
    fn store(self) -> Self::Array;
    /// To the numbers of eight from the position `first`, which must be a multiple of the number of lanes.
    #[inline(always)]
    fn store_some(self, to: &mut [f64; 8], first: usize) {
        let stored = self.store();
        (0..Self::LANES).for_each(|lane| to[first + lane] = stored[lane]);
    }
    /// Passes the numbers of each lane in eight vectors to `row`.
    fn store_rows(columns: [Self; 8], row: impl FnMut(usize, [f64; 8]));
    /// As [`Doubles::store_rows`], rounded to float32.
    fn store_singles(columns: [Self; 8], row: impl FnMut(usize, [f32; 8]));
    /// Rounded to float32.
    fn to_single(self) -> Self;
    /// Two to the power `-e`, where `2^(e-1) <= |self| < 2^e`; any number if `e` is below -1021 or above 1022.
    fn power_below_one(self) -> Self;
    /// `self * factor - subtrahend`, rounded once.
    fn mul_sub(self, factor: Self, subtrahend: Self) -> Self;
    /// `summand - self * factor`, rounded once.
    fn neg_mul_add(self, factor: Self, summand: Self) -> Self;
    /// The lesser of each pair; `other` if they do not compare.
    fn lesser(self, other: Self) -> Self;
    /// The greater of each pair; `other` if they do not compare.
    fn greater(self, other: Self) -> Self;
    fn abs(self) -> Self;
    fn sqrt(self) -> Self;
    /// `self` in lanes in which `sign` has its sign bit set, else `other`.
    fn where_negative(self, sign: Self, other: Self) -> Self;
    /// `self` in the lanes of a mask, else `other`.
    fn where_set(self, lanes: u8, other: Self) -> Self;
    /// Without the lower 27 bits of the mantissa, the upper half of the number.
    fn upper_half(self) -> Self;
    fn is_less(self, other: Self) -> u8;
    fn is_at_most(self, other: Self) -> u8;
}

/// The bits that [`Doubles::upper_half`] keeps.
const UPPER_HALF: u64 = !0x7ff_ffff;

/// Eight float32 numbers. A comparison sets all bits of the lanes in which it holds: that is a mask.
pub(crate) trait Singles: Copy + Debug {
    fn splat(x: f32) -> Self;
    fn load(from: &[f32; 8]) -> Self;
    /// `self * factor - subtrahend`, rounded once.
    fn mul_sub(self, factor: Self, subtrahend: Self) -> Self;
    fn mul(self, factor: Self) -> Self;
    /// The lesser of each pair; `other` if they do not compare.
    fn lesser(self, other: Self) -> Self;
    /// The greater of each pair; `other` if they do not compare.
    fn greater(self, other: Self) -> Self;
    fn is_at_most(self, other: Self) -> Self;
    fn is_less(self, other: Self) -> Self;
    /// A mask as bits, the first lane in the lowest.
    fn bits(self) -> u8;
    /// The lesser of each pair in the lanes of a mask, `other` in the rest.
    fn lesser_where(self, mask: Self, other: Self) -> Self;
}
