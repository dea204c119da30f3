"""Checks every #include against the layers of CMakeLists.txt.

A layer includes itself and the layers it names in USES, and what those use in turn
where a header of theirs needs it: CMake passes that on, so it is what compiles, and the
architecture allows it. The longest folder wins: sim/effects/acts is a layer of its own
inside sim/effects. Beside that, MuJoCo's headers stand only where metres are allowed, and
the blind tests' truth code includes nothing of any layer: it would test itself. No two
headers define a type of the same name: such programs link, and then do anything. And nothing
outside kinds/ branches on a machine's kind or is named after one (tools/house.py counts).

    layers_test.py ROOT          checks a tree
    layers_test.py --self-test   checks that a leak would be found
"""

import re
import sys
import tempfile
from pathlib import Path

sys.path.insert(0, str(Path(__file__).parent.parent / "tools"))
import house  # noqa: E402  (stands beside what it counts)

SOURCE_FOLDERS = ("sim", "calibration", "scenarios", "renders", "tools", "tests")
MUJOCO_FOLDERS = ("sim/mjcf", "sim/physics", "renders", "tests/bench")
# Of a kind of machine: its model and its world.
MUJOCO_FILES = re.compile(r"sim/kinds/\w+/(mjcf|world)\.(h|cc)")
BLIND_FOLDER = "tests/blind/"
LAYER = re.compile(r"^caltwin_layer\((\w+)\s+DIR\s+(\S+)([^)]*)\)", re.MULTILINE)
TYPE = re.compile(r"^(?:class|struct|enum class) (\w+)(?: final)?(?: :[^;]*)? *\{", re.MULTILINE)
NAMESPACE = re.compile(r"^namespace (\w+) *\{", re.MULTILINE)
INCLUDE = re.compile(r'^\s*#\s*include\s*(["<])([^">]+)[">]')


def read_layers(cmake_text):
    """{folder: (name, used)} where `used` holds the layer itself and all below it."""
    folders, uses = {}, {}
    for name, folder, rest in LAYER.findall(cmake_text):
        words = rest.split()
        used = []
        if "USES" in words:
            for word in words[words.index("USES") + 1 :]:
                if word == "NEEDS":
                    break
                used.append(word)
        folders[folder] = name
        uses[name] = used

    def closure(name, seen):
        for used in uses[name]:
            if used not in seen:
                seen.add(used)
                closure(used, seen)
        return seen

    return {folder: (name, closure(name, {name})) for folder, name in folders.items()}


def folder_of(path, layers):
    """The layer folder that holds `path`; the longest wins. None if there is none."""
    inside = [folder for folder in layers if path.startswith(folder + "/")]
    return max(inside, key=len, default=None)


def faults_of(path, text, layers):
    folder = folder_of(path, layers)
    for number, line in enumerate(text.splitlines(), start=1):
        match = INCLUDE.match(line)
        if not match:
            continue
        included = match.group(2)
        if included.startswith("mujoco/"):
            if not path.startswith(tuple(f + "/" for f in MUJOCO_FOLDERS)) and not (
                MUJOCO_FILES.fullmatch(path)
            ):
                yield f"{path}:{number}: includes {included}, allowed only in " + ", ".join(
                    MUJOCO_FOLDERS
                )
            continue
        target = folder_of(included, layers)
        if path.startswith(BLIND_FOLDER) and target is not None:
            yield f"{path}:{number}: includes {included}, but blind truth shares nothing"
            continue
        if folder is None or target is None:
            continue
        name, used = layers[folder]
        if layers[target][0] not in used:
            yield (
                f"{path}:{number}: includes {included}, but the layer '{name}' does not "
                f"use the layer '{layers[target][0]}' (see CMakeLists.txt)"
            )


def linked_faults(root):
    """The blind tests link no library of a layer either."""
    for file in sorted((root / BLIND_FOLDER).glob("CMakeLists.txt")):
        for number, line in enumerate(file.read_text().splitlines(), start=1):
            if re.search(r"\bcaltwin_\w", line.split("#")[0]):
                yield f"{BLIND_FOLDER}{file.name}:{number}: links a layer, but blind truth shares nothing"


def types_of(text):
    """Types that a header defines at the top level of its namespace, qualified."""
    namespace = "::".join(NAMESPACE.findall(text))
    return [f"{namespace}::{name}" for name in TYPE.findall(text)]


def doubled_types(headers):
    """Two types of one name in one namespace: the linker keeps the functions of one."""
    first, faults = {}, []
    for path, text in headers:
        for name in types_of(text):
            other = first.setdefault(name, path)
            if other != path:
                faults.append(f"{path}: {name} is a type of {other} too")
    return faults


def kind_faults(root):
    """Nothing outside kinds/ branches on a machine's kind or is named after one."""
    names = [
        file.relative_to(root).as_posix()
        for folder in house.FOLDERS
        for file in sorted((root / folder).rglob("*"))
        if file.suffix in (".h", ".cc")
    ]
    branches, knowing = house.places(names, lambda name: (root / name).read_text())
    faults = [f"{place}: branches on the kind of the machine outside kinds/" for place in branches]
    faults += [f"{place}: knows a kind of machine outside kinds/" for place in knowing]
    return faults + [
        f"{name}:1: named after a kind of machine outside kinds/"
        for name in house.named_after_a_kind(names)
    ]


def check(root):
    layers = read_layers((root / "CMakeLists.txt").read_text())
    if len(layers) < 3:
        return ["CMakeLists.txt: no table of layers was found"]
    faults, files = list(linked_faults(root)), 0
    for folder in SOURCE_FOLDERS:
        for file in sorted((root / folder).rglob("*")):
            if file.suffix in (".h", ".cc"):
                files += 1
                path = file.relative_to(root).as_posix()
                faults += faults_of(path, file.read_text(), layers)
    headers = [
        (file.relative_to(root).as_posix(), file.read_text())
        for folder in SOURCE_FOLDERS
        for file in sorted((root / folder).rglob("*.h"))
    ]
    faults += doubled_types(headers) + kind_faults(root)
    if files == 0:
        faults.append(f"{root}: no source was found")
    return faults


SELF_TEST = {
    "sim/base/a.h": ("", 0),
    "sim/base/b.cc": ('#include "sim/top/t.h"\n', 1),
    "sim/top/c.cc": ('#include "sim/base/a.h"\n#include <mujoco/mujoco.h>\n', 1),
    "sim/top/deep/d.cc": ('#include "sim/top/t.h"\n  #  include "sim/base/a.h"\n', 1),
    "sim/other/e.cc": ('#include "sim/base/a.h"\n// #include "sim/top/t.h"\n', 0),
    "sim/mjcf/f.cc": ("#include <mujoco/mujoco.h>\n#include <vector>\n", 0),
    "sim/top/w.h": ("namespace n {\nstruct Word {\n};\n}\n", 0),
    "sim/top/x.h": ("namespace n {\nenum class Word { kA };\nclass Other;\n}\n", 1),
    "sim/top/y.h": ("namespace m {\nstruct Word {\n};\nstruct Other {\n};\n}\n", 0),
    "sim/top/k.cc": ("if (machine.kind == DeltaKind()) return;\n", 1),
    "sim/top/l.cc": ("const bool is_delta = kind == DeltaKind();\n", 1),
    "sim/top/kinds/m.cc": ("if (machine.kind == DeltaKind()) return;\n", 0),
    "sim/top/delta_words.h": ("", 1),
    "tests/blind/g.cc": ('#include "tests/blind/h.h"\n#include "sim/base/a.h"\n', 1),
    "tests/blind/CMakeLists.txt": ("# of caltwin_base\ntarget_link(g caltwin_base)\n", 1),
}
SELF_TEST_CMAKE = """
caltwin_layer(base DIR sim/base NEEDS fmt)
caltwin_layer(top DIR sim/top USES other NEEDS mujoco::mujoco)
caltwin_layer(other DIR sim/other USES base)
caltwin_layer(deep DIR sim/top/deep USES base)
caltwin_layer(mjcf DIR sim/mjcf USES base)
"""


def self_test():
    with tempfile.TemporaryDirectory() as folder:
        root = Path(folder)
        (root / "CMakeLists.txt").write_text(SELF_TEST_CMAKE)
        for path, (text, _) in SELF_TEST.items():
            (root / path).parent.mkdir(parents=True, exist_ok=True)
            (root / path).write_text(text)
        faults = check(root)
    wrong = []
    for path, (_, expected) in SELF_TEST.items():
        found = [fault for fault in faults if fault.startswith(path + ":")]
        if len(found) != expected:
            wrong.append(f"self-test: {path}: expected {expected} faults, got {found}")
    return wrong


def main():
    faults = self_test() if sys.argv[1] == "--self-test" else check(Path(sys.argv[1]))
    print("\n".join(faults) if faults else "every #include keeps to its layer")
    return 1 if faults else 0


if __name__ == "__main__":
    sys.exit(main())
