//! Vectors of four float64 and of eight float32 numbers, by the instructions of the CPU.
//!
//! A kernel is written once, generic over [`Simd`], with every function inlined into one entry. The entry is
//! compiled for each set of instructions, and the best that the CPU has is picked at run time. Every operation rounds as
//! IEEE 754 says, so all of them give the same bits.

#[cfg(target_arch = "x86_64")]
mod avx2;
mod portable;

use std::fmt::Debug;

use crate::math::Real;

#[cfg(target_arch = "x86_64")]
pub(crate) use avx2::Avx2;
pub(crate) use portable::Portable;

/// A set of instructions.
pub(crate) trait Simd: Copy + 'static {
    type F64: F64x4;
    type F32: F32x8;
    /// Eight unsigned integers.
    type U32: Copy;

    /// Eight integers from memory.
    fn load_u32(from: &[u32; 8]) -> Self::U32;

    /// Eight integers to memory.
    fn store_u32(values: Self::U32, to: &mut [u32; 8]);

    /// Sorts the lanes of a mask by their numbers, which are not negative, in descending order. Returns a key for each
    /// such lane, and zeros behind them. The low three bits of a key are the lane, the others those of the number, plus 8:
    /// so no key is zero. Numbers that differ only in those bits count as equal.
    fn descending(numbers: Self::F32, lanes: Self::F32) -> Self::U32;

    /// The values at the positions given by the low three bits of each lane.
    fn permute(values: Self::U32, positions: Self::U32) -> Self::U32;

    /// The values of the lanes of a mask, in order, and then anything.
    fn compress(values: Self::U32, lanes: u8) -> Self::U32;

    /// A mask of the lanes with values of at most `most`. Both must be below `2^31`.
    fn at_most(values: Self::U32, most: u32) -> u8;

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
    let task = match avx2::run(task) {
        Ok(output) => return output,
        Err(task) => task,
    };
    task.run::<Portable>()
}

/// Four float64 numbers. Comparisons give a mask, the first lane in the lowest bit.
pub(crate) trait F64x4: Real + Debug {
    fn load(from: &[f64; 4]) -> Self;
    fn widen(from: &[f32; 4]) -> Self;
    fn store(self) -> [f64; 4];
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
    fn is_less(self, other: Self) -> u8;
    fn is_at_most(self, other: Self) -> u8;
}

/// Eight float32 numbers. A comparison sets all bits of the lanes in which it holds: that is a mask.
pub(crate) trait F32x8: Copy + Debug {
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
    /// `self` in the lanes of a mask, infinity in the others.
    fn or_infinity(self, mask: Self) -> Self;
}
