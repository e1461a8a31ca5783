//! What all connections of a viewer share.

use std::sync::Arc;
use std::sync::atomic::{AtomicBool, AtomicUsize};

use super::address::Address;
use super::stage::Stage;

/// A viewer that runs.
pub struct Server {
    pub stage: Arc<Stage>,
    pub address: Address,
    pub is_stopped: Arc<AtomicBool>,
    /// The number of open pages.
    pub pages: AtomicUsize,
    /// The number of open connections.
    pub connections: AtomicUsize,
}
