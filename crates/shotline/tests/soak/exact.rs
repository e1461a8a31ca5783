//! The crossings of a line with a torus in exact rational arithmetic. The real roots of the quartic are isolated
//! by Sturm's theorem, which is slow but certain.

use num_rational::BigRational;
use num_traits::{Signed, Zero};
use shotline::math::Vec3;

/// The coefficients of a polynomial, from the constant term upwards, without leading zeros.
type Poly = Vec<BigRational>;

fn exact(x: f64) -> BigRational {
    BigRational::from_float(x).expect("a finite number")
}

fn trimmed(mut p: Poly) -> Poly {
    while p.last().is_some_and(Zero::is_zero) {
        p.pop();
    }
    p
}

fn add(a: &Poly, b: &Poly, times: &BigRational) -> Poly {
    let at = |p: &Poly, i: usize| p.get(i).cloned().unwrap_or_else(BigRational::zero);
    trimmed((0..a.len().max(b.len())).map(|i| at(a, i) + at(b, i) * times).collect())
}

fn product(a: &Poly, b: &Poly) -> Poly {
    let mut out = vec![BigRational::zero(); (a.len() + b.len()).saturating_sub(1)];
    for (i, x) in a.iter().enumerate() {
        for (j, y) in b.iter().enumerate() {
            out[i + j] += x * y;
        }
    }
    trimmed(out)
}

fn remainder(a: &Poly, b: &Poly) -> Poly {
    let mut rest = a.clone();
    while rest.len() >= b.len() {
        let factor = -(&rest[rest.len() - 1] / &b[b.len() - 1]);
        let mut shifted = vec![BigRational::zero(); rest.len() - b.len()];
        shifted.extend(b.iter().cloned());
        let degree = rest.len() - 1;
        rest = add(&rest, &shifted, &factor);
        debug_assert!(rest.len() <= degree);
    }
    rest
}

fn value(p: &Poly, x: &BigRational) -> BigRational {
    p.iter().rev().fold(BigRational::zero(), |sum, c| sum * x + c)
}

/// The exact quartic of a torus along a line.
pub struct Section {
    /// The Sturm chain, whose first polynomial is the quartic.
    chain: Vec<Poly>,
    /// `|q|^2 + R^2 - r^2`, which is negative in a ball around the lemon of a spindle. The quartic's roots in
    /// that ball are not on the surface.
    ball: Poly,
}

impl Section {
    /// The torus of radii `major` and `minor` along `o + t d`.
    pub fn new(major: f64, minor: f64, o: Vec3, d: Vec3) -> Section {
        let square = |i: usize| {
            let coordinate = trimmed(vec![exact(o[i]), exact(d[i])]);
            product(&coordinate, &coordinate)
        };
        let one = exact(1.0);
        let (major2, minor2) = (exact(major) * exact(major), exact(minor) * exact(minor));
        let across = add(&square(0), &square(1), &one);
        let ball = add(&add(&across, &square(2), &one), &vec![&major2 - &minor2], &one);
        let quartic = add(&product(&ball, &ball), &across, &(-exact(4.0) * major2));
        let slope: Poly = (0..).zip(&quartic).skip(1).map(|(i, c)| c * exact(f64::from(i))).collect();
        let mut chain = vec![quartic, slope];
        while let [.., a, b] = chain.as_slice()
            && b.len() > 1
        {
            let rest: Poly = remainder(a, b).into_iter().map(|c| -c).collect();
            if rest.is_empty() {
                break;
            }
            chain.push(rest);
        }
        Section { chain, ball }
    }

    /// Counts the roots between `lo` and `hi` at which membership changes. Neither end may be a root.
    pub fn changes(&self, lo: f64, hi: f64) -> usize {
        let (lo, hi) = (exact(lo), exact(hi));
        let mut open = vec![(lo.clone(), self.variations(&lo), hi.clone(), self.variations(&hi))];
        let mut changes = 0;
        while let Some((lo, at_lo, hi, at_hi)) = open.pop() {
            match at_lo - at_hi {
                0 => {}
                1 => changes += usize::from(self.member(&lo) != self.member(&hi)),
                _ => {
                    let mut middle = (&lo + &hi) / exact(2.0);
                    if value(&self.chain[0], &middle).is_zero() {
                        middle = (&lo + &middle * exact(2.0)) / exact(3.0);
                    }
                    let at_middle = self.variations(&middle);
                    open.push((lo, at_lo, middle.clone(), at_middle));
                    open.push((middle, at_middle, hi, at_hi));
                }
            }
        }
        changes
    }

    /// The quartic is negative in the tube. In the lemon of a spindle it is not, but the ball function is.
    fn member(&self, t: &BigRational) -> bool {
        value(&self.chain[0], t).is_negative() || value(&self.ball, t).is_negative()
    }

    fn variations(&self, t: &BigRational) -> usize {
        let signs: Vec<bool> = (self.chain.iter())
            .map(|p| value(p, t))
            .filter(|v| !v.is_zero())
            .map(|v| v.is_negative())
            .collect();
        signs.windows(2).filter(|pair| pair[0] != pair[1]).count()
    }
}
