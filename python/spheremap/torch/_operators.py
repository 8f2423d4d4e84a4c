"""How a call of the library becomes an operator of torch, with all its derivatives.

`torch.library.custom_op` knows no forward derivatives: under `torch.func.jvp` such an operator says
nothing and has a tangent of zero. So the rules are put where autograd itself looks for them, for
one level at a time: for `backward`, `torch.func`, `torch.compile` and `torch.export` alike.
"""

from __future__ import annotations

import functools
from collections.abc import Callable
from typing import TYPE_CHECKING, Any

import torch
from torch._functorch.autograd_function import enable_single_level_autograd_function
from torch.autograd import forward_ad

if TYPE_CHECKING:
    from torch import Tensor

_library = torch.library.Library("spheremap", "DEF")

# Whose tensors the kernels share the memory of.
_KERNELS_ON = "cpu"

# What the compiler puts in the place of operators.
_written: dict[Any, Callable[..., Any]] = {}


def has_kernel(tensor: Tensor) -> bool:
    """Tell whether the kernels of the library take a tensor."""
    kind: str = tensor.device.type
    return kind == _KERNELS_ON


@functools.cache
def _tell_the_compiler() -> None:
    """Let torch's compiler write operators out: it fuses what it sees, and an operator it does not.

    This is done when something is compiled, since the compiler takes a second to import.
    """
    from torch._inductor import decomposition, lowering

    for operator in _written:
        # What stays an operator on the CPU is called as one; the compiler itself would add that
        # where it meets one, and takes none that may be written out.
        lowering.make_fallback(operator, warn=False)
    decomposition.decompositions.update(_written)
    # A copy that torch holds from a compilation before this one.
    decomposition.fast_random_decomps.cache_clear()


def define(
    schema: str,
    *,
    kernel: Callable[..., Tensor],
    fake: Callable[..., Tensor],
    batched: Callable[..., tuple[Tensor, int]],
    written: Callable[..., Tensor] | None = None,
    reverse: Callable[..., tuple[Tensor | None, ...]] | None = None,
    forward: Callable[..., Tensor] | None = None,
    none: str | None = None,
) -> Callable[..., Tensor]:
    """Define an operator and return it.

    Parameters
    ----------
    schema : str
        Its name and arguments: tensors first, plain values after them.
    kernel : callable
        What computes it.
    fake : callable
        Returns an empty tensor of the result's shape and dtype.
    batched : callable
        Takes `in_dims` and the arguments, one of which has an axis more; returns the result, and
        where its axis is.
    written : callable, optional
        Does by operations of torch what `kernel` does where there are no kernels. The compiler
        fuses it there with what stands around it.
    reverse : callable, optional
        Takes which tensors want a gradient, the arguments, the result and its gradient; returns
        one of each tensor. It is made of what has derivatives, where there are second ones.
    forward : callable, optional
        Takes the arguments, the result and the tangents (or None) of the tensors.
    none : str, optional
        What is said where one of the last two is missing and asked for: an error.
    """
    name = schema.partition("(")[0]
    _library.define(schema)
    _library.impl(name, kernel, "CompositeExplicitAutograd")
    operator: Any = getattr(torch.ops.spheremap, name).default

    def empty(*given: Any) -> Tensor:
        _tell_the_compiler()
        return fake(*given)

    torch.library.register_fake(f"spheremap::{name}", empty, lib=_library)
    if written is not None:

        def in_place(*given: Any) -> Any:
            return NotImplemented if has_kernel(given[0]) else written(*given)

        _written[operator] = in_place

    def vmap(info: Any, in_dims: tuple[int | None, ...], *given: Any) -> tuple[Tensor, int]:
        return batched(in_dims, *given)

    torch.library.register_vmap(f"spheremap::{name}", vmap, lib=_library)
    arguments = operator._schema.arguments
    tensors = sum(str(one.type) == "Tensor" for one in arguments)
    values = len(arguments) - tensors

    class Rules(torch.autograd.function._SingleLevelFunction):  # type: ignore[misc]
        @staticmethod
        def forward(ctx: Any, *given: Any) -> Any:
            with torch._C._AutoDispatchBelowAutograd():
                result = operator(*given)
            ctx.save_for_backward(*given[:tensors], result)
            ctx.save_for_forward(*given[:tensors], result)
            ctx.values = given[tensors:]
            # No tangent is None, and not a zero that would ask for a derivative.
            ctx.set_materialize_grads(False)
            return result

        @staticmethod
        def backward(ctx: Any, *gradients: Any) -> Any:
            if reverse is None:
                raise NotImplementedError(none)
            if gradients[0] is None:
                return (None,) * (tensors + values)
            *given, result = ctx.saved_tensors
            wanted = ctx.needs_input_grad[:tensors]
            found = reverse(wanted, *given, *ctx.values, result, gradients[0])
            return (*found, *(None for _ in range(values)))

        @staticmethod
        def jvp(ctx: Any, *tangents: Any) -> Any:
            if forward is None:
                raise NotImplementedError(none)
            *given, result = ctx.saved_tensors
            return forward(*given, *ctx.values, result, *tangents[:tensors])

    def differentiable(*given: Any) -> Any:
        # Most calls have nothing to derive by: the rules would cost as much again as the call.
        is_plain = forward_ad._current_level < 0
        if is_plain and not any(tensor.requires_grad for tensor in given[:tensors]):
            with torch._C._AutoDispatchBelowAutograd():
                return operator(*given)
        with enable_single_level_autograd_function():
            return Rules.apply(*given)

    _library.impl(name, differentiable, "Autograd")
    found: Callable[..., Tensor] = operator
    return found


def alike(in_dims: tuple[int | None, ...], *given: Tensor) -> list[Tensor]:
    """Return tensors with the axis that a rule of `vmap` is of first, those that have none too."""
    pairs = list(zip(given, in_dims, strict=False))
    count = next(t.shape[k] for t, k in pairs if isinstance(k, int))
    return [t.expand(count, *t.shape) if k is None else t.movedim(k, 0) for t, k in pairs]


def is_compiled() -> bool:
    """Tell whether torch's compiler looks at a call, whose numbers are not known to it."""
    found: bool = torch.compiler.is_compiling()
    return found


def is_hidden(tensor: Tensor) -> bool:
    """Tell whether the numbers of a tensor are not known: within `vmap` or the compiler."""
    return is_compiled() or _has_level(tensor, torch._C._functorch.is_batchedtensor)


def is_moving(tensor: Tensor) -> bool:
    """Tell whether what is made of a tensor must follow it.

    It must where a derivative is asked for, reverse or forward, and where its numbers are not
    known.
    """
    if is_hidden(tensor) or (torch.is_grad_enabled() and tensor.requires_grad):
        return True
    # A level of `torch.func` has its derivatives in a tensor about this one.
    if _has_level(tensor, torch._C._functorch.is_gradtrackingtensor):
        return True
    return forward_ad._current_level >= 0 and forward_ad.unpack_dual(tensor).tangent is not None


def _has_level(tensor: Tensor, kind: Callable[[Tensor], bool]) -> bool:
    """Tell whether one of the levels of `torch.func` about a tensor is of a kind."""
    functorch = torch._C._functorch
    while functorch.is_functorch_wrapped_tensor(tensor):
        if kind(tensor):
            return True
        tensor = functorch.get_unwrapped(tensor)
    return False


def product(a: Tensor, b: Tensor) -> Tensor:
    """Return a matrix product in the width of what is multiplied, whatever autocast says."""
    kind = a.device.type
    if not torch.is_autocast_enabled(kind):
        return a @ b
    with torch.autocast(kind, enabled=False):
        return a @ b


def power_of_two(vectors: Tensor) -> Tensor:
    """Return what brings the largest number of each vector near 1, (..., 1), by a division.

    Squares of the largest and the smallest have no width. A power of two rounds nothing; it is a
    constant to derivatives.
    """
    largest = vectors.detach().abs().amax(-1, keepdim=True)
    usable = largest.isfinite() & (largest > 0)
    known = torch.where(usable, largest, 1.0)
    return known / (2 * torch.frexp(known).mantissa)


def in_float(tensor: Tensor, name: str) -> Tensor:
    """Return a tensor in the width that it is computed in: half floats in float32."""
    if not isinstance(tensor, torch.Tensor):
        raise TypeError(f"Expected `{name}` to be a tensor, got {type(tensor).__name__}.")
    if tensor.dtype in (torch.float16, torch.bfloat16):
        return tensor.float()
    if tensor.dtype not in (torch.float32, torch.float64):
        raise TypeError(f"Expected `{name}` to be of floats, got {tensor.dtype}.")
    return tensor
