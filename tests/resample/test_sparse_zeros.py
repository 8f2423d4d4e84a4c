"""Arrays that take memory where they are written."""

import numpy as np
import pytest
from spheremap.resample import sparse

TERA = 1 << 40


def resident():
    with open("/proc/self/statm") as file:
        return int(file.read().split()[1]) * 4096


@pytest.mark.parametrize("anonymous", [True, False], ids=["pages", "file"])
def test_it_is_zeros_that_can_be_written(anonymous, monkeypatch):
    if not anonymous:
        monkeypatch.setattr(sparse, "_NORESERVE", None)
    array = sparse.sparse_zeros((5, 7, 3), np.float32)
    assert not array.any() and array.flags.c_contiguous and array.dtype == np.float32
    array[2:4] = 1
    assert array.sum() == 42


def test_of_nothing():
    assert sparse.sparse_zeros((0, 7), np.uint8).shape == (0, 7)


@pytest.mark.skipif(sparse._NORESERVE is None, reason="other systems write files")
def test_it_takes_the_memory_of_what_is_written():
    before = resident()
    array = sparse.sparse_zeros((1 << 20, 1 << 18), np.float32)
    assert array.nbytes == TERA
    array[1000:1256, 5000:5256] = 1
    # 256 rows of a KiB each, at most two pages of 4 KiB a row, and page tables of a page a row.
    assert resident() - before < 256 * 5 * 4096
    assert array[1255, 5255] == 1 and array[1256, 5255] == 0


def test_where_the_system_refuses_it_is_a_file(monkeypatch):
    def refused(*_, **__):
        raise OSError(12, "Cannot allocate memory")

    monkeypatch.setattr(sparse.mmap, "mmap", refused)
    assert sparse._anonymous(4096) is None
