//! The operations by AVX2 and FMA.
//!
//! Safety of every block here: the instructions exist on the CPU, because [`Avx2`] is named only in functions compiled
//! for it, and these are called only where the CPU was found to have them (see [`super::dispatch`]). Loads and stores
//! are unaligned and of whole arrays, so they stay within what a reference points at.

use std::arch::x86_64::*;
use std::ops::{Add, Div, Mul, Neg, Sub};

use super::{Doubles, Simd, Singles, Task, UPPER_HALF};
use crate::math::Real;

/// Whether the CPU has these instructions.
#[inline]
pub(super) fn is_supported() -> bool {
    is_x86_feature_detected!("avx2")
        && is_x86_feature_detected!("fma")
        && is_x86_feature_detected!("bmi1")
        && is_x86_feature_detected!("bmi2")
        && is_x86_feature_detected!("lzcnt")
        && is_x86_feature_detected!("popcnt")
}

#[target_feature(enable = "avx2,fma,bmi1,bmi2,lzcnt,popcnt")]
fn run<T: Task>(task: T) -> T::Output {
    task.run::<Avx2>()
}

/// AVX2 with fused multiply-add.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Avx2;

/// Four numbers.
#[derive(Clone, Copy, Debug)]
pub(crate) struct F64x4(pub __m256d);

/// Eight numbers.
#[derive(Clone, Copy, Debug)]
pub(crate) struct F32x8(pub __m256);

macro_rules! operators {
    ($($operator:ident $method:ident $instruction:ident),*) => {$(
        impl $operator for F64x4 {
            type Output = F64x4;
            #[inline(always)]
            fn $method(self, other: F64x4) -> F64x4 {
                F64x4(unsafe { $instruction(self.0, other.0) })
            }
        }
    )*};
}
operators!(Add add _mm256_add_pd, Sub sub _mm256_sub_pd, Mul mul _mm256_mul_pd, Div div _mm256_div_pd);

impl Neg for F64x4 {
    type Output = F64x4;
    #[inline(always)]
    fn neg(self) -> F64x4 {
        F64x4(unsafe { _mm256_xor_pd(self.0, _mm256_set1_pd(-0.0)) })
    }
}

/// The rows of four columns.
#[inline(always)]
fn transposed([a, b, c, d]: [__m256d; 4]) -> [__m256d; 4] {
    unsafe {
        let (ab_even, ab_odd) = (_mm256_unpacklo_pd(a, b), _mm256_unpackhi_pd(a, b));
        let (cd_even, cd_odd) = (_mm256_unpacklo_pd(c, d), _mm256_unpackhi_pd(c, d));
        [
            _mm256_permute2f128_pd::<0x20>(ab_even, cd_even),
            _mm256_permute2f128_pd::<0x20>(ab_odd, cd_odd),
            _mm256_permute2f128_pd::<0x31>(ab_even, cd_even),
            _mm256_permute2f128_pd::<0x31>(ab_odd, cd_odd),
        ]
    }
}

#[inline(always)]
fn bits_of(mask: __m256d) -> u8 {
    unsafe { _mm256_movemask_pd(mask) as u8 }
}

impl Real for F64x4 {
    #[inline(always)]
    fn splat(x: f64) -> F64x4 {
        F64x4(unsafe { _mm256_set1_pd(x) })
    }

    #[inline(always)]
    fn mul_add(self, factor: F64x4, summand: F64x4) -> F64x4 {
        F64x4(unsafe { _mm256_fmadd_pd(self.0, factor.0, summand.0) })
    }
}

impl Doubles for F64x4 {
    const LANES: usize = 4;
    type Array = [f64; 4];

    #[inline(always)]
    fn load(from: &[f64; 4]) -> F64x4 {
        F64x4(unsafe { _mm256_loadu_pd(from.as_ptr()) })
    }

    #[inline(always)]
    fn from_fn(number: impl Fn(usize) -> f64) -> F64x4 {
        F64x4::load(&[number(0), number(1), number(2), number(3)])
    }

    #[inline(always)]
    fn load_some(from: &[f64; 8], first: usize) -> F64x4 {
        let [low, high] = [[from[0], from[1], from[2], from[3]], [from[4], from[5], from[6], from[7]]];
        F64x4::load(if first == 0 { &low } else { &high })
    }

    #[inline(always)]
    fn store(self) -> [f64; 4] {
        let mut to = [0.0; 4];
        unsafe { _mm256_storeu_pd(to.as_mut_ptr(), self.0) };
        to
    }

    #[inline(always)]
    fn store_rows(columns: [F64x4; 8], mut row: impl FnMut(usize, [f64; 8])) {
        let [a, b, c, d, e, f, g, h] = columns;
        let (low, high) = (transposed([a.0, b.0, c.0, d.0]), transposed([e.0, f.0, g.0, h.0]));
        for (lane, (low, high)) in low.into_iter().zip(high).enumerate() {
            let mut numbers = [0.0; 8];
            unsafe {
                _mm256_storeu_pd(numbers.as_mut_ptr(), low);
                _mm256_storeu_pd(numbers.as_mut_ptr().add(4), high);
            }
            row(lane, numbers);
        }
    }

    #[inline(always)]
    fn store_singles(columns: [F64x4; 8], mut row: impl FnMut(usize, [f32; 8])) {
        let [a, b, c, d, e, f, g, h] = columns;
        let (low, high) = (transposed([a.0, b.0, c.0, d.0]), transposed([e.0, f.0, g.0, h.0]));
        for (lane, (low, high)) in low.into_iter().zip(high).enumerate() {
            let mut singles = [0.0; 8];
            unsafe {
                _mm_storeu_ps(singles.as_mut_ptr(), _mm256_cvtpd_ps(low));
                _mm_storeu_ps(singles.as_mut_ptr().add(4), _mm256_cvtpd_ps(high));
            }
            row(lane, singles);
        }
    }

    #[inline(always)]
    fn to_single(self) -> F64x4 {
        F64x4(unsafe { _mm256_cvtps_pd(_mm256_cvtpd_ps(self.0)) })
    }

    #[inline(always)]
    fn power_below_one(self) -> F64x4 {
        F64x4(unsafe {
            let exponent = _mm256_and_pd(self.0, _mm256_set1_pd(f64::INFINITY));
            let largest = _mm256_set1_epi64x(2045 << 52);
            _mm256_castsi256_pd(_mm256_sub_epi64(largest, _mm256_castpd_si256(exponent)))
        })
    }

    #[inline(always)]
    fn mul_sub(self, factor: F64x4, subtrahend: F64x4) -> F64x4 {
        F64x4(unsafe { _mm256_fmsub_pd(self.0, factor.0, subtrahend.0) })
    }

    #[inline(always)]
    fn neg_mul_add(self, factor: F64x4, summand: F64x4) -> F64x4 {
        F64x4(unsafe { _mm256_fnmadd_pd(self.0, factor.0, summand.0) })
    }

    #[inline(always)]
    fn lesser(self, other: F64x4) -> F64x4 {
        F64x4(unsafe { _mm256_min_pd(self.0, other.0) })
    }

    #[inline(always)]
    fn greater(self, other: F64x4) -> F64x4 {
        F64x4(unsafe { _mm256_max_pd(self.0, other.0) })
    }

    #[inline(always)]
    fn sqrt(self) -> F64x4 {
        F64x4(unsafe { _mm256_sqrt_pd(self.0) })
    }

    #[inline(always)]
    fn abs(self) -> F64x4 {
        F64x4(unsafe { _mm256_andnot_pd(_mm256_set1_pd(-0.0), self.0) })
    }

    #[inline(always)]
    fn where_negative(self, sign: F64x4, other: F64x4) -> F64x4 {
        F64x4(unsafe { _mm256_blendv_pd(other.0, self.0, sign.0) })
    }

    #[inline(always)]
    fn where_set(self, lanes: u8, other: F64x4) -> F64x4 {
        F64x4(unsafe {
            let bits = _mm256_setr_epi64x(1, 2, 4, 8);
            let set = _mm256_and_si256(_mm256_set1_epi64x(i64::from(lanes)), bits);
            let set = _mm256_castsi256_pd(_mm256_cmpeq_epi64(set, bits));
            _mm256_blendv_pd(other.0, self.0, set)
        })
    }

    #[inline(always)]
    fn upper_half(self) -> F64x4 {
        F64x4(unsafe { _mm256_and_pd(self.0, _mm256_set1_pd(f64::from_bits(UPPER_HALF))) })
    }

    #[inline(always)]
    fn is_less(self, other: F64x4) -> u8 {
        bits_of(unsafe { _mm256_cmp_pd::<_CMP_LT_OQ>(self.0, other.0) })
    }

    #[inline(always)]
    fn is_at_most(self, other: F64x4) -> u8 {
        bits_of(unsafe { _mm256_cmp_pd::<_CMP_LE_OQ>(self.0, other.0) })
    }
}

impl Singles for F32x8 {
    #[inline(always)]
    fn splat(x: f32) -> F32x8 {
        F32x8(unsafe { _mm256_set1_ps(x) })
    }

    #[inline(always)]
    fn load(from: &[f32; 8]) -> F32x8 {
        F32x8(unsafe { _mm256_loadu_ps(from.as_ptr()) })
    }

    #[inline(always)]
    fn mul_sub(self, factor: F32x8, subtrahend: F32x8) -> F32x8 {
        F32x8(unsafe { _mm256_fmsub_ps(self.0, factor.0, subtrahend.0) })
    }

    #[inline(always)]
    fn mul(self, factor: F32x8) -> F32x8 {
        F32x8(unsafe { _mm256_mul_ps(self.0, factor.0) })
    }

    #[inline(always)]
    fn lesser(self, other: F32x8) -> F32x8 {
        F32x8(unsafe { _mm256_min_ps(self.0, other.0) })
    }

    #[inline(always)]
    fn greater(self, other: F32x8) -> F32x8 {
        F32x8(unsafe { _mm256_max_ps(self.0, other.0) })
    }

    #[inline(always)]
    fn is_at_most(self, other: F32x8) -> F32x8 {
        F32x8(unsafe { _mm256_cmp_ps::<_CMP_LE_OQ>(self.0, other.0) })
    }

    #[inline(always)]
    fn is_less(self, other: F32x8) -> F32x8 {
        F32x8(unsafe { _mm256_cmp_ps::<_CMP_LT_OQ>(self.0, other.0) })
    }

    #[inline(always)]
    fn bits(self) -> u8 {
        unsafe { _mm256_movemask_ps(self.0) as u8 }
    }

    #[inline(always)]
    fn lesser_where(self, mask: F32x8, other: F32x8) -> F32x8 {
        F32x8(unsafe { _mm256_blendv_ps(other.0, _mm256_min_ps(self.0, other.0), mask.0) })
    }
}

/// For each mask, the lanes that are set, in order.
static SET_LANES: [[u8; 8]; 256] = set_lanes();

const fn set_lanes() -> [[u8; 8]; 256] {
    let mut table = [[0; 8]; 256];
    let mut mask = 0;
    while mask < 256 {
        let (mut lane, mut count) = (0, 0);
        while lane < 8 {
            if mask >> lane & 1 == 1 {
                table[mask][count] = lane as u8;
                count += 1;
            }
            lane += 1;
        }
        mask += 1;
    }
    table
}

/// The step of a sorting network.
pub(super) trait Exchange {
    /// Sorts pairs of lanes: the greater goes to the lanes that are not in `LESSER`.
    fn exchange<const LESSER: i32>(keys: __m256i, partners: __m256i) -> __m256i;
}

impl Exchange for Avx2 {
    #[inline(always)]
    fn exchange<const LESSER: i32>(keys: __m256i, partners: __m256i) -> __m256i {
        unsafe {
            let (lesser, greater) = (_mm256_min_epu32(keys, partners), _mm256_max_epu32(keys, partners));
            _mm256_blend_epi32::<LESSER>(greater, lesser)
        }
    }
}

/// [`Simd::descending`] by a bitonic network (Batcher 1968, "Sorting networks and their applications").
#[inline(always)]
pub(super) fn descending<E: Exchange>(numbers: F32x8, lanes: F32x8) -> __m256i {
    unsafe {
        let bits = _mm256_andnot_si256(_mm256_set1_epi32(7), _mm256_castps_si256(numbers.0));
        let keys = _mm256_add_epi32(bits, _mm256_setr_epi32(8, 9, 10, 11, 12, 13, 14, 15));
        let v = _mm256_and_si256(keys, _mm256_castps_si256(lanes.0));
        let v = E::exchange::<0xAA>(v, _mm256_shuffle_epi32::<0xB1>(v));
        let v = E::exchange::<0xCC>(v, _mm256_shuffle_epi32::<0x1B>(v));
        let v = E::exchange::<0xAA>(v, _mm256_shuffle_epi32::<0xB1>(v));
        let reversed = _mm256_setr_epi32(7, 6, 5, 4, 3, 2, 1, 0);
        let v = E::exchange::<0xF0>(v, _mm256_permutevar8x32_epi32(v, reversed));
        let v = E::exchange::<0xCC>(v, _mm256_shuffle_epi32::<0x4E>(v));
        E::exchange::<0xAA>(v, _mm256_shuffle_epi32::<0xB1>(v))
    }
}

impl Simd for Avx2 {
    type F64x4 = F64x4;
    type Wide = F64x4;
    type F32x8 = F32x8;
    type U32x8 = __m256i;

    #[inline(always)]
    fn call<T: Task>(task: T) -> T::Output {
        // Safety: the CPU has these instructions.
        unsafe { run(task) }
    }

    #[inline(always)]
    fn widen(from: &[f32; 4]) -> F64x4 {
        F64x4(unsafe { _mm256_cvtps_pd(_mm_loadu_ps(from.as_ptr())) })
    }

    #[inline(always)]
    fn load_u32(from: &[u32; 8]) -> __m256i {
        unsafe { _mm256_loadu_si256(from.as_ptr().cast()) }
    }

    #[inline(always)]
    fn store_u32(values: __m256i, to: &mut [u32; 8]) {
        unsafe { _mm256_storeu_si256(to.as_mut_ptr().cast(), values) }
    }

    #[inline(always)]
    fn descending(numbers: F32x8, lanes: F32x8) -> __m256i {
        descending::<Avx2>(numbers, lanes)
    }

    #[inline(always)]
    fn permute(values: __m256i, positions: __m256i) -> __m256i {
        unsafe { _mm256_permutevar8x32_epi32(values, positions) }
    }

    #[inline(always)]
    fn compress(values: __m256i, lanes: u8) -> __m256i {
        let positions = &SET_LANES[usize::from(lanes)];
        unsafe {
            let positions = _mm256_cvtepu8_epi32(_mm_loadl_epi64(positions.as_ptr().cast()));
            _mm256_permutevar8x32_epi32(values, positions)
        }
    }

    #[inline(always)]
    fn at_most(values: __m256i, most: u32) -> u8 {
        unsafe {
            let above = _mm256_cmpgt_epi32(values, _mm256_set1_epi32(most as i32));
            !(_mm256_movemask_ps(_mm256_castsi256_ps(above)) as u8)
        }
    }

    #[inline(always)]
    fn transpose_bits(bytes: &[u8; 64]) -> [u64; 8] {
        unsafe {
            let low = _mm256_loadu_si256(bytes.as_ptr().cast());
            let high = _mm256_loadu_si256(bytes.as_ptr().add(32).cast());
            let mut masks = [0; 8];
            for (bit, mask) in masks.iter_mut().enumerate() {
                // The sign bits of the bytes become the mask.
                let shift = _mm_cvtsi32_si128(7 - bit as i32);
                let signs = |v| _mm256_movemask_epi8(_mm256_sll_epi16(v, shift)) as u32;
                *mask = u64::from(signs(low)) | u64::from(signs(high)) << 32;
            }
            masks
        }
    }

    #[inline(always)]
    fn prefetch<T>(at: *const T) {
        // A prefetch of any address is valid.
        unsafe { _mm_prefetch::<_MM_HINT_T0>(at.cast()) }
    }
}
