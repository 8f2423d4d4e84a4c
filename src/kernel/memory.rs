//! Asks for memory before it is taken, where a caller decides how much.
//!
//! An allocation that fails ends a Rust program, and with it the interpreter that runs it. So whoever is about to make
//! vectors as large as an image asks for their room first: it is reserved and given back, and where that fails, an error
//! takes the place of the end. Nothing is written, so that asking costs a few microseconds; vectors of zeros, which systems give away
//! without writing, stay as cheap as they are. Two threads that both ask and then both take may still fall short.

use crate::error::Error;

/// What nobody asks for.
const SMALL: usize = 1 << 20;

/// Whether there is room for `count` items of a type.
///
/// # Errors
/// There is not.
pub fn expect_room<T>(count: usize) -> Result<(), Error> {
    let bytes = count.checked_mul(size_of::<T>());
    if bytes.is_some_and(|bytes| bytes <= SMALL) {
        return Ok(());
    }
    let mut room = Vec::<T>::new();
    let reserved = room.try_reserve_exact(count);
    // Without this the compiler sees that nothing uses the room, and takes none.
    std::hint::black_box(&mut room);
    reserved.map_err(|_| Error::Memory {
        bytes: bytes.unwrap_or(usize::MAX),
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn there_is_no_room_for_everything() {
        assert_eq!(expect_room::<f64>(0), Ok(()));
        assert_eq!(expect_room::<f64>(1 << 20), Ok(()));
        for count in [usize::MAX, usize::MAX / 8, 1 << 58] {
            let error = expect_room::<f64>(count).unwrap_err();
            assert!(error.to_string().contains("memory"), "{error}");
        }
    }
}
