//! What is sent to a page.

use serde_json::Value;

/// An answer.
pub enum Answer {
    Text(Value),
    /// Bytes behind a head that says what they are.
    Pixels {
        head: Value,
        bytes: Vec<u8>,
    },
}
