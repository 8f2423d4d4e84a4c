//! Calls run without the interpreter's lock, stop at Ctrl-C, and tell how far they are.
//!
//! Signals are the main thread's; its handlers run where it asks for them. On other threads the question is asked once a
//! call and never again, unless somebody wants to be told.

use crate::error::Error;
use crate::kernel::interrupt;
use pyo3::prelude::*;
use std::cell::{Cell, RefCell};

thread_local! {
    /// What a signal's handler raised during the call on this thread.
    static RAISED: RefCell<Option<PyErr>> = const { RefCell::new(None) };
    /// Whether this is the main thread, once that was asked in a call.
    static IS_MAIN: Cell<Option<bool>> = const { Cell::new(None) };
    /// Who is told how much of the call on this thread is done.
    static TELL: RefCell<Option<Py<PyAny>>> = const { RefCell::new(None) };
}

/// Runs work without the lock. What a signal's handler raises meanwhile ends it, and is the error.
pub fn stoppable<T: Send, E: Into<PyErr> + Send>(
    py: Python<'_>,
    work: impl FnOnce() -> Result<T, E> + Send,
) -> PyResult<T> {
    released(py, work)?.map_err(Into::into)
}

/// The same of work that cannot fail by itself.
pub fn released<T: Send>(py: Python<'_>, work: impl FnOnce() -> T + Send) -> PyResult<T> {
    // A forked child's only thread may have been any of its parent's.
    IS_MAIN.set(None);
    let result = py.detach(|| interrupt::stoppable(is_to_stop, work));
    result.map_err(|error| RAISED.take().unwrap_or_else(|| Error::into(error)))
}

/// Has calls on this thread call `tell` now and then with how much of them is done, from 0 to 1, or nobody with None. What it raises ends
/// a call.
#[pyfunction]
#[pyo3(signature = (tell, /))]
pub fn tell_progress(tell: Option<Py<PyAny>>) {
    TELL.set(tell);
}

fn is_to_stop(done: Option<f64>) -> bool {
    let done = done.filter(|_| TELL.with_borrow(Option::is_some));
    if IS_MAIN.get() == Some(false) && done.is_none() {
        return false;
    }
    Python::attach(|py| {
        // Whoever runs Python's code may meet the signal's handler, and what that raises.
        let raised = py.check_signals().and_then(|()| {
            if IS_MAIN.get().is_none() {
                IS_MAIN.set(Some(is_main(py)?));
            }
            if let Some(done) = done {
                // Whom it calls may call others: nothing is borrowed meanwhile.
                let tell = TELL.with_borrow(|tell| tell.as_ref().map(|tell| tell.clone_ref(py)));
                tell.map(|tell| tell.call1(py, (done,))).transpose()?;
            }
            Ok(())
        });
        match raised {
            Ok(()) => false,
            Err(raised) => {
                RAISED.set(Some(raised));
                true
            }
        }
    })
}

fn is_main(py: Python<'_>) -> PyResult<bool> {
    let threading = py.import("threading")?;
    let main = threading.call_method0("main_thread")?.getattr("ident")?;
    main.eq(threading.call_method0("get_ident")?)
}
