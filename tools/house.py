"""Counts what the house is measured by: house.py [COMMIT].

Product C++ alone (sim, calibration, scenarios, renders, tools), of the work tree or of a
commit: lines; branches on the kind of the machine outside kinds/, and each other place there
that knows a kind (its name, what only it draws); files named after a kind outside kinds/.
tests/layers_test.py allows no branch, no such file, and of the places those it lists.
"""

import re
import subprocess
import sys

FOLDERS = ("sim/", "calibration/", "scenarios/", "renders/", "tools/")
KIND = (r"((\.|->)(delta|triple_z|z_station|motor|z_offset)\b(?!\()|IsMotorStage\(|Kinematics::k"
        r"|\b(Delta|TripleZ|ZStation)Kind\(\)|\bOwn<\w+>"
        r"|As<\w+Scenario>)")
BRANCH = re.compile(r"\b(if|case|switch|while|return)\b.*" + KIND + r"|(\?|&&|\|\|).*" + KIND)
# Beside branches: a comparison with a kind, what only one kind draws, a kind by its name.
KNOWS = re.compile(r"[=!]= *(Cartesian|Delta|TripleZ|ZStation|MotorStage|CoreXy)Kind\(\)"
                   r"|\b(Delta|TripleZ|ZStation|MotorStage|CoreXy)Kind\(\)|\bOwn<\w+>"
                   r"|kind(->|\.|\(\)->)name\(\) *[=!]= *\"|ProceduresOf\(\"[a-z]")
NAMED = re.compile(r"(^|_)(delta|triple_z|z_station|z_offset|motor|gantry)(_|\.)|simulated_(stage|station|printer)")
# Causes that CONTRACT names so.
EXCEPTED = re.compile(r"gantry_sag|motors_swapped")


def listed(commit):
    words = ["git", "ls-tree", "-r", "--name-only", commit] if commit else ["git", "ls-files"]
    names = subprocess.run(words, capture_output=True, text=True, check=True).stdout.split("\n")
    return [n for n in names if n.startswith(FOLDERS) and n.endswith((".cc", ".h"))]


def text_of(name, commit):
    if not commit:
        return open(name, encoding="utf-8").read()
    words = ["git", "show", f"{commit}:{name}"]
    return subprocess.run(words, capture_output=True, text=True, check=True).stdout


def places(names, text):
    """PATH:LINE of each place outside kinds/ that branches on a kind or knows one."""
    branches, knowing = [], []
    for name in names:
        if "/kinds/" in name:
            continue
        for number, line in enumerate(text(name).splitlines(), 1):
            code = line.split("//")[0]
            if BRANCH.search(code):
                branches.append(f"{name}:{number}")
            elif KNOWS.search(code):
                knowing.append(f"{name}:{number}")
    return branches, knowing


def named_after_a_kind(names):
    return [n for n in names
            if "/kinds/" not in n and NAMED.search(n.rsplit("/", 1)[1]) and not EXCEPTED.search(n)]


def main():
    if len(sys.argv) > 1 and sys.argv[1].startswith("-"):
        print(__doc__)
        return 0 if sys.argv[1] in ("-h", "--help") else 2
    commit = sys.argv[1] if len(sys.argv) > 1 else ""
    names = listed(commit)
    texts = {name: text_of(name, commit) for name in names}
    branches, knowing = places(names, texts.get)
    named = named_after_a_kind(names)
    print(f"lines: {sum(text.count(chr(10)) for text in texts.values())} in {len(names)} files")
    print(f"branches on the kind outside kinds/: {len(branches)}", *branches, sep="\n  ")
    print(f"other places outside kinds/ that know a kind: {len(knowing)}", *knowing, sep="\n  ")
    print(f"files named after a kind outside kinds/: {len(named)}", *named, sep="\n  ")
    return 0


if __name__ == "__main__":
    sys.exit(main())
