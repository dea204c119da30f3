"""Counts what the house is measured by: house.py [COMMIT].

Product C++ alone (sim, calibration, scenarios, renders, tools), of the work tree or of a
commit: lines; branches on the kind of the machine outside kinds/; files named after a kind
outside kinds/.
"""

import re
import subprocess
import sys

FOLDERS = ("sim/", "calibration/", "scenarios/", "renders/", "tools/")
KIND = (r"((\.|->)(delta|triple_z|z_station|motor|z_offset)\b(?!\()|IsMotorStage\(|Kinematics::k"
        r"|\b(Delta|TripleZ|ZStation)Kind\(\)|\bOwn<\w+>"
        r"|As<\w+Scenario>)")
BRANCH = re.compile(r"\b(if|case|switch|while|return)\b.*" + KIND + r"|(\?|&&|\|\|).*" + KIND)
NAMED = re.compile(r"(^|_)(delta|triple_z|z_station|z_offset|motor|gantry)(_|\.)|simulated_(stage|station|printer)")
# A cause and dialects that CONTRACT names so.
EXCEPTED = re.compile(r"gantry_sag|motors_swapped|dialects/")


def listed(commit):
    words = ["git", "ls-tree", "-r", "--name-only", commit] if commit else ["git", "ls-files"]
    names = subprocess.run(words, capture_output=True, text=True, check=True).stdout.split("\n")
    return [n for n in names if n.startswith(FOLDERS) and n.endswith((".cc", ".h"))]


def text_of(name, commit):
    if not commit:
        return open(name, encoding="utf-8").read()
    words = ["git", "show", f"{commit}:{name}"]
    return subprocess.run(words, capture_output=True, text=True, check=True).stdout


def main():
    commit = sys.argv[1] if len(sys.argv) > 1 else ""
    names = listed(commit)
    texts = {name: text_of(name, commit) for name in names}
    outside = [name for name in names if "/kinds/" not in name]
    branches = {name: sum(1 for line in texts[name].splitlines() if BRANCH.search(line.split("//")[0]))
                for name in outside}
    named = [n for n in outside if NAMED.search(n.rsplit("/", 1)[1]) and not EXCEPTED.search(n)]
    print(f"lines: {sum(text.count(chr(10)) for text in texts.values())} in {len(names)} files")
    print(f"branches on the kind outside kinds/: {sum(branches.values())} in "
          f"{sum(1 for count in branches.values() if count)} files")
    print(f"files named after a kind outside kinds/: {len(named)}")
    return 0


if __name__ == "__main__":
    sys.exit(main())
