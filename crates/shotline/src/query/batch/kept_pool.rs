//! A pool of threads that is kept from batch to batch, so that a batch does not start threads of its own.

use std::sync::Mutex;

use rayon::{ThreadPool, ThreadPoolBuilder};

/// The pool that no batch uses now.
static KEPT: Mutex<Option<OwnedPool>> = Mutex::new(None);

/// A pool, and what it was made for.
struct OwnedPool {
    /// The process that started its threads. A process that was forked from it does not have them.
    process: u32,
    threads: usize,
    pool: ThreadPool,
}

/// A pool that one batch uses, and no other: a short batch must not wait for a long one. It is kept when it is dropped.
pub(super) struct PoolInUse(Option<OwnedPool>);

impl PoolInUse {
    /// A pool of some threads, 0 for one per core; `None` if they cannot be started.
    pub fn of(threads: usize) -> Option<PoolInUse> {
        let kept = exchange(None).filter(|kept| kept.threads == threads);
        let pool = match kept {
            Some(kept) => kept,
            None => {
                let pool = ThreadPoolBuilder::new().num_threads(threads).build().ok()?;
                OwnedPool { process: std::process::id(), threads, pool }
            }
        };
        Some(PoolInUse(Some(pool)))
    }

    /// Does work on its threads. Passes their number.
    pub fn run<T: Send>(&self, work: impl FnOnce(usize) -> T + Send) -> T {
        match &self.0 {
            Some(OwnedPool { pool, .. }) => pool.install(|| work(pool.current_num_threads())),
            None => work(1),
        }
    }
}

impl Drop for PoolInUse {
    fn drop(&mut self) {
        drop(exchange(self.0.take()));
    }
}

/// Exchanges the kept pool with another one, and returns it if its threads exist. Never waits for the lock, which another
/// thread may have held for ever when this process was forked; then the other one is dropped.
fn exchange(other: Option<OwnedPool>) -> Option<OwnedPool> {
    let before = std::mem::replace(&mut *KEPT.try_lock().ok()?, other)?;
    if before.process == std::process::id() {
        return Some(before);
    }
    // To drop it would be to wait for its threads.
    std::mem::forget(before);
    None
}

#[cfg(test)]
mod tests {
    use std::collections::HashSet;
    use std::thread::{ThreadId, current};

    use super::*;

    fn threads_of(pool: &PoolInUse) -> HashSet<ThreadId> {
        pool.run(|_| rayon::broadcast(|_| current().id())).into_iter().collect()
    }

    /// One test, since all batches of the process share the kept pool: another one may take it at any time.
    #[test]
    fn a_pool_is_used_by_one_batch_at_a_time_and_kept() {
        let mut kept = 0;
        for _ in 0..100 {
            let first = PoolInUse::of(3).expect("threads");
            let second = PoolInUse::of(3).expect("threads");
            let of_first = threads_of(&first);
            assert_eq!(of_first.len(), 3);
            assert!(of_first.is_disjoint(&threads_of(&second)));
            drop((second, first));
            let again = PoolInUse::of(3).expect("threads");
            kept += usize::from(threads_of(&again) == of_first);
            let other = PoolInUse::of(2).expect("threads");
            assert_eq!(other.run(|threads| threads), 2);
        }
        assert!(kept > 50, "{kept} of 100 pools were kept");
    }
}
