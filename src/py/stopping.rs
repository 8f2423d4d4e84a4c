//! Calls run without the interpreter's lock, and stop at Ctrl-C.
//!
//! Signals are the main thread's; its handlers run where it asks for them. On other threads the question is asked once a
//! call and never again.

use crate::error::Error;
use crate::kernel::interrupt;
use pyo3::prelude::*;
use std::cell::{Cell, RefCell};

thread_local! {
    /// What a signal's handler raised during the call on this thread.
    static RAISED: RefCell<Option<PyErr>> = const { RefCell::new(None) };
    /// Whether this is the main thread, once that was asked in a call.
    static IS_MAIN: Cell<Option<bool>> = const { Cell::new(None) };
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

fn is_to_stop() -> bool {
    if IS_MAIN.get() == Some(false) {
        return false;
    }
    Python::attach(|py| {
        // Whoever runs Python's code may meet the signal's handler, and what that raises.
        let raised = py.check_signals().and_then(|()| {
            if IS_MAIN.get().is_none() {
                IS_MAIN.set(Some(is_main(py)?));
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
