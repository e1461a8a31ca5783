//! The operations in plain Rust, for every CPU. The others are held to it by tests.

use std::ops::{Add, Div, Mul, Neg, Sub};

use super::{F32x8, F64x4, Simd};
use crate::math::Real;

/// Plain Rust.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Portable;

/// Four numbers.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Doubles([f64; 4]);

/// Eight numbers.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Singles([f32; 8]);

impl Doubles {
    #[inline(always)]
    fn zip(self, other: Doubles, with: impl Fn(f64, f64) -> f64) -> Doubles {
        Doubles(std::array::from_fn(|i| with(self.0[i], other.0[i])))
    }

    #[inline(always)]
    fn mask(self, other: Doubles, holds: impl Fn(f64, f64) -> bool) -> u8 {
        (0..4).fold(0, |mask, i| mask | u8::from(holds(self.0[i], other.0[i])) << i)
    }
}

macro_rules! operators {
    ($($operator:ident $method:ident),*) => {$(
        impl $operator for Doubles {
            type Output = Doubles;
            #[inline(always)]
            fn $method(self, other: Doubles) -> Doubles {
                self.zip(other, f64::$method)
            }
        }
    )*};
}
operators!(Add add, Sub sub, Mul mul, Div div);

impl Neg for Doubles {
    type Output = Doubles;
    #[inline(always)]
    fn neg(self) -> Doubles {
        Doubles(self.0.map(f64::neg))
    }
}

impl Real for Doubles {
    #[inline(always)]
    fn splat(x: f64) -> Doubles {
        Doubles([x; 4])
    }

    #[inline(always)]
    fn mul_add(self, factor: Doubles, summand: Doubles) -> Doubles {
        Doubles(std::array::from_fn(|i| self.0[i].mul_add(factor.0[i], summand.0[i])))
    }
}

impl F64x4 for Doubles {
    #[inline(always)]
    fn load(from: &[f64; 4]) -> Doubles {
        Doubles(*from)
    }

    #[inline(always)]
    fn widen(from: &[f32; 4]) -> Doubles {
        Doubles(from.map(f64::from))
    }

    #[inline(always)]
    fn store(self) -> [f64; 4] {
        self.0
    }

    #[inline(always)]
    fn mul_sub(self, factor: Doubles, subtrahend: Doubles) -> Doubles {
        self.mul_add(factor, -subtrahend)
    }

    #[inline(always)]
    fn neg_mul_add(self, factor: Doubles, summand: Doubles) -> Doubles {
        (-self).mul_add(factor, summand)
    }

    #[inline(always)]
    fn lesser(self, other: Doubles) -> Doubles {
        self.zip(other, |a, b| if a < b { a } else { b })
    }

    #[inline(always)]
    fn greater(self, other: Doubles) -> Doubles {
        self.zip(other, |a, b| if a > b { a } else { b })
    }

    #[inline(always)]
    fn sqrt(self) -> Doubles {
        Doubles(self.0.map(f64::sqrt))
    }

    #[inline(always)]
    fn abs(self) -> Doubles {
        Doubles(self.0.map(f64::abs))
    }

    #[inline(always)]
    fn where_negative(self, sign: Doubles, other: Doubles) -> Doubles {
        let pick = |i: usize| if sign.0[i].is_sign_negative() { self.0[i] } else { other.0[i] };
        Doubles(std::array::from_fn(pick))
    }

    #[inline(always)]
    fn is_less(self, other: Doubles) -> u8 {
        self.mask(other, |a, b| a < b)
    }

    #[inline(always)]
    fn is_at_most(self, other: Doubles) -> u8 {
        self.mask(other, |a, b| a <= b)
    }
}

impl F32x8 for Singles {
    #[inline(always)]
    fn splat(x: f32) -> Singles {
        Singles([x; 8])
    }

    #[inline(always)]
    fn load(from: &[f32; 8]) -> Singles {
        Singles(*from)
    }

    #[inline(always)]
    fn mul_sub(self, factor: Singles, subtrahend: Singles) -> Singles {
        Singles(std::array::from_fn(|i| self.0[i].mul_add(factor.0[i], -subtrahend.0[i])))
    }

    #[inline(always)]
    fn mul(self, factor: Singles) -> Singles {
        Singles(std::array::from_fn(|i| self.0[i] * factor.0[i]))
    }

    #[inline(always)]
    fn lesser(self, other: Singles) -> Singles {
        Singles(std::array::from_fn(|i| if self.0[i] < other.0[i] { self.0[i] } else { other.0[i] }))
    }

    #[inline(always)]
    fn greater(self, other: Singles) -> Singles {
        Singles(std::array::from_fn(|i| if self.0[i] > other.0[i] { self.0[i] } else { other.0[i] }))
    }

    #[inline(always)]
    fn is_at_most(self, other: Singles) -> Singles {
        Singles(std::array::from_fn(|i| mask_if(self.0[i] <= other.0[i])))
    }

    #[inline(always)]
    fn is_less(self, other: Singles) -> Singles {
        Singles(std::array::from_fn(|i| mask_if(self.0[i] < other.0[i])))
    }

    #[inline(always)]
    fn bits(self) -> u8 {
        (0..8).fold(0, |mask, i| mask | u8::from(self.0[i].is_sign_negative()) << i)
    }

    #[inline(always)]
    fn or_infinity(self, mask: Singles) -> Singles {
        let pick = |i: usize| if mask.0[i].is_sign_negative() { self.0[i] } else { f32::INFINITY };
        Singles(std::array::from_fn(pick))
    }
}

/// The lane of a mask.
#[inline(always)]
fn mask_if(condition: bool) -> f32 {
    f32::from_bits(if condition { u32::MAX } else { 0 })
}

impl Simd for Portable {
    type F64 = Doubles;
    type F32 = Singles;
    type U32 = [u32; 8];

    #[inline(always)]
    fn load_u32(from: &[u32; 8]) -> [u32; 8] {
        *from
    }

    #[inline(always)]
    fn store_u32(values: [u32; 8], to: &mut [u32; 8]) {
        *to = values;
    }

    #[inline(always)]
    fn descending(numbers: Singles, lanes: Singles) -> [u32; 8] {
        let key = |i: usize| {
            if lanes.0[i].is_sign_negative() { ((numbers.0[i].to_bits() & !7) | i as u32) + 8 } else { 0 }
        };
        let mut keys: [u32; 8] = std::array::from_fn(key);
        keys.sort_unstable_by(|a, b| b.cmp(a));
        keys
    }

    #[inline(always)]
    fn permute(values: [u32; 8], positions: [u32; 8]) -> [u32; 8] {
        positions.map(|at| values[(at & 7) as usize])
    }

    #[inline(always)]
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

    #[inline(always)]
    fn at_most(values: [u32; 8], most: u32) -> u8 {
        (0..8).fold(0, |mask, i| mask | u8::from(values[i] <= most) << i)
    }

    #[inline(always)]
    fn transpose_bits(bytes: &[u8; 64]) -> [u64; 8] {
        let mask = |bit: usize| (0..64).fold(0, |mask, i| mask | u64::from(bytes[i] >> bit & 1) << i);
        std::array::from_fn(mask)
    }

    #[inline(always)]
    fn prefetch<T>(_at: *const T) {}
}
