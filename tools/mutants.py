"""The planted mistakes of tests/mutants.yaml: mutants.py check | list | plant FOLDER.

check         every entry fits its file: its text stands there exactly once
list          NAME<TAB>FILE of every mistake
plant FOLDER  copies the tree there and turns every entry into a choice at run time:
              CALTWIN_MUTANT=NAME in the environment chooses the mistake of that name

An entry has a name (several may share one: a mistake in several places), a file, the text
that stands there, what is there instead, and, where the text alone stands there more than
once, what stands right behind it to the left. A text that ends in a semicolon is a
statement, any other an expression.
"""

import collections
import pathlib
import re
import subprocess
import sys

import yaml

ROOT = pathlib.Path(__file__).resolve().parent.parent
ENTRIES = ROOT / "tests/mutants.yaml"
KEYS = {"name", "file", "behind", "text", "instead"}
TOKEN = re.compile(r'"(?:\\.|[^"\\])*"|\w+|[^\s\w]')
SPACE_OR_COMMENT = r"(?:\s|//[^\n]*\n)*"
CHOICE_HEADER = """#pragma once

#include <cstdlib>
#include <string_view>
#include <type_traits>

namespace caltwin {

inline bool IsMutant(std::string_view name) {
  static const char* const chosen = std::getenv("CALTWIN_MUTANT");
  return chosen != nullptr && name == chosen;
}

template <typename T>
T Mutant(std::string_view name, T good, T bad) {
  return IsMutant(name) ? bad : good;
}
/// A whole number in place of one with a fraction, or the other way round.
template <typename A, typename B>
std::common_type_t<A, B> Mutant(std::string_view name, A good, B bad) {
  if (IsMutant(name)) return static_cast<std::common_type_t<A, B>>(bad);
  return static_cast<std::common_type_t<A, B>>(good);
}

}  // namespace caltwin
"""
Place = collections.namedtuple("Place", "start end entry")


def pattern_of(text):
    """Matches the text whatever white space, and remarks, stand between its words."""
    return SPACE_OR_COMMENT.join(re.escape(token) for token in TOKEN.findall(text))


def find(entry, source):
    """Where the text of an entry stands; all places where its pattern matches."""
    behind, text = entry.get("behind", ""), entry["text"]
    start = r"(?<!\w)" if re.match(r"\w", behind or text) else ""
    end = r"(?!\w)" if re.search(r"\w$", text) else ""
    before = pattern_of(behind) + SPACE_OR_COMMENT if behind else ""
    return [Place(m.start(1), m.end(1), entry)
            for m in re.finditer(f"{start}{before}({pattern_of(text)}){end}", source)]


def read_entries():
    entries = yaml.safe_load(ENTRIES.read_text())["mutants"]
    for entry in entries:
        if not {"name", "file", "text", "instead"} <= entry.keys() <= KEYS:
            sys.exit(f"{ENTRIES}: {entry}: an entry has name, file, text, instead, perhaps behind")
    return entries


def faults_of(entries):
    for entry in entries:
        file = ROOT / entry["file"]
        if not file.exists():
            yield f"{entry['name']}: there is no {entry['file']}"
            continue
        found = len(find(entry, file.read_text()))
        if found != 1:
            where = f"{entry.get('behind', '')} [{entry['text']}]".strip()
            yield f"{entry['name']}: {entry['file']}: stands {found} times, not once: {where}"


def choice(entry, text):
    name, instead = entry["name"], entry["instead"]
    if entry["text"].endswith(";"):
        return f'if (IsMutant("{name}")) {{ {instead} }} else {{ {text} }}'
    if instead.endswith(f" * {entry['text']}") and "*" not in instead[:-len(entry["text"]) - 3]:
        return f'Mutant("{name}", 1.0, {instead[:-len(entry["text"]) - 3]}) * {text}'
    return f'Mutant("{name}", {text}, {instead})'


def planted(source, entries):
    """The source with every entry as a choice; of several at one place one in the other."""
    by_span = collections.defaultdict(list)
    for entry in entries:
        (place,) = find(entry, source)
        by_span[place.start, place.end].append(entry)
    for (start, end), here in sorted(by_span.items(), reverse=True):
        text = source[start:end]
        for entry in here:
            text = choice(entry, text)
        source = source[:start] + text + source[end:]
    return '#include "sim/base/mutant.h"\n' + source


def write_changed(path, text):
    """Writes only what differs, so that a build made before is of use."""
    if not path.exists() or path.read_bytes() != text:
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_bytes(text)


def plant(folder, entries):
    by_file = collections.defaultdict(list)
    for entry in entries:
        by_file[entry["file"]].append(entry)
    listed = subprocess.run(["git", "ls-files", "-z", "--cached", "--others", "--exclude-standard"],
                            cwd=ROOT, capture_output=True, text=True, check=True).stdout
    for name in filter(None, listed.split("\0")):
        if not (ROOT / name).is_file():
            continue
        text = (ROOT / name).read_bytes()
        if name in by_file:
            text = planted(text.decode(), by_file[name]).encode()
        write_changed(folder / name, text)
        (folder / name).chmod((ROOT / name).stat().st_mode)  # Scripts are run there.
    write_changed(folder / "sim/base/mutant.h", CHOICE_HEADER.encode())


def main():
    entries = read_entries()
    what = sys.argv[1] if len(sys.argv) > 1 else ""
    faults = list(faults_of(entries))
    if faults:
        print("\n".join(faults), file=sys.stderr)
        return 1
    if what == "check":
        print(f"{len(entries)} entries of {len({e['name'] for e in entries})} mutants fit their files")
    elif what == "list":
        print("\n".join(f"{name}\t{file}" for name, file in {e["name"]: e["file"] for e in entries}.items()))
    elif what == "plant" and len(sys.argv) == 3:
        plant(pathlib.Path(sys.argv[2]), entries)
    else:
        print(__doc__, file=sys.stderr)
        return 2
    return 0


if __name__ == "__main__":
    sys.exit(main())
