"""Folders of batches: one a plan, whatever the names are."""

from __future__ import annotations

import json
from pathlib import Path

import bpy

# isort: split
from cmc_formfinding.cmc_addon.headless import cli
from cmc_formfinding.cmc_addon.headless.folders import folder_names, input_folders

from .batches import plans, report


def test_a_name_gives_its_folder_whatever_is_beside_it():
    assert folder_names(["Hall", "Café", "Hall 1"]) == {"Hall": "Hall", "Café": "Café", "Hall 1": "Hall 1"}
    alone = folder_names(["Hall/1"])["Hall/1"]
    assert alone == folder_names(["Hall/1", "Hall 1", "Hall:1"])["Hall/1"] and alone.startswith("Hall_1-")


def test_folders_never_clash():
    names = ["Hall/1", "Hall:1", "Hall_1", "hall", "HALL", "Cafe\u0301", "Café", "CON", "a.", "a", ".."]
    names += ["x" * 70, "x" * 71, folder_names(["Hall/1"])["Hall/1"], "report.json", "in.blend", "ß", "ss"]
    folders = folder_names(names, ("report.json", "in.blend"))
    assert len({folder.casefold() for folder in folders.values()}) == len(names)
    assert not {"..", "CON", "report.json", "in.blend"} & set(folders.values())
    assert not any(set(folder) & set('\\/:*?"<>|') or folder.endswith(".") for folder in folders.values())


def test_folders_of_inputs_mirror_theirs_where_names_are_equal():
    a, b, c, d = (Path("/p") / name for name in ("x/hall.blend", "y/hall.blend", "y/hall.obj", "court.blend"))
    assert set(map(str, input_folders([a, d]).values())) == {"hall", "court"}
    assert [str(input_folders([a, b, d])[path]) for path in (a, b, d)] == ["x/hall", "y/hall", "court"]
    assert [str(input_folders([a, b, c])[path]) for path in (a, b, c)] == ["x/hall", "y/hall.blend", "y/hall.obj"]
    x = Path("/p/x.blend")  # its plans would lie where the folder of x/hall.blend does
    assert [str(input_folders([a, b, x])[path]) for path in (a, b, x)] == ["x/hall", "y/hall", "x.blend"]


def test_each_plan_has_its_file(tmp_path):
    names = ("Café", "Cafè", "Hall 1", "Hall-1", "Hall/1", "hall-1")
    assert cli.run([str(plans(tmp_path / "in.blend", *names)), "-o", str(tmp_path / "out"), "-f", "glb"]) == 0
    folders = json.loads((tmp_path / "out/in/plans.json").read_text())["plans"]
    assert list(folders) == sorted(names, key=list(folders).index) and len(set(folders.values())) == len(names)
    for name, folder in folders.items():
        assert report(tmp_path / "out" / "in" / folder)["plan"] == name
        assert (tmp_path / "out" / "in" / folder / "shell.glb").exists()


def test_equal_stems_mirror_the_folder_tree(tmp_path):
    inputs = [str(plans(tmp_path / place / "hall.blend", place)) for place in ("a",)]
    bpy.ops.wm.read_homefile(use_empty=True, use_factory_startup=True)
    inputs.append(str(plans(tmp_path / "b" / "hall.blend", "b")))
    assert cli.run([*inputs, "-o", str(tmp_path / "out"), "-f", "obj"]) == 0
    assert (tmp_path / "out/a/hall/a/shell.obj").exists() and (tmp_path / "out/b/hall/b/shell.obj").exists()
