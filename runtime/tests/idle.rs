//! An idle pool costs no processor time. The only test of this process, since it counts the time of the whole
//! process.
#![cfg(all(target_os = "linux", not(loom)))]

use cellstep::pool::Pool;
use cellstep_core::executor::{Executor, Stage};
use std::fs;
use std::thread::sleep;
use std::time::Duration;

/// Processor time of this process in units of the kernel, mostly 10 ms each: fields 14 and 15 of proc(5)'s
/// `stat`.
fn processor_time() -> u64 {
    let stat = fs::read_to_string("/proc/self/stat").expect("proc is mounted");
    let (_, fields) = stat.rsplit_once(')').expect("the name is in parentheses");
    fields.split_whitespace().skip(11).take(2).map(|field| field.parse::<u64>().expect("a number")).sum()
}

#[test]
fn idle_pool_costs_no_processor_time() {
    let mut pool = Pool::new(8).expect("the system has threads");
    let mut tasks = [0_u32; 64];
    for _ in 0..100 {
        pool.for_each(Stage::Solve, &mut tasks, |runs| *runs += 1);
    }
    sleep(Duration::from_millis(100));
    let before = processor_time();
    sleep(Duration::from_secs(1));
    let spent = processor_time() - before;
    // One spinning thread would take about 100 on a free core, and tens on a busy one.
    assert!(spent <= 3, "{spent} units in a second of rest");
    pool.for_each(Stage::Solve, &mut tasks, |runs| *runs += 1);
    assert_eq!(tasks, [101; 64]);
}
