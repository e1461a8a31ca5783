//! Every set of instructions gives the bits of plain Rust.

use super::*;
use crate::testkit::random::Random;

/// Numbers for every operation.
struct Operands {
    doubles: [[f64; 8]; 3],
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
        let doubles = [0; 3].map(|_| [0; 8].map(|_| double()));
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
fn mask<S: Simd>(lanes: u8) -> S::F32x8 {
    let bits = |lane: usize| if lanes >> lane & 1 == 1 { -1.0 } else { 1.0 };
    let signs: [f32; 8] = std::array::from_fn(bits);
    S::F32x8::load(&signs).is_less(S::F32x8::splat(0.0))
}

/// The results of all operations.
#[inline(always)]
fn all<S: Simd>(of: &Operands) -> Vec<u64> {
    let mut out = Vec::new();
    doubles::<f64>(of, &mut out);
    doubles::<S::F64x4>(of, &mut out);
    doubles::<S::Wide>(of, &mut out);
    let four = of.singles[0].first_chunk().expect("eight numbers");
    out.extend(S::widen(four).store().map(bits));
    singles::<S>(of, &mut out);
    let lanes_of = |values: S::U32x8| {
        let mut stored = [0; 8];
        S::store_u32(values, &mut stored);
        stored.map(u64::from)
    };
    let words = S::load_u32(&of.words);
    out.extend(lanes_of(words));
    out.extend(lanes_of(S::descending(S::F32x8::load(&of.depths), mask::<S>(of.lanes))));
    out.extend(lanes_of(S::permute(words, S::load_u32(&of.keys))));
    let kept = of.lanes.count_ones() as usize;
    out.extend(&lanes_of(S::compress(words, of.lanes))[..kept]);
    out.push(u64::from(S::at_most(S::load_u32(&of.keys), of.most)));
    out.extend(S::transpose_bits(&of.bytes));
    S::prefetch(&of.bytes);
    out
}

/// A power, of numbers for which it is defined.
#[inline(always)]
fn of_power<F: Doubles>(x: F) -> F {
    let size = x.abs();
    size.lesser(F::splat(1e300)).greater(F::splat(1e-300)).power_below_one()
}

/// The results of operations on eight numbers, as many at a time as `F` has.
#[inline(always)]
fn doubles<F: Doubles>(of: &Operands, out: &mut Vec<u64>) {
    let mut lanes: [Vec<u64>; 8] = Default::default();
    for first in (0..8).step_by(F::LANES) {
        let load = |k: usize| F::load_some(&of.doubles[k], first);
        let [a, b, c] = [load(0), load(1), load(2)];
        let results = [
            F::splat(of.doubles[0][0]),
            F::load(&a.store()),
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
            a.to_single(),
            F::from_fn(|lane| of.doubles[1][first + lane]),
            of_power(a),
            a.where_set(of.lanes >> first, b),
            a.upper_half(),
        ];
        let masks = [a.is_less(b), a.is_at_most(b), a.is_less(a), a.is_at_most(a)];
        let columns = [a, b, c, a + b, a - b, a * b, a / b, -a];
        F::store_rows(columns, |lane, row| lanes[first + lane].extend(row.map(bits)));
        F::store_singles(columns, |lane, row| lanes[first + lane].extend(row.map(|x| bits(f64::from(x)))));
        for lane in 0..F::LANES {
            let out = &mut lanes[first + lane];
            out.extend(results.iter().map(|result| bits(result.store()[lane])));
            out.extend(masks.iter().map(|mask| u64::from(mask >> lane & 1)));
        }
    }
    out.extend(lanes.iter().flatten());
}

#[inline(always)]
fn singles<S: Simd>(of: &Operands, out: &mut Vec<u64>) {
    let [a, b, c] =
        [S::F32x8::load(&of.singles[0]), S::F32x8::load(&of.singles[1]), S::F32x8::load(&of.singles[2])];
    let results = [
        S::F32x8::splat(of.singles[0][0]),
        a,
        a.mul_sub(b, c),
        a.mul(b),
        a.lesser(b),
        a.greater(b),
        a.lesser_where(mask::<S>(of.lanes), b),
    ];
    for result in results {
        // There is no store of float32: comparisons with 0 to 7 find the value of each lane.
        out.push(u64::from(result.is_at_most(result).bits()));
        for bound in of.singles.iter().flatten().chain(&of.depths) {
            out.push(u64::from(result.is_at_most(S::F32x8::splat(*bound)).bits()));
            out.push(u64::from(result.is_less(S::F32x8::splat(*bound)).bits()));
            out.push(u64::from(S::F32x8::splat(*bound).is_at_most(result).bits()));
        }
        for product in [(a, b), (b, c)].map(|(x, y)| x.mul(y)) {
            out.push(u64::from(result.is_at_most(product).bits()));
        }
        // The bits of what is not negative, but for the lowest three.
        out.extend(key_bits::<S>(result.greater(S::F32x8::splat(0.0))));
    }
}

#[inline(always)]
fn key_bits<S: Simd>(numbers: S::F32x8) -> [u64; 8] {
    let mut keys = [0; 8];
    S::store_u32(S::descending(numbers, mask::<S>(0xff)), &mut keys);
    keys.map(u64::from)
}

struct All<'a>(&'a Operands);

impl Task for All<'_> {
    type Output = Vec<u64>;

    #[inline(always)]
    fn run<S: Simd>(self) -> Vec<u64> {
        all::<S>(self.0)
    }
}

/// A set of instructions that the CPU has.
type Set = (&'static str, fn(&Operands) -> Vec<u64>);

fn sets() -> Vec<Set> {
    let mut sets: Vec<Set> = vec![("plain Rust", |of| Portable::call(All(of)))];
    #[cfg(target_arch = "x86_64")]
    {
        if avx2::is_supported() {
            sets.push(("AVX2", |of| Avx2::call(All(of))));
        }
        if avx512::is_supported() {
            sets.push(("AVX-512", |of| Avx512::call(All(of))));
        }
    }
    sets
}

#[test]
fn operations_have_the_bits_of_plain_rust() {
    let sets = sets();
    println!("compared: {:?}", sets.iter().map(|(name, _)| name).collect::<Vec<_>>());
    let mut random = Random::new(1);
    for case in 0..5_000 {
        let operands = Operands::any(&mut random);
        let expected = all::<Portable>(&operands);
        for (name, results) in &sets {
            let found = results(&operands);
            let differs = found.iter().zip(&expected).position(|(a, b)| a != b);
            assert_eq!((differs, found.len()), (None, expected.len()), "case {case}, {name}");
        }
    }
}
