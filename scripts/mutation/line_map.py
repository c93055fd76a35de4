"""A pytest plugin that writes the lines of some files that each test runs: `-p scripts.mutation.line_map`.

CMC_LINES_OF: folders of the checkout, with commas between. CMC_LINES_IN: the JSON file to write, {test: {"seconds": s,
"lines": {file: [line]}}}, of the tests that pass; seconds of processor time, lines of functions only. What a fixture or
a cached function of the checkout has run counts for each test that uses its result, not only for the first (fixtures of
one test run with it).
"""

from __future__ import annotations

import functools
import inspect
import itertools
import json
import os
import sys
import threading
import time
from collections import defaultdict
from pathlib import Path
from types import CodeType, FrameType

import pytest

ROOT = Path(__file__).resolve().parents[2]
Lines = set[tuple[str, int]]


class LineMap:
    def __init__(self, folders: list[str], out: Path) -> None:
        self.folders, self.out = tuple(f"{folder}/" for folder in folders), out
        self.files: dict[CodeType, str | None] = {}
        self.lines: Lines = set()
        self.of_fixture: dict[object, Lines] = defaultdict(set)
        self.tests: dict[str, dict] = {}
        self.passed: set[str] = set()

    def file_of(self, code: CodeType) -> str | None:
        """The file in the checkout, if it is in one of the folders; the code may have come by a link to it."""
        if code not in self.files:
            path = Path(os.path.realpath(code.co_filename))
            name = path.relative_to(ROOT).as_posix() if path.is_relative_to(ROOT) else ""
            of_function = code.co_flags & inspect.CO_OPTIMIZED  # not of a module or a class
            self.files[code] = name if of_function and name.startswith(self.folders) else None
        return self.files[code]

    def trace(self, frame: FrameType, event: str, _: object):
        file = self.file_of(frame.f_code)
        if file is None:
            return None
        self.lines.add((file, frame.f_lineno))

        def local(frame: FrameType, event: str, _: object):
            if event == "line":
                self.lines.add((file, frame.f_lineno))
            return local

        return local

    def recorded(self, call) -> tuple[object, Lines]:
        """The result of a call, and the lines it ran, which count for the test under way, too."""
        before, self.lines = self.lines, set()
        try:
            return call(), self.lines
        finally:
            own, self.lines = self.lines, before
            self.lines |= own

    def cached(self, function):
        """`functools.cache` for functions of the checkout: a result brings along the lines it took."""
        if not os.path.realpath(function.__code__.co_filename).startswith(str(ROOT)):
            return functools.lru_cache(maxsize=None)(function)
        results: dict[tuple, tuple[object, Lines]] = {}

        @functools.wraps(function)
        def call(*args, **kwargs):
            key = (args, tuple(sorted(kwargs.items())))
            if key not in results:
                results[key] = self.recorded(lambda: function(*args, **kwargs))
            self.lines |= results[key][1]
            return results[key][0]

        return call

    @pytest.hookimpl(hookwrapper=True)
    def pytest_runtest_protocol(self, item: pytest.Item):
        self.lines, start = set(), time.process_time()
        threading.settrace(self.trace)
        sys.settrace(self.trace)
        yield
        sys.settrace(None)
        threading.settrace(None)  # type: ignore[arg-type]
        for fixture in itertools.chain(*item._fixtureinfo.name2fixturedefs.values()):  # type: ignore[attr-defined]
            self.lines |= self.of_fixture[fixture]
        found: dict[str, list[int]] = defaultdict(list)
        for file, line in sorted(self.lines):
            found[file].append(line)
        self.tests[item.nodeid] = {"seconds": round(time.process_time() - start, 3), "lines": found}

    @pytest.hookimpl(hookwrapper=True)
    def pytest_fixture_setup(self, fixturedef: pytest.FixtureDef):
        if fixturedef.scope == "function":
            yield
            return
        before, self.lines = self.lines, set()
        yield
        self.of_fixture[fixturedef] |= self.lines
        self.lines |= before

    def pytest_runtest_logreport(self, report: pytest.TestReport) -> None:
        if report.when == "call" and report.passed:
            self.passed.add(report.nodeid)

    def pytest_sessionfinish(self) -> None:
        known = {test: found for test, found in self.tests.items() if test in self.passed}
        self.out.write_text(json.dumps(known))


def pytest_configure(config: pytest.Config) -> None:
    lines = LineMap(os.environ["CMC_LINES_OF"].split(","), Path(os.environ["CMC_LINES_IN"]))
    functools.cache = lines.cached
    config.pluginmanager.register(lines)
