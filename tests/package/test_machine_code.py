"""Every kernel is packed arithmetic, at every level: read from the machine code of the module.

A formula that the compiler did not vectorize gives the right numbers, several times slower, and
nothing else tells. So the functions themselves are disassembled and their loops found in the graph
of their jumps. A backward jump is not enough: blocks that are taken once lie behind the loops and
jump back as well.
"""

from __future__ import annotations

import os
import re
from collections.abc import Iterator
from dataclasses import dataclass, replace
from functools import cache
from itertools import pairwise
from pathlib import Path

import pytest
from capstone import CS_ARCH_X86, CS_MODE_64, Cs
from elftools.elf.elffile import ELFFile
from spheremap import _core

# What walks over chunks calls the formula, by a pointer.
WALK = "11walk_chunks"

# A part of the symbol for each level, in legacy and in v0 mangling, and the registers it fills. A
# v0 symbol of the first two holds one of the others as well. Rare maps have no AVX-512.
BASELINES = ("kernel8dispatch", "9fill_rows", WALK)
LEVELS = {"vectorize_avx512": "zmm", "vectorize_avx2": "ymm", **dict.fromkeys(BASELINES, "xmm")}

SCALAR = re.compile(r"v?(add|sub|mul|div|sqrt)s[sd]")
PACKED = re.compile(r"v?(add|sub|mul|div|sqrt)p[sd]")

# The baseline's registers hold two doubles: there the compiler may as well pack what belongs to one
# point, like derivatives by u and by v, and leaves the rest of that point scalar. Singles are four.
FORBIDDEN = {"xmm": re.compile(SCALAR.pattern.replace("[sd]", "s"))}

# What a call prepares from its parameters, outside of every loop, is less than a loop over the
# points of a chunk that was unrolled whole would have of each: kernel::W.
POINTS = 64


@dataclass(frozen=True)
class Instruction:
    address: int
    size: int
    name: str
    operands: str

    def __str__(self) -> str:
        return f"{self.address:#x}: {self.name} {self.operands}"

    @property
    def target(self) -> int | None:
        """Where a direct jump goes."""
        return int(self.operands, 16) if self.operands.startswith("0x") else None


@dataclass(frozen=True)
class Kernel:
    level: str
    symbol: str
    address: int
    size: int
    walks: bool = False

    def __str__(self) -> str:
        return f"{self.level} kernel at {self.address:#x}, {self.symbol}"


def _unsuited(path: Path) -> str | None:
    with path.open("rb") as file:
        if file.read(4) != b"\x7fELF":
            return f"{path.name} is not an ELF file"
        machine = ELFFile(file).get_machine_arch()
        return None if machine == "x64" else f"{path.name} is for {machine}, not x86-64"


MODULE = Path(_core.__file__)
if WHY := _unsuited(MODULE):
    pytest.skip(WHY, allow_module_level=True)


@cache
def _module() -> tuple[list[Kernel], int, bytes]:
    """Give the kernels, and the address and bytes of the code."""
    with MODULE.open("rb") as file:
        elf = ELFFile(file)
        symbols, text = elf.get_section_by_name(".symtab"), elf.get_section_by_name(".text")
        start, code = text["sh_addr"], text.data()
        functions = {}
        for symbol in symbols.iter_symbols() if symbols else ():
            if symbol["st_info"]["type"] == "STT_FUNC" and symbol["st_size"]:
                level = next((level for level in LEVELS if level in symbol.name), None)
                if level is not None:
                    address, size = symbol["st_value"], symbol["st_size"]
                    functions[address] = Kernel(level, symbol.name, address, size)
        # Lookups are compiled for each level as well, and gather one texel after the other. Kernels
        # are what `dispatch`, `fill_rows` and `walk_chunks` call, and themselves: the baseline.
        kernels = {}
        for kernel in functions.values():
            if kernel.level in BASELINES:
                first = kernel.address - start
                body = code[first : first + kernel.size]
                decoded = Cs(CS_ARCH_X86, CS_MODE_64).disasm_lite(body, kernel.address)
                called = [op for _, _, name, op in decoded if name in {"call", "jmp"}]
                targets = {int(op, 16) for op in called if op.startswith("0x")}
                wide = [functions[address] for address in targets & functions.keys()]
                for each in (kernel, *wide):
                    kernels[each.address] = replace(each, walks=kernel.level == WALK)
        return list(kernels.values()), start, code


STRIPPED = f"{MODULE.name} has no symbols of its kernels: it was stripped"


def _parameters() -> list[object]:
    kernels = _module()[0]
    if not kernels:
        return [pytest.param(None, id="none", marks=pytest.mark.skip(reason=STRIPPED))]
    return [pytest.param(k, id=f"{k.level}-{k.address:#x}") for k in kernels]


each_kernel = pytest.mark.parametrize("kernel", _parameters())


class Code:
    """A function, disassembled."""

    def __init__(self, kernel: Kernel) -> None:
        _, start, text = _module()
        self.kernel = kernel
        first, size = kernel.address, kernel.size
        code = text[first - start : first - start + size]
        decoded = Cs(CS_ARCH_X86, CS_MODE_64).disasm_lite(code, first)
        self.instructions = [Instruction(*fields) for fields in decoded]
        assert sum(i.size for i in self.instructions) == size, f"{kernel}: not all of it decodes"
        self.blocks = self._blocks()
        self.loops = list(_loops(self._successors()))
        looped = {block for loop in self.loops for block in loop}
        self.in_loops = [i for b in sorted(looped) for i in self.blocks[b]]
        self.elsewhere = [i for b in sorted(self.blocks.keys() - looped) for i in self.blocks[b]]

    def computes(self) -> bool:
        return any(PACKED.match(i.name) or SCALAR.match(i.name) for i in self.instructions)

    def _blocks(self) -> dict[int, list[Instruction]]:
        ends = {"ret", "ud2"}
        starts = {self.kernel.address}
        for i in self.instructions:
            if i.name[0] == "j":
                # A table of targets would hide loops.
                assert i.target is not None or "rip" in i.operands, f"{self.kernel}: {i}"
                starts.add(i.target or 0)
            if i.name[0] == "j" or i.name in ends:
                starts.add(i.address + i.size)
        begins = [n for n, i in enumerate(self.instructions) if i.address in starts]
        borders = pairwise([*begins, len(self.instructions)])
        return {self.instructions[a].address: self.instructions[a:b] for a, b in borders}

    def _successors(self) -> dict[int, set[int]]:
        successors = {}
        for block, instructions in self.blocks.items():
            last = instructions[-1]
            after = set()
            if last.name[0] == "j":
                after.add(last.target)
            if last.name not in {"jmp", "ret", "ud2"}:
                after.add(last.address + last.size)
            successors[block] = after & self.blocks.keys()
        return successors


def _loops(successors: dict[int, set[int]]) -> Iterator[set[int]]:
    """Find the outermost loops: the blocks from which some way leads back to themselves."""
    order: dict[int, int] = {}
    low: dict[int, int] = {}
    stack: list[int] = []
    # Tarjan's strongly connected components, without recursion.
    for root in successors:
        path = [] if root in order else [(root, iter(successors[root]))]
        while path:
            block, rest = path[-1]
            if block not in order:
                order[block] = low[block] = len(order)
                stack.append(block)
            for after in rest:
                if after not in order:
                    path.append((after, iter(successors[after])))
                    break
                if after in stack:
                    low[block] = min(low[block], order[after])
            else:
                path.pop()
                if path:
                    low[path[-1][0]] = min(low[path[-1][0]], low[block])
                if low[block] == order[block]:
                    at = stack.index(block)
                    loop = set(stack[at:])
                    del stack[at:]
                    if len(loop) > 1 or block in successors[block]:
                        yield loop


@cache
def _code(kernel: Kernel) -> Code:
    return Code(kernel)


def _list(instructions: list[Instruction]) -> str:
    return f"{len(instructions)} instructions\n  " + "\n  ".join(map(str, instructions))


def test_kernels_are_found_at_every_level():
    kernels = _module()[0]
    if not kernels:
        assert not os.environ.get("CI"), STRIPPED
        pytest.skip(STRIPPED)
    assert {kernel.level for kernel in kernels} == set(LEVELS)
    # What is left to a function that calls for each point computes nothing.
    codes = [code for code in map(_code, kernels) if code.computes()]
    assert len(codes) > 0.8 * len(kernels)
    # Few of the loops over the points of a chunk are short enough to be unrolled whole.
    assert sum(bool(code.loops) for code in codes) > 0.9 * len(codes)


def test_operations_of_lanes_are_no_calls():
    with MODULE.open("rb") as file:
        symbols = ELFFile(file).get_section_by_name(".symtab")
        names = [symbol.name for symbol in symbols.iter_symbols()] if symbols else []
    if not any("vectorize_avx2" in name for name in names):
        assert not os.environ.get("CI"), STRIPPED
        pytest.skip(STRIPPED)
    # A closure among lanes that is not inlined is compiled for the baseline, and calls these for
    # every sum and product. Nothing else keeps one in the module.
    assert not [name for name in names if "__fearless_simd_kernel" in name]


@each_kernel
def test_no_scalar_arithmetic(kernel):
    code = _code(kernel)
    pattern = FORBIDDEN.get(LEVELS[kernel.level], SCALAR)
    scalar = [i for i in code.in_loops if pattern.fullmatch(i.name)]
    assert not scalar, f"{kernel}: in a loop {_list(scalar)}"
    scalar = [i for i in code.elsewhere if SCALAR.fullmatch(i.name)]
    assert len(scalar) < POINTS, f"{kernel}: an unrolled loop? {_list(scalar)}"


@each_kernel
def test_packed_arithmetic_fills_its_registers(kernel):
    code = _code(kernel)
    width = LEVELS[kernel.level]
    packed = [i for i in code.in_loops or code.elsewhere if PACKED.fullmatch(i.name)]
    # Whole numbers are only counted, and a constant density takes no arithmetic at all.
    if packed or any(SCALAR.fullmatch(i.name) for i in code.in_loops):
        assert any(width in i.operands for i in packed), f"{kernel}: nothing packed in {width}"
    narrow = [i for i in code.in_loops if PACKED.fullmatch(i.name) and width not in i.operands]
    assert not narrow, f"{kernel}: in a loop, narrow {_list(narrow)}"


@each_kernel
def test_no_calls_in_loops(kernel):
    calls = [i for i in _code(kernel).in_loops if i.name == "call"]
    if kernel.walks:
        calls = [i for i in calls if i.target is not None or "rip" in i.operands]
    assert not calls, f"{kernel}: in a loop {_list(calls)}"
