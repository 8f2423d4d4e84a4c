//! What is asked for beside the map and the language.

use crate::code::verb::Verb;

/// What is asked for beside the map and the language.
#[derive(Clone, Copy, Debug)]
#[non_exhaustive]
pub struct CodeOptions<'a> {
    /// The functions, in this order.
    pub verbs: &'a [Verb],
    /// What names begin with; the projection's name where nothing is said.
    pub name: Option<&'a str>,
    /// The language's own sine, arctangent and so on, rather than the library's polynomials.
    pub native: bool,
    /// Numbers of 64 bits.
    pub double: bool,
}

impl Default for CodeOptions<'_> {
    fn default() -> Self {
        CodeOptions {
            verbs: &[Verb::Encode, Verb::Decode],
            name: None,
            native: false,
            double: false,
        }
    }
}

impl<'a> CodeOptions<'a> {
    /// `encode` and `decode` in 32 bits, with the library's polynomials.
    ///
    /// ```
    /// use spheremap::code::{CodeOptions, Verb};
    /// assert_eq!(CodeOptions::new().verbs, [Verb::Encode, Verb::Decode]);
    /// ```
    pub fn new() -> Self {
        CodeOptions::default()
    }

    /// With these verbs.
    ///
    /// ```
    /// use spheremap::Map;
    /// use spheremap::code::{CodeOptions, Verb, code};
    /// let text = code(&Map::new("octahedral")?, "hlsl", &CodeOptions::new().verbs(&[Verb::Decode]))?;
    /// assert!(text.contains("float3 octahedral_decode(") && !text.contains("octahedral_encode("));
    /// # Ok::<(), spheremap::Error>(())
    /// ```
    #[must_use]
    pub fn verbs(self, verbs: &'a [Verb]) -> Self {
        CodeOptions { verbs, ..self }
    }

    /// With names that begin so.
    ///
    /// ```
    /// use spheremap::Map;
    /// use spheremap::code::{CodeOptions, code};
    /// let text = code(&Map::new("octahedral")?, "glsl", &CodeOptions::new().name("normal"))?;
    /// assert!(text.contains("vec2 normal_encode("));
    /// # Ok::<(), spheremap::Error>(())
    /// ```
    #[must_use]
    pub fn name(self, name: &'a str) -> Self {
        CodeOptions {
            name: Some(name),
            ..self
        }
    }

    /// With the language's own functions, or not.
    ///
    /// ```
    /// use spheremap::Map;
    /// use spheremap::code::{CodeOptions, code};
    /// let latlong = Map::new("latlong")?;
    /// let own = code(&latlong, "c", &CodeOptions::new().native(true))?;
    /// let ours = code(&latlong, "c", &CodeOptions::new())?;
    /// assert!(own.contains("atan2f(") && !ours.contains("atan2f("));
    /// # Ok::<(), spheremap::Error>(())
    /// ```
    #[must_use]
    pub fn native(self, native: bool) -> Self {
        CodeOptions { native, ..self }
    }

    /// In 64 bits, or 32.
    ///
    /// ```
    /// use spheremap::Map;
    /// use spheremap::code::{CodeOptions, code};
    /// let octahedral = Map::new("octahedral")?;
    /// let text = code(&octahedral, "c", &CodeOptions::new().double(true))?;
    /// assert!(text.contains("double"));
    /// assert!(code(&octahedral, "wgsl", &CodeOptions::new().double(true)).is_err());
    /// # Ok::<(), spheremap::Error>(())
    /// ```
    #[must_use]
    pub fn double(self, double: bool) -> Self {
        CodeOptions { double, ..self }
    }
}
