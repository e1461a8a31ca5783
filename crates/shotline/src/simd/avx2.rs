//! The operations by AVX2 and FMA.
//!
//! Safety of every block here: the instructions exist on the CPU, because [`Avx2`] is named only in functions compiled
//! for it, and these are called only where the CPU was found to have them (see [`run`] and `Kernel::cast`). Loads and
//! stores are unaligned and of whole arrays, so they stay within what a reference points at.

use std::arch::x86_64::*;
use std::ops::{Add, Div, Mul, Neg, Sub};

use super::{F32x8, F64x4, Simd, Task};
use crate::math::Real;

/// Does work by these instructions, or returns it if the CPU does not have them.
#[inline]
pub(super) fn run<T: Task>(task: T) -> Result<T::Output, T> {
    if is_x86_feature_detected!("avx2") && is_x86_feature_detected!("fma") {
        // Safety: the CPU has been found to have these instructions.
        Ok(unsafe { run_compiled(task) })
    } else {
        Err(task)
    }
}

#[target_feature(enable = "avx2,fma")]
fn run_compiled<T: Task>(task: T) -> T::Output {
    task.run::<Avx2>()
}

/// AVX2 with fused multiply-add.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Avx2;

/// Four numbers.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Doubles(__m256d);

/// Eight numbers.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Singles(__m256);

macro_rules! operators {
    ($($operator:ident $method:ident $instruction:ident),*) => {$(
        impl $operator for Doubles {
            type Output = Doubles;
            #[inline(always)]
            fn $method(self, other: Doubles) -> Doubles {
                Doubles(unsafe { $instruction(self.0, other.0) })
            }
        }
    )*};
}
operators!(Add add _mm256_add_pd, Sub sub _mm256_sub_pd, Mul mul _mm256_mul_pd, Div div _mm256_div_pd);

impl Neg for Doubles {
    type Output = Doubles;
    #[inline(always)]
    fn neg(self) -> Doubles {
        Doubles(unsafe { _mm256_xor_pd(self.0, _mm256_set1_pd(-0.0)) })
    }
}

#[inline(always)]
fn bits_of(mask: __m256d) -> u8 {
    unsafe { _mm256_movemask_pd(mask) as u8 }
}

impl Real for Doubles {
    #[inline(always)]
    fn splat(x: f64) -> Doubles {
        Doubles(unsafe { _mm256_set1_pd(x) })
    }

    #[inline(always)]
    fn mul_add(self, factor: Doubles, summand: Doubles) -> Doubles {
        Doubles(unsafe { _mm256_fmadd_pd(self.0, factor.0, summand.0) })
    }
}

impl F64x4 for Doubles {
    #[inline(always)]
    fn load(from: &[f64; 4]) -> Doubles {
        Doubles(unsafe { _mm256_loadu_pd(from.as_ptr()) })
    }

    #[inline(always)]
    fn widen(from: &[f32; 4]) -> Doubles {
        Doubles(unsafe { _mm256_cvtps_pd(_mm_loadu_ps(from.as_ptr())) })
    }

    #[inline(always)]
    fn store(self) -> [f64; 4] {
        let mut to = [0.0; 4];
        unsafe { _mm256_storeu_pd(to.as_mut_ptr(), self.0) };
        to
    }

    #[inline(always)]
    fn mul_sub(self, factor: Doubles, subtrahend: Doubles) -> Doubles {
        Doubles(unsafe { _mm256_fmsub_pd(self.0, factor.0, subtrahend.0) })
    }

    #[inline(always)]
    fn neg_mul_add(self, factor: Doubles, summand: Doubles) -> Doubles {
        Doubles(unsafe { _mm256_fnmadd_pd(self.0, factor.0, summand.0) })
    }

    #[inline(always)]
    fn lesser(self, other: Doubles) -> Doubles {
        Doubles(unsafe { _mm256_min_pd(self.0, other.0) })
    }

    #[inline(always)]
    fn greater(self, other: Doubles) -> Doubles {
        Doubles(unsafe { _mm256_max_pd(self.0, other.0) })
    }

    #[inline(always)]
    fn sqrt(self) -> Doubles {
        Doubles(unsafe { _mm256_sqrt_pd(self.0) })
    }

    #[inline(always)]
    fn abs(self) -> Doubles {
        Doubles(unsafe { _mm256_andnot_pd(_mm256_set1_pd(-0.0), self.0) })
    }

    #[inline(always)]
    fn where_negative(self, sign: Doubles, other: Doubles) -> Doubles {
        Doubles(unsafe { _mm256_blendv_pd(other.0, self.0, sign.0) })
    }

    #[inline(always)]
    fn is_less(self, other: Doubles) -> u8 {
        bits_of(unsafe { _mm256_cmp_pd::<_CMP_LT_OQ>(self.0, other.0) })
    }

    #[inline(always)]
    fn is_at_most(self, other: Doubles) -> u8 {
        bits_of(unsafe { _mm256_cmp_pd::<_CMP_LE_OQ>(self.0, other.0) })
    }
}

impl F32x8 for Singles {
    #[inline(always)]
    fn splat(x: f32) -> Singles {
        Singles(unsafe { _mm256_set1_ps(x) })
    }

    #[inline(always)]
    fn load(from: &[f32; 8]) -> Singles {
        Singles(unsafe { _mm256_loadu_ps(from.as_ptr()) })
    }

    #[inline(always)]
    fn mul_sub(self, factor: Singles, subtrahend: Singles) -> Singles {
        Singles(unsafe { _mm256_fmsub_ps(self.0, factor.0, subtrahend.0) })
    }

    #[inline(always)]
    fn mul(self, factor: Singles) -> Singles {
        Singles(unsafe { _mm256_mul_ps(self.0, factor.0) })
    }

    #[inline(always)]
    fn lesser(self, other: Singles) -> Singles {
        Singles(unsafe { _mm256_min_ps(self.0, other.0) })
    }

    #[inline(always)]
    fn greater(self, other: Singles) -> Singles {
        Singles(unsafe { _mm256_max_ps(self.0, other.0) })
    }

    #[inline(always)]
    fn is_at_most(self, other: Singles) -> Singles {
        Singles(unsafe { _mm256_cmp_ps::<_CMP_LE_OQ>(self.0, other.0) })
    }

    #[inline(always)]
    fn is_less(self, other: Singles) -> Singles {
        Singles(unsafe { _mm256_cmp_ps::<_CMP_LT_OQ>(self.0, other.0) })
    }

    #[inline(always)]
    fn bits(self) -> u8 {
        unsafe { _mm256_movemask_ps(self.0) as u8 }
    }

    #[inline(always)]
    fn or_infinity(self, mask: Singles) -> Singles {
        Singles(unsafe { _mm256_blendv_ps(_mm256_set1_ps(f32::INFINITY), self.0, mask.0) })
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

/// Sorts pairs of lanes: the greater goes to the lanes that are not in `LESSER`.
#[inline(always)]
fn exchange<const LESSER: i32>(keys: __m256i, partners: __m256i) -> __m256i {
    unsafe {
        let (lesser, greater) = (_mm256_min_epu32(keys, partners), _mm256_max_epu32(keys, partners));
        _mm256_blend_epi32::<LESSER>(greater, lesser)
    }
}

impl Simd for Avx2 {
    type F64 = Doubles;
    type F32 = Singles;
    type U32 = __m256i;

    #[inline(always)]
    fn load_u32(from: &[u32; 8]) -> __m256i {
        unsafe { _mm256_loadu_si256(from.as_ptr().cast()) }
    }

    #[inline(always)]
    fn store_u32(values: __m256i, to: &mut [u32; 8]) {
        unsafe { _mm256_storeu_si256(to.as_mut_ptr().cast(), values) }
    }

    /// A bitonic network (Batcher 1968, "Sorting networks and their applications").
    #[inline(always)]
    fn descending(numbers: Singles, lanes: Singles) -> __m256i {
        unsafe {
            let bits = _mm256_andnot_si256(_mm256_set1_epi32(7), _mm256_castps_si256(numbers.0));
            let keys = _mm256_add_epi32(bits, _mm256_setr_epi32(8, 9, 10, 11, 12, 13, 14, 15));
            let v = _mm256_and_si256(keys, _mm256_castps_si256(lanes.0));
            let v = exchange::<0xAA>(v, _mm256_shuffle_epi32::<0xB1>(v));
            let v = exchange::<0xCC>(v, _mm256_shuffle_epi32::<0x1B>(v));
            let v = exchange::<0xAA>(v, _mm256_shuffle_epi32::<0xB1>(v));
            let reversed = _mm256_setr_epi32(7, 6, 5, 4, 3, 2, 1, 0);
            let v = exchange::<0xF0>(v, _mm256_permutevar8x32_epi32(v, reversed));
            let v = exchange::<0xCC>(v, _mm256_shuffle_epi32::<0x4E>(v));
            exchange::<0xAA>(v, _mm256_shuffle_epi32::<0xB1>(v))
        }
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

#[cfg(test)]
mod tests {
    use super::super::Portable;
    use super::*;
    use crate::testkit::random::Random;

    /// Numbers for every operation.
    struct Operands {
        doubles: [[f64; 4]; 3],
        singles: [[f32; 8]; 3],
        /// Not negative.
        depths: [f32; 8],
        words: [u32; 8],
        /// Below `2^31`.
        keys: [u32; 8],
        most: u32,
        bytes: [u8; 64],
        lanes: u8,
    }

    impl Operands {
        fn any(random: &mut Random) -> Operands {
            let mut double = || match random.below(8) {
                0 => [0.0, -0.0, f64::INFINITY, -f64::INFINITY, f64::NAN, 1.0][random.below(6)],
                1 => f64::from_bits(random.bits() & !(0x7ff << 52)),
                2 => f64::from_bits(random.bits()),
                _ => (random.number(-2.0, 2.0) * 8.0).round() * [0.125, 1e-3][random.below(2)],
            };
            let doubles = [0; 3].map(|_| [0; 4].map(|_| double()));
            let singles = [0; 3].map(|_| [0; 8].map(|_| double() as f32));
            let bits = |random: &mut Random| random.bits() as u32;
            let depth = |random: &mut Random| match random.below(4) {
                0 => [0.0, f32::INFINITY, f32::MIN_POSITIVE, 1.0][random.below(4)],
                1 => f32::from_bits(0x3f80_0000 | random.below(20) as u32),
                _ => random.number(0.0, 9.0) as f32,
            };
            Operands {
                doubles,
                singles,
                depths: [0; 8].map(|_| depth(random)),
                words: [0; 8].map(|_| bits(random)),
                keys: [0; 8].map(|_| bits(random) >> [1, 28][random.below(2)]),
                most: bits(random) >> [1, 28][random.below(2)],
                bytes: [0; 64].map(|_| bits(random) as u8),
                lanes: [bits(random) as u8, 0, 0xff][random.below(3)],
            }
        }
    }

    /// The bits of a number; all NaN are the same.
    fn bits(x: f64) -> u64 {
        if x.is_nan() { u64::MAX } else { x.to_bits() }
    }

    /// A mask of lanes.
    #[inline(always)]
    fn mask<S: Simd>(lanes: u8) -> S::F32 {
        let bits = |lane: usize| if lanes >> lane & 1 == 1 { -1.0 } else { 1.0 };
        let signs: [f32; 8] = std::array::from_fn(bits);
        S::F32::load(&signs).is_less(S::F32::splat(0.0))
    }

    /// The results of all operations.
    #[inline(always)]
    fn all<S: Simd>(of: &Operands) -> Vec<u64> {
        let mut out = Vec::new();
        doubles::<S>(of, &mut out);
        singles::<S>(of, &mut out);
        let lanes_of = |values: S::U32| {
            let mut stored = [0; 8];
            S::store_u32(values, &mut stored);
            stored.map(u64::from)
        };
        let words = S::load_u32(&of.words);
        out.extend(lanes_of(words));
        out.extend(lanes_of(S::descending(S::F32::load(&of.depths), mask::<S>(of.lanes))));
        out.extend(lanes_of(S::permute(words, S::load_u32(&of.keys))));
        let kept = of.lanes.count_ones() as usize;
        out.extend(&lanes_of(S::compress(words, of.lanes))[..kept]);
        out.push(u64::from(S::at_most(S::load_u32(&of.keys), of.most)));
        out.extend(S::transpose_bits(&of.bytes));
        S::prefetch(&of.bytes);
        out
    }

    #[inline(always)]
    fn doubles<S: Simd>(of: &Operands, out: &mut Vec<u64>) {
        let [a, b, c] =
            [S::F64::load(&of.doubles[0]), S::F64::load(&of.doubles[1]), S::F64::load(&of.doubles[2])];
        let quads = of.singles[0].first_chunk().expect("eight numbers");
        let results = [
            S::F64::splat(of.doubles[0][0]),
            S::F64::widen(quads),
            a + b,
            a - b,
            a * b,
            a / b,
            -a,
            a.mul_add(b, c),
            a.mul_sub(b, c),
            a.neg_mul_add(b, c),
            a.lesser(b),
            a.greater(b),
            a.lesser(a),
            a.abs(),
            a.abs().sqrt(),
            a.where_negative(b, c),
        ];
        for result in results {
            out.extend(result.store().map(bits));
        }
        out.extend([a.is_less(b), a.is_at_most(b), a.is_less(a), a.is_at_most(a)].map(u64::from));
    }

    #[inline(always)]
    fn singles<S: Simd>(of: &Operands, out: &mut Vec<u64>) {
        let [a, b, c] =
            [S::F32::load(&of.singles[0]), S::F32::load(&of.singles[1]), S::F32::load(&of.singles[2])];
        let results = [
            S::F32::splat(of.singles[0][0]),
            a,
            a.mul_sub(b, c),
            a.mul(b),
            a.lesser(b),
            a.greater(b),
            a.or_infinity(mask::<S>(of.lanes)),
        ];
        for result in results {
            // There is no store of float32: comparisons with 0 to 7 find the value of each lane.
            out.push(u64::from(result.is_at_most(result).bits()));
            for bound in of.singles.iter().flatten().chain(&of.depths) {
                out.push(u64::from(result.is_at_most(S::F32::splat(*bound)).bits()));
                out.push(u64::from(result.is_less(S::F32::splat(*bound)).bits()));
                out.push(u64::from(S::F32::splat(*bound).is_at_most(result).bits()));
            }
            for product in [(a, b), (b, c)].map(|(x, y)| x.mul(y)) {
                out.push(u64::from(result.is_at_most(product).bits()));
            }
            // The bits of what is not negative, but for the lowest three.
            out.extend(key_bits::<S>(result.greater(S::F32::splat(0.0))));
        }
    }

    #[inline(always)]
    fn key_bits<S: Simd>(numbers: S::F32) -> [u64; 8] {
        let mut keys = [0; 8];
        S::store_u32(S::descending(numbers, mask::<S>(0xff)), &mut keys);
        keys.map(u64::from)
    }

    #[target_feature(enable = "avx2,fma")]
    fn all_by_avx2(of: &Operands) -> Vec<u64> {
        all::<Avx2>(of)
    }

    #[test]
    fn operations_have_the_bits_of_plain_rust() {
        if !is_x86_feature_detected!("avx2") || !is_x86_feature_detected!("fma") {
            eprintln!("skipped: this CPU has no AVX2");
            return;
        }
        let mut random = Random::new(1);
        for case in 0..5_000 {
            let operands = Operands::any(&mut random);
            // Safety: the CPU has been found to have these instructions.
            let found = unsafe { all_by_avx2(&operands) };
            let expected = all::<Portable>(&operands);
            let differs = found.iter().zip(&expected).position(|(a, b)| a != b);
            assert_eq!((differs, found.len()), (None, expected.len()), "case {case}");
        }
    }
}
