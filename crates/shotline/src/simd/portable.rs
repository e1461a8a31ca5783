//! The operations in plain Rust, for every CPU. The others are held to it by tests.

use std::ops::{Add, Div, Mul, Neg, Sub};

use super::single::EXPONENT;
use super::{Doubles, Simd, Singles, Task, UPPER_HALF};
use crate::math::Real;

/// Plain Rust.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Portable;

/// Four numbers.
#[derive(Clone, Copy, Debug)]
pub(crate) struct F64x4([f64; 4]);

/// Eight numbers.
#[derive(Clone, Copy, Debug)]
pub(crate) struct F32x8([f32; 8]);

impl F64x4 {
    #[cfg_attr(debug_assertions, inline(never))]
    #[cfg_attr(not(debug_assertions), inline(always))]
    fn zip(self, other: F64x4, with: impl Fn(f64, f64) -> f64) -> F64x4 {
        F64x4(std::array::from_fn(|i| with(self.0[i], other.0[i])))
    }

    #[cfg_attr(debug_assertions, inline(never))]
    #[cfg_attr(not(debug_assertions), inline(always))]
    fn mask(self, other: F64x4, holds: impl Fn(f64, f64) -> bool) -> u8 {
        (0..4).fold(0, |mask, i| mask | u8::from(holds(self.0[i], other.0[i])) << i)
    }
}

macro_rules! operators {
    ($($operator:ident $method:ident),*) => {$(
        impl $operator for F64x4 {
            type Output = F64x4;
            #[cfg_attr(debug_assertions, inline(never))]
            #[cfg_attr(not(debug_assertions), inline(always))]
            fn $method(self, other: F64x4) -> F64x4 {
                self.zip(other, f64::$method)
            }
        }
    )*};
}
operators!(Add add, Sub sub, Mul mul, Div div);

impl Neg for F64x4 {
    type Output = F64x4;
    #[cfg_attr(debug_assertions, inline(never))]
    #[cfg_attr(not(debug_assertions), inline(always))]
    fn neg(self) -> F64x4 {
        F64x4(self.0.map(f64::neg))
    }
}

impl Real for F64x4 {
    #[cfg_attr(debug_assertions, inline(never))]
    #[cfg_attr(not(debug_assertions), inline(always))]
    fn splat(x: f64) -> F64x4 {
        F64x4([x; 4])
    }

    #[cfg_attr(debug_assertions, inline(never))]
    #[cfg_attr(not(debug_assertions), inline(always))]
    fn mul_add(self, factor: F64x4, summand: F64x4) -> F64x4 {
        F64x4(std::array::from_fn(|i| self.0[i].mul_add(factor.0[i], summand.0[i])))
    }
}

impl Doubles for F64x4 {
    const LANES: usize = 4;
    type Array = [f64; 4];

    #[cfg_attr(debug_assertions, inline(never))]
    #[cfg_attr(not(debug_assertions), inline(always))]
    fn load(from: &[f64; 4]) -> F64x4 {
        F64x4(*from)
    }

    #[cfg_attr(debug_assertions, inline(never))]
    #[cfg_attr(not(debug_assertions), inline(always))]
    fn from_fn(number: impl Fn(usize) -> f64) -> F64x4 {
        F64x4([number(0), number(1), number(2), number(3)])
    }

    #[cfg_attr(debug_assertions, inline(never))]
    #[cfg_attr(not(debug_assertions), inline(always))]
    fn load_some(from: &[f64; 8], first: usize) -> F64x4 {
        F64x4(std::array::from_fn(|i| from[first + i]))
    }

    #[cfg_attr(debug_assertions, inline(never))]
    #[cfg_attr(not(debug_assertions), inline(always))]
    fn store(self) -> [f64; 4] {
        self.0
    }

    #[cfg_attr(debug_assertions, inline(never))]
    #[cfg_attr(not(debug_assertions), inline(always))]
    fn store_rows(columns: [F64x4; 8], mut row: impl FnMut(usize, [f64; 8])) {
        (0..4).for_each(|lane| row(lane, columns.map(|column| column.0[lane])));
    }

    #[cfg_attr(debug_assertions, inline(never))]
    #[cfg_attr(not(debug_assertions), inline(always))]
    fn store_singles(columns: [F64x4; 8], mut row: impl FnMut(usize, [f32; 8])) {
        (0..4).for_each(|lane| row(lane, columns.map(|column| column.0[lane] as f32)));
    }

    #[cfg_attr(debug_assertions, inline(never))]
    #[cfg_attr(not(debug_assertions), inline(always))]
    fn to_single(self) -> F64x4 {
        F64x4(self.0.map(|x| f64::from(x as f32)))
    }

    #[cfg_attr(debug_assertions, inline(never))]
    #[cfg_attr(not(debug_assertions), inline(always))]
    fn power_below_one(self) -> F64x4 {
        F64x4(self.0.map(|x| f64::from_bits((2045_u64 << 52).wrapping_sub(x.to_bits() & EXPONENT))))
    }

    #[cfg_attr(debug_assertions, inline(never))]
    #[cfg_attr(not(debug_assertions), inline(always))]
    fn mul_sub(self, factor: F64x4, subtrahend: F64x4) -> F64x4 {
        self.mul_add(factor, -subtrahend)
    }

    #[cfg_attr(debug_assertions, inline(never))]
    #[cfg_attr(not(debug_assertions), inline(always))]
    fn neg_mul_add(self, factor: F64x4, summand: F64x4) -> F64x4 {
        (-self).mul_add(factor, summand)
    }

    #[cfg_attr(debug_assertions, inline(never))]
    #[cfg_attr(not(debug_assertions), inline(always))]
    fn lesser(self, other: F64x4) -> F64x4 {
        self.zip(other, |a, b| if a < b { a } else { b })
    }

    #[cfg_attr(debug_assertions, inline(never))]
    #[cfg_attr(not(debug_assertions), inline(always))]
    fn greater(self, other: F64x4) -> F64x4 {
        self.zip(other, |a, b| if a > b { a } else { b })
    }

    #[cfg_attr(debug_assertions, inline(never))]
    #[cfg_attr(not(debug_assertions), inline(always))]
    fn sqrt(self) -> F64x4 {
        F64x4(self.0.map(f64::sqrt))
    }

    #[cfg_attr(debug_assertions, inline(never))]
    #[cfg_attr(not(debug_assertions), inline(always))]
    fn abs(self) -> F64x4 {
        F64x4(self.0.map(f64::abs))
    }

    #[cfg_attr(debug_assertions, inline(never))]
    #[cfg_attr(not(debug_assertions), inline(always))]
    fn where_negative(self, sign: F64x4, other: F64x4) -> F64x4 {
        let pick = |i: usize| if sign.0[i].is_sign_negative() { self.0[i] } else { other.0[i] };
        F64x4(std::array::from_fn(pick))
    }

    #[cfg_attr(debug_assertions, inline(never))]
    #[cfg_attr(not(debug_assertions), inline(always))]
    fn where_set(self, lanes: u8, other: F64x4) -> F64x4 {
        F64x4(std::array::from_fn(|i| if lanes >> i & 1 == 1 { self.0[i] } else { other.0[i] }))
    }

    #[cfg_attr(debug_assertions, inline(never))]
    #[cfg_attr(not(debug_assertions), inline(always))]
    fn upper_half(self) -> F64x4 {
        F64x4(self.0.map(|x| f64::from_bits(x.to_bits() & UPPER_HALF)))
    }

    #[cfg_attr(debug_assertions, inline(never))]
    #[cfg_attr(not(debug_assertions), inline(always))]
    fn is_less(self, other: F64x4) -> u8 {
        self.mask(other, |a, b| a < b)
    }

    #[cfg_attr(debug_assertions, inline(never))]
    #[cfg_attr(not(debug_assertions), inline(always))]
    fn is_at_most(self, other: F64x4) -> u8 {
        self.mask(other, |a, b| a <= b)
    }
}

impl Singles for F32x8 {
    #[cfg_attr(debug_assertions, inline(never))]
    #[cfg_attr(not(debug_assertions), inline(always))]
    fn splat(x: f32) -> F32x8 {
        F32x8([x; 8])
    }

    #[cfg_attr(debug_assertions, inline(never))]
    #[cfg_attr(not(debug_assertions), inline(always))]
    fn load(from: &[f32; 8]) -> F32x8 {
        F32x8(*from)
    }

    #[cfg_attr(debug_assertions, inline(never))]
    #[cfg_attr(not(debug_assertions), inline(always))]
    fn mul_sub(self, factor: F32x8, subtrahend: F32x8) -> F32x8 {
        F32x8(std::array::from_fn(|i| self.0[i].mul_add(factor.0[i], -subtrahend.0[i])))
    }

    #[cfg_attr(debug_assertions, inline(never))]
    #[cfg_attr(not(debug_assertions), inline(always))]
    fn mul(self, factor: F32x8) -> F32x8 {
        F32x8(std::array::from_fn(|i| self.0[i] * factor.0[i]))
    }

    #[cfg_attr(debug_assertions, inline(never))]
    #[cfg_attr(not(debug_assertions), inline(always))]
    fn lesser(self, other: F32x8) -> F32x8 {
        F32x8(std::array::from_fn(|i| if self.0[i] < other.0[i] { self.0[i] } else { other.0[i] }))
    }

    #[cfg_attr(debug_assertions, inline(never))]
    #[cfg_attr(not(debug_assertions), inline(always))]
    fn greater(self, other: F32x8) -> F32x8 {
        F32x8(std::array::from_fn(|i| if self.0[i] > other.0[i] { self.0[i] } else { other.0[i] }))
    }

    #[cfg_attr(debug_assertions, inline(never))]
    #[cfg_attr(not(debug_assertions), inline(always))]
    fn is_at_most(self, other: F32x8) -> F32x8 {
        F32x8(std::array::from_fn(|i| mask_if(self.0[i] <= other.0[i])))
    }

    #[cfg_attr(debug_assertions, inline(never))]
    #[cfg_attr(not(debug_assertions), inline(always))]
    fn is_less(self, other: F32x8) -> F32x8 {
        F32x8(std::array::from_fn(|i| mask_if(self.0[i] < other.0[i])))
    }

    #[cfg_attr(debug_assertions, inline(never))]
    #[cfg_attr(not(debug_assertions), inline(always))]
    fn bits(self) -> u8 {
        (0..8).fold(0, |mask, i| mask | u8::from(self.0[i].is_sign_negative()) << i)
    }

    #[cfg_attr(debug_assertions, inline(never))]
    #[cfg_attr(not(debug_assertions), inline(always))]
    fn lesser_where(self, mask: F32x8, other: F32x8) -> F32x8 {
        let is_less = |i: usize| mask.0[i].is_sign_negative() && self.0[i] < other.0[i];
        let pick = |i: usize| if is_less(i) { self.0[i] } else { other.0[i] };
        F32x8(std::array::from_fn(pick))
    }
}

/// The lane of a mask.
#[cfg_attr(debug_assertions, inline(never))]
#[cfg_attr(not(debug_assertions), inline(always))]
fn mask_if(condition: bool) -> f32 {
    f32::from_bits(if condition { u32::MAX } else { 0 })
}

impl Simd for Portable {
    type F64x4 = F64x4;
    type Wide = F64x4;
    type F32x8 = F32x8;
    type U32x8 = [u32; 8];

    #[cfg_attr(debug_assertions, inline(never))]
    #[cfg_attr(not(debug_assertions), inline(always))]
    fn call<T: Task>(task: T) -> T::Output {
        task.run::<Portable>()
    }

    #[cfg_attr(debug_assertions, inline(never))]
    #[cfg_attr(not(debug_assertions), inline(always))]
    fn widen(from: &[f32; 4]) -> F64x4 {
        F64x4(from.map(f64::from))
    }

    #[cfg_attr(debug_assertions, inline(never))]
    #[cfg_attr(not(debug_assertions), inline(always))]
    fn load_u32(from: &[u32; 8]) -> [u32; 8] {
        *from
    }

    #[cfg_attr(debug_assertions, inline(never))]
    #[cfg_attr(not(debug_assertions), inline(always))]
    fn store_u32(values: [u32; 8], to: &mut [u32; 8]) {
        *to = values;
    }

    #[cfg_attr(debug_assertions, inline(never))]
    #[cfg_attr(not(debug_assertions), inline(always))]
    fn descending(numbers: F32x8, lanes: F32x8) -> [u32; 8] {
        let key = |i: usize| {
            if lanes.0[i].is_sign_negative() { ((numbers.0[i].to_bits() & !7) | i as u32) + 8 } else { 0 }
        };
        let mut keys: [u32; 8] = std::array::from_fn(key);
        keys.sort_unstable_by(|a, b| b.cmp(a));
        keys
    }

    #[cfg_attr(debug_assertions, inline(never))]
    #[cfg_attr(not(debug_assertions), inline(always))]
    fn permute(values: [u32; 8], positions: [u32; 8]) -> [u32; 8] {
        positions.map(|at| values[(at & 7) as usize])
    }

    #[cfg_attr(debug_assertions, inline(never))]
    #[cfg_attr(not(debug_assertions), inline(always))]
    fn compress(values: [u32; 8], lanes: u8) -> [u32; 8] {
        let (mut out, mut count) = ([0; 8], 0);
        for (i, value) in values.into_iter().enumerate() {
            if lanes >> i & 1 == 1 {
                out[count] = value;
                count += 1;
            }
        }
        out
    }

    #[cfg_attr(debug_assertions, inline(never))]
    #[cfg_attr(not(debug_assertions), inline(always))]
    fn at_most(values: [u32; 8], most: u32) -> u8 {
        (0..8).fold(0, |mask, i| mask | u8::from(values[i] <= most) << i)
    }

    #[cfg_attr(debug_assertions, inline(never))]
    #[cfg_attr(not(debug_assertions), inline(always))]
    fn transpose_bits(bytes: &[u8; 64]) -> [u64; 8] {
        let mask = |bit: usize| (0..64).fold(0, |mask, i| mask | u64::from(bytes[i] >> bit & 1) << i);
        std::array::from_fn(mask)
    }

    #[cfg_attr(debug_assertions, inline(never))]
    #[cfg_attr(not(debug_assertions), inline(always))]
    fn prefetch<T>(_at: *const T) {}
}
