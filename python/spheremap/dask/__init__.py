"""The verbs of images on arrays in chunks: `pip install spheremap[dask]`.

Each chunk of a result is a task that depends on those chunks of its source that it sees, and on no
others. `spheremap` itself never imports dask.
"""

try:
    import dask.array as _array  # noqa: F401
except ImportError:
    raise ImportError(
        "`spheremap.dask` needs dask: pip install spheremap[dask]", name="dask"
    ) from None

from . import light, sh
from .images import convert
from .lookups import sample

__all__ = ["convert", "light", "sample", "sh"]


def __dir__() -> list[str]:
    return __all__
