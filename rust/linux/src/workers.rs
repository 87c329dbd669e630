// SPDX-License-Identifier: Apache-2.0
//! Threads that run reactions of one level side by side.

use std::sync::{Mutex, OnceLock, PoisonError};

use lf_model::{Job, Worker, WorkerPool};
use rayon::{ThreadPool, ThreadPoolBuilder};

/// The threads of this process, beside the event loop's; none if the operating system had none. They start when they
/// are first needed.
static POOL: OnceLock<Option<ThreadPool>> = OnceLock::new();

/// `COUNT` threads, the event loop's among them.
#[derive(Clone, Copy, Debug)]
pub struct Threads<const COUNT: usize>;

impl<const COUNT: usize> Threads<COUNT> {
    fn pool() -> Option<&'static ThreadPool> {
        let name = |index| format!("worker {}", index + 1);
        let build = || match ThreadPoolBuilder::new().num_threads(COUNT.max(2) - 1).thread_name(name).build() {
            Ok(pool) => Some(pool),
            Err(error) => {
                log::warn!("reactions run in one thread instead of {COUNT}: {error}");
                None
            }
        };
        POOL.get_or_init(build).as_ref()
    }
}

impl<const COUNT: usize> WorkerPool for Threads<COUNT> {
    fn run(&self, workers: &mut [Worker<'_>], jobs: &mut [Job<'_>]) {
        let Some((own, others)) = workers.split_first_mut() else { return };
        let jobs = Mutex::new(jobs.iter_mut());
        // A thread that is free takes the next one.
        let work = |worker: &mut Worker<'_>| {
            loop {
                let next = jobs.lock().unwrap_or_else(PoisonError::into_inner).next();
                let Some(job) = next else { break };
                worker.run(job);
            }
        };
        let work = &work;
        let Some(pool) = Self::pool() else { return work(own) };
        pool.in_place_scope(|scope| {
            for worker in others {
                scope.spawn(move |_| work(worker));
            }
            work(own);
        });
    }
}
