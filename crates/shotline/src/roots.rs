//! Real roots of polynomials up to degree 4.
