"""The mutants of `make mutation`: each is one small fault in a text that otherwise stays, and what is left alone."""

from __future__ import annotations

from scripts.mutation.mutants import mutants_of

SOURCE = '''"""Not 1 of these words."""

LIMIT: "1 + 2" = 3


def first(values: list[int], most=2.5) -> int:
    """As long as 1 < 2."""
    for value in values:  # no ↔ of a comment
        if not value and value <= LIMIT:
            continue
        values[0] = f"{value + 1}"
        return value * -1
    raise ValueError("none of " + str(most))
'''


def faults(tmp_path) -> dict[int, list[tuple[str, str]]]:
    (tmp_path / "sample.py").write_text(SOURCE)
    found: dict[int, list[tuple[str, str]]] = {}
    for mutant in mutants_of("sample.py", tmp_path):
        found.setdefault(mutant.line, []).append((mutant.old, mutant.new))
    return found


def test_every_fault_by_line(tmp_path):
    assert {line: sorted(pairs) for line, pairs in faults(tmp_path).items()} == {
        3: [("3", "4")],
        6: [("2.5", "5.0")],
        9: [
            ("not value", "(value)"),
            ("not value and value <= LIMIT", "(not value or value <= LIMIT)"),
            ("value <= LIMIT", "(value < LIMIT)"),
            ("value <= LIMIT", "(value > LIMIT)"),
        ],
        10: [("continue", "pass")],
        11: [("0", "1"), ('values[0] = f"{value + 1}"', "pass")],
        12: [("-1", "(1)"), ("1", "2"), ("return value * -1", "return None"), ("value * -1", "(value / -1)")],
        13: [('raise ValueError("none of " + str(most))', "pass")],
    }


def test_a_mutant_differs_in_its_own_place_only_and_knows_what_runs_it(tmp_path):
    (tmp_path / "sample.py").write_text(SOURCE)
    for mutant in mutants_of("sample.py", tmp_path):
        text = mutant.applied(SOURCE.encode()).decode()
        compile(text, "sample.py", "exec")
        start = SOURCE.encode()[: mutant.span[0]].decode()
        assert text.startswith(start) and text.endswith(SOURCE.encode()[mutant.span[1] :].decode())
        assert text[len(start) :].startswith(mutant.new)
        assert mutant.name == ("LIMIT" if mutant.line == 3 else None)
        assert (mutant.lines == (0, 0)) == (mutant.line == 3)
        assert mutant.lines == (6, 13) or mutant.line != 6, "a default serves the whole function"
