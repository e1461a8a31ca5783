//! The operations by AVX-512, on registers of 256 bits except where eight float64 numbers are needed.
//!
//! Safety of every block here: as in [`super::avx2`].

use std::arch::x86_64::*;
use std::ops::{Add, Div, Mul, Neg, Sub};

use super::avx2::{self, Avx2, Exchange, F32x8, F64x4};
use super::{Doubles, Simd, Task, UPPER_HALF};
use crate::math::Real;

/// Whether the CPU has these instructions.
#[inline]
pub(super) fn is_supported() -> bool {
    avx2::is_supported()
        && is_x86_feature_detected!("avx512f")
        && is_x86_feature_detected!("avx512vl")
        && is_x86_feature_detected!("avx512dq")
        && is_x86_feature_detected!("avx512bw")
}

#[target_feature(enable = "avx512f,avx512vl,avx512dq,avx512bw,avx2,fma,bmi1,bmi2,lzcnt,popcnt")]
fn run<T: Task>(task: T) -> T::Output {
    task.run::<Avx512>()
}

/// AVX-512 as all CPUs with its 256-bit forms have it.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Avx512;

/// Eight numbers.
#[derive(Clone, Copy, Debug)]
pub(crate) struct F64x8(__m512d);

macro_rules! operators {
    ($($operator:ident $method:ident $instruction:ident),*) => {$(
        impl $operator for F64x8 {
            type Output = F64x8;
            #[inline(always)]
            fn $method(self, other: F64x8) -> F64x8 {
                F64x8(unsafe { $instruction(self.0, other.0) })
            }
        }
    )*};
}
operators!(Add add _mm512_add_pd, Sub sub _mm512_sub_pd, Mul mul _mm512_mul_pd, Div div _mm512_div_pd);

impl Neg for F64x8 {
    type Output = F64x8;
    #[inline(always)]
    fn neg(self) -> F64x8 {
        F64x8(unsafe { _mm512_xor_pd(self.0, _mm512_set1_pd(-0.0)) })
    }
}

impl Real for F64x8 {
    #[inline(always)]
    fn splat(x: f64) -> F64x8 {
        F64x8(unsafe { _mm512_set1_pd(x) })
    }

    #[inline(always)]
    fn mul_add(self, factor: F64x8, summand: F64x8) -> F64x8 {
        F64x8(unsafe { _mm512_fmadd_pd(self.0, factor.0, summand.0) })
    }
}

impl Doubles for F64x8 {
    const LANES: usize = 8;
    type Array = [f64; 8];

    #[inline(always)]
    fn load(from: &[f64; 8]) -> F64x8 {
        F64x8(unsafe { _mm512_loadu_pd(from.as_ptr()) })
    }

    #[inline(always)]
    fn from_fn(number: impl Fn(usize) -> f64) -> F64x8 {
        let [a, b, c, d] = [number(0), number(1), number(2), number(3)];
        let [e, f, g, h] = [number(4), number(5), number(6), number(7)];
        F64x8::load(&[a, b, c, d, e, f, g, h])
    }

    #[inline(always)]
    fn load_some(from: &[f64; 8], _first: usize) -> F64x8 {
        F64x8::load(from)
    }

    #[inline(always)]
    fn store(self) -> [f64; 8] {
        let mut to = [0.0; 8];
        unsafe { _mm512_storeu_pd(to.as_mut_ptr(), self.0) };
        to
    }

    #[inline(always)]
    fn store_rows(columns: [F64x8; 8], mut row: impl FnMut(usize, [f64; 8])) {
        for (lane, numbers) in transposed(columns).into_iter().enumerate() {
            row(lane, F64x8(numbers).store());
        }
    }

    #[inline(always)]
    fn store_singles(columns: [F64x8; 8], mut row: impl FnMut(usize, [f32; 8])) {
        for (lane, numbers) in transposed(columns).into_iter().enumerate() {
            let mut singles = [0.0; 8];
            unsafe { _mm256_storeu_ps(singles.as_mut_ptr(), _mm512_cvtpd_ps(numbers)) };
            row(lane, singles);
        }
    }

    #[inline(always)]
    fn to_single(self) -> F64x8 {
        F64x8(unsafe { _mm512_cvtps_pd(_mm512_cvtpd_ps(self.0)) })
    }

    #[inline(always)]
    fn power_below_one(self) -> F64x8 {
        F64x8(unsafe {
            let exponent = _mm512_and_pd(self.0, _mm512_set1_pd(f64::INFINITY));
            let largest = _mm512_set1_epi64(2045 << 52);
            _mm512_castsi512_pd(_mm512_sub_epi64(largest, _mm512_castpd_si512(exponent)))
        })
    }

    #[inline(always)]
    fn mul_sub(self, factor: F64x8, subtrahend: F64x8) -> F64x8 {
        F64x8(unsafe { _mm512_fmsub_pd(self.0, factor.0, subtrahend.0) })
    }

    #[inline(always)]
    fn neg_mul_add(self, factor: F64x8, summand: F64x8) -> F64x8 {
        F64x8(unsafe { _mm512_fnmadd_pd(self.0, factor.0, summand.0) })
    }

    #[inline(always)]
    fn lesser(self, other: F64x8) -> F64x8 {
        F64x8(unsafe { _mm512_min_pd(self.0, other.0) })
    }

    #[inline(always)]
    fn greater(self, other: F64x8) -> F64x8 {
        F64x8(unsafe { _mm512_max_pd(self.0, other.0) })
    }

    #[inline(always)]
    fn abs(self) -> F64x8 {
        F64x8(unsafe { _mm512_andnot_pd(_mm512_set1_pd(-0.0), self.0) })
    }

    #[inline(always)]
    fn sqrt(self) -> F64x8 {
        F64x8(unsafe { _mm512_sqrt_pd(self.0) })
    }

    #[inline(always)]
    fn where_negative(self, sign: F64x8, other: F64x8) -> F64x8 {
        F64x8(unsafe {
            let negative = _mm512_movepi64_mask(_mm512_castpd_si512(sign.0));
            _mm512_mask_blend_pd(negative, other.0, self.0)
        })
    }

    #[inline(always)]
    fn where_set(self, lanes: u8, other: F64x8) -> F64x8 {
        F64x8(unsafe { _mm512_mask_blend_pd(lanes, other.0, self.0) })
    }

    #[inline(always)]
    fn upper_half(self) -> F64x8 {
        F64x8(unsafe { _mm512_and_pd(self.0, _mm512_set1_pd(f64::from_bits(UPPER_HALF))) })
    }

    #[inline(always)]
    fn is_less(self, other: F64x8) -> u8 {
        unsafe { _mm512_cmp_pd_mask::<_CMP_LT_OQ>(self.0, other.0) }
    }

    #[inline(always)]
    fn is_at_most(self, other: F64x8) -> u8 {
        unsafe { _mm512_cmp_pd_mask::<_CMP_LE_OQ>(self.0, other.0) }
    }
}

/// The rows of eight columns.
#[inline(always)]
fn transposed(columns: [F64x8; 8]) -> [__m512d; 8] {
    unsafe {
        let [a, b, c, d, e, f, g, h] = columns;
        // Pairs of lanes, then quarters of two pairs of columns, then of all four.
        let (ab, ab_odd) = (_mm512_unpacklo_pd(a.0, b.0), _mm512_unpackhi_pd(a.0, b.0));
        let (cd, cd_odd) = (_mm512_unpacklo_pd(c.0, d.0), _mm512_unpackhi_pd(c.0, d.0));
        let (ef, ef_odd) = (_mm512_unpacklo_pd(e.0, f.0), _mm512_unpackhi_pd(e.0, f.0));
        let (gh, gh_odd) = (_mm512_unpacklo_pd(g.0, h.0), _mm512_unpackhi_pd(g.0, h.0));
        let [row0, row2, row4, row6] = joined(ab, cd, ef, gh);
        let [row1, row3, row5, row7] = joined(ab_odd, cd_odd, ef_odd, gh_odd);
        [row0, row1, row2, row3, row4, row5, row6, row7]
    }
}

/// For each quarter, that of all four registers.
#[inline(always)]
fn joined(a: __m512d, b: __m512d, c: __m512d, d: __m512d) -> [__m512d; 4] {
    unsafe {
        let (low_ab, high_ab) = (_mm512_shuffle_f64x2::<0x44>(a, b), _mm512_shuffle_f64x2::<0xEE>(a, b));
        let (low_cd, high_cd) = (_mm512_shuffle_f64x2::<0x44>(c, d), _mm512_shuffle_f64x2::<0xEE>(c, d));
        [
            _mm512_shuffle_f64x2::<0x88>(low_ab, low_cd),
            _mm512_shuffle_f64x2::<0xDD>(low_ab, low_cd),
            _mm512_shuffle_f64x2::<0x88>(high_ab, high_cd),
            _mm512_shuffle_f64x2::<0xDD>(high_ab, high_cd),
        ]
    }
}

impl Exchange for Avx512 {
    #[inline(always)]
    fn exchange<const LESSER: i32>(keys: __m256i, partners: __m256i) -> __m256i {
        unsafe { _mm256_mask_min_epu32(_mm256_max_epu32(keys, partners), LESSER as u8, keys, partners) }
    }
}

impl Simd for Avx512 {
    type F64x4 = F64x4;
    type Wide = F64x8;
    type F32x8 = F32x8;
    type U32x8 = __m256i;

    #[inline(always)]
    fn call<T: Task>(task: T) -> T::Output {
        // Safety: the CPU has these instructions.
        unsafe { run(task) }
    }

    #[inline(always)]
    fn widen(from: &[f32; 4]) -> F64x4 {
        Avx2::widen(from)
    }

    #[inline(always)]
    fn load_u32(from: &[u32; 8]) -> __m256i {
        Avx2::load_u32(from)
    }

    #[inline(always)]
    fn store_u32(values: __m256i, to: &mut [u32; 8]) {
        Avx2::store_u32(values, to);
    }

    #[inline(always)]
    fn descending(numbers: F32x8, lanes: F32x8) -> __m256i {
        avx2::descending::<Avx512>(numbers, lanes)
    }

    #[inline(always)]
    fn permute(values: __m256i, positions: __m256i) -> __m256i {
        Avx2::permute(values, positions)
    }

    #[inline(always)]
    fn compress(values: __m256i, lanes: u8) -> __m256i {
        unsafe { _mm256_maskz_compress_epi32(lanes, values) }
    }

    #[inline(always)]
    fn at_most(values: __m256i, most: u32) -> u8 {
        unsafe { _mm256_cmple_epu32_mask(values, _mm256_set1_epi32(most as i32)) }
    }

    #[inline(always)]
    fn transpose_bits(bytes: &[u8; 64]) -> [u64; 8] {
        unsafe {
            let bytes = _mm512_loadu_si512(bytes.as_ptr().cast());
            let mut masks = [0; 8];
            for (bit, mask) in masks.iter_mut().enumerate() {
                *mask = _mm512_test_epi8_mask(bytes, _mm512_set1_epi8((1u8 << bit) as i8));
            }
            masks
        }
    }

    #[inline(always)]
    fn prefetch<T>(at: *const T) {
        Avx2::prefetch(at);
    }
}
