"""What the session needs of its process: code under test may take it away, and it is put back after each run.

What is replaced by something that can be called stays: libraries do that, and `self_check` asks whether it answers
rightly. What is deleted, or replaced by what nobody can call, would end pytest itself.
"""

from __future__ import annotations

import builtins
import contextlib
import datetime
import errno
import functools
import hashlib
import importlib
import inspect
import io
import json
import linecache
import math
import os
import pathlib
import pickle
import re
import select
import shutil
import signal
import stat
import struct
import subprocess
import sys
import tempfile
import threading
import time
import traceback
import types
import warnings
import weakref
import zlib
from collections.abc import Iterator, Mapping
from typing import Any

import greenlet
import msgspec
import pytest

try:
    import resource
except ImportError:
    resource = None  # type: ignore[assignment]  # not on Windows

# As they are now: what is put back is looked at with them.
_CALLABLE, _SETATTR, _DICT, _HASATTR = callable, setattr, dict, hasattr
_LIMIT, _SET_LIMIT = sys.getrecursionlimit, sys.setrecursionlimit
_MODULES = sys.modules
_MODULE = types.ModuleType

_KEPT: Mapping[str, types.ModuleType | type] = {
    module.__name__: module
    for module in (
        *(builtins, contextlib, datetime, errno, functools, hashlib, importlib, inspect, io, json, linecache, math, os),
        *(os.path, pathlib, pickle, re, select, shutil, signal, stat, struct, subprocess, sys, tempfile, threading),
        *(time, traceback, types, warnings, weakref, zlib, greenlet, msgspec, msgspec.json, pytest),
    )
} | {"pathlib.Path": pathlib.Path, "pathlib.PurePath": pathlib.PurePath}

_OWN = sys.stdlib_module_names | {
    "_pytest",
    "coverage",
    "execnet",
    "greenlet",
    "jinja2",
    "lark",
    "markupsafe",
    "msgspec",
}
_OWN |= {"pluggy", "pytest", "pytest_hricdv", "xdist"}
"""Packages whose modules the session imports itself; others may be taken out of `sys.modules`, to import them again."""

_LIMITS = ("RLIMIT_NOFILE", "RLIMIT_FSIZE", "RLIMIT_AS", "RLIMIT_DATA", "RLIMIT_NPROC", "RLIMIT_STACK")


class ProcessState:
    """What the process is like when this is made."""

    def __init__(self) -> None:
        self._names = {name: _DICT(kept.__dict__) for name, kept in _KEPT.items()}
        self._modules = _DICT(_MODULES)
        self._recursion_limit = sys.getrecursionlimit()
        self._is_main = threading.current_thread() is threading.main_thread()
        self._children = signal.getsignal(signal.SIGCHLD) if _HASATTR(signal, "SIGCHLD") else None
        self._mask = signal.pthread_sigmask(signal.SIG_BLOCK, ()) if _HASATTR(signal, "pthread_sigmask") else None
        self._folder = _folder()
        searched: tuple[list[Any], ...] = (sys.path, sys.meta_path, sys.path_hooks)
        self._finders = [(finders, [*finders]) for finders in searched]
        self._limits = {} if resource is None else {name: _limit(name) for name in _LIMITS if _HASATTR(resource, name)}

    def put_back(self) -> tuple[str, ...]:
        """Put back what is missing; the names of what nobody could have called, and of modules that were taken out."""
        if _LIMIT() < self._recursion_limit:  # first: all that follows needs a deeper stack
            _SET_LIMIT(self._recursion_limit)
        lost = [*self._put_back_names(), *self._put_back_modules()]
        if self._is_main and self._children is not None:
            signal.signal(signal.SIGCHLD, self._children)
        if self._mask is not None:
            signal.pthread_sigmask(signal.SIG_SETMASK, self._mask)
        if self._folder and not _folder():
            with contextlib.suppress(OSError):
                os.chdir(self._folder)
        for finders, kept in self._finders:
            finders[:] = finders or kept
        for name, before in self._limits.items():
            if _limit(name) != before:
                with contextlib.suppress(OSError, ValueError):  # only root raises what nobody may exceed
                    resource.setrlimit(getattr(resource, name), before)
        return (*lost,)

    def _put_back_names(self) -> Iterator[str]:
        for kept_name, before in self._names.items():
            kept = _KEPT[kept_name]
            now = kept.__dict__
            for name, value in before.items():
                taken = now.get(name)
                if taken is value or value is None:
                    continue
                # Not what may well be None, as a cache that is emptied.
                is_lost = not _CALLABLE(taken) if _CALLABLE(value) else taken is None and type(value) is _MODULE
                if is_lost:
                    _SETATTR(kept, name, value)
                    yield f"{kept_name}.{name}"

    def _put_back_modules(self) -> Iterator[str]:
        sys.modules = _MODULES
        missing = self._modules.keys() - _MODULES.keys()
        if _MODULES.get("sys") is not sys or _MODULES.get("builtins") is not builtins:
            _MODULES.update(self._modules)
            yield "sys.modules"
            return
        own = [name for name in missing if name.partition(".")[0] in _OWN]
        for name in own:
            _MODULES[name] = self._modules[name]
        if own:
            yield f"sys.modules[{min(own)!r}]"


def _folder() -> str:
    """The current folder; empty where it was removed."""
    try:
        return os.getcwd()
    except OSError:
        return ""


def _limit(name: str) -> tuple[int, int]:
    return resource.getrlimit(getattr(resource, name))


def complaint(names: tuple[str, ...]) -> str:
    """What was put back, in a sentence."""
    shown = ", ".join(names[:5]) + (f" and {len(names) - 5} more" if len(names) > 5 else "")
    return (
        f"the code under test took {shown} away from the whole process, pytest included; after its run this was put "
        "back: let it do so in its own modules only"
    )
