"""Images with names, `da.sphere.convert("cube")`: `pip install spheremap[xarray]`.

Importing this module gives every `xarray.DataArray` the accessor `sphere`. `spheremap` itself never
imports xarray.
"""

try:
    import xarray as _xarray  # noqa: F401
except ImportError:
    raise ImportError(
        "`spheremap.xarray` needs xarray: pip install spheremap[xarray]", name="xarray"
    ) from None

from .accessor import Sphere

__all__ = ["Sphere"]


def __dir__() -> list[str]:
    return __all__
