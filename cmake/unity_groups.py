#!/usr/bin/env python3
"""Which sources can be compiled as one: unity_groups.py ROOT LINES SOURCE...

Prints "SOURCE;GROUP" lines. Sources of a group are put one behind another, which compiles
in a third of the time: most of it is reading the same headers and making the same templates
anew. Names in an unnamed namespace then meet, so two sources share a group only where
neither says a name that is unnamed in the other, nor includes a header of ROOT that declares
one. A group ends at so many LINES, so that there is work for every core. What is overlooked
here, as a name that is added later, is an error of the compiler: configure again.
"""

import functools
import pathlib
import re
import sys

# Not a member's name: behind a dot or an arrow.
WORD = re.compile(r"(?<![\w.>])[A-Za-z_]\w*")
INCLUDE = re.compile(r'^#include "([^"]+)"', re.MULTILINE)
COMMENT_OR_STRING = re.compile(r'//[^\n]*|"(?:\\.|[^"\\\n])*"')
# As clang-format leaves it: what is declared in a namespace begins a line.
UNNAMED = re.compile(r"^namespace \{$(.*?)^\}  // namespace$", re.MULTILINE | re.DOTALL)
TYPE = re.compile(r"^(?:template <.*> )?(?:class|struct|union|enum(?: class)?) (\w+)")
DECLARED = re.compile(r"(\w+) *(?:\(|\{|=|;|\[)")
TAKEN_FROM = re.compile(r"^using ((?:\w*::)+\w+);$", re.MULTILINE)
NO_NAMES = {"TEST", "TEST_F", "TEST_P", "INSTANTIATE_TEST_SUITE_P"}


@functools.cache
def text_of(path):
    return COMMENT_OR_STRING.sub("", path.read_text())


@functools.cache
def words_of(path):
    return frozenset(WORD.findall(text_of(path)))


def declared_in(text):
    """What lines that begin at the margin declare."""
    names, declaration = set(), ""
    for line in COMMENT_OR_STRING.sub("", text).splitlines():
        is_begun = line[:1] not in ("", " ", "}", "#", ")")
        if line.startswith("namespace ") or TAKEN_FROM.match(line):
            continue
        if not is_begun and not declaration:
            continue
        declaration = line if is_begun else f"{declaration} {line.strip()}"
        found = TYPE.match(declaration) or DECLARED.search(declaration)
        if found:
            if found[1] not in NO_NAMES:
                names.add(found[1])
            declaration = ""
    return names


def unnamed_in(path):
    """Names that the source keeps to itself."""
    return set().union(*map(declared_in, UNNAMED.findall(path.read_text())))


@functools.cache
def offered_by(header):
    return frozenset(declared_in(header.read_text()))


@functools.cache
def headers_of(root, path):
    """All headers of the project that a file includes, whichever way."""
    found, left = set(), [path]
    while left:
        for name in INCLUDE.findall(left.pop().read_text()):
            header = root / name
            if header not in found and header.is_file():
                found.add(header)
                left.append(header)
    return found


def said_in(root, path):
    """All words of a source, and what the headers that it includes declare."""
    return words_of(path).union(*map(offered_by, headers_of(root, path)))


class Group:
    """Sources one behind another, or a single one."""

    def __init__(self, root, source):
        self.sources = [source]
        self.lines = source.read_text().count("\n")
        self.unnamed, self.said = unnamed_in(source), said_in(root, source)
        # What `using` takes from elsewhere, and what is said by who has not taken it.
        taken = TAKEN_FROM.findall(source.read_text())
        self.taken = {name.rpartition("::")[2] for name in taken}
        self.not_taken = self.said - self.taken

    def takes(self, other, most):
        return self.lines + other.lines <= most and not (
            self.unnamed & other.said or self.said & other.unnamed or
            self.taken & other.not_taken or self.not_taken & other.taken)

    def add(self, other):
        self.sources += other.sources
        self.lines += other.lines
        self.unnamed |= other.unnamed
        self.said |= other.said
        self.taken |= other.taken
        self.not_taken |= other.not_taken


def groups_of(root, most, sources):
    groups = []
    for source in sources:
        alone = Group(root, source)
        group = next((one for one in groups if one.takes(alone, most)), None)
        if group:
            group.add(alone)
        else:
            groups.append(alone)
    return groups


def main():
    root, most = pathlib.Path(sys.argv[1]), int(sys.argv[2])
    for index, group in enumerate(groups_of(root, most, map(pathlib.Path, sorted(sys.argv[3:])))):
        for source in group.sources:
            print(f"{source};{index}")


if __name__ == "__main__":
    main()
