//! The table of filters: one line each.
//!
//! The macro makes the enum of all filters, one for each method, and the static dispatch. A new separable filter is
//! one file with its claims and its kernel, and one line here; names, the command line's choices, types
//! for editors, the table in the documentation and the tests iterate the table.

pub mod claims;
#[cfg(test)]
mod tests;

use crate::error::Error;
use claims::{Claims, FilterInfo, Lookup, Visitor};

macro_rules! filters {
    (
        lookup { $($lookup_file:ident::$lookup:ident),+ $(,)? }
        mipmapped { $($mipmapped_file:ident::$mipmapped:ident),+ $(,)? }
        area { $($area_file:ident::$area:ident),+ $(,)? }
    ) => {
        $(mod $lookup_file;)+
        $(mod $mipmapped_file;)+
        $(mod $area_file;)+

        /// Any filter of the table.
        #[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
        #[non_exhaustive]
        pub enum Filter {
            $(#[doc = concat!("Its row is in `filters::", stringify!($lookup_file), "`.")] $lookup,)+
            $(#[doc = concat!("Its row is in `filters::", stringify!($mipmapped_file), "`.")] $mipmapped,)+
            $(#[doc = concat!("Its row is in `filters::", stringify!($area_file), "`.")] $area,)+
        }

        /// A filter that weights the texels around a place.
        #[derive(Clone, Copy, Debug, PartialEq, Eq)]
        #[non_exhaustive]
        pub(crate) enum LookupFilter {
            $(#[doc = concat!("`", stringify!($lookup_file), "`")] $lookup,)+
        }

        /// A filter that looks a footprint up in a mip chain.
        #[derive(Clone, Copy, Debug, PartialEq, Eq)]
        pub(crate) enum MipmappedFilter {
            $(#[doc = concat!("`", stringify!($mipmapped_file), "`")] $mipmapped,)+
        }

        /// A filter that takes all that a texel covers.
        #[derive(Clone, Copy, Debug, PartialEq, Eq)]
        pub(crate) enum AreaFilter {
            $(#[doc = concat!("`", stringify!($area_file), "`")] $area,)+
        }

        /// A filter, by its method.
        #[derive(Clone, Copy, Debug, PartialEq, Eq)]
        pub(crate) enum ByMethod {
            /// It weights the texels around a place.
            Lookup(LookupFilter),
            /// It looks a footprint up in a mip chain.
            Mipmapped(MipmappedFilter),
            /// It takes all that a texel covers.
            Area(AreaFilter),
        }

        impl Filter {
            /// All filters, in the order of the table.
            pub const ALL: &[Filter] = &[
                $(Filter::$lookup,)+
                $(Filter::$mipmapped,)+
                $(Filter::$area,)+
            ];

            /// The claims of all filters, in the order of the table.
            pub const TABLE: &[FilterInfo] = &[
                $($lookup_file::$lookup::INFO,)+
                $($mipmapped_file::$mipmapped::INFO,)+
                $($area_file::$area::INFO,)+
            ];

            /// It, by its method.
            pub(crate) fn by_method(self) -> ByMethod {
                match self {
                    $(Filter::$lookup => ByMethod::Lookup(LookupFilter::$lookup),)+
                    $(Filter::$mipmapped => ByMethod::Mipmapped(MipmappedFilter::$mipmapped),)+
                    $(Filter::$area => ByMethod::Area(AreaFilter::$area),)+
                }
            }
        }

        impl LookupFilter {
            /// Calls the visitor's method for it.
            #[inline(always)]
            pub(crate) fn visit<V: Visitor>(self, visitor: V) -> V::Output {
                match self {
                    $(LookupFilter::$lookup => $lookup_file::$lookup::visit(visitor),)+
                }
            }
        }
    };
}

filters! {
    lookup {
        nearest::Nearest,
        bilinear::Bilinear,
        catmull_rom::CatmullRom,
        mitchell::Mitchell,
        lanczos3::Lanczos3,
        gaussian::Gaussian,
    }
    mipmapped {
        trilinear::Trilinear,
        ewa::Ewa,
    }
    area {
        area::Area,
        mode::Mode,
    }
}

impl Filter {
    /// Its claims.
    ///
    /// ```
    /// use spheremap::resample::Filter;
    ///
    /// assert!(Filter::CatmullRom.info().interpolates);
    /// assert_eq!(Filter::Lanczos3.info().support, Some(3.0));
    /// ```
    pub fn info(self) -> &'static FilterInfo {
        &Self::TABLE[self as usize]
    }

    /// The filter of this name.
    ///
    /// # Errors
    /// For a name that no filter has; it says which is near.
    ///
    /// ```
    /// use spheremap::resample::Filter;
    ///
    /// assert_eq!(Filter::find("bicubic"), Filter::find("catmull-rom"));
    /// assert!(Filter::find("lanczos").unwrap_err().to_string().contains("'lanczos3'"));
    /// ```
    pub fn find(name: &str) -> Result<Filter, Error> {
        let has = |filter: &Filter| filter.names().any(|own| own == name);
        let found = Self::ALL.iter().copied().find(has);
        found.ok_or_else(|| Error::unknown("filter", name, &Self::all_names(|_| true)))
    }

    /// It as a filter that weights the texels around a place.
    ///
    /// # Errors
    /// For a filter of another method.
    pub(crate) fn lookup(self) -> Result<LookupFilter, Error> {
        match self.by_method() {
            ByMethod::Lookup(filter) => Ok(filter),
            _ => {
                let looks_up = |filter: Filter| matches!(filter.by_method(), ByMethod::Lookup(_));
                Err(Error::Contradiction(format!(
                    "filter '{}' makes texels of an image and looks no direction up; those that do are {}",
                    self.info().name,
                    Self::all_names(looks_up).join(", ")
                )))
            }
        }
    }

    /// It as a filter of lookups that do not say how much of an image they see.
    ///
    /// # Errors
    /// For a filter of another method.
    pub(crate) fn of_points(self) -> Result<LookupFilter, Error> {
        match self.by_method() {
            ByMethod::Mipmapped(_) => Err(Error::Contradiction(format!(
                "filter '{}' has to know how much a lookup sees: a `lod` or `derivatives`",
                self.info().name
            ))),
            _ => self.lookup(),
        }
    }

    /// It as a filter of lookups that do.
    ///
    /// # Errors
    /// For a filter of another method.
    pub(crate) fn of_footprints(self) -> Result<MipmappedFilter, Error> {
        match self.by_method() {
            ByMethod::Mipmapped(filter) => Ok(filter),
            _ => Err(Error::Contradiction(format!(
                "filter '{}' knows no levels: `lod` and `derivatives` are for filters 'trilinear' and 'ewa'",
                self.info().name
            ))),
        }
    }

    /// Its name and its other names.
    fn names(self) -> impl Iterator<Item = &'static str> {
        let info = self.info();
        std::iter::once(info.name).chain(info.also.iter().copied())
    }

    fn all_names(wanted: impl Fn(Filter) -> bool) -> Vec<&'static str> {
        let wanted = Self::ALL.iter().filter(|filter| wanted(**filter));
        wanted.flat_map(|filter| filter.names()).collect()
    }
}
