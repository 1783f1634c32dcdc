use super::*;

fn never() -> Option<Interrupt> {
    None
}

#[test]
fn a_map_keeps_the_order_for_any_number_of_threads() {
    for threads in [1, 2, 3, 8] {
        for n in [0, 1, 2, 100] {
            let flow = parallel_map(n, threads, || (), |i, ()| i * i, &mut never).unwrap();
            let expected: Vec<_> = (0..n).map(|i| i * i).collect();
            assert_eq!(flow, ControlFlow::Continue(expected), "{threads} threads");
        }
    }
}

#[test]
fn every_thread_keeps_its_own_workspace() {
    // Each task counts up its workspace; the counts must add up to the number of tasks.
    let workers = Workers::new(3).unwrap();
    let mut counts = [0_usize; 3];
    let flow = workers.run(
        &mut counts,
        500,
        &|_, count| *count += 1,
        &mut never,
        |_, ()| {},
    );
    assert!(flow.is_continue());
    assert_eq!(counts.iter().sum::<usize>(), 500);
}

#[test]
fn an_interrupt_ends_a_long_batch_early() {
    for threads in [1, 2] {
        let mut polls = 0;
        let mut stop = || {
            polls += 1;
            (polls > 2).then_some(Interrupt::User)
        };
        let done = AtomicUsize::new(0);
        let flow = parallel_map(
            10_000,
            threads,
            || (),
            |_, ()| {
                std::thread::sleep(Duration::from_millis(2));
                done.fetch_add(1, Ordering::Relaxed);
            },
            &mut stop,
        );
        assert_eq!(flow.unwrap(), ControlFlow::Break(Interrupt::User));
        // Two polls are 40 ms at most, 20 tasks a thread; ten times that for a busy machine.
        let done = done.into_inner();
        assert!(
            (1..400).contains(&done),
            "{done} tasks on {threads} threads"
        );
    }
}

#[test]
fn a_panic_reaches_the_caller_instead_of_hanging() {
    for threads in [1, 2] {
        let caught = std::panic::catch_unwind(|| {
            parallel_map(
                50,
                threads,
                || (),
                |i, ()| assert!(i != 30, "task thirty"),
                &mut never,
            )
        });
        let payload = caught.unwrap_err();
        let text = payload.downcast_ref::<&str>();
        assert_eq!(text, Some(&"task thirty"), "{threads} threads");
    }
}

#[test]
fn no_thread_is_refused() {
    let error = Workers::new(0).unwrap_err().to_string();
    assert_eq!(
        error,
        "threads: got 0; wanted at least 1. Use 1 to evaluate on the calling thread."
    );
}

#[test]
fn many_evaluations_return_raw_costs() {
    let objective = |x: &[f64]| if x[0] < 0.0 { f64::NAN } else { x[0] + x[1] };
    let xs = [1.0, 2.0, -1.0, 0.0, 0.25, 0.5];
    for threads in [1, 2] {
        let flow = evaluate_many(&objective, Candidates::new(&xs, 2), threads, &mut never);
        let ControlFlow::Continue(costs) = flow.unwrap() else {
            panic!("nothing interrupts");
        };
        assert_eq!((costs[0], costs[2]), (3.0, 0.75));
        assert!(costs[1].is_nan());
    }
}
