//! Parallel processing of the objects of a data set, longest first, so that all threads are busy until the end.

use base::error::Result;
use std::sync::atomic::{AtomicBool, AtomicUsize, Ordering};
use std::sync::{Mutex, PoisonError};

/// Calls `run` for each of `work.len()` objects, with its index and a number of threads, on `threads` threads in total.
/// `work` is the expected work of each object in any unit. Returns the results in the order of the objects.
///
/// # Errors
/// Returns the first error in the order of the objects; after an error, no further object is started.
pub fn longest_first<T: Send>(
    work: &[u64],
    threads: usize,
    run: impl Fn(usize, usize) -> Result<T> + Sync,
) -> Result<Vec<T>> {
    let mut order: Vec<usize> = (0..work.len()).collect();
    order.sort_by_key(|i| std::cmp::Reverse(work[*i]));
    let workers = threads.clamp(1, work.len().max(1));
    let (next, stop) = (AtomicUsize::new(0), AtomicBool::new(false));
    let slots: Vec<Mutex<Option<Result<T>>>> = work.iter().map(|_| Mutex::new(None)).collect();
    std::thread::scope(|scope| {
        for _ in 0..workers {
            scope.spawn(|| {
                loop {
                    let k = next.fetch_add(1, Ordering::Relaxed);
                    let Some(&index) = order.get(k).filter(|_| !stop.load(Ordering::Relaxed)) else { return };
                    // The last objects share the threads of the workers that are idle.
                    let share = (threads / (order.len() - k).min(workers)).max(1);
                    let done = run(index, share);
                    stop.fetch_or(done.is_err(), Ordering::Relaxed);
                    *slots[index].lock().unwrap_or_else(PoisonError::into_inner) = Some(done);
                }
            });
        }
    });
    let done = slots.into_iter().filter_map(|slot| slot.into_inner().unwrap_or_else(PoisonError::into_inner));
    // A result is missing only after an error.
    done.collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use base::error::Error;

    #[test]
    fn every_object_runs_once_the_longest_first_and_the_last_has_all_threads() {
        let begun = Mutex::new(Vec::new());
        let shares = longest_first(&[1, 5, 3, 5], 1, |i, share| {
            begun.lock().unwrap().push(i);
            Ok((i, share))
        });
        assert_eq!(shares.unwrap(), [(0, 1), (1, 1), (2, 1), (3, 1)]);
        assert_eq!(begun.into_inner().unwrap(), [1, 3, 2, 0]);
        assert_eq!(longest_first(&[7], 4, |_, share| Ok(share)).unwrap(), [4]);
        assert!(longest_first::<()>(&[], 2, |_, _| Ok(())).unwrap().is_empty());
        let failed = longest_first(&[1, 1], 1, |i, _| if i == 0 { Err(Error::Start("no".into())) } else { Ok(()) });
        assert!(failed.is_err());
    }
}
