"""The verbs on arrays of JAX, under `jit`, `grad`, `vmap` and `pmap`: `pip install spheremap[jax]`.

Maps are the code that `spheremap.code` prints; what adds texels up is gathers, or the kernels of
this library with their exact adjoints. `spheremap` itself never imports jax.
"""

try:
    import jax as _jax  # noqa: F401
except ImportError:
    raise ImportError("`spheremap.jax` needs jax: pip install spheremap[jax]", name="jax") from None

from . import light, packing, sh
from .images import convert, integrate, pad, sample
from .maps import decode, density, directions, encode, jacobian, projection, reflect

__all__ = [
    "convert",
    "decode",
    "density",
    "directions",
    "encode",
    "integrate",
    "jacobian",
    "light",
    "packing",
    "pad",
    "projection",
    "reflect",
    "sample",
    "sh",
]


def __dir__() -> list[str]:
    return __all__
