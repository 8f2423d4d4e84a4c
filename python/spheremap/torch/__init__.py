"""The verbs on tensors of torch, with gradients: `pip install spheremap[torch]`.

On the CPU they are the kernels of this library, without a copy; elsewhere the code that
`spheremap.code` prints. `spheremap` itself never imports torch.
"""

try:
    import torch as _torch  # noqa: F401
except ImportError:
    raise ImportError(
        "`spheremap.torch` needs torch: pip install spheremap[torch]", name="torch"
    ) from None

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
