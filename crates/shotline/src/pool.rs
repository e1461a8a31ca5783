//! Pools of threads that are kept from use to use, so that a batch or a mesh does not start threads of its own.
//!
//! The global pool of rayon is not used for work that is divided: a process that was forked does not have its threads,
//! and would wait for them for ever.

use std::sync::Mutex;

use rayon::{ThreadPool, ThreadPoolBuilder};

/// The pools that nobody uses now, the latest one last, each with another number of threads.
static KEPT: Mutex<Vec<OwnedPool>> = Mutex::new(Vec::new());

/// More kept pools than this would be idle threads: one for meshes, one for batches and one for pictures.
const MOST_KEPT: usize = 3;

/// More threads take longer to start than they save.
const MOST_THREADS: usize = 256;

/// Does work on a number of threads, at most 256; 0 for one per core. Passes their number. What is divided in this work, such as the
/// building of meshes, is divided among these threads. If none can be started, the calling thread does the work.
pub fn on_threads<T: Send>(threads: usize, work: impl FnOnce(usize) -> T + Send) -> T {
    match PoolInUse::of(threads.min(MOST_THREADS)).or_else(|| PoolInUse::of(1)) {
        Some(pool) => pool.run(work),
        None => alone(|| work(1)),
    }
}

/// Does work that is divided among threads: those of the pool that the calling thread is in, or of a kept one.
pub(crate) fn divided<T: Send>(work: impl FnOnce() -> T + Send) -> T {
    if rayon::current_thread_index().is_some() { work() } else { on_threads(0, |_| work()) }
}

/// Does work on the calling thread. From then on the thread is a pool, so that nothing on it looks for the global one.
fn alone<T>(work: impl FnOnce() -> T) -> T {
    if let Ok(pool) = ThreadPoolBuilder::new().num_threads(1).use_current_thread().build() {
        // The pool lasts as long as the thread.
        std::mem::forget(pool);
    }
    work()
}

/// A pool, and what it was made for.
struct OwnedPool {
    /// The process that started its threads. A process that was forked from it does not have them.
    process: u32,
    threads: usize,
    pool: ThreadPool,
}

/// A pool that one caller uses, and no other: short work must not wait for long work. It is kept when it is dropped.
struct PoolInUse(Option<OwnedPool>);

impl PoolInUse {
    /// A pool of some threads, 0 for one per core; `None` if they cannot be started.
    fn of(threads: usize) -> Option<PoolInUse> {
        let pool = match take_kept(threads) {
            Some(kept) => kept,
            None => {
                let pool = ThreadPoolBuilder::new().num_threads(threads).build().ok()?;
                OwnedPool { process: std::process::id(), threads, pool }
            }
        };
        Some(PoolInUse(Some(pool)))
    }

    /// Does work on its threads. Passes their number.
    fn run<T: Send>(&self, work: impl FnOnce(usize) -> T + Send) -> T {
        match &self.0 {
            Some(OwnedPool { pool, .. }) => pool.install(|| work(pool.current_num_threads())),
            None => work(1),
        }
    }
}

impl Drop for PoolInUse {
    fn drop(&mut self) {
        if let Some(pool) = self.0.take() {
            keep(pool);
        }
    }
}

/// Takes the kept pool of so many threads.
fn take_kept(threads: usize) -> Option<OwnedPool> {
    change_kept(|kept| {
        let place = kept.iter().position(|pool| pool.threads == threads)?;
        Some(kept.remove(place))
    })?
}

/// Keeps a pool, in place of one of as many threads, or of the one that was kept first.
fn keep(pool: OwnedPool) {
    // The pool that is not kept ends when the lock is free again.
    drop(change_kept(|kept| {
        let same = kept.iter().position(|other| other.threads == pool.threads);
        let place = same.or((kept.len() == MOST_KEPT).then_some(0));
        let left_out = place.map(|place| kept.remove(place));
        kept.push(pool);
        left_out
    }));
}

/// Changes the kept pools, all of which have threads. Never waits for the lock, which another thread may have held for
/// ever when this process was forked; then nothing is done.
fn change_kept<T>(change: impl FnOnce(&mut Vec<OwnedPool>) -> T) -> Option<T> {
    let mut kept = KEPT.try_lock().ok()?;
    let process = std::process::id();
    // To drop a pool of another process would be to wait for its threads.
    kept.extract_if(.., |pool| pool.process != process).for_each(std::mem::forget);
    Some(change(&mut kept))
}

#[cfg(test)]
mod tests {
    use std::collections::HashSet;
    use std::thread::{ThreadId, current};

    use rayon::prelude::*;

    use super::*;

    fn threads_of(pool: &PoolInUse) -> HashSet<ThreadId> {
        pool.run(|_| rayon::broadcast(|_| current().id())).into_iter().collect()
    }

    /// One test, since all tests of the process share the kept pools: another one may take them at any time.
    #[test]
    fn a_pool_is_used_by_one_caller_at_a_time_and_kept() {
        let mut kept = 0;
        for _ in 0..100 {
            let first = PoolInUse::of(3).expect("threads");
            let second = PoolInUse::of(3).expect("threads");
            let of_first = threads_of(&first);
            assert_eq!(of_first.len(), 3);
            assert!(of_first.is_disjoint(&threads_of(&second)));
            drop((second, first));
            let other = PoolInUse::of(2).expect("threads");
            assert_eq!(other.run(|threads| threads), 2);
            drop(other);
            let again = PoolInUse::of(3).expect("threads");
            kept += usize::from(threads_of(&again) == of_first);
        }
        assert!(kept > 50, "{kept} of 100 pools were kept");
    }

    #[test]
    fn work_in_a_pool_is_divided_among_its_threads() {
        let threads = on_threads(3, |_| divided(rayon::current_num_threads));
        assert_eq!(threads, 3);
        let in_none = rayon::current_thread_index();
        assert_eq!((in_none, divided(|| rayon::current_thread_index().is_some())), (None, true));
    }

    #[test]
    fn a_thread_without_others_does_all_work_itself() {
        let work = || {
            for _ in 0..2 {
                let own = current().id();
                let others = || (0..10_000).into_par_iter().filter(|_| current().id() != own).count();
                assert_eq!((alone(others), alone(rayon::current_num_threads), divided(others)), (0, 1, 0));
            }
        };
        std::thread::spawn(work).join().expect("the work is done");
    }
}
