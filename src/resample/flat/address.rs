//! What lies beyond the edges of a picture: the address modes of graphics APIs.

use crate::error::Error;

/// What lies beyond an edge.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Address {
    /// The texel at the edge (`CLAMP`, `CLAMP_TO_EDGE`).
    Clamp,
    /// The picture again (`WRAP`, `REPEAT`).
    Wrap,
    /// The picture mirrored, and so on (`MIRROR`, `MIRRORED_REPEAT`).
    Mirror,
    /// A color (`BORDER`, `CLAMP_TO_BORDER`).
    Border,
}

impl Address {
    const ALL: [(&'static str, Address); 4] = [
        ("clamp", Address::Clamp),
        ("wrap", Address::Wrap),
        ("mirror", Address::Mirror),
        ("border", Address::Border),
    ];

    /// The mode of this name.
    ///
    /// # Errors
    /// For a name that no mode has.
    ///
    /// ```
    /// use spheremap::resample::flat::Address;
    ///
    /// assert_eq!(Address::find("wrap"), Ok(Address::Wrap));
    /// assert!(Address::find("warp").is_err());
    /// ```
    pub fn find(name: &str) -> Result<Address, Error> {
        let mut all = Self::ALL.iter();
        let found = all.find(|(own, _)| *own == name);
        found
            .map(|(_, mode)| *mode)
            .ok_or_else(|| Error::unknown("address", name, &Self::ALL.map(|(name, _)| name)))
    }

    /// Which of `n` texels stands for number `i`; none where the border does.
    pub(crate) fn texel(self, i: isize, n: usize) -> Option<usize> {
        let count = n as isize;
        match self {
            Address::Clamp => Some(i.clamp(0, count - 1) as usize),
            Address::Wrap => Some(i.rem_euclid(count) as usize),
            Address::Mirror => {
                let i = i.rem_euclid(2 * count);
                Some(i.min(2 * count - 1 - i) as usize)
            }
            Address::Border => usize::try_from(i).ok().filter(|i| *i < n),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::Address;

    #[test]
    fn modes_are_those_of_the_specification() {
        let of = |mode: Address| (-4..8).map(|i| mode.texel(i, 3)).collect::<Vec<_>>();
        let some = |all: [usize; 12]| all.map(Some).to_vec();
        assert_eq!(
            of(Address::Clamp),
            some([0, 0, 0, 0, 0, 1, 2, 2, 2, 2, 2, 2])
        );
        assert_eq!(
            of(Address::Wrap),
            some([2, 0, 1, 2, 0, 1, 2, 0, 1, 2, 0, 1])
        );
        assert_eq!(
            of(Address::Mirror),
            some([2, 2, 1, 0, 0, 1, 2, 2, 1, 0, 0, 1])
        );
        assert_eq!(
            of(Address::Border)[3..8],
            [None, Some(0), Some(1), Some(2), None]
        );
    }
}
